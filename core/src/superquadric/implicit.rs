//! The inside–outside function f (3.1) with its gradients, in the log domain.
//!
//! f of a tapered or bent shape is f of the base shape at the base point ([`Superquadric::to_base`]).

use nalgebra::{Point3, Vector3};

use super::{Superquadric, fast_exp};

impl Superquadric {
    /// `ln f` (3.1) at a point of the axes S: negative inside, 0 on the surface, positive outside.
    ///
    /// Finite everywhere; the centre counts as a point 1e-150 semi-axes away from it.
    pub fn ln_inside_outside(&self, p_S: &Point3<f64>) -> f64 {
        2.0 / self.e1 * self.base_gauge(&self.to_base(p_S)).ln_rho
    }

    /// The inside–outside function f (3.1) at a point of the axes S: below 1 inside, above 1 outside.
    ///
    /// Held at e⁷⁰⁰ ≈ 1e304 where it would overflow.
    pub fn inside_outside(&self, p_S: &Point3<f64>) -> f64 {
        fast_exp(self.ln_inside_outside(p_S))
    }

    /// Whether a point of F is inside or on the surface.
    pub fn contains(&self, p_F: &Point3<f64>) -> bool {
        self.ln_inside_outside(&self.to_axes(p_F)) <= 0.0
    }

    /// `∂ln f/∂p_S`, 1/m: 0 along a coordinate whose base value is 0, so finite on the axis planes and at the centre.
    pub fn ln_gradient(&self, p_S: &Point3<f64>) -> Vector3<f64> {
        let k = 2.0 / self.e1;
        if self.is_deformed() {
            let base = self.deformation().base_point(p_S);
            return k * base.gradient_in_axes(&self.base_gauge(&base.p_0).gradient());
        }
        k * self.base_gauge(p_S).gradient()
    }

    /// `∂f/∂p_S`, 1/m; f as held by [`Superquadric::inside_outside`].
    pub fn gradient(&self, p_S: &Point3<f64>) -> Vector3<f64> {
        self.inside_outside(p_S) * self.ln_gradient(p_S)
    }

