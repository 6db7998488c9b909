//! The 3D view with the real renderer: a drag turns, the wheel zooms to the pointer, a click picks.

use std::sync::Arc;

use egui::{Event, MouseWheelUnit, Pos2, Theme, Vec2};
use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use endcomfort_core::grasp::ExportFormat;
use image::RgbaImage;
use nalgebra::{Isometry3, Vector3};

use super::{Page, invented};
use crate::export::MotionFormat;
use crate::render::{Camera, Frame, MeshDraw, Named, Surface, shapes};
use crate::viewer::layout::Layout;
use crate::viewer::view3d::View3d;
use crate::viewer::{
    ComposeInput, Demo, Document, Label, Outputs, Pick, Picture, RobotChoice, Studio, Tone, ViewEffect, draw_panels,
    theme,
};

const SIZE: Vec2 = egui::vec2(1280.0, 720.0);
/// A colour that nothing else on the page has.
const MAGENTA: [f32; 4] = [1.0, 0.0, 1.0, 1.0];

/// A magenta brick that means cluster 1, and how often it was asked for.
struct Brick {
    composed: usize,
}

impl Studio for Brick {
    fn demos(&self) -> Vec<Demo> {
        Vec::new()
    }

    fn robots(&self) -> Vec<RobotChoice> {
        Vec::new()
    }

    fn export(&self, _document: &Document, _outputs: &Outputs, _format: ExportFormat) -> Result<String, String> {
        Err("a brick has no grasps".to_owned())
    }

    fn export_motion(
        &self,
        _document: &Document,
        _outputs: &Outputs,
        _format: MotionFormat,
    ) -> Result<Vec<u8>, String> {
        Err("a brick has no plan".to_owned())
    }

    fn compose(&mut self, _input: &ComposeInput<'_>) -> Picture {
        self.composed += 1;
        let brick = MeshDraw {
            mesh: Arc::new(shapes::cuboid(Vector3::new(0.3, 0.6, 0.2))),
            X_WM: Isometry3::translation(0.5, 0.0, 0.8),
            color: MAGENTA,
            surface: Surface::Unlit,
            pick_id: Pick::Cluster(1).id(),
        };
        let label = Label { p_W: [0.5, 0.0, 0.9].into(), text: "Brick".to_owned(), tone: Tone::Plain };
        Picture { frame: Frame { meshes: vec![brick], ..Frame::default() }, labels: vec![label], ..Picture::default() }
    }
}

struct Whole {
    page: Page,
    view: View3d,
    studio: Brick,
}

fn whole() -> Harness<'static, Whole> {
    whole_at(0.25)
}

/// With so many seconds from one frame to the next.
fn whole_at(step_s: f32) -> Harness<'static, Whole> {
    let gpu = create_render_state(default_wgpu_setup(), eframe::egui_wgpu::RendererOptions::PREDICTABLE);
    // The test renderer wants a state that has drawn nothing yet, so it is made before the view.
    let renderer = WgpuTestRenderer::from_render_state(gpu.clone());
    let page = Page { state: invented::planned(), effects: Vec::new(), commands: Vec::new() };
    let whole = Whole { page, view: View3d::new(&gpu), studio: Brick { composed: 0 } };
    let show = |ui: &mut egui::Ui, whole: &mut Whole| {
        let window = ui.ctx().content_rect();
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(window));
        ui.set_clip_rect(window);
        let mut commands = whole.view.show(&mut ui, &whole.page.state, &mut whole.studio);
        commands.extend(draw_panels(&mut ui, &whole.page.state));
        for command in commands {
            let _effects = whole.page.state.apply(command);
        }
    };
    Harness::builder()
        .with_size(SIZE)
        .with_step_dt(step_s)
        .with_theme(Theme::Dark)
        .renderer(renderer)
        .with_context_setup(theme::install)
        .build_ui_state(show, whole)
}

/// Pixels of the brick: how many, and their middle.
fn brick(picture: &RgbaImage) -> (usize, Pos2) {
    let found: Vec<(f32, f32)> = picture
        .enumerate_pixels()
        .filter(|(_, _, pixel)| pixel.0[0] > 230 && pixel.0[1] < 25 && pixel.0[2] > 230)
        .map(|(x, y, _)| (x as f32, y as f32))
        .collect();
    let n = found.len().max(1) as f32;
    let sum = found.iter().fold((0.0, 0.0), |sum, at| (sum.0 + at.0, sum.1 + at.1));
    (found.len(), Pos2::new(sum.0 / n, sum.1 / n))
}

fn picture(harness: &mut Harness<'_, Whole>) -> RgbaImage {
    harness.run_steps(3);
    let picture = harness.render().expect("the software rasteriser draws");
    if let Some(folder) = std::env::var_os("ENDCOMFORT_LOOK") {
        let n = harness.state().view.camera().distance_m;
        picture.save(std::path::Path::new(&folder).join(format!("view-{n:.3}.png"))).expect("it can be written");
    }
    picture
}

