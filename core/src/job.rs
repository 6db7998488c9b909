//! Requests, progress and results: what crosses the thread channel natively and `postMessage` in the browser.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

use crate::cloud::PointCloud;
use crate::fit::{Fit, ObjectiveKind};
use crate::grasp::{Grasp, Quality};
use crate::guest::GuestRobot;
use crate::object::HouseholdObject;
use crate::scene::Scene;
use crate::segment::{Plane, PointFate};
use crate::superquadric::Superquadric;
use crate::task::{Plan, Try};

/// Runs the pipeline for a scene; stages whose inputs did not change are answered from the last run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Request {
    /// Revision of the scene that this belongs to; results carry it back and stale ones are dropped.
    pub revision: u64,
    /// The scene.
    pub scene: Scene,
    /// A cloud that was dropped instead of the scene's own objects.
    pub cloud: Option<DroppedCloud>,
    /// The scene's robot, if somebody brought it.
    #[serde(with = "shared")]
    pub robot: Option<Arc<GuestRobot>>,
    /// Those of the scene's objects that somebody brought.
    #[serde(with = "shared_list")]
    pub objects: Vec<Arc<HouseholdObject>>,
    /// The cluster to grasp; `None` takes the one nearest to the task's object (largest, for a dropped cloud).
    pub cluster: Option<usize>,
    /// The grasp to plan with; `None` tries them in their order of rank.
    pub grasp: Option<u32>,
    /// A shape that a person set in place of a cluster's fit.
    pub shape: Option<SetShape>,
    /// The first stage that is told; earlier ones are computed where they must be, in silence.
    pub first: Stage,
    /// The last stage that is wanted.
    pub last: Stage,
    /// Instead of the stages: fits this cluster with each of the five objectives.
    pub compare: Option<usize>,
    /// Instead of the stages: builds reachability maps.
    pub map: Option<MapRequest>,
}

impl Request {
    /// All stages for a scene as it stands, revision 0.
    pub fn new(scene: Scene) -> Self {
        Self {
            revision: 0,
            scene,
            cloud: None,
            robot: None,
            objects: Vec::new(),
            cluster: None,
            grasp: None,
            shape: None,
            first: Stage::Scene,
            last: Stage::Plan,
            compare: None,
            map: None,
        }
    }
}

/// What is shared is written as itself.
mod shared {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<T: Serialize, S: Serializer>(value: &Option<Arc<T>>, to: S) -> Result<S::Ok, S::Error> {
        value.as_deref().serialize(to)
    }

    pub(super) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<Arc<T>>, D::Error> {
        Ok(Option::<T>::deserialize(from)?.map(Arc::new))
    }
}

/// A list of what is shared is written as itself.
mod shared_list {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<T: Serialize, S: Serializer>(list: &[Arc<T>], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(list.iter().map(AsRef::as_ref))
    }

    pub(super) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Vec<Arc<T>>, D::Error> {
        Ok(Vec::<T>::deserialize(from)?.into_iter().map(Arc::new).collect())
    }
}

/// A shape that a person set in place of a cluster's fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetShape {
    /// The cluster.
    pub cluster: usize,
    /// The shape, in W.
    pub superquadric: Superquadric,
}

/// Asks for the reachability maps of arms of the scene's robot, with the hand that the scene gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapRequest {
    /// Names of the arms; one map is built after the other.
    pub arms: Vec<String>,
    /// Whether the joint before the arm turns as well.
    pub torso: bool,
    /// Edge length of the voxels, metres.
    pub voxel_m: f64,
    /// Orientations of the hand that are told apart.
    pub orientations: usize,
    /// How the maps are built.
    pub method: MapMethod,
}

/// How a reachability map is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapMethod {
    /// Every pose is solved for the joints in closed form.
    Inverse,
    /// So many configurations are drawn.
    Forward {
        /// How many.
        samples: usize,
    },
}

/// A file that somebody dropped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DroppedCloud {
    /// File name.
    pub name: String,
    /// Its content.
    #[serde(with = "crate::bulk")]
    pub bytes: Vec<u8>,
}

/// The steps of the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    Scene,
    Segment,
    Fit,
    Grasps,
    Rank,
    Plan,
}

impl Stage {
    /// All stages in the order in which they run.
    pub const ALL: [Self; 6] = [Self::Scene, Self::Segment, Self::Fit, Self::Grasps, Self::Rank, Self::Plan];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Segment => "Segment",
            Self::Fit => "Fit",
            Self::Grasps => "Grasps",
            Self::Rank => "Rank",
            Self::Plan => "Plan",
        }
    }
}

