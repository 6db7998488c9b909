//! Table 5.1 as the thesis prints it: its own numbers, never mixed with ours.

use super::Condition;
use crate::grasp::RankBy;

/// One row of Table 5.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThesisPriority {
    /// Cases in which the first grasp had both paths; some are printed as fractions.
    pub success: f64,
    /// Cases.
    pub trials: usize,
    /// Planning time, seconds.
    pub planning_time_s: f64,
}

/// The thesis's numbers for a condition and an order, if it has any.
pub fn thesis_priority(condition: Condition, metric: RankBy) -> Option<ThesisPriority> {
    use Condition::{WithRotation, WithoutRotation};
    let (success, planning_time_s) = match (condition, metric) {
        (WithoutRotation, RankBy::Start) => (21.8, 2.17),
        (WithoutRotation, RankBy::Goal) => (33.0, 2.218),
        (WithoutRotation, RankBy::Mean) => (31.4, 2.29),
        (WithRotation, RankBy::Start) => (255.0, 4.70),
        (WithRotation, RankBy::Goal) => (275.0, 4.49),
        (WithRotation, RankBy::Mean) => (260.0, 3.83),
        _ => return None,
    };
    Some(ThesisPriority { success, trials: condition.thesis_trials(), planning_time_s })
}
