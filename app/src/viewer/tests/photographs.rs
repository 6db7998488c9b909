//! Pictures at sizes that no window has, with the real renderer, read back without waiting.

use std::sync::Arc;
use std::time::Duration;

use egui::Context;
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use endcomfort_core::job::Stage;
use image::RgbaImage;
use nalgebra::{Isometry3, Vector3};

use super::bench::Bench;
use crate::render::{Frame, MeshDraw, Quality, SizeError, Surface, shapes};
use crate::studio::BuiltInStudio;
use crate::viewer::photographer::Photographer;
use crate::viewer::view3d::View3d;
use crate::viewer::{Command, Label, Picture, Posture, Shot, Studio as _, Tone, ViewCommand};

/// A colour that nothing else has.
const MAGENTA: [f32; 4] = [1.0, 0.0, 1.0, 1.0];
const SHOT: Shot = Shot { size_px: [640, 360], scale: 1.0, transparent: true, words: false, dark: true };

struct Booth {
    ctx: Context,
    view: View3d,
    photographer: Photographer,
}

impl Booth {
    fn new() -> Self {
        let gpu = create_render_state(default_wgpu_setup(), eframe::egui_wgpu::RendererOptions::PREDICTABLE);
        Self { ctx: Context::default(), view: View3d::new(&gpu), photographer: Photographer::default() }
    }

    fn take(&mut self, picture: &Picture, shot: &Shot) -> RgbaImage {
        let camera = self.view.camera_for(shot.size_px);
        self.photographer
            .expose(&self.ctx, &mut self.view, picture, (camera, None), (shot, Quality::Live))
            .expect("it is not too large");
        assert!(self.photographer.is_busy(), "nobody waits for the pixels");
        for _ in 0..10_000 {
            if let Some(arrived) = self.photographer.develop(&mut self.view) {
                assert!(!self.photographer.is_busy());
                return arrived.expect("the device is there");
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("the picture never arrived");
    }
}

/// A magenta brick with its name above it.
fn brick() -> Picture {
    let brick = MeshDraw {
        mesh: Arc::new(shapes::cuboid(Vector3::new(0.3, 0.6, 0.2))),
        X_WM: Isometry3::translation(0.4, 0.0, 0.9),
        color: MAGENTA,
        surface: Surface::Unlit,
        pick_id: 0,
    };
    let label = Label { p_W: [0.4, 0.0, 1.0].into(), text: "Brick".to_owned(), tone: Tone::Plain };
    Picture { frame: Frame { meshes: vec![brick], ..Frame::default() }, labels: vec![label], ..Picture::default() }
}

fn differing(a: &RgbaImage, b: &RgbaImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

fn magenta(picture: &RgbaImage) -> usize {
    picture.pixels().filter(|pixel| pixel.0 == [255, 0, 255, 255]).count()
}

#[test]
fn a_picture_has_the_size_that_was_asked_for_and_a_clear_or_a_full_background() {
    let mut booth = Booth::new();
    let clear = booth.take(&brick(), &SHOT);
    assert_eq!(clear.dimensions(), (640, 360));
    assert_eq!(clear.get_pixel(0, 0).0[3], 0);
    let full = booth.take(&brick(), &Shot { transparent: false, ..SHOT });
    assert!(full.pixels().all(|pixel| pixel.0[3] == 255));
    // Twice as large, the brick covers four times as many pixels; its rim is a hundredth of them.
    let large = booth.take(&brick(), &Shot { size_px: [1280, 720], ..SHOT });
    let ratio = magenta(&large) as f64 / magenta(&clear) as f64;
    assert!((ratio - 4.0).abs() < 0.1, "{ratio}");
    assert_eq!(differing(&clear, &booth.take(&brick(), &SHOT)), 0, "the same again");
}

#[test]
fn words_stand_in_the_picture_and_grow_with_the_scale() {
    let mut booth = Booth::new();
    let without = booth.take(&brick(), &SHOT);
    let words = |booth: &mut Booth, scale: f32| {
        let plain = booth.take(&brick(), &Shot { scale, ..SHOT });
        differing(&plain, &booth.take(&brick(), &Shot { words: true, scale, ..SHOT }))
    };
    let (once, twice) = (words(&mut booth, 1.0), words(&mut booth, 2.0));
    assert!((300..3000).contains(&once), "{once} pixels of words");
    let ratio = twice as f64 / once as f64;
    // A pill of words; its frame and the pin below it are as thick as a point.
    assert!((3.2..4.4).contains(&ratio), "{once} and {twice} pixels");
    assert_eq!(differing(&without, &booth.take(&brick(), &SHOT)), 0, "no word stays behind");
}

#[test]
fn what_is_too_large_is_refused_before_anything_is_drawn() {
    let mut booth = Booth::new();
    let camera = booth.view.camera();
    for (shot, wanted) in [
        (Shot { size_px: [0, 9], ..SHOT }, "each side"),
        (Shot { size_px: [40_000, 9], ..SHOT }, "each side"),
        (Shot { size_px: [8000, 8000], ..SHOT }, "64.0 million"),
        (Shot { scale: 0.0, ..SHOT }, "pixels per point"),
    ] {
        let refused =
            booth.photographer.expose(&booth.ctx, &mut booth.view, &brick(), (camera, None), (&shot, Quality::Live));
        let refused: SizeError = refused.expect_err("it is too large");
        assert!(refused.to_string().contains(wanted), "{refused}");
        assert!(!booth.photographer.is_busy());
    }
}

#[test]
fn a_frame_of_a_planned_demo_shows_its_moment_whatever_was_drawn_before() {
    let mut bench = Bench::until("jar", Stage::Plan);
    bench.apply(Command::View(ViewCommand::FrameAll));
    let (mut booth, mut studio) = (Booth::new(), BuiltInStudio::default());
    let shot = Shot { size_px: [480, 300], transparent: false, words: true, ..SHOT };
    let mut at = |time_s: f64| {
        let mut input = bench.page.state.compose_input(shot.dark);
        input.posture = Posture::Plan { time_s };
        let picture = studio.compose(&input);
        booth.take(&picture, &shot)
    };
    let (first, later) = (at(3.0), at(9.0));
    assert!(differing(&first, &later) > 480 * 300 / 100, "the robot moves");
    assert_eq!(differing(&first, &at(3.0)), 0, "a moment is a picture, whenever it is drawn");
    if let Some(folder) = std::env::var_os("ENDCOMFORT_LOOK") {
        later.save(std::path::Path::new(&folder).join("photograph.png")).expect("it can be written");
    }
}
