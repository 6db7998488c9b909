//! Where the found object shall go: the task speaks of the described object, the robot holds its fit.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::fit::Fit;
use crate::math::sin_cos;
use crate::scene::{Action, Freedom, Scene, Step};
use crate::superquadric::Superquadric;
use crate::task::Stop;

/// Room left between the object and what it is put on, metres: it is let go just above.
const SETTLE_GAP_M: f64 = 0.002;
/// Poses that stand for a soft goal.
pub(super) const SOFT_POSES: u32 = 24;

/// The stops of the task for the fit: poses in W of the object frame O, the axes of the fit's main superquadric.
///
/// The task's motion, from the described object's start to a step's goal, is applied to the fit. Where it is put down
/// the result is moved along z until the lowest point of all its bodies is just above what it shall stand on. For a
/// dropped cloud the described object does not exist: only the motion's translation is taken, except where the goal
/// turns the object about the vertical or tilts it relative to its start, which it does in the same way.
pub(super) fn stops(scene: &Scene, fitted: &Fit, is_dropped: bool, soft_poses: u32) -> Vec<Stop> {
    scene.task.steps.iter().map(|step| stop(scene, step, fitted, is_dropped, soft_poses)).collect()
}

fn stop(scene: &Scene, step: &Step, fitted: &Fit, is_dropped: bool, count: u32) -> Stop {
    let X_WO_start = scene.objects[scene.task.object].X_WO;
    let X_WS = fitted.superquadric.X_FS;
    let wanted = if is_dropped {
        Translation3::from(step.X_WO_goal.translation.vector - X_WO_start.translation.vector) * X_WS
    } else {
        step.X_WO_goal * X_WO_start.inverse() * X_WS
    };
    let up_O = X_WS.rotation.inverse() * Vector3::z();
    let settled = |X_WO: Isometry3<f64>| match step.action {
        Action::Put | Action::Slide => settle(scene, fitted, &X_WO),
        Action::Pour { .. } => X_WO,
    };
    let poses_WO = soft_poses(&step.freedom, &wanted, &up_O, count).into_iter().map(settled).collect();
    Stop { action: step.action, poses_WO, keep_upright_rad: step.keep_upright_rad }
}

/// The pose, moved along z until its lowest point is just above what is under it.
pub(super) fn settle(scene: &Scene, fitted: &Fit, X_WO: &Isometry3<f64>) -> Isometry3<f64> {
    let motion = X_WO * fitted.superquadric.X_FS.inverse();
    let lowest_of = |body: &Superquadric| {
        let X_WS = motion * body.X_FS;
        X_WS.translation.z - Superquadric { X_FS: X_WS, ..*body }.support(&-Vector3::z())
    };
    let lowest = fitted.bodies().map(lowest_of).fold(f64::INFINITY, f64::min);
    let lift = support_height(scene, X_WO) + SETTLE_GAP_M - lowest;
    Translation3::new(0.0, 0.0, lift) * X_WO
}

/// The wanted pose, then poses spread evenly over what a soft goal leaves free (Halton's sequence in the bases 2, 3,
/// 5, 7, 11).
///
/// `up_O` is the object's upright axis in O.
fn soft_poses(freedom: &Freedom, X_WO: &Isometry3<f64>, up_O: &Vector3<f64>, count: u32) -> Vec<Isometry3<f64>> {
    let mut poses = vec![*X_WO];
    if freedom.is_none() {
        return poses;
    }
    let either_side = |u: f64| 2.0 * u - 1.0;
    poses.extend((1..count).map(|k| {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), either_side(halton(k, 2)) * freedom.yaw_rad);
        // Uniform over the cap of the cone: 1 − cos θ is uniform.
        let (_, cos_half) = sin_cos(freedom.cone_rad);
        let cos = 1.0 - halton(k, 3) * (1.0 - cos_half);
        let (sin_azimuth, cos_azimuth) = sin_cos(std::f64::consts::TAU * halton(k, 5));
        let up_W = X_WO.rotation * up_O;
        let side = Vector3::new(cos_azimuth, sin_azimuth, 0.0);
        let axis = nalgebra::Unit::try_new(up_W.cross(&side), 1e-9).unwrap_or_else(Vector3::x_axis);
        let tilt = UnitQuaternion::from_axis_angle(&axis, libm::acos(cos.max(-1.0).min(1.0)));
        let [x_m, y_m] = freedom.area_m;
        let shift = Vector3::new(either_side(halton(k, 7)) * x_m, either_side(halton(k, 11)) * y_m, 0.0);
        Isometry3::from_parts(Translation3::from(X_WO.translation.vector + shift), turn * tilt * X_WO.rotation)
    }));
    poses
}

