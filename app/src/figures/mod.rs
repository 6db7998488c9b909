//! Pictures without a window: a scene at a moment, drawn off-screen.

mod fit_pair;

use endcomfort_core::reach::ReachMap;
use image::RgbaImage;
use nalgebra::Point3;

use crate::compose::{Composer, ReachContent};
use crate::render::{Camera, Cut, Offscreen, OffscreenError, Theme, View};
use crate::viewer::{Layer, Layers, ReachView};

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
    /// What is taken away.
    pub cut: Option<Cut>,
    /// Reachability maps to be drawn; the usual view frames them.
    pub reach: Option<ReachPicture>,
}

/// Reachability maps in a picture.
pub struct ReachPicture {
    /// Of the left arm and of the right one.
    pub maps: [Option<ReachMap>; 2],
    /// How they are shown.
    pub view: ReachView,
}

impl ReachPicture {
    fn content(&self) -> ReachContent<'_> {
        let maps = self.maps.each_ref().map(Option::as_ref);
        ReachContent { maps, view: self.view, chosen: None, version: 0 }
    }
}

impl Picture<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// [`OffscreenError`] when there is no graphics adapter or the size is beyond its limit.
    pub fn draw(&self, settings: &PictureSettings) -> Result<RgbaImage, OffscreenError> {
        let mut layers = Layers::default();
        layers.get_mut(Layer::Reach).visible = settings.reach.is_some();
        let mut composer = Composer::default();
        let reach = settings.reach.as_ref().map(ReachPicture::content);
        let frame = self.frame(&mut composer, settings.time_s, settings.theme, &layers, reach);
        let mut camera = Camera::default();
        if let Some((eye, target)) = settings.camera {
            camera = looking(eye.into(), target.into());
        } else if let (_, Some(bounds)) = composer.reach_drawn() {
            camera.frame(&bounds, settings.size_px.map(f64::from));
        }
        let (transparent, cut) = (settings.transparent, settings.cut);
        let view = View { transparent, cut, ..View::new(camera, settings.theme, settings.size_px) };
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
