//! From a path to a timed motion.

use super::filter::{moving_average, window_samples};
use super::limits::{MotionLimits, Violation};
use super::retime::TimedRun;
use super::smooth::{Rounded, Stretch};
use super::space::{ArmSpace, Path, lerp};
use super::trajectory::Trajectory;
use crate::collision::Scratch;

/// How to run along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimingSettings {
    /// Share of the speed limits that is used, in (0, 1].
    pub velocity_scale: f64,
    /// Share of the acceleration limits that is used, in (0, 1].
    pub acceleration_scale: f64,
    /// Share of the jerk limits that is used, in (0, 1].
    pub jerk_scale: f64,
    /// Time between samples, seconds.
    pub sample_s: f64,
    /// Widest rounding of a corner, rad along each of its lines.
    pub blend_rad: f64,
}

impl Default for TimingSettings {
    fn default() -> Self {
        Self { velocity_scale: 1.0, acceleration_scale: 1.0, jerk_scale: 1.0, sample_s: 0.01, blend_rad: 1.0 }
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
    /// The finished motion exceeds a limit: a fault of the timing.
    #[error("the timed motion exceeds a limit: {violation}")]
    LimitExceeded { violation: Violation },
}

/// Runs along a path as fast as limits allow, from rest to rest, rounding corners where there is room.
///
/// First the fastest run under speed and acceleration limits; then the moving average of its samples, which keeps both
/// and bounds the jerk by twice the acceleration over the window: a motion from rest to rest takes longer by the
/// window, 0.2 s where jerk limits reach the acceleration in 0.1 s. The average leaves the run by at most `a w² / 24`
/// (2 mrad for 1 rad/s² and 0.2 s), and only where the run bends.
///
/// The samples are `sample_s` apart; their first, second and third differences stay below the scaled limits, rest before
/// and after included ([`MotionLimits::first_violation`] is asked before the answer is given). The motion between
/// samples (straight) is proven free like every edge; corners in the way of that are rounded less, stopped at, and at
/// last paused at, when the average follows the path exactly.
///
/// # Errors
/// [`TimingError`] naming the limit, scale or point at fault.
pub fn time_path(
    space: &ArmSpace,
    path: &Path,
    limits: &MotionLimits,
    settings: &TimingSettings,
) -> Result<Trajectory, TimingError> {
    check(space, path, limits, settings)?;
    let (Some(start), Some(end)) = (path.points.first(), path.points.last()) else { return Err(TimingError::Empty) };
    let limits = limits.scaled(settings.velocity_scale, settings.acceleration_scale, settings.jerk_scale);
    let scratch = &mut Scratch::default();
    let mut rounded = Rounded::new(space, scratch, path, settings.blend_rad.max(0.0));
    let mut path_is_proven = false;
    loop {
        let mut samples = fastest(&rounded.runs(), start, &limits, settings.sample_s);
        samples[0].clone_from(start);
        if let Some(last) = samples.last_mut() {
            last.clone_from(end);
        }
        let blocked = blocked_places(space, scratch, &samples);
        if !blocked.is_empty() {
            if !path_is_proven {
                for pair in path.points.windows(2) {
                    if let Some(blocked) = space.edge_hit(scratch, &pair[0], &pair[1]) {
                        return Err(TimingError::Blocked { hit: blocked.hit });
                    }
                }
                path_is_proven = true;
            }
            // With a pause at every corner the samples lie on the path, which is free.
            if rounded.give_way(&blocked) {
                continue;
            }
        }
        let times_s = (0..samples.len()).map(|k| k as f64 * settings.sample_s).collect();
        let trajectory = Trajectory { times_s, positions: samples };
        return match limits.first_violation(&trajectory) {
            None => Ok(trajectory),
            Some(violation) => Err(TimingError::LimitExceeded { violation }),
        };
    }
}

fn check(space: &ArmSpace, path: &Path, limits: &MotionLimits, settings: &TimingSettings) -> Result<(), TimingError> {
    let positive = |what: &dyn Fn() -> String, found: f64| {
        if found.is_finite() && found > 0.0 { Ok(()) } else { Err(TimingError::NotPositive { what: what(), found }) }
    };
    positive(&|| "the velocity scale".to_owned(), settings.velocity_scale)?;
    positive(&|| "the acceleration scale".to_owned(), settings.acceleration_scale)?;
    positive(&|| "the jerk scale".to_owned(), settings.jerk_scale)?;
    positive(&|| "the sample time".to_owned(), settings.sample_s)?;
    let wanted = space.dimension();
    let kinds = [("velocity", &limits.velocity), ("acceleration", &limits.acceleration), ("jerk", &limits.jerk)];
    for (what, values) in kinds {
        if values.len() != wanted {
            return Err(TimingError::WrongLength { what, found: values.len(), wanted });
        }
        for (joint, &value) in space.joint_names.iter().zip(values) {
            positive(&|| format!("the {what} limit of joint {joint}"), value)?;
        }
    }
    match path.points.iter().enumerate().find_map(|(index, point)| space.fault(point).map(|fault| (index, fault))) {
        Some((index, fault)) => Err(TimingError::BadPoint { index, fault }),
        None => Ok(()),
    }
}

/// Samples of the fastest motion along the runs.
///
/// All joints share one window. A joint whose jerk limit asks for a wide window can do with a narrower one if it
/// accelerates less, which is why the window of every joint is tried.
fn fastest(runs: &[(Vec<Stretch>, bool)], start: &[f64], limits: &MotionLimits, sample_s: f64) -> Vec<Vec<f64>> {
    let mut windows: Vec<usize> = (limits.acceleration.iter().zip(&limits.jerk))
        .map(|(acceleration, jerk)| window_samples(2.0 * acceleration / jerk, sample_s))
        .collect();
    windows.sort_unstable();
    windows.dedup();
    let mut best: Option<Vec<Vec<f64>>> = None;
    for window in windows {
        let window_s = window as f64 * sample_s;
        let acceleration: Vec<f64> = (limits.acceleration.iter().zip(&limits.jerk))
            .map(|(acceleration, jerk)| acceleration.min(0.5 * jerk * window_s))
            .collect();
        let mut samples = vec![start.to_vec()];
        for (run, pause) in runs {
            let timed = TimedRun::new(run, &limits.velocity, &acceleration);
            // A whole number of samples: slower by less than one sample time.
            timed.sample((timed.duration_s() / sample_s).ceil().max(1.0) as usize, &mut samples);
            if *pause && let Some(last) = samples.last().cloned() {
                samples.extend(std::iter::repeat_n(last, window));
            }
        }
        let samples = moving_average(&samples, window);
        if best.as_ref().is_none_or(|best| samples.len() < best.len()) {
            best = Some(samples);
        }
    }
    best.unwrap_or_default()
}

/// Middles of the motions between samples that are not free.
fn blocked_places(space: &ArmSpace, scratch: &mut Scratch, samples: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut blocked = Vec::new();
    let mut from = 0;
    while let Some(index) = space.blocked_motion(scratch, &samples[from..]) {
        let motion = from + index;
        blocked.push(lerp(&samples[motion], &samples[motion + 1], 0.5));
        from = motion + 1;
    }
    blocked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::{Bench, shelf_configurations};
    use crate::plan::{BirrtSettings, PlanOutcome, ShortcutSettings, plan_path, shorten, walk};
    use crate::watch::Watch;

    /// First, second and third differences of all samples stay below the limits, and some come close to them.
    fn check_differences(trajectory: &Trajectory, limits: &MotionLimits, sample_s: f64) {
        let MotionLimits { velocity, acceleration, jerk } = limits;
        let mut tightest: f64 = 0.0;
        for (k, time) in trajectory.times_s.iter().enumerate() {
            assert!((time - k as f64 * sample_s).abs() < 1e-9);
        }
        // Rest before the start and after the end belongs to the motion.
        let mut samples = trajectory.positions.clone();
        for _ in 0..3 {
            samples.insert(0, samples[0].clone());
            samples.push(samples[samples.len() - 1].clone());
        }
        for k in 2..samples.len() - 1 {
            for joint in 0..velocity.len() {
                let speed = (samples[k][joint] - samples[k - 1][joint]) / sample_s;
                // Positions of about 1 rad carry 1e-16 of round-off: 1e-14 after one division, 1e-12 after two.
                assert!(speed.abs() <= velocity[joint] + 1e-9, "joint {joint} at sample {k}: {speed} rad/s");
                let change = samples[k + 1][joint] - 2.0 * samples[k][joint] + samples[k - 1][joint];
                let rate = change / (sample_s * sample_s);
                assert!(rate.abs() <= acceleration[joint] + 1e-6, "joint {joint} at sample {k}: {rate} rad/s²");
                let before = samples[k][joint] - 2.0 * samples[k - 1][joint] + samples[k - 2][joint];
                let jolt = (change - before) / (sample_s * sample_s * sample_s);
                assert!(jolt.abs() <= jerk[joint] + 1e-6, "joint {joint} at sample {k}: {jolt} rad/s³");
                tightest = tightest.max(speed.abs() / velocity[joint]).max(rate.abs() / acceleration[joint]);
                tightest = tightest.max(jolt.abs() / jerk[joint]);
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
                for (velocity_scale, acceleration_scale, jerk_scale) in [(1.0, 1.0, 1.0), (0.5, 0.25, 0.1)] {
                    let settings =
                        TimingSettings { velocity_scale, acceleration_scale, jerk_scale, ..TimingSettings::default() };
                    let trajectory = time_path(&space, path, &limits, &settings).unwrap();
                    let scaled = limits.scaled(velocity_scale, acceleration_scale, jerk_scale);
                    check_differences(&trajectory, &scaled, 0.01);
                    assert_eq!(scaled.first_violation(&trajectory), None);
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
        let limits = MotionLimits { velocity: vec![0.5; 7], acceleration: vec![1.0; 7], jerk: vec![10.0; 7] };
        // 1 rad of one joint: 0.5 s to 0.5 rad/s and as much back, 0.25 rad in all, 0.75 rad between: 1 s + 1.5 s. The
        // jerk adds 2 a / j = 0.2 s.
        let mut to = vec![0.0; 7];
        to[1] = 1.0;
        let path = Path { points: vec![vec![0.0; 7], to] };
        let trajectory = time_path(&space, &path, &limits, &TimingSettings::default()).unwrap();
        // The grid of 0.02 rad may switch a little late; samples round up to 10 ms.
        assert!((trajectory.duration_s() - 2.7).abs() < 0.03, "{}", trajectory.duration_s());
        check_differences(&trajectory, &limits, 0.01);
    }

    #[test]
    fn a_corner_is_rounded_without_stopping_and_a_reversal_turns_back() {
        let bench = Bench::new(&[]);
        let space = bench.space();
        let limits = MotionLimits { velocity: vec![1.0; 7], acceleration: vec![2.0; 7], jerk: vec![20.0; 7] };
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
                check_differences(&trajectory, &limits, 0.01);
                assert_eq!(trajectory.positions.last(), path.points.last());
            }
        }
    }

    #[test]
    fn a_joint_with_little_jerk_does_not_slow_the_others_down() {
        let bench = Bench::new(&[]);
        let space = bench.space();
        let mut limits = MotionLimits { velocity: vec![1.0; 7], acceleration: vec![2.0; 7], jerk: vec![20.0; 7] };
        limits.jerk[6] = 0.5;
        let mut to = vec![0.0; 7];
        to[1] = 1.0;
        // 0.5 s to full speed and back, 0.5 s at it, 0.2 s for the jerk; the window of joint 7 would be 8 s.
        let path = Path { points: vec![vec![0.0; 7], to.clone()] };
        let trajectory = time_path(&space, &path, &limits, &TimingSettings::default()).unwrap();
        assert!((trajectory.duration_s() - 1.7).abs() < 0.03, "{}", trajectory.duration_s());
        to[6] = 0.1;
        let path = Path { points: vec![vec![0.0; 7], to] };
        let trajectory = time_path(&space, &path, &limits, &TimingSettings::default()).unwrap();
        check_differences(&trajectory, &limits, 0.01);
    }

    #[test]
    fn the_average_does_not_cut_a_corner_that_has_no_room() {
        // The arm points forwards, comes down and swings to the left; a post stands above and to the left of its way.
        let at = |turn: f64, down: f64| vec![turn, down, 0.0, 0.5, 0.0, 0.0, 0.0];
        let limits = MotionLimits { velocity: vec![1.0; 7], acceleration: vec![2.0; 7], jerk: vec![5.0; 7] };
        let arm = Bench::new(&[]);
        let tip = arm.model.robot().link_poses(&at(0.0, 1.2))[7] * nalgebra::Point3::new(0.0, 0.0, 0.2024);
        let path = Path { points: vec![at(0.0, 0.9), at(0.0, 1.2), at(0.6, 1.2)] };
        let mut durations = Vec::new();
        // The average alone leaves the corner by a w² / 24 = 53 mrad: 40 mm at the hand.
        for gap in [0.006, 0.012, 0.1] {
            let beside = 0.045 + gap + 0.01;
            let bench = Bench::new(&[("post", [tip.x - 0.01, beside, tip.z + beside], [0.02; 3])]);
            let trajectory = time_path(&bench.space(), &path, &limits, &TimingSettings::default()).unwrap();
            check_differences(&trajectory, &limits, 0.01);
            let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
            assert_eq!(walk(&judge, &bench.dofs(), &bench.rest(), &trajectory, 16), None, "gap {gap}");
            durations.push(trajectory.duration_s());
        }
        assert!(durations[0] > durations[2] + 0.1, "the post must cost time: {durations:?}");
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
        let jolting = MotionLimits { jerk: vec![f64::NAN; 7], ..limits.clone() };
        assert!(matches!(
            time_path(&space, &here, &jolting, &TimingSettings::default()),
            Err(TimingError::NotPositive { what, .. }) if what.contains("the jerk limit of joint j1")
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
