//! Moving the hand along given poses: lift, place, retreat.

use nalgebra::{Isometry3, Translation3};

use super::edge::EdgeCause;
use super::space::{ArmSpace, ConfigurationFault, Path};
use crate::collision::Scratch;

/// How to follow poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CartesianSettings {
    /// Largest motion of any joint from one pose to the next, rad; more is a jump to another branch.
    pub max_joint_step_rad: f64,
}

impl Default for CartesianSettings {
    fn default() -> Self {
        Self { max_joint_step_rad: 0.25 }
    }
}

/// Where following ended early, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct CartesianStop {
    /// Index of the pose that was not reached.
    pub pose: usize,
    /// Number of poses.
    pub poses: usize,
    /// Why.
    pub reason: StopReason,
}

/// Why a pose was not reached.
#[derive(Clone, Debug, PartialEq)]
pub enum StopReason {
    /// The start is not a configuration of the arm, or the inverse kinematics answered with none.
    Invalid(ConfigurationFault),
    /// The inverse kinematics found nothing near.
    NoIk,
    /// The nearest solution turns a joint too far: another branch.
    Jump { joint: String, step_rad: f64 },
    /// The motion to it is blocked.
    Blocked(EdgeCause),
}

/// Poses from one to the other, no farther apart than the steps, without the first: positions on a line, rotations by
/// slerp.
pub fn straight_line(from: &Isometry3<f64>, to: &Isometry3<f64>, step_m: f64, step_rad: f64) -> Vec<Isometry3<f64>> {
    let span_m = (to.translation.vector - from.translation.vector).norm();
    let span_rad = from.rotation.angle_to(&to.rotation);
    let steps = (span_m / step_m.max(1e-4)).max(span_rad / step_rad.max(1e-3)).ceil().min(1e5);
    let steps = steps.max(1.0) as usize;
    (1..=steps)
        .map(|k| {
            let fraction = k as f64 / steps as f64;
            let translation = from.translation.vector.lerp(&to.translation.vector, fraction);
            // Half a turn has no shortest way: stay, then turn at the end.
            let rotation = from.rotation.try_slerp(&to.rotation, fraction, 1e-9).unwrap_or(to.rotation);
            Isometry3::from_parts(Translation3::from(translation), rotation)
        })
        .collect()
}

/// Inverse kinematics: answers a hand pose X_WH and a near configuration with the solution nearest to that, if any.
pub type NearIk<'a> = dyn Fn(&Isometry3<f64>, &[f64]) -> Option<Vec<f64>> + 'a;

