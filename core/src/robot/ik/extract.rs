//! Recognises an S-R-S arm in a robot and takes its lengths, axes and fixed transforms from it.

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

use super::ball::Ball;
use crate::robot::{Arm, JointKind, JointLimit, Robot};

/// How far axes may miss each other, metres, and how far right angles may be off, radians: what is lost when a URDF
/// is written with six decimals.
pub(super) const TOLERANCE: f64 = 2e-6;

/// Why an arm is not of the S-R-S kind.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotSrs {
    /// Not seven joints between base and hand.
    #[error("{found} joints between {base:?} and {tip:?}, wanted 7")]
    JointCount { base: String, tip: String, found: usize },
    /// The tip does not hang below the base.
    #[error("link {tip:?} does not descend from {base:?}")]
    NotAChain { base: String, tip: String },
    /// A joint that slides, or copies another one.
    #[error("joint {joint:?} does not turn by itself")]
    NotRevolute { joint: String },
    /// Axes that must meet in a point, do not.
    #[error("the axes of joints {joints} miss each other by {miss_m} m, at most {TOLERANCE} is read as meeting")]
    AxesMiss { joints: &'static str, miss_m: f64 },
    /// Axes that must be perpendicular, are not.
    #[error("the axes of joints {joints} are {off_rad} rad off the right angle")]
    NotPerpendicular { joints: &'static str, off_rad: f64 },
    /// Upper arm or forearm has no length.
    #[error("the segment from {segment} has no length")]
    NoLength { segment: &'static str },
}

/// An S-R-S arm, ready to be solved. All vectors are at q = 0 in the frame B of the arm's base link.
#[derive(Clone, Debug)]
pub struct SrsArm {
    pub(super) shoulder: Ball,
    pub(super) wrist: Ball,
    /// Axis of the elbow.
    pub(super) a4: Vector3<f64>,
    /// Shoulder centre.
    pub(super) p_BS: Vector3<f64>,
    /// S to E at q = 0.
    pub(super) v_SE: Vector3<f64>,
    /// E to W at q = 0.
    pub(super) v_EW: Vector3<f64>,
    /// Wrist centre in the hand.
    pub(super) p_HW: Point3<f64>,
    /// Rotation of the hand at q = 0, transposed.
    pub(super) R_HB0: Matrix3<f64>,
    /// Length |SE|, metres.
    pub(super) upper_m: f64,
    /// Length |EW|, metres.
    pub(super) fore_m: f64,
    /// Signed angle from SE to EW about `a4` at q = 0.
    pub(super) elbow0: f64,
    /// Directions from which the arm angle is counted: the first, or the second when SW lies along the first.
    pub(super) references: [Vector3<f64>; 2],
    pub(super) limits: [JointLimit; 7],
}

impl SrsArm {
    /// The arm with its hand frame H as the tip.
    ///
    /// # Errors
    /// [`NotSrs`] when the arm is of another kind.
    pub fn of(robot: &Robot, arm: &Arm) -> Result<Self, NotSrs> {
        Self::between(robot, arm.base_link, arm.hand.tcp_link)
    }

    /// The seven joints between two links; the tip's frame is the hand frame H, the base's frame is B.
    ///
    /// # Errors
    /// [`NotSrs`] when the chain is of another kind.
    pub fn between(robot: &Robot, base_link: usize, tip_link: usize) -> Result<Self, NotSrs> {
        let name = |link: usize| robot.links.get(link).map_or_else(String::new, |link| link.name.clone());
        let no_chain = || NotSrs::NotAChain { base: name(base_link), tip: name(tip_link) };
        if base_link >= robot.links.len() || tip_link >= robot.links.len() {
            return Err(no_chain());
        }
        let chain = robot.chain(base_link, tip_link).ok_or_else(no_chain)?;
        let moving: Vec<_> =
            chain.iter().map(|&joint| &robot.joints[joint]).filter(|joint| joint.kind != JointKind::Fixed).collect();
        if let Some(joint) = moving.iter().find(|joint| joint.kind != JointKind::Revolute || joint.dof.is_none()) {
            return Err(NotSrs::NotRevolute { joint: joint.name.clone() });
        }
        let count = |found| NotSrs::JointCount { base: name(base_link), tip: name(tip_link), found };
        let joints: [_; 7] = moving.try_into().map_err(|moving: Vec<_>| count(moving.len()))?;

        let X_WL = robot.link_poses(&vec![0.0; robot.dof_count()]);
        let X_BW = X_WL[base_link].inverse();
        let X_BL: [Isometry3<f64>; 7] = joints.map(|joint| X_BW * X_WL[joint.child]);
        let axis = |i: usize| Unit::new_unchecked(X_BL[i].rotation * joints[i].axis.into_inner());
        let axes: [Unit<Vector3<f64>>; 7] = std::array::from_fn(axis);
        let lines: [Line; 7] = std::array::from_fn(|i| Line { p: X_BL[i].translation.vector, a: axes[i] });

        let S = lines[1].nearest_to(&lines[0]);
        let W = lines[5].nearest_to(&lines[4]);
        let E = lines[3].nearest_to(&lines[2]);
        let meets = |joints, point: &Vector3<f64>, through: &[usize]| {
            let miss_m = through.iter().map(|&i| lines[i].distance_to(point)).fold(0.0, f64::max);
            if miss_m <= TOLERANCE { Ok(()) } else { Err(NotSrs::AxesMiss { joints, miss_m }) }
        };
        meets("1, 2 and 3", &S, &[0, 1, 2])?;
        meets("5, 6 and 7", &W, &[4, 5, 6])?;
        meets("3, 4 and 5", &E, &[2, 3, 4])?;
        for (joints, a, b) in [
            ("1 and 2", 0, 1),
            ("2 and 3", 1, 2),
            ("3 and 4", 2, 3),
            ("4 and 5", 3, 4),
            ("5 and 6", 4, 5),
            ("6 and 7", 5, 6),
        ] {
            let off_rad = axes[a].dot(&axes[b]).abs();
            if off_rad > TOLERANCE {
                return Err(NotSrs::NotPerpendicular { joints, off_rad });
            }
        }
        let (v_SE, v_EW) = (E - S, W - E);
        for (segment, v) in [("shoulder to elbow", v_SE), ("elbow to wrist", v_EW)] {
            if v.norm() < 1e-3 {
                return Err(NotSrs::NoLength { segment });
            }
        }
        let a4 = axes[3].into_inner();
        let X_BH = X_BW * X_WL[tip_link];
        let side = axes[1].into_inner();
        Ok(Self {
            shoulder: Ball::new(&axes[0], &axes[1], &axes[2]),
            wrist: Ball::new(&axes[4], &axes[5], &axes[6]),
            a4,
            p_BS: S,
            v_SE,
            v_EW,
            p_HW: X_BH.inverse() * Point3::from(W),
            R_HB0: X_BH.rotation.to_rotation_matrix().into_inner().transpose(),
            upper_m: v_SE.norm(),
            fore_m: v_EW.norm(),
            elbow0: crate::math::atan2(v_SE.cross(&v_EW).dot(&a4), v_SE.dot(&v_EW)),
            references: [axes[0].into_inner(), side],
            limits: joints.map(|joint| joint.limit),
        })
    }

    /// Lengths |SE| and |EW|, metres.
    pub fn lengths_m(&self) -> (f64, f64) {
        (self.upper_m, self.fore_m)
    }

    /// Shoulder centre S in the frame of the arm's base link, metres.
    pub fn shoulder(&self) -> Point3<f64> {
        Point3::from(self.p_BS)
    }

    /// Wrist centre W in the hand frame H, metres.
    pub fn wrist(&self) -> Point3<f64> {
        self.p_HW
    }

    /// Limits from shoulder to wrist.
    pub fn limits(&self) -> &[JointLimit; 7] {
        &self.limits
    }
}

/// A joint axis in space.
pub(super) struct Line {
    pub(super) p: Vector3<f64>,
    pub(super) a: Unit<Vector3<f64>>,
}

impl Line {
    /// The point of this line that is nearest to another line; `p` when they are parallel.
    pub(super) fn nearest_to(&self, other: &Self) -> Vector3<f64> {
        let between = other.p - self.p;
        let cosine = self.a.dot(&other.a);
        let sine2 = 1.0 - cosine * cosine;
        if sine2 < 1e-12 {
            return self.p;
        }
        self.p + self.a.into_inner() * ((between.dot(&self.a) - cosine * between.dot(&other.a)) / sine2)
    }

    pub(super) fn distance_to(&self, point: &Vector3<f64>) -> f64 {
        (point - self.p).cross(&self.a).norm()
    }
}
