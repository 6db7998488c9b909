//! Where the bodies of a link are: corners and vertices that tell its size and its middle.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::robot::{Geometry, JointKind, Link, Robot};

/// Points that span a link's bodies, in the link's frame: what collides, or what is drawn where nothing collides.
pub(super) fn link_points(link: &Link) -> Vec<Point3<f64>> {
    let solid = link.collisions.iter().map(|body| (&body.X_LC, &body.geometry));
    let drawn = link.visuals.iter().map(|body| (&body.X_LV, &body.geometry));
    let points: Vec<Point3<f64>> = solid.flat_map(|(X_LB, geometry)| corners(X_LB, geometry)).collect();
    if points.is_empty() { drawn.flat_map(|(X_LB, geometry)| corners(X_LB, geometry)).collect() } else { points }
}

fn corners(X_LB: &Isometry3<f64>, geometry: &Geometry) -> Vec<Point3<f64>> {
    let half = match geometry {
        Geometry::Box { size_m } => 0.5 * size_m,
        Geometry::Sphere { radius_m } => Vector3::repeat(*radius_m),
        Geometry::Cylinder { radius_m, length_m } => Vector3::new(*radius_m, *radius_m, 0.5 * length_m),
        Geometry::Capsule { radius_m, length_m } => Vector3::new(*radius_m, *radius_m, radius_m + 0.5 * length_m),
        Geometry::Mesh { mesh, .. } => return mesh.positions.iter().map(|p| X_LB * p).collect(),
    };
    let sign = |bit: usize, corner: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let corner = |k: usize| Point3::new(half.x * sign(0, k), half.y * sign(1, k), half.z * sign(2, k));
    (0..8).map(|k| X_LB * corner(k)).collect()
}

/// The middle of points; `None` where there are none.
pub(super) fn middle(points: &[Point3<f64>]) -> Option<Point3<f64>> {
    let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
    (!points.is_empty()).then(|| Point3::from(sum / points.len() as f64))
}

/// All joints at 0, or at the limit that is nearest to it.
pub(super) fn rest(robot: &Robot) -> Vec<f64> {
    let limits = robot.dof_joints.iter().map(|&joint| robot.joints[joint].limit);
    limits.map(|limit| 0.0_f64.max(limit.lower).min(limit.upper)).collect()
}

/// Moving joints, mimics too, whose parents are welded to a link that is the top of its body.
pub(super) fn moving_below(robot: &Robot, body: usize) -> Vec<usize> {
    let hangs = |joint: &usize| {
        let joint = &robot.joints[*joint];
        joint.kind != JointKind::Fixed && robot.body_root(joint.parent) == body
    };
    (0..robot.joints.len()).filter(hangs).collect()
}
