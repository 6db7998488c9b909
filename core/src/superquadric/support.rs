//! Support function and bounding boxes, exact and closed-form.

use nalgebra::{Isometry3, Vector3};

use super::{AxesGauge, Superquadric, fast_exp};

impl Superquadric {
    /// Support function in F about the centre: the largest `d · (p - centre)` over the body, metres for a unit `d`.
    ///
    /// The body is a unit ball of nested ℓp norms with `p = 2/e`; its support function is the dual norm, the same
    /// formula with semi-axes 1/a, 1/b, 1/c and exponents `2 - e`.
    pub fn support(&self, d_F: &Vector3<f64>) -> f64 {
        if d_F.iter().all(|d| *d == 0.0) {
            return 0.0;
        }
        let d_S = self.X_FS.rotation.inverse_transform_vector(d_F);
        let dual = AxesGauge::new([1.0 / self.a, 1.0 / self.b, 1.0 / self.c], [2.0 - self.e1, 2.0 - self.e2]);
        fast_exp(dual.at([d_S.x, d_S.y, d_S.z]).ln_rho)
    }

    /// Half the extents of the axis-aligned bounding box in a frame G, given the pose of F in G, metres.
    ///
    /// The box is centred on the superquadric's centre.
    pub fn half_extents_in(&self, X_GF: &Isometry3<f64>) -> Vector3<f64> {
        let along = |axis: Vector3<f64>| self.support(&X_GF.rotation.inverse_transform_vector(&axis));
        Vector3::new(along(Vector3::x()), along(Vector3::y()), along(Vector3::z()))
    }

    /// Half the extents of the axis-aligned bounding box in F, metres.
    pub fn half_extents(&self) -> Vector3<f64> {
        self.half_extents_in(&Isometry3::identity())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn support_is_the_farthest_point_of_the_surface() {
        let mut rng = Rng::new(12, 0);
        for _ in 0..20 {
            let X_FS = Isometry3::from_parts(nalgebra::Translation3::identity(), rng.rotation());
            let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.2));
            let (e1, e2) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9));
            let s = Superquadric::new(axes[0], axes[1], axes[2], e1, e2, X_FS).unwrap();
            let surface = s.samples_spaced(0.004);
            for _ in 0..10 {
                let d = rng.direction();
                let farthest = surface.iter().map(|q| d.dot(&q.p_F.coords)).max_by(f64::total_cmp).unwrap();
                let support = s.support(&d);
                // Samples are 4 mm apart, so the farthest one is less than 4 mm short.
                assert!(farthest <= support + 1e-12 && support - farthest < 0.004, "{support} {farthest} {s:?}");
            }
            // Each of (4.1)'s points with (4.2)'s normal attains the support of that normal exactly.
            let (p, n) = (s.point(0.7, 0.4), s.normal(0.7, 0.4));
            assert!((s.support(&n) - n.dot(&p.coords)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_box_turned_by_45_degrees_has_the_diagonal_as_extent() {
        let turn = Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_4);
        let s = Superquadric::new(0.1, 0.1, 0.2, 0.01, 0.01, turn).unwrap();
        let half = s.half_extents();
        // An exponent of 0.01 rounds each corner by 0.35 % of its semi-axis.
        assert!((half.x / (0.1 * std::f64::consts::SQRT_2) - 1.0).abs() < 0.01 && (half.z - 0.2).abs() < 1e-12);
    }
}
