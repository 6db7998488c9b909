//! The scene: the document that people save and share.

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::fit::FitSettings;
use crate::grasp::{GraspSettings, RankSettings};
use crate::robot::{HandDescription, HandError};
use crate::segment::SegmentSettings;

/// Version of the format that this program writes.
pub const SCENE_VERSION: u32 = 1;

/// Everything that a plan is computed from, except the robot's files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Format version, [`SCENE_VERSION`].
    pub version: u32,
    /// Short name: `mustard`.
    pub name: String,
    /// What a person reads: `Alita picks the mustard bottle`.
    pub title: String,
    /// One sentence for the gallery.
    pub summary: String,
    /// Robot: `crichton` or `alita`.
    pub robot: String,
    /// Arm that acts.
    pub arm: ArmChoice,
    /// Posture (of the SRDF) from which the robot starts.
    pub posture: String,
    /// Table top in the world.
    pub table: TableTop,
    /// Objects on the table; the one named by `task.object` is grasped.
    pub objects: Vec<PlacedObject>,
    /// Boxes that stand in the way and are known to the robot.
    pub obstacles: Vec<Obstacle>,
    /// Pose of the RGB-D camera's optical frame C (x right, y down, z forward) in the world.
    pub X_WC: Isometry3<f64>,
    /// What to do.
    pub task: Task,
    /// Seed of everything random.
    pub seed: u64,
    /// Settings of the segmentation.
    #[serde(default)]
    pub segment: SegmentSettings,
    /// Settings of the fit.
    #[serde(default)]
    pub fit: FitSettings,
    /// Settings of the grasp synthesis.
    #[serde(default)]
    pub grasp: GraspSettings,
    /// How grasps are ranked.
    #[serde(default)]
    pub rank: RankSettings,
    /// Whether a joint between the robot's base and its arms (Crichton's torso) moves with the arm.
    #[serde(default)]
    pub torso: bool,
    /// A hand of the user's own at the acting arm, instead of the robot's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hand: Option<HandDescription>,
}

/// Which arm acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ArmChoice {
    Left,
    Right,
}

impl ArmChoice {
    /// Name of the arm's group in the SRDF.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// The top of a table: a slab whose upper face is at `height_m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableTop {
    /// Centre of the upper face in the world's x and y, metres.
    pub center_m: [f64; 2],
    /// Extent along x and y, metres.
    pub size_m: [f64; 2],
    /// Height of the upper face, metres.
    pub height_m: f64,
    /// Thickness, metres.
    pub thickness_m: f64,
}

/// A household object at a pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedObject {
    /// Name of the object's file in `objects/`: `mustard_bottle`.
    pub object: String,
    /// Pose of the object's frame O in the world.
    pub X_WO: Isometry3<f64>,
}

/// A box that is known to the robot: a shelf, a crate, a block to put things on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// What reasons call it.
    pub name: String,
    /// Edge lengths, metres.
    pub size_m: Vector3<f64>,
    /// Pose of its centre in the world.
    pub X_WB: Isometry3<f64>,
}

/// What the robot shall do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Task {
    /// Grasp the object and lift it.
    Pick {
        /// Index into `objects`.
        object: usize,
    },
    /// Move the object: a motion of its pose, expressed in the world, applied to wherever it was found.
    PickAndPlace {
        /// Index into `objects`.
        object: usize,
        /// Goal pose of the object's frame O in the world.
        X_WO_goal: Isometry3<f64>,
    },
}

impl Task {
    /// Index of the object that is grasped.
    pub fn object(&self) -> usize {
        match self {
            Self::Pick { object } | Self::PickAndPlace { object, .. } => *object,
        }
    }
}

/// Why a scene file is not taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Not JSON, or not our fields.
    #[error("not a scene: {reason}")]
    Format { reason: String },
    /// Written by a later program.
    #[error("the scene has version {found}; this program reads version {SCENE_VERSION}")]
    Version { found: u32 },
    /// A number outside its range.
    #[error("{place}: found {found}, wanted {wanted}")]
    Value { place: String, found: String, wanted: String },
    /// Its hand.
    #[error("hand: {0}")]
    Hand(#[from] HandError),
}

