//! What joints may do, and whether a trajectory keeps to it.

use super::space::ArmSpace;
use super::trajectory::Trajectory;

/// How fast each joint may be, how fast its speed may change, and how fast that may change.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLimits {
    /// Largest speeds, rad/s.
    pub velocity: Vec<f64>,
    /// Largest accelerations, rad/s².
    pub acceleration: Vec<f64>,
    /// Largest jerks, rad/s³.
    pub jerk: Vec<f64>,
}

/// What is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionQuantity {
    /// First differences of the samples.
    Velocity,
    /// Second differences.
    Acceleration,
    /// Third differences.
    Jerk,
}

impl MotionQuantity {
    /// Its name: `velocity`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Velocity => "rad/s",
            Self::Acceleration => "rad/s²",
            Self::Jerk => "rad/s³",
        }
    }
}

/// Where a trajectory exceeds a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Column of the trajectory.
    pub joint: usize,
    /// Time of the last sample of the difference, seconds.
    pub time_s: f64,
    /// Which limit.
    pub what: MotionQuantity,
    /// The difference, in the unit of the limit; NaN where positions are missing or time does not advance.
    pub found: f64,
    /// The limit.
    pub limit: f64,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joint, time_s, what, found, limit } = self;
        let (name, unit) = (what.name(), what.unit());
        write!(f, "joint {} at {time_s:.2} s: {name} {found:.4} {unit}, at most {limit:.4} allowed", joint + 1)
    }
}

impl MotionLimits {
    /// The robot's own limits.
    pub fn of(space: &ArmSpace) -> Self {
        Self {
            velocity: space.max_velocity.clone(),
            acceleration: space.max_acceleration.clone(),
            jerk: space.max_jerk.clone(),
        }
    }

    /// A share of each limit.
    pub fn scaled(&self, velocity: f64, acceleration: f64, jerk: f64) -> Self {
        let times = |values: &[f64], share: f64| values.iter().map(|value| value * share).collect();
        Self {
            velocity: times(&self.velocity, velocity),
            acceleration: times(&self.acceleration, acceleration),
            jerk: times(&self.jerk, jerk),
        }
    }

