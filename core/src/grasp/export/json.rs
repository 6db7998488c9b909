//! One array with one object per grasp: every quantity, poses, contacts, fingers, status.

use nalgebra::Isometry3;
use serde_json::{Map, Value, json};

use super::{GraspExport, pose};
use crate::grasp::{Grasp, Quantity, Situated};
use crate::robot::Joint;

impl GraspExport<'_> {
    /// The grasps as a JSON array, one object per line.
    pub(super) fn json(&self) -> String {
        let joints = self.finger_joints();
        let rows: Vec<String> = self.ranked().map(|(rank, grasp)| self.row(rank, grasp, &joints).to_string()).collect();
        format!("[\n{}\n]\n", rows.join(",\n"))
    }

    fn row(&self, rank: Option<usize>, grasp: &Grasp, joints: &[&Joint]) -> Value {
        let mut row = Map::new();
        let mut put = |name: &str, value: Value| {
            let _new = row.insert(name.to_owned(), value);
        };
        put("rank", json!(rank));
        put("id", json!(grasp.id));
        put("part", json!(grasp.part));
        put("object", json!(self.object));
        put("robot", json!(self.robot.name));
        put("arm", json!(self.arm.name));
        put("status", json!(grasp.status.name()));
        put("reason", json!(grasp.status.reason()));
        for quantity in Quantity::ALL {
            put(quantity.name(), json!(quantity.of(grasp)));
        }
        put("success_trials", json!(grasp.success.map(|success| success.trials)));
        put("score_terms", json!(grasp.score.as_ref().map(|score| &score.terms)));
        put("object_from_hand", pose_json(&grasp.X_OH));
        put("world_from_hand_start", pose_json(&(self.X_WO_start * grasp.X_OH)));
        let at_goal = self.X_WO_goal.map(|X_WO| pose_json(&(X_WO * grasp.X_OH)));
        put("world_from_hand_goal", json!(at_goal));
        let fingers: Map<String, Value> =
            joints.iter().zip(&grasp.closed).map(|(joint, &q)| (joint.name.clone(), json!(q))).collect();
        put("fingers", Value::Object(fingers));
        let contacts: Vec<Value> = grasp
            .contacts
            .iter()
            .map(|contact| {
                json!({
                    "link": contact.link,
                    "position_m": contact.p_O.coords.as_slice(),
                    "normal": contact.n_O.as_slice(),
                    "penetration_m": contact.penetration_m,
                })
            })
            .collect();
        // The number of contacts is a quantity of that name, so the list has another one.
        put("contact_list", Value::Array(contacts));
        put("start", situated(grasp.start.as_ref()));
        put("goal", situated(grasp.goal.as_ref()));
        Value::Object(row)
    }
}

fn pose_json(X: &Isometry3<f64>) -> Value {
    let [x, y, z, qx, qy, qz, qw] = pose(X);
    json!({ "position_m": [x, y, z], "rotation_xyzw": [qx, qy, qz, qw] })
}

/// The IK set in short: its best configuration, and what was turned away.
fn situated(set: Option<&Situated>) -> Value {
    let Some(set) = set else { return Value::Null };
    let best = set.manipulability.iter().zip(&set.solutions).max_by(|l, r| l.0.total_cmp(r.0));
    let rejected: Vec<Value> =
        set.rejected.iter().map(|(reason, count)| json!({ "reason": reason.to_string(), "count": count })).collect();
    json!({ "best_q": best.map(|(_, q)| q), "best_manipulability": best.map(|(m, _)| m), "rejected": rejected })
}
