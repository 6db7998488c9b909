//! Exponential and logarithm for loops over clouds: short, without branches or tables, so that the compiler can run
//! several points at once. Plain f64 arithmetic in a fixed order, hence the same bits natively and in the browser.

use std::f64::consts::{LN_2, LOG2_E};

/// 1.5 · 2⁵²: adding it rounds to the nearest integer and leaves that integer in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// ln 2 with its last 32 bits cleared, so that a product with a small integer is exact, and the rest.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Exponent field of 1.0.
const ONE_BITS: u64 = 1023 << 52;
const EXPONENT_FIELD: u64 = 0xfff << 52;
/// Bits of √½: mantissas are taken from [√½, √2).
const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
/// 2⁵² as bits: or-ing a small integer into it makes the float 2⁵² + integer.
const TWO_52_BITS: u64 = 1075 << 52;
const TWO_52: f64 = 4_503_599_627_370_496.0;

/// eˣ, relative error below 1e-14; the argument is held within [-700, 700].
#[inline(always)]
pub(crate) fn fast_exp(x: f64) -> f64 {
    let x = if x > -700.0 { x } else { -700.0 };
    let x = if x < 700.0 { x } else { 700.0 };
    let rounded = x * LOG2_E + ROUNDER;
    let k = rounded - ROUNDER;
    let r = (x - k * LN_2_HIGH) - k * LN_2_LOW;
    // Taylor to r¹¹: |r| ≤ ln 2 / 2 leaves r¹²/12! < 7e-15. Summed in pairs, so that products need not wait.
    let (r2, r4) = (r * r, (r * r) * (r * r));
    let low = (1.0 + r) + r2 * (0.5 + r * (1.0 / 6.0));
    let middle = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5_040.0));
    let high = (1.0 / 40_320.0 + r * (1.0 / 362_880.0)) + r2 * (1.0 / 3_628_800.0 + r * (1.0 / 39_916_800.0));
    let sum = low + r4 * (middle + r4 * high);
    f64::from_bits(sum.to_bits().wrapping_add(rounded.to_bits() << 52))
}

/// ln x for normal positive x, absolute error below 1e-15 near 1 and relative error below 1e-15 elsewhere.
#[inline(always)]
pub(crate) fn fast_ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let shifted = bits.wrapping_sub(SQRT_HALF_BITS).wrapping_add(ONE_BITS);
    let exponent = f64::from_bits(TWO_52_BITS | (shifted >> 52)) - (TWO_52 + 1023.0);
    let m = f64::from_bits(bits.wrapping_sub(shifted & EXPONENT_FIELD).wrapping_add(ONE_BITS));
    // ln m = 2 artanh t, |t| ≤ 0.1716: the series to t¹⁷ leaves t¹⁹/9.5 < 4e-16.
    let t = (m - 1.0) / (m + 1.0);
    let s = t * t;
    let (s2, s4) = (s * s, (s * s) * (s * s));
    let low = (1.0 + s * (1.0 / 3.0)) + s2 * (1.0 / 5.0 + s * (1.0 / 7.0));
    let high = (1.0 / 9.0 + s * (1.0 / 11.0)) + s2 * (1.0 / 13.0 + s * (1.0 / 15.0));
    let sum = low + s4 * (high + s4 * (1.0 / 17.0));
    exponent * LN_2 + 2.0 * t * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::rng::Rng;

    #[test]
    fn exponentials_agree_with_the_reference_library() {
        let mut rng = Rng::new(1, 0);
        for _ in 0..20_000 {
            let x = rng.uniform(-690.0, 690.0);
            assert!((fast_exp(x) / math::exp(x) - 1.0).abs() < 2e-14, "at {x}");
        }
        assert_eq!(fast_exp(0.0), 1.0);
        assert!(fast_exp(-1e9) < 1e-300 && fast_exp(1e9).is_finite());
    }

    #[test]
    fn logarithms_agree_with_the_reference_library() {
        let mut rng = Rng::new(2, 0);
        for _ in 0..20_000 {
            let near = rng.uniform(0.5, 2.0);
            assert!((fast_ln(near) - math::ln(near)).abs() < 1e-15, "at {near}");
            let far = math::exp(rng.uniform(-600.0, 600.0));
            assert!((fast_ln(far) - math::ln(far)).abs() < 1e-15 * math::ln(far).abs() + 1e-15, "at {far}");
        }
        assert_eq!(fast_ln(1.0), 0.0);
    }
}
