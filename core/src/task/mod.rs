//! Tasks: from an intent ("pick it", "place it there") to a list of timed phases, or a typed refusal.

mod motion;
mod pick_and_place;
mod plan;
mod report;
mod settings;
mod workcell;

pub(crate) use motion::STRAIGHT_STEP_M;
pub use pick_and_place::{PickAndPlace, plan_pick_and_place};
pub use plan::{Certificate, Leg, ObjectState, Phase, PhaseKind, Plan, PlanState, Route, Try};
pub use report::plan_json_lines;
pub use settings::{MotionSettings, Planner};
pub use workcell::{Situation, TARGET, Workcell, WorkcellError};
