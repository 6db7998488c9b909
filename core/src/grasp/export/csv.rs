//! One line per grasp; a head with the units in the names, empty cells for what is not known (RFC 4180).

use super::{GraspExport, pose};
use crate::grasp::Quantity;
use crate::robot::JointKind;

/// What follows the name of a frame pair in the heads of a pose.
const POSE: [&str; 7] = ["x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"];

impl GraspExport<'_> {
    /// The grasps as CSV.
    pub(super) fn csv(&self) -> String {
        let joints = self.finger_joints();
        let mut heads: Vec<String> = ["rank", "id", "part", "status", "reason"].map(str::to_owned).to_vec();
        heads.extend(Quantity::ALL.map(|quantity| quantity.name().to_owned()));
        heads.push("success_trials".to_owned());
        for frames in ["object_from_hand", "world_from_hand_start", "world_from_hand_goal"] {
            heads.extend(POSE.map(|part| format!("{frames}_{part}")));
        }
        heads.extend(joints.iter().map(|joint| {
            let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
            format!("{}_{unit}", joint.name)
        }));
        let mut text = line(&heads);
        for (rank, grasp) in self.ranked() {
            let mut cells = vec![
                rank.map_or_else(String::new, |rank| rank.to_string()),
                grasp.id.to_string(),
                grasp.part.to_string(),
                grasp.status.name().to_owned(),
                grasp.status.reason(),
            ];
            cells.extend(Quantity::ALL.map(|quantity| quantity.of(grasp).map_or_else(String::new, number)));
            cells.push(grasp.success.map_or_else(String::new, |success| success.trials.to_string()));
            cells.extend(pose(&grasp.X_OH).map(number));
            cells.extend(pose(&(self.X_WO_start * grasp.X_OH)).map(number));
            match self.X_WO_goal {
                Some(X_WO) => cells.extend(pose(&(X_WO * grasp.X_OH)).map(number)),
                None => cells.extend(POSE.map(|_| String::new())),
            }
            cells.extend((0..joints.len()).map(|k| grasp.closed.get(k).copied().map_or_else(String::new, number)));
            text.push_str(&line(&cells));
        }
        text
    }
}

/// The shortest text that reads back as the same number; nothing for one that is not finite.
fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

fn line(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
    format!("{}\n", cells.join(","))
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}
