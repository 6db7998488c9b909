//! What one frame costs the processor: picture, panels and draw calls of a full scene.
//!
//! `cargo bench -p endcomfort --bench frame`. The scene: the demo `butler` (Alita and Hubo with their furniture), planned;
//! its cloud thickened to 500 000 points, its grasps repeated to 2 000, all of them accepted, and both of Alita's
//! reachability maps with every voxel shown. Three kinds of frames: the view is turned (what a drag costs), another
//! grasp is under the pointer (the picture is composed anew), and the plan plays (it is composed anew without grasps).
//! The panels have 1280 × 720 points. The time until the GPU has drawn is not counted: each frame waits
//! for the one before outside the measured part. Opaque voxels, and voxels that fade (sorted by depth) in lines of their
//! own.
#![allow(non_snake_case, reason = "frame letters")]

#[path = "../../core/benches/common/report.rs"]
mod report;

use std::error::Error;
use std::sync::Arc;

use egui::{Pos2, RawInput, Rect, vec2};
use endcomfort::assets;
use endcomfort::jobs::run_until;
use endcomfort::render::{Camera, Frame, Offscreen, Quality, Theme, View};
use endcomfort::studio::BuiltInStudio;
use endcomfort::viewer::{
    Command, Document, Effect, Hover, ReachCommand, ReachView, Studio as _, ViewerState, draw_panels, install_theme,
};
use endcomfort_core::grasp::GraspStatus;
use endcomfort_core::job::{Output, Request, Stage, Update};
use endcomfort_core::rng::Rng;
use report::{Report, now_ms};

const SEED: u64 = 1;
const POINTS: usize = 500_000;
const GRASPS: usize = 2_000;
const RUNS: usize = 30;
/// Frames that only warm the caches.
const WARM_UP: usize = 4;
const SIZE: [u32; 2] = [1280, 720];
/// Pixels of the picture: few, because a software GPU takes its time for each.
const PICTURE: [u32; 2] = [320, 180];

fn main() -> Result<(), Box<dyn Error>> {
    let mut bench = Bench::new()?;
    let voxels = bench.voxels();
    let problem = format!("{POINTS} points, 2 robots, {GRASPS} grasps, {voxels} voxels");
    let mut report = Report::new("frame", SEED);
    for (look, fades) in [("opaque", false), ("fading", true)] {
        let view = ReachView { fades, ..bench.state.reaching.view };
        bench.apply(Command::Reach(ReachCommand::View(view)));
        for (kind, change) in [
            ("view turned", Change::Camera),
            ("another grasp under the pointer", Change::Hover),
            ("plan plays", Change::Time),
        ] {
            let parts = bench.measure(change)?;
            let what = format!("{kind}, {look} voxels");
            report.add(&problem, &what, "ms", parts.iter().map(|part| part.iter().sum()), "");
            for (index, name) in ["compose", "draw calls", "panels"].into_iter().enumerate() {
                report.add("", format!("  {name}"), "ms", parts.iter().map(|part| part[index]), "");
            }
        }
    }
    report.print();
    Ok(())
}

/// What is different from one frame to the next.
#[derive(Clone, Copy)]
enum Change {
    Camera,
    Hover,
    Time,
}

struct Bench {
    state: ViewerState,
    studio: BuiltInStudio,
    offscreen: Offscreen,
    egui: egui::Context,
    frame: Frame,
    grasps: Vec<u32>,
}

impl Bench {
    fn new() -> Result<Self, Box<dyn Error>> {
        let studio = BuiltInStudio::default();
        let scene = Arc::new(assets::demo("butler").ok_or("no demo `butler`")?);
        let mut state = ViewerState::new(Document::new(scene.clone()), studio.demos(), studio.robots());
        let request = Request::new((*scene).clone());
        let outputs = run_until(&request, Stage::Plan).map_err(|refusal| refusal.message)?;
        for output in enlarge(outputs) {
            let revision = state.revision;
            let _effects = state.receive(Update::Done { revision, elapsed_ms: 1.0, output: Box::new(output) });
        }
        let _effects = state.receive(Update::Finished { revision: state.revision });
        let grasps = state.outputs.candidates().iter().map(|grasp| grasp.id).collect();
        let egui = egui::Context::default();
        install_theme(&egui);
        let mut offscreen = Offscreen::new()?;
        offscreen.set_quality(Quality::Live);
        let mut bench = Self { state, studio, offscreen, egui, frame: Frame::default(), grasps };
        bench.apply(Command::Reach(ReachCommand::Open));
        Ok(bench)
    }

