//! Sharing, restoring and being embedded, as a person meets them.

use std::sync::Arc;

use egui::{Key, Modifiers, Theme};
use egui_kittest::kittest::Queryable as _;

use super::{invented, page};
use crate::render::Camera;
use crate::viewer::ViewEffect;
use crate::viewer::share::Offer;
use crate::viewer::{Command, Effect, Layer, Overlay, link_text, read_link};

const SIZE: [f32; 2] = [1440.0, 900.0];

#[test]
fn the_chain_and_its_shortcut_copy_a_link_and_a_phone_has_it_in_the_menu() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(2);
    harness.get_by_label("Copy a link to this view (Ctrl Shift S)").click();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    harness.run_steps(2);
    let shared = harness.state().effects.iter().filter(|effect| matches!(effect, Effect::Share)).count();
    assert_eq!(shared, 2);

    let mut harness = page(invented::planned(), [390.0, 800.0], Theme::Light);
    harness.run_steps(2);
    assert!(harness.query_by_label("Copy a link to this view (Ctrl Shift S)").is_none());
    harness.get_by_label_contains("Open a demo; now").click();
    harness.run_steps(3);
    for (row, effect) in
        [("Copy a link to this view", "Share"), ("Save the session", "SaveSession"), ("Save the scene", "Save {")]
    {
        if harness.query_by_label(row).is_none() {
            harness.get_by_label_contains("Open a demo; now").click();
            harness.run_steps(3);
        }
        harness.get_by_label(row).click();
        harness.run_steps(3);
        let newest = format!("{:?}", harness.state().effects.last());
        assert!(newest.starts_with(&format!("Some({effect}")), "{row}: {newest}");
    }
}

#[test]
fn a_link_comes_to_stand_with_the_plan_and_the_camera_is_not_framed_over_it() {
    let mut shared = invented::planned();
    let grasp = shared.outputs.candidates()[2].id;
    let _none = shared.apply(Command::SetPlaying(false));
    let _none = shared.apply(Command::SelectGrasp(grasp));
    let _none = shared.apply(Command::Seek(0.75 * shared.duration_s()));
    let _none = shared.apply(Command::ToggleLayer(Layer::Cloud));
    let camera = Camera { yaw_rad: 1.5, ..Camera::default() };
    let link = link_text(&shared, Some(camera)).expect("a link");

    let mut state = invented::fresh();
    let opened = read_link(&link, &state.demos).expect("it opens");
    let mut effects = state.apply(Command::OpenShared(Box::new(opened)));
    assert!(matches!(effects[0], Effect::Run(_)), "{effects:?}");
    for (elapsed_ms, output) in invented::outputs() {
        invented::done(&mut state, elapsed_ms, output);
    }
    effects.extend(state.receive(endcomfort_core::job::Update::Finished { revision: state.revision }));
    let placed = effects.iter().any(|effect| matches!(effect, Effect::PlaceCamera(at) if *at == camera));
    assert!(
        placed && !effects.iter().any(|effect| matches!(effect, Effect::View(ViewEffect::FrameAll))),
        "{effects:?}"
    );
    assert_eq!(state.selection.step, shared.selection.step);
    assert_eq!(state.selection.grasp, Some(grasp));
    assert_eq!(state.layers, shared.layers);
    assert!((state.playback.time_s - shared.playback.time_s).abs() < 1e-4 && !state.playback.playing);
}

#[test]
fn what_was_open_at_the_last_visit_is_offered_above_the_demos() {
    let mut before = invented::planned();
    let _run = before.apply(Command::SetSeed(77));
    let opened = read_link(&link_text(&before, None).expect("a link"), &before.demos).expect("it opens");
    let mut state = invented::fresh();
    state.offer = Some(Offer { title: "Upside-down glass".to_owned(), age_s: 720.0, opened });
    state.overlay = Overlay::Gallery;
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(2);
    assert!(harness.query_by_label("Upside-down glass, 12 minutes ago").is_some());
    harness.get_by_label("Restore what you had open").click();
    harness.run_steps(2);
    let state = &harness.state().state;
    assert_eq!((state.document.scene.seed, state.overlay, &state.offer), (77, Overlay::None, &None));
}

#[test]
fn in_a_frame_the_presentation_is_not_left_and_the_gallery_does_not_open() {
    let mut state = invented::planned();
    state.is_embedded = true;
    let _framed = state.apply(Command::Present(true));
    let mut harness = page(state, [880.0, 560.0], Theme::Dark);
    harness.run_steps(2);
    for key in [Key::Escape, Key::P, Key::G] {
        harness.key_press(key);
        harness.run_steps(2);
    }
    let state = &harness.state().state;
    assert!(state.presentation.is_some() && state.overlay == Overlay::None);
    assert!(harness.query_by_label("Leave the presentation (Esc)").is_none());
    harness.get_by_label("Open in Endcomfort").click();
    harness.run_steps(2);
    assert!(harness.state().effects.iter().any(|effect| matches!(effect, Effect::OpenPage)));
}

#[test]
fn a_file_is_named_by_letters_that_any_system_takes() {
    let mut state = invented::fresh();
    Arc::make_mut(&mut state.document.scene).name = "../etc/a b".to_owned();
    assert_eq!(state.file_name("json"), "---etc-a-b.json");
}
