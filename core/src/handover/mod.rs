//! Handovers: from one hand to another, robot to robot, robot to person.

mod comfort;
mod keep_out;

pub use comfort::{ArmAngles, Comfort, ReceiverArm};
pub use keep_out::{KeepOut, guarded, keep_out};
