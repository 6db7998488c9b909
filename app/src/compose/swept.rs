//! The space that bodies sweep: voxels that their surfaces pass, blurred and wrapped in one smooth skin.
//!
//! The skin lies up to one voxel outside the bodies: it is a picture, not a proof of free space.

use std::collections::{BTreeMap, BTreeSet};

use endcomfort_core::mesh::Mesh;
use nalgebra::{Isometry3, Point3, Vector3};

/// Edge of a voxel, metres: finer than a finger is thick.
pub(super) const VOXEL_M: f64 = 0.014;
/// Share of a voxel's neighbourhood that is filled where the skin lies: a sheet of one voxel fills a third.
const SKIN: f32 = 0.2;
/// Most voxels: beyond that (a robot the size of a crane) there is no skin.
const MOST_VOXELS: usize = 8_000_000;

/// Points on a mesh, about a voxel apart, each in a cell of its own.
pub(super) fn surface_points(mesh: &Mesh, X_LM: &Isometry3<f64>) -> Vec<Point3<f64>> {
    let mut cells = BTreeSet::new();
    let mut points = Vec::new();
    for triangle in &mesh.triangles {
        let [Some(a), Some(b), Some(c)] = triangle.map(|i| mesh.positions.get(i as usize)) else { continue };
        let longest_m = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        // Not more than 64 a side: a table-sized triangle belongs to no link.
        let steps = ((longest_m / VOXEL_M).ceil().max(1.0) as u32).min(64);
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (u, v) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
                let point = X_LM * (a + u * (b - a) + v * (c - a));
                let cell = point.coords.map(|x| (x / (0.8 * VOXEL_M)).floor() as i32);
                if cells.insert([cell.x, cell.y, cell.z]) {
                    points.push(point);
                }
            }
        }
    }
    points
}

/// Voxels over a box of the world.
struct Grid {
    origin: Point3<f64>,
    size: [usize; 3],
    values: Vec<f32>,
}

impl Grid {
    /// All empty, around a box; `None` if that takes too many.
    fn around(low: &Point3<f64>, high: &Point3<f64>) -> Option<Self> {
        const MARGIN: f64 = 3.0 * VOXEL_M;
        let size = (high - low).map(|extent| ((extent + 2.0 * MARGIN) / VOXEL_M).ceil() + 1.0);
        let fits = size.iter().all(|s| s.is_finite() && *s < 1000.0) && size.product() < MOST_VOXELS as f64;
        let size = [size.x as usize, size.y as usize, size.z as usize];
        fits.then(|| Self { origin: low - Vector3::repeat(MARGIN), size, values: vec![0.0; size.iter().product()] })
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    fn fill(&mut self, p_W: &Point3<f64>) {
        let cell = (p_W - self.origin).map(|x| (x / VOXEL_M).round());
        let inside = (0..3).all(|axis| cell[axis] >= 0.0 && cell[axis] < self.size[axis] as f64);
        if inside {
            let index = self.index([cell.x as usize, cell.y as usize, cell.z as usize]);
            self.values[index] = 1.0;
        }
    }

    /// Mean over three voxels along each axis in turn.
    fn blur(&mut self) {
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        for stride in strides {
            let before = self.values.clone();
            let last = before.len() - stride;
            for index in stride..last {
                self.values[index] = (before[index - stride] + before[index] + before[index + stride]) / 3.0;
            }
        }
    }
}

/// The skin around everything that points sweep: `clouds` in their own frames, `poses` of each frame in the world.
pub(super) fn skin(clouds: &[Vec<Point3<f64>>], poses: &[Vec<Isometry3<f64>>]) -> Option<Mesh> {
    let everywhere = || {
        clouds
            .iter()
            .zip(poses)
            .flat_map(|(cloud, poses)| poses.iter().flat_map(move |X_WL| cloud.iter().map(move |p_L| X_WL * p_L)))
    };
    let start = (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3]));
    let (low, high) = everywhere().fold(start, |(low, high), p| (low.inf(&p), high.sup(&p)));
    let mut grid = Grid::around(&low, &high)?;
    everywhere().for_each(|p_W| grid.fill(&p_W));
    grid.blur();
    Some(surface_nets(&grid))
}

