//! Seeded random numbers: ChaCha8, the same stream on every platform.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::math;

/// A stream of random numbers that depends on the seed and the stream's name alone.
pub struct Rng {
    source: ChaCha8Rng,
}

impl Rng {
    /// The stream `stream` of `seed`; different streams of one seed are independent.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut source = ChaCha8Rng::seed_from_u64(seed);
        source.set_stream(stream);
        Self { source }
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.source.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [lo, hi).
    pub fn uniform(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Uniform index below `count`, which must be greater than 0.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Gaussian with mean 0 and deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * math::ln(1.0 - self.unit())).sqrt();
        radius * math::cos(std::f64::consts::TAU * self.unit())
    }

    /// Uniform direction on the unit sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        let z = self.uniform(-1.0, 1.0);
        let (sin, cos) = math::sin_cos(self.uniform(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vector3::new(r * cos, r * sin, z)
    }

    /// Uniform rotation (Shoemake 1992).
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let u = self.unit();
        let (s1, c1) = math::sin_cos(std::f64::consts::TAU * self.unit());
        let (s2, c2) = math::sin_cos(std::f64::consts::TAU * self.unit());
        let (r1, r2) = ((1.0 - u).sqrt(), u.sqrt());
        UnitQuaternion::from_quaternion(Quaternion::new(r2 * c2, r1 * s1, r1 * c1, r2 * s2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_seeds_give_equal_streams_and_streams_differ() {
        let draw = |seed, stream| {
            let mut rng = Rng::new(seed, stream);
            (0..8).map(|_| rng.unit()).collect::<Vec<_>>()
        };
        assert_eq!(draw(7, 0), draw(7, 0));
        assert_ne!(draw(7, 0), draw(7, 1));
        assert_ne!(draw(7, 0), draw(8, 0));
    }

    #[test]
    fn normal_numbers_have_unit_deviation() {
        let mut rng = Rng::new(1, 0);
        let n = 20_000;
        let (sum, squares) = (0..n).map(|_| rng.normal()).fold((0.0, 0.0), |(s, q), x| (s + x, q + x * x));
        // Standard error of the mean is 1/√n ≈ 0.007, of the variance √(2/n) ≈ 0.01: four of each.
        assert!((sum / f64::from(n)).abs() < 0.03);
        assert!((squares / f64::from(n) - 1.0).abs() < 0.04);
    }
}