#[test]
fn the_view_frames_the_scene_between_the_panels_and_follows_the_hand() {
    let mut harness = whole();
    let (count, middle) = brick(&picture(&mut harness));
    let free = Layout::new(egui::Rect::from_min_size(Pos2::ZERO, SIZE), None).free;
    assert!(count > 5_000, "the brick is framed: {count} pixels");
    // The label hides a little of the brick, so its middle is not exact.
    assert!((middle - free.center()).length() < 25.0, "{middle:?} is not the middle of {free:?}");

    // Nothing changes, nothing is composed again.
    let composed = harness.state().studio.composed;
    harness.run_steps(5);
    assert_eq!(harness.state().studio.composed, composed);

    // The wheel zooms in, and what is under the pointer stays there.
    harness.hover_at(middle);
    harness.run_steps(2);
    let before = harness.state().view.camera();
    let delta = egui::vec2(0.0, 120.0);
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta,
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run_steps(12);
    assert!(harness.state().view.camera().distance_m < 0.95 * before.distance_m);
    // What is told of the brick lies over it.
    harness.hover_at(Pos2::new(4.0, 4.0));
    let (nearer, still) = brick(&picture(&mut harness));
    harness.hover_at(middle);
    harness.run_steps(2);
    assert!(nearer > count, "{nearer} pixels after zooming, {count} before");
    assert!((still - middle).length() < 12.0, "{still:?} against {middle:?}");

    // A click on the brick selects its cluster.
    assert_eq!(harness.state().page.state.hover.cluster, Some(1));
    harness.drag_at(middle);
    harness.drop_at(middle);
    harness.run_steps(3);
    assert_eq!(harness.state().page.state.selection.cluster, Some(1));

    // A drag turns about the point that was grabbed: it keeps its distance from the eye.
    let before = harness.state().view.camera();
    harness.drag_at(middle);
    harness.run_steps(1);
    for step in 1..=6 {
        harness.hover_at(middle + egui::vec2(20.0 * step as f32, 0.0));
        harness.run_steps(1);
    }
    harness.drop_at(middle + egui::vec2(120.0, 0.0));
    harness.run_steps(2);
    let after = harness.state().view.camera();
    let turned = (before.yaw_rad - after.yaw_rad).abs();
    // 120 points at a quarter turn per 300 points are 36°, less what the drag needs to be told from a click.
    assert!((0.4..0.7).contains(&turned), "turned by {turned} rad");
    assert!((before.distance_m - after.distance_m).abs() < 1e-9);
}

#[test]
fn a_camera_that_a_link_brings_is_not_framed_over_whether_it_comes_first_or_later() {
    let wanted = Camera { yaw_rad: -1.0, distance_m: 4.0, ..Camera::default() };
    let mut harness = whole();
    harness.state_mut().view.place(wanted);
    harness.run_steps(5);
    assert_eq!(harness.state().view.camera(), wanted, "before anything was framed");

    let mut harness = whole();
    harness.run_steps(3);
    assert_ne!(harness.state().view.camera(), wanted);
    harness.state_mut().view.go(ViewEffect::FrameAll);
    harness.state_mut().view.place(wanted);
    assert_eq!(harness.state().view.camera(), wanted, "also for a link that is made before the next picture");
    harness.run_steps(30);
    assert_eq!(harness.state().view.camera(), wanted, "over a frame that was asked for at the same time");
}

#[test]
fn a_drag_that_starts_on_a_panel_leaves_the_camera_alone() {
    let mut harness = whole();
    harness.run_steps(3);
    let before = harness.state().view.camera();
    harness.drag_at(Pos2::new(100.0, 560.0));
    harness.run_steps(1);
    harness.hover_at(Pos2::new(600.0, 360.0));
    harness.run_steps(2);
    harness.drop_at(Pos2::new(600.0, 360.0));
    harness.run_steps(2);
    assert_eq!(harness.state().view.camera(), before);
}

#[test]
fn a_double_click_goes_to_what_is_there_and_a_drag_takes_over_on_the_way() {
    let mut harness = whole_at(0.02);
    let (_, middle) = brick(&picture(&mut harness));
    let before = harness.state().view.camera();
    for _ in 0..2 {
        harness.drag_at(middle);
        harness.drop_at(middle);
        harness.run_steps(1);
    }
    harness.run_steps(30);
    let near = harness.state().view.camera();
    assert!(near.distance_m < 0.91 && near.distance_m < before.distance_m, "{} m", near.distance_m);
    assert!((near.target - nalgebra::Point3::new(0.5, 0.0, 0.8)).norm() < 0.4, "{}", near.target);

    // A named view begins its way, and the hand stops it.
    harness.state_mut().view.go(ViewEffect::Look(Named::Back));
    harness.run_steps(2);
    harness.drag_at(middle);
    harness.hover_at(middle + egui::vec2(30.0, 0.0));
    harness.run_steps(30);
    let yaw_rad = harness.state().view.camera().yaw_rad;
    harness.drop_at(middle + egui::vec2(30.0, 0.0));
    harness.run_steps(10);
    assert!((yaw_rad.abs() - std::f64::consts::PI).abs() > 0.1, "it did not arrive behind: {yaw_rad}");
    assert_eq!(harness.state().view.camera().yaw_rad, yaw_rad);
}

#[test]
fn keys_fly_the_camera_while_they_are_held() {
    let mut harness = whole();
    harness.run_steps(3);
    let before = harness.state().view.camera();
    harness.key_down(egui::Key::D);
    harness.run_steps(10);
    harness.key_up(egui::Key::D);
    harness.run_steps(2);
    let after = harness.state().view.camera();
    let moved = after.target - before.target;
    assert!(moved.dot(&before.right()) > 0.01 && moved.z.abs() < 1e-12, "{moved}");
    harness.run_steps(5);
    assert_eq!(harness.state().view.camera(), after);
}
