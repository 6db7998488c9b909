//! Pictures of the view at any size: drawn beside the window, read back while the interface goes on.

use egui::{Context, Ui};
use image::RgbaImage;

use super::layout::Layout;
use super::view3d::View3d;
use super::words::Words;
use super::{Picture, Shot, legends, view3d};
use crate::render::{Camera, Cut, Quality, Readback, SizeError, Target, Theme, View, check_scale, check_size};

/// Takes one picture at a time.
#[derive(Default)]
pub(super) struct Photographer {
    target: Option<Target>,
    words: Option<Words>,
    developing: Option<Readback>,
}

impl Photographer {
    /// Whether a picture is on its way.
    pub(super) fn is_busy(&self) -> bool {
        self.developing.is_some()
    }

    /// Draws a picture and asks for its pixels; `ctx` is woken when they are there. One that was still on its way is
    /// forgotten.
    ///
    /// # Errors
    /// [`SizeError`] when the shot is larger than what this device draws.
    pub(super) fn expose(
        &mut self,
        ctx: &Context,
        view: &mut View3d,
        picture: &Picture,
        (camera, cut): (Camera, Option<Cut>),
        (shot, quality): (&Shot, Quality),
    ) -> Result<(), SizeError> {
        let (gpu, renderer) = view.gpu_and_renderer();
        check_size(shot.size_px, gpu.device.limits().max_texture_dimension_2d)?;
        check_scale(shot.scale)?;
        let mut target = match self.target.take() {
            Some(target) if target.size() == shot.size_px => target,
            _ => Target::new(&gpu.device, shot.size_px),
        };
        let theme = if shot.dark { Theme::Dark } else { Theme::Light };
        let mut seen = View::new(camera, theme, shot.size_px);
        (seen.pixels_per_point, seen.transparent, seen.cut) = (shot.scale, shot.transparent, cut);
        renderer.set_quality(quality);
        renderer.draw(&gpu.device, &gpu.queue, &picture.frame, &seen, &mut target);
        if shot.words {
            let words = self.words.get_or_insert_with(|| Words::new(&gpu.device));
            let of = (&gpu.device, &gpu.queue);
            words.paint(of, &target, (shot.dark, shot.scale), |ui| say_over(ui, picture, &camera));
        }
        let ctx = ctx.clone();
        let wake = move || ctx.request_repaint();
        self.developing = Some(Readback::start(&gpu.device, &gpu.queue, &target, wake));
        // Kept for the next one: an animation has many of one size.
        self.target = Some(target);
        Ok(())
    }

    /// The picture that was exposed, once it has arrived.
    pub(super) fn develop(&mut self, view: &mut View3d) -> Option<Result<RgbaImage, String>> {
        let arrived = self.developing.as_ref()?.take(&view.gpu_and_renderer().0.device)?;
        self.developing = None;
        Some(arrived)
    }

    /// Lets go of what large pictures need.
    pub(super) fn rest(&mut self) {
        (self.target, self.developing) = (None, None);
    }
}

/// Labels, legend and scale, as they stand over the view, over a picture that fills the `Ui`'s window.
pub(crate) fn say_over(ui: &mut Ui, picture: &Picture, camera: &Camera) {
    let window = ui.ctx().content_rect();
    let layout = Layout { free: window, ..Layout::new(window, None) };
    view3d::labels(ui, window, camera, &picture.labels);
    if let Some(legend) = &picture.legend {
        legends::legend(ui, &layout, legend);
    }
    if let Some(bar) = &picture.scale {
        legends::scale_bar(ui, &layout, bar);
    }
}
