//! The robot as data: links, joints, arms and hands, read from URDF and SRDF and valid from then on.

use std::sync::Arc;

use nalgebra::{Isometry3, Unit, Vector3};

use crate::mesh::Mesh;

/// A robot: a tree of links, with the arms, hands and postures that its SRDF names.
///
/// `q` always means one value per degree of freedom (non-fixed, non-mimic joint), in the order of the URDF:
/// radians for revolute joints, metres for prismatic ones.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name in the URDF.
    pub name: String,
    /// Links; index 0 is the root, every parent stands before its children.
    pub links: Vec<Link>,
    /// Joints; joint `i` moves link `i + 1`.
    pub joints: Vec<Joint>,
    /// Joint index of each degree of freedom.
    pub dof_joints: Vec<usize>,
    /// Arms in the order of the SRDF; Crichton and Alita have `left` and `right`.
    pub arms: Vec<Arm>,
    /// Named postures: name and a full `q` (degrees of freedom that the SRDF does not mention are 0).
    pub postures: Vec<(String, Vec<f64>)>,
    /// Pairs of link indices, smaller first and sorted, that need not be looked at: computed, and listed in the SRDF
    /// ([`crate::collision::AllowedCollisions`]).
    pub allowed_collisions: Vec<(usize, usize)>,
}

/// One rigid body.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name in the URDF.
    pub name: String,
    /// What is drawn.
    pub visuals: Vec<Visual>,
    /// What collides.
    pub collisions: Vec<CollisionBody>,
}

/// One drawn body of a link.
#[derive(Clone, Debug)]
pub struct Visual {
    /// Pose of the body in the link.
    pub X_LV: Isometry3<f64>,
    /// Its shape.
    pub geometry: Geometry,
    /// Its material.
    pub material: Material,
}

/// One colliding body of a link.
#[derive(Clone, Debug)]
pub struct CollisionBody {
    /// Pose of the body in the link.
    pub X_LC: Isometry3<f64>,
    /// Its shape; meshes count as their convex hull.
    pub geometry: Geometry,
}

/// A named colour; the name tells the renderer which surface it is (shell, joint, accent, rubber, metal).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the URDF.
    pub name: String,
    /// sRGB and opacity in [0, 1].
    pub rgba: [f32; 4],
}

/// A shape, metres; cylinders and capsules lie along z, centred.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// A box with these edge lengths.
    Box { size_m: Vector3<f64> },
    /// A cylinder.
    Cylinder { radius_m: f64, length_m: f64 },
    /// A sphere.
    Sphere { radius_m: f64 },
    /// A capsule; `length_m` is the length of its cylindrical part.
    Capsule { radius_m: f64, length_m: f64 },
    /// A mesh read from the file of this name, already scaled.
    Mesh { file: String, mesh: Arc<Mesh> },
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Does not move.
    Fixed,
    /// Turns about its axis.
    Revolute,
    /// Slides along its axis.
    Prismatic,
}

/// A joint between a parent link and the child link that it moves.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// Pose of the joint frame in the parent link at q = 0.
    pub X_PJ: Isometry3<f64>,
    /// Axis in the joint frame.
    pub axis: Unit<Vector3<f64>>,
    /// Limits; a continuous joint gets ±π for planning. Unused when fixed.
    pub limit: JointLimit,
    /// The joint that this one copies, if any.
    pub mimic: Option<Mimic>,
    /// Index into `q`, for joints that are neither fixed nor mimics.
    pub dof: Option<usize>,
}

/// Limits of a joint, `lower <= upper`, all finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimit {
    /// Lower position, rad or m.
    pub lower: f64,
    /// Upper position, rad or m.
    pub upper: f64,
    /// Speed, rad/s or m/s, greater than 0.
    pub velocity: f64,
    /// Acceleration, rad/s² or m/s², greater than 0. `<limit acceleration>` is ours; without it the joint takes
    /// one second to its top speed.
    pub acceleration: f64,
    /// Jerk, rad/s³ or m/s³, greater than 0. `<limit jerk>` is ours; without it the joint takes a tenth of a second
    /// to its acceleration.
    pub jerk: f64,
}

/// A mimic joint's position is `multiplier * q[dof] + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mimic {
    /// Degree of freedom that is copied.
    pub dof: usize,
    /// Factor.
    pub multiplier: f64,
    /// Offset, rad or m.
    pub offset: f64,
}

/// A serial arm and the hand it carries.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Group name in the SRDF: `left`, `right`.
    pub name: String,
    /// Degrees of freedom from shoulder to wrist, indices into `q`.
    pub dofs: Vec<usize>,
    /// Link that carries the first joint.
    pub base_link: usize,
    /// Flange link E, the last link moved by the arm's joints (or fixed to it).
    pub flange_link: usize,
    /// The hand.
    pub hand: Hand,
}

/// A hand, as grasping needs it.
#[derive(Clone, Debug)]
pub struct Hand {
    /// Group name in the SRDF: `left_hand`.
    pub name: String,
    /// All links of the hand, palm first.
    pub links: Vec<usize>,
    /// Palm link.
    pub palm_link: usize,
    /// Link whose frame is the hand frame H (thesis 4.1: x closing direction, z approach): `left_tcp`.
    pub tcp_link: usize,
    /// Degrees of freedom that close the hand, finger by finger, proximal before distal; one finger per list.
    pub fingers: Vec<Vec<usize>>,
    /// Open posture, one value per entry of `fingers` flattened.
    pub open: Vec<f64>,
    /// Closed posture, same order: where closing ends when nothing is met.
    pub closed: Vec<f64>,
}
