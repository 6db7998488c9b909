//! Handovers: from one hand of the robot to the other, to another robot, or to a person (thesis chapter 6).

mod choose;
mod comfort;
mod effort;
mod keep_out;
mod places;
mod plan;
mod report;
mod settings;
mod side;

pub use comfort::{ArmAngles, Comfort, ReceiverArm};
pub use keep_out::{KEEP_OUT, KeepOut, guarded, keep_out};
pub use plan::{HandoverTask, plan_handover};
pub use report::{HandoverReport, Place};
pub(crate) use side::count_serving;

pub use settings::{Agent, AgentGoal, Handover, PERSON, PlaceChoice, Receiver};
