//! What one plan is compared with another by.

use std::sync::Arc;

use endcomfort_core::robot::Robot;
use endcomfort_core::task::Plan;
use nalgebra::{Point3, Vector3};

use super::playback;

/// The numbers of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Measures {
    /// Duration, seconds.
    pub duration_s: f64,
    /// Way of the arm in joint space, rad (metres for joints that slide).
    pub arm_rad: f64,
    /// Way of the hand frame's origin, metres.
    pub hand_m: f64,
    /// Smallest clearance, metres; `None` where nobody measured it.
    pub clearance_m: Option<f64>,
    /// Mean manipulability (5.1) over time; `None` where nobody measured it.
    pub manipulability: Option<f64>,
    /// How many phases it has.
    pub phases: usize,
    /// What was tried in vain before it.
    pub tries: usize,
}

impl Measures {
    /// Measures a plan of a robot whose arm has the first `arm_joints` columns of every trajectory.
    pub fn of(plan: &Plan, robot: &Robot, arm_joints: usize) -> Self {
        let columns = |q: &[f64]| q[..arm_joints.min(q.len())].to_vec();
        let moves = plan.phases.iter().flat_map(|phase| phase.trajectory.positions.windows(2));
        let arm_rad = moves.map(|pair| apart(&columns(&pair[0]), &columns(&pair[1]))).sum();
        let hand_m = trail(plan, robot).windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        Self {
            duration_s: plan.duration_s(),
            arm_rad,
            hand_m,
            clearance_m: playback::closest(plan).map(|(clearance_m, _)| clearance_m),
            manipulability: mean_manipulability(plan),
            phases: plan.phases.len(),
            tries: plan.tries.len(),
        }
    }
}

fn apart(from: &[f64], to: &[f64]) -> f64 {
    from.iter().zip(to).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
}

/// Mean over time by the trapezium rule within phases.
fn mean_manipulability(plan: &Plan) -> Option<f64> {
    let (mut area, mut length_s) = (0.0, 0.0);
    for phase in &plan.phases {
        let samples: Vec<(&f64, &f64)> = phase.trajectory.times_s.iter().zip(&phase.manipulability).collect();
        for pair in samples.windows(2) {
            let dt_s = pair[1].0 - pair[0].0;
            area += 0.5 * dt_s * (pair[0].1 + pair[1].1);
            length_s += dt_s;
        }
    }
    (length_s > 0.0 && area.is_finite()).then(|| area / length_s)
}

/// Places of the hand frame's origin over a plan, in the world.
pub(super) fn trail(plan: &Plan, robot: &Robot) -> Vec<Point3<f64>> {
    // One place in a fiftieth of a second: a hand goes a few centimetres in that time.
    let count = (50.0 * plan.duration_s()).ceil().max(1.0).min(3000.0) as u32;
    let at = |k: u32| {
        let state = plan.state_at(plan.duration_s() * f64::from(k) / f64::from(count));
        Point3::from(robot.link_poses(&state.q)[plan.tcp_link(&state)].translation.vector)
    };
    let mut points: Vec<Point3<f64>> = (0..=count).map(at).collect();
    points.dedup_by(|after, before| (*after - *before).norm() < 1e-6);
    points
}

/// A plan that was kept to compare others with.
#[derive(Clone, Debug)]
pub struct Kept {
    /// Its number, another for every plan that is kept.
    pub number: u64,
    /// What it was made with, for a person.
    pub title: String,
    /// Its numbers.
    pub measures: Measures,
    /// Way of the hand in the world.
    pub trail: Arc<Vec<Point3<f64>>>,
}

impl Kept {
    /// The middle of its way, and a little above it.
    pub fn label_place(&self) -> Option<Point3<f64>> {
        Some(self.trail.get(self.trail.len() / 2)? + 0.01 * Vector3::z())
    }
}
