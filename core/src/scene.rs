//! The scene: the document that people save and share.

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

use crate::fit::FitSettings;
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
