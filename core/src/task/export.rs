//! A plan's motion as text for other programs: CSV, JSON, and ROS `trajectory_msgs/JointTrajectory` as YAML.

use std::fmt::Write as _;

use super::{Phase, Plan, plan_json_lines};
use crate::robot::Robot;

/// A format for trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrajectoryFormat {
    /// A table with one line per sample.
    Csv,
    /// One JSON object per phase, in an array.
    Json,
    /// One message over all phases, as `ros2 topic pub` takes it.
    Yaml,
}

impl TrajectoryFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Csv, Self::Json, Self::Yaml];

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
            Self::Yaml => "yaml",
        }
    }

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Csv => "CSV",
            Self::Json => "JSON",
            Self::Yaml => "ROS JointTrajectory (YAML)",
        }
    }
}

/// The motion of a plan as text: joints in the order of [`Plan::dofs`], SI units, radians.
pub fn trajectory_text(plan: &Plan, robot: &Robot, format: TrajectoryFormat) -> String {
    match format {
        TrajectoryFormat::Csv => csv(plan, robot),
        TrajectoryFormat::Json => json(plan, robot),
        TrajectoryFormat::Yaml => yaml(plan, robot),
    }
}

/// One sample of the whole plan.
struct Sample<'a> {
    phase: &'a Phase,
    index: usize,
    time_s: f64,
    q: &'a [f64],
    /// First and second derivatives by central differences; phases begin and end at rest.
    v: Vec<f64>,
    a: Vec<f64>,
}

/// All samples in order; where one phase ends and the next begins there is one sample, that of the next.
fn samples(plan: &Plan) -> Vec<Sample<'_>> {
    let mut all = Vec::new();
    for (number, phase) in plan.phases.iter().enumerate() {
        let (times, positions) = (&phase.trajectory.times_s, &phase.trajectory.positions);
        let is_last = number + 1 == plan.phases.len();
        let count = times.len().min(positions.len());
        for index in 0..if is_last { count } else { count.saturating_sub(1) } {
            let q = &positions[index];
            let at = |k: usize| (times[k], &positions[k]);
            let (v, a) = match index.checked_sub(1).map(at).zip((index + 1 < count).then(|| at(index + 1))) {
                None => (vec![0.0; q.len()], vec![0.0; q.len()]),
                Some(((t0, q0), (t1, q1))) => {
                    let (before, after) = (times[index] - t0, t1 - times[index]);
                    let v = q0.iter().zip(q1).map(|(q0, q1)| (q1 - q0) / (before + after)).collect();
                    let bend = |((q0, q), q1): ((&f64, &f64), &f64)| {
                        ((q1 - q) / after - (q - q0) / before) / (0.5 * (before + after))
                    };
                    (v, q0.iter().zip(q).zip(q1).map(bend).collect())
                }
            };
            all.push(Sample { phase, index, time_s: phase.start_s + times[index], q, v, a });
        }
    }
    all
}

fn joint_names<'a>(plan: &Plan, robot: &'a Robot) -> Vec<&'a str> {
    plan.dofs.iter().map(|&dof| robot.joints[robot.dof_joints[dof]].name.as_str()).collect()
}

