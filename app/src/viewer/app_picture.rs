//! What the application does with pictures and animations: one picture after the other, between two frames of the window.

use egui::Context;
use endcomfort_core::job::Stage;
use image::RgbaImage;
use serde::Deserialize;

use super::photographer::Photographer;
use super::{App, Command, PictureCommand, PictureEffect, Posture, Shot, ViewerState};
use crate::export::{AnimationFormat, Clip, Recorder, glb_scene, png_bytes};
use crate::render::{Camera, Quality};

/// The picture or the animation under way.
#[derive(Default)]
pub(super) struct Pictures {
    photographer: Photographer,
    wanted: Option<Wanted>,
}

enum Wanted {
    /// A picture, and the name of its file.
    Picture(String),
    Film(Box<Film>),
}

/// An animation under way. The camera stays where it stood when the animation began.
struct Film {
    recorder: Recorder,
    shot: Shot,
    camera: Camera,
    name: String,
    /// Revision of the plan that it shows.
    revision: Option<u64>,
}

/// What a script asks for; everything has a usual value.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Asked {
    width: u32,
    height: u32,
    scale: f32,
    transparent: bool,
    words: bool,
    light: bool,
    /// Extension of the file of an animation.
    format: String,
    fps: u32,
    from_s: f64,
    to_s: f64,
}

impl Default for Asked {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            scale: 1.0,
            transparent: false,
            words: true,
            light: false,
            format: "gif".to_owned(),
            fps: 25,
            from_s: 0.0,
            to_s: f64::MAX,
        }
    }
}

impl Asked {
    fn read(wanted: &str, ctx: &Context) -> Result<(Self, Shot), String> {
        let asked: Self = serde_json::from_str(wanted).map_err(|error| error.to_string())?;
        let &Self { width, height, scale, transparent, words, light, .. } = &asked;
        let dark = ctx.theme() == egui::Theme::Dark && !light;
        let shot = Shot { size_px: [width, height], scale, transparent, words, dark };
        match ViewerState::shot_problem(&shot) {
            Some(problem) => Err(problem),
            None => Ok((asked, shot)),
        }
    }
}

impl App {
    /// Saves a picture of the view: a JSON object with some of `width`, `height`, `scale`, `transparent`, `words`,
    /// `light`.
    ///
    /// # Errors
    /// A clause that says what is wrong with the object.
    pub fn save_picture(&mut self, ctx: &Context, wanted: &str) -> Result<(), String> {
        let (_, shot) = Asked::read(wanted, ctx)?;
        self.apply(ctx, Command::Picture(PictureCommand::Take(shot)));
        Ok(())
    }

    /// Saves the plan as an animation: the same object, with `format` (`gif`, `apng` or `zip`), `fps`, `from_s` and
    /// `to_s`.
    ///
    /// # Errors
    /// A clause that says what is wrong with the object.
    pub fn save_animation(&mut self, ctx: &Context, wanted: &str) -> Result<(), String> {
        let (Asked { format, fps, from_s, to_s, .. }, shot) = Asked::read(wanted, ctx)?;
        let known = || AnimationFormat::ALL.map(AnimationFormat::extension).join(", ");
        let format = AnimationFormat::of_extension(&format)
            .ok_or_else(|| format!("found format {format:?}, wanted one of {}", known()))?;
        let duration_s = self.state.duration_s();
        let clip = Clip { format, fps, from_s, to_s: to_s.min(duration_s) };
        clip.check(duration_s).map_err(|error| error.to_string())?;
        self.apply(ctx, Command::Picture(PictureCommand::Film(shot, clip)));
        Ok(())
    }

    pub(super) fn picture(&mut self, ctx: &Context, effect: PictureEffect) {
        match effect {
            PictureEffect::Take(shot) => self.take_picture(ctx, shot),
            PictureEffect::Film(shot, clip) => self.begin_film(ctx, shot, clip),
            PictureEffect::Stop => self.stop_pictures(),
            PictureEffect::SaveScene => self.save_bodies(ctx),
        }
    }

    fn stop_pictures(&mut self) {
        self.pictures.wanted = None;
        self.pictures.photographer.rest();
    }

    fn picture_failed(&mut self, ctx: &Context, reason: &str) {
        self.stop_pictures();
        let sentence = format!("The picture could not be saved: {reason}.");
        self.host.announce(&sentence);
        self.state.say(true, sentence, Vec::new());
        self.apply(ctx, Command::Picture(PictureCommand::Progress(None)));
    }

    fn hand_over(&mut self, name: &str, bytes: &[u8]) {
        let sentence = self.host.save(name, bytes);
        self.host.announce(&sentence);
        self.state.say(false, sentence, Vec::new());
    }

