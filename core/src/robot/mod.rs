//! Robots: URDF + SRDF, kinematics, limits, hands, inverse kinematics.

mod kinematics;
mod model;

pub use model::{
    Arm, CollisionBody, Geometry, Hand, Joint, JointKind, JointLimit, Link, Material, Mimic, Robot, Visual,
};
