//! Experiments on grasps and plans (thesis chapter 5): known objects on the robots' table, in simulation.
//!
//! The robot knows the shape of an object beforehand: it is the fit to 4 000 points of the whole surface of the bundled
//! household object, made once. From there on everything is the pipeline's own: workcell, candidates, ranking, plans.
//! What the camera makes of an object is measured elsewhere ([`super::Experiment::Objects`]).

mod cases;
mod feasible;
mod handover;
mod handover_cases;
mod known;
mod motion;
mod pace;
mod prioritization;
mod priority_row;
mod reference;
#[cfg(test)]
mod testing;

pub use cases::Condition;
pub use feasible::{ENOUGH, FeasibleCase, FeasibleOutcome, FeasibleRow, run_feasible};
pub use handover::{Handed, HandoverCase, HandoverOutcome, HandoverRow, ThesisHandover, run_handover, thesis_handover};
pub use motion::{MotionCase, MotionOutcome, MotionRow, Planned, run_motion};
pub use pace::Pace;
pub use prioritization::{PrioritizationOutcome, run_prioritization};
pub use priority_row::{Excluded, ExcludedCounts, PriorityCase, PriorityRow};
pub use reference::{ThesisPriority, thesis_priority};

use std::sync::Arc;

use super::ExperimentRefusal;
use crate::library::Library;
use crate::scene::Scene;
use crate::task::Planner;

/// An experiment on grasps by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraspExperiment {
    /// Table 5.1: which order of the grasps makes the first one work.
    Prioritization,
    /// How many grasps each object offers each robot.
    Grasps,
    /// Whole pick-and-place plans on random cases.
    Motion,
    /// Table 6.1: handovers on random cases.
    Handover,
}

impl GraspExperiment {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Prioritization, Self::Grasps, Self::Motion, Self::Handover];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Prioritization => "prioritization",
            Self::Grasps => "grasps",
            Self::Motion => "motion",
            Self::Handover => "handover",
        }
    }

    /// What it finds out, for a person.
    pub fn about(self) -> &'static str {
        match self {
            Self::Prioritization => "Table 5.1: which order of the grasps makes the first one work",
            Self::Grasps => {
                "how many grasps each object offers each robot where it stands on the table, and why no more"
            }
            Self::Motion => {
                "whole pick-and-place plans on random cases: success, time, and whether they keep their word"
            }
            Self::Handover => {
                "Table 6.1: handovers to the other hand, to another robot and to a person on random cases"
            }
        }
    }
}

/// What an experiment on grasps is given.
#[derive(Clone)]
pub struct GraspExperimentSettings {
    /// Robots and objects.
    pub library: Arc<Library>,
    /// Names of the robots.
    pub robots: Vec<String>,
    /// Names of the objects.
    pub objects: Vec<String>,
    /// Trials per condition and robot; `None` for the thesis's own numbers.
    pub trials: Option<usize>,
    /// Boxes on the table, known to the robot, in each case.
    pub clutter: usize,
    /// Whether grasps are accepted without looking at straight ways in and out, as in the thesis.
    pub any_way: bool,
    /// What plans look for their way with (experiment `motion`).
    pub planner: Planner,
    /// Scenes with a handover that cases are drawn around (experiment `handover`).
    pub scenes: Vec<Scene>,
    /// Scenarios to run, by name (experiment `handover`); empty for all.
    pub scenarios: Vec<String>,
    /// Seed of everything random.
    pub seed: u64,
    /// What runs at the same time.
    pub pace: Pace,
}

impl GraspExperimentSettings {
    /// Whether there is anything to do.
    fn check(&self, experiment: GraspExperiment) -> Result<(), ExperimentRefusal> {
        let missing = [
            ("trials", self.trials == Some(0)),
            ("objects", self.objects.is_empty()),
            ("robots", self.robots.is_empty()),
        ];
        match missing.into_iter().find(|(_, is_missing)| *is_missing) {
            Some((thing, _)) => Err(ExperimentRefusal::Nothing { experiment: experiment.name(), thing }),
            None => Ok(()),
        }
    }
}
