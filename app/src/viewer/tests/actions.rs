//! Keys, the list of keys, the palette, and the menu of the view.

use std::collections::HashSet;

use egui::{Event, Key, Modifiers, Theme};
use egui_kittest::kittest::Queryable as _;

use super::{invented, page};
use crate::render::{Camera, Projection};
use crate::viewer::actions::{self, GESTURES};
use crate::viewer::{Command, Effect, Overlay, Turning, ViewCommand, ViewEffect};

const SIZE: [f32; 2] = [1280.0, 720.0];

#[test]
fn no_two_actions_have_the_same_key_or_the_same_name() {
    let state = invented::planned();
    let keyed = actions::with_keys(&state);
    let chords: HashSet<_> = keyed.iter().filter_map(|action| action.shortcut).map(|s| (s.modifiers, s.key)).collect();
    assert_eq!(chords.len(), keyed.len());
    let all: Vec<_> = keyed.into_iter().chain(actions::without_keys(&state)).collect();
    let names: HashSet<&str> = all.iter().map(|action| action.title.as_ref()).collect();
    assert_eq!(names.len(), all.len());
}

#[test]
fn the_list_shows_every_key_and_gesture() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.key_press(Key::Questionmark);
    harness.run_steps(2);
    assert_eq!(harness.state().state.overlay, Overlay::Help);
    for action in actions::with_keys(&harness.state().state) {
        assert!(harness.query_all_by_label(&action.title).count() >= 1, "{} is not listed", action.title);
    }
    for (_, what) in GESTURES {
        assert!(harness.query_all_by_label(what).count() >= 1, "{what} is not listed");
    }
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(harness.state().state.overlay, Overlay::None);
}

#[test]
fn the_palette_finds_by_letters_and_does_what_was_chosen_with_the_keyboard_alone() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::K);
    harness.run_steps(3);
    assert_eq!(harness.state().state.overlay, Overlay::Palette);
    harness.event(egui::Event::Text("orthog".to_owned()));
    harness.run_steps(2);
    assert!(harness.query_all_by_label("Orthographic view").count() >= 1);
    assert_eq!(harness.query_all_by_label("Frame everything").count(), 0, "what does not fit is left out");
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    let state = &harness.state().state;
    assert_eq!((state.overlay, state.viewing.projection), (Overlay::None, Projection::Orthographic));
    // Space belongs to the page again.
    harness.key_press(Key::Space);
    harness.run_steps(1);
    assert!(harness.state().state.playback.playing);
}

#[test]
fn what_is_typed_behind_the_palettes_chord_within_one_frame_is_for_its_field() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(1);
    let press = |key, modifiers| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
    // "top": T alone is the tour, O and P are commands as well.
    harness.input_mut().events.extend([press(Key::K, Modifiers::COMMAND), press(Key::T, Modifiers::NONE)]);
    harness.input_mut().events.push(Event::Text("to the t".to_owned()));
    harness.step();
    assert_eq!(harness.state().state.overlay, Overlay::Palette);
    // Before the field was ever drawn.
    harness.input_mut().events.extend([press(Key::T, Modifiers::NONE), Event::Text("op".to_owned())]);
    harness.step();
    harness.run_steps(1);
    assert!(harness.state().state.tour.is_none());
    assert_eq!(harness.state().state.overlay, Overlay::Palette);
    assert!(harness.query_all_by_value("to the top").count() >= 1);
}

#[test]
fn arrows_walk_through_the_palette_and_escape_closes_it_without_a_deed() {
    let mut harness = page(invented::planned(), SIZE, Theme::Light);
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::K);
    harness.run_steps(3);
    harness.event(egui::Event::Text("layer".to_owned()));
    harness.run_steps(2);
    let layers = harness.state().state.layers;
    harness.key_press(Key::ArrowDown);
    harness.run_steps(2);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!((harness.state().state.overlay, harness.state().state.layers), (Overlay::None, layers));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::K);
    harness.run_steps(3);
    harness.event(egui::Event::Text("nothing is called so".to_owned()));
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label("Nothing is called so.").count(), 1);
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    assert_eq!(harness.state().state.layers, layers);
}

#[test]
fn the_menu_of_the_view_sets_how_it_is_looked_at() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.get_by_label("View").click();
    harness.run_steps(3);
    harness.get_by_label("Orthographic").click();
    harness.run_steps(2);
    harness.get_by_label("Free").click();
    harness.run_steps(2);
    let viewing = &harness.state().state.viewing;
    assert_eq!((viewing.projection, viewing.turning), (Projection::Orthographic, Turning::Free));
    harness.get_by_label("Turntable").click();
    harness.run_steps(2);
    harness.get_by_label("From behind").click();
    harness.run_steps(2);
    let asked: Vec<ViewEffect> = harness
        .state()
        .effects
        .iter()
        .filter_map(|effect| if let Effect::View(effect) = effect { Some(*effect) } else { None })
        .collect();
    assert_eq!(asked, [ViewEffect::Level, ViewEffect::Look(crate::render::Named::Back)]);
}

#[test]
fn a_kept_view_is_gone_back_to_with_its_projection_until_it_is_forgotten() {
    let mut state = invented::planned();
    let camera = Camera { projection: Projection::Orthographic, yaw_rad: 1.0, ..Camera::default() };
    let _said = state.apply(Command::View(ViewCommand::KeepCamera(camera)));
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.get_by_label("View").click();
    harness.run_steps(3);
    harness.get_by_label("View 1").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.viewing.projection, Projection::Orthographic);
    let went = |effect: &Effect| matches!(effect, Effect::View(ViewEffect::GoTo(to)) if *to == camera);
    assert!(harness.state().effects.iter().any(went));
    harness.get_by_label("View").click();
    harness.run_steps(3);
    harness.get_by_label("Forget View 1").click();
    harness.run_steps(2);
    assert!(harness.state().state.viewing.kept.is_empty());
}
