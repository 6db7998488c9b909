//! What people bring: robots of their own, as URDF with its meshes, and the files that they come in.
//!
//! [`Files`] is what was dropped or named on the command line, folders and archives unpacked. [`propose`] looks in it for
//! a robot: it finds its arms, its fingers and a place behind the table, and says in words what it could not find. The
//! answer is a [`GuestRobot`], whole and self-contained, which the [`crate::library::Library`] takes in under a name
//! of its own. What was chosen is kept in a [`RobotDescription`], a small file beside the URDF.
//!
//! What is not here: xacro (it has to be expanded first), Collada meshes (marked boxes stand for them), robots whose
//! joints close loops.

mod arms;
mod blob;
mod body;
mod boxes;
mod build;
mod description;
mod error;
mod files;
mod fingers;
mod names;
mod propose;
mod ready;
mod robot;
mod stand;
#[cfg(test)]
mod tests;
mod zip;

pub use arms::{FoundArm, LEAST_JOINTS, find_arms};
pub use blob::Blob;
pub use boxes::MISSING_MATERIAL;
pub use build::BuiltGuest;
pub use description::{ArmDescription, ROBOT_FILE_VERSION, RobotDescription};
pub use error::GuestError;
pub use files::{Files, MAX_FILE_BYTES, MAX_FILES, MAX_TOTAL_BYTES};
pub use propose::{ArmWish, Proposal, Wishes, propose};
pub use robot::{GuestRobot, READY};
