//! Who touches whom: robot with itself, with the scene, and with what it carries.
//!
//! [`CollisionModel`] is the robot as convex bodies, [`World`] the named obstacles, [`CarriedObject`] what a hand
//! holds, and [`MayTouch`] the contacts that are intended. A [`Checker`] is built from them once and then answers for
//! many configurations: [`Checker::first_hit`] names a colliding pair, [`Checker::distance`] the smallest clearance.
//! [`HandChecker`] asks only for a hand that is placed somewhere without its arm, which drops hopeless grasps early.
//!
//! Lists of configurations go through [`Checker::first_hit_of_all`]: a sieve looks at several side by side, with every
//! moving body inside a few capsules, and passes what it is sure of; the exact checker looks at the rest. Motions are
//! proven by the same sieve. Many obstacles stand in a tree of boxes.
//!
//! Capsules, spheres and boxes meet in closed form; everything else goes through parry's GJK, wrapped in one file.
//! All bodies are convex: a link's mesh counts as its convex hull, an obstacle's as its triangles
//! ([`World::add_mesh`]), and points without a shape as the boxes of the cells that they occupy ([`World::add_cloud`]).
//! [`Exhaustive`] answers the same question with parry's own shapes and no shortcut at all; it is the independent judge
//! of everything above.

mod allowed;
mod ball;
mod batch;
mod build;
mod checker;
mod clearance;
mod closed_form;
mod cover;
mod exhaustive;
mod frames;
mod hand;
mod hull;
mod lanes;
mod model;
mod narrow;
mod parry;
mod query;
mod setup;
mod sieve;
mod solid;
#[cfg(test)]
pub(crate) mod testing;
mod touching;
mod tree;
mod triangles;
mod voxels;
mod world;

pub use allowed::{AllowedCollisions, AllowedPair, AllowedReason};
pub use ball::BallChecker;
pub(crate) use batch::Sifted;
pub use checker::{Checker, Clearance, Hit, Scratch};
pub(crate) use checker::{Owner, Pair, State};
pub use exhaustive::Exhaustive;
pub use hand::HandChecker;
pub use hull::ConvexHull;
pub(crate) use lanes::LANES;
pub use model::{CollisionError, CollisionModel};
pub use setup::{CarriedObject, MayTouch, Party};
pub use triangles::TriangleSurface;
pub use voxels::{CloudBoxes, MOST_BOXES, MOST_CELLS};
pub use world::{MOST_TRIANGLES, World};
