//! What happens when somebody touches something.

use egui::{Key, Modifiers, Theme};
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::grasp::Quantity;
use endcomfort_core::job::{Refusal, Stage, Update};
use endcomfort_core::scene::Scene;

use super::{invented, page};
use crate::viewer::state::{StageState, Step};
use crate::viewer::{Column, Command, Effect, Layer, Overlay, Posture, ViewerState};

const SIZE: [f32; 2] = [1440.0, 900.0];

fn ranked() -> ViewerState {
    let mut state = invented::planned();
    let _none = state.apply(Command::SelectStep(Step::Stage(Stage::Rank)));
    state
}

fn third(state: &ViewerState) -> u32 {
    state.outputs.candidates()[2].id
}

fn refusal(message: &str) -> Refusal {
    Refusal::new(message).with_details(vec!["first detail".to_owned()])
}

#[test]
fn clicking_a_row_selects_its_grasp_and_hovering_it_points_at_it() {
    let state = ranked();
    let id = third(&state);
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(2);
    let row = harness.get_by_label_contains(&format!("Grasp {id}:")).rect();
    harness.hover_at(row.center());
    harness.run_steps(2);
    assert_eq!(harness.state().state.hover.grasp, Some(id));
    harness.get_by_label_contains(&format!("Grasp {id}:")).click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.selection.grasp, Some(id));
    harness.remove_cursor();
    harness.run_steps(2);
    assert_eq!(harness.state().state.hover.grasp, None);
}

