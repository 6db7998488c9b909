//! The thesis's experiments on fitting (chapter 3), those on grasps (chapter 5), and the comparisons that go beyond them, as data.
//!
//! [`run_experiment`] takes a seed and a number of trials and gives typed rows and every single fit; both are
//! [`Record`]s, one JSON object or one CSV line each. Random trials have one stream of random numbers each, so the
//! outcome is the same whatever the number of threads. Errors are evaluated on the full clean cloud, also for partial
//! and noisy fits, as in the thesis's tables.
//!
//! Times come from the watch that the caller passes, and are given only when every fit had a processor for itself
//! ([`ExperimentSettings::is_serial`]). What the thesis reports stands in `reference` alone and is never mixed with
//! what was measured here.
//!
//! Experiments on grasps and plans (chapter 5) have their own rows: [`run_prioritization`], [`run_feasible`].
//!
//! Not here: the experiments on handovers (chapter 6).

mod deformations;
mod downsampling;
mod equivalence;
mod grasping;
mod object_views;
mod objectives;
mod objects;
mod outliers;
mod peers;
mod protocol;
mod record;
mod reference;
mod row;
mod run;
mod summary;
#[cfg(test)]
mod tests;
mod trial;
mod trials_file;
mod visibility;

pub use equivalence::{EXPONENT_TOLERANCE, equivalent_exponents, exponent_error};
pub use grasping::{
    Condition, ENOUGH, Excluded, ExcludedCounts, FeasibleCase, FeasibleOutcome, FeasibleRow, GraspExperiment,
    GraspExperimentSettings, Handed, HandoverCase, HandoverOutcome, HandoverRow, MotionCase, MotionOutcome, MotionRow,
    Pace, Planned, PrioritizationOutcome, PriorityCase, PriorityRow, ThesisHandover, ThesisPriority, run_feasible,
    run_handover, run_motion, run_prioritization, thesis_handover, thesis_priority,
};
pub use object_views::{ObjectView, household_views};
pub use peers::{peers_clouds, peers_input};
pub use protocol::{Clouds, NOISE_M, THESIS_POINTS, Visibility, draw_shape, even_cloud, random_cloud};
pub use record::{Cell, Record, csv};
pub use reference::{ThesisRow, thesis_row};
pub use row::{RECOVERED_M, Row};
pub use run::{Experiment, ExperimentRefusal, ExperimentSettings, Outcome, run_experiment};
pub use summary::Summary;
pub use trial::{Answer, Trial};
pub use trials_file::{TrialsFileError, read_trials};
