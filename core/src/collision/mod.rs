//! Who touches whom: robot with itself, with the scene, and with what it carries.
//!
//! [`CollisionModel`] is the robot as convex bodies, [`World`] the named obstacles, [`CarriedObject`] what a hand
//! holds, and [`MayTouch`] the contacts that are intended. A [`Checker`] is built from them once and then answers for
//! many configurations: [`Checker::first_hit`] names a colliding pair, [`Checker::distance`] the smallest clearance.
//! [`HandChecker`] asks only for a hand that is placed somewhere without its arm, which drops hopeless grasps early.
//!
//! Capsules, spheres and boxes meet in closed form; everything else goes through parry's GJK, wrapped in one file.
//! All bodies are convex: a mesh counts as its convex hull. [`Exhaustive`] answers the same question with
//! parry's own shapes and no shortcut at all; it is the independent judge of everything above.

mod ball;
mod build;
mod checker;
mod closed_form;
mod exhaustive;
mod frames;
mod hand;
mod hull;
mod model;
mod narrow;
mod parry;
mod query;
mod setup;
mod solid;
#[cfg(test)]
pub(crate) mod testing;
mod touching;
mod triangles;
mod world;

pub use ball::BallChecker;
pub use checker::{Checker, Clearance, Hit, Scratch};
pub(crate) use checker::{Pair, State};
pub use exhaustive::Exhaustive;
pub use hand::HandChecker;
pub use hull::ConvexHull;
pub use model::{CollisionError, CollisionModel};
pub use setup::{CarriedObject, MayTouch, Party};
pub use triangles::TriangleSurface;
pub use world::World;