fn csv(plan: &Plan, robot: &Robot) -> String {
    let names = joint_names(plan, robot);
    let mut text = String::from("time_s,phase,leg,carries_object,manipulability,clearance_m");
    for (prefix, unit) in [("q", "rad"), ("v", "rad_per_s"), ("a", "rad_per_s2")] {
        names.iter().for_each(|name| {
            let _ = write!(text, ",{prefix}_{name}_{unit}");
        });
    }
    text.push('\n');
    for sample in samples(plan) {
        let Sample { phase, index, time_s, q, v, a } = sample;
        let (m, clearance_m) = (phase.manipulability.get(index), phase.clearance_m.get(index));
        let number = |value: Option<&f64>| value.map_or_else(String::new, f64::to_string);
        let _ = write!(text, "{time_s:.4},{},{},{}", phase.kind.name(), phase.leg, phase.carries);
        let _ = write!(text, ",{},{}", number(m), number(clearance_m.filter(|c| c.is_finite())));
        for value in q.iter().chain(&v).chain(&a) {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text
}

fn json(plan: &Plan, robot: &Robot) -> String {
    let lines: Vec<String> = plan_json_lines(plan, robot).iter().map(ToString::to_string).collect();
    format!("[\n{}\n]\n", lines.join(",\n"))
}

fn yaml(plan: &Plan, robot: &Robot) -> String {
    let list = |values: &[f64]| values.iter().map(|value| format!("{value:.9}")).collect::<Vec<_>>().join(", ");
    let mut text = format!("# trajectory_msgs/msg/JointTrajectory, arm: {}\n", plan.arms().join(" and "));
    text.push_str("header:\n  stamp: {sec: 0, nanosec: 0}\n  frame_id: \"\"\n");
    let _ = writeln!(text, "joint_names: [{}]\npoints:", joint_names(plan, robot).join(", "));
    for Sample { phase, index, time_s, q, v, a } in samples(plan) {
        if index == 0 {
            let _ = writeln!(text, "# {}", phase.kind.name());
        }
        let nanoseconds = libm::round(time_s * 1e9) as u64;
        let (sec, nanosec) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
        let _ = writeln!(text, "- positions: [{}]", list(q));
        let _ = writeln!(text, "  velocities: [{}]", list(&v));
        let _ = writeln!(text, "  accelerations: [{}]", list(&a));
        let _ = writeln!(text, "  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}");
    }
    text
}

#[cfg(test)]
mod tests {
    use yaml_rust2::{Yaml, YamlLoader};

    use super::*;
    use crate::collision::testing::two_arm_robot;
    use crate::plan::Trajectory;
    use crate::task::{Certificate, PhaseKind};

    /// Two phases of three joints, 0.5 s each: a parabola in the first joint, then the same backwards.
    fn plan() -> Plan {
        let phase = |kind, start_s: f64, from: f64| {
            let times_s: Vec<f64> = (0..=50).map(|k| 0.01 * f64::from(k)).collect();
            let at = |t: &f64| (t - from) * (t - from);
            let positions: Vec<Vec<f64>> = times_s.iter().map(|t| vec![at(t), 0.25, -0.5]).collect();
            let trajectory = Trajectory { times_s, positions };
            let closest = ["hand".to_owned(), "table".to_owned()];
            let (manipulability, clearance_m) = (vec![0.1; 51], vec![0.02; 51]);
            Phase { kind, leg: 0, start_s, trajectory, carries: false, manipulability, clearance_m, closest }
        };
        Plan {
            legs: Vec::new(),
            phases: vec![phase(PhaseKind::Reach, 0.0, 0.0), phase(PhaseKind::Retreat, 0.5, 0.5)],
            q_start: vec![0.0; 18],
            dofs: vec![0, 1, 2],
            tries: Vec::new(),
            routes: Vec::new(),
            handover: None,
            certificate: Certificate::default(),
        }
    }

    fn numbers(list: &Yaml) -> Vec<f64> {
        let number = |value: &Yaml| value.as_f64().or_else(|| value.as_i64().map(|v| v as f64)).unwrap();
        list.as_vec().unwrap().iter().map(number).collect()
    }

    #[test]
    fn a_ros_message_has_rising_times_and_the_derivatives_of_its_positions() {
        let (plan, robot) = (plan(), two_arm_robot());
        let read = YamlLoader::load_from_str(&trajectory_text(&plan, &robot, TrajectoryFormat::Yaml)).unwrap();
        let (names, points) = (&read[0]["joint_names"], read[0]["points"].as_vec().unwrap());
        assert_eq!(names.as_vec().unwrap().len(), 3);
        // One sample where the phases meet.
        assert_eq!(points.len(), 51 + 50);
        let time = |k: usize| {
            let at = &points[k]["time_from_start"];
            at["sec"].as_i64().unwrap() as f64 + 1e-9 * at["nanosec"].as_i64().unwrap() as f64
        };
        for k in 1..points.len() {
            assert!((time(k) - time(k - 1) - 0.01).abs() < 1e-9, "at {k}");
        }
        // Of t², 0.2 s after the start: 2 t and 2.
        assert!((numbers(&points[20]["velocities"])[0] - 0.4).abs() < 1e-6);
        assert!((numbers(&points[20]["accelerations"])[0] - 2.0).abs() < 1e-4);
        assert_eq!(numbers(&points[50]["velocities"]), [0.0; 3], "phases begin at rest");
    }

    #[test]
    fn the_table_has_one_line_per_sample_and_the_names_of_the_joints() {
        let (plan, robot) = (plan(), two_arm_robot());
        let text = trajectory_text(&plan, &robot, TrajectoryFormat::Csv);
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(lines.len(), 1 + 101);
        assert!(lines.iter().all(|line| line.len() == 6 + 3 * 3), "every line has all cells");
        let name = &robot.joints[robot.dof_joints[0]].name;
        assert_eq!(lines[0][6], format!("q_{name}_rad"));
        assert_eq!((lines[1][1], lines[101][1], lines[101][0]), ("reach", "retreat", "1.0000"));
    }

    #[test]
    fn json_is_one_array_of_phases() {
        let mut plan = plan();
        plan.phases.clear();
        let empty: serde_json::Value =
            serde_json::from_str(&trajectory_text(&plan, &two_arm_robot(), TrajectoryFormat::Json)).unwrap();
        assert_eq!(empty, serde_json::json!([]));
    }
}
