//! The scene: the document that people save and share.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::fit::FitSettings;
use crate::grasp::{GraspSettings, RankSettings};
use crate::handover::Handover;
use crate::robot::{HandDescription, HandError, MAX_LINKS, Robot, StartError};
use crate::segment::SegmentSettings;
use crate::task::MotionSettings;

/// Version of the format that this program writes.
pub const SCENE_VERSION: u32 = 2;

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
    /// Joints that start elsewhere than in that posture, by their names in the URDF: radians or metres.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub joints: BTreeMap<String, f64>,
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
    /// How the robot moves.
    #[serde(default)]
    pub motion: MotionSettings,
    /// Whether a joint between the robot's base and its arms (Crichton's torso) moves with the arm.
    #[serde(default)]
    pub torso: bool,
    /// The object goes through another hand on its way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub handover: Option<Handover>,
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
    /// The arm on the other side.
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

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

/// What the robot shall do with an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Index into `objects`.
    pub object: usize,
    /// Where it goes, one step after the other; without steps it is grasped and lifted.
    #[serde(default)]
    pub steps: Vec<Step>,
}

/// One place that the object goes to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// What happens there.
    #[serde(default)]
    pub action: Action,
    /// Goal pose of the object's frame O in the world: a motion of its pose, applied to wherever it was found.
    pub X_WO_goal: Isometry3<f64>,
    /// How far the object may end up from that pose.
    #[serde(default, skip_serializing_if = "Freedom::is_none")]
    pub freedom: Freedom,
    /// On the way there its upright axis stays within this of the vertical, rad: it may be full.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep_upright_rad: Option<f64>,
}

/// What happens to the object at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Action {
    /// It is put down and let go.
    #[default]
    Put,
    /// It is pushed there without being lifted, and let go.
    Slide,
    /// It is held there for a while, tilted if the pose is, and stays in the hand: pouring.
    Pour {
        /// How long, seconds.
        hold_s: f64,
    },
}

/// Soft goals: directions in which a goal pose may vary (thesis 8.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Freedom {
    /// Turn about the vertical to either side, rad; π leaves it free.
    pub yaw_rad: f64,
    /// Shift along the world's x and y to either side, metres.
    pub area_m: [f64; 2],
    /// Half angle of the cone of directions in which the object's upright axis may point, rad.
    pub cone_rad: f64,
}

impl Freedom {
    /// Whether only the pose itself will do.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl Task {
    /// Grasp it and lift it.
    pub fn pick(object: usize) -> Self {
        Self { object, steps: Vec::new() }
    }

    /// Put it there.
    pub fn place(object: usize, X_WO_goal: Isometry3<f64>) -> Self {
        Self { object, steps: vec![Step::put(X_WO_goal)] }
    }

    /// The pose of the last step.
    pub fn X_WO_goal(&self) -> Option<&Isometry3<f64>> {
        self.steps.last().map(|step| &step.X_WO_goal)
    }
}

