//! How a depth sensor errs.

use serde::{Deserialize, Serialize};

use crate::math;
use crate::rng::Rng;

/// Range and noise of a structured-light depth sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DepthNoise {
    /// Depths outside this interval are not measured, metres.
    pub range_m: [f64; 2],
    /// Deviation along the optical axis: `[s0, s1, z0]` gives `s0 + s1 (z - z0)²`, metres.
    pub axial: [f64; 3],
    /// Disparity is measured in steps of this size, pixels; 0 for none.
    pub disparity_step_px: f64,
    /// Focal length times baseline of the sensor's own optics, pixel metres: disparity is this over the depth.
    pub focal_baseline_px_m: f64,
    /// Surfaces seen at a larger angle between ray and normal are not measured, radians.
    pub max_incidence_rad: f64,
    /// At depth edges the measured ray wanders sideways with this deviation, pixels.
    pub edge_jitter_px: f64,
}

impl DepthNoise {
    /// PrimeSense Carmine 1.09: 0.35–1.4 m, fit of its datasheet, 1/8 pixel disparity at f = 575 px and b = 75 mm.
    pub fn carmine() -> Self {
        Self {
            range_m: [0.35, 1.4],
            axial: [0.000181, 0.00166, 0.1],
            disparity_step_px: 0.125,
            focal_baseline_px_m: 575.0 * 0.075,
            max_incidence_rad: 75.0 * std::f64::consts::PI / 180.0,
            edge_jitter_px: 0.8,
        }
    }

    /// A sensor without error that still cannot see nearer than 1 cm.
    pub fn none() -> Self {
        Self {
            range_m: [0.01, f64::MAX],
            axial: [0.0; 3],
            disparity_step_px: 0.0,
            focal_baseline_px_m: 1.0,
            max_incidence_rad: std::f64::consts::FRAC_PI_2,
            edge_jitter_px: 0.0,
        }
    }

    /// The depth that is measured for a true depth, or `None` out of range.
    pub(super) fn measure(&self, depth_m: f64, gauss: &mut Gauss) -> Option<f64> {
        let [s0, s1, z0] = self.axial;
        let deviation = s0 + s1 * (depth_m - z0) * (depth_m - z0);
        let mut depth = if deviation > 0.0 { depth_m + deviation * gauss.next() } else { depth_m };
        if self.disparity_step_px > 0.0 {
            let steps = self.focal_baseline_px_m / (depth * self.disparity_step_px);
            depth = self.focal_baseline_px_m / (steps.round() * self.disparity_step_px);
        }
        (depth >= self.range_m[0] && depth <= self.range_m[1]).then_some(depth)
    }
}

/// Gaussian numbers, two from each pair of uniform ones (Box and Muller).
pub(super) struct Gauss {
    rng: Rng,
    spare: Option<f64>,
}

impl Gauss {
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        Self { rng: Rng::new(seed, stream), spare: None }
    }

    pub(super) fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * math::ln(1.0 - self.rng.unit())).sqrt();
        let (sin, cos) = math::sin_cos(std::f64::consts::TAU * self.rng.unit());
        self.spare = Some(radius * sin);
        radius * cos
    }
}
