//! The one file that speaks parry's language (glam): GJK and EPA on our bodies, hulls, and parry's own shapes.
//!
//! Our bodies are handed to GJK in world coordinates, so the relative pose that parry passes along is always the
//! identity and is ignored.

use nalgebra::{Isometry3, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::details::contact_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::{SharedShape, SupportMap};

use super::frames::Rigid;
use super::solid::Core;

pub(super) fn to_parry(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(super) fn from_parry(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

fn pose_to_parry(X: &Isometry3<f64>) -> Pose {
    let r = X.rotation.coords;
    Pose::from_parts(to_parry(&X.translation.vector), Rotation::from_xyzw(r.x, r.y, r.z, r.w))
}

/// A core where it stands in the world.
pub(crate) struct Placed<'a> {
    pub(crate) core: &'a Core,
    pub(crate) X_WB: &'a Rigid,
}

impl SupportMap for Placed<'_> {
    #[inline]
    fn local_support_point(&self, direction: Vector) -> Vector {
        let direction_B = self.X_WB.R.tr_mul(&from_parry(direction));
        to_parry(&self.X_WB.point(&self.core.support(&direction_B)))
    }

    #[inline]
    fn support_point(&self, _identity: &Pose, direction: Vector) -> Vector {
        self.local_support_point(direction)
    }

    #[inline]
    fn support_point_toward(&self, _identity: &Pose, direction: Vector) -> Vector {
        self.local_support_point(direction)
    }
}

/// Whether two cores are closer than `reach_m` (at least 0); `towards` points roughly from the first to the second.
///
/// When GJK does not converge, a separation that cannot be confirmed counts as "closer".
pub(crate) fn cores_within(a: &Placed<'_>, b: &Placed<'_>, reach_m: f64, towards: &Vector3<f64>) -> bool {
    let towards = towards.try_normalize(1e-12).unwrap_or_else(Vector3::x);
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&Pose::IDENTITY, a, b, to_parry(&towards)));
    match gjk::closest_points(&Pose::IDENTITY, a, b, reach_m, false, &mut simplex) {
        GJKResult::NoIntersection(direction) => {
            let bound = -direction.dot(CsoPoint::from_shapes(&Pose::IDENTITY, a, b, direction).point);
            bound <= reach_m
        }
        _ => true,
    }
}

/// Signed distance of two cores, metres: negative is the depth of penetration (EPA).
pub(crate) fn core_distance(a: &Placed<'_>, b: &Placed<'_>, towards: &Vector3<f64>) -> f64 {
    let towards = towards.try_normalize(1e-12).unwrap_or_else(Vector3::x);
    let mut simplex = VoronoiSimplex::new();
    let start = Some(to_parry(&towards));
    match contact_support_map_support_map_with_params(&Pose::IDENTITY, a, b, f64::MAX, &mut simplex, start) {
        GJKResult::ClosestPoints(p_a, p_b, normal) => (p_b - p_a).dot(normal),
        // EPA found no depth: the cores touch.
        _ => 0.0,
    }
}

type Corners = Vec<Vector3<f64>>;
type Triangles = Vec<[u32; 3]>;

/// The corners and triangles of the convex hull of some points; `None` when they span no volume.
pub(crate) fn hull_of(points: &[Vector3<f64>]) -> Option<(Corners, Triangles)> {
    if !spans_volume(points) {
        return None;
    }
    let wrapped: Vec<Vector> = points.iter().map(to_parry).collect();
    let (corners, triangles) = parry3d_f64::transformation::try_convex_hull(&wrapped).ok()?;
    (corners.len() >= 4).then(|| (corners.into_iter().map(from_parry).collect(), triangles))
}

/// Whether the points stand out of every plane by more than a micrometre.
fn spans_volume(points: &[Vector3<f64>]) -> bool {
    const FLAT_M: f64 = 1e-6;
    let Some(origin) = points.first() else { return false };
    let farthest = |height: &dyn Fn(&Vector3<f64>) -> f64| {
        points.iter().map(|p| p - origin).max_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or_default()
    };
    let along = farthest(&|p| p.norm()).try_normalize(FLAT_M);
    let Some(along) = along else { return false };
    let across = farthest(&|p| p.cross(&along).norm());
    let Some(normal) = along.cross(&across).try_normalize(FLAT_M) else { return false };
    farthest(&|p| p.dot(&normal).abs()).dot(&normal).abs() > FLAT_M
}

/// A body in parry's own shapes, for the exhaustive judge.
#[derive(Clone)]
pub(crate) struct ForeignBody {
    shape: SharedShape,
    X_OB: Pose,
}

impl ForeignBody {
    /// From a core, its rounding and the pose of the body's own frame in the frame that owns it.
    pub(crate) fn new(core: &Core, radius: f64, X_OB: &Isometry3<f64>) -> Option<Self> {
        let X_OB = pose_to_parry(X_OB);
        Some(match core {
            Core::Segment { a, b } if a == b => {
                Self { shape: SharedShape::ball(radius), X_OB: X_OB * Pose::from_translation(to_parry(a)) }
            }
            Core::Segment { a, b } => Self { shape: SharedShape::capsule(to_parry(a), to_parry(b), radius), X_OB },
            Core::Box { half } => Self { shape: SharedShape::cuboid(half.x, half.y, half.z), X_OB },
            Core::Cylinder { radius, half_length } => {
                // Parry's cylinders lie along y.
                let quarter = std::f64::consts::FRAC_1_SQRT_2;
                let y_to_z = Pose::from_rotation(Rotation::from_xyzw(quarter, 0.0, 0.0, quarter));
                Self { shape: SharedShape::cylinder(*half_length, *radius), X_OB: X_OB * y_to_z }
            }
            Core::Triangle { corners } => {
                let [a, b, c] = corners.each_ref().map(to_parry);
                Self { shape: SharedShape::triangle(a, b, c), X_OB }
            }
            Core::Hull(hull) => {
                let points: Vec<Vector> = hull.corners().iter().map(to_parry).collect();
                Self { shape: SharedShape::convex_hull(&points)?, X_OB }
            }
        })
    }

    /// Whether two bodies meet, each given with the pose of its owner.
    pub(crate) fn meets(&self, X_WO: &Isometry3<f64>, other: &Self, X_WO_other: &Isometry3<f64>) -> bool {
        let (X_WA, X_WB) = (pose_to_parry(X_WO) * self.X_OB, pose_to_parry(X_WO_other) * other.X_OB);
        parry3d_f64::query::intersection_test(&X_WA, &*self.shape, &X_WB, &*other.shape)
            .is_ok_and(|answer| answer.intersecting)
    }

    /// Signed distance, metres.
    pub(crate) fn distance(&self, X_WO: &Isometry3<f64>, other: &Self, X_WO_other: &Isometry3<f64>) -> f64 {
        let (X_WA, X_WB) = (pose_to_parry(X_WO) * self.X_OB, pose_to_parry(X_WO_other) * other.X_OB);
        match parry3d_f64::query::contact(&X_WA, &*self.shape, &X_WB, &*other.shape, f64::MAX) {
            Ok(Some(contact)) => contact.dist,
            _ => f64::INFINITY,
        }
    }

    /// Ball around the body in the world: centre and radius.
    pub(crate) fn ball(&self, X_WO: &Isometry3<f64>) -> (Vector3<f64>, f64) {
        let sphere = self.shape.compute_bounding_sphere(&(pose_to_parry(X_WO) * self.X_OB));
        (from_parry(sphere.center), sphere.radius)
    }
}
