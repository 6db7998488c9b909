//! From a fitted object to ranked grasps, each with its reasons (thesis 4.2 and chapter 5).

mod bodies;
mod candidates;
mod close;
mod export;
mod hand;
mod obstruction;
mod quality;
mod quantity;
mod ranking;
mod settings;
mod situate;
mod success;
mod surfels;
mod volume;

pub use bodies::Touched;
pub use candidates::{HandHit, HandHits, candidates};
pub use export::{ExportFormat, GraspExport, StraightWays};
pub use hand::HandModel;
pub use obstruction::Obstruction;
pub use quality::epsilon;
pub use quantity::Quantity;
pub use ranking::{RankBy, RankSettings, Score, Term, Weights, rank};
pub use settings::{ApproachCone, ContactSurface, GraspFilter, GraspSettings, PoseNoise, Region, Unwanted};
pub use situate::Reach;
pub use success::Trials;
pub use surfels::Surfels;
pub use volume::volume;

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::robot::ik::Arc;

/// A hand pose at the object with closed fingers, or the reason why there is none.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Grasp {
    /// Number in the order of generation; the same seed and fit give the same number to the same grasp.
    pub id: u32,
    /// Body of the object that it started from: 0 is the main one, the others stand in the order of the fit.
    #[serde(default)]
    pub part: usize,
    /// Pose of the hand frame H in the object frame O (the fitted superquadric's axes S).
    pub X_OH: Isometry3<f64>,
    /// Finger positions after closing, in the order of `Hand::fingers` flattened.
    #[serde(with = "crate::bulk")]
    pub closed: Vec<f64>,
    /// Where the hand touches.
    pub contacts: Vec<Contact>,
    /// Distance between the outermost contacts along the closing direction, metres.
    pub width_m: f64,
    /// Largest-ball quality of the grasp wrench space (Ferrari and Canny 1992); 0 without force closure.
    pub epsilon: f64,
    /// Volume of the grasp wrench space in its six dimensions, forces and scaled torques without unit; `None` while it
    /// was not computed.
    #[serde(default)]
    pub volume: Option<f64>,
    /// How often it holds when the object is not quite where it was seen; `None` while that was not asked.
    #[serde(default)]
    pub success: Option<Success>,
    /// Smallest distance of the closed hand from table and neighbours at start and goal, metres; `None` while unknown.
    #[serde(default)]
    pub clearance_m: Option<f64>,
    /// The weighted score among the accepted grasps; `None` while they are not ranked by it.
    #[serde(default)]
    pub score: Option<Score>,
    /// The grasp at the start pose; `None` while it was not reached.
    pub start: Option<Situated>,
    /// The grasp at the stops between start and goal.
    #[serde(default)]
    pub via: Vec<Situated>,
    /// The grasp at the goal pose; `None` while it was not reached or there is no goal.
    pub goal: Option<Situated>,
    /// Accepted, or why not.
    pub status: GraspStatus,
}

impl Grasp {
    /// Forgets what was found out about the places of a task, for another task with the same start.
    pub(crate) fn forget_places(&mut self) {
        let is_of_a_place = matches!(
            self.status,
            GraspStatus::NoIkAtStart { .. }
                | GraspStatus::NoWayAtStart { .. }
                | GraspStatus::NoIkAtStep { .. }
                | GraspStatus::NoWayAtStep { .. }
                | GraspStatus::NoIkAtGoal { .. }
                | GraspStatus::NoWayAtGoal { .. }
        );
        if is_of_a_place {
            self.status = GraspStatus::Accepted;
        }
        (self.start, self.goal, self.clearance_m, self.score) = (None, None, None, None);
        self.via.clear();
    }

    /// The grasp at every stop of its task, the goal last; empty while it did not come so far or there is no goal.
    pub fn stops(&self) -> impl Iterator<Item = &Situated> {
        self.via.iter().chain(&self.goal)
    }

    /// Whether it may be used.
    pub fn is_accepted(&self) -> bool {
        self.status == GraspStatus::Accepted
    }
}

/// A place where the hand touches the object, in O.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Contact {
    /// Point on the object's surface, metres.
    pub p_O: Point3<f64>,
    /// Outward unit normal of the object there.
    pub n_O: Vector3<f64>,
    /// How far the hand's surface is inside the object's there, metres; negative for a gap that the pads close.
    #[serde(default)]
    pub penetration_m: f64,
    /// Link of the hand that touches.
    pub link: String,
}

/// Holds among the poses tried around the one that was seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Success {
    /// Poses at which the grasp held.
    pub held: u32,
    /// Poses tried, at least 1.
    pub trials: u32,
}

/// What takes longer to tell of an accepted grasp than everything else.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Number of the grasp.
    pub id: u32,
    /// See [`Grasp::success`].
    pub success: Option<Success>,
    /// See [`Grasp::volume`].
    pub volume: f64,
}

impl Quality {
    /// Writes qualities into the grasps that they belong to.
    pub fn put_all(qualities: &[Self], grasps: &mut [Grasp]) {
        for quality in qualities {
            if let Some(grasp) = grasps.iter_mut().find(|grasp| grasp.id == quality.id) {
                (grasp.success, grasp.volume) = (quality.success, Some(quality.volume));
            }
        }
    }
}

