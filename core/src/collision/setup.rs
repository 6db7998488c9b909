//! What a hand carries, and which contacts are intended.

use nalgebra::Isometry3;

use super::hull::ConvexHull;
use super::model::CollisionError;
use super::solid::{Core, Solid};
use crate::robot::Robot;

/// An object O of convex pieces that is fixed to a hand frame H.
#[derive(Clone, Debug)]
pub struct CarriedObject {
    pub(crate) name: String,
    pub(crate) tcp_link: usize,
    pub(crate) solids_H: Vec<Solid>,
    pub(crate) touching: Vec<usize>,
}

impl CarriedObject {
    /// An object of convex pieces in its frame O, carried by an arm of the robot; all links of its hand may touch it.
    ///
    /// * `arm`: index into [`Robot::arms`].
    /// * `X_HO`: pose of the object in the hand frame.
    ///
    /// # Errors
    /// [`CollisionError`] if there is no such arm.
    pub fn new(
        name: &str,
        pieces_O: &[ConvexHull],
        X_HO: &Isometry3<f64>,
        robot: &Robot,
        arm: usize,
    ) -> Result<Self, CollisionError> {
        let hand = &robot.arms.get(arm).ok_or(CollisionError::NoSuchArm { found: arm, arms: robot.arms.len() })?.hand;
        Ok(Self {
            name: name.to_owned(),
            tcp_link: hand.tcp_link,
            solids_H: pieces_O.iter().map(|hull| Solid::new(Core::Hull(hull.clone()), 0.0, X_HO)).collect(),
            touching: hand.links.clone(),
        })
    }
}

/// One side of an intended contact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Party {
    /// A link of the robot, by index.
    Link(usize),
    /// An obstacle of the world, by name; a name that is not in the world is ignored.
    Obstacle(String),
    /// The carried object.
    Carried,
}

/// A contact that is intended: the two may touch, down to a depth.
#[derive(Clone, Debug, PartialEq)]
pub struct MayTouch {
    /// One of them.
    pub a: Party,
    /// The other.
    pub b: Party,
    /// How far one may sink into the other, metres; infinity means that the pair is not looked at.
    pub depth_m: f64,
}

impl MayTouch {
    /// All links of a hand may touch an obstacle: fingers around the object that they are about to grasp.
    pub fn hand(robot: &Robot, arm: usize, obstacle: &str) -> Vec<Self> {
        let links = robot.arms.get(arm).map(|arm| arm.hand.links.as_slice()).unwrap_or_default();
        let contact =
            |&link| Self { a: Party::Link(link), b: Party::Obstacle(obstacle.to_owned()), depth_m: f64::INFINITY };
        links.iter().map(contact).collect()
    }

    /// The carried object may rest on an obstacle: noise of a fit sinks it by a few millimetres.
    pub fn carried(obstacle: &str, depth_m: f64) -> Self {
        Self { a: Party::Carried, b: Party::Obstacle(obstacle.to_owned()), depth_m }
    }
}