    /// `∂ln f/∂(a, b, c, e1, e2, K, κ)` at a point of the axes S.
    pub fn ln_parameter_gradient(&self, p_S: &Point3<f64>) -> [f64; 7] {
        let base = self.deformation().undeformed_with_derivatives(p_S);
        let gauge = self.base_gauge(&base.p_0);
        let gradient = gauge.gradient();
        let k = 2.0 / self.e1;
        [
            -k * gauge.shares[0] / self.a,
            -k * gauge.shares[1] / self.b,
            k * (gradient.dot(&base.by_c) - gauge.shares[2] / self.c),
            k * (gauge.by_exponent[0] - gauge.ln_rho / self.e1),
            k * gauge.by_exponent[1],
            k * gradient.dot(&base.by_taper),
            k * gradient.dot(&base.by_bend),
        ]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::super::bend_limit_per_m;
    use super::*;
    use crate::math;
    use crate::rng::Rng;

    /// (3.1) typed as printed; overflows for small exponents, which the tests avoid.
    fn f_as_printed(s: &Superquadric, p: &Point3<f64>) -> f64 {
        let section = math::powf((p.x / s.a).abs(), 2.0 / s.e2) + math::powf((p.y / s.b).abs(), 2.0 / s.e2);
        math::powf(section, s.e2 / s.e1) + math::powf((p.z / s.c).abs(), 2.0 / s.e1)
    }

    fn random_shape(rng: &mut Rng) -> Superquadric {
        let mut axis = || rng.uniform(0.025, 0.39);
        let (a, b, c) = (axis(), axis(), axis());
        let (e1, e2) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9));
        Superquadric::new(a, b, c, e1, e2, Isometry3::identity()).unwrap()
    }

    fn random_deformed(rng: &mut Rng) -> Superquadric {
        let plain = random_shape(rng);
        let taper = rng.uniform(-0.9, 0.9);
        let most = bend_limit_per_m(plain.b, plain.c, taper);
        plain.deformed(taper, rng.uniform(-most, most)).unwrap()
    }

    /// Points near the surface, every second one moved onto an axis plane or an axis.
    fn points(s: &Superquadric, rng: &mut Rng, count: usize) -> Vec<Point3<f64>> {
        (0..count)
            .map(|k| {
                let mut d = rng.direction().component_mul(&s.semi_axes()) * rng.uniform(0.6, 1.4);
                match k % 6 {
                    1 => d.x = 0.0,
                    3 => d.y = 0.0,
                    5 => d.z = 0.0,
                    _ => {}
                }
                if k % 12 == 11 {
                    d.y = 0.0;
                }
                Point3::from(d)
            })
            .collect()
    }

    #[test]
    fn value_equals_the_printed_formula_where_that_does_not_overflow() {
        let mut rng = Rng::new(3, 0);
        for _ in 0..200 {
            let s = random_shape(&mut rng);
            for p in points(&s, &mut rng, 24) {
                let (value, printed) = (s.inside_outside(&p), f_as_printed(&s, &p));
                // Relative 1e-10: powers up to 20 · 20 multiply the relative round-off of a logarithm.
                assert!((value - printed).abs() <= 1e-10 * printed.max(1e-30), "{value} {printed} at {p:?}");
            }
        }
    }

    #[test]
    fn gradient_matches_central_difference_on_the_axis_planes_too() {
        let mut rng = Rng::new(4, 0);
        for _ in 0..100 {
            let s = random_shape(&mut rng);
            for p in points(&s, &mut rng, 24) {
                let gradient = s.ln_gradient(&p);
                for axis in 0..3 {
                    let h = 1e-7 * s.semi_axes()[axis];
                    // Next to an axis plane |x|^(2/e) bends too fast for any difference: stay 1e-3 semi-axes away.
                    if p[axis] != 0.0 && p[axis].abs() < 1e-3 * s.semi_axes()[axis] {
                        continue;
                    }
                    let mut step = Vector3::zeros();
                    step[axis] = h;
                    let difference = (s.ln_inside_outside(&(p + step)) - s.ln_inside_outside(&(p - step))) / (2.0 * h);
                    // ln f up to 20 with 1e-16 relative error over h = 1e-7 a: about 2e-8/a; 1e-5/a covers curvature.
                    let scale = 1.0 / s.semi_axes()[axis] + difference.abs();
                    assert!((gradient[axis] - difference).abs() < 1e-5 * scale, "{s:?} at {p:?} axis {axis}");
                }
            }
        }
    }

    #[test]
    fn gradient_of_a_deformed_shape_matches_central_difference() {
        let mut rng = Rng::new(6, 0);
        for _ in 0..100 {
            let s = random_deformed(&mut rng);
            for _ in 0..24 {
                // Base points well off the axis planes, next to which |x|^(2/e) bends too fast for any difference.
                let p_0 =
                    Point3::from(s.semi_axes().map(|a| a * rng.uniform(0.2, 1.1) * rng.uniform(-1.0, 1.0).signum()));
                let p = s.from_base(&p_0);
                assert!((s.ln_inside_outside(&p) - 2.0 / s.e1 * s.base_gauge(&p_0).ln_rho).abs() < 1e-10);
                let gradient = s.ln_gradient(&p);
                for axis in 0..3 {
                    let mut step = Vector3::zeros();
                    step[axis] = 1e-8;
                    let difference = (s.ln_inside_outside(&(p + step)) - s.ln_inside_outside(&(p - step))) / 2e-8;
                    // ln f up to 20 with 1e-15 relative error over 1e-8 is 2e-6, times 20 at a thin end.
                    let scale = 1.0 / 0.025 + gradient.norm();
                    assert!((gradient[axis] - difference).abs() < 1e-5 * scale, "{s:?} at {p:?} axis {axis}");
                }
            }
        }
    }

    #[test]
    fn parameter_gradient_matches_central_difference() {
        let mut rng = Rng::new(5, 0);
        for k in 0..200 {
            let s = if k % 2 == 0 { random_shape(&mut rng) } else { random_deformed(&mut rng) };
            for p in points(&s, &mut rng, 24) {
                let gradient = s.ln_parameter_gradient(&p);
                for (k, expected) in gradient.into_iter().enumerate() {
                    let at = |h: f64| {
                        let mut moved = s;
                        let Superquadric { a, b, c, e1, e2, taper, bend_per_m, .. } = &mut moved;
                        *[a, b, c, e1, e2, taper, bend_per_m].into_iter().nth(k).unwrap() += h;
                        moved.ln_inside_outside(&p)
                    };
                    let h = 1e-7;
                    let difference = (at(h) - at(-h)) / (2.0 * h);
                    // Second derivatives reach 1/a² = 1600 and 4/e1³ = 4000; h² of the third order is far below.
                    assert!((expected - difference).abs() < 1e-4 * (1.0 + difference.abs()), "{s:?} {p:?} {k}");
                }
            }
        }
    }

    #[test]
    fn everything_is_finite_at_the_centre_on_axes_and_for_tiny_exponents() {
        for e in [0.01, 0.1, 1.0, 1.99] {
            let s = Superquadric::new(0.03, 0.05, 0.4, e, e, Isometry3::identity()).unwrap();
            for x in [0.0, 1e-200, 1e-12, 0.03, 10.0] {
                for p in [Point3::new(x, 0.0, 0.0), Point3::new(0.0, x, 0.0), Point3::new(x, x, x)] {
                    assert!(s.ln_inside_outside(&p).is_finite() && s.inside_outside(&p).is_finite());
                    assert!(s.ln_gradient(&p).iter().all(|g| g.is_finite()), "e {e} at {p:?}");
                    assert!(s.ln_parameter_gradient(&p).iter().all(|g| g.is_finite()));
                    assert!(s.signed_distance(&p).is_finite() && s.radial_distance(&p).is_finite());
                }
            }
        }
    }
}