impl Success {
    /// Share of the poses at which the grasp held.
    pub fn probability(&self) -> f64 {
        f64::from(self.held) / f64::from(self.trials.max(1))
    }
}

/// A grasp with the object at one pose: the IK set and its mean manipulability.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Situated {
    /// Pose of the object in the world: of the poses that a soft goal allows, the one chosen.
    #[serde(default = "Isometry3::identity")]
    pub X_WO: Isometry3<f64>,
    /// How many poses a soft goal offered; 1 if it was not soft.
    #[serde(default)]
    pub poses: usize,
    /// Mean manipulability m_g over the collision-free IK set (5.2); 0 for an empty set.
    pub m_g: f64,
    /// N of (5.2): configurations that reach the grasp, within limits and without collision.
    pub ik_count: usize,
    /// The IK set: one value per joint of the arm ([`crate::robot::Arm::dofs`]) each, radians, in order of arm angle
    /// and branch.
    #[serde(with = "crate::bulk::lists")]
    pub solutions: Vec<Vec<f64>>,
    /// Manipulability (5.1) of each solution.
    #[serde(with = "crate::bulk")]
    pub manipulability: Vec<f64>,
    /// Arm angles that the joint limits allow, collisions not asked; empty for an arm without closed form.
    #[serde(default)]
    pub feasible: Vec<Arc>,
    /// Indices of solutions from which the hand can come and go straight with and without the object, the most
    /// manipulable first: as many as a planner needs, not all there are.
    #[serde(default)]
    pub with_ways: Vec<usize>,
    /// What was turned away: reason and count, most frequent first.
    pub rejected: Vec<(Obstruction, usize)>,
}

/// Why a grasp was accepted or dropped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum GraspStatus {
    /// Usable.
    Accepted,
    /// The object is wider across the fingers than the open hand.
    TooWide { width_m: f64, opening_m: f64 },
    /// Part of the hand is inside the object before the fingers close.
    HandInObject { link: String, depth_m: f64 },
    /// Fewer contacts than three after closing.
    TooFewContacts { found: usize, wanted: usize },
    /// Everything that touches is on one side of the object.
    OneSided { link: String },
    /// A hand link meets the table.
    HitsTable { link: String },
    /// A hand link meets another thing in the scene.
    HitsNeighbour { link: String, neighbour: String },
    /// No arm configuration reaches it at the start pose.
    NoIkAtStart { reason: Obstruction },
    /// No arm configuration reaches it at the goal pose.
    NoIkAtGoal { reason: Obstruction },
    /// It can be reached at the start, but no configuration comes to it straight or lifts the object from it.
    NoWayAtStart { reason: Obstruction },
    /// No arm configuration reaches it at a stop between start and goal, counted from 0.
    NoIkAtStep { step: usize, reason: Obstruction },
    /// It can be reached at such a stop, but no way leads on from there.
    NoWayAtStep { step: usize, reason: Obstruction },
    /// It can be reached at the goal, but no configuration lowers the object there or leaves it straight.
    NoWayAtGoal { reason: Obstruction },
    /// It is not among those that a person wants.
    Unwanted { wish: Unwanted },
}

impl GraspStatus {
    /// The variant's name as it stands in JSON.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::TooWide { .. } => "too_wide",
            Self::HandInObject { .. } => "hand_in_object",
            Self::TooFewContacts { .. } => "too_few_contacts",
            Self::OneSided { .. } => "one_sided",
            Self::HitsTable { .. } => "hits_table",
            Self::HitsNeighbour { .. } => "hits_neighbour",
            Self::NoIkAtStart { .. } => "no_ik_at_start",
            Self::NoIkAtStep { .. } => "no_ik_at_step",
            Self::NoWayAtStep { .. } => "no_way_at_step",
            Self::NoIkAtGoal { .. } => "no_ik_at_goal",
            Self::NoWayAtStart { .. } => "no_way_at_start",
            Self::NoWayAtGoal { .. } => "no_way_at_goal",
            Self::Unwanted { .. } => "unwanted",
        }
    }

    /// The reason in a few words; empty when accepted.
    pub fn reason(&self) -> String {
        match self {
            Self::Accepted => String::new(),
            Self::TooWide { width_m, opening_m } => {
                format!("too wide: {:.0} mm, hand opens {:.0} mm", width_m * 1e3, opening_m * 1e3)
            }
            Self::HandInObject { link, depth_m } => format!("{link} is {:.0} mm inside the object", depth_m * 1e3),
            Self::TooFewContacts { found, wanted } => format!("{found} of {wanted} contacts"),
            Self::OneSided { link } => format!("only {link} touches, nothing opposes it"),
            Self::HitsTable { link } => format!("{link} hits the table"),
            Self::HitsNeighbour { link, neighbour } => format!("{link} hits {neighbour}"),
            Self::NoIkAtStart { reason } => format!("start: {reason}"),
            Self::NoIkAtStep { step, reason } => format!("step {}: {reason}", step + 1),
            Self::NoWayAtStep { step, reason } => format!("step {}, way on: {reason}", step + 1),
            Self::NoIkAtGoal { reason } => format!("goal: {reason}"),
            Self::NoWayAtStart { reason } => format!("start, way in or up: {reason}"),
            Self::NoWayAtGoal { reason } => format!("goal, way down or out: {reason}"),
            Self::Unwanted { wish } => wish.reason(),
        }
    }
}
