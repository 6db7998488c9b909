//! A plan as JSON lines: the same text natively and in the browser for the same seed.

use serde_json::{Value, json};

use super::Plan;
use crate::robot::Robot;

/// One line per phase: joint names, sample times and positions, clearance and manipulability, SI units.
pub fn plan_json_lines(plan: &Plan, robot: &Robot) -> Vec<Value> {
    let joint_names: Vec<&str> =
        plan.dofs.iter().map(|&dof| robot.joints[robot.dof_joints[dof]].name.as_str()).collect();
    plan.phases
        .iter()
        .map(|phase| {
            let leg = &plan.legs[phase.leg];
            let grasp = &leg.grasp;
            let matrix = grasp.X_OH.to_homogeneous();
            let object_from_hand: Vec<f64> = (0..16).map(|k| matrix[(k / 4, k % 4)]).collect();
            json!({
                "phase": phase.kind.name(),
                "arm": leg.arm,
                "leg": phase.leg,
                "grasp": grasp.id,
                "object_from_hand": object_from_hand,
                "start_s": phase.start_s,
                "duration_s": phase.trajectory.duration_s(),
                "carries_object": phase.carries,
                "joint_names": joint_names,
                "times_s": phase.trajectory.times_s,
                "positions": phase.trajectory.positions,
                "manipulability": phase.manipulability,
                "clearance_m": phase.clearance_m,
                "closest": phase.closest,
            })
        })
        .collect()
}
