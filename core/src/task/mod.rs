//! Tasks: from an intent ("pick it", "place it there") to a list of timed phases, or a typed refusal.

mod motion;
mod pick_and_place;
mod report;
mod workcell;

pub(crate) use motion::STRAIGHT_STEP_M;
pub use pick_and_place::{MotionSettings, PickAndPlace, plan_pick_and_place};
pub use report::plan_json_lines;
pub use workcell::{Situation, TARGET, Workcell, WorkcellError};

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::grasp::Grasp;
use crate::plan::Trajectory;
use crate::robot::Robot;

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
    /// Pose of the object frame O in the world before it is grasped.
    pub X_WO_start: Isometry3<f64>,
    /// Pose of O once it is let go; equal to the last carried pose for a pick.
    pub X_WO_end: Isometry3<f64>,
    /// Link index of the hand frame H.
    pub tcp_link: usize,
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
    /// Phase index.
    pub phase: usize,
    /// Where the object is.
    pub object: ObjectState,
}

/// Where the object is during a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectState {
    /// Standing, not yet grasped or let go again: its pose `X_WO`.
    Standing(Isometry3<f64>),
    /// In the hand: its pose `X_HO` in the hand frame.
    Carried(Isometry3<f64>),
}

impl Plan {
    /// Pose of the object O in the world in a state of this plan; a carried one follows from the robot's kinematics.
    pub fn object_pose(&self, robot: &Robot, state: &PlanState) -> Isometry3<f64> {
        match state.object {
            ObjectState::Standing(X_WO) => X_WO,
            ObjectState::Carried(X_HO) => robot.link_poses(&state.q)[self.tcp_link] * X_HO,
        }
    }

    /// Duration of all phases, seconds.
    pub fn duration_s(&self) -> f64 {
        self.phases.last().map_or(0.0, |phase| phase.start_s + phase.trajectory.duration_s())
    }

    /// Index of the phase at a time; the first before the start, the last after the end.
    pub fn phase_at(&self, time_s: f64) -> usize {
        self.phases.partition_point(|phase| phase.start_s <= time_s).saturating_sub(1)
    }

    /// Joints and object at a time, seconds from the start of the plan.
    pub fn state_at(&self, time_s: f64) -> PlanState {
        let mut q = self.q_start.clone();
        let index = self.phase_at(time_s);
        let Some(phase) = self.phases.get(index) else {
            return PlanState { q, phase: 0, object: ObjectState::Standing(self.X_WO_start) };
        };
        for (&dof, position) in self.dofs.iter().zip(phase.trajectory.at(time_s - phase.start_s)) {
            q[dof] = position;
        }
        let was_carried = self.phases[..index].iter().any(|earlier| earlier.carries);
        let object = if phase.carries {
            ObjectState::Carried(self.grasp.X_OH.inverse())
        } else if was_carried {
            ObjectState::Standing(self.X_WO_end)
        } else {
            ObjectState::Standing(self.X_WO_start)
        };
        PlanState { q, phase: index, object }
    }
}
