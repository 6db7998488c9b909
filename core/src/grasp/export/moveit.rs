//! `moveit_msgs/Grasp` messages of ROS 2 as YAML, as `rosidl_runtime_py` reads them.
//!
//! MoveIt wants as `grasp_pose` the pose of the link that carries the hand (`parent_link` of the SRDF's end effector),
//! not of the hand itself: that is the flange E, so `X_WE = X_WO X_OH X_HE` is written, in the robot's root frame.

use std::fmt::Write as _;

use nalgebra::{Isometry3, Vector3};

use super::{GraspExport, pose};
use crate::grasp::Grasp;
use crate::robot::Joint;

impl GraspExport<'_> {
    /// The accepted grasps as a YAML list, best first.
    pub(super) fn moveit_yaml(&self) -> String {
        let accepted: Vec<&Grasp> = self.grasps.iter().filter(|grasp| grasp.is_accepted()).collect();
        let mut text = format!(
            "# moveit_msgs/Grasp (ROS 2): {} accepted grasps of {} with the {} arm of {}, best first.\n",
            accepted.len(),
            one_line(self.object),
            one_line(&self.arm.name),
            one_line(&self.robot.name)
        );
        if accepted.is_empty() {
            text.push_str("[]\n");
        }
        let X_WL = self.robot.link_poses(&vec![0.0; self.robot.dof_count()]);
        // Both links are fixed to each other, so any posture gives the same.
        let X_HE = X_WL[self.arm.hand.tcp_link].inv_mul(&X_WL[self.arm.flange_link]);
        let ways = self.ways;
        let root = &self.robot.links[0].name;
        let hand = &self.robot.links[self.arm.hand.tcp_link].name;
        let joints = self.finger_joints();
        for (index, grasp) in accepted.iter().enumerate() {
            let share = 1.0 - index as f64 / accepted.len() as f64;
            // A random order has no quantity: its places then keep the order.
            let quality = self.ranked_by.map_or(Some(share), |quantity| quantity.of(grasp));
            let mut out = Message { text: &mut text, indent: 1 };
            out.item("id", &quote(&format!("{} {}", self.object, grasp.id)));
            out.posture("pre_grasp_posture", &joints, &self.arm.hand.open);
            out.posture("grasp_posture", &joints, &grasp.closed);
            out.pose("grasp_pose", root, &(self.X_WO_start * grasp.X_OH * X_HE));
            out.field("grasp_quality", &number(quality.unwrap_or(0.0)));
            let along = Vector3::z();
            out.translation("pre_grasp_approach", hand, &along, ways.approach_m, ways.min_approach_m);
            out.translation("post_grasp_retreat", root, &Vector3::z(), ways.lift_m, ways.lift_m);
            out.translation("post_place_retreat", hand, &-along, ways.approach_m, ways.min_approach_m);
            out.field("max_contact_force", &number(0.0));
            out.field("allowed_touch_objects", &format!("[{}]", quote(self.object)));
        }
        text
    }
}

/// A message that is being written, as one item of a list.
struct Message<'a> {
    text: &'a mut String,
    indent: usize,
}

impl Message<'_> {
    fn item(&mut self, name: &str, value: &str) {
        // Writing into a string cannot fail.
        let _ = writeln!(self.text, "- {name}: {value}");
    }

    fn field(&mut self, name: &str, value: &str) {
        let indent = "  ".repeat(self.indent);
        let gap = if value.is_empty() { "" } else { " " };
        let _ = writeln!(self.text, "{indent}{name}:{gap}{value}");
    }

    fn group(&mut self, name: &str, fields: impl FnOnce(&mut Message<'_>)) {
        self.field(name, "");
        fields(&mut Message { text: self.text, indent: self.indent + 1 });
    }

    fn header(&mut self, frame: &str) {
        let stamp = "{sec: 0, nanosec: 0}";
        self.field("header", &format!("{{stamp: {stamp}, frame_id: {}}}", quote(frame)));
    }

    /// A `trajectory_msgs/JointTrajectory` of one point.
    fn posture(&mut self, name: &str, joints: &[&Joint], positions: &[f64]) {
        let joints: Vec<String> = joints.iter().map(|joint| quote(&joint.name)).collect();
        let positions: Vec<String> = positions.iter().map(|&q| number(q)).collect();
        self.group(name, |out| {
            out.header("");
            out.field("joint_names", &format!("[{}]", joints.join(", ")));
            out.field("points", "");
            out.indent += 1;
            out.field("- positions", &format!("[{}]", positions.join(", ")));
            out.indent += 1;
            for name in ["velocities", "accelerations", "effort"] {
                out.field(name, "[]");
            }
            out.field("time_from_start", "{sec: 0, nanosec: 0}");
        });
    }

    /// A `geometry_msgs/PoseStamped`.
    fn pose(&mut self, name: &str, frame: &str, X: &Isometry3<f64>) {
        let [x, y, z, qx, qy, qz, qw] = pose(X).map(number);
        self.group(name, |out| {
            out.header(frame);
            out.group("pose", |out| {
                out.field("position", &format!("{{x: {x}, y: {y}, z: {z}}}"));
                out.field("orientation", &format!("{{x: {qx}, y: {qy}, z: {qz}, w: {qw}}}"));
            });
        });
    }

    /// A `moveit_msgs/GripperTranslation`.
    fn translation(&mut self, name: &str, frame: &str, direction: &Vector3<f64>, desired_m: f64, min_m: f64) {
        let [x, y, z] = [direction.x, direction.y, direction.z].map(number);
        self.group(name, |out| {
            out.group("direction", |out| {
                out.header(frame);
                out.field("vector", &format!("{{x: {x}, y: {y}, z: {z}}}"));
            });
            out.field("desired_distance", &number(desired_m));
            out.field("min_distance", &number(min_m));
        });
    }
}

/// A number that every YAML reader takes for one: with a point and without an exponent; 0 if it is not finite.
fn number(value: f64) -> String {
    // Nanometres and billionths of a quaternion.
    if value.is_finite() { format!("{value:.9}") } else { "0.0".to_owned() }
}

/// A double-quoted scalar; JSON's escapes are all escapes of YAML too.
fn quote(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Text for a comment: whatever would end its line becomes a space.
fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}