impl Step {
    /// Put it there and let go.
    pub fn put(X_WO_goal: Isometry3<f64>) -> Self {
        Self { action: Action::Put, X_WO_goal, freedom: Freedom::default(), keep_upright_rad: None }
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
/// Most steps of a task.
pub const MAX_STEPS: usize = 8;
/// Longest time that something is held, seconds.
const MAX_HOLD_S: f64 = 60.0;
/// Largest weight in a score.
pub const MAX_WEIGHT: f64 = 100.0;
/// Dividing a quaternion by its norm leaves it this close to length 1: a few roundings of f64.
const UNIT_ROUND_OFF: f64 = 1e-15;
/// Nothing stands farther than this from the robot, metres.
const MAX_COORDINATE_M: f64 = 10.0;

impl Scene {
    /// The described object that stands where a fit is: the one nearest to it on the table, within 8 cm.
    pub fn object_at(&self, X_WS: &Isometry3<f64>) -> Option<&PlacedObject> {
        let apart = |placed: &PlacedObject| (placed.X_WO.translation.vector.xy() - X_WS.translation.vector.xy()).norm();
        let near = self.objects.iter().filter(|placed| apart(placed) < SAME_OBJECT_M);
        near.min_by(|l, r| apart(l).total_cmp(&apart(r)))
    }

    /// Where the robot's joints start, one value per degree of freedom.
    ///
    /// # Errors
    /// [`StartError`] if the robot lacks the posture or a joint, or a joint would start outside of its limits.
    pub fn q_start(&self, robot: &Robot) -> Result<Vec<f64>, StartError> {
        robot.start(&self.posture, &self.joints)
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
        check(self.joints.len() <= MAX_LINKS, "joints", self.joints.len(), format!("at most {MAX_LINKS}"))?;
        for (name, value) in &self.joints {
            check(value.is_finite(), &format!("joints.{name}"), value, "a finite number".into())?;
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
        let object = self.task.object;
        check(object < self.objects.len(), "task.object", object, format!("below {}", self.objects.len()))?;
        let steps = self.task.steps.len();
        check(steps <= MAX_STEPS, "task.steps", steps, format!("at most {MAX_STEPS}"))?;
        for (index, step) in self.task.steps.iter_mut().enumerate() {
            step.check(&format!("task.steps[{index}]"))?;
        }
        self.motion.check()?;
        check(
            self.fit.voxel_m.is_finite() && self.fit.voxel_m >= 0.0,
            "fit.voxel_m",
            self.fit.voxel_m,
            "0 or more".into(),
        )?;
        self.check_grasping()?;
        if let Some(handover) = &mut self.handover {
            handover.check()?;
        }
        if let Some(hand) = &self.hand {
            hand.check()?;
        }
        Ok(self)
    }

    fn check_grasping(&self) -> Result<(), SceneError> {
        let (grasp, rank) = (&self.grasp, &self.rank);
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
            check_range(place, value, low, high)?;
        }
        if let Some(cone) = &grasp.filter.approach {
            let length = cone.axis_W.norm();
            check(length.is_finite() && length > 1e-9, "grasp.filter.approach.axis_W", length, "a direction".into())?;
            let place = "grasp.filter.approach.half_angle_rad";
            check_range(place, cone.half_angle_rad, 0.0, std::f64::consts::PI)?;
        }
        if let Some(region) = &grasp.filter.region {
            let is_finite = region.center_W.iter().chain(&region.half_m).all(|x| x.abs() < MAX_COORDINATE_M);
            check(is_finite, "grasp.filter.region", region, "numbers within 10 m".into())?;
        }
        Ok(())
    }
}

impl Step {
    fn check(&mut self, place: &str) -> Result<(), SceneError> {
        checked_pose(&format!("{place}.X_WO_goal"), &mut self.X_WO_goal)?;
        // Half a turn, and a little for those who type 3.1416.
        let pi = std::f64::consts::PI + 1e-4;
        let [x_m, y_m] = self.freedom.area_m;
        let hold_s = if let Action::Pour { hold_s } = self.action { hold_s } else { 0.0 };
        for (name, value, high) in [
            ("freedom.yaw_rad", self.freedom.yaw_rad, pi),
            ("freedom.area_m[0]", x_m, 1.0),
            ("freedom.area_m[1]", y_m, 1.0),
            ("freedom.cone_rad", self.freedom.cone_rad, pi),
            ("keep_upright_rad", self.keep_upright_rad.unwrap_or(0.0), pi),
            ("action.hold_s", hold_s, MAX_HOLD_S),
        ] {
            check_range(&format!("{place}.{name}"), value, 0.0, high)?;
        }
        Ok(())
    }
}

/// A number that has to lie between two others.
pub(crate) fn check_range(place: &str, value: f64, low: f64, high: f64) -> Result<(), SceneError> {
    check((low..=high).contains(&value), place, value, format!("from {low} to {high}"))
}

fn check(holds: bool, place: &str, found: impl std::fmt::Debug, wanted: String) -> Result<(), SceneError> {
    if holds { Ok(()) } else { Err(SceneError::Value { place: place.to_owned(), found: format!("{found:?}"), wanted }) }
}

/// A pose within the room, its rotation brought to unit length.
pub(crate) fn checked_pose(place: &str, X: &mut Isometry3<f64>) -> Result<(), SceneError> {
    let t = X.translation.vector;
    check(t.iter().all(|c| c.abs() < MAX_COORDINATE_M), place, t, "coordinates within 10 m".into())?;
    let quaternion = *X.rotation.quaternion();
    let norm = quaternion.norm();
    check(norm.is_finite() && norm > 1e-6, place, norm, "a rotation of length 1".into())?;
    // What is a unit quaternion already keeps its last digits, so that a scene that is written and read stays the same.
    if (norm - 1.0).abs() > UNIT_ROUND_OFF {
        X.rotation = nalgebra::UnitQuaternion::new_unchecked(quaternion / norm);
    }
    Ok(())
}
