//! Reachability maps (thesis 6.1): which poses of its hand an arm reaches, how freely, and by which configuration.
//!
//! A [`ReachMap`] is a grid of voxels in the frame of the arm's base, with a set of [`Orientations`] in each. Two ways
//! lead to one: [`build_inverse`] solves each of these poses for the joints in closed form (S-R-S arms, also behind a
//! turning torso: [`crate::robot::Robot::with_torso`]), [`build_forward`] draws configurations of any arm and sorts
//! them into the poses that they reach. [`ReachMap::to_bytes`] and [`ReachMap::from_bytes`] keep a map in a file.
//!
//! What a map does not know: obstacles, the other arm (its links can be moved out of the way, so they do not count as
//! something to touch), and what the hand carries. A pose that is not reached at its point and orientation may be
//! reached at another point or orientation of the same voxel.

mod about;
mod bytes;
mod clear;
mod closed;
mod error;
mod file;
mod forward;
mod grid;
mod inverse;
mod map;
mod orientations;
mod recipe;
mod scale;
mod spots;
#[cfg(test)]
mod tests;

pub use about::{About, MappedArm, ReachMethod};
pub use error::ReachError;
pub use forward::{ForwardSettings, build_forward};
pub use inverse::{InverseSettings, build_inverse};
pub use map::{ReachMap, Voxel};
pub use orientations::Orientations;