    fn apply(&mut self, command: Command) {
        for effect in self.state.apply(command) {
            if let Effect::FetchMap(path) = effect {
                let file = assets::read(&format!("robots/{path}")).map(<[u8]>::to_vec).ok_or_else(String::new);
                self.apply(Command::Reach(ReachCommand::Arrived { path, file }));
            }
        }
    }

    fn voxels(&self) -> usize {
        (0..2).filter_map(|arm| self.state.reaching.map(arm)).map(|map| map.voxels().count()).sum()
    }

    /// Milliseconds of composing, of draw calls and of panels, for each frame.
    fn measure(&mut self, change: Change) -> Result<Vec<[f64; 3]>, Box<dyn Error>> {
        let mut frames = Vec::new();
        let _effects = self.state.apply(Command::Seek(0.0));
        self.frame = self.studio.compose(&self.state.compose_input(true)).frame;
        for run in 0..WARM_UP + RUNS {
            let mut camera = Camera::default();
            let begin_ms = now_ms();
            match change {
                Change::Camera => camera.yaw_rad += 0.01 * run as f64,
                Change::Hover => {
                    self.state.hover = Hover { grasp: self.grasps.get(run).copied(), ..Hover::default() };
                    self.frame = self.studio.compose(&self.state.compose_input(true)).frame;
                }
                Change::Time => {
                    let _effects = self.state.apply(Command::Seek(0.1 + 0.05 * run as f64));
                    self.frame = self.studio.compose(&self.state.compose_input(true)).frame;
                }
            }
            let composed_ms = now_ms();
            let mut drawn_ms = composed_ms;
            let view = View::new(camera, Theme::Dark, PICTURE);
            // The callback comes when everything is handed to the GPU; then its picture is waited for.
            self.offscreen.render_with(&self.frame, &view, |_, _| drawn_ms = now_ms())?;
            let panels_begin_ms = now_ms();
            self.panels(run);
            let parts = [composed_ms - begin_ms, drawn_ms - composed_ms, now_ms() - panels_begin_ms];
            if run >= WARM_UP {
                frames.push(parts);
            }
        }
        Ok(frames)
    }

    fn panels(&self, run: usize) {
        let window = vec2(SIZE[0] as f32, SIZE[1] as f32);
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, window)),
            time: Some(run as f64 / 60.0),
            ..RawInput::default()
        };
        let output = self.egui.run_ui(input, |ui| {
            let _commands = draw_panels(ui, &self.state);
        });
        let _triangles = self.egui.tessellate(output.shapes, output.pixels_per_point);
    }
}

/// The outputs with as many points and grasps as the bench promises.
fn enlarge(outputs: Vec<Output>) -> Vec<Output> {
    let mut rng = Rng::new(SEED, 0);
    let enlarged = outputs.into_iter().map(|output| match output {
        Output::Scene(mut scene) => {
            let cloud = &mut scene.cloud;
            let seen = cloud.points.clone();
            while cloud.points.len() < POINTS {
                let mut point = seen[cloud.points.len() % seen.len()];
                point.coords.iter_mut().for_each(|x| *x += 1e-3 * rng.uniform(-0.5, 0.5));
                cloud.points.push(point);
            }
            cloud.points.truncate(POINTS);
            (cloud.colors, cloud.grid) = (Vec::new(), None);
            Output::Scene(scene)
        }
        Output::Segment(mut segment) => {
            segment.fates = segment.fates.iter().copied().cycle().take(POINTS).collect();
            Output::Segment(segment)
        }
        Output::Rank(mut ranked) => {
            let found: Vec<_> = ranked.grasps.iter().filter(|grasp| grasp.is_accepted()).cloned().collect();
            ranked.grasps = found.into_iter().cycle().take(GRASPS).collect();
            for (id, grasp) in (0..).zip(&mut ranked.grasps) {
                (grasp.id, grasp.status) = (id, GraspStatus::Accepted);
            }
            ranked.accepted = GRASPS;
            Output::Rank(ranked)
        }
        other => other,
    });
    enlarged.collect()
}
