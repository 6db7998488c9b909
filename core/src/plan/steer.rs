//! Single steps of a search: where to look next, and how to get there.

use super::space::{ArmSpace, distance_rad, lerp};
use crate::collision::Scratch;
use crate::rng::Rng;

/// Share of a step by which a step must come nearer.
const PROGRESS: f64 = 0.25;

/// Longest step where nothing may tilt, rad, and by how much it is longer per radian of tilt that is allowed.
const LEVEL_STEP_RAD: f64 = 0.2;
const LEVEL_STEP_PER_RAD: f64 = 1.0;

impl ArmSpace {
    /// A random configuration: uniform within the limits, or an upright pose of the hand where something must be kept
    /// upright (of uniform configurations only one in hundreds would be).
    pub(crate) fn draw(&self, rng: &mut Rng, q_random: &mut [f64]) {
        if let Some(q) = self.upright.as_ref().and_then(|upright| upright.drawn(rng)) {
            q_random.copy_from_slice(&q);
            return;
        }
        for (value, (lower, upper)) in q_random.iter_mut().zip(self.lower.iter().zip(&self.upper)) {
            *value = rng.uniform(*lower, *upper);
        }
    }

    /// The longest straight step, no more than `most_rad`: while something is kept upright motions must bend.
    pub(crate) fn step_rad(&self, most_rad: f64) -> f64 {
        match &self.upright {
            None => most_rad,
            Some(upright) => most_rad.min(LEVEL_STEP_RAD + LEVEL_STEP_PER_RAD * upright.max_tilt_rad()),
        }
    }

    /// The configuration one step towards another one, upright again if need be; `None` if that comes no nearer.
    pub(crate) fn step_towards(&self, from: &[f64], to: &[f64], step_rad: f64) -> Option<Vec<f64>> {
        let gap = distance_rad(from, to);
        if gap <= step_rad {
            return Some(to.to_vec());
        }
        let straight = lerp(from, to, step_rad / gap);
        let Some(upright) = &self.upright else { return Some(straight) };
        let raised = upright.raised(&straight, step_rad)?;
        (distance_rad(&raised, to) <= gap - PROGRESS * step_rad).then_some(raised)
    }

    /// Free steps from one configuration to another, without the first and the last, where the straight motion tilts
    /// too far; `None` without anything to keep upright, or where the steps do not arrive.
    pub(crate) fn steered(&self, scratch: &mut Scratch, from: &[f64], to: &[f64]) -> Option<Vec<Vec<f64>>> {
        self.upright.as_ref()?;
        let step_rad = self.step_rad(f64::INFINITY);
        let mut between: Vec<Vec<f64>> = Vec::new();
        loop {
            let at = between.last().map_or(from, Vec::as_slice);
            let next = self.step_towards(at, to, step_rad)?;
            if !self.edge_is_free(scratch, at, &next) {
                return None;
            }
            if next == to {
                return Some(between);
            }
            between.push(next);
        }
    }
}
