//! Tasks: from an intent ("pick it", "place it there") to a list of timed phases, or a typed refusal.

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::grasp::Grasp;
use crate::plan::Trajectory;

/// A played plan: the phases one after the other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the arm that moves.
    pub arm: String,
    /// The grasp that is used.
    pub grasp: Grasp,
    /// Phases in the order of time.
    pub phases: Vec<Phase>,
    /// Full joint positions before the first phase, all degrees of freedom of the robot.
    pub q_start: Vec<f64>,
    /// Degrees of freedom of the arm, then of the hand, as indices into `q`: the columns of every trajectory.
    pub dofs: Vec<usize>,
    /// Grasps tried before this one, each with the reason it failed.
    pub failed_grasps: Vec<(u32, String)>,
}

/// What happens in a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PhaseKind {
    Reach,
    Close,
    Lift,
    Transport,
    Place,
    Open,
    Retreat,
}

impl PhaseKind {
    /// The word in JSON and on the timeline.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reach => "reach",
            Self::Close => "close",
            Self::Lift => "lift",
            Self::Transport => "transport",
            Self::Place => "place",
            Self::Open => "open",
            Self::Retreat => "retreat",
        }
    }
}

/// One phase of a plan.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Phase {
    /// What happens.
    pub kind: PhaseKind,
    /// When it starts, seconds from the start of the plan.
    pub start_s: f64,
    /// Motion of the plan's `dofs`, its time starting at 0.
    pub trajectory: Trajectory,
    /// Whether the hand carries the object.
    pub carries: bool,
    /// Manipulability (5.1) of each sample.
    pub manipulability: Vec<f64>,
    /// Smallest distance to anything, metres, of each sample.
    pub clearance_m: Vec<f64>,
}

/// State of everything that moves at one time.
#[derive(Clone, Debug)]
pub struct PlanState {
    /// All degrees of freedom.
    pub q: Vec<f64>,
    /// Pose of the object O in the world.
    pub X_WO: Isometry3<f64>,
    /// Phase index.
    pub phase: usize,
}