#[test]
fn space_plays_and_pauses_and_the_arrows_step() {
    let mut harness = page(ranked(), SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.key_press(Key::Space);
    harness.run_steps(1);
    assert!(harness.state().state.playback.playing);
    harness.key_press(Key::Space);
    harness.run_steps(1);
    assert!(!harness.state().state.playback.playing);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(1);
    assert!((harness.state().state.playback.time_s - 0.1).abs() < 1e-9);
}

#[test]
fn pressing_the_track_goes_to_that_time() {
    let mut harness = page(ranked(), SIZE, Theme::Dark);
    harness.run_steps(1);
    let track = harness.get_by_label("Time").rect();
    harness.drag_at(track.center());
    harness.run_steps(2);
    let state = &harness.state().state;
    assert!((state.playback.time_s / state.duration_s() - 0.5).abs() < 0.01, "{}", state.playback.time_s);
}

#[test]
fn a_refused_stage_shows_its_reason_and_what_was_tried() {
    let mut state = ranked();
    let _run = state.apply(Command::SetSeed(8));
    let reason = "No cluster has 300 points.";
    let revision = state.revision;
    let _announced = state.receive(Update::Refused { revision, stage: Stage::Segment, refusal: refusal(reason) });
    assert_eq!(state.selection.step, Step::Stage(Stage::Segment));
    assert!(state.outputs.plan.is_none(), "a plan that no longer follows is not shown");
    let mut harness = page(state, SIZE, Theme::Light);
    harness.run_steps(2);
    assert!(harness.query_all_by_label(reason).count() >= 2, "in the stepper and in the inspector");
    assert_eq!(harness.query_all_by_label("first detail").count(), 1);
}

#[test]
fn an_update_for_an_older_revision_is_dropped() {
    let mut state = invented::fresh();
    let older = state.revision;
    let _run = state.apply(Command::SetSeed(11));
    for (elapsed_ms, output) in invented::outputs() {
        let effects = state.receive(Update::Done { revision: older, elapsed_ms, output: Box::new(output) });
        assert!(effects.is_empty());
    }
    assert!(state.outputs.scene.is_none() && state.outputs.plan.is_none());
    assert_eq!(*state.stage(Stage::Scene), StageState::Waiting);
}

#[test]
fn old_results_stay_marked_as_out_of_date_until_new_ones_stand() {
    let mut state = ranked();
    let _run = state.apply(Command::SetSeed(12));
    assert!(Stage::ALL.into_iter().all(|stage| state.is_stale(stage)));
    assert!(state.outputs.plan.is_some() && state.plan_json().is_none());
    for (elapsed_ms, output) in invented::outputs() {
        invented::done(&mut state, elapsed_ms, output);
    }
    assert!(!Stage::ALL.into_iter().any(|stage| state.is_stale(stage)));
    assert!(state.plan_json().is_some());
}

#[test]
fn undo_brings_the_scene_back_and_redo_takes_it_forth() {
    let mut harness = page(ranked(), SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.get_by_label("Alita").click();
    harness.run_steps(2);
    let robot = |harness: &egui_kittest::Harness<'_, super::Page>| harness.state().state.scene().robot.clone();
    assert_eq!(robot(&harness), "alita");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(1);
    assert_eq!(robot(&harness), "crichton");
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(1);
    assert_eq!(robot(&harness), "alita");
    let runs = harness.state().effects.iter().filter(|effect| matches!(effect, Effect::Run(_))).count();
    assert_eq!(runs, 3, "each of the three asks for a new run");
}

#[test]
fn an_unreadable_file_is_reported_and_the_scene_stands_as_it_was() {
    let mut state = ranked();
    let (revision, seed) = (state.revision, state.document.scene.seed);
    let effects = state.apply(Command::OpenFile { name: "cut.pcd".to_owned(), bytes: b"VERSION .7".to_vec() });
    assert!(matches!(effects.first(), Some(Effect::Run(request)) if request.cloud.is_some()));
    let update = Update::Refused {
        revision: state.revision,
        stage: Stage::Scene,
        refusal: refusal("cut.pcd ends in its header."),
    };
    let _announced = state.receive(update);
    assert_eq!((state.revision, state.document.scene.seed), (revision, seed));
    assert!(state.document.cloud.is_none() && state.plan_json().is_some() && !state.can_undo());
    assert_eq!(*state.stage(Stage::Plan), StageState::Done { elapsed_ms: 6.3 });
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(3);
    assert_eq!(harness.query_all_by_label("cut.pcd ends in its header.").count(), 1);
    harness.get_by_label("Close this message").click();
    harness.run_steps(2);
    assert!(harness.state().state.messages.is_empty());
}

#[test]
fn a_scene_file_is_opened_and_a_broken_one_is_refused_with_its_reason() {
    let mut state = ranked();
    let scene = Scene { seed: 99, ..(**state.scene()).clone() };
    let bytes = serde_json::to_vec(&scene).unwrap();
    let effects = state.apply(Command::OpenFile { name: "mine.json".to_owned(), bytes: bytes.clone() });
    assert!(matches!(effects.first(), Some(Effect::Run(request)) if request.scene.seed == 99));
    let broken = bytes[..bytes.len() / 2].to_vec();
    let effects = state.apply(Command::OpenFile { name: "cut.json".to_owned(), bytes: broken });
    assert!(matches!(effects.as_slice(), [Effect::Announce(sentence)] if sentence.contains("cut.json")));
    assert_eq!(state.scene().seed, 99);
}

#[test]
fn a_hand_description_gives_the_acting_arm_another_hand_until_it_is_undone() {
    let mut state = ranked();
    let json = crate::assets::read("robots/hands/adaptive.json").unwrap().to_vec();
    let open = |bytes: Vec<u8>| Command::OpenFile { name: "mine.json".to_owned(), bytes };
    let effects = state.apply(open(json.clone()));
    let asked_for = effects.iter().find_map(|effect| match effect {
        Effect::Run(request) => request.scene.hand.clone(),
        _ => None,
    });
    assert_eq!(asked_for.map(|hand| hand.name).as_deref(), Some("Two adaptive fingers"));
    assert_eq!(state.scene().grasp.friction, 0.7, "the friction of its pads");
    assert!(state.messages.iter().any(|message| !message.is_error && message.text.contains("Two adaptive fingers")));
    let wrong = String::from_utf8(json).unwrap().replace("\"palm_link\": \"palm\"", "\"palm_link\": \"hand\"");
    let effects = state.apply(open(wrong.into_bytes()));
    let reason = "the URDF has no link \"hand\"";
    assert!(matches!(effects.as_slice(), [Effect::Announce(sentence)] if sentence.contains(reason)), "{effects:?}");
    let _run = state.apply(Command::Undo);
    assert!(state.scene().hand.is_none() && state.scene().grasp.friction == 0.5);
}

#[test]
fn cancel_stops_the_worker_and_leaves_the_old_results() {
    let mut state = ranked();
    let _run = state.apply(Command::SetSeed(5));
    let progress = Update::Progress { revision: state.revision, stage: Stage::Fit, fraction: 0.5, note: String::new() };
    let _none = state.receive(progress);
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(2);
    harness.get_by_label("Cancel").click();
    harness.run_steps(2);
    assert!(matches!(harness.state().effects.as_slice(), [Effect::Cancel]));
    let state = &harness.state().state;
    assert!(!state.running && state.outputs.plan.is_some());
    assert_eq!(*state.stage(Stage::Fit), StageState::Stale);
}

#[test]
fn the_table_sorts_by_a_column_and_turns_round_at_the_second_click() {
    let mut harness = page(ranked(), SIZE, Theme::Dark);
    harness.run_steps(1);
    let name = "Sort by Largest-ball quality ε";
    harness.get_by_label(name).click();
    harness.run_steps(2);
    let epsilons = |state: &ViewerState| -> Vec<f64> {
        let grasps = state.outputs.candidates();
        state.table_rows().into_iter().map(|row| grasps[row].epsilon).collect()
    };
    assert_eq!(harness.state().state.table.sort, Column::Of(Quantity::Epsilon));
    assert!(epsilons(&harness.state().state).is_sorted_by(|a, b| a >= b));
    harness.get_by_label(name).click();
    harness.run_steps(2);
    assert!(epsilons(&harness.state().state).is_sorted());
    harness.get_by_label_contains("Accepted 37").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.table_rows().len(), 37);
}

#[test]
fn stepping_through_the_ik_set_shows_each_solution_and_playing_leaves_it() {
    let mut harness = page(ranked(), SIZE, Theme::Dark);
    harness.run_steps(1);
    for index in 0..2 {
        harness.get_by_label("Next solution").click();
        harness.run_steps(2);
        let posture = harness.state().state.posture();
        assert!(matches!(posture, Posture::Ik { index: shown, .. } if shown == index), "{posture:?}");
    }
    harness.key_press(Key::Space);
    harness.run_steps(1);
    assert!(matches!(harness.state().state.posture(), Posture::Plan { .. }));
}

#[test]
fn planning_with_a_grasp_asks_the_worker_for_that_grasp() {
    let mut state = ranked();
    let id = third(&state);
    let _none = state.apply(Command::SelectGrasp(id));
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(2);
    harness.get_by_label("Plan with grasp 3").click();
    harness.run_steps(2);
    let asked = harness.state().effects.iter().find_map(|effect| match effect {
        Effect::Run(request) => request.grasp,
        _ => None,
    });
    assert_eq!(asked, Some(id));
}

#[test]
fn a_layer_is_hidden_by_its_eye_and_the_picture_depends_on_it() {
    let mut harness = page(ranked(), SIZE, Theme::Dark);
    harness.run_steps(1);
    let before = harness.state().state.view_key(true);
    harness.get_by_label("Hide Cloud").click();
    harness.run_steps(2);
    let state = &harness.state().state;
    assert_eq!(state.layers.opacity(Layer::Cloud), 0.0);
    assert_ne!(state.view_key(true), before);
}

#[test]
fn escape_closes_the_gallery_and_a_card_opens_its_demo() {
    let mut state = ranked();
    let _none = state.apply(Command::Show(Overlay::Gallery));
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(3);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(harness.state().state.overlay, Overlay::None);
    harness.key_press(Key::G);
    harness.run_steps(3);
    harness.get_by_label("Open Crichton moves a jar onto a box").click();
    harness.run_steps(3);
    let page = harness.state();
    assert_eq!((page.state.overlay, page.state.scene().name.as_str()), (Overlay::None, "jar"));
    assert!(page.effects.iter().any(|effect| matches!(effect, Effect::Run(request) if request.scene.name == "jar")));
}

#[test]
fn the_seed_field_runs_the_pipeline_with_the_number_that_was_typed() {
    let mut harness = page(ranked(), SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.get_by_role_and_label(egui::Role::TextInput, "seed").focus();
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.get_by_role_and_label(egui::Role::TextInput, "seed").type_text("42");
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    assert_eq!(harness.state().state.scene().seed, 42);
}
