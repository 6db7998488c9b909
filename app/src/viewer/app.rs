//! The application: state, view and panels, between a host that computes and a studio that composes.

use std::sync::{Arc, Mutex, PoisonError};

use crate::export::MotionFormat;
use egui::{Context, Ui};
use endcomfort_core::grasp::ExportFormat;

use super::app_picture::Pictures;
use super::share::Autosave;
use super::state::Step;
use super::view3d::View3d;
use super::{
    BringCommand, Command, Document, Effect, LabCommand, Offer, Overlay, PanelSizes, ReachCommand, Studio, ThemeChoice,
    ViewCommand, ViewEffect, ViewerState, draw_panels, theme,
};
use crate::assets;
use crate::host::Host;

/// How the program shall open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StartOptions {
    /// Demo to open; `None` opens the first.
    pub demo: Option<String>,
    /// Whether the gallery lies over it.
    pub gallery: bool,
    /// Dark, light, or as the system has it.
    pub theme: ThemeChoice,
    /// Link to open instead of a demo.
    pub link: Option<String>,
    /// Whether this is a part of somebody else's page.
    pub is_embedded: bool,
    /// Files to open as if they had been dropped: paths and contents.
    pub files: Vec<(String, Vec<u8>)>,
}

/// The frame after which the robots are loaded that no scene wants yet. The first pictures are there by then, and a
/// switch to another robot does not have to wait a tenth of a second (in a browser) for its meshes and its collisions.
const LOADS_OTHERS: u64 = 3;

/// The interface as eframe runs it.
pub struct App {
    pub(super) state: ViewerState,
    pub(super) view: View3d,
    pub(super) host: Box<dyn Host>,
    pub(super) studio: Box<dyn Studio>,
    inbox: Inbox,
    pub(super) pictures: Pictures,
    pub(super) autosave: Autosave,
    /// Sizes of the panels as they were written last.
    pub(super) kept_sizes: PanelSizes,
    /// Frames drawn since the start.
    frames: u64,
}

/// Files that are still being read when they are dropped (the browser reads them in its own time).
type Inbox = Arc<Mutex<Vec<Command>>>;

impl App {
    /// Opens the first demo (or the one that is asked for) at once.
    ///
    /// # Errors
    /// A sentence if eframe has no wgpu device, or if there is no demo at all.
    pub fn new(
        cc: &eframe::CreationContext<'_>,
        host: Box<dyn Host>,
        studio: Box<dyn Studio>,
        start: StartOptions,
    ) -> Result<Self, String> {
        let gpu = cc.wgpu_render_state.as_ref().ok_or("The window opened without wgpu, which draws the 3D view.")?;
        theme::install(&cc.egui_ctx);
        let demos = studio.demos();
        let first = demos.first().ok_or("The program was built without demos.")?;
        let document = Document::new(first.scene.clone());
        let name = first.name.clone();
        let mut state = ViewerState::new(document, demos, studio.robots());
        state.demo = Some(name);
        state.is_embedded = start.is_embedded;
        let mut app = Self {
            state,
            view: View3d::new(gpu),
            host,
            studio,
            inbox: Inbox::default(),
            pictures: Pictures::default(),
            autosave: Autosave::default(),
            kept_sizes: PanelSizes::default(),
            frames: 0,
        };
        let ctx = &cc.egui_ctx;
        app.apply(ctx, Command::SetTheme(start.theme));
        let is_linked = start.link.is_some_and(|link| app.open_link(ctx, &link).is_ok());
        let wanted = start.demo.filter(|demo| app.state.demo.as_ref() != Some(demo));
        match wanted {
            _ if is_linked => {}
            Some(demo) if app.state.demo_named(&demo).is_some() => app.apply(ctx, Command::OpenDemo(demo)),
            unknown => {
                let effects = app.state.run();
                app.carry_out(ctx, effects);
                if let Some(demo) = unknown {
                    app.apply(ctx, Command::OpenDemo(demo));
                }
            }
        }
        if start.is_embedded {
            app.apply(ctx, Command::Present(true));
        } else if start.gallery && !is_linked {
            app.state.offer = app.host.store().and_then(|store| Offer::read(store, &app.state.demos));
            app.apply(ctx, Command::Show(Overlay::Gallery));
        }
        if !start.files.is_empty() {
            app.open_files(ctx, start.files);
        }
        app.autosave = Autosave::new(app.state.revision);
        app.restore_layout();
        Ok(app)
    }

    /// What stands on the screen, as one JSON object.
    pub fn status_json(&self) -> String {
        let mut status = self.state.status();
        let camera = serde_json::to_value(self.view.camera()).unwrap_or_default();
        if let Some(fields) = status.as_object_mut() {
            fields.insert("backend".to_owned(), self.host.backend().into());
            fields.insert("camera".to_owned(), camera);
            fields.insert("frames".to_owned(), self.frames.into());
        }
        status.to_string()
    }

