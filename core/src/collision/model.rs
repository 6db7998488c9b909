//! A robot as convex bodies.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};

use super::hull::ConvexHull;
use super::solid::{Core, Solid};
use super::world::positive;
use crate::robot::{Geometry, JointKind, Robot};

/// Why bodies cannot be made or a checker cannot be set up.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CollisionError {
    /// A size that no body has.
    #[error("{thing}: {what} is {found}, wanted a finite number greater than 0")]
    BadSize { thing: String, what: &'static str, found: f64 },
    /// A point that is NaN or infinite.
    #[error("{thing}: point {index} is not finite")]
    PointNotFinite { thing: String, index: usize },
    /// A pose with NaN or infinite entries.
    #[error("{thing}: its pose is not finite")]
    PoseNotFinite { thing: String },
    /// More of something than memory and time are kept for.
    #[error("{thing}: {found} {what}, at most {most} are taken")]
    TooMany { thing: String, what: &'static str, found: usize, most: usize },
    /// A triangle between corners that are not there.
    #[error("{thing}: triangle {triangle} names corner {corner} of {corners}")]
    NoSuchCorner { thing: String, triangle: usize, corner: u32, corners: usize },
    /// Points in a plane, on a line, or none.
    #[error("{thing}: its {points} points span no volume")]
    NoVolume { thing: String, points: usize },
    /// An arm index beyond the robot's arms.
    #[error("there is no arm number {found}: the robot has {arms}")]
    NoSuchArm { found: usize, arms: usize },
    /// A configuration of the wrong length.
    #[error("a configuration has {found} values, wanted {wanted}")]
    WrongLength { found: usize, wanted: usize },
}

/// The robot's bodies and the pairs of links that are looked at.
#[derive(Clone, Debug)]
pub struct CollisionModel {
    pub(crate) robot: Arc<Robot>,
    /// Bodies of each link, in the link's frame L.
    pub(crate) solids_L: Vec<Vec<Solid>>,
    /// For each link, the first link of the group that fixed joints weld together.
    pub(crate) weld: Vec<usize>,
}

impl CollisionModel {
    /// Makes the bodies of all links.
    ///
    /// Looked at is every pair of links, except those of [`Robot::allowed_collisions`] and those that fixed joints weld
    /// together: their distance never changes.
    ///
    /// # Errors
    /// [`CollisionError`] naming the link whose shape has no volume or no finite size.
    pub fn new(robot: &Robot) -> Result<Self, CollisionError> {
        let solids_L = robot
            .links
            .iter()
            .map(|link| link.collisions.iter().map(|body| solid(&link.name, &body.geometry, &body.X_LC)).collect())
            .collect::<Result<Vec<Vec<Solid>>, _>>()?;
        let mut weld: Vec<usize> = (0..robot.links.len()).collect();
        for joint in &robot.joints {
            if joint.kind == JointKind::Fixed && joint.child < weld.len() && joint.parent < weld.len() {
                weld[joint.child] = weld[joint.parent];
            }
        }
        Ok(Self { robot: Arc::new(robot.clone()), solids_L, weld })
    }

    /// The robot that the bodies were made from.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Number of bodies.
    pub fn body_count(&self) -> usize {
        self.solids_L.iter().map(Vec::len).sum()
    }

    /// Whether two different links are looked at.
    pub(crate) fn looked_at(&self, a: usize, b: usize) -> bool {
        a != b
            && self.weld[a] != self.weld[b]
            && self.robot.allowed_collisions.binary_search(&(a.min(b), a.max(b))).is_err()
    }
}

/// The body of one geometry of a link.
fn solid(link: &str, geometry: &Geometry, X_LC: &Isometry3<f64>) -> Result<Solid, CollisionError> {
    if !X_LC.translation.vector.iter().chain(X_LC.rotation.coords.iter()).all(|x| x.is_finite()) {
        return Err(CollisionError::PoseNotFinite { thing: link.to_owned() });
    }
    let (core, radius) = match geometry {
        Geometry::Box { size_m } => {
            for edge in size_m.iter() {
                positive(link, "box edge", *edge)?;
            }
            (Core::Box { half: 0.5 * size_m }, 0.0)
        }
        Geometry::Cylinder { radius_m, length_m } => {
            positive(link, "cylinder radius", *radius_m)?;
            positive(link, "cylinder length", *length_m)?;
            (Core::Cylinder { radius: *radius_m, half_length: 0.5 * length_m }, 0.0)
        }
        Geometry::Sphere { radius_m } => {
            positive(link, "sphere radius", *radius_m)?;
            (Core::Segment { a: Vector3::zeros(), b: Vector3::zeros() }, *radius_m)
        }
        Geometry::Capsule { radius_m, length_m } => {
            positive(link, "capsule radius", *radius_m)?;
            positive(link, "capsule length", *length_m)?;
            let half = Vector3::z() * (0.5 * length_m);
            (Core::Segment { a: -half, b: half }, *radius_m)
        }
        Geometry::Mesh { file, mesh } => {
            (Core::Hull(ConvexHull::new(&format!("{link} ({file})"), &mesh.positions)?), 0.0)
        }
    };
    Ok(Solid::new(core, radius, X_LC))
}
