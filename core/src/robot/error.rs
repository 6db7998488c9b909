//! What can be wrong with a robot's files, said so that the author of the file can mend it.

/// Most links a robot may have; beyond it the file is taken for a mistake.
pub const MAX_LINKS: usize = 1000;

/// A robot file that cannot be used, with the line, the thing, what was found and what was wanted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// Not well-formed XML.
    #[error("{file} is not well-formed XML: {message}")]
    Xml { file: &'static str, message: String },
    /// The outermost element is not `<robot>`.
    #[error("line {line}: {file} starts with <{found}>, wanted <robot>")]
    NotARobot { file: &'static str, line: u32, found: String },
    /// A needed attribute or element is absent.
    #[error("line {line}: {thing} has no {wanted}")]
    Missing { line: u32, thing: String, wanted: String },
    /// A number that is no number, not finite, out of range, or not as many numbers as wanted.
    #[error("line {line}: {thing}: {attribute}=\"{found}\", wanted {wanted}")]
    BadValue { line: u32, thing: String, attribute: String, found: String, wanted: &'static str },
    /// A name that is used twice.
    #[error("line {line}: {kind} {name:?} is defined a second time (first on line {first_line})")]
    DuplicateName { line: u32, kind: &'static str, name: String, first_line: u32 },
    /// A name that nothing bears.
    #[error("line {line}: {thing} names {kind} {name:?}, which does not exist")]
    UnknownName { line: u32, thing: String, kind: &'static str, name: String },
    /// A joint type that is not supported.
    #[error("line {line}: joint {joint:?} has type {found:?}, wanted fixed, revolute, continuous or prismatic")]
    UnknownJointType { line: u32, joint: String, found: String },
    /// A link that two joints move.
    #[error("line {line}: link {link:?} is moved by joint {second:?} and already by joint {first:?}")]
    TwoParents { line: u32, link: String, first: String, second: String },
    /// Joints that form a loop.
    #[error("line {line}: joint {joint:?} closes a loop: {}", links.join(" → "))]
    Cycle { line: u32, joint: String, links: Vec<String> },
    /// Links that hang together in more than one tree.
    #[error("line {line}: link {second:?} has no parent, but {first:?} is the root already")]
    TwoRoots { line: u32, first: String, second: String },
    /// No link at all.
    #[error("the robot has no links")]
    NoLinks,
    /// More links than [`MAX_LINKS`].
    #[error("the robot has {found} links, at most {limit} are read (MAX_LINKS)")]
    TooManyLinks { found: usize, limit: usize },
    /// Limits in the wrong order.
    #[error("line {line}: joint {joint:?}: lower limit {lower} is above upper limit {upper}")]
    ReversedLimit { line: u32, joint: String, lower: f64, upper: f64 },
    /// An axis without direction.
    #[error("line {line}: joint {joint:?}: axis {found:?} has no direction, wanted a vector longer than 1e-9")]
    ZeroAxis { line: u32, joint: String, found: [f64; 3] },
    /// A mimic that cannot be followed.
    #[error("line {line}: joint {joint:?} mimics {master:?}, {reason}")]
    BadMimic { line: u32, joint: String, master: String, reason: &'static str },
    /// A chain whose tip does not hang below its base.
    #[error("line {line}: group {group:?}: link {tip:?} does not descend from {base:?}")]
    NotAChain { line: u32, group: String, base: String, tip: String },
    /// Groups that contain each other.
    #[error("line {line}: group {group:?} contains itself")]
    GroupLoop { line: u32, group: String },
    /// An arm group without a moving joint.
    #[error("line {line}: arm group {group:?} has no moving joints")]
    EmptyArm { line: u32, group: String },
    /// A hand that lacks its frame link.
    #[error("line {line}: hand group {group:?} has no link {wanted:?}, which must be the hand frame H")]
    NoHandFrame { line: u32, group: String, wanted: String },
    /// A hand in pieces.
    #[error("line {line}: hand group {group:?} is not one tree: {first:?} and {second:?} both hang outside it")]
    HandInPieces { line: u32, group: String, first: String, second: String },
}
