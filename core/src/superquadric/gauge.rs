//! The gauge `ρ = f^(e1/2)` and all its derivatives, in logarithms.
//!
//! With `X = ln|x/a|` and so on, `ln G = (e2/2) ln(exp(2X/e2) + exp(2Y/e2))` and
//! `ln ρ = (e1/2) ln(exp(2 ln G/e1) + exp(2Z/e1))`. Let `w` be the share of each term in its sum. Then
//! `∂ln ρ/∂ln|x| = w_G w_x`, `∂ln ρ/∂ln|z| = w_z`, and the derivative by an exponent is half the entropy
//! `-Σ w ln w` of its sum, which stays between 0 and ln 2. So nothing here can overflow.
//!
//! The support function of the same body is again such a gauge, with axes `1/a` and exponents `2 - e` (the dual norm).

use nalgebra::{Point3, Vector3};

use super::Superquadric;
use super::kernels::{fast_exp, fast_ln};

/// Coordinates closer than this to an axis plane, in semi-axes, count as on it; far below any f32 or f64 cloud.
const FLOOR: f64 = 1e-150;

/// Constants of a gauge that do not depend on the point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxesGauge {
    /// 1/a, 1/b, 1/c.
    pub(crate) inverse_axes: [f64; 3],
    /// e1/2, e2/2.
    half_e: [f64; 2],
    /// 2/e1, 2/e2.
    two_over_e: [f64; 2],
}

/// The logarithm of the gauge at a point with its derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogGauge {
    /// ln ρ.
    pub(crate) ln_rho: f64,
    /// ∂ln ρ/∂ln|x|, ∂ln ρ/∂ln|y|, ∂ln ρ/∂ln|z|: not negative, sum 1.
    pub(crate) shares: [f64; 3],
    /// ∂ln ρ/∂e1, ∂ln ρ/∂e2.
    pub(crate) by_exponent: [f64; 2],
    /// ∂ln ρ/∂(x, y, z); 0 along a coordinate that is 0.
    pub(crate) gradient: [f64; 3],
}

/// `(ln(eᵘ + eᵛ) - max, share of u, share of v, entropy)` of a sum of two terms, from `u - v`.
#[inline(always)]
fn two_terms(difference: f64) -> (f64, f64, f64, f64) {
    let gap = difference.abs();
    let ratio = fast_exp(-gap);
    let excess = fast_ln(1.0 + ratio);
    let large = 1.0 / (1.0 + ratio);
    let small = ratio * large;
    let (first, second) = if difference > 0.0 { (large, small) } else { (small, large) };
    (excess, first, second, excess + small * gap)
}

impl AxesGauge {
    /// The gauge with these semi-axes and exponents (e1, e2).
    #[inline(always)]
    pub(crate) fn new(axes: [f64; 3], e: [f64; 2]) -> Self {
        Self { inverse_axes: axes.map(|a| 1.0 / a), half_e: e.map(|e| 0.5 * e), two_over_e: e.map(|e| 2.0 / e) }
    }

    /// Value and derivatives at the point (x, y, z) of the axes S.
    #[inline(always)]
    pub(crate) fn at(&self, p: [f64; 3]) -> LogGauge {
        let scaled = [0, 1, 2].map(|i| {
            let r = p[i].abs() * self.inverse_axes[i];
            if r > FLOOR { r } else { FLOOR }
        });
        let ln = scaled.map(fast_ln);
        let (excess_2, share_x, share_y, entropy_2) = two_terms(self.two_over_e[1] * (ln[0] - ln[1]));
        let ln_section = (if ln[0] > ln[1] { ln[0] } else { ln[1] }) + self.half_e[1] * excess_2;
        let (excess_1, share_section, share_z, entropy_1) = two_terms(self.two_over_e[0] * (ln_section - ln[2]));
        let ln_rho = (if ln_section > ln[2] { ln_section } else { ln[2] }) + self.half_e[0] * excess_1;
        let shares = [share_section * share_x, share_section * share_y, share_z];
        let gradient = [0, 1, 2].map(|i| {
            let on_plane = scaled[i] <= FLOOR;
            let slope = shares[i] / (if on_plane { 1.0 } else { p[i] });
            if on_plane { 0.0 } else { slope }
        });
        LogGauge { ln_rho, shares, by_exponent: [0.5 * entropy_1, 0.5 * share_section * entropy_2], gradient }
    }
}

impl Superquadric {
    /// The gauge of the base shape, before taper and bend, at a base point.
    #[inline]
    pub(crate) fn base_gauge(&self, p_0: &Point3<f64>) -> LogGauge {
        AxesGauge::new([self.a, self.b, self.c], [self.e1, self.e2]).at([p_0.x, p_0.y, p_0.z])
    }
}

impl LogGauge {
    /// ∂ln ρ/∂p as a vector.
    #[inline(always)]
    pub(crate) fn gradient(&self) -> Vector3<f64> {
        Vector3::new(self.gradient[0], self.gradient[1], self.gradient[2])
    }
}