/// Largest number of objects or obstacles in a scene.
pub const MAX_THINGS: usize = 200;
/// A described object this close to a fit gives the fit its name and its colour, metres.
const SAME_OBJECT_M: f64 = 0.08;
/// Most surface samples per object are made at this density.
pub const MAX_DENSITY: f64 = 80.0;
/// Most rolls of the hand per sample.
pub const MAX_ROLLS: f64 = 36.0;
/// Most stand-off depths per sample.
pub const MAX_DEPTHS: f64 = 10.0;
/// Most poses for one success probability.
pub const MAX_NOISE_TRIALS: f64 = 1000.0;
/// Most arm angles of an IK set.
pub const MAX_ARM_ANGLES: f64 = 360.0;
/// Largest weight in a score.
pub const MAX_WEIGHT: f64 = 100.0;
/// Nothing stands farther than this from the robot, metres.
const MAX_COORDINATE_M: f64 = 10.0;

impl Scene {
    /// The described object that stands where a fit is: the one nearest to it on the table, within 8 cm.
    pub fn object_at(&self, X_WS: &Isometry3<f64>) -> Option<&PlacedObject> {
        let apart = |placed: &PlacedObject| (placed.X_WO.translation.vector.xy() - X_WS.translation.vector.xy()).norm();
        let near = self.objects.iter().filter(|placed| apart(placed) < SAME_OBJECT_M);
        near.min_by(|l, r| apart(l).total_cmp(&apart(r)))
    }

    /// Gives the acting arm a hand of the user's own, and the contacts its friction where that is known.
    pub fn set_hand(&mut self, hand: HandDescription) {
        if let Some(friction) = hand.friction {
            self.grasp.friction = friction;
        }
        self.hand = Some(hand);
    }

    /// Reads a scene from JSON and checks it; rotations are brought to unit length.
    ///
    /// # Errors
    /// [`SceneError`] naming the place, what was found and what was wanted.
    pub fn parse(json: &str) -> Result<Self, SceneError> {
        let scene: Self =
            serde_json::from_str(json).map_err(|error| SceneError::Format { reason: error.to_string() })?;
        scene.checked()
    }

