//! Plots of a plan over time: manipulability and clearance, and every joint with its limits.

use endcomfort_core::robot::Robot;
use endcomfort_core::scene::Scene;
use endcomfort_core::task::{Phase, PhaseKind, Plan};

use super::chart::{Axis, Chart, Line, Sheet, Strip};
use super::{TEAL, hex};
use crate::viewer::{ArmJoint, Curve, curve_samples, phase_color};

/// `#rrggbb` of a phase on a light ground.
fn color_of(kind: PhaseKind) -> String {
    hex(phase_color(kind, false).to_normalized_gamma_f32())
}

fn strips(plan: &Plan) -> Vec<Strip> {
    let strip = |phase: &Phase| Strip {
        from: phase.start_s,
        to: phase.start_s + phase.trajectory.duration_s(),
        color: color_of(phase.kind),
    };
    plan.phases.iter().map(strip).collect()
}

/// The kinds of phases in the order in which they first come; those of one colour share an entry.
fn key(plan: &Plan) -> Vec<(String, String)> {
    let mut key: Vec<(String, String)> = Vec::new();
    for phase in &plan.phases {
        let (name, color) = (phase.kind.name(), color_of(phase.kind));
        match key.iter_mut().find(|(_, known)| *known == color) {
            Some((names, _)) if names.split(", ").all(|known| known != name) => {
                names.push_str(", ");
                names.push_str(name);
            }
            Some(_) => {}
            None => key.push((name.to_owned(), color)),
        }
    }
    key
}

fn time_axis(plan: &Plan) -> Axis {
    Axis::new("time, s", 0.0, plan.duration_s().max(1e-3))
}

/// Samples of a phase's measure over the whole plan, in a unit.
fn measured(plan: &Plan, of: fn(&Phase) -> &[f64], per_si: f64) -> Vec<(f64, f64)> {
    let of_phase = |phase: &Phase| {
        let times = phase.trajectory.times_s.iter().map(|t| phase.start_s + t);
        times.zip(of(phase).iter().map(|value| per_si * value)).collect::<Vec<_>>()
    };
    plan.phases.iter().flat_map(of_phase).filter(|(_, value)| value.is_finite()).collect()
}

/// Manipulability and clearance.
pub(super) fn timeline(plan: &Plan) -> Sheet {
    let chart = |title: &str, label: &str, points: Vec<(f64, f64)>| {
        let top = points.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        Chart {
            title: title.to_owned(),
            x: time_axis(plan),
            y: Axis::new(label, 0.0, if top > 0.0 { 1.08 * top } else { 1.0 }),
            lines: vec![Line { name: String::new(), color: TEAL.to_owned(), width: 1.8, points }],
            bars: Vec::new(),
            limits: Vec::new(),
            strips: strips(plan),
        }
    };
    Sheet {
        title: "Manipulability and clearance over the plan".to_owned(),
        key: key(plan),
        charts: vec![
            chart("Manipulability of the arm", "m(q)", measured(plan, |phase| &phase.manipulability, 1.0)),
            chart("Distance to whatever is nearest", "mm", measured(plan, |phase| &phase.clearance_m, 1e3)),
        ],
        shares_x: true,
        height: 150.0,
    }
}

/// One curve of every joint of the arm, with its limits.
///
/// # Errors
/// A clause when the plan belongs to another robot.
pub(super) fn joints(plan: &Plan, robot: &Robot, scene: &Scene, curve: Curve) -> Result<Sheet, String> {
    let solution = plan.grasp().start.as_ref().and_then(|start| start.solutions.first());
    let joints = ArmJoint::of(plan, robot, scene, solution.map_or(7, Vec::len));
    if joints.is_empty() {
        return Err("the plan belongs to another robot".to_owned());
    }
    let chart = |(column, joint): (usize, &ArmJoint)| {
        let (unit, per_si) = joint.unit(curve);
        let points: Vec<(f64, f64)> =
            curve_samples(plan, column, curve).into_iter().map(|(t, value)| (t, per_si * value)).collect();
        let (lower, upper) = joint.limits[curve as usize];
        let limits = vec![per_si * lower, per_si * upper];
        let values = points.iter().map(|(_, value)| *value).chain(limits.iter().copied());
        Chart {
            title: format!("{}, {unit}", joint.name),
            x: time_axis(plan),
            y: Axis::around("", values),
            lines: vec![Line { name: String::new(), color: TEAL.to_owned(), width: 1.6, points }],
            bars: Vec::new(),
            limits,
            strips: strips(plan),
        }
    };
    Ok(Sheet {
        title: format!("{} of the joints, limits dashed", curve.title()),
        key: key(plan),
        charts: joints.iter().enumerate().map(chart).collect(),
        shares_x: true,
        height: 76.0,
    })
}
