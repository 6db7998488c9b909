//! Moving the arm: straight ways of the hand, searched ways of the joints, and their timing.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::setback::Blocked;
use super::ways_between::RoadmapOnce;
use super::{MotionSettings, PhaseKind, Workcell};
use crate::collision::{Clearance, Scratch};
use crate::plan::{
    ArmSpace, CartesianSettings, CartesianStop, EdgeCause, MotionLimits, Path, StopReason, TimingSettings, Trajectory,
    follow_poses, straight_line, time_path,
};
use crate::robot::Dexterity;
use crate::watch::Watch;

/// Distance between poses on a straight way, metres, and radians.
pub(crate) const STRAIGHT_STEP_M: f64 = 0.01;
pub(crate) const STRAIGHT_STEP_RAD: f64 = 0.1;
/// Share of the lift that is wanted that an object has to rise at least before it is carried away.
pub(crate) const LEAST_LIFT: f64 = 0.25;
/// One phase of a plan before its start time is known.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub(super) kind: PhaseKind,
    pub(super) trajectory: Trajectory,
    pub(super) carries: bool,
    pub(super) manipulability: Vec<f64>,
    pub(super) clearance_m: Vec<f64>,
    pub(super) closest: [String; 2],
}

impl Draft {
    /// The same state for a while, then another motion: one phase.
    pub(super) fn then(mut self, rest_s: f64, next: &Self) -> Self {
        let sample_s = TimingSettings::default().sample_s;
        let samples = libm::ceil(rest_s / sample_s).max(0.0) as usize;
        let least = |of: &[f64]| of.iter().copied().fold(f64::INFINITY, f64::min);
        if least(&next.clearance_m) < least(&self.clearance_m) {
            self.closest.clone_from(&next.closest);
        }
        let mut push = |q: &[f64], m: f64, clearance_m: f64| {
            self.trajectory.times_s.push(self.trajectory.positions.len() as f64 * sample_s);
            self.trajectory.positions.push(q.to_vec());
            self.manipulability.push(m);
            self.clearance_m.push(clearance_m);
        };
        let last = next.trajectory.positions.first().cloned().unwrap_or_default();
        let (m, clearance_m) = (next.manipulability[0], next.clearance_m[0]);
        for _ in 0..samples {
            push(&last, m, clearance_m);
        }
        for k in 1..next.trajectory.positions.len() {
            push(&next.trajectory.positions[k], next.manipulability[k], next.clearance_m[k]);
        }
        self
    }
}

/// Plans single motions of one arm; every failure is a sentence for a person.
pub(super) struct Mover<'a> {
    pub(super) cell: &'a Workcell,
    pub(super) settings: &'a MotionSettings,
    pub(super) seed: u64,
    pub(super) roadmap: RoadmapOnce,
    pub(super) watch: Watch<'a>,
}

