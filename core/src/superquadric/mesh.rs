//! A closed triangle mesh of the surface.

use nalgebra::{Isometry3, Point3, Vector3};

use super::Superquadric;
use super::superellipse::{QuarterArc, unfold};
use crate::mesh::Mesh;

impl Superquadric {
    /// A closed mesh in the axes S with `8 · half` columns and `4 · half` rows; `half` is at least 2, 8 looks smooth.
    ///
    /// Rows and columns follow the uniform superellipse steps, denser where the curves bend and with one exactly on
    /// each rounded edge, so that boxes and cylinders keep their silhouettes. Vertices are shared, normals exact.
    pub fn mesh_in_axes(&self, half: u32) -> Mesh {
        let half = half.max(2) as usize;
        let quarter = QuarterArc::new(self.a, self.b, self.e2).silhouette_steps(half);
        let columns = unfold(&quarter);
        let profile = QuarterArc::new((self.a * self.b).sqrt(), self.c, self.e1).silhouette_steps(half);
        // Rings from the equator to the north without the pole, which is (0, 1) of the profile.
        let north = &profile[..profile.len() - 1];
        let base = |[ring, height]: [f64; 2], [u, v]: [f64; 2]| {
            Point3::new(self.a * ring * u, self.b * ring * v, self.c * height)
        };
        let mut mesh = Mesh::default();
        for z in [self.c, -self.c] {
            let pole = Point3::new(0.0, 0.0, z);
            self.push(&mut mesh, pole, &self.base_gauge(&pole).gradient());
        }
        // The base shape is its own mirror image in all three planes: an eighth of its gradients is computed.
        let last = quarter.len() - 1;
        let gradients: Vec<Vec<Vector3<f64>>> = (north.iter())
            .map(|ring| quarter.iter().map(|column| self.base_gauge(&base(*ring, *column)).gradient()).collect())
            .collect();
        let rings: Vec<(usize, f64)> =
            (1..north.len()).rev().map(|ring| (ring, 1.0)).chain((0..north.len()).map(|ring| (ring, -1.0))).collect();
        for (ring, side) in &rings {
            let [radius, height] = north[*ring];
            for (index, column) in columns.iter().enumerate() {
                let within = index % (2 * last);
                let gradient = gradients[*ring][within.min(2 * last - within)];
                let mirrored = Vector3::new(
                    gradient.x.abs().copysign(column[0]),
                    gradient.y.abs().copysign(column[1]),
                    gradient.z * side,
                );
                self.push(&mut mesh, base([radius, side * height], *column), &mirrored);
            }
        }
        let width = columns.len();
        let vertex = |ring: usize, column: usize| (2 + ring * width + column % width) as u32;
        let south = rings.len() - 1;
        for column in 0..width {
            mesh.triangles.push([0, vertex(0, column), vertex(0, column + 1)]);
            mesh.triangles.push([1, vertex(south, column + 1), vertex(south, column)]);
            for ring in 0..south {
                let [upper, upper_next] = [vertex(ring, column), vertex(ring, column + 1)];
                let [lower, lower_next] = [vertex(ring + 1, column), vertex(ring + 1, column + 1)];
                mesh.triangles.push([upper, lower, lower_next]);
                mesh.triangles.push([upper, lower_next, upper_next]);
            }
        }
        mesh
    }

    /// [`Superquadric::mesh_in_axes`] moved into F.
    pub fn mesh(&self, half: u32) -> Mesh {
        let X_FS: &Isometry3<f64> = &self.X_FS;
        self.mesh_in_axes(half).transformed(X_FS)
    }

    /// Adds a point of the base shape with the gradient of its gauge there, deformed as the shape is.
    fn push(&self, mesh: &mut Mesh, p_0: Point3<f64>, gradient: &Vector3<f64>) {
        mesh.positions.push(self.from_base(&p_0));
        let n_S = self.gradient_from_base(&p_0, gradient);
        let norm = n_S.norm_squared().sqrt();
        mesh.normals.push(if norm > 0.0 { n_S / norm } else { Vector3::z() });
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Volume enclosed by a closed mesh: tetrahedra from the origin.
    fn enclosed(mesh: &Mesh) -> f64 {
        mesh.triangles
            .iter()
            .map(|t| {
                let [p, q, r] = t.map(|i| mesh.positions[i as usize].coords);
                p.dot(&q.cross(&r)) / 6.0
            })
            .sum()
    }

    #[test]
    fn meshes_are_closed_outward_and_enclose_the_volume() {
        for (e1, e2) in [(0.1, 0.1), (0.1, 1.0), (1.0, 1.0), (0.3, 1.9), (1.9, 1.9), (1.9, 0.1)] {
            let at = Isometry3::translation(0.3, -0.2, 0.5);
            let plain = Superquadric::new(0.03, 0.06, 0.12, e1, e2, at).unwrap();
            let own = plain.mesh_in_axes(8);
            for (p, n) in own.positions.iter().zip(&own.normals) {
                assert!(
                    (plain.ln_gradient(p).try_normalize(0.0).unwrap() - n).norm() < 1e-9,
                    "{n} at {p} of {plain:?}"
                );
            }
            for s in [plain, plain.deformed(0.7, 0.0).unwrap(), plain.deformed(-0.3, 7.0).unwrap()] {
                let mesh = s.mesh(8);
                let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
                for t in &mesh.triangles {
                    for (from, to) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                        assert_ne!(from, to);
                        *edges.entry((from, to)).or_default() += 1;
                    }
                }
                // Closed and oriented: every edge once in each direction.
                assert!(edges.iter().all(|((from, to), n)| *n == 1 && edges.get(&(*to, *from)) == Some(&1)));
                // Chords of 64 columns and 32 rows lose 0.5 % of a sphere, less of a box.
                let ratio = enclosed(&mesh) / s.volume();
                assert!(ratio > 0.97 && ratio <= 1.0 + 1e-9, "{ratio} {s:?}");
                for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
                    assert!(s.ln_inside_outside(&s.to_axes(p)).abs() < 1e-8, "{s:?}");
                    assert!((n.norm() - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_box_keeps_its_corners() {
        let s = Superquadric::new(0.05, 0.05, 0.1, 0.1, 0.1, Isometry3::identity()).unwrap();
        let mesh = s.mesh_in_axes(4);
        let farthest = mesh.positions.iter().map(|p| p.x + p.y).max_by(f64::total_cmp).unwrap();
        assert!((farthest - s.support(&Vector3::new(1.0, 1.0, 0.0))).abs() < 1e-9);
    }
}