    /// The scene with unit rotations, or what is wrong with it.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn checked(mut self) -> Result<Self, SceneError> {
        if self.version != SCENE_VERSION {
            return Err(SceneError::Version { found: self.version });
        }
        for (list, count) in [("objects", self.objects.len()), ("obstacles", self.obstacles.len())] {
            check(count <= MAX_THINGS, list, count, format!("at most {MAX_THINGS}"))?;
        }
        let table = &self.table;
        for (name, value) in
            [("size_m[0]", table.size_m[0]), ("size_m[1]", table.size_m[1]), ("thickness_m", table.thickness_m)]
        {
            check(value > 0.0 && value < MAX_COORDINATE_M, &format!("table.{name}"), value, "between 0 and 10".into())?;
        }
        for (name, value) in
            [("center_m[0]", table.center_m[0]), ("center_m[1]", table.center_m[1]), ("height_m", table.height_m)]
        {
            check(value.abs() < MAX_COORDINATE_M, &format!("table.{name}"), value, "within 10 m".into())?;
        }
        checked_pose("X_WC", &mut self.X_WC)?;
        for (index, object) in self.objects.iter_mut().enumerate() {
            checked_pose(&format!("objects[{index}].X_WO"), &mut object.X_WO)?;
        }
        for (index, obstacle) in self.obstacles.iter_mut().enumerate() {
            checked_pose(&format!("obstacles[{index}].X_WB"), &mut obstacle.X_WB)?;
            let fits = obstacle.size_m.iter().all(|s| *s > 0.0 && *s < MAX_COORDINATE_M);
            check(fits, &format!("obstacles[{index}].size_m"), obstacle.size_m, "between 0 and 10".into())?;
        }
        let object = self.task.object();
        check(object < self.objects.len(), "task.object", object, format!("below {}", self.objects.len()))?;
        if let Task::PickAndPlace { X_WO_goal, .. } = &mut self.task {
            checked_pose("task.X_WO_goal", X_WO_goal)?;
        }
        check(
            self.fit.voxel_m.is_finite() && self.fit.voxel_m >= 0.0,
            "fit.voxel_m",
            self.fit.voxel_m,
            "0 or more".into(),
        )?;
        self.check_grasping()?;
        if let Some(hand) = &self.hand {
            hand.check()?;
        }
        Ok(self)
    }

    fn check_grasping(&self) -> Result<(), SceneError> {
        let (grasp, rank) = (&self.grasp, &self.rank);
        let range = |low: f64, high: f64| format!("from {low} to {high}");
        for (place, value, low, high) in [
            ("grasp.density", f64::from(grasp.density), 1.0, MAX_DENSITY),
            ("grasp.rolls", f64::from(grasp.rolls), 1.0, MAX_ROLLS),
            ("grasp.depths", f64::from(grasp.depths), 1.0, MAX_DEPTHS),
            ("grasp.palm_gap_m", grasp.palm_gap_m, 0.0, 0.1),
            ("grasp.fingertip_depth_m", grasp.fingertip_depth_m, 0.0, 0.1),
            ("grasp.friction", grasp.friction, 0.01, 5.0),
            ("grasp.noise.trials", f64::from(grasp.noise.trials), 0.0, MAX_NOISE_TRIALS),
            ("grasp.noise.position_m", grasp.noise.position_m, 0.0, 0.1),
            ("grasp.noise.rotation_rad", grasp.noise.rotation_rad, 0.0, 1.0),
            ("grasp.filter.min_clearance_m", grasp.filter.min_clearance_m, 0.0, 1.0),
            ("rank.arm_angles", rank.arm_angles as f64, 1.0, MAX_ARM_ANGLES),
            ("rank.weights.m_g_goal", rank.weights.m_g_goal, 0.0, MAX_WEIGHT),
            ("rank.weights.m_g_start", rank.weights.m_g_start, 0.0, MAX_WEIGHT),
            ("rank.weights.ik_count", rank.weights.ik_count, 0.0, MAX_WEIGHT),
            ("rank.weights.epsilon", rank.weights.epsilon, 0.0, MAX_WEIGHT),
            ("rank.weights.success", rank.weights.success, 0.0, MAX_WEIGHT),
            ("rank.weights.clearance", rank.weights.clearance, 0.0, MAX_WEIGHT),
        ] {
            check((low..=high).contains(&value), place, value, range(low, high))?;
        }
        if let Some(cone) = &grasp.filter.approach {
            let length = cone.axis_W.norm();
            check(length.is_finite() && length > 1e-9, "grasp.filter.approach.axis_W", length, "a direction".into())?;
            let place = "grasp.filter.approach.half_angle_rad";
            let pi = std::f64::consts::PI;
            check((0.0..=pi).contains(&cone.half_angle_rad), place, cone.half_angle_rad, range(0.0, pi))?;
        }
        if let Some(region) = &grasp.filter.region {
            let is_finite = region.center_W.iter().chain(&region.half_m).all(|x| x.abs() < MAX_COORDINATE_M);
            check(is_finite, "grasp.filter.region", region, "numbers within 10 m".into())?;
        }
        Ok(())
    }
}

fn check(holds: bool, place: &str, found: impl std::fmt::Debug, wanted: String) -> Result<(), SceneError> {
    if holds { Ok(()) } else { Err(SceneError::Value { place: place.to_owned(), found: format!("{found:?}"), wanted }) }
}

fn checked_pose(place: &str, X: &mut Isometry3<f64>) -> Result<(), SceneError> {
    let t = X.translation.vector;
    check(t.iter().all(|c| c.abs() < MAX_COORDINATE_M), place, t, "coordinates within 10 m".into())?;
    let quaternion = *X.rotation.quaternion();
    let norm = quaternion.norm();
    check(norm.is_finite() && norm > 1e-6, place, norm, "a rotation of length 1".into())?;
    X.rotation = nalgebra::UnitQuaternion::new_unchecked(quaternion / norm);
    Ok(())
}
