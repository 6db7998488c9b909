//! Support function and bounding boxes: closed-form for plain shapes, one search along z for deformed ones.

use nalgebra::{Isometry3, Point3, Vector3};

use super::superellipse::unit_point;
use super::{AxesGauge, Superquadric, fast_exp};

/// Steps of the search along the profile from pole to pole; even, so that edges and poles are among them.
const STEPS: u32 = 128;
/// Rounds of the golden section: each shortens the bracket of two steps by 0.618, to 1e-10 of a step in the end.
const ROUNDS: u32 = 48;
/// What is added to the result of a search so that it bounds, in sums of the semi-axes.
const SEARCH_MARGIN: f64 = 1e-6;

impl Superquadric {
    /// Support function in F about the centre: the largest `d · (p - centre)` over the body, metres for a unit `d`.
    ///
    /// The base body is a unit ball of nested ℓp norms with `p = 2/e`; its support function is the dual norm, the same
    /// formula with semi-axes 1/a, 1/b, 1/c and exponents `2 - e`. For a tapered or bent body this gives each section's
    /// support, and the best section is searched for: the result is never below the true support and above it by at
    /// most 2e-6 (a + b + c) |d|, so a body that seems to stand 1 µm above a table may touch it, not sink in.
    pub fn support(&self, d_F: &Vector3<f64>) -> f64 {
        let size = d_F.norm();
        if size == 0.0 {
            return 0.0;
        }
        let d_S = self.X_FS.rotation.inverse_transform_vector(d_F);
        if self.is_deformed() {
            return self.searched_support(&d_S) + SEARCH_MARGIN * size * (self.a + self.b + self.c);
        }
        let dual = AxesGauge::new([1.0 / self.a, 1.0 / self.b, 1.0 / self.c], [2.0 - self.e1, 2.0 - self.e2]);
        fast_exp(dual.at([d_S.x, d_S.y, d_S.z]).ln_rho)
    }

    /// The largest support of a section, over all heights z of the base.
    ///
    /// A section at angle `φ = κz` has its own x and y axes turned by φ, so its support is that of a superellipse with
    /// the semi-axes a and b times ring and taper, in the turned direction, plus the reach of the bent z axis.
    fn searched_support(&self, d_S: &Vector3<f64>) -> f64 {
        let map = self.deformation();
        let section = AxesGauge::new([1.0 / self.a, 1.0 / self.b, 1.0], [1.0, 2.0 - self.e2]);
        // From the south pole, -1, to the north pole, 1, by polar angle in quarter turns.
        let reach = |turn: f64| {
            let [ring, height] = unit_point(std::f64::consts::FRAC_PI_2 * turn.abs(), self.e1);
            let z = self.c * height.copysign(turn);
            let axis = map.at_base(&Point3::new(0.0, 0.0, z));
            let (sin, cos) = (axis.tapered.sin, axis.tapered.cos);
            let (across, toward) = (d_S.x, d_S.y * cos - d_S.z * sin);
            let flat =
                if across == 0.0 && toward == 0.0 { 0.0 } else { fast_exp(section.at([across, toward, 0.0]).ln_rho) };
            d_S.dot(&map.deformed(&Point3::new(0.0, 0.0, z)).coords) + axis.scale.value * ring * flat
        };
        let step = 2.0 / f64::from(STEPS);
        let samples: Vec<f64> = (0..=STEPS).map(|k| reach(f64::from(k) * step - 1.0)).collect();
        let best = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut support = best;
        for (k, value) in samples.iter().enumerate() {
            let is_peak = (k == 0 || samples[k - 1] <= *value) && (k + 1 == samples.len() || samples[k + 1] <= *value);
            // Peaks this far below the best one do not overtake it within a step.
            if is_peak && *value > best - 0.05 * (best.abs() + self.a + self.b) {
                let at = k as f64 * step - 1.0;
                support = support.max(golden_maximum(&reach, (at - step).max(-1.0), (at + step).min(1.0)));
            }
        }
        support
    }

    /// Lowest and highest corner of the axis-aligned bounding box in a frame G, given the pose of F in G.
    ///
    /// As tight as [`Superquadric::support`], and never too small.
    pub fn bounding_box_in(&self, X_GF: &Isometry3<f64>) -> (Point3<f64>, Point3<f64>) {
        let (low, high) = self.extents_in(X_GF);
        let center = X_GF * Point3::from(self.X_FS.translation.vector);
        (center - low, center + high)
    }

    /// How far the body reaches from its centre down and up each axis of G, metres.
    fn extents_in(&self, X_GF: &Isometry3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let along = |axis: Vector3<f64>| self.support(&X_GF.rotation.inverse_transform_vector(&axis));
        let high = Vector3::new(along(Vector3::x()), along(Vector3::y()), along(Vector3::z()));
        if !self.is_deformed() {
            return (high, high);
        }
        (Vector3::new(along(-Vector3::x()), along(-Vector3::y()), along(-Vector3::z())), high)
    }

    /// Half the extents of the axis-aligned box in a frame G that is centred on the superquadric's centre and holds it,
    /// given the pose of F in G, metres.
    ///
    /// A deformed body lies on one side of its centre: [`Superquadric::bounding_box_in`] is tighter for it.
    pub fn half_extents_in(&self, X_GF: &Isometry3<f64>) -> Vector3<f64> {
        let (low, high) = self.extents_in(X_GF);
        low.sup(&high)
    }

    /// [`Superquadric::half_extents_in`] for F itself.
    pub fn half_extents(&self) -> Vector3<f64> {
        self.half_extents_in(&Isometry3::identity())
    }
}

/// The largest value met by a golden-section search between two arguments.
fn golden_maximum(value: &impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (low, high);
    let (mut left, mut right) = (high - RATIO * (high - low), low + RATIO * (high - low));
    let (mut at_left, mut at_right) = (value(left), value(right));
    let mut best = at_left.max(at_right);
    for _ in 0..ROUNDS {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - RATIO * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + RATIO * (high - low);
            at_right = value(right);
        }
        best = best.max(at_left).max(at_right);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::bend_limit_per_m;
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
    fn support_of_deformed_shapes_is_the_farthest_point_of_a_fine_mesh() {
        let mut rng = Rng::new(13, 0);
        for _ in 0..40 {
            let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.2));
            let (e1, e2, taper) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9), rng.uniform(-0.95, 0.95));
            let X_FS = Isometry3::from_parts(nalgebra::Translation3::identity(), rng.rotation());
            let plain = Superquadric::new(axes[0], axes[1], axes[2], e1, e2, X_FS).unwrap();
            let most = bend_limit_per_m(plain.b, plain.c, taper);
            let s = plain.deformed(taper, rng.uniform(-most, most)).unwrap();
            let surface = s.mesh(40);
            for _ in 0..10 {
                let d = rng.direction();
                let farthest = surface.positions.iter().map(|p| d.dot(&p.coords)).max_by(f64::total_cmp).unwrap();
                let support = s.support(&d);
                // 320 columns and 160 rows: neighbours within 10 mm of each other, half of it squared over the radius.
                assert!(farthest <= support && support - farthest < 0.001, "{support} {farthest} {s:?}");
            }
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
