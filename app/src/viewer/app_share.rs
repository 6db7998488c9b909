//! What the application does with links, sessions and whoever embeds it.

use egui::{Context, OpenUrl};
use endcomfort_core::job::Stage;
use endcomfort_core::scene::Scene;

use super::state::StageState;
use super::{App, Command, Document, Edge, Opened, PanelSizes, SharedView, link_text, read_link, session_text};
use crate::host::Entry;

impl App {
    /// The address of this view: the page's own with `#s=…`, natively that part alone.
    ///
    /// # Errors
    /// A sentence if the scene cannot be written.
    pub fn link(&self) -> Result<String, String> {
        let text = link_text(&self.state, Some(self.view.camera())).map_err(|error| error.to_string())?;
        Ok(format!("{}{text}", self.host.page()))
    }

    /// Opens a link; a broken one is told to the person as well.
    ///
    /// # Errors
    /// A clause that says what is wrong with it.
    pub fn open_link(&mut self, ctx: &Context, text: &str) -> Result<(), String> {
        match read_link(text, &self.state.demos) {
            Ok(opened) => {
                self.apply(ctx, Command::OpenShared(Box::new(opened)));
                Ok(())
            }
            Err(error) => {
                let effects = self.state.refuse_link(&error);
                self.carry_out(ctx, effects);
                ctx.request_repaint();
                Err(error.to_string())
            }
        }
    }

    /// Opens a scene's JSON.
    ///
    /// # Errors
    /// A clause that says what is wrong with it.
    pub fn open_scene(&mut self, ctx: &Context, json: &str) -> Result<(), String> {
        let scene = Scene::parse(json).map_err(|error| error.to_string())?;
        let document = Document::new(scene.into());
        let opened = Opened { document, demo: None, view: SharedView::default() };
        self.apply(ctx, Command::OpenShared(Box::new(opened)));
        Ok(())
    }

    /// Everything that is needed to open this view again, as JSON.
    ///
    /// # Errors
    /// A sentence if the scene cannot be written.
    pub fn session(&self) -> Result<String, String> {
        session_text(&self.state, Some(self.view.camera()), true).map_err(|error| error.to_string())
    }

    pub(super) fn share(&mut self, ctx: &Context) {
        match self.link() {
            Ok(link) => {
                let sentence = self.state.shared_sentence(link.len());
                ctx.copy_text(link);
                self.host.announce(&sentence);
                self.state.say(false, sentence, Vec::new());
            }
            Err(reason) => self.state.say(true, format!("There is no link to this view: {reason}."), Vec::new()),
        }
    }

    pub(super) fn save_session(&mut self) {
        match self.session() {
            Ok(text) => {
                let sentence = self.host.save(&self.state.file_name("endcomfort.json"), text.as_bytes());
                self.host.announce(&sentence);
                self.state.say(false, sentence, Vec::new());
            }
            Err(reason) => self.state.say(true, format!("The session could not be saved: {reason}."), Vec::new()),
        }
    }

    pub(super) fn open_page(&mut self, ctx: &Context) {
        match self.link() {
            Ok(link) => ctx.open_url(OpenUrl::new_tab(link)),
            Err(reason) => self.state.say(true, format!("There is no link to this view: {reason}."), Vec::new()),
        }
    }

    /// Writes an edit that has settled to where the next visit finds it.
    pub(super) fn keep_for_next_visit(&mut self, ctx: &Context) {
        let now_s = ctx.input(|input| input.time);
        let Some(wait_s) = self.autosave.due_in_s(&self.state, now_s) else { return };
        // Part of somebody else's page, it keeps out of what a person does on the page itself.
        let Some(store) = self.host.store().filter(|_| !self.state.is_embedded) else { return };
        if wait_s > 0.0 {
            ctx.request_repaint_after_secs(wait_s as f32);
        } else {
            self.autosave.write(&self.state, self.view.camera(), now_s, store);
        }
    }

    /// Gives the panels the sizes that they had at the last visit.
    pub(super) fn restore_layout(&mut self) {
        let text = self.host.store().and_then(|store| store.read(Entry::Layout));
        let Some(text) = text.filter(|_| !self.state.is_embedded) else { return };
        match serde_json::from_str::<PanelSizes>(&text) {
            Ok(sizes) => {
                Edge::ALL.iter().zip(sizes.0).for_each(|(edge, size)| self.state.sizes.set(*edge, size));
                self.kept_sizes = self.state.sizes;
            }
            Err(error) => log::warn!("the panels have their usual sizes: what was kept of them is wrong: {error}"),
        }
    }

    /// Writes the sizes of the panels once nobody drags them any more.
    pub(super) fn keep_layout(&mut self, ctx: &Context) {
        let sizes = self.state.sizes;
        if sizes == self.kept_sizes || ctx.input(|input| input.pointer.any_down()) || self.state.is_embedded {
            return;
        }
        self.kept_sizes = sizes;
        if let (Some(store), Ok(text)) = (self.host.store(), serde_json::to_string(&sizes))
            && let Err(reason) = store.write(Entry::Layout, &text)
        {
            log::warn!("the sizes of the panels are not kept: {reason}");
        }
    }

    /// Tells whoever embeds the page which stages were done or refused since `before`.
    pub(super) fn tell_stages(&mut self, before: &[StageState]) {
        for (stage, before) in Stage::ALL.into_iter().zip(before) {
            let now = self.state.stage(stage);
            if now != before && matches!(now, StageState::Done { .. } | StageState::Refused(_)) {
                let mut event = self.state.stage_status(stage);
                event["event"] = "stage".into();
                self.host.tell(&event);
            }
        }
    }
}
