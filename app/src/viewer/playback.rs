//! Time on the timeline, and what a plan says about a moment.

use endcomfort_core::task::{Phase, Plan};

use super::ViewerState;
use crate::assets;

/// Where the playing stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Playback {
    /// Seconds from the start of the plan.
    pub time_s: f64,
    /// Whether time runs.
    pub playing: bool,
    /// Seconds of the plan per second.
    pub speed: f64,
    /// Whether the end leads back to the start.
    pub looping: bool,
    /// What the camera keeps in the middle.
    pub follows: Option<Followed>,
}

/// What the camera can follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Followed {
    /// The object that the task is about.
    Object,
    /// The hand of an arm, by the arm's index in the robot.
    Hand(usize),
}

impl Default for Playback {
    fn default() -> Self {
        Self { time_s: 0.0, playing: false, speed: 1.0, looping: false, follows: None }
    }
}

impl ViewerState {
    /// The hands of all arms in the scene, and what a person reads.
    pub fn hands_to_follow(&self) -> Vec<(Followed, String)> {
        let Ok(robot) = assets::library().robot_of(self.scene()) else { return Vec::new() };
        let title = |name: &str| format!("Follow the {} hand", name.replace(['_', '-'], " "));
        robot.arms.iter().enumerate().map(|(arm, of)| (Followed::Hand(arm), title(&of.name))).collect()
    }
}

impl Playback {
    /// The speeds that the timeline offers.
    pub const SPEEDS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

    /// Lets `dt_s` seconds of the clock pass.
    pub(super) fn advance(&mut self, dt_s: f64, duration_s: f64) {
        if !self.playing || duration_s <= 0.0 {
            return;
        }
        self.time_s += dt_s.max(0.0) * self.speed;
        if self.time_s >= duration_s {
            if self.looping {
                self.time_s %= duration_s;
            } else {
                self.time_s = duration_s;
                self.playing = false;
            }
        }
    }

    /// Starts; from the beginning if the end was reached.
    pub(super) fn play(&mut self, duration_s: f64) {
        if duration_s > 0.0 {
            if self.time_s >= duration_s - 1e-9 {
                self.time_s = 0.0;
            }
            self.playing = true;
        }
    }
}

/// The phase at a time; none in an empty plan.
pub(super) fn phase_at(plan: &Plan, time_s: f64) -> Option<&Phase> {
    plan.phases.get(plan.phase_at(time_s))
}

/// A value sampled with a phase (manipulability, clearance) at a time, linear between samples.
pub(super) fn sampled(phase: &Phase, values: &[f64], time_s: f64) -> Option<f64> {
    let times = &phase.trajectory.times_s;
    let local = time_s - phase.start_s;
    let after = times.partition_point(|&t| t <= local);
    let last = values.last().copied();
    let Some(before) = after.checked_sub(1) else { return values.first().copied() };
    let (Some(&from), Some(&to)) = (values.get(before), values.get(after)) else { return last };
    let (Some(&t0), Some(&t1)) = (times.get(before), times.get(after)) else { return last };
    let u = if t1 > t0 { (local - t0) / (t1 - t0) } else { 1.0 };
    Some(from + u * (to - from))
}

/// Time of the sample after or before a time, from the start of the plan; `None` where there is no further one.
pub(super) fn sample_beside(plan: &Plan, time_s: f64, forth: bool) -> Option<f64> {
    // Phases share their ends, and times that were summed up differ in their last bits.
    const SAME_S: f64 = 1e-7;
    let times = || plan.phases.iter().flat_map(|phase| phase.trajectory.times_s.iter().map(|t| phase.start_s + t));
    if forth { times().find(|&t| t > time_s + SAME_S) } else { times().take_while(|&t| t < time_s - SAME_S).last() }
}

/// Manipulability (5.1) at a time.
pub(super) fn manipulability_at(plan: &Plan, time_s: f64) -> Option<f64> {
    phase_at(plan, time_s).and_then(|phase| sampled(phase, &phase.manipulability, time_s))
}

/// Clearance at a time, metres.
pub(super) fn clearance_at(plan: &Plan, time_s: f64) -> Option<f64> {
    phase_at(plan, time_s).and_then(|phase| sampled(phase, &phase.clearance_m, time_s))
}

/// Smallest clearance over the whole plan and when it is met, metres and seconds.
pub(super) fn closest(plan: &Plan) -> Option<(f64, f64)> {
    let samples = plan.phases.iter().flat_map(|phase| {
        phase.clearance_m.iter().zip(&phase.trajectory.times_s).map(|(&c, &t)| (c, phase.start_s + t))
    });
    samples.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn playing_stops_at_the_end_or_starts_over_when_it_loops() {
        let mut playback = Playback { time_s: 9.5, playing: true, ..Playback::default() };
        playback.advance(1.0, 10.0);
        assert_eq!(playback, Playback { time_s: 10.0, playing: false, ..Playback::default() });
        playback.play(10.0);
        assert!(playback.playing && playback.time_s == 0.0);
        playback.looping = true;
        playback.speed = 2.0;
        playback.advance(5.25, 10.0);
        assert!((playback.time_s - 0.5).abs() < 1e-12 && playback.playing);
    }
}