    fn take_picture(&mut self, ctx: &Context, shot: Shot) {
        let camera = self.view.camera_for(shot.size_px);
        let picture = self.studio.compose(&self.state.compose_input(shot.dark));
        let stand = (camera, self.state.looking.cut);
        match self.pictures.photographer.expose(ctx, &mut self.view, &picture, stand, (&shot, Quality::Figure)) {
            Ok(()) => {
                let name = self.state.saved_name(&format!("{:.2}s", self.state.playback.time_s), "png");
                self.pictures.wanted = Some(Wanted::Picture(name));
            }
            Err(error) => self.picture_failed(ctx, &error.to_string()),
        }
    }

    fn begin_film(&mut self, ctx: &Context, shot: Shot, clip: Clip) {
        if self.state.outputs.plan.is_none() {
            return self.picture_failed(ctx, "there is no plan that could move");
        }
        let recorder = match Recorder::new(clip, self.state.duration_s(), shot.size_px, shot.transparent) {
            Ok(recorder) => recorder,
            Err(error) => return self.picture_failed(ctx, &error.to_string()),
        };
        let name = self.state.saved_name("plan", clip.format.extension());
        let camera = self.view.camera_for(shot.size_px);
        let revision = self.state.outputs.revision(Stage::Plan);
        self.pictures.wanted = Some(Wanted::Film(Box::new(Film { recorder, shot, camera, name, revision })));
        self.next_frame(ctx);
    }

    /// Takes the next picture of the animation, or saves it after the last one.
    fn next_frame(&mut self, ctx: &Context) {
        let Some(Wanted::Film(film)) = &self.pictures.wanted else { return };
        if film.revision != self.state.outputs.revision(Stage::Plan) {
            return self.picture_failed(ctx, "the plan has changed meanwhile");
        }
        let progress = Some(film.recorder.progress());
        let Some(time_s) = film.recorder.wanted_s() else { return self.end_film(ctx) };
        let Film { shot, mut camera, .. } = **film;
        let mut input = self.state.compose_input(shot.dark);
        (input.posture, input.lab) = (Posture::Plan { time_s }, None);
        let picture = self.studio.compose(&input);
        if let Some(p_W) = self.state.playback.follows.and_then(|followed| picture.place_of(followed)) {
            camera.target = p_W;
        }
        let stand = (camera, self.state.looking.cut);
        match self.pictures.photographer.expose(ctx, &mut self.view, &picture, stand, (&shot, Quality::Live)) {
            Ok(()) => self.apply(ctx, Command::Picture(PictureCommand::Progress(progress))),
            Err(error) => self.picture_failed(ctx, &error.to_string()),
        }
    }

    fn end_film(&mut self, ctx: &Context) {
        let Some(Wanted::Film(film)) = self.pictures.wanted.take() else { return };
        self.pictures.photographer.rest();
        let Film { recorder, name, .. } = *film;
        match recorder.finish() {
            Ok(bytes) => {
                self.hand_over(&name, &bytes);
                self.apply(ctx, Command::Picture(PictureCommand::Progress(None)));
            }
            Err(error) => self.picture_failed(ctx, &error.to_string()),
        }
    }

    /// Takes in what has arrived from the GPU.
    pub(super) fn develop_pictures(&mut self, ctx: &Context) {
        if !self.pictures.photographer.is_busy() {
            return;
        }
        // The browser's WebGL and native devices have to be asked again.
        ctx.request_repaint();
        match self.pictures.photographer.develop(&mut self.view) {
            None => {}
            Some(Err(reason)) => self.picture_failed(ctx, &reason),
            Some(Ok(picture)) => self.developed(ctx, &picture),
        }
    }

    fn developed(&mut self, ctx: &Context, picture: &RgbaImage) {
        match &mut self.pictures.wanted {
            None => self.pictures.photographer.rest(),
            Some(Wanted::Film(film)) => match film.recorder.take(picture) {
                Ok(()) => self.next_frame(ctx),
                Err(error) => self.picture_failed(ctx, &error.to_string()),
            },
            Some(Wanted::Picture(name)) => {
                let name = std::mem::take(name);
                self.stop_pictures();
                match png_bytes(picture) {
                    Ok(bytes) => self.hand_over(&name, &bytes),
                    Err(reason) => self.picture_failed(ctx, &reason),
                }
            }
        }
    }

    /// Saves the bodies, points and lines of the view as a GLB.
    fn save_bodies(&mut self, ctx: &Context) {
        let dark = ctx.theme() == egui::Theme::Dark;
        let picture = self.studio.compose(&self.state.compose_input(dark));
        match glb_scene(&picture.frame) {
            Ok(bytes) => self.hand_over(&self.state.saved_name("scene", "glb"), &bytes),
            Err(reason) => {
                self.state.say(true, format!("The scene could not be saved: {reason}."), Vec::new());
            }
        }
    }
}
