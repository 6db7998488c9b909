//! A plan: timed phases, the grasps they use, and what was tried before.

use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

use crate::grasp::Grasp;
use crate::handover::HandoverReport;
use crate::plan::Trajectory;
use crate::robot::Robot;

/// A played plan: the phases one after the other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Plan {
    /// What happens between taking the object and letting it go, at least one; more than one when it is put down and
    /// grasped anew, or handed over.
    pub legs: Vec<Leg>,
    /// Phases in the order of time.
    pub phases: Vec<Phase>,
    /// Full joint positions before the first phase, all degrees of freedom of the robot.
    pub q_start: Vec<f64>,
    /// Degrees of freedom of the arm, then of its hand, as indices into `q`: the columns of every trajectory. If a second
    /// arm takes part, its own follow.
    pub dofs: Vec<usize>,
    /// What was tried before this, and why each failed.
    pub tries: Vec<Try>,
    /// Routes of the hand that were looked at ([`super::Planner::Routes`]).
    pub routes: Vec<Route>,
    /// How the place of the handover was chosen, if the object is handed over.
    #[serde(default)]
    pub handover: Option<Box<HandoverReport>>,
    /// How the trajectories were checked once more.
    pub certificate: Certificate,
}

/// One grasp and what is done with it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Leg {
    /// Name of the arm that does it.
    pub arm: String,
    /// Link index of its hand frame H.
    pub tcp_link: usize,
    /// The grasp that is used.
    pub grasp: Grasp,
    /// Pose of the object frame O in the world before it is grasped.
    pub X_WO_start: Isometry3<f64>,
    /// Pose of O once it is let go; equal to the last carried pose for a pick.
    pub X_WO_end: Isometry3<f64>,
}

/// What happens in a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PhaseKind {
    Reach,
    Close,
    Lift,
    Transport,
    Pour,
    Slide,
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
            Self::Pour => "pour",
            Self::Slide => "slide",
            Self::Place => "place",
            Self::Open => "open",
            Self::Retreat => "retreat",
        }
    }

    /// Whether its way was searched, as opposed to followed along a line.
    pub fn is_searched(self) -> bool {
        matches!(self, Self::Reach | Self::Transport)
    }

    /// Whether only the fingers move.
    pub fn is_of_fingers(self) -> bool {
        matches!(self, Self::Close | Self::Open)
    }
}

/// One phase of a plan.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Phase {
    /// What happens.
    pub kind: PhaseKind,
    /// Index of the leg that it belongs to.
    pub leg: usize,
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
    /// Names of the two that come closest in this phase; empty if there is nothing to come close to.
    pub closest: [String; 2],
}

/// Something that was tried in vain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Try {
    /// The grasp, by its number.
    pub grasp: Option<u32>,
    /// The phase that could not be done.
    pub phase: Option<PhaseKind>,
    /// Why, for a person.
    pub reason: String,
    /// Names of the links, obstacles or the object that stood in the way.
    pub culprits: Vec<String>,
    /// Positions of the plan's joints where that was seen, arm then fingers; empty if there is no such place.
    pub q: Vec<f64>,
    /// Whether the hand carried the object there.
    pub carries: bool,
    /// Name of the arm, if it is not the one that the scene names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<String>,
    /// Where the object stood, if neither at its start nor at its goal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub X_WO: Option<Isometry3<f64>>,
}

impl std::fmt::Display for Try {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(grasp) = self.grasp {
            write!(f, "grasp {grasp}: ")?;
        }
        if let Some(phase) = self.phase {
            write!(f, "{}: ", phase.name())?;
        }
        write!(f, "{}", self.reason)
    }
}

/// A route of the hand between two places: a way round things on one side or the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Route {
    /// Corners of the hand's way in the world.
    pub points_W: Vec<Point3<f64>>,
    /// Length of the hand's way, metres.
    pub length_m: f64,
    /// Smallest distance of hand and object from everything on the way, metres.
    pub clearance_m: f64,
    /// Time that the arm takes, seconds; `None` when it cannot follow.
    pub duration_s: Option<f64>,
    /// Why the arm cannot follow.
    pub refused: Option<String>,
    /// Whether the plan takes this one.
    pub chosen: bool,
}

/// How the trajectories of a plan were checked once more before it was given out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Certificate {
    /// Configurations looked at, none of which touches anything.
    pub states: usize,
    /// Configurations per sample of the trajectories.
    pub density: usize,
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
    /// In a hand: the link of its hand frame H, and the object's pose `X_HO` there.
    Carried { tcp_link: usize, X_HO: Isometry3<f64> },
}

impl Plan {
    /// The first grasp.
    pub fn grasp(&self) -> &Grasp {
        &self.legs[0].grasp
    }

    /// Pose of the object frame O in the world before it is grasped.
    pub fn X_WO_start(&self) -> &Isometry3<f64> {
        &self.legs[0].X_WO_start
    }

    /// Pose of O at the end; equal to the last carried pose for a pick.
    pub fn X_WO_end(&self) -> &Isometry3<f64> {
        &self.legs[self.legs.len() - 1].X_WO_end
    }

    /// Pose of the object O in the world in a state of this plan; a carried one follows from the robot's kinematics.
    pub fn object_pose(&self, robot: &Robot, state: &PlanState) -> Isometry3<f64> {
        match state.object {
            ObjectState::Standing(X_WO) => X_WO,
            ObjectState::Carried { tcp_link, X_HO } => robot.link_poses(&state.q)[tcp_link] * X_HO,
        }
    }

    /// Link index of the frame H of the hand that moves in a state.
    pub fn tcp_link(&self, state: &PlanState) -> usize {
        self.phases.get(state.phase).map_or(self.legs[0].tcp_link, |phase| self.legs[phase.leg].tcp_link)
    }

    /// Names of the arms that move, each once, in the order in which they begin.
    pub fn arms(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for leg in &self.legs {
            if !names.contains(&leg.arm.as_str()) {
                names.push(&leg.arm);
            }
        }
        names
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
            return PlanState { q, phase: 0, object: ObjectState::Standing(*self.X_WO_start()) };
        };
        for (&dof, position) in self.dofs.iter().zip(phase.trajectory.at(time_s - phase.start_s)) {
            q[dof] = position;
        }
        let leg = &self.legs[phase.leg];
        let was_carried = self.phases[..index].iter().any(|earlier| earlier.leg == phase.leg && earlier.carries);
        let object = if phase.carries {
            ObjectState::Carried { tcp_link: leg.tcp_link, X_HO: leg.grasp.X_OH.inverse() }
        } else if was_carried {
            ObjectState::Standing(leg.X_WO_end)
        } else {
            ObjectState::Standing(leg.X_WO_start)
        };
        PlanState { q, phase: index, object }
    }
}
