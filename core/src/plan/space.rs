//! The joint space of one arm: limits, distances and what may stand in the way.

use crate::collision::{Checker, CollisionError, Hit, Scratch};
use crate::robot::Robot;

/// The joint space of one arm while the rest of the robot stands still.
///
/// A configuration is one value per joint of the arm, shoulder to wrist. Joints do not wrap: a joint that may turn by
/// ±π has two ends.
#[derive(Clone, Debug)]
pub struct ArmSpace {
    /// Names of the joints.
    pub joint_names: Vec<String>,
    /// Lower limits, rad.
    pub lower: Vec<f64>,
    /// Upper limits, rad.
    pub upper: Vec<f64>,
    /// Largest joint speeds, rad/s.
    pub max_velocity: Vec<f64>,
    /// Largest joint accelerations, rad/s².
    pub max_acceleration: Vec<f64>,
    /// Largest joint jerks, rad/s³.
    pub max_jerk: Vec<f64>,
    /// Who touches whom; its columns are the arm's joints.
    pub checker: Checker,
}

/// Why a list of numbers is not a configuration of the arm.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigurationFault {
    /// Too few or too many values.
    #[error("{found} joint positions, wanted {wanted}")]
    WrongLength { found: usize, wanted: usize },
    /// NaN or infinite.
    #[error("joint {joint}: position {found} is not finite")]
    NotFinite { joint: String, found: f64 },
    /// Beyond a limit.
    #[error("joint {joint}: position {found:.4} is outside of its limits {lower:.4} … {upper:.4}")]
    OutsideLimits { joint: String, found: f64, lower: f64, upper: f64 },
}

impl ArmSpace {
    /// The space of an arm with a checker made for it ([`Checker::for_arm`]).
    ///
    /// # Errors
    /// [`CollisionError`] if there is no such arm or the checker moves other joints.
    pub fn new(robot: &Robot, arm: usize, checker: Checker) -> Result<Self, CollisionError> {
        let arms = robot.arms.len();
        let dofs = &robot.arms.get(arm).ok_or(CollisionError::NoSuchArm { found: arm, arms })?.dofs;
        if checker.dofs() != dofs.as_slice() {
            return Err(CollisionError::WrongLength { found: checker.dofs().len(), wanted: dofs.len() });
        }
        let joints = || dofs.iter().map(|&dof| &robot.joints[robot.dof_joints[dof]]);
        Ok(Self {
            joint_names: joints().map(|joint| joint.name.clone()).collect(),
            lower: joints().map(|joint| joint.limit.lower).collect(),
            upper: joints().map(|joint| joint.limit.upper).collect(),
            max_velocity: joints().map(|joint| joint.limit.velocity).collect(),
            max_acceleration: joints().map(|joint| joint.limit.acceleration).collect(),
            max_jerk: joints().map(|joint| joint.limit.jerk).collect(),
            checker,
        })
    }

    /// The space of configurations and motions that keep everything farther than `clearance_m` from everything that the
    /// arm moves.
    ///
    /// What is nearer than that at one of the configurations `ends` (start, goal) must only stay as far away as there,
    /// to 0.12 mm; intended contacts keep their own rule, and so does what the arm's joints do not move. Searches,
    /// shortcuts and timing in this space are proven with that distance.
    pub fn keeping_clear(&self, clearance_m: f64, ends: &[&[f64]]) -> Self {
        Self { checker: self.checker.keeping_clear(clearance_m, 0.0, ends), ..self.clone() }
    }

    /// The smallest distance of anything that the arm moves to anything else, metres, up to `most_m`; intended contacts
    /// are left out.
    pub fn room_m(&self, scratch: &mut Scratch, q: &[f64], most_m: f64) -> f64 {
        self.checker.room_m(scratch, q, most_m)
    }

    /// Number of joints.
    pub fn dimension(&self) -> usize {
        self.lower.len()
    }

    /// What keeps `q` from being a configuration of the arm; limits are met to 1e-9 rad, which is round-off.
    pub fn fault(&self, q: &[f64]) -> Option<ConfigurationFault> {
        if q.len() != self.dimension() {
            return Some(ConfigurationFault::WrongLength { found: q.len(), wanted: self.dimension() });
        }
        q.iter().enumerate().find_map(|(index, &found)| {
            let joint = || self.joint_names[index].clone();
            let (lower, upper) = (self.lower[index], self.upper[index]);
            if !found.is_finite() {
                Some(ConfigurationFault::NotFinite { joint: joint(), found })
            } else if found < lower - 1e-9 || found > upper + 1e-9 {
                Some(ConfigurationFault::OutsideLimits { joint: joint(), found, lower, upper })
            } else {
                None
            }
        })
    }

    /// The pair that touches at `q`, if any.
    pub fn first_hit(&self, scratch: &mut Scratch, q: &[f64]) -> Option<Hit> {
        self.checker.first_hit(scratch, q)
    }
}

/// Euclidean distance of two configurations, rad.
pub(crate) fn distance_rad(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// The configuration at a fraction of the straight motion from `a` to `b`.
pub(crate) fn lerp(a: &[f64], b: &[f64], fraction: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + (b - a) * fraction).collect()
}

/// Straight joint motions from point to point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// Configurations of the arm, rad.
    pub points: Vec<Vec<f64>>,
}

impl Path {
    /// Sum of the Euclidean lengths of the motions, rad.
    pub fn length_rad(&self) -> f64 {
        self.points.windows(2).map(|pair| distance_rad(&pair[0], &pair[1])).sum()
    }
}
