//! What inverse kinematics answers: solutions, and a typed reason for each branch that is none.

/// One joint posture of an arm that puts the hand where it was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkSolution {
    /// Joint positions from shoulder to wrist, radians, within the limits.
    pub q: [f64; 7],
    /// Arm angle, radians.
    pub arm_angle: f64,
    /// Branch 0..8: bit 2 elbow, bit 1 wrist, bit 0 shoulder.
    pub branch: u8,
}

/// Why there is no solution, for the whole pose or for one branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IkReject {
    /// The wrist would have to be farther from the shoulder than the stretched arm.
    OutOfReach {
        /// Missing length, metres.
        gap_m: f64,
    },
    /// The wrist would have to be nearer to the shoulder than the folded arm.
    TooClose {
        /// Missing distance, metres.
        gap_m: f64,
    },
    /// A joint would leave its limits.
    JointLimit {
        /// Joint of the arm, 0 at the shoulder; joints before an S-R-S arm are not counted.
        joint: usize,
        /// Position it would need, radians (metres if it slides).
        value: f64,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// No posture makes the rotation (of six joints in closed form), or a numeric search came no nearer than this.
    Stalled {
        /// Distance left, metres.
        gap_m: f64,
        /// Rotation left, radians.
        gap_rad: f64,
    },
}

impl IkReject {
    /// The reason in a few words, the same for every pose it applies to: `joint 6 limit`.
    pub fn reason(&self) -> String {
        match self {
            Self::OutOfReach { .. } => "out of reach".to_owned(),
            Self::TooClose { .. } => "too close to the shoulder".to_owned(),
            Self::JointLimit { joint, .. } => format!("joint {} limit", joint + 1),
            Self::Stalled { .. } => "no solution found".to_owned(),
        }
    }
}

impl std::fmt::Display for IkReject {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::OutOfReach { gap_m } => write!(f, "out of reach by {}", Length(*gap_m)),
            Self::TooClose { gap_m } => write!(f, "too close to the shoulder by {}", Length(*gap_m)),
            Self::JointLimit { joint, value, lower, upper } => {
                write!(f, "joint {} limit: would be at {value:.2}, may be {lower:.2} to {upper:.2}", joint + 1)
            }
            Self::Stalled { gap_m, gap_rad } => {
                write!(f, "no solution found: {} and {:.0}° short", Length(*gap_m), gap_rad.to_degrees())
            }
        }
    }
}

/// A length as a person says it: `4 cm`, `7 mm`.
pub(crate) struct Length(pub(crate) f64);

impl std::fmt::Display for Length {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            m if m >= 0.0195 => write!(f, "{:.0} cm", m * 1e2),
            m if m >= 0.5e-3 => write!(f, "{:.0} mm", m * 1e3),
            _ => write!(f, "less than 1 mm"),
        }
    }
}

/// The solutions of one pose at one or many arm angles, in the order of arm angle and branch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IkSet {
    /// Postures within the limits.
    pub solutions: Vec<IkSolution>,
    /// One reason for each branch that is no solution, or one for the whole pose.
    pub rejected: Vec<IkReject>,
}

impl IkSet {
    /// Forgets everything but keeps the memory.
    pub fn clear(&mut self) {
        self.solutions.clear();
        self.rejected.clear();
    }

    /// Reasons with their counts, most frequent first.
    pub fn reject_counts(&self) -> Vec<(String, usize)> {
        let mut counts: Vec<(String, usize)> = Vec::new();
        for reason in self.rejected.iter().map(IkReject::reason) {
            match counts.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, count)) => *count += 1,
                None => counts.push((reason, 1)),
            }
        }
        counts.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        counts
    }
}
