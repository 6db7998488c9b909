//! Opening what was shared, and handing it out.

use std::sync::Arc;

use endcomfort_core::guest::GuestRobot;

use super::{Opened, ShareError, SharedView, content, read_session};
use crate::viewer::state::Step;
use crate::viewer::{Command, Effect, Looking, Outputs, Overlay, ViewEffect, ViewerState};

impl ViewerState {
    /// Opens a link or a session: the pipeline runs, and what it was looked at with stands when the plan does.
    pub(in crate::viewer) fn open_shared(&mut self, opened: Opened) -> Vec<Effect> {
        let Opened { document, demo, view } = opened;
        let standing = self.standing();
        (self.overlay, self.drawer) = (Overlay::None, None);
        self.playback.playing = false;
        self.outputs = Outputs::default();
        self.outputs_version += 1;
        self.selection = crate::viewer::Selection { step: self.selection.step, cluster: None, grasp: None, ik: None };
        let mut effects = self.edit(|present| *present = document);
        self.fallback = standing.filter(|_| !effects.is_empty());
        if effects.is_empty() {
            // No edit that could be taken back. The document is the one that stands: its results are asked for anew, so that one way leads to the view.
            effects = self.apply(Command::Run);
        }
        self.demo = demo;
        self.layers = view.layers();
        self.posing.is_open = false;
        self.looking = Looking { cloud: view.points.unwrap_or_default(), cut: view.cut, measured: None };
        self.viewing.keep(&view.kept);
        // In somebody else's page there is no inspector, and the examined fit would cover the plan.
        if let Some(step) = view.step().filter(|_| !self.is_embedded) {
            effects.extend(self.apply(Command::SelectStep(step)));
        }
        if let Some(camera) = &view.camera {
            self.look_with(camera);
        }
        effects.push(view.camera.map_or(Effect::View(ViewEffect::FrameAll), Effect::PlaceCamera));
        self.restoring = Some(view);
        effects
    }

    /// Opens the JSON of a session file.
    pub(in crate::viewer) fn open_session(&mut self, name: String, json: serde_json::Value) -> Vec<Effect> {
        match read_session(json, &self.demos) {
            Ok(opened) => self.open_shared(opened),
            Err(error) => self.apply(Command::FileFailed { name, reason: error.to_string() }),
        }
    }

    /// Says why a link is not opened.
    pub(in crate::viewer) fn refuse_link(&mut self, error: &ShareError) -> Vec<Effect> {
        let sentence = format!("The link could not be opened: {error}.");
        self.say(true, sentence.clone(), Vec::new());
        vec![Effect::Announce(sentence)]
    }

    /// Opens what was left at the last visit.
    pub(in crate::viewer) fn restore(&mut self) -> Vec<Effect> {
        match self.offer.take() {
            Some(offer) => self.open_shared(offer.opened),
            None => Vec::new(),
        }
    }

    /// The answer stands: selection and moment become those that were shared.
    pub(in crate::viewer) fn restore_view(&mut self) -> Vec<Effect> {
        let Some(SharedView { camera, time_s, grasp, cluster, .. }) = self.restoring.take() else { return Vec::new() };
        let clusters = self.outputs.segment.as_ref().map_or(0, |segment| segment.clusters.len());
        if let Some(cluster) = cluster.filter(|&cluster| cluster < clusters) {
            self.selection.cluster = Some(cluster);
        }
        if let Some(grasp) = grasp.filter(|&grasp| self.outputs.candidate(grasp).is_some()) {
            self.selection.grasp = Some(grasp);
        }
        self.playback.time_s = time_s.max(0.0).min(self.duration_s());
        // The fit that is examined took the camera to itself.
        let is_in_lab = matches!(self.selection.step, Step::Stage(endcomfort_core::job::Stage::Fit));
        camera.filter(|_| is_in_lab).map(Effect::PlaceCamera).into_iter().collect()
    }

    /// Hands out the scene alone.
    pub(in crate::viewer) fn save_scene(&mut self) -> Vec<Effect> {
        match serde_json::to_string_pretty(&*self.document.scene) {
            Ok(text) => vec![Effect::Save { name: self.file_name("json"), bytes: Arc::new(text.into_bytes()) }],
            Err(error) => {
                self.say(true, format!("The scene could not be written: {error}."), Vec::new());
                Vec::new()
            }
        }
    }

    /// Name of a file for what is open. A scene's name may hold anything, a file's may not.
    pub(in crate::viewer) fn file_name(&self, extension: &str) -> String {
        let plain = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_') { c } else { '-' };
        let name: String = self.document.scene.name.chars().map(plain).collect();
        format!("{}.{extension}", if name.is_empty() { "scene" } else { &name })
    }

    /// The words under a link that was copied.
    ///
    /// * `length`: characters of the whole address.
    pub(in crate::viewer) fn shared_sentence(&self, length: usize) -> String {
        let cloud = self.document.cloud.as_ref().map(|cloud| {
            format!(" {} is not in the link: save the session instead (in the list of demos).", cloud.name)
        });
        let is_long = length > content::LONG_LINK;
        let long =
            is_long.then(|| format!(" It has {length} characters, which some programs cut: a session file is safer."));
        let scene = &self.document.scene;
        let brought = std::iter::once(&scene.robot).chain(scene.objects.iter().map(|placed| &placed.object));
        let away = brought.map(|name| (GuestRobot::title_of(name), name)).find(|(title, name)| *title != name.as_str());
        let away = away.map(|(title, _)| {
            format!(" {title} is yours and not in the link: save the session instead (in the list of demos).")
        });
        let [cloud, away, long] = [cloud, away, long].map(Option::unwrap_or_default);
        format!("Copied a link to this view.{cloud}{away}{long}")
    }
}