impl Mover<'_> {
    /// Straight back along the approach direction, as far as there is room, at least the shortest way that counts.
    pub(super) fn back_off(&self, space: &ArmSpace, q: &[f64], X_WH: &Isometry3<f64>) -> Result<Path, Blocked> {
        let (full, least) = (self.settings.approach_m, self.settings.min_approach_m);
        let mut reason = Blocked::default();
        for length_m in [full, 0.5 * (full + least), least] {
            let X_WH_end = X_WH * Translation3::new(0.0, 0.0, -length_m);
            match self.straight(space, q, X_WH, &X_WH_end) {
                Ok(path) => return Ok(path),
                Err(blocked) => reason = blocked,
            }
        }
        Err(reason)
    }

    /// Straight up from the hand pose, as far as there is room, at least a quarter of what is wanted.
    pub(super) fn rise(&self, space: &ArmSpace, q: &[f64], X_WH: &Isometry3<f64>) -> Result<Path, Blocked> {
        let mut reason = Blocked::default();
        for share in [1.0, 0.5, LEAST_LIFT] {
            let up = Translation3::from(Vector3::z() * (share * self.settings.lift_m));
            match self.straight(space, q, X_WH, &(up * X_WH)) {
                Ok(path) => return Ok(path),
                Err(blocked) => reason = blocked,
            }
        }
        Err(reason)
    }

    /// The hand on a straight line from pose to pose, staying on one branch of the inverse kinematics.
    pub(super) fn straight(
        &self,
        space: &ArmSpace,
        q: &[f64],
        X_WH: &Isometry3<f64>,
        X_WH_end: &Isometry3<f64>,
    ) -> Result<Path, Blocked> {
        let X_WB = self.cell.robot.link_poses(&self.cell.q_start)[self.cell.arm().base_link];
        let poses = straight_line(X_WH, X_WH_end, STRAIGHT_STEP_M, STRAIGHT_STEP_RAD);
        let near_ik = |X_WH: &Isometry3<f64>, near: &[f64]| self.cell.ik.near(&X_WB.inv_mul(X_WH), near);
        follow_poses(space, q, &poses, &near_ik, &CartesianSettings::default()).map_err(|stop| stopped(&stop, q))
    }

    /// The phase that moves the arm along a path with the fingers at rest; timed in a space that may keep a clearance,
    /// with the distances of the plain one.
    pub(super) fn along(
        &self,
        kind: PhaseKind,
        [space, plain]: [&ArmSpace; 2],
        path: &Path,
        fingers: &[f64],
        carries: bool,
    ) -> Result<Draft, Blocked> {
        let trajectory = self.timed(space, path, self.settings.velocity_scale)?;
        Ok(self.measured(kind, plain, trajectory, fingers, carries))
    }

    /// A path with times, the joints' speeds scaled.
    pub(super) fn timed(&self, space: &ArmSpace, path: &Path, velocity_scale: f64) -> Result<Trajectory, Blocked> {
        let timing = TimingSettings {
            velocity_scale,
            acceleration_scale: self.settings.acceleration_scale,
            jerk_scale: self.settings.jerk_scale,
            ..TimingSettings::default()
        };
        time_path(space, path, &MotionLimits::of(space), &timing).map_err(|error| Blocked::because(error.to_string()))
    }

    /// The phase of a motion of the arm, with the distances of a space and the manipulability at every sample.
    pub(super) fn measured(
        &self,
        kind: PhaseKind,
        space: &ArmSpace,
        mut trajectory: Trajectory,
        fingers: &[f64],
        carries: bool,
    ) -> Draft {
        let mut scratch = Scratch::default();
        let mut nearest = Clearance { distance_m: f64::INFINITY, a: String::new(), b: String::new() };
        let mut clearance_m = Vec::with_capacity(trajectory.positions.len());
        let mut most_m = f64::INFINITY;
        let mut last: Option<&Vec<f64>> = None;
        for q in &trajectory.positions {
            let grown_m = last.map_or(f64::INFINITY, |last| 2.0 * space.checker.displacement_m(last, q));
            let clearance = space.checker.distance_within(&mut scratch, q, most_m + grown_m + 1e-9);
            (most_m, last) = (clearance.distance_m, Some(q));
            clearance_m.push(clearance.distance_m);
            if clearance.distance_m < nearest.distance_m {
                nearest = clearance;
            }
        }
        let manipulability = self.manipulability(&trajectory);
        trajectory.positions.iter_mut().for_each(|q| q.extend_from_slice(fingers));
        Draft { kind, trajectory, carries, manipulability, clearance_m, closest: [nearest.a, nearest.b] }
    }

    /// The phase that moves the fingers with the arm at rest: from rest to rest, a cubic in time.
    pub(super) fn fingers(&self, kind: PhaseKind, space: &ArmSpace, q: &[f64], from: &[f64], to: &[f64]) -> Draft {
        let sample_s = TimingSettings::default().sample_s;
        let steps = libm::ceil(self.settings.fingers_s / sample_s).max(1.0) as usize;
        let mut trajectory = Trajectory::default();
        for k in 0..=steps {
            let u = k as f64 / steps as f64;
            let smooth = u * u * (3.0 - 2.0 * u);
            let fingers = from.iter().zip(to).map(|(a, b)| a + smooth * (b - a));
            trajectory.times_s.push(k as f64 * sample_s);
            trajectory.positions.push(q.iter().copied().chain(fingers).collect());
        }
        let still = Trajectory { times_s: vec![0.0], positions: vec![q.to_vec()] };
        let m = self.manipulability(&still)[0];
        let Clearance { distance_m, a, b } = space.checker.distance(&mut Scratch::default(), q);
        let samples = steps + 1;
        Draft {
            kind,
            trajectory,
            carries: false,
            manipulability: vec![m; samples],
            clearance_m: vec![distance_m; samples],
            closest: [a, b],
        }
    }

    /// Manipulability of every sample.
    fn manipulability(&self, trajectory: &Trajectory) -> Vec<f64> {
        let mut placed = Vec::new();
        Dexterity::new(self.cell.ik.chain()).all(&trajectory.positions.concat(), &mut placed);
        placed.iter().map(|placed| placed.manipulability).collect()
    }
}

/// A way back along a path.
pub(super) fn reversed(path: &Path) -> Path {
    Path { points: path.points.iter().rev().cloned().collect() }
}

/// One path after the other; the second starts where the first ends.
pub(super) fn joined(first: &Path, second: &Path) -> Path {
    Path { points: first.points.iter().chain(second.points.iter().skip(1)).cloned().collect() }
}

fn stopped(stop: &CartesianStop, q: &[f64]) -> Blocked {
    let share = 100 * stop.pose / stop.poses.max(1);
    match &stop.reason {
        StopReason::Invalid(fault) => Blocked::because(fault.to_string()),
        StopReason::NoIk => Blocked::because(format!("out of reach after {share} % of the way")),
        StopReason::Jump { joint, .. } => {
            Blocked::because(format!("{joint} would have to jump after {share} % of the way"))
        }
        StopReason::Blocked(EdgeCause::Contact(hit)) => Blocked::at(format!("{} hits {}", hit.a, hit.b), hit, q),
        StopReason::Blocked(EdgeCause::Tilted(tilt)) => Blocked::because(format!("the hand is {tilt}")),
    }
}
