//! The interface on the program's own scenes: a worker that answers at once, and a window with the view.

use std::sync::Arc;

use egui::{Theme, Vec2};
use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use endcomfort_core::job::{Request, Stage, Update};
use endcomfort_core::pipeline::Pipeline;
use image::RgbaImage;

use super::Page;
use crate::assets;
use crate::studio::BuiltInStudio;
use crate::viewer::state::Step;
use crate::viewer::view3d::View3d;
use crate::viewer::{
    Command, Document, Effect, LabCommand, ReachCommand, Studio as _, ViewerState, draw_panels, theme,
};

/// The interface with a worker that answers at once.
pub(super) struct Bench {
    pub(super) page: Page,
    pipeline: Pipeline,
    /// Requests in the order in which they were made.
    pub(super) asked: Vec<Request>,
    /// The last stage that the worker takes part in: a test of the fit needs no plan.
    pub(super) last: Stage,
}

impl Bench {
    /// A demo, fitted, with the lab open.
    pub(super) fn new(demo: &str) -> Self {
        let mut bench = Self::until(demo, Stage::Fit);
        bench.apply(Command::SelectStep(Step::Stage(Stage::Fit)));
        bench
    }

    /// A demo, run until a stage is done.
    pub(super) fn until(demo: &str, last: Stage) -> Self {
        let studio = BuiltInStudio::default();
        let scene = Arc::new(assets::demo(demo).expect("the demo is there"));
        let state = ViewerState::new(Document::new(scene), studio.demos(), studio.robots());
        let page = Page { state, effects: Vec::new(), commands: Vec::new() };
        let mut bench = Self { page, pipeline: Pipeline::new(assets::library()), asked: Vec::new(), last };
        let effects = bench.page.state.run();
        bench.carry_out(effects);
        bench
    }

    pub(super) fn apply(&mut self, command: Command) {
        let effects = self.page.state.apply(command);
        self.carry_out(effects);
    }

    pub(super) fn lab(&mut self, command: LabCommand) {
        self.apply(Command::Lab(command));
    }

    pub(super) fn carry_out(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Run(request) => {
                    for update in self.answers(&request) {
                        let more = self.page.state.receive(update);
                        self.carry_out(more);
                    }
                }
                Effect::FetchMap(path) => {
                    let file = assets::read(&format!("robots/{path}"));
                    let file = file.map(<[u8]>::to_vec).ok_or_else(|| "the server answers 404".to_owned());
                    self.apply(Command::Reach(ReachCommand::Arrived { path, file }));
                }
                _ => {}
            }
        }
    }

    pub(super) fn answers(&mut self, request: &Request) -> Vec<Update> {
        self.asked.push(request.clone());
        let request = Request { last: request.last.min(self.last), ..request.clone() };
        let mut updates = Vec::new();
        crate::jobs::run(&mut self.pipeline, &request, &|| false, &mut |update| updates.push(update));
        updates
    }
}

/// The window: view, panels and a worker that answers at once.
pub(super) struct Window {
    pub(super) bench: Bench,
    pub(super) view: View3d,
    studio: BuiltInStudio,
}

pub(super) fn window(bench: Bench, size: [f32; 2], dark: bool) -> Harness<'static, Window> {
    let gpu = create_render_state(default_wgpu_setup(), eframe::egui_wgpu::RendererOptions::PREDICTABLE);
    let renderer = WgpuTestRenderer::from_render_state(gpu.clone());
    let window = Window { bench, view: View3d::new(&gpu), studio: BuiltInStudio::default() };
    let show = |ui: &mut egui::Ui, window: &mut Window| {
        let rect = ui.ctx().content_rect();
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(rect));
        ui.set_clip_rect(rect);
        let mut commands = window.view.show(&mut ui, &window.bench.page.state, &mut window.studio);
        commands.extend(draw_panels(&mut ui, &window.bench.page.state));
        for command in commands {
            window.bench.apply(command);
        }
    };
    Harness::builder()
        .with_size(Vec2::from(size))
        .with_theme(if dark { Theme::Dark } else { Theme::Light })
        .with_max_steps(24)
        .renderer(renderer)
        .with_context_setup(theme::install)
        .build_ui_state(show, window)
}

pub(super) fn picture(harness: &mut Harness<'_, Window>, name: &str) -> RgbaImage {
    // Long enough for the camera to arrive.
    harness.run_steps(40);
    let picture = harness.render().expect("the software rasteriser draws");
    if let Some(folder) = std::env::var_os("ENDCOMFORT_LOOK") {
        picture.save(std::path::Path::new(&folder).join(format!("{name}.png"))).expect("it can be written");
    }
    picture
}
