//! A handover in the view: the place, the places that were not taken, the line that joins the shoulders, and the object
//! as it is passed.

use std::sync::Arc;

use endcomfort_core::handover::HandoverReport;
use endcomfort_core::mesh::Mesh;
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::{Composer, Content, Palette};
use crate::render::{Frame, LineDraw, MeshDraw, Surface, shapes};
use crate::viewer::{Layer, Pick};

/// Edge of the cube of a place that is not looked at, as a share of its voxel.
const SMALL: f64 = 0.3;
/// Opacity of the voxel that is looked at.
const VOXEL: f32 = 0.22;
/// Opacity of the object there.
const GHOST: f32 = 0.30;
/// Radius of the marks at the shoulders, metres.
const SHOULDER_M: f64 = 0.022;

/// Meshes that every picture of a handover shares.
pub(super) struct Marks {
    voxel_m: f64,
    voxel: Arc<Mesh>,
    small: Arc<Mesh>,
    shoulder: Arc<Mesh>,
}

impl Marks {
    fn new(voxel_m: f64) -> Self {
        let cube = |edge_m: f64| Arc::new(shapes::cuboid(Vector3::repeat(edge_m)));
        let shoulder = Arc::new(shapes::sphere(SHOULDER_M));
        Self { voxel_m, voxel: cube(voxel_m), small: cube(SMALL * voxel_m), shoulder }
    }
}

impl Composer {
    pub(super) fn add_handover(&mut self, frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
        let opacity = input.layers.opacity(Layer::Handover);
        let Some(report) = input.plan.and_then(|plan| plan.handover.as_deref()).filter(|_| opacity > 0.0) else {
            return;
        };
        let shown = input.motion.shown_place.unwrap_or(report.chosen);
        let Some(place) = report.places.get(shown) else { return };
        let mut ink = if input.motion.is_stale { palette.stale } else { palette.handover };
        ink[3] *= opacity;
        let faint = |share: f32| [ink[0], ink[1], ink[2], ink[3] * share];
        let marks = match self.marks.take() {
            Some(marks) if marks.voxel_m == report.voxel_m => marks,
            _ => Marks::new(report.voxel_m),
        };
        frame.lines.push(LineDraw::new(report.shoulders.to_vec(), ink, 2.2).dashed(8.0));
        for shoulder in &report.shoulders {
            frame.meshes.push(mark(&marks.shoulder, shoulder, ink, Surface::Satin, 0));
        }
        frame.meshes.push(mark(&marks.voxel, &place.voxel, faint(VOXEL), Surface::Ghost, 0));
        frame.lines.extend(edges(&place.voxel, report.voxel_m).map(|points| LineDraw::new(points, ink, 1.8)));
        if input.motion.is_presented {
            self.marks = Some(marks);
            return;
        }
        for (index, voxel) in others(report, shown) {
            let is_refused = report.places[index].refused.is_some();
            let mut color = if is_refused && !input.motion.is_stale { palette.rejected } else { faint(0.85) };
            color[3] = color[3].min(opacity);
            let pick = Pick::Place(index as u32);
            frame.meshes.push(mark(&marks.small, &voxel, color, Surface::Satin, pick.id()));
        }
        for (mesh, X_OP) in self.object_bodies(input) {
            let (X_WM, color) = (place.X_WO * X_OP, faint(GHOST));
            frame.meshes.push(MeshDraw { mesh, X_WM, color, surface: Surface::Ghost, pick_id: 0 });
        }
        self.marks = Some(marks);
    }
}

/// One place of every other voxel, the best one of it: several may share a voxel, which is drawn once.
fn others(report: &HandoverReport, shown: usize) -> Vec<(usize, Point3<f64>)> {
    let mut voxels: Vec<(usize, Point3<f64>)> = Vec::new();
    for (index, place) in report.places.iter().enumerate() {
        let is_new = voxels.iter().all(|(_, known)| *known != place.voxel);
        if is_new && place.voxel != report.places[shown].voxel {
            voxels.push((index, place.voxel));
        }
    }
    voxels
}

fn mark(mesh: &Arc<Mesh>, p_W: &Point3<f64>, color: [f32; 4], surface: Surface, pick_id: u32) -> MeshDraw {
    let X_WM = Isometry3::from(Translation3::from(p_W.coords));
    MeshDraw { mesh: mesh.clone(), X_WM, color, surface, pick_id }
}

/// The edges of a cube: both faces and what joins them.
fn edges(center: &Point3<f64>, edge_m: f64) -> impl Iterator<Item = Vec<Point3<f64>>> {
    const FACE: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let center = *center;
    let corner = move |side: usize, z: f64| {
        let [x, y] = FACE[side % 4];
        center + 0.5 * edge_m * Vector3::new(x, y, z)
    };
    let faces = [-1.0, 1.0].map(|z| (0..=4).map(|side| corner(side, z)).collect());
    faces.into_iter().chain((0..4).map(move |side| vec![corner(side, -1.0), corner(side, 1.0)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edges_of_a_cube_are_twelve_and_as_long_as_they_say() {
        let center = Point3::new(0.3, -0.7, 1.1);
        let lengths: Vec<f64> = edges(&center, 0.05)
            .flat_map(|points| points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect::<Vec<_>>())
            .collect();
        assert_eq!(lengths.len(), 12);
        assert!(lengths.iter().all(|length_m| (length_m - 0.05).abs() < 1e-12));
    }
}
