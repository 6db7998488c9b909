//! Where the found object shall go: the task speaks of the described object, the robot holds its fit.

use nalgebra::{Isometry3, Translation3, Vector3};

use crate::fit::Fit;
use crate::scene::Scene;
use crate::superquadric::Superquadric;

/// Room left between the object and what it is put on, metres: it is let go just above.
const SETTLE_GAP_M: f64 = 0.002;

/// Goal pose in W of the object frame O, the axes of the fit's main superquadric; `None` for a task without a goal.
///
/// The task's motion, from the described object's start to its goal, is applied to the fit, and the result is moved
/// along z until the lowest point of all its bodies is just above what it shall stand on. For a dropped cloud the
/// described object does not exist: only the motion's translation is taken.
pub(super) fn goal_pose(scene: &Scene, fitted: &Fit, is_dropped: bool) -> Option<Isometry3<f64>> {
    let X_WO_goal = scene.task.X_WO_goal()?;
    let X_WO_start = scene.objects[scene.task.object].X_WO;
    let X_WS = fitted.superquadric.X_FS;
    let moved = if is_dropped {
        Translation3::from(X_WO_goal.translation.vector - X_WO_start.translation.vector) * X_WS
    } else {
        X_WO_goal * X_WO_start.inverse() * X_WS
    };
    let motion = moved * X_WS.inverse();
    let lowest_of = |X_WS: &Isometry3<f64>, body: &Superquadric| {
        X_WS.translation.z - Superquadric { X_FS: *X_WS, ..*body }.support(&-Vector3::z())
    };
    let main = lowest_of(&moved, &fitted.superquadric);
    let others = fitted.others.iter().map(|part| lowest_of(&(motion * part.superquadric.X_FS), &part.superquadric));
    let lowest = others.fold(main, f64::min);
    let lift = support_height(scene, &moved) + SETTLE_GAP_M - lowest;
    Some(Translation3::new(0.0, 0.0, lift) * moved)
}

/// Height of whatever is under a pose: the table, or the top of the highest known box below it.
fn support_height(scene: &Scene, X_WO: &Isometry3<f64>) -> f64 {
    let p = X_WO.translation.vector;
    let tops = scene.obstacles.iter().filter_map(|obstacle| {
        let p_B = obstacle.X_WB.inverse_transform_vector(&(p - obstacle.X_WB.translation.vector));
        let over = (0..2).all(|axis| p_B[axis].abs() <= 0.5 * obstacle.size_m[axis]);
        let top = obstacle.X_WB.translation.z + 0.5 * obstacle.size_m.z;
        (over && top <= p.z).then_some(top)
    });
    tops.fold(scene.table.height_m, f64::max)
}
