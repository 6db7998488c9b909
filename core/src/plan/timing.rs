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
    /// The robot's own limits.
    pub fn of(space: &ArmSpace) -> Self {
        Self { velocity: space.max_velocity.clone(), acceleration: space.max_acceleration.clone() }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::{Bench, shelf_configurations};
    use crate::plan::{BirrtSettings, PlanOutcome, ShortcutSettings, plan_path, shorten, walk};
    use crate::watch::Watch;

    /// First and second differences of all samples stay below the limits, and some come close to them.
    fn check_differences(trajectory: &Trajectory, velocity: &[f64], acceleration: &[f64], sample_s: f64) {
        let mut tightest: f64 = 0.0;
        for (k, time) in trajectory.times_s.iter().enumerate() {
            assert!((time - k as f64 * sample_s).abs() < 1e-9);
        }
        // Rest before the start and after the end belongs to the motion.
        let mut samples = trajectory.positions.clone();
        samples.insert(0, samples[0].clone());
        samples.push(samples[samples.len() - 1].clone());
        for k in 1..samples.len() - 1 {
            for joint in 0..velocity.len() {
                let speed = (samples[k][joint] - samples[k - 1][joint]) / sample_s;
                // Positions of about 1 rad carry 1e-16 of round-off: 1e-14 after one division, 1e-12 after two.
                assert!(speed.abs() <= velocity[joint] + 1e-9, "joint {joint} at sample {k}: {speed} rad/s");
                let change = samples[k + 1][joint] - 2.0 * samples[k][joint] + samples[k - 1][joint];
                let rate = change / (sample_s * sample_s);
                assert!(rate.abs() <= acceleration[joint] + 1e-6, "joint {joint} at sample {k}: {rate} rad/s²");
                tightest = tightest.max(speed.abs() / velocity[joint]).max(rate.abs() / acceleration[joint]);
            }
        }
        assert!(tightest > 0.95, "the motion is slower than it need be: {tightest} of the limits");
    }

    #[test]
    fn samples_respect_limits_one_by_one_and_the_motion_between_them_is_free() {
        let bench = Bench::shelf();
        let space = bench.space();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let limits = MotionLimits::of(&space);
        let cells = shelf_configurations();
        for (seed, pair) in cells.windows(2).enumerate() {
            let outcome =
                plan_path(&space, &pair[0], &[pair[1].clone()], &BirrtSettings::default(), seed as u64, &Watch::idle());
            let PlanOutcome::Found(found) = outcome else { panic!("{outcome:?}") };
            let short = shorten(&space, &found.path, &ShortcutSettings::default(), 1, &Watch::idle());
            for path in [&found.path, &short] {
                for (velocity_scale, acceleration_scale) in [(1.0, 1.0), (0.5, 0.25)] {
                    let settings = TimingSettings { velocity_scale, acceleration_scale, ..TimingSettings::default() };
                    let trajectory = time_path(&space, path, &limits, &settings).unwrap();
                    let velocity: Vec<f64> = limits.velocity.iter().map(|v| v * velocity_scale).collect();
                    let acceleration: Vec<f64> = limits.acceleration.iter().map(|a| a * acceleration_scale).collect();
                    check_differences(&trajectory, &velocity, &acceleration, 0.01);
                    assert_eq!(trajectory.positions.first(), Some(&pair[0]));
                    assert_eq!(trajectory.positions.last(), Some(&pair[1]));
                    assert_eq!(walk(&judge, &bench.dofs(), &bench.rest(), &trajectory, 4), None);
                }
            }
        }
    }

    #[test]
    fn a_single_line_takes_exactly_the_trapezoid() {
        let bench = Bench::new(&[]);
        let space = bench.space();
        let limits = MotionLimits { velocity: vec![0.5; 7], acceleration: vec![1.0; 7] };
        // 1 rad of one joint: 0.5 s to 0.5 rad/s and as much back, 0.25 rad in all, 0.75 rad between: 1 s + 1.5 s.
        let mut to = vec![0.0; 7];
        to[1] = 1.0;
        let path = Path { points: vec![vec![0.0; 7], to] };
        let trajectory = time_path(&space, &path, &limits, &TimingSettings::default()).unwrap();
        // The grid of 0.02 rad may switch a little late; samples round up to 10 ms.
        assert!((trajectory.duration_s() - 2.5).abs() < 0.03, "{}", trajectory.duration_s());
        check_differences(&trajectory, &limits.velocity, &limits.acceleration, 0.01);
    }

    #[test]
    fn a_corner_is_rounded_without_stopping_and_a_reversal_turns_back() {
        let bench = Bench::new(&[]);
        let space = bench.space();
        let limits = MotionLimits { velocity: vec![1.0; 7], acceleration: vec![2.0; 7] };
        let at = |a: f64, b: f64| vec![0.0, a, 0.0, b, 0.0, 0.0, 0.0];
        let corner = Path { points: vec![at(0.0, 0.0), at(0.8, 0.0), at(0.8, 0.8)] };
        let trajectory = time_path(&space, &corner, &limits, &TimingSettings::default()).unwrap();
        let speeds: Vec<f64> = trajectory
            .positions
            .windows(2)
            .map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max) / 0.01)
            .collect();
        let inner = &speeds[speeds.len() / 4..3 * speeds.len() / 4];
        assert!(inner.iter().all(|&speed| speed > 0.3), "the arm all but stops: {inner:?}");
        let stopping = TimingSettings { blend_rad: 0.0, ..TimingSettings::default() };
        let stopped = time_path(&space, &corner, &limits, &stopping).unwrap();
        assert!(trajectory.duration_s() < 0.9 * stopped.duration_s());
        for path in [corner, Path { points: vec![at(0.0, 0.0), at(0.8, 0.0), at(0.1, 0.0)] }] {
            for settings in [TimingSettings::default(), stopping] {
                let trajectory = time_path(&space, &path, &limits, &settings).unwrap();
                check_differences(&trajectory, &limits.velocity, &limits.acceleration, 0.01);
                assert_eq!(trajectory.positions.last(), path.points.last());
            }
        }
    }

    #[test]
    fn staying_put_is_one_sample_and_bad_limits_are_named() {
        let space = Bench::new(&[]).space();
        let limits = MotionLimits::of(&space);
        let here = Path { points: vec![vec![0.1; 7], vec![0.1; 7]] };
        let trajectory = time_path(&space, &here, &limits, &TimingSettings::default()).unwrap();
        assert_eq!((trajectory.duration_s(), trajectory.positions.len()), (0.0, 1));
        let none = Path::default();
        assert!(matches!(time_path(&space, &none, &limits, &TimingSettings::default()), Err(TimingError::Empty)));
        let stuck = MotionLimits { acceleration: vec![0.0; 7], ..limits.clone() };
        assert!(matches!(
            time_path(&space, &here, &stuck, &TimingSettings::default()),
            Err(TimingError::NotPositive { what, found: 0.0 }) if what.contains("joint j1")
        ));
        let short = MotionLimits { velocity: vec![1.0; 3], ..limits };
        assert!(matches!(
            time_path(&space, &here, &short, &TimingSettings::default()),
            Err(TimingError::WrongLength { what: "velocity", found: 3, wanted: 7 })
        ));
    }

    #[test]
    fn a_path_through_a_board_is_refused() {
        let space = Bench::shelf().space();
        let cells = shelf_configurations();
        let path = Path { points: vec![cells[0].clone(), vec![0.0, 1.57, 0.0, 0.0, 0.0, 0.0, 0.0]] };
        let limits = MotionLimits::of(&space);
        assert!(matches!(
            time_path(&space, &path, &limits, &TimingSettings::default()),
            Err(TimingError::Blocked { .. })
        ));
    }
}
