//! Inverse kinematics: closed form over the arm angle for arms of the S-R-S kind, closed form for arms of six joints with
//! a ball at the shoulder and two axes that meet at the wrist (Hubo), numeric for all others.
//!
//! [`ArmIk`] is the one interface: it looks at the arm, takes the best method for it, and answers joint vectors or typed
//! reasons. What follows is about arms of seven joints.
//!
//! An S-R-S arm has a ball of three joints at the shoulder S, a hinge at the elbow E and a ball at the wrist W, without
//! offsets (LWA4D and LWA3 are such arms). Its redundancy is one number, the *arm angle*: how far the elbow is
//! turned about the line from S to W. At each arm angle a hand pose has up to eight solutions. Arms of another
//! kind are refused by [`SrsArm::of`] with the reason.

mod arcs;
mod arm;
mod ball;
mod extract;
mod follow;
mod glance;
mod led;
mod numeric;
mod outcome;
mod six;
mod solve;
#[cfg(test)]
mod tests;

pub use arcs::Arc;
pub use arm::{ArmIk, IkMethod, Postures};
pub use extract::{NotSrs, SrsArm};
pub use follow::Followed;
pub(crate) use glance::{GLANCES, Glance, Glancer, arm_angle_rad};
pub use led::EXTRA_SAMPLES;
pub(crate) use outcome::Length;
pub use outcome::{IkReject, IkSet, IkSolution};