    /// The plan as JSON; `None` while there is none for the present scene.
    pub fn plan_json(&self) -> Option<String> {
        self.state.plan_json()
    }

    /// The state that the panels show.
    pub fn state(&self) -> &ViewerState {
        &self.state
    }

    /// Opens a file as if it had been dropped.
    pub fn open_file(&mut self, ctx: &Context, name: String, bytes: Vec<u8>) {
        self.open_files(ctx, vec![(name, bytes)]);
    }

    /// Opens files that belong together as if they had been dropped: paths and contents.
    pub fn open_files(&mut self, ctx: &Context, files: Vec<(String, Vec<u8>)>) {
        self.apply(ctx, Command::Bring(BringCommand::Files(files)));
    }

    /// Opens a demo by name.
    pub fn open_demo(&mut self, ctx: &Context, name: &str) {
        self.apply(ctx, Command::OpenDemo(name.to_owned()));
    }

    /// Starts or stops the playing.
    pub fn set_playing(&mut self, ctx: &Context, playing: bool) {
        self.apply(ctx, Command::SetPlaying(playing));
    }

    /// Goes to a time of the plan, seconds.
    pub fn seek(&mut self, ctx: &Context, time_s: f64) {
        self.apply(ctx, Command::Seek(time_s));
    }

    /// Shows a step by its name in lower case.
    ///
    /// # Errors
    /// A sentence that lists the steps when there is none of this name.
    pub fn select_step(&mut self, ctx: &Context, name: &str) -> Result<(), String> {
        let Some(step) = Step::named(name) else {
            let known = Step::ALL.map(Step::title).join(", ").to_lowercase();
            return Err(format!("there is no step {name:?}; the steps are {known}"));
        };
        self.apply(ctx, Command::SelectStep(step));
        Ok(())
    }

    /// Fits the examined cluster with each objective.
    pub fn compare_objectives(&mut self, ctx: &Context) {
        self.apply(ctx, Command::Lab(LabCommand::Compare));
    }

    /// Sets parameters of the examined cluster's shape: a JSON object with some fields of a superquadric.
    ///
    /// # Errors
    /// A sentence when there is no fit, or when the parameters are those of no superquadric.
    pub fn set_shape(&mut self, ctx: &Context, parameters: &str) -> Result<(), String> {
        let shape = self.state.shape_with(parameters)?;
        self.apply(ctx, Command::Lab(LabCommand::SetShape(shape)));
        Ok(())
    }

    /// Does what a person could do.
    pub fn apply(&mut self, ctx: &Context, command: Command) {
        let effects = self.state.apply(command);
        self.carry_out(ctx, effects);
        ctx.request_repaint();
    }

