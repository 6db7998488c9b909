//! The explicit form (4.1), its normals (4.2), both also tapered and bent, and the normal at a surface point.

use nalgebra::{Point3, Unit, Vector3};

use super::{Superquadric, fast_exp};
use crate::math;

impl Superquadric {
    /// The surface point (4.1) in F: latitude η in [-π/2, π/2], longitude ω in [-π, π), radians.
    pub fn point(&self, eta_rad: f64, omega_rad: f64) -> Point3<f64> {
        self.X_FS * self.from_base(&self.base_at(eta_rad, omega_rad))
    }

    /// The point (4.1) of the base shape, before taper and bend.
    fn base_at(&self, eta_rad: f64, omega_rad: f64) -> Point3<f64> {
        let (sin_eta, cos_eta) = math::sin_cos(eta_rad);
        let (sin_omega, cos_omega) = math::sin_cos(omega_rad);
        // cos(π/2) is 6e-17, not 0, and 6e-17^0.1 is 0.02: a pole must be a pole.
        let ring = math::signed_powf(snap(cos_eta), self.e1);
        Point3::new(
            self.a * ring * math::signed_powf(snap(cos_omega), self.e2),
            self.b * ring * math::signed_powf(snap(sin_omega), self.e2),
            self.c * math::signed_powf(snap(sin_eta), self.e1),
        )
    }

    /// The outward unit normal (4.2) in F at latitude η and longitude ω, radians.
    pub fn normal(&self, eta_rad: f64, omega_rad: f64) -> Unit<Vector3<f64>> {
        let (sin_eta, cos_eta) = math::sin_cos(eta_rad);
        let (sin_omega, cos_omega) = math::sin_cos(omega_rad);
        let ring = math::signed_powf(snap(cos_eta), 2.0 - self.e1);
        let n_0 = Vector3::new(
            ring * math::signed_powf(snap(cos_omega), 2.0 - self.e2) / self.a,
            ring * math::signed_powf(snap(sin_omega), 2.0 - self.e2) / self.b,
            math::signed_powf(snap(sin_eta), 2.0 - self.e1) / self.c,
        );
        let n_S = self.gradient_from_base(&self.base_at(eta_rad, omega_rad), &n_0);
        self.X_FS.rotation * Unit::try_new(n_S, 0.0).unwrap_or_else(Vector3::z_axis)
    }

    /// The outward unit normal in F where the ray from the centre through a point of F leaves the surface.
    ///
    /// For a point on the surface this is the surface normal. At the centre it is the axis of the shortest semi-axis.
    /// The ray is one of the base shape: on a bent body it follows the bend.
    pub fn normal_at(&self, p_F: &Point3<f64>) -> Unit<Vector3<f64>> {
        let p_0 = self.to_base(&self.to_axes(p_F));
        let gauge = self.base_gauge(&p_0);
        let foot_0 = p_0 * fast_exp(-gauge.ln_rho);
        let n_S = self.gradient_from_base(&foot_0, &gauge.gradient());
        let shortest = match self.semi_axes().imin() {
            0 => Vector3::x_axis(),
            1 => Vector3::y_axis(),
            _ => Vector3::z_axis(),
        };
        self.X_FS.rotation * Unit::try_new(n_S, 0.0).unwrap_or(shortest)
    }
}

/// Zero for what is round-off of a sine or cosine at a multiple of π/2.
fn snap(x: f64) -> f64 {
    if x.abs() < 1e-15 { 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::{Isometry3, Translation3};

    use super::super::bend_limit_per_m;
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn explicit_points_lie_on_the_surface_and_normals_follow_the_gradient() {
        let mut rng = Rng::new(6, 0);
        for _ in 0..200 {
            let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
            let axes = [0.0; 3].map(|_: f64| rng.uniform(0.025, 0.39));
            let (e1, e2) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9));
            let s = Superquadric::new(axes[0], axes[1], axes[2], e1, e2, X_FS).unwrap();
            for k in 0..40 {
                let (mut eta, mut omega) = (rng.uniform(-FRAC_PI_2, FRAC_PI_2), rng.uniform(-PI, PI));
                if k % 4 == 0 {
                    eta = [0.0, FRAC_PI_2, -FRAC_PI_2][k / 4 % 3];
                }
                if k % 4 == 1 {
                    omega = [0.0, FRAC_PI_2, -FRAC_PI_2, -PI][k / 4 % 4];
                }
                let p_F = s.point(eta, omega);
                // 20/e1 amplifies the rounding of the rigid motion (1e-16 of 1 m over semi-axes of 25 mm).
                assert!(s.ln_inside_outside(&s.to_axes(&p_F)).abs() < 1e-9, "{s:?} {eta} {omega}");
                // Where a coordinate is lost in that rounding, so is its share in the normal: compare away from there.
                let p_S = s.to_axes(&p_F).coords.component_div(&s.semi_axes());
                if p_S.iter().all(|x| x.abs() > 1e-4) {
                    let angle = s.normal(eta, omega).angle(&s.normal_at(&p_F));
                    assert!(angle < 1e-6, "{angle} {s:?} {eta} {omega}");
                }
            }
        }
    }

    #[test]
    fn normals_of_deformed_shapes_stand_on_both_tangents() {
        let mut rng = Rng::new(7, 0);
        for _ in 0..100 {
            let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
            let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.2));
            let plain =
                Superquadric::new(axes[0], axes[1], axes[2], rng.uniform(0.3, 1.7), rng.uniform(0.3, 1.7), X_FS);
            let (plain, taper) = (plain.unwrap(), rng.uniform(-0.9, 0.9));
            let most = bend_limit_per_m(plain.b, plain.c, taper);
            let s = plain.deformed(taper, rng.uniform(-most, most)).unwrap();
            for _ in 0..40 {
                let (eta, omega) = (rng.uniform(0.2, 1.3) * rng.uniform(-1.0, 1.0).signum(), rng.uniform(0.2, 1.3));
                let (p, n) = (s.point(eta, omega), s.normal(eta, omega));
                assert!(s.ln_inside_outside(&s.to_axes(&p)).abs() < 1e-9, "{s:?}");
                assert!(n.angle(&s.normal_at(&p)) < 1e-6);
                let h = 1e-6;
                for tangent in [s.point(eta + h, omega) - p, s.point(eta, omega + h) - p] {
                    // A chord of 1e-6 rad leaves the tangent by its own curvature, 1e-6 times less than 100.
                    assert!(n.dot(&tangent).abs() < 1e-4 * tangent.norm(), "{s:?} {eta} {omega}");
                }
                assert!(!s.contains(&(p + n.scale(1e-7))) && s.contains(&(p - n.scale(1e-7))));
            }
        }
    }

    #[test]
    fn poles_and_axes_have_axis_normals_even_for_boxes() {
        let s = Superquadric::new(0.1, 0.2, 0.3, 0.1, 0.1, Isometry3::identity()).unwrap();
        assert!((s.point(FRAC_PI_2, 0.3) - Point3::new(0.0, 0.0, 0.3)).norm() < 1e-12);
        assert!((s.normal(FRAC_PI_2, 0.3).into_inner() - Vector3::z()).norm() < 1e-12);
        assert!((s.normal(0.0, FRAC_PI_2).into_inner() - Vector3::y()).norm() < 1e-12);
        assert!((s.normal_at(&Point3::origin()).into_inner() - Vector3::x()).norm() < 1e-12);
    }
}
