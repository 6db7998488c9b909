//! What a plan tells of its handover: the place that was chosen, and those that were not.

use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

use super::Comfort;

/// How the place of a handover was chosen. Everything is in the world frame W.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandoverReport {
    /// Names of the arms that give and take.
    pub arms: [String; 2],
    /// Shoulders of these arms, whose line the receiver's hand shall follow.
    pub shoulders: [Point3<f64>; 2],
    /// Edge of the voxels in which places were looked for, metres.
    pub voxel_m: f64,
    /// Grasps that serve the start (giver's) and the goal (receiver's).
    pub grasps: [usize; 2],
    /// Voxels that both hands reach well enough.
    pub voxels: usize,
    /// The places that can be used as far as the two hands and arms are concerned, best first.
    pub places: Vec<Place>,
    /// Index of the one that the plan uses.
    pub chosen: usize,
}

/// A place for a handover.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Centre of its voxel.
    pub voxel: Point3<f64>,
    /// Pose of the object.
    pub X_WO: Isometry3<f64>,
    /// Numbers of the grasps of giver and receiver.
    pub grasps: [u32; 2],
    /// Mean manipulability m_g (5.2) of giver and receiver with these grasps.
    pub m_g: [f64; 2],
    /// Angle between the receiver's approach and the line from its shoulder to the giver's, rad.
    pub off_line_rad: f64,
    /// Distance of the voxel from the segment between start and goal of the object, metres.
    pub off_way_m: f64,
    /// Whether the receiver gets the object by its handle.
    pub by_handle: bool,
    /// What it costs a person, if the receiver is one.
    pub comfort: Option<Comfort>,
    /// What it counts for among the others: the larger the better.
    pub score: f64,
    /// Why no plan came of it, if it was tried in vain.
    pub refused: Option<String>,
}
