//! Marked boxes in place of meshes that are missing: as long as the link is, by the joints that it carries.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::robot::{CollisionBody, Geometry, Material, MissingMesh, Robot, Visual};

/// Name of the material by which whoever draws knows a box that stands for something else.
pub const MISSING_MATERIAL: &str = "missing";
/// Colour of such a box, sRGB and opacity.
const COLOR: [f32; 4] = [0.95, 0.60, 0.12, 0.75];
/// A box reaches this far beyond the joints of its link, metres: half the thickness of a slender arm.
const AROUND_M: f64 = 0.03;
/// No box is longer than this, metres.
const LONGEST_M: f64 = 1.5;

/// Adds a box to each link that lacks a mesh: to what is drawn, to what collides, or to both.
pub(super) fn add_boxes(robot: &mut Robot, missing: &[MissingMesh]) {
    for link in 0..robot.links.len() {
        let name = &robot.links[link].name;
        let lacks = |is_visual: bool| missing.iter().any(|m| m.link == *name && m.is_visual == is_visual);
        let (is_drawn, collides) = (lacks(true), lacks(false));
        if !is_drawn && !collides {
            continue;
        }
        let (X_LB, geometry) = box_of(robot, link);
        if is_drawn {
            let material = Material { name: MISSING_MATERIAL.to_owned(), rgba: COLOR };
            robot.links[link].visuals.push(Visual { X_LV: X_LB, geometry: geometry.clone(), material });
        }
        if collides {
            robot.links[link].collisions.push(CollisionBody { X_LC: X_LB, geometry });
        }
    }
}

/// The box around a link's own origin and those of the joints that it carries.
fn box_of(robot: &Robot, link: usize) -> (Isometry3<f64>, Geometry) {
    let carried = robot.joints.iter().filter(|joint| joint.parent == link);
    let ends = carried.map(|joint| Point3::from(joint.X_PJ.translation.vector));
    let (mut least, mut most) = (Vector3::zeros(), Vector3::zeros());
    for end in ends {
        (least, most) = (least.inf(&end.coords), most.sup(&end.coords));
    }
    let size_m = (most - least + Vector3::repeat(2.0 * AROUND_M)).map(|edge| edge.min(LONGEST_M));
    (Isometry3::from_parts((0.5 * (least + most)).into(), nalgebra::one()), Geometry::Box { size_m })
}
