//! Why what somebody brought cannot be used, said so that they can mend it.

use crate::robot::{HandError, RobotError};

/// A file, a folder or an archive that holds no robot that could act.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GuestError {
    /// No robot among the files.
    #[error("found no URDF among {count} files ({}), wanted a file that ends in .urdf", shown.join(", "))]
    NoUrdf { count: usize, shown: Vec<String> },
    /// More than one robot, and nothing that says which.
    #[error("found {} URDF files ({}), wanted one, or a .robot.json that names one of them", found.len(), found.join(", "))]
    SeveralUrdfs { found: Vec<String> },
    /// A macro file in place of a robot.
    #[error("{file}: found xacro macros, wanted plain URDF: expand it first (xacro {file} > robot.urdf)")]
    Xacro { file: String },
    /// An archive that cannot be unpacked.
    #[error("{archive}: {place}: found {found}, wanted {wanted}")]
    Zip { archive: String, place: String, found: String, wanted: String },
    /// More or larger files than are read.
    #[error("{thing}: found {found}, at most {limit} are read ({limit_name})")]
    TooMuch { thing: String, found: u64, limit: u64, limit_name: &'static str },
    /// The robot's own files.
    #[error("{file}: {source}")]
    Robot { file: String, source: RobotError },
    /// The description beside the robot.
    #[error("{file}: not a robot description: {reason}")]
    Format { file: String, reason: String },
    /// A number or a name of the description that does not fit.
    #[error("{place}: found {found}, wanted {wanted}")]
    Value { place: String, found: String, wanted: String },
    /// A link that the robot does not have.
    #[error("{place}: the robot has no link {name:?}; it has {}", known.join(", "))]
    UnknownLink { place: String, name: String, known: Vec<String> },
    /// Two links with no chain between them.
    #[error("{place}: link {tip:?} does not descend from {base:?}, wanted a tip below the base")]
    NotAChain { place: String, base: String, tip: String },
    /// An arm that cannot move a hand about.
    #[error("{place}: found {found} moving joints from {base:?} to {tip:?}, wanted at least {wanted}")]
    ShortArm { place: String, base: String, tip: String, found: usize, wanted: usize },
    /// An arm that shall use fingers of its own and has none.
    #[error("{place}: no joint below {tip:?} moves a body, so there are no fingers; give it a hand description")]
    NoFingers { place: String, tip: String },
    /// A name that this program needs.
    #[error("the robot has a {kind} {name:?} already, a name that this program gives: rename it in the URDF")]
    NameTaken { kind: &'static str, name: String },
    /// The hand that it was given.
    #[error("{place}: {source}")]
    Hand { place: String, source: HandError },
}
