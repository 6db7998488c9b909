//! Ranked grasps as text for other programs: JSON with everything, CSV for tables, YAML messages for MoveIt.

mod csv;
mod json;
mod moveit;

use nalgebra::Isometry3;

use super::{Grasp, Quantity};
use crate::robot::{Arm, Joint, Robot};

/// Ranked grasps and what they are told in.
pub struct GraspExport<'a> {
    /// Grasps in their order of rank, accepted ones first.
    pub grasps: &'a [Grasp],
    /// The robot whose root frame is W.
    pub robot: &'a Robot,
    /// The arm that grasps.
    pub arm: &'a Arm,
    /// Name of the object.
    pub object: &'a str,
    /// Pose of the object frame O in W at the start.
    pub X_WO_start: Isometry3<f64>,
    /// Pose of O in W at the goal, if there is one.
    pub X_WO_goal: Option<Isometry3<f64>>,
    /// What the order is made from; `None` for a random one.
    pub ranked_by: Option<Quantity>,
    /// Straight ways before and after the grasp.
    pub ways: StraightWays,
}

/// Lengths of the straight ways that belong to a grasp, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightWays {
    /// Of the open hand before it closes and after it opens.
    pub approach_m: f64,
    /// The shortest of these that still counts.
    pub min_approach_m: f64,
    /// Of the object up from where it stands.
    pub lift_m: f64,
}

/// A format of the export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// One array of objects with everything that is known of each grasp.
    Json,
    /// One line per grasp, units in the names of the columns.
    Csv,
    /// A list of `moveit_msgs/Grasp` messages (ROS 2), of the accepted grasps alone.
    Yaml,
}

impl ExportFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Json, Self::Csv, Self::Yaml];

    /// What a file of it ends in, without the point.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::Csv => "csv",
            Self::Yaml => "yaml",
        }
    }

    /// The format of a file by its name; `yml` counts as YAML.
    pub fn of_file(name: &str) -> Option<Self> {
        let extension = name.rsplit_once('.')?.1.to_ascii_lowercase();
        let extension = if extension == "yml" { "yaml" } else { extension.as_str() };
        Self::ALL.into_iter().find(|format| format.extension() == extension)
    }
}

impl GraspExport<'_> {
    /// The grasps as text of a format, ending in a line break.
    pub fn text(&self, format: ExportFormat) -> String {
        match format {
            ExportFormat::Json => self.json(),
            ExportFormat::Csv => self.csv(),
            ExportFormat::Yaml => self.moveit_yaml(),
        }
    }

    /// Each grasp with its rank, from 1, if it has one.
    fn ranked(&self) -> impl Iterator<Item = (Option<usize>, &Grasp)> {
        self.grasps.iter().enumerate().map(|(index, grasp)| (grasp.is_accepted().then_some(index + 1), grasp))
    }

    /// The joints that [`Grasp::closed`] speaks of.
    fn finger_joints(&self) -> Vec<&Joint> {
        let dofs = self.arm.hand.fingers.iter().flatten();
        dofs.map(|&dof| &self.robot.joints[self.robot.dof_joints[dof]]).collect()
    }
}

/// A pose as `[x, y, z, qx, qy, qz, qw]`.
fn pose(X: &Isometry3<f64>) -> [f64; 7] {
    let (t, r) = (X.translation.vector, X.rotation.coords);
    [t.x, t.y, t.z, r.x, r.y, r.z, r.w]
}

#[cfg(test)]
mod tests;