/// Element `index` of the van der Corput sequence in a base, in (0, 1) for an index above 0.
fn halton(mut index: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value
}

/// Height of whatever is under a pose: the top of the highest known box below it, the table, or the floor.
fn support_height(scene: &Scene, X_WO: &Isometry3<f64>) -> f64 {
    let p = X_WO.translation.vector;
    let tops = scene.obstacles.iter().filter_map(|obstacle| {
        let p_B = obstacle.X_WB.inverse_transform_vector(&(p - obstacle.X_WB.translation.vector));
        let over = (0..2).all(|axis| p_B[axis].abs() <= 0.5 * obstacle.size_m[axis]);
        let top = obstacle.X_WB.translation.z + 0.5 * obstacle.size_m.z;
        (over && top <= p.z).then_some(top)
    });
    let table = &scene.table;
    let over_table = (0..2).all(|axis| (p[axis] - table.center_m[axis]).abs() <= 0.5 * table.size_m[axis]);
    tops.fold(if over_table { table.height_m } else { 0.0 }, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_of_a_soft_goal_stay_within_its_freedom_and_fill_it() {
        let freedom = Freedom { yaw_rad: 0.8, area_m: [0.1, 0.05], cone_rad: 0.4 };
        let X_WO = Isometry3::from_parts(
            Translation3::new(0.5, 0.1, 0.8),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.3),
        );
        let up_O = X_WO.rotation.inverse() * Vector3::z();
        let poses = soft_poses(&freedom, &X_WO, &up_O, SOFT_POSES);
        assert_eq!((poses.len(), poses[0]), (SOFT_POSES as usize, X_WO));
        let mut widest = [0.0_f64; 3];
        for pose in &poses {
            let shift = pose.translation.vector - X_WO.translation.vector;
            let tilt = (pose.rotation * up_O).angle(&Vector3::z());
            assert!(shift.x.abs() <= 0.1 && shift.y.abs() <= 0.05 && shift.z == 0.0 && tilt <= 0.4 + 1e-9);
            widest = [widest[0].max(shift.x.abs()), widest[1].max(shift.y.abs()), widest[2].max(tilt)];
        }
        assert!(widest[0] > 0.08 && widest[1] > 0.04 && widest[2] > 0.33, "{widest:?}");
        assert_eq!(soft_poses(&Freedom::default(), &X_WO, &up_O, SOFT_POSES), [X_WO], "a hard goal is one pose");
    }

    #[test]
    fn a_free_yaw_keeps_the_object_upright() {
        let freedom = Freedom { yaw_rad: std::f64::consts::PI, ..Freedom::default() };
        let poses = soft_poses(&freedom, &Isometry3::identity(), &Vector3::z(), SOFT_POSES);
        let angles: Vec<f64> = poses.iter().map(|pose| pose.rotation.euler_angles().2).collect();
        for pose in &poses {
            assert!((pose.rotation * Vector3::z() - Vector3::z()).norm() < 1e-12);
            assert_eq!(pose.translation.vector, Vector3::zeros());
        }
        for sector in -3..3 {
            let low = f64::from(sector) * std::f64::consts::FRAC_PI_3;
            assert!(angles.iter().any(|a| (low..low + 1.05).contains(a)), "no pose between {low} and {low} + 60°");
        }
    }
}