    /// The first place where a trajectory exceeds these limits, by its samples alone.
    ///
    /// Velocities are differences of neighbouring samples over their time, accelerations differences of neighbouring
    /// velocities, jerks differences of neighbouring accelerations; the arm rests before the first sample and after the
    /// last. Columns beyond those of the limits (fingers) are not looked at. What round-off alone can make of positions
    /// of this size is allowed on top of the limits.
    pub fn first_violation(&self, trajectory: &Trajectory) -> Option<Violation> {
        let (times, positions) = (&trajectory.times_s, &trajectory.positions);
        let count = times.len().max(positions.len());
        if count < 2 {
            return None;
        }
        let joints = self.velocity.len();
        let sample =
            |k: usize| -> (f64, Option<&Vec<f64>>) { (times.get(k).copied().unwrap_or(f64::NAN), positions.get(k)) };
        // Per joint the last velocity and acceleration, and the step over which the velocity was taken.
        let mut v_last = vec![0.0; joints];
        let mut a_last = vec![0.0; joints];
        let mut step_last = sample(1).0 - sample(0).0;
        // Two more steps at rest after the end: the last acceleration, and the last jerk.
        for k in 1..count + 2 {
            let step = if k < count { sample(k).0 - sample(k - 1).0 } else { step_last };
            let time_s = if k < count { sample(k).0 } else { sample(count - 1).0 + (k + 1 - count) as f64 * step };
            for joint in 0..joints {
                let at = |k: usize| sample(k).1.and_then(|q| q.get(joint)).copied().unwrap_or(f64::NAN);
                let (from, to) = if k < count { (at(k - 1), at(k)) } else { (0.0, 0.0) };
                let v = if step > 0.0 { (to - from) / step } else { f64::NAN };
                let a = (v - v_last[joint]) / (0.5 * (step + step_last));
                let j = (a - a_last[joint]) / (0.5 * (step + step_last));
                // Each position is good to one unit in its last place; a sum of a window of samples to a few.
                let round_off = 64.0 * f64::EPSILON * from.abs().max(to.abs()).max(1.0) / step;
                for (what, found, limit, round_off) in [
                    (MotionQuantity::Velocity, v, self.velocity[joint], round_off),
                    (MotionQuantity::Acceleration, a, self.acceleration[joint], round_off / step),
                    (MotionQuantity::Jerk, j, self.jerk[joint], round_off / (step * step)),
                ] {
                    let within = found.abs() <= limit * (1.0 + 1e-12) + round_off;
                    if !within {
                        return Some(Violation { joint, time_s, what, found, limit });
                    }
                }
                v_last[joint] = v;
                a_last[joint] = a;
            }
            step_last = step;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of one joint, 0.1 s apart.
    fn sampled(positions: &[f64]) -> Trajectory {
        Trajectory {
            times_s: (0..positions.len()).map(|k| 0.1 * k as f64).collect(),
            positions: positions.iter().map(|q| vec![*q]).collect(),
        }
    }

    fn limits(velocity: f64, acceleration: f64, jerk: f64) -> MotionLimits {
        MotionLimits { velocity: vec![velocity], acceleration: vec![acceleration], jerk: vec![jerk] }
    }

    #[test]
    fn each_limit_is_found_exceeded_where_it_is_and_not_just_above() {
        // Velocities 0, 1, 2, 1, 0 rad/s; accelerations ±10 rad/s²; the largest jerk from +10 to −10 in one step.
        let hat = sampled(&[0.0, 0.1, 0.3, 0.4, 0.4]);
        assert_eq!(limits(2.0, 10.0, 200.0).first_violation(&hat), None);
        let violation = limits(1.99, 10.0, 200.0).first_violation(&hat).unwrap();
        assert_eq!((violation.what, violation.joint), (MotionQuantity::Velocity, 0));
        assert!((violation.found - 2.0).abs() < 1e-9 && (violation.time_s - 0.2).abs() < 1e-9, "{violation:?}");
        assert_eq!(violation.to_string(), "joint 1 at 0.20 s: velocity 2.0000 rad/s, at most 1.9900 allowed");
        let violation = limits(2.0, 9.9, 200.0).first_violation(&hat).unwrap();
        assert_eq!(violation.what, MotionQuantity::Acceleration);
        let violation = limits(2.0, 10.0, 199.0).first_violation(&hat).unwrap();
        assert_eq!(violation.what, MotionQuantity::Jerk);
        assert!((violation.time_s - 0.3).abs() < 1e-9, "{violation:?}");
    }

    #[test]
    fn rest_before_and_after_belongs_to_the_motion() {
        // At constant speed all the way: only starting and stopping accelerate.
        let ramp = sampled(&[0.0, 0.1, 0.2, 0.3, 0.4]);
        let begin = limits(1.0, 9.0, 1e6).first_violation(&ramp).unwrap();
        assert!((begin.time_s - 0.1).abs() < 1e-9 && begin.found > 0.0, "{begin:?}");
        let soft = sampled(&[0.0, 0.05, 0.15, 0.25, 0.35]);
        let end = limits(1.0, 9.0, 1e6).first_violation(&soft).unwrap();
        assert!((end.time_s - 0.5).abs() < 1e-9 && end.found < 0.0, "{end:?}");
        // Braking with 0.5 rad/s² until the last sample, then nothing: that jerk of 5 rad/s³ comes after the end.
        let braked = sampled(&[0.0, 0.002, 0.009, 0.019, 0.028, 0.033, 0.033]);
        assert_eq!(limits(1.0, 1.0, 5.01).first_violation(&braked), None);
        let end = limits(1.0, 1.0, 4.9).first_violation(&braked).unwrap();
        assert!(end.what == MotionQuantity::Jerk && (end.time_s - 0.7).abs() < 1e-9, "{end:?}");
    }

    #[test]
    fn what_is_no_trajectory_of_these_joints_is_a_violation() {
        let limits = limits(1.0, 1.0, 1.0);
        for broken in [
            Trajectory { times_s: vec![0.0, 0.1], positions: vec![vec![], vec![]] },
            Trajectory { times_s: vec![0.0, 0.1], positions: vec![vec![0.0]] },
            Trajectory { times_s: vec![0.0, 0.0], positions: vec![vec![0.0]; 2] },
            sampled(&[0.0, f64::NAN, 0.0]),
        ] {
            assert!(limits.first_violation(&broken).unwrap().found.is_nan(), "{broken:?}");
        }
        assert_eq!(limits.first_violation(&Trajectory::default()), None);
        assert_eq!(limits.first_violation(&sampled(&[0.3])), None);
    }
}
