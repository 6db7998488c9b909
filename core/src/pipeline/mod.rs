//! The whole way: scene → cloud → segments → fits → grasps → ranking → plan.
//!
//! [`Pipeline::run`] answers a [`Request`](crate::job::Request) stage by stage. A stage whose inputs have not changed
//! since the last run is answered from memory, so moving the goal does not segment the cloud again.

mod goal;
mod handover;
mod lab;
mod legs;
mod map;
mod memory;
mod perceive;
mod rank;
mod regrasp;
mod run;
mod situate;
mod surroundings;

pub use perceive::synthetic_cloud;
pub use run::Pipeline;
pub use surroundings::{Meeting, Seen, Surroundings};

pub(crate) use handover::{HandoverInput, acting};
pub(crate) use legs::TaskInput;
pub(crate) use rank::{grasp_candidates, ranked, workcell};
