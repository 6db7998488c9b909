//! Why an arm configuration is not used.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::collision::Hit;
use crate::robot::ik::{IkReject, Length};

/// Why a configuration of the arm does not count among those that reach a grasp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Obstruction {
    /// The whole pose is beyond the stretched arm.
    OutOfReach { gap_m: f64 },
    /// The whole pose is nearer to the shoulder than the folded arm reaches.
    TooClose { gap_m: f64 },
    /// A joint, counted from 1 at the shoulder, would leave its limits.
    JointLimit { joint: usize },
    /// A numeric search came no nearer than this.
    Stalled { gap_m: f64, gap_rad: f64 },
    /// Two bodies would meet.
    Collision { a: String, b: String },
    /// The question itself makes no sense; the sentence says why.
    Invalid { reason: String },
}

impl From<&IkReject> for Obstruction {
    fn from(reject: &IkReject) -> Self {
        match *reject {
            IkReject::OutOfReach { gap_m } => Self::OutOfReach { gap_m },
            IkReject::TooClose { gap_m } => Self::TooClose { gap_m },
            IkReject::JointLimit { joint, .. } => Self::JointLimit { joint: joint + 1 },
            IkReject::Stalled { gap_m, gap_rad } => Self::Stalled { gap_m, gap_rad },
        }
    }
}

impl From<Hit> for Obstruction {
    fn from(Hit { a, b }: Hit) -> Self {
        Self::Collision { a, b }
    }
}

impl fmt::Display for Obstruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfReach { gap_m } => write!(f, "out of reach by {}", Length(*gap_m)),
            Self::TooClose { gap_m } => write!(f, "too close to the shoulder by {}", Length(*gap_m)),
            Self::JointLimit { joint } => write!(f, "joint {joint} limit"),
            Self::Stalled { gap_m, gap_rad } => {
                write!(f, "no posture found: {} and {:.0}° short", Length(*gap_m), gap_rad.to_degrees())
            }
            Self::Collision { a, b } => write!(f, "{a} hits {b}"),
            Self::Invalid { reason } => write!(f, "{reason}"),
        }
    }
}
