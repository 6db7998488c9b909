//! Volume (3.11).

use super::Superquadric;
use crate::math;

/// `ln B(x, y)` of the beta function.
fn ln_beta(x: f64, y: f64) -> f64 {
    math::ln_gamma(x) + math::ln_gamma(y) - math::ln_gamma(x + y)
}

impl Superquadric {
    /// Volume (3.11), cubic metres: `2 a b c e1 e2 B(e1/2 + 1, e1) B(e2/2, e2/2)`, tapered and bent.
    ///
    /// The deformation has `det J = s² (1 - κ s y)` with `s = 1 + K z/c`. y is odd, so the bend leaves the volume, and
    /// of `s²` the mean over the base shape is `1 + K² m`, where `m = B(3 e1/2, e1 + 1) / B(e1/2, e1 + 1)` is that of
    /// `(z/c)²`.
    pub fn volume(&self) -> f64 {
        let ln_betas = ln_beta(0.5 * self.e1 + 1.0, self.e1) + ln_beta(0.5 * self.e2, 0.5 * self.e2);
        let base = 2.0 * self.a * self.b * self.c * self.e1 * self.e2 * math::exp(ln_betas);
        if self.taper == 0.0 {
            return base;
        }
        let second_moment = math::exp(ln_beta(1.5 * self.e1, self.e1 + 1.0) - ln_beta(0.5 * self.e1, self.e1 + 1.0));
        base * (1.0 + self.taper * self.taper * second_moment)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::{Isometry3, Point3, Vector3};

    use super::*;

    fn shape(a: f64, b: f64, c: f64, e1: f64, e2: f64) -> Superquadric {
        Superquadric::new(a, b, c, e1, e2, Isometry3::identity()).unwrap()
    }

    #[test]
    fn known_shapes_have_known_volumes() {
        assert!((shape(0.1, 0.2, 0.3, 1.0, 1.0).volume() / (4.0 / 3.0 * PI * 0.006) - 1.0).abs() < 1e-12);
        // At e = 0.01 a box lacks about 1e-4 of its volume, an upright cylinder half of that.
        assert!((shape(0.1, 0.2, 0.3, 0.01, 0.01).volume() / (8.0 * 0.006) - 1.0).abs() < 3e-4);
        assert!((shape(0.1, 0.1, 0.3, 0.01, 1.0).volume() / (2.0 * PI * 0.003) - 1.0).abs() < 3e-4);
        // e1 → 2, e2 = 1 is a double cone: 2/3 π a b c.
        assert!((shape(0.1, 0.1, 0.3, 1.99, 1.0).volume() / (2.0 / 3.0 * PI * 0.003) - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_tapered_cylinder_has_the_volume_of_a_truncated_cone() {
        // Radii 0.05 and 0.15, height 0.6; e1 = 0.01 rounds off 1e-4.
        let s = shape(0.1, 0.1, 0.3, 0.01, 1.0).deformed(0.5, 0.0).unwrap();
        let cone = PI / 3.0 * 0.6 * (0.15 * 0.15 + 0.15 * 0.05 + 0.05 * 0.05);
        assert!((s.volume() / cone - 1.0).abs() < 3e-4);
    }

    #[test]
    fn volume_of_deformed_shapes_equals_a_count_of_cells() {
        for (e1, e2, taper, bend) in
            [(0.1, 0.1, 0.6, 0.0), (1.0, 0.5, -0.4, 4.0), (1.7, 1.5, 0.9, 3.0), (0.3, 1.0, 0.0, -6.0)]
        {
            let s = shape(0.06, 0.08, 0.2, e1, e2).deformed(taper, bend).unwrap();
            let (low, high) = s.bounding_box_in(&Isometry3::identity());
            let n = 120;
            let edges = (high - low) / n as f64;
            let mut inside = 0usize;
            for i in 0..n {
                for j in 0..n {
                    for k in 0..n {
                        let middle = Vector3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5);
                        inside += usize::from(s.contains(&(low + middle.component_mul(&edges))));
                    }
                }
            }
            let counted = inside as f64 * edges.product();
            // The surface crosses about 3 · 120² of the cells, half of which may be miscounted by chance.
            assert!((counted / s.volume() - 1.0).abs() < 0.005, "{counted} {} {s:?}", s.volume());
        }
    }

    #[test]
    fn volume_equals_a_count_of_cells() {
        for (e1, e2) in [(0.1, 0.1), (0.4, 1.3), (1.0, 0.5), (1.9, 1.9), (1.5, 0.2)] {
            let s = shape(0.1, 0.15, 0.2, e1, e2);
            // One octant in 80³ cells: the surface crosses 3 · 80² of them, half of which may be miscounted by chance.
            let n = 80;
            let cell = |i: usize| (i as f64 + 0.5) / n as f64;
            let mut inside = 0usize;
            for i in 0..n {
                for j in 0..n {
                    for k in 0..n {
                        let p = Point3::new(s.a * cell(i), s.b * cell(j), s.c * cell(k));
                        inside += usize::from(s.contains(&p));
                    }
                }
            }
            let counted = 8.0 * s.a * s.b * s.c * inside as f64 / (n * n * n) as f64;
            assert!((counted / s.volume() - 1.0).abs() < 0.01, "{counted} {} e1 {e1} e2 {e2}", s.volume());
        }
    }
}
