//! Robots: URDF + SRDF, kinematics, limits, hands, inverse kinematics.

mod beside;
mod chain;
mod dexterity;
mod error;
mod hand_attach;
mod hand_description;
pub mod ik;
mod kinematics;
mod mesh_file;
mod model;
#[cfg(test)]
mod receivers_test;
#[cfg(test)]
pub(crate) mod samples;
#[cfg(test)]
mod shapes_test;
mod srdf;
mod standing;
mod start;
mod tree;
mod trig;
mod urdf;
mod xml;

pub use chain::{Chain, ChainError, ChainState};
pub use dexterity::{Dexterity, Placed};
pub(crate) use dexterity::{Rough, RoughDexterity};
pub use error::{MAX_LINKS, RobotError};
pub use hand_description::{HAND_VERSION, HandDescription, HandError, HandFrame, Placement};
pub use model::{
    Arm, CollisionBody, Geometry, Hand, Joint, JointKind, JointLimit, Link, Material, Mimic, Robot, Visual,
};
pub(crate) use srdf::srdf_hints;
pub use srdf::{apply_srdf, load_robot};
pub use start::StartError;
pub use urdf::{
    DEFAULT_SECONDS_TO_ACCELERATION, DEFAULT_SECONDS_TO_TOP_SPEED, MissingMesh, Resolve, read_urdf,
    read_urdf_and_missing,
};
