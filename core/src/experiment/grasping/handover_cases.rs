//! Random handovers: where the receiver stands, where the object starts and where it goes (thesis 6.2).

use nalgebra::{Isometry3, Translation3};

use super::known::{KnownObject, TABLE, scene, turn};
use crate::handover::{Handover, PlaceChoice, Receiver};
use crate::rng::Rng;
use crate::scene::{ArmChoice, Scene, Task};

/// How far a receiver stands from its place in the scene, metres to either side, and how far it is turned, rad.
const APART_M: f64 = 0.08;
const TURNED_RAD: f64 = 0.3;
/// How far the object starts from its place in the scene, and ends from its goal there, metres to either side; how far
/// it is turned about the vertical at its start, rad.
const START_M: f64 = 0.05;
const START_TURN_RAD: f64 = 0.8;
const GOAL_M: f64 = 0.03;
/// Part of the table from which an object is passed to the other hand: x, and |y|, metres.
const FORWARD_M: [f64; 2] = [0.35, 0.6];
const ASIDE_M: [f64; 2] = [0.35, 0.7];

/// A number to either side of 0.
fn about(rng: &mut Rng, half: f64) -> f64 {
    rng.uniform(-half, half)
}

/// A case around a scene: receiver, start and goal moved and turned.
pub(super) fn around(base: &Scene, rng: &mut Rng, seed: u64) -> Scene {
    let mut drawn = base.clone();
    drawn.seed = seed;
    let placed = &mut drawn.objects[base.task.object];
    let shift = Translation3::new(about(rng, START_M), about(rng, START_M), 0.0);
    let yaw = turn(about(rng, START_TURN_RAD));
    placed.X_WO = Isometry3::from_parts(shift * placed.X_WO.translation, yaw * placed.X_WO.rotation);
    // Nothing else stands on the table: what the camera sees is measured elsewhere.
    drawn.objects = vec![drawn.objects.swap_remove(base.task.object)];
    drawn.task = Task { object: 0, steps: drawn.task.steps };
    if let Some(Handover { receiver: Receiver::Agent(agent), .. }) = &mut drawn.handover {
        agent.position_m = agent.position_m.map(|x| x + about(rng, APART_M));
        agent.yaw_rad += about(rng, TURNED_RAD);
        if let Some(goal) = &mut agent.goal {
            let t = &mut goal.X_AO.translation;
            (t.x, t.y) = (t.x + about(rng, GOAL_M), t.y + about(rng, GOAL_M));
            goal.X_AO.rotation = turn(rng.uniform(-std::f64::consts::PI, std::f64::consts::PI)) * goal.X_AO.rotation;
        }
    }
    drawn
}

/// An object on one side of the table that belongs on the other; it stands there as it is, turned by any angles.
pub(super) fn across(robot: &str, object: &KnownObject, rng: &mut Rng, seed: u64) -> Scene {
    let side = if rng.unit() < 0.5 { 1.0 } else { -1.0 };
    let mut pose = |side: f64| -> Isometry3<f64> {
        let x = rng.uniform(FORWARD_M[0], FORWARD_M[1]);
        let y = side * rng.uniform(ASIDE_M[0], ASIDE_M[1]);
        object.standing([x, y], rng.uniform(-std::f64::consts::PI, std::f64::consts::PI))
    };
    let (start, goal) = (pose(side), pose(-side));
    debug_assert!(start.translation.y.abs() < 0.5 * TABLE.size_m[1]);
    let arm = if side > 0.0 { ArmChoice::Left } else { ArmChoice::Right };
    let mut drawn = scene(robot, arm, object, start, seed);
    drawn.task = Task::place(0, goal);
    drawn.handover =
        Some(Handover { receiver: Receiver::OtherHand, giver_arm: Some(arm), choice: PlaceChoice::default() });
    drawn
}
