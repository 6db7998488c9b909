//! How the configuration of a pose is made from the few bits that a map keeps of it.

use nalgebra::Isometry3;

use super::closed::ClosedForm;
use crate::plan::low_discrepancy::EvenPoints;
use crate::rng::Rng;
use crate::robot::{Chain, JointLimit};

/// The seed chooses one of so many beginnings of the sequence.
const BEGINNINGS: usize = 1 << 24;

/// How configurations are kept.
#[derive(Clone, Debug)]
pub(super) enum Recipe {
    /// Position of the joint before the arm, arm angle and branch.
    Closed(Box<ClosedForm>),
    /// Number of the sample.
    Drawn(Samples),
}

impl Recipe {
    /// The configuration of a code; the pose is asked for only where it is needed.
    pub(super) fn configuration(&self, code: u32, pose: impl Fn() -> Option<Isometry3<f64>>) -> Option<Vec<f64>> {
        match self {
            Self::Closed(closed) => closed.configuration(&pose()?, code),
            Self::Drawn(samples) => {
                let mut q = Vec::new();
                samples.push(code, &mut q);
                Some(q)
            }
        }
    }
}

/// Configurations spread evenly over the limits of a chain, by number: `frac(½ + (first + k) α)`.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    pub(super) first: f64,
    pub(super) alpha: Vec<f64>,
    pub(super) lower: Vec<f64>,
    pub(super) span: Vec<f64>,
}

impl Samples {
    pub(super) fn of(chain: &Chain, seed: u64) -> Self {
        let of_limits = |value: fn(&JointLimit) -> f64| chain.limits().iter().map(value).collect::<Vec<f64>>();
        Self {
            first: Rng::new(seed, 0).index(BEGINNINGS) as f64,
            alpha: EvenPoints::new(chain.dofs().len()).alpha,
            lower: of_limits(|limit| limit.lower),
            span: of_limits(|limit| limit.upper - limit.lower),
        }
    }

    /// Adds a configuration.
    pub(super) fn push(&self, number: u32, q: &mut Vec<f64>) {
        let number = self.first + f64::from(number);
        q.extend((0..self.alpha.len()).map(|joint| self.position(joint, number)));
    }

    /// Position of a joint at a number counted from the beginning of the sequence.
    #[inline(always)]
    pub(super) fn position(&self, joint: usize, number: f64) -> f64 {
        let along = 0.5 + number * self.alpha[joint];
        self.lower[joint] + self.span[joint] * (along - along.floor())
    }
}
