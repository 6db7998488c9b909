//! How closely a handover is looked for: quickly first, thoroughly where that finds nothing.

/// Tilts of the receiver's approach against the line of the shoulders, or of the object against its pose on the way,
/// rad, about two axes across it; the first of them are enough for most.
const TILTS: [[f64; 2]; 9] =
    [[0.0, 0.0], [0.6, 0.0], [-0.6, 0.0], [0.0, 0.6], [0.0, -0.6], [1.2, 0.0], [-1.2, 0.0], [0.0, 1.2], [0.0, -1.2]];

/// How much is looked at before a handover is given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effort {
    /// What nearly always contains a good one.
    Quick,
    /// Everything.
    Thorough,
}

impl Effort {
    /// In the order in which they are made.
    pub(super) const ALL: [Self; 2] = [Self::Quick, Self::Thorough];

    /// Poses of a soft goal that are looked at.
    pub(super) fn poses(self) -> usize {
        match self {
            Self::Quick => 24,
            Self::Thorough => usize::MAX,
        }
    }

    /// Poses of a soft goal that a grasp serves before no further ones are looked at.
    pub(super) fn served_poses(self) -> usize {
        match self {
            Self::Quick => 3,
            Self::Thorough => 8,
        }
    }

    /// Receiver's grasps that are tried at one spot.
    pub(super) fn tried_grasps(self) -> usize {
        match self {
            Self::Quick => 6,
            Self::Thorough => usize::MAX,
        }
    }

    /// Tilts of the receiver's hand.
    pub(super) fn tilts(self) -> &'static [[f64; 2]] {
        match self {
            Self::Quick => &TILTS[..5],
            Self::Thorough => &TILTS,
        }
    }

    /// Tilts of the object where the hands follow from it.
    pub(super) fn object_tilts(self) -> &'static [[f64; 2]] {
        match self {
            Self::Quick => &TILTS[..1],
            Self::Thorough => &TILTS,
        }
    }
}