/// What comes back while a request runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Update {
    /// A stage is under way: fraction in [0, 1] and a few words.
    Progress { revision: u64, stage: Stage, fraction: f64, note: String },
    /// A reachability map is being built: fraction in [0, 1] of all that were asked for, and a few words.
    Mapping { revision: u64, fraction: f64, note: String },
    /// A stage is done.
    Done { revision: u64, elapsed_ms: f64, output: Box<Output> },
    /// A stage cannot be done; later stages are not run.
    Refused { revision: u64, stage: Stage, refusal: Refusal },
    /// Nothing more will come for this request.
    Finished { revision: u64 },
}

/// What a stage gives; everything is in the world frame W.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Output {
    Scene(SceneOutput),
    Segment(SegmentOutput),
    Fit(FitOutput),
    Grasps(GraspsOutput),
    Rank(RankOutput),
    Plan(Box<Plan>),
    /// One of the fits of [`Request::compare`]; not a stage.
    Objective(Box<ObjectiveFit>),
    /// Qualities of the accepted grasps of [`Output::Rank`], once the plan stands; not a stage.
    Quality(Vec<Quality>),
    /// One of the maps of [`Request::map`], or the reason why there is none; not a stage.
    Map(Box<BuiltMap>),
}

/// A reachability map that was asked for.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BuiltMap {
    /// Name of the arm.
    pub arm: String,
    /// Whether the joint before the arm turned as well.
    pub torso: bool,
    /// The map as a file ([`crate::reach::ReachMap::to_bytes`]), or the reason why there is none.
    pub file: Result<Vec<u8>, String>,
}

/// The cloud that the robot sees.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SceneOutput {
    /// The cloud in W.
    pub cloud: PointCloud,
    /// Notes of the reader, or how the cloud was brought onto the robot's table.
    pub notes: Vec<String>,
}

/// Table, clusters and what became of each point.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SegmentOutput {
    /// The table plane in W.
    pub table: Plane,
    /// Fate of each point of the cloud.
    #[serde(with = "crate::bulk")]
    pub fates: Vec<PointFate>,
    /// Points of each cluster, in W, largest first.
    #[serde(with = "crate::bulk::lists")]
    pub clusters: Vec<Vec<Point3<f64>>>,
    /// The cluster that will be grasped.
    pub target: usize,
}

/// The fits of all clusters; the target's is grasped, the others are obstacles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FitOutput {
    /// One per cluster, or the reason why there is none.
    pub fits: Vec<Result<Fit, String>>,
    /// Index of the target.
    pub target: usize,
    /// Signed radial distance (3.4) of every point of every cluster from its fit, metres, negative inside; of several
    /// parts the nearest counts. Empty for a cluster without a fit.
    #[serde(with = "crate::bulk::lists")]
    pub distances_m: Vec<Vec<f64>>,
    /// The fit that a shape set by a person ([`Request::shape`]) stands in for.
    pub automatic: Option<Box<Fit>>,
}

/// What an objective made of a cluster.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ObjectiveFit {
    /// The cluster.
    pub cluster: usize,
    /// The objective.
    pub objective: ObjectiveKind,
    /// The fit, or the reason why there is none.
    pub fit: Result<Fit, String>,
}

/// Candidates after closing the hand and looking for collisions of the hand alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GraspsOutput {
    /// Name of the arm that they are for: that of the scene, or of a handover the one that gives.
    pub arm: String,
    /// All candidates, in the order of generation.
    pub grasps: Vec<Grasp>,
    /// Pose of the object frame O (axes of the target's fit) at the start, in W.
    pub X_WO_start: Isometry3<f64>,
    /// Pose of O at the goal, in W, if the task has one.
    pub X_WO_goal: Option<Isometry3<f64>>,
}

/// All candidates, ranked: accepted ones first, best first; then the others in the order of generation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RankOutput {
    /// All candidates.
    pub grasps: Vec<Grasp>,
    /// How many of them are accepted.
    pub accepted: usize,
}

/// Why a stage cannot be done, for a person.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// One sentence: what happened and what to do.
    pub message: String,
    /// Details, one per line.
    pub details: Vec<String>,
    /// What was tried, and why each failed; these can be shown in the scene.
    pub tries: Vec<Try>,
}

impl Refusal {
    /// One sentence.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), ..Self::default() }
    }

    /// With details, one per line.
    pub fn with_details(mut self, details: Vec<String>) -> Self {
        self.details = details;
        self
    }
}
