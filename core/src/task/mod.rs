//! Tasks: from an intent ("pick it", "place it there") to a list of timed phases, or a typed refusal.

mod certify;
mod exchange;
mod export;
mod leg;
mod motion;
mod partners;
mod phases;
mod plan;
mod report;
mod setback;
mod settings;
mod ways;
mod ways_between;
mod workcell;

pub use certify::{CellOf, certify};
pub use exchange::{Exchange, Failure, plan_exchange};
pub use export::{TrajectoryFormat, trajectory_text};
pub use leg::{LegPlan, LegTask, assemble, plan_leg};
pub(crate) use motion::{LEAST_LIFT, STRAIGHT_STEP_M, STRAIGHT_STEP_RAD};
pub use partners::Partners;
pub use plan::{Certificate, Leg, ObjectState, Phase, PhaseKind, Plan, PlanState, Route, Try};
pub use report::plan_json_lines;
pub use settings::{MotionSettings, Planner};
pub(crate) use ways::upright_again;
pub use workcell::{Situation, Stop, TARGET, Workcell, WorkcellError};
