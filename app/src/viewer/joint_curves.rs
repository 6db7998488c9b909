//! Joints over time: position, velocity and acceleration of each joint of a plan, and what limits them.

use endcomfort_core::robot::{JointKind, Robot};
use endcomfort_core::scene::Scene;
use endcomfort_core::task::{Phase, Plan};

/// Shortest time between samples that gives a difference worth showing, seconds.
const SHORTEST_S: f64 = 1e-4;

/// What of a joint is plotted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Where it stands.
    #[default]
    Position,
    /// How fast it moves: first differences of the samples.
    Velocity,
    /// How its velocity changes: second differences.
    Acceleration,
}

impl Curve {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Position, Self::Velocity, Self::Acceleration];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Position => "Position",
            Self::Velocity => "Velocity",
            Self::Acceleration => "Acceleration",
        }
    }
}

/// A joint of the arm as its plots need it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ArmJoint {
    /// Name in the URDF.
    pub(crate) name: String,
    /// Whether it turns; else it slides.
    pub(crate) turns: bool,
    /// Lower and upper end of each [`Curve`], the shares of the scene's motion settings taken into account.
    pub(crate) limits: [(f64, f64); 3],
}

impl ArmJoint {
    /// The joints of the arm that a plan moves, from shoulder to wrist; none for a plan of another robot.
    pub(crate) fn of(plan: &Plan, robot: &Robot, scene: &Scene, count: usize) -> Vec<Self> {
        if plan.q_start.len() != robot.dof_count() {
            return Vec::new();
        }
        let motion = &scene.motion;
        let joints = plan.dofs.iter().take(count).filter_map(|&dof| robot.joints.get(*robot.dof_joints.get(dof)?));
        joints
            .map(|joint| {
                let limit = &joint.limit;
                let velocity = limit.velocity * motion.velocity_scale;
                let acceleration = limit.acceleration * motion.acceleration_scale;
                Self {
                    name: joint.name.clone(),
                    turns: joint.kind == JointKind::Revolute,
                    limits: [(limit.lower, limit.upper), (-velocity, velocity), (-acceleration, acceleration)],
                }
            })
            .collect()
    }

    /// Unit in which a person reads a curve, and how many of it are one SI unit.
    pub(crate) fn unit(&self, curve: Curve) -> (&'static str, f64) {
        match (self.turns, curve) {
            (true, Curve::Position) => ("°", 180.0 / std::f64::consts::PI),
            (true, Curve::Velocity) => ("°/s", 180.0 / std::f64::consts::PI),
            (true, Curve::Acceleration) => ("°/s²", 180.0 / std::f64::consts::PI),
            (false, Curve::Position) => ("mm", 1e3),
            (false, Curve::Velocity) => ("mm/s", 1e3),
            (false, Curve::Acceleration) => ("mm/s²", 1e3),
        }
    }
}

/// Times from the start of the plan, seconds, and values of a column of its trajectories, SI units.
pub(crate) fn samples(plan: &Plan, column: usize, curve: Curve) -> Vec<(f64, f64)> {
    plan.phases.iter().flat_map(|phase| of_phase(phase, column, curve)).collect()
}

fn of_phase(phase: &Phase, column: usize, curve: Curve) -> Vec<(f64, f64)> {
    let motion = &phase.trajectory;
    let start_s = phase.start_s;
    let at = |(&t, q): (&f64, &Vec<f64>)| Some((start_s + t, *q.get(column)?));
    let mut values: Vec<(f64, f64)> = motion.times_s.iter().zip(&motion.positions).filter_map(at).collect();
    let ends = (start_s, start_s + motion.duration_s());
    for _ in 0..curve as usize {
        values = differences(&values, ends);
    }
    values
}

/// Slopes between neighbours, at the middle of their times; a phase starts and ends at rest.
fn differences(values: &[(f64, f64)], ends: (f64, f64)) -> Vec<(f64, f64)> {
    let mut slopes = vec![(ends.0, 0.0)];
    slopes.extend(values.windows(2).filter_map(|pair| {
        let [(t0, v0), (t1, v1)] = [pair[0], pair[1]];
        (t1 - t0 > SHORTEST_S).then(|| (0.5 * (t0 + t1), (v1 - v0) / (t1 - t0)))
    }));
    slopes.push((ends.1, 0.0));
    slopes
}

/// The value of sampled times and values at a time, linear between samples, held beyond them.
pub(crate) fn value_at(values: &[(f64, f64)], time_s: f64) -> Option<f64> {
    let after = values.partition_point(|&(t, _)| t <= time_s);
    let (Some(&(t0, v0)), Some(&(t1, v1))) = (after.checked_sub(1).and_then(|k| values.get(k)), values.get(after))
    else {
        let end = if after == 0 { values.first() } else { values.last() };
        return end.map(|&(_, value)| value);
    };
    Some(if t1 > t0 { v0 + (time_s - t0) / (t1 - t0) * (v1 - v0) } else { v1 })
}

#[cfg(test)]
mod tests {
    use endcomfort_core::plan::Trajectory;
    use endcomfort_core::task::PhaseKind;

    use super::*;

    /// One joint on a parabola `q = t²` for two seconds, as a phase that starts at 3 s.
    fn parabola() -> Phase {
        let times_s: Vec<f64> = (0..=200).map(|i| 0.01 * f64::from(i)).collect();
        Phase {
            kind: PhaseKind::Reach,
            leg: 0,
            start_s: 3.0,
            trajectory: Trajectory { positions: times_s.iter().map(|t| vec![t * t]).collect(), times_s },
            carries: false,
            manipulability: Vec::new(),
            clearance_m: Vec::new(),
            closest: Default::default(),
        }
    }

    #[test]
    fn differences_of_a_parabola_are_its_derivatives() {
        let phase = parabola();
        let value = |curve, t| value_at(&of_phase(&phase, 0, curve), t).unwrap();
        // At a sample and between two: the chord of a parabola lies up to h²/4 = 2.5e-5 above it.
        for t in [0.5, 1.0, 1.237] {
            assert!((value(Curve::Position, 3.0 + t) - t * t).abs() < 3e-5);
            assert!((value(Curve::Velocity, 3.0 + t) - 2.0 * t).abs() < 1e-9);
            assert!((value(Curve::Acceleration, 3.0 + t) - 2.0).abs() < 1e-6);
        }
        assert_eq!(value(Curve::Velocity, 3.0), 0.0, "it starts at rest");
        assert!(of_phase(&phase, 1, Curve::Position).is_empty(), "there is no second joint");
    }

    #[test]
    fn a_value_is_held_before_the_first_sample_and_after_the_last() {
        let values = [(1.0, 5.0), (2.0, 7.0)];
        assert_eq!([0.0, 1.5, 9.0].map(|t| value_at(&values, t)), [Some(5.0), Some(6.0), Some(7.0)]);
        assert_eq!(value_at(&[], 1.0), None);
    }
}
