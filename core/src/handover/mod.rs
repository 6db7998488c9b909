//! Handovers: from one hand of the robot to the other, to another robot, or to a person (thesis chapter 6).

mod choose;
mod comfort;
mod places;
mod plan;
mod report;
mod settings;
mod side;

pub use comfort::Comfort;
pub use plan::{HandoverTask, plan_handover};
pub use report::{HandoverReport, Place};
pub use settings::{Agent, AgentGoal, Handover, PlaceChoice, Receiver};
