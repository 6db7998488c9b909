//! Boxes that stand for missing meshes: marked by dashed edges and a cross on every side.

use endcomfort_core::guest::MISSING_MATERIAL;
use endcomfort_core::robot::{Geometry, Visual};
use nalgebra::{Isometry3, Point3};

use crate::render::{Frame, LineDraw};

const EDGE_PX: f32 = 1.8;
const CROSS_PX: f32 = 1.0;
const DASH_PX: f32 = 5.0;

/// Marks a visual if it is a box that stands for something else.
///
/// * `X_WV`: pose of the visual in the world.
pub(super) fn mark(frame: &mut Frame, visual: &Visual, X_WV: &Isometry3<f64>, opacity: f32) {
    let Geometry::Box { size_m } = &visual.geometry else { return };
    if visual.material.name != MISSING_MATERIAL || opacity <= 0.0 {
        return;
    }
    let [r, g, b, _] = visual.material.rgba;
    let color = [r, g, b, opacity];
    let corner = |k: usize| {
        let side = |axis: usize| 0.5 * if k >> axis & 1 == 1 { size_m[axis] } else { -size_m[axis] };
        X_WV * Point3::new(side(0), side(1), side(2))
    };
    for from in 0..8_usize {
        // Along an edge one coordinate changes, across a side two.
        for bit in [1, 2, 4].into_iter().filter(|bit| from & bit == 0) {
            frame.lines.push(LineDraw::new(vec![corner(from), corner(from | bit)], color, EDGE_PX).dashed(DASH_PX));
        }
        for bits in [3, 5, 6].into_iter().filter(|bits| (from & bits).count_ones() < 2) {
            if from < from ^ bits {
                frame.lines.push(LineDraw::new(vec![corner(from), corner(from ^ bits)], color, CROSS_PX));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use endcomfort_core::robot::Material;
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn a_marked_box_has_twelve_edges_and_two_diagonals_on_each_of_six_sides() {
        let visual = |name: &str| Visual {
            X_LV: Isometry3::identity(),
            geometry: Geometry::Box { size_m: Vector3::new(0.1, 0.2, 0.3) },
            material: Material { name: name.to_owned(), rgba: [1.0, 0.5, 0.0, 0.7] },
        };
        let lines = |name: &str| {
            let mut frame = Frame::default();
            mark(&mut frame, &visual(name), &Isometry3::identity(), 1.0);
            frame.lines
        };
        assert!(lines("shell").is_empty());
        let lines = lines(MISSING_MATERIAL);
        let (edges, diagonals): (Vec<_>, Vec<_>) = lines.iter().partition(|line| line.dash_px.is_some());
        assert_eq!((edges.len(), diagonals.len()), (12, 12));
    }
}