    pub(super) fn carry_out(&mut self, ctx: &Context, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Run(request) => self.host.submit(*request),
                Effect::Cancel => self.host.cancel(),
                Effect::View(ViewEffect::Keep) => {
                    let camera = self.view.camera();
                    self.apply(ctx, Command::View(ViewCommand::KeepCamera(camera)));
                }
                Effect::View(effect) => self.view.go(effect),
                Effect::Announce(sentence) => self.host.announce(&sentence),
                Effect::Theme(choice) => ctx.set_theme(match choice {
                    ThemeChoice::System => egui::ThemePreference::System,
                    ThemeChoice::Dark => egui::ThemePreference::Dark,
                    ThemeChoice::Light => egui::ThemePreference::Light,
                }),
                Effect::FetchMap(path) => self.fetch_map(ctx, path),
                Effect::Save { name, bytes } => {
                    let sentence = self.host.save(&name, &bytes);
                    self.state.say(false, sentence, Vec::new());
                }
                Effect::Picture(effect) => self.picture(ctx, effect),
                Effect::Export(format) => self.export(format),
                Effect::ExportMotion(format) => self.export_motion(format),
                Effect::PlaceCamera(camera) => self.view.place(camera),
                Effect::Share => self.share(ctx),
                Effect::PickFile => self.host.pick(),
                Effect::SaveSession => self.save_session(),
                Effect::OpenPage => self.open_page(ctx),
            }
        }
    }

    /// Updates of the worker, files that were read, pictures that were taken.
    fn take_in(&mut self, ctx: &Context) {
        for update in self.host.poll() {
            let before = self.state.stages.clone();
            let effects = self.state.receive(update);
            self.carry_out(ctx, effects);
            self.tell_stages(&before);
            ctx.request_repaint();
        }
        let arrived = std::mem::take(&mut *self.inbox.lock().unwrap_or_else(PoisonError::into_inner));
        for command in arrived {
            self.apply(ctx, command);
        }
        self.develop_pictures(ctx);
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        if !dropped.is_empty() {
            read_together(dropped, &self.inbox, ctx);
        }
    }

    /// Hands the ranked grasps to the person as a file.
    fn export(&mut self, format: ExportFormat) {
        match self.studio.export(&self.state.document, &self.state.outputs, format) {
            Ok(text) => {
                let name = format!("endcomfort-{}-grasps.{}", self.state.scene().name, format.extension());
                let sentence = self.host.save(&name, text.as_bytes());
                self.host.announce(&sentence);
                self.state.say(false, sentence, Vec::new());
            }
            Err(reason) => self.state.say(true, format!("The grasps could not be exported: {reason}."), Vec::new()),
        }
    }

    /// Hands the planned motion to the person as a file.
    fn export_motion(&mut self, format: MotionFormat) {
        match self.studio.export_motion(&self.state.document, &self.state.outputs, format) {
            Ok(bytes) => {
                let name = format!("endcomfort-{}-plan.{}", self.state.scene().name, format.extension());
                let sentence = self.host.save(&name, &bytes);
                self.host.announce(&sentence);
                self.state.say(false, sentence, Vec::new());
            }
            Err(reason) => self.state.say(true, format!("The plan could not be exported: {reason}."), Vec::new()),
        }
    }

    /// What arrives comes in with the next frame, like a file that was dropped.
    fn fetch_map(&mut self, ctx: &Context, path: String) {
        let (inbox, repaint, name) = (self.inbox.clone(), ctx.clone(), path.clone());
        let done = move |file| {
            let arrived = Command::Reach(ReachCommand::Arrived { path: name, file });
            inbox.lock().unwrap_or_else(PoisonError::into_inner).push(arrived);
            repaint.request_repaint();
        };
        self.host.fetch(&path, Box::new(done));
    }
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &Context, _frame: &mut eframe::Frame) {
        self.take_in(ctx);
        self.keep_for_next_visit(ctx);
        self.keep_layout(ctx);
        if self.state.tour_runs() {
            let dt_s = f64::from(ctx.input(|input| input.stable_dt)).min(0.1);
            let effects = self.state.advance_tour(dt_s);
            self.carry_out(ctx, effects);
            ctx.request_repaint_after_secs(0.05);
        }
        if self.state.playback.playing {
            self.state.advance(f64::from(ctx.input(|input| input.stable_dt)).min(0.1));
            ctx.request_repaint();
        } else if self.state.running {
            // The host wakes us when it can; this is for the one that cannot.
            ctx.request_repaint_after_secs(0.05);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.frames += 1;
        let mut commands = self.view.show(ui, &self.state, &mut *self.studio);
        commands.extend(draw_panels(ui, &self.state));
        let ctx = ui.ctx().clone();
        for command in commands {
            self.apply(&ctx, command);
        }
        if self.frames == LOADS_OTHERS {
            for robot in &self.state.robots {
                let _loaded_now_or_refused_when_wanted = assets::library().robot(&robot.name);
            }
        }
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }
}

/// What one dropped file or folder was read as: files with their paths, or the name of what could not be read and why.
type Read = Result<Vec<(String, Vec<u8>)>, (String, String)>;

/// The command that things stand for that were dropped together; what cannot be read of them fails them all.
fn brought(read: impl IntoIterator<Item = Read>) -> Command {
    let files: Result<Vec<_>, _> = read.into_iter().collect();
    match files {
        Ok(files) => Command::Bring(BringCommand::Files(files.into_iter().flatten().collect())),
        Err((name, reason)) => Command::FileFailed { name, reason },
    }
}

fn name_of(file: &egui::DroppedFileHandle) -> String {
    file.path().file_name().map_or("file".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Reads files that were dropped together; in a window folders as well.
#[cfg(not(target_arch = "wasm32"))]
fn read_together(files: Vec<egui::DroppedFileHandle>, inbox: &Inbox, ctx: &Context) {
    let read = |file: &egui::DroppedFileHandle| {
        let path = file.path();
        if path.is_dir() {
            return crate::brought::disk::all_files(path).map_err(|reason| (name_of(file), reason));
        }
        file.bytes().map(|bytes| vec![(name_of(file), bytes)]).map_err(|reason| (name_of(file), reason))
    };
    let command = brought(files.iter().map(read));
    inbox.lock().unwrap_or_else(PoisonError::into_inner).push(command);
    ctx.request_repaint();
}

/// Reads files that were dropped together, in the browser's own time. Folders are read by `web/boot.js`.
#[cfg(target_arch = "wasm32")]
fn read_together(files: Vec<egui::DroppedFileHandle>, inbox: &Inbox, ctx: &Context) {
    let (inbox, ctx) = (inbox.clone(), ctx.clone());
    wasm_bindgen_futures::spawn_local(async move {
        let mut read: Vec<Read> = Vec::new();
        for file in &files {
            let bytes = file.bytes_async().await;
            read.push(bytes.map(|bytes| vec![(name_of(file), bytes)]).map_err(|reason| (name_of(file), reason)));
        }
        inbox.lock().unwrap_or_else(PoisonError::into_inner).push(brought(read));
        ctx.request_repaint();
    });
}
