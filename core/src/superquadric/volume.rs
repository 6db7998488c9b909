//! Volume (3.11).

use super::Superquadric;
use crate::math;

/// `ln B(x, y)` of the beta function.
fn ln_beta(x: f64, y: f64) -> f64 {
    math::ln_gamma(x) + math::ln_gamma(y) - math::ln_gamma(x + y)
}

impl Superquadric {
    /// Volume (3.11), cubic metres: `2 a b c e1 e2 B(e1/2 + 1, e1) B(e2/2, e2/2)`.
    pub fn volume(&self) -> f64 {
        let ln_betas = ln_beta(0.5 * self.e1 + 1.0, self.e1) + ln_beta(0.5 * self.e2, 0.5 * self.e2);
        2.0 * self.a * self.b * self.c * self.e1 * self.e2 * math::exp(ln_betas)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::{Isometry3, Point3};

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
