//! Regions of the object: the box around what a drag in the view covers, and around the upper half.

use endcomfort_core::fit::Fit;
use endcomfort_core::grasp::Region;
use nalgebra::{Isometry3, Point2, Point3, Vector3};

use super::ViewerState;
use crate::render::Camera;

/// Room around the surface that a region takes in, metres: where a hand holds an object is a little inside it, and
/// samples of the surface are some millimetres apart.
const ROOM_M: f64 = 0.01;
/// Resolution of the meshes whose corners stand for the surface: 64 columns, 32 rows.
const SURFACE_HALF: u32 = 8;

impl ViewerState {
    /// The fit of the object to grasp.
    pub(super) fn target_fit(&self) -> Option<&Fit> {
        let fits = self.outputs.fit.as_ref()?;
        fits.fits.get(fits.target)?.as_ref().ok()
    }

    /// The box around the upper half of the object where it was seen.
    pub(super) fn upper_half(&self) -> Option<Region> {
        let boxes = self.target_fit()?.bodies().map(|body| body.bounding_box_in(&Isometry3::identity()));
        let (mut low, high) = boxes.reduce(|(low, high), (l, h)| (low.inf(&l), high.sup(&h)))?;
        low.z = 0.5 * (low.z + high.z);
        Some(around(&low, &high))
    }

    /// The box around what of the object's surface, near and far side, is seen between two corners of a picture of
    /// this size; `None` if nothing is.
    pub(super) fn region_between(&self, camera: &Camera, corners: [Point2<f64>; 2], size: [f64; 2]) -> Option<Region> {
        let (low, high) = (corners[0].inf(&corners[1]), corners[0].sup(&corners[1]));
        let is_inside = |p_W: &Point3<f64>| {
            camera.project(p_W, size).is_some_and(|at| at.inf(&low) == low && at.sup(&high) == high)
        };
        let bodies = self.target_fit()?.bodies();
        let surface = bodies.flat_map(|body| body.mesh(SURFACE_HALF).positions);
        let boxes = surface.filter(is_inside).map(|p| (p, p));
        let (low, high) = boxes.reduce(|(low, high), (l, h)| (low.inf(&l), high.sup(&h)))?;
        Some(around(&low, &high))
    }
}

fn around(low: &Point3<f64>, high: &Point3<f64>) -> Region {
    Region { center_W: nalgebra::center(low, high), half_m: 0.5 * (high - low) + Vector3::repeat(ROOM_M) }
}
