//! From a path to a timed motion.

use super::retime::TimedRun;
use super::smooth::smooth;
use super::space::{ArmSpace, Path};
use super::trajectory::Trajectory;
use crate::collision::Scratch;

/// How fast each joint may be.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLimits {
    /// Largest speeds, rad/s.
    pub velocity: Vec<f64>,
    /// Largest accelerations, rad/s².
    pub acceleration: Vec<f64>,
}

impl MotionLimits {
    /// The robot's own speeds, with one acceleration for all joints (URDF has none), rad/s².
    pub fn of(space: &ArmSpace, acceleration_rad_s2: f64) -> Self {
        Self {
            velocity: space.max_velocity.clone(),
            acceleration: vec![acceleration_rad_s2; space.max_velocity.len()],
        }
    }
}

/// How to run along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimingSettings {
    /// Share of the speed limits that is used, in (0, 1].
    pub velocity_scale: f64,
    /// Share of the acceleration limits that is used, in (0, 1].
    pub acceleration_scale: f64,
    /// Time between samples, seconds.
    pub sample_s: f64,
    /// Widest rounding of a corner, rad along each of its lines.
    pub blend_rad: f64,
}

impl Default for TimingSettings {
    fn default() -> Self {
        Self { velocity_scale: 1.0, acceleration_scale: 1.0, sample_s: 0.01, blend_rad: 1.0 }
    }
}

/// Why a path cannot be timed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TimingError {
    /// A limit, scale or sample time that is not finite or not greater than 0.
    #[error("{what} is {found}, wanted a finite number greater than 0")]
    NotPositive { what: String, found: f64 },
    /// Limits for another number of joints.
    #[error("{found} {what} limits, wanted one for each of {wanted} joints")]
    WrongLength { what: &'static str, found: usize, wanted: usize },
    /// A point of the path is no configuration of the arm.
    #[error("point {index} of the path: {fault}")]
    BadPoint { index: usize, fault: super::ConfigurationFault },
    /// The path has no points.
    #[error("the path has no points")]
    Empty,
    /// A motion of the path is not free.
    #[error("the path itself is blocked: {hit}")]
    Blocked { hit: crate::collision::Hit },
}

/// Runs along a path as fast as limits allow, from rest to rest, rounding corners where there is room.
///
/// The samples are `sample_s` apart; first and second differences of the samples stay below the scaled limits. The
/// motion between samples (straight) is proven free like every edge; where rounding stands in the way of that, the
/// corners are rounded less.
///
/// # Errors
/// [`TimingError`] naming the limit, scale or point at fault.
pub fn time_path(
    space: &ArmSpace,
    path: &Path,
    limits: &MotionLimits,
    settings: &TimingSettings,
) -> Result<Trajectory, TimingError> {
    let positive = |what: &str, found: f64| {
        if found.is_finite() && found > 0.0 {
            Ok(())
        } else {
            Err(TimingError::NotPositive { what: what.to_owned(), found })
        }
    };
    positive("the velocity scale", settings.velocity_scale)?;
    positive("the acceleration scale", settings.acceleration_scale)?;
    positive("the sample time", settings.sample_s)?;
    let wanted = space.dimension();
    for (what, values) in [("velocity", &limits.velocity), ("acceleration", &limits.acceleration)] {
        if values.len() != wanted {
            return Err(TimingError::WrongLength { what, found: values.len(), wanted });
        }
        for (joint, &value) in space.joint_names.iter().zip(values) {
            positive(&format!("the {what} limit of joint {joint}"), value)?;
        }
    }
    for (index, point) in path.points.iter().enumerate() {
        if let Some(fault) = space.fault(point) {
            return Err(TimingError::BadPoint { index, fault });
        }
    }
    let Some(start) = path.points.first() else { return Err(TimingError::Empty) };
    let mut scratch = Scratch::default();
    for pair in path.points.windows(2) {
        if let Some(blocked) = space.edge_hit(&mut scratch, &pair[0], &pair[1]) {
            return Err(TimingError::Blocked { hit: blocked.hit });
        }
    }
    let velocity: Vec<f64> = limits.velocity.iter().map(|v| v * settings.velocity_scale).collect();
    let acceleration: Vec<f64> = limits.acceleration.iter().map(|a| a * settings.acceleration_scale).collect();
    let mut blend_rad = settings.blend_rad.max(0.0);
    loop {
        let mut samples = vec![start.clone()];
        for run in smooth(space, &mut scratch, path, blend_rad) {
            let timed = TimedRun::new(&run, &velocity, &acceleration);
            // A whole number of samples: slower by less than one sample time.
            let steps = (timed.duration_s() / settings.sample_s).ceil().max(1.0) as usize;
            samples.extend((1..=steps).map(|k| timed.at(timed.duration_s() * k as f64 / steps as f64)));
        }
        if let (Some(last), Some(end)) = (samples.last_mut(), path.points.last()) {
            last.clone_from(end);
        }
        let sampled = Path { points: samples };
        // Without rounding the samples lie on the path, which is free.
        if blend_rad == 0.0 || space.path_is_free(&mut scratch, &sampled) {
            let times_s = (0..sampled.points.len()).map(|k| k as f64 * settings.sample_s).collect();
            return Ok(Trajectory { times_s, positions: sampled.points });
        }
        blend_rad = if blend_rad > 0.01 { 0.25 * blend_rad } else { 0.0 };
    }
}
