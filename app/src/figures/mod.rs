//! Pictures without a window: a scene at a moment, drawn off-screen.

mod fit_pair;
mod words;

use std::sync::Arc;

use endcomfort_core::reach::ReachMap;
use endcomfort_core::task::Plan;
use image::RgbaImage;
use nalgebra::Point3;

use self::words::Labeller;
use crate::compose::{Composer, ReachContent};
use crate::export::glb_scene;
use crate::render::{Camera, Cut, Frame, Offscreen, OffscreenError, Quality, Theme, View};
use crate::viewer::{Layer, Layers, ReachView};

pub use crate::compose::Picture;
pub use fit_pair::draw_fits;

/// How a picture is taken.
pub struct PictureSettings {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Eye and target in the world, metres; the usual view without.
    pub camera: Option<([f64; 3], [f64; 3])>,
    /// Pixels per point: how thick lines and points are.
    pub scale: f32,
    /// No background.
    pub transparent: bool,
    /// With the labels and the scale that stand over the view.
    pub words: bool,
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
    /// Everything that a picture at a time of the plan shows, as a GLB; without a time the robot stands in its start
    /// posture.
    ///
    /// # Errors
    /// A sentence when there is nothing to write, or when the file would be too large.
    pub fn glb(&self, settings: &PictureSettings, time_s: Option<f64>) -> Result<Vec<u8>, String> {
        glb_scene(&self.compose(&mut Composer::default(), self.plan().as_ref(), settings, time_s))
    }

    fn compose(
        &self,
        composer: &mut Composer,
        plan: Option<&Arc<Plan>>,
        settings: &PictureSettings,
        time_s: Option<f64>,
    ) -> Frame {
        let mut layers = Layers::default();
        layers.get_mut(Layer::Reach).visible = settings.reach.is_some();
        let reach = settings.reach.as_ref().map(ReachPicture::content);
        self.frame(composer, plan, time_s, settings.theme, &layers, reach)
    }
}

/// Takes pictures of one scene, as many as are wanted, without a window.
pub struct Shooting<'a> {
    picture: Picture<'a>,
    plan: Option<Arc<Plan>>,
    settings: &'a PictureSettings,
    composer: Composer,
    offscreen: Offscreen,
    labeller: Option<Labeller>,
}

impl<'a> Shooting<'a> {
    /// Opens the graphics adapter.
    ///
    /// # Errors
    /// [`OffscreenError`] when there is none.
    pub fn new(picture: Picture<'a>, settings: &'a PictureSettings) -> Result<Self, OffscreenError> {
        let plan = picture.plan();
        let labeller = settings.words.then(|| Labeller::new(picture.scene, picture.cloud, picture.outputs));
        let offscreen = Offscreen::new()?;
        Ok(Self { picture, plan, settings, composer: Composer::default(), offscreen, labeller })
    }

    /// How finely the next pictures are lit; [`Quality::Figure`] at first.
    pub fn set_quality(&mut self, quality: Quality) {
        self.offscreen.set_quality(quality);
    }

    /// Draws the picture at a time of the plan, seconds; without a time the robot stands in its start posture.
    ///
    /// # Errors
    /// [`OffscreenError`] when the size or the scale is beyond its limit.
    pub fn shoot(&mut self, time_s: Option<f64>) -> Result<RgbaImage, OffscreenError> {
        let settings = self.settings;
        let frame = self.picture.compose(&mut self.composer, self.plan.as_ref(), settings, time_s);
        let mut camera = Camera::default();
        if let Some((eye, target)) = settings.camera {
            camera = looking(eye.into(), target.into());
        } else if let (_, Some(bounds)) = self.composer.reach_drawn() {
            camera.frame(&bounds, settings.size_px.map(f64::from));
        }
        let mut view = View::new(camera, settings.theme, settings.size_px);
        view.cut = settings.cut;
        (view.transparent, view.pixels_per_point) = (settings.transparent, settings.scale);
        let labeller = &mut self.labeller;
        self.offscreen.render_with(&frame, &view, |gpu, target| {
            if let Some(labeller) = labeller {
                labeller.write(gpu, target, &view.camera, time_s, (settings.theme, settings.scale));
            }
        })
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
