//! Why there is no map.

use crate::collision::CollisionError;
use crate::robot::ChainError;
use crate::robot::ik::NotSrs;

/// Why a map cannot be built or read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReachError {
    /// Voxels too small or too large.
    #[error("the voxels are {found} m wide, wanted 0.005 to 0.5")]
    BadVoxel { found: f64 },
    /// A number of orientations that there is no set of.
    #[error("{found} orientations, wanted 1 (positions only), 40 or 272")]
    BadOrientations { found: usize },
    /// A number of samples that is none, or more than their numbers count.
    #[error("{found} samples, wanted 1 to {most}")]
    BadSamples { found: usize, most: usize },
    /// More of something than memory is kept for.
    #[error("{found} {what}, at most {most} are kept: take larger voxels or fewer orientations")]
    TooMany { what: &'static str, found: f64, most: f64 },
    /// An arm index beyond the robot's arms.
    #[error("there is no arm number {found}: the robot has {arms}")]
    NoSuchArm { found: usize, arms: usize },
    /// The joints of the arm are not those that move its hand.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// The robot's bodies cannot be made.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// Inverse sampling of an arm without a closed form.
    #[error("the arm has no closed form, sample it forward: {because}")]
    NoClosedForm { because: NotSrs },
    /// Inverse sampling of an arm behind more than one other joint.
    #[error("{found} joints before the arm, at most 1 is sampled: sample the arm forward")]
    TooManyJoints { found: usize },
    /// Inverse sampling without orientations.
    #[error("inverse sampling needs 40 or 272 orientations: sample positions forward")]
    NeedsOrientations,
    /// Told to stop.
    #[error("cancelled")]
    Cancelled,
    /// A file that is no map, is damaged, or is of another version.
    #[error("{place}: found {found}, wanted {wanted}")]
    BadFile { place: &'static str, found: String, wanted: String },
    /// A map of another robot, arm, hand, or with other limits.
    #[error("the map is one of {found}, wanted one of {wanted}")]
    OtherArm { found: String, wanted: String },
}
