//! Transcendental functions with the same last bit on every platform.
//!
//! The standard library forwards `sin` and its kin to the platform, whose results differ in the last bit; a planner
//! amplifies that bit into another plan. Everything in this crate calls `libm` through these names instead.
//! `sqrt` is exact by IEEE 754 and stays a method.

/// Sine of an angle in radians.
#[inline]
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Cosine of an angle in radians.
#[inline]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Sine and cosine of an angle in radians.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Tangent of an angle in radians.
#[inline]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Arc sine in radians; arguments just outside [-1, 1] by round-off are moved to the edge.
#[inline]
pub fn asin(x: f64) -> f64 {
    libm::asin(x.max(-1.0).min(1.0))
}

/// Arc cosine in radians; arguments just outside [-1, 1] by round-off are moved to the edge.
#[inline]
pub fn acos(x: f64) -> f64 {
    libm::acos(x.max(-1.0).min(1.0))
}

/// Angle of the vector (x, y) in (-π, π].
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// e to the power x.
#[inline]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm; minus infinity at zero.
#[inline]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// x to the power y.
#[inline]
pub fn powf(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// `ln Γ(x)` for x > 0.
#[inline]
pub fn ln_gamma(x: f64) -> f64 {
    libm::lgamma(x)
}

/// `sign(x) |x|^y`, the signed power of the explicit superquadric form (4.1).
#[inline]
pub fn signed_powf(x: f64, y: f64) -> f64 {
    if x == 0.0 { 0.0 } else { libm::copysign(libm::pow(x.abs(), y), x) }
}

/// `ln(eᵃ + eᵇ)` without overflow; minus infinity stands for an exact zero term.
#[inline]
pub fn ln_add_exp(a: f64, b: f64) -> f64 {
    let hi = a.max(b);
    if hi == f64::NEG_INFINITY {
        return hi;
    }
    let lo = a.min(b);
    hi + libm::log1p(libm::exp(lo - hi))
}

/// The angle moved by whole turns into [-π, π].
#[inline]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let turns = libm::round(angle_rad / std::f64::consts::TAU);
    angle_rad - turns * std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ln_add_exp_survives_terms_that_overflow_alone() {
        assert!((ln_add_exp(2000.0, 2000.0) - (2000.0 + std::f64::consts::LN_2)).abs() < 1e-12);
        assert_eq!(ln_add_exp(f64::NEG_INFINITY, f64::NEG_INFINITY), f64::NEG_INFINITY);
        assert_eq!(ln_add_exp(f64::NEG_INFINITY, 3.0), 3.0);
    }

    #[test]
    fn wrapped_angles_stay_within_half_a_turn() {
        for k in -20..20 {
            let wrapped = wrap_angle(0.7 * f64::from(k));
            assert!(wrapped.abs() <= std::f64::consts::PI + 1e-12);
            assert!((sin(wrapped) - sin(0.7 * f64::from(k))).abs() < 1e-12);
        }
    }
}
