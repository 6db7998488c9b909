//! What stood in the way of a motion, and of a phase.

use super::{PhaseKind, Try};
use crate::collision::{CollisionError, Hit};

/// Why a motion cannot be made, where that was seen.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocked {
    /// For a person.
    pub(super) reason: String,
    /// Names of what touches.
    pub(super) culprits: Vec<String>,
    /// Positions of the arm's joints there; empty if there is no such place.
    pub(super) q: Vec<f64>,
}

impl Blocked {
    /// A reason without a place.
    pub(super) fn because(reason: impl Into<String>) -> Self {
        Self { reason: reason.into(), ..Self::default() }
    }

    /// Two things touch at a configuration.
    pub(super) fn at(reason: impl Into<String>, hit: &Hit, q: &[f64]) -> Self {
        Self { reason: reason.into(), culprits: vec![hit.a.clone(), hit.b.clone()], q: q.to_vec() }
    }

    /// In a phase, with the hand empty or not.
    pub(super) fn in_phase(self, phase: PhaseKind, carries: bool) -> Setback {
        Setback { phase, carries, blocked: self }
    }
}

/// The phase that could not be done, and why.
#[derive(Clone, Debug)]
pub(super) struct Setback {
    pub(super) phase: PhaseKind,
    pub(super) carries: bool,
    pub(super) blocked: Blocked,
}

impl Setback {
    /// Bodies that make no sense.
    pub(super) fn of(phase: PhaseKind, error: &CollisionError) -> Self {
        Blocked::because(error.to_string()).in_phase(phase, false)
    }

    /// What is told of a grasp; `fingers` are the positions of the hand's joints in that phase.
    pub(super) fn told(self, grasp: u32, fingers: &[f64]) -> Try {
        let Self { phase, carries, blocked: Blocked { reason, culprits, mut q } } = self;
        if !q.is_empty() {
            q.extend_from_slice(fingers);
        }
        Try { grasp: Some(grasp), phase: Some(phase), reason, culprits, q, carries, arm: None, X_WO: None }
    }
}
