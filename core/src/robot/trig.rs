//! Sine and cosine for loops over configurations: short, without branches or tables, so that the compiler can run several
//! at once. Plain f64 arithmetic in a fixed order, hence the same bits natively and in the browser.

/// 1.5 · 2⁵²: adding it rounds to the nearest integer and leaves that integer in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// π/2 with its last 20 bits cleared, so that a product with a small integer is exact, and the rest.
const HALF_PI_HIGH: f64 = 1.570_796_326_734_125_6;
const HALF_PI_LOW: f64 = 6.077_100_506_506_192e-11;

/// (sin x, cos x), absolute error below 3e-16 for |x| ≤ 1000.
#[inline(always)]
pub(super) fn fast_sin_cos(x: f64) -> (f64, f64) {
    let rounded = x * std::f64::consts::FRAC_2_PI + ROUNDER;
    let quarters = rounded - ROUNDER;
    let r = (x - quarters * HALF_PI_HIGH) - quarters * HALF_PI_LOW;
    // Taylor: |r| ≤ π/4 leaves r¹⁷/17! < 5e-17 and r¹⁸/18! < 3e-18.
    let (s, s2) = (r * r, (r * r) * (r * r));
    let low = (1.0 / 362_880.0) + s * (-1.0 / 39_916_800.0);
    let high = (1.0 / 6_227_020_800.0) + s * (-1.0 / 1_307_674_368_000.0);
    let sine_tail = ((-1.0 / 6.0) + s * (1.0 / 120.0)) + s2 * ((-1.0 / 5_040.0) + s * (low + s2 * high));
    let sine = r + (r * s) * sine_tail;
    let low = (1.0 / 40_320.0) + s * (-1.0 / 3_628_800.0);
    let high = (1.0 / 479_001_600.0) + s * ((-1.0 / 87_178_291_200.0) + s * (1.0 / 20_922_789_888_000.0));
    let cosine_tail = (1.0 / 24.0) + s * ((-1.0 / 720.0) + s * (low + s2 * high));
    let cosine = (1.0 - 0.5 * s) + s2 * cosine_tail;
    // Quarter turns: odd ones swap the two, the second bit gives the signs.
    let bits = rounded.to_bits();
    let swap = 0_u64.wrapping_sub(bits & 1);
    let pick = |a: f64, b: f64| (a.to_bits() & !swap) | (b.to_bits() & swap);
    let sine_sign = (bits & 2) << 62;
    let cosine_sign = (bits.wrapping_add(1) & 2) << 62;
    (f64::from_bits(pick(sine, cosine) ^ sine_sign), f64::from_bits(pick(cosine, sine) ^ cosine_sign))
}

/// The same in single precision for |x| ≤ 100, absolute error below 3e-7.
#[inline(always)]
pub(super) fn fast_sin_cos_single(x: f32) -> (f32, f32) {
    // As above: 1.5 · 2²³, and π/2 in three parts whose products with a small integer are exact.
    const ROUNDER: f32 = 12_582_912.0;
    const PARTS: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    let rounded = x * std::f32::consts::FRAC_2_PI + ROUNDER;
    let quarters = rounded - ROUNDER;
    let r = ((x - quarters * PARTS[0]) - quarters * PARTS[1]) - quarters * PARTS[2];
    // Taylor: |r| ≤ π/4 leaves r¹¹/11! < 2e-9 and r¹⁰/10! < 3e-8.
    let s = r * r;
    let sine_tail = (-1.0 / 6.0) + s * ((1.0 / 120.0) + s * ((-1.0 / 5_040.0) + s * (1.0 / 362_880.0)));
    let sine = r + (r * s) * sine_tail;
    let cosine_tail = (1.0 / 24.0) + s * ((-1.0 / 720.0) + s * (1.0 / 40_320.0));
    let cosine = (1.0 - 0.5 * s) + (s * s) * cosine_tail;
    let bits = rounded.to_bits();
    let swap = 0_u32.wrapping_sub(bits & 1);
    let pick = |a: f32, b: f32| (a.to_bits() & !swap) | (b.to_bits() & swap);
    let sine_sign = (bits & 2) << 30;
    let cosine_sign = (bits.wrapping_add(1) & 2) << 30;
    (f32::from_bits(pick(sine, cosine) ^ sine_sign), f32::from_bits(pick(cosine, sine) ^ cosine_sign))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::rng::Rng;

    #[test]
    fn sines_and_cosines_agree_with_the_reference_library() {
        let mut rng = Rng::new(1, 0);
        for range in [0.8, 3.2, 10.0, 1000.0] {
            for _ in 0..20_000 {
                let x = rng.uniform(-range, range);
                let (sine, cosine) = fast_sin_cos(x);
                let (wanted_sine, wanted_cosine) = math::sin_cos(x);
                assert!((sine - wanted_sine).abs() < 3e-16, "sin {x}: {sine} {wanted_sine}");
                assert!((cosine - wanted_cosine).abs() < 3e-16, "cos {x}: {cosine} {wanted_cosine}");
            }
        }
        assert_eq!(fast_sin_cos(0.0), (0.0, 1.0));
    }

    #[test]
    fn those_of_single_precision_agree_to_its_last_digits() {
        let mut rng = Rng::new(2, 0);
        for range in [0.8, 3.2, 10.0, 100.0] {
            for _ in 0..20_000 {
                let x = rng.uniform(-range, range) as f32;
                let (sine, cosine) = fast_sin_cos_single(x);
                let (wanted_sine, wanted_cosine) = math::sin_cos(f64::from(x));
                assert!((f64::from(sine) - wanted_sine).abs() < 3e-7, "sin {x}: {sine} {wanted_sine}");
                assert!((f64::from(cosine) - wanted_cosine).abs() < 3e-7, "cos {x}: {cosine} {wanted_cosine}");
            }
        }
    }
}