/// The surface on which a grid's values are [`SKIN`]: one vertex per cube of voxels that it passes, at the mean of
/// where it cuts the cube's edges (naive surface nets, Gibson 1998).
fn surface_nets(grid: &Grid) -> Mesh {
    let [nx, ny, nz] = grid.size;
    let strides = [1, nx, nx * ny];
    let mut mesh = Mesh::default();
    let mut vertex_of: BTreeMap<usize, u32> = BTreeMap::new();
    let corner = |c: usize| [c & 1, c >> 1 & 1, c >> 2 & 1];
    for k in 0..nz - 1 {
        for j in 0..ny - 1 {
            for i in 0..nx - 1 {
                let index = grid.index([i, j, k]);
                let value = |c: usize| {
                    let [x, y, z] = corner(c);
                    grid.values[index + x + y * strides[1] + z * strides[2]] - SKIN
                };
                let inside = (0..8).filter(|&c| value(c) > 0.0).count();
                if inside == 0 || inside == 8 {
                    continue;
                }
                let (mut sum, mut cuts) = (Vector3::zeros(), 0.0);
                for from in 0..8_usize {
                    for axis in 0..3 {
                        let to = from | 1 << axis;
                        if to == from || (value(from) > 0.0) == (value(to) > 0.0) {
                            continue;
                        }
                        let mut at = Vector3::from(corner(from).map(|x| x as f64));
                        at[axis] += f64::from(value(from) / (value(from) - value(to)));
                        sum += at;
                        cuts += 1.0;
                    }
                }
                let at = Vector3::new(i as f64, j as f64, k as f64) + sum / cuts;
                vertex_of.insert(index, mesh.positions.len() as u32);
                mesh.positions.push(grid.origin + VOXEL_M * at);
            }
        }
    }
    for &index in vertex_of.keys() {
        let is_inside = grid.values[index] > SKIN;
        for axis in 0..3 {
            // The edge from this voxel along an axis is shared by four cubes.
            let (u, v) = (strides[(axis + 1) % 3], strides[(axis + 2) % 3]);
            if is_inside == (grid.values[index + strides[axis]] > SKIN) || index < u + v {
                continue;
            }
            let cubes = [index, index - u, index - u - v, index - v].map(|cube| vertex_of.get(&cube).copied());
            let [Some(a), Some(b), Some(c), Some(d)] = cubes else { continue };
            let [a, b, c, d] = if is_inside { [a, b, c, d] } else { [d, c, b, a] };
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::shapes;

    #[test]
    fn a_ball_that_is_pushed_along_sweeps_a_capsule_of_its_radius() {
        let (radius_m, way_m) = (0.08, 0.4);
        let ball = surface_points(&shapes::sphere(radius_m), &Isometry3::identity());
        let poses = (0..=40).map(|k| Isometry3::translation(0.01 * f64::from(k), 0.0, 0.0)).collect();
        let mesh = skin(&[ball], &[poses]).unwrap();
        let from_axis = |p: &Point3<f64>| (p - Point3::new(p.x.max(0.0).min(way_m), 0.0, 0.0)).norm();
        // The outer skin; an inner one wraps the hollow that no surface has passed.
        let outer: Vec<&Point3<f64>> = mesh.positions.iter().filter(|p| from_axis(p) > radius_m - VOXEL_M).collect();
        assert!(outer.len() > 500);
        for p in outer {
            assert!((from_axis(p) - radius_m).abs() < 1.6 * VOXEL_M, "{p} lies {} from the axis", from_axis(p));
        }
        let ends = mesh.positions.iter().fold((0.0_f64, 0.0_f64), |(low, high), p| (low.min(p.x), high.max(p.x)));
        assert!((ends.0 + radius_m).abs() < 1.6 * VOXEL_M && (ends.1 - way_m - radius_m).abs() < 1.6 * VOXEL_M);
    }

    #[test]
    fn triangles_of_the_skin_face_outward() {
        let ball = surface_points(&shapes::sphere(0.06), &Isometry3::identity());
        let mesh = skin(&[ball], &[vec![Isometry3::identity()]]).unwrap();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let normal = (b - a).cross(&(c - a));
            let middle = (a.coords + b.coords + c.coords) / 3.0;
            // The outer skin alone: the inner one faces the other way.
            if middle.norm() > 0.06 {
                assert!(normal.dot(&middle) > 0.0, "a triangle at {middle:?} faces inward");
            }
        }
    }
}
