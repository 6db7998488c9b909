//! What is drawn stays within what collides, so that a picture never shows a touch the planner did not see.

use nalgebra::Point3;

use super::{CollisionBody, Geometry, samples};

/// Distance of a point in the link to a collision body, metres; negative inside.
fn distance(body: &CollisionBody, p_L: &Point3<f64>) -> f64 {
    let p = body.X_LC.inverse_transform_point(p_L);
    let hypot = |x: f64, y: f64| (x * x + y * y).sqrt();
    let radial = hypot(p.x, p.y);
    match &body.geometry {
        Geometry::Sphere { radius_m } => p.coords.norm() - radius_m,
        Geometry::Capsule { radius_m, length_m } => hypot(radial, (p.z.abs() - 0.5 * length_m).max(0.0)) - radius_m,
        Geometry::Cylinder { radius_m, length_m } => (radial - radius_m).max(p.z.abs() - 0.5 * length_m),
        Geometry::Box { size_m } => (0..3).map(|k| p[k].abs() - 0.5 * size_m[k]).fold(f64::MIN, f64::max),
        Geometry::Mesh { file, .. } => panic!("{file}: collision shapes are primitives"),
    }
}

#[test]
fn drawn_links_stay_within_four_millimetres_of_their_collision_shapes() {
    let mut outside = Vec::new();
    for robot in [samples::crichton(), samples::alita(), samples::hubo(), samples::human()] {
        for link in robot.links.iter().filter(|link| !link.collisions.is_empty()) {
            for visual in &link.visuals {
                let Geometry::Mesh { file, mesh } = &visual.geometry else { continue };
                let worst = mesh
                    .positions
                    .iter()
                    .map(|p| visual.X_LV * p)
                    .map(|p| (link.collisions.iter().map(|body| distance(body, &p)).fold(f64::MAX, f64::min), p))
                    .max_by(|a, b| a.0.total_cmp(&b.0));
                // Corners of finger pads and forks: rounder shapes collide faster and would cost more clearance.
                if let Some((out, p)) = worst.filter(|(out, _)| *out > 4e-3) {
                    outside.push(format!("{}: {file} at {p:.4?} by {out:.4} m", link.name));
                }
            }
        }
    }
    assert!(outside.is_empty(), "{outside:#?}");
}
