//! Moving the hand along given poses: lift, place, retreat.

use nalgebra::{Isometry3, Translation3};

use super::space::{ArmSpace, ConfigurationFault, Path};
use crate::collision::{Hit, Scratch};

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
    Blocked(Hit),
}

/// Poses from one to the other, no farther apart than the steps, without the first: positions on a line, rotations by
/// slerp.
pub fn straight_line(from: &Isometry3<f64>, to: &Isometry3<f64>, step_m: f64, step_rad: f64) -> Vec<Isometry3<f64>> {
    let span_m = (to.translation.vector - from.translation.vector).norm();
    let span_rad = from.rotation.angle_to(&to.rotation);
    let steps = (span_m / step_m.max(1e-4)).max(span_rad / step_rad.max(1e-3)).ceil().max(1.0).min(1e5) as usize;
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

/// Follows hand poses from `q_start`, staying on one branch of the inverse kinematics.
///
/// `ik` answers a pose X_WH and a near configuration with the solution nearest to that, if any. Every motion between
/// poses is proven free; the path starts with `q_start` and has one more point per pose.
///
/// # Errors
/// [`CartesianStop`] naming the pose that was not reached and why.
pub fn follow_poses(
    space: &ArmSpace,
    q_start: &[f64],
    poses: &[Isometry3<f64>],
    ik: &dyn Fn(&Isometry3<f64>, &[f64]) -> Option<Vec<f64>>,
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
            return Err(stop(index, StopReason::Blocked(blocked.hit)));
        }
        points.push(q.clone());
        near = q;
    }
    Ok(Path { points })
}