/// Follows hand poses from `q_start`, staying on one branch of the inverse kinematics.
///
/// Every motion between poses is proven free; the path starts with `q_start` and has one more point per pose.
///
/// # Errors
/// [`CartesianStop`] naming the pose that was not reached and why.
pub fn follow_poses(
    space: &ArmSpace,
    q_start: &[f64],
    poses: &[Isometry3<f64>],
    ik: &NearIk<'_>,
    settings: &CartesianSettings,
) -> Result<Path, CartesianStop> {
    let stop = |pose: usize, reason: StopReason| CartesianStop { pose, poses: poses.len(), reason };
    if let Some(fault) = space.fault(q_start) {
        return Err(stop(0, StopReason::Invalid(fault)));
    }
    let mut scratch = Scratch::default();
    let mut points = vec![q_start.to_vec()];
    let mut near = q_start.to_vec();
    for (index, X_WH) in poses.iter().enumerate() {
        let q = ik(X_WH, &near).ok_or_else(|| stop(index, StopReason::NoIk))?;
        if let Some(fault) = space.fault(&q) {
            return Err(stop(index, StopReason::Invalid(fault)));
        }
        let steps = space.joint_names.iter().zip(q.iter().zip(&near)).map(|(joint, (a, b))| (joint, (a - b).abs()));
        if let Some((joint, step_rad)) = steps.max_by(|a, b| a.1.total_cmp(&b.1))
            && step_rad > settings.max_joint_step_rad
        {
            return Err(stop(index, StopReason::Jump { joint: joint.clone(), step_rad }));
        }
        if let Some(blocked) = space.edge_hit(&mut scratch, &near, &q) {
            return Err(stop(index, StopReason::Blocked(blocked.cause)));
        }
        points.push(q.clone());
        near = q;
    }
    Ok(Path { points })
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::plan::testing::Bench;
    use crate::robot::Robot;

    /// The configuration near `near` that puts link 7 at a pose, by damped Gauss–Newton steps on the Jacobian.
    fn solve(robot: &Robot, X_WH: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>> {
        let mut q = near.to_vec();
        for _ in 0..200 {
            let X_WL = robot.link_poses(&q);
            let error_rad = (X_WH.rotation * X_WL[7].rotation.inverse()).scaled_axis();
            let error_m = X_WH.translation.vector - X_WL[7].translation.vector;
            if error_rad.norm() < 1e-9 && error_m.norm() < 1e-9 {
                return Some(q);
            }
            let J_WH = robot.hand_jacobian(&robot.arms[0], &X_WL);
            let mut e = nalgebra::DVector::zeros(6);
            e.rows_mut(0, 3).copy_from(&error_rad);
            e.rows_mut(3, 3).copy_from(&error_m);
            let gram = &J_WH * J_WH.transpose() + nalgebra::DMatrix::identity(6, 6) * 1e-8;
            let step = J_WH.transpose() * gram.lu().solve(&e)?;
            q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q += step);
        }
        None
    }

    const START: [f64; 7] = [0.3, 0.9, 0.1, 1.2, 0.2, 0.7, 0.0];

    fn lift(robot: &Robot, up_m: f64) -> Vec<Isometry3<f64>> {
        let from = robot.link_poses(&START)[7];
        let to = Translation3::new(0.0, 0.0, up_m) * from;
        straight_line(&from, &to, 0.01, 0.1)
    }

    #[test]
    fn the_hand_rises_on_a_line_and_keeps_its_rotation() {
        let bench = Bench::new(&[]);
        let robot = bench.model.robot();
        let poses = lift(robot, 0.1);
        assert_eq!(poses.len(), 10);
        let ik = |X: &Isometry3<f64>, near: &[f64]| solve(robot, X, near);
        let path = follow_poses(&bench.space(), &START, &poses, &ik, &CartesianSettings::default()).unwrap();
        assert_eq!(path.points.len(), 11);
        let from = robot.link_poses(&START)[7];
        for pair in path.points.windows(2) {
            let middle: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| 0.5 * (a + b)).collect();
            let X_WH = robot.link_poses(&middle)[7];
            let aside = (X_WH.translation.vector - from.translation.vector).xy().norm();
            // A joint-space chord of 10 mm sags by about (10 mm)² / (8 · 0.3 m) = 0.04 mm.
            assert!(aside < 1e-4, "the hand is {aside} m beside its line");
            assert!(X_WH.rotation.angle_to(&from.rotation) < 1e-3);
        }
    }

    #[test]
    fn every_way_of_stopping_names_its_pose() {
        let free = Bench::new(&[]);
        let space = free.space();
        let robot = free.model.robot();
        let poses = lift(robot, 0.1);
        let settings = CartesianSettings::default();
        let ik = |X: &Isometry3<f64>, near: &[f64]| solve(robot, X, near);
        let stop = follow_poses(&space, &START, &poses, &|_, _| None, &settings).unwrap_err();
        assert_eq!(stop, CartesianStop { pose: 0, poses: 10, reason: StopReason::NoIk });
        let jump = |X: &Isometry3<f64>, near: &[f64]| {
            let mut q = solve(robot, X, near)?;
            q[4] += if X.translation.z > poses[4].translation.z + 1e-6 { 1.0 } else { 0.0 };
            Some(q)
        };
        let stop = follow_poses(&space, &START, &poses, &jump, &settings).unwrap_err();
        assert!(stop.pose == 5 && matches!(&stop.reason, StopReason::Jump { joint, .. } if joint == "j5"), "{stop:?}");
        // A floor 50 mm below the hand's tip, whose radius is 45 mm.
        let tip = robot.link_poses(&START)[7] * nalgebra::Point3::new(0.0, 0.0, 0.2024);
        let floored = Bench::new(&[("floor", [tip.x, tip.y, tip.z - 0.1], [0.3, 0.3, 0.01])]);
        let down = lift(robot, -0.1);
        let stop = follow_poses(&floored.space(), &START, &down, &ik, &settings).unwrap_err();
        assert!(matches!(&stop.reason, StopReason::Blocked(EdgeCause::Contact(hit)) if hit.b == "floor"), "{stop:?}");
        assert!((3..=6).contains(&stop.pose), "{stop:?}");
        let stop = follow_poses(&space, &[9.0; 7], &poses, &ik, &settings).unwrap_err();
        assert!(matches!(stop.reason, StopReason::Invalid(_)));
    }

    #[test]
    fn a_line_of_poses_ends_at_its_goal_and_half_turns_do_not_panic() {
        let from = Isometry3::identity();
        let half_turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
        let to = Isometry3::from_parts(Translation3::new(0.1, 0.0, 0.0), half_turn);
        let poses = straight_line(&from, &to, 0.01, 0.1);
        assert!(poses.len() >= 31);
        let last = poses.last().unwrap();
        assert!((last.translation.vector - to.translation.vector).norm() < 1e-12);
        assert!(last.rotation.angle_to(&to.rotation) < 1e-9);
        assert_eq!(straight_line(&from, &from, 0.01, 0.1).len(), 1);
    }
}
