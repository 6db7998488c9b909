//! A body as convex pieces: what collision checks, which know only convex hulls, stand on.

use nalgebra::Point3;

use super::Superquadric;
use super::superellipse::{QuarterArc, unfold};
use crate::math;

/// A piece of a bent body turns by at most this angle, radians: its hull fills a hollow of angle²/8 radii, 1.5 %.
const PIECE_TURN_RAD: f64 = 0.35;

impl Superquadric {
    /// Points in the axes S whose convex hulls together are the body, to the fineness of a mesh with the same `half`.
    ///
    /// A plain or tapered body is one piece, the corners of [`Superquadric::mesh_in_axes`]; a bent one is cut across
    /// its axis into pieces that are nearly straight, neighbours sharing the corners of their cut.
    pub fn convex_pieces_in_axes(&self, half: u32) -> Vec<Vec<Point3<f64>>> {
        let turn_rad = 2.0 * self.c * self.bend_per_m.abs();
        let count = libm::ceil(turn_rad / PIECE_TURN_RAD) as usize;
        if count < 2 {
            return vec![self.mesh_in_axes(half).positions];
        }
        let half = half.max(2) as usize;
        let columns = unfold(&QuarterArc::new(self.a, self.b, self.e2).silhouette_steps(half));
        let quarter = QuarterArc::new((self.a * self.b).sqrt(), self.c, self.e1).silhouette_steps(half);
        // Rings (radius, height) of the mesh from south to north, in semi-axes.
        let south = quarter.iter().rev().map(|[r, h]| [*r, -h]);
        let rings: Vec<[f64; 2]> = south.chain(quarter.iter().skip(1).copied()).collect();
        let cut = |k: usize| 2.0 * k as f64 / count as f64 - 1.0;
        (0..count)
            .map(|k| {
                let (low, high) = (cut(k), cut(k + 1));
                let inner = rings.iter().copied().filter(|[_, h]| *h > low && *h < high);
                [[self.ring_at(low), low]]
                    .into_iter()
                    .chain(inner)
                    .chain([[self.ring_at(high), high]])
                    .flat_map(|[ring, height]| {
                        columns.iter().map(move |[u, v]| {
                            self.from_base(&Point3::new(self.a * ring * u, self.b * ring * v, self.c * height))
                        })
                    })
                    .collect()
            })
            .collect()
    }

    /// Radius of the base's ring at a height in semi-axes.
    fn ring_at(&self, height: f64) -> f64 {
        let height = height.abs().min(1.0);
        if height == 0.0 { 1.0 } else { math::powf(1.0 - math::powf(height, 2.0 / self.e1), 0.5 * self.e1) }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Vector3};

    use super::*;

    #[test]
    fn pieces_follow_the_bend_and_leave_the_hollow_free() {
        let plain = Superquadric::new(0.01, 0.008, 0.06, 0.4, 1.0, Isometry3::identity()).unwrap();
        assert_eq!(plain.convex_pieces_in_axes(4).len(), 1);
        assert_eq!(plain.deformed(0.5, 0.0).unwrap().convex_pieces_in_axes(4).len(), 1);
        let bent = plain.deformed(0.2, 20.0).unwrap();
        let pieces = bent.convex_pieces_in_axes(4);
        assert_eq!(pieces.len(), 7);
        for points in &pieces {
            for p in points {
                assert!(bent.ln_inside_outside(p).abs() < 1e-9);
            }
        }
        // A pencil through the hollow along x: one hull would cover it, no piece does.
        let middle = Point3::new(0.0, 0.02, 0.0);
        let separates = |points: &[Point3<f64>], n: &Vector3<f64>| points.iter().all(|p| n.dot(&(p - middle)) > 1e-3);
        let directions: Vec<Vector3<f64>> = (0..64)
            .map(|k| {
                let (sin, cos) = math::sin_cos(0.1 * f64::from(k));
                Vector3::new(0.0, cos, sin)
            })
            .collect();
        assert!(pieces.iter().all(|points| directions.iter().any(|n| separates(points, n))));
        let whole: Vec<Point3<f64>> = pieces.concat();
        assert!(!directions.iter().any(|n| separates(&whole, n)));
    }

    #[test]
    fn every_surface_point_is_in_the_hull_of_a_piece_to_a_millimetre() {
        let plain = Superquadric::new(0.02, 0.015, 0.08, 0.6, 0.8, Isometry3::identity()).unwrap();
        let bent = plain.deformed(-0.4, -9.0).unwrap();
        let pieces = bent.convex_pieces_in_axes(6);
        let mut rng = crate::rng::Rng::new(70, 0);
        let directions: Vec<Vector3<f64>> = (0..600).map(|_| rng.direction()).collect();
        for q in bent.samples(20) {
            // A point sticks out of a hull by the largest of n · p minus the hull's support over all directions.
            let out = |points: &Vec<Point3<f64>>| {
                let support =
                    |n: &Vector3<f64>| points.iter().map(|p| n.dot(&p.coords)).max_by(f64::total_cmp).unwrap();
                directions.iter().map(|n| n.dot(&q.p_F.coords) - support(n)).max_by(f64::total_cmp).unwrap()
            };
            let least = pieces.iter().map(out).min_by(f64::total_cmp).unwrap();
            assert!(least < 0.001, "{least} {q:?}");
        }
    }
}
