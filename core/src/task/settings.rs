//! How the robot moves.

use serde::{Deserialize, Serialize};

use crate::scene::{SceneError, check_range};

/// How the robot moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MotionSettings {
    /// What looks for the way from place to place.
    pub planner: Planner,
    /// With [`Planner::Routes`]: the hand's route that is taken, by its number; `None` takes the first that the arm can
    /// follow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub route: Option<usize>,
    /// Distance that searched ways keep from everything where there is room, metres.
    pub clearance_m: f64,
    /// Share of the joints' speed limits, in (0, 1].
    pub velocity_scale: f64,
    /// Share of the joints' acceleration limits, in (0, 1].
    pub acceleration_scale: f64,
    /// Share of the joints' jerk limits, in (0, 1].
    pub jerk_scale: f64,
    /// Straight way of the open hand before the grasp and after letting go, metres.
    pub approach_m: f64,
    /// Shortest straight way that still counts, metres.
    pub min_approach_m: f64,
    /// Straight way up after the grasp and down at the goal, metres.
    pub lift_m: f64,
    /// Time that the fingers take to close or open, seconds.
    pub fingers_s: f64,
    /// Grasps tried before the task is refused.
    pub max_grasps: usize,
    /// Whether the object may be put down in between and grasped anew where no single grasp does the whole task.
    pub regrasp: bool,
}

/// What looks for the way from place to place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Planner {
    /// The IK-BiRRT: random, the same for the same seed.
    #[default]
    Search,
    /// A roadmap of the joint space: no random numbers.
    Roadmap,
    /// Several clearly different routes of the hand, which the arm follows with its null space: no random numbers.
    Routes,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            planner: Planner::Search,
            route: None,
            clearance_m: 0.01,
            velocity_scale: 1.0,
            acceleration_scale: 1.0,
            jerk_scale: 1.0,
            approach_m: 0.09,
            min_approach_m: 0.03,
            lift_m: 0.06,
            fingers_s: 0.8,
            max_grasps: 12,
            regrasp: true,
        }
    }
}

/// Most grasps that are tried for one task.
const MAX_GRASPS: usize = 1000;
/// Least share of a limit.
const MIN_SCALE: f64 = 0.01;

impl MotionSettings {
    /// The part of the settings that decides which grasps have straight ways; the rest only matters once they are
    /// ranked.
    pub fn straight_ways(&self) -> (f64, f64, f64) {
        (self.approach_m, self.min_approach_m, self.lift_m)
    }

    /// What is wrong with the numbers.
    ///
    /// # Errors
    /// [`SceneError::Value`] naming the place, what was found and what was wanted.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        for (name, value, low, high) in [
            ("clearance_m", self.clearance_m, 0.0, 0.2),
            ("velocity_scale", self.velocity_scale, MIN_SCALE, 1.0),
            ("acceleration_scale", self.acceleration_scale, MIN_SCALE, 1.0),
            ("jerk_scale", self.jerk_scale, MIN_SCALE, 1.0),
            ("approach_m", self.approach_m, self.min_approach_m, 0.5),
            ("min_approach_m", self.min_approach_m, 0.0, 0.5),
            ("lift_m", self.lift_m, 0.001, 0.5),
            ("fingers_s", self.fingers_s, 0.05, 10.0),
            ("max_grasps", self.max_grasps as f64, 1.0, MAX_GRASPS as f64),
        ] {
            check_range(&format!("motion.{name}"), value, low, high)?;
        }
        Ok(())
    }
}
