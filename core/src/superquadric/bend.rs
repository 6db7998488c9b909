//! Bend in the y–z plane about an axis parallel to x at `y = R = 1/κ`.
//!
//! `x' = x`, `y' = R - (R - y) cos κz`, `z' = (R - y) sin κz`: the z axis becomes an arc of curvature κ that leaves the
//! origin along z and turns towards +y for κ > 0. Distances along x and y stay, lengths along z are stretched by
//! `r = 1 - κy`. All formulas are written so that κ → 0 is the straight body without loss of digits.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::math;

/// r is held above this in derivatives: on the axis of curvature the direction of z has none.
const LEAST_STRETCH: f64 = 1e-9;
/// Below this angle, radians, `atan t / t` and its kin are summed as series to the last digit.
const SMALL_RAD: f64 = 0.05;

/// A bend with curvature κ, 1/m, of either sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    pub(super) per_m: f64,
}

/// A point before the bend, and how the bend turns and stretches space there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Straightened {
    /// The point before the bend.
    pub(super) p: Point3<f64>,
    /// r = 1 - κy: metres along the arc per metre of z.
    pub(super) stretch: f64,
    /// cos κz and sin κz.
    pub(super) cos: f64,
    pub(super) sin: f64,
}

/// `sin φ / φ`.
fn sinc(phi: f64) -> f64 {
    if phi.abs() < 1e-4 { 1.0 - phi * phi / 6.0 } else { math::sin(phi) / phi }
}

impl Bend {
    /// The bent place of a point.
    #[inline(always)]
    pub(super) fn bent(&self, p: &Point3<f64>) -> Point3<f64> {
        let phi = self.per_m * p.z;
        let (sin, cos) = math::sin_cos(phi);
        // (1 - cos φ)/κ and sin φ/κ.
        let sagitta = p.z * math::sin(0.5 * phi) * sinc(0.5 * phi);
        Point3::new(p.x, p.y * cos + sagitta, p.z * sinc(phi) - p.y * sin)
    }

    /// The inverse of [`Bend::bent`]: for a point beyond the axis of curvature, the shorter way around it.
    #[inline(always)]
    pub(super) fn straightened(&self, p: &Point3<f64>) -> Straightened {
        let k = self.per_m;
        let (u, v) = (1.0 - k * p.y, k * p.z);
        let r = (u * u + v * v).sqrt();
        let stretch = if r > LEAST_STRETCH { r } else { LEAST_STRETCH };
        let y = (2.0 * p.y - k * (p.y * p.y + p.z * p.z)) / (1.0 + r);
        let z = if u > 0.0 && v.abs() < SMALL_RAD * u {
            let t = v / u;
            p.z / u * atan_over(t * t)
        } else {
            math::atan2(v, u) / k
        };
        Straightened { p: Point3::new(p.x, y, z), stretch, cos: u / stretch, sin: v / stretch }
    }

    /// What [`Bend::straightened`] gives for the bent place of a point of the body.
    #[inline(always)]
    pub(super) fn straight(&self, p: &Point3<f64>) -> Straightened {
        let (sin, cos) = math::sin_cos(self.per_m * p.z);
        Straightened { p: *p, stretch: (1.0 - self.per_m * p.y).max(LEAST_STRETCH), cos, sin }
    }

    /// ∂(straightened point)/∂κ at a bent point, m².
    #[inline(always)]
    pub(super) fn straightened_by_curvature(&self, p: &Point3<f64>, at: &Straightened) -> Vector3<f64> {
        let k = self.per_m;
        let (u, v) = (1.0 - k * p.y, k * p.z);
        let r = at.stretch;
        let squared = p.y * p.y + p.z * p.z;
        let r_by_curvature = (k * squared - p.y) / r;
        let y = -(squared + at.p.y * r_by_curvature) / (1.0 + r);
        let z = if u > 0.0 && v.abs() < SMALL_RAD * u {
            let t = v / u;
            let (y_u, z_u) = (p.y / u, p.z / u);
            z_u * (y_u / (1.0 + t * t) + z_u * t * atan_over_by(t * t))
        } else {
            (p.z / (r * r) - at.p.z) / k
        };
        Vector3::new(0.0, y, z)
    }
}

/// `atan t / t` from t², for small t.
#[inline(always)]
fn atan_over(t2: f64) -> f64 {
    1.0 - t2 * (1.0 / 3.0 - t2 * (0.2 - t2 * (1.0 / 7.0 - t2 * (1.0 / 9.0 - t2 * (1.0 / 11.0)))))
}

/// `(1/(1 + t²) - atan t / t) / t²` from t², for small t.
#[inline(always)]
fn atan_over_by(t2: f64) -> f64 {
    -2.0 / 3.0 + t2 * (0.8 - t2 * (6.0 / 7.0 - t2 * (8.0 / 9.0 - t2 * (10.0 / 11.0 - t2 * (12.0 / 13.0)))))
}

impl Straightened {
    /// Jacobian of the inverse map, ∂p/∂p': a turn about x by κz, then 1/r along z.
    #[inline(always)]
    pub(super) fn inverse_jacobian(&self) -> Matrix3<f64> {
        let over = 1.0 / self.stretch;
        let (c, s) = (self.cos, self.sin);
        Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s * over, c * over)
    }

    /// `Jᵀ g` with the inverse map's Jacobian J: the gradient over bent points of a function with gradient g over
    /// straight ones.
    #[inline(always)]
    pub(super) fn inverse_transposed_times(&self, g: &Vector3<f64>) -> Vector3<f64> {
        self.turned(&Vector3::new(g.x, g.y, g.z / self.stretch))
    }

    /// A direction given along x, towards the axis of curvature and along the arc, in the axes S.
    #[inline(always)]
    pub(super) fn turned(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(v.x, self.cos * v.y + self.sin * v.z, self.cos * v.z - self.sin * v.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn bending_equals_the_printed_formula_and_has_its_inverse_for_every_curvature() {
        let mut rng = Rng::new(30, 0);
        for per_m in [0.0, 1e-12, -1e-9, 1e-5, -1e-3, 0.1, -2.0, 7.0, -9.0] {
            let bend = Bend { per_m };
            for _ in 0..200 {
                let p = Point3::new(rng.uniform(-0.1, 0.1), rng.uniform(-0.09, 0.09), rng.uniform(-0.17, 0.17));
                let bent = bend.bent(&p);
                let back = bend.straightened(&bent);
                assert!((back.p - p).norm() < 1e-15 / 0.1, "{per_m} {p:?} {back:?}");
                assert!((back.stretch - (1.0 - per_m * p.y)).abs() < 1e-14);
                if per_m.abs() > 0.01 {
                    let R = 1.0 / per_m;
                    let (sin, cos) = math::sin_cos(per_m * p.z);
                    let printed = Point3::new(p.x, R - (R - p.y) * cos, (R - p.y) * sin);
                    assert!((bent - printed).norm() < 1e-13, "{per_m} {p:?}");
                } else {
                    // A straight body moves by κ z²/2 and κ y z at most.
                    assert!((bent - p).norm() <= 0.04 * per_m.abs(), "{per_m} {p:?}");
                }
            }
        }
    }
}
