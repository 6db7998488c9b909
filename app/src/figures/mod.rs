//! Pictures without a window: a scene at a moment, drawn off-screen.

mod fit_pair;

use image::RgbaImage;
use nalgebra::Point3;

use crate::compose::Composer;
use crate::render::{Camera, Offscreen, OffscreenError, Theme, View};
use crate::viewer::Layers;

pub use crate::compose::Picture;
pub use fit_pair::draw_fits;

/// How a picture is taken.
pub struct PictureSettings {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Eye and target in the world, metres; the usual view without.
    pub camera: Option<([f64; 3], [f64; 3])>,
    /// Time in the plan, seconds; without it the robot stands in its start posture.
    pub time_s: Option<f64>,
    /// No background.
    pub transparent: bool,
    /// Colours.
    pub theme: Theme,
}

impl Picture<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// [`OffscreenError`] when there is no graphics adapter or the size is beyond its limit.
    pub fn draw(&self, settings: &PictureSettings) -> Result<RgbaImage, OffscreenError> {
        let frame = self.frame(&mut Composer::default(), settings.time_s, settings.theme, &Layers::default());
        let camera = settings.camera.map_or_else(Camera::default, |(eye, target)| looking(eye.into(), target.into()));
        let view = View { transparent: settings.transparent, ..View::new(camera, settings.theme, settings.size_px) };
        Offscreen::new()?.render(&frame, &view)
    }
}

/// The camera at `eye` that looks at `target`.
fn looking(eye: Point3<f64>, target: Point3<f64>) -> Camera {
    let back = eye - target;
    let distance_m = back.norm().max(1e-3);
    Camera {
        target,
        distance_m,
        yaw_rad: back.y.atan2(back.x),
        pitch_rad: (back.z / distance_m).asin(),
        ..Camera::default()
    }
}
