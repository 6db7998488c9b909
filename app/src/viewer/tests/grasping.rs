//! Grasps from the settings to the pixels: what is asked for, listed, coloured, drawn and written out.

use egui::{Pos2, Theme};
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::grasp::{
    ApproachCone, ExportFormat, GraspFilter, GraspSettings, GraspStatus, Quantity, RankBy, RankSettings,
};
use endcomfort_core::job::{Refusal, Stage, Update};
use nalgebra::Vector3;

use super::bench::{Bench, picture, window};
use super::{Page, invented, page};
use crate::viewer::state::{StageState, Step};
use crate::viewer::{Column, Command, Effect, GraspCommand, GraspPage, Listed, Studio as _, ViewerState};

const SIZE: [f32; 2] = [1440.0, 900.0];

fn at(stage: Stage, page: GraspPage) -> ViewerState {
    let mut state = invented::planned();
    for command in [Command::SelectStep(Step::Stage(stage)), Command::Grasping(GraspCommand::Page(page))] {
        let _none = state.apply(command);
    }
    state
}

fn panels(stage: Stage, open: GraspPage) -> egui_kittest::Harness<'static, Page> {
    let mut harness = page(at(stage, open), SIZE, Theme::Dark);
    harness.run_steps(2);
    harness
}

/// The first stage of the request that was made last.
fn asked_from(harness: &egui_kittest::Harness<'_, Page>) -> Option<Stage> {
    harness.state().effects.iter().rev().find_map(|effect| match effect {
        Effect::Run(request) => Some(request.first),
        _ => None,
    })
}

#[test]
fn other_settings_ask_from_the_grasps_on_and_another_order_from_the_ranking() {
    let mut harness = panels(Stage::Grasps, GraspPage::Settings);
    harness.get_by_label("Mesh").click();
    harness.run_steps(2);
    assert_eq!(asked_from(&harness), Some(Stage::Grasps));
    let state = &harness.state().state;
    assert_eq!(*state.stage(Stage::Fit), StageState::Done { elapsed_ms: 3.2 }, "the fit stands as it was");
    assert_eq!(*state.stage(Stage::Grasps), StageState::Stale);
    assert_eq!(state.outputs.candidates().len(), 412, "the old ones are shown until the new ones stand");

    let mut harness = panels(Stage::Rank, GraspPage::Order);
    harness.get_by_label("Score").click();
    harness.run_steps(2);
    assert_eq!(asked_from(&harness), Some(Stage::Rank));
    let state = &harness.state().state;
    assert_eq!(state.scene().rank.by, RankBy::Score);
    assert!(state.is_stale(Stage::Rank) && !state.is_stale(Stage::Grasps));
    assert!(state.outputs.is_ranked(), "the old order is shown until the new one stands");
    harness.get_by_label("Usual order").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.scene().rank, RankSettings::default());
}

#[test]
fn an_arm_or_another_robot_leaves_the_cloud_and_the_fit_alone() {
    let mut harness = panels(Stage::Grasps, GraspPage::Settings);
    let torso = "The torso moves with the arm";
    harness.get_by_role_and_label(egui::Role::Switch, torso).click();
    harness.run_steps(2);
    assert!(harness.state().state.scene().torso);
    harness.get_by_label("Left").click();
    harness.run_steps(2);
    assert_eq!(asked_from(&harness), Some(Stage::Grasps));
    harness.get_by_label("Alita").click();
    harness.run_steps(2);
    assert_eq!(asked_from(&harness), Some(Stage::Grasps));
    assert!(harness.query_all_by_label(torso).count() == 0, "Alita has no torso");
}

#[test]
fn missing_values_stand_last_in_both_directions() {
    let mut state = at(Stage::Rank, GraspPage::Table);
    let known = |state: &ViewerState| -> Vec<Option<f64>> {
        let grasps = state.outputs.candidates();
        state.table_rows().into_iter().map(|row| Quantity::MgGoal.of(&grasps[row])).collect()
    };
    for _ in 0..2 {
        let _none = state.apply(Command::Grasping(GraspCommand::SortBy(Column::Of(Quantity::MgGoal))));
        let values = known(&state);
        let there: Vec<f64> = values.iter().copied().map_while(|value| value).collect();
        assert!(there.len() > 37 && values[there.len()..].iter().all(Option::is_none));
        let falls = there.is_sorted_by(|a, b| a >= b);
        assert_eq!(falls, !state.table.reversed);
        assert!(falls || there.is_sorted());
    }
    // Without a rank there is nothing to turn round.
    for _ in 0..2 {
        let _none = state.apply(Command::Grasping(GraspCommand::SortBy(Column::Number)));
    }
    assert!(state.table.reversed);
    let grasps = state.outputs.candidates();
    let ranks: Vec<Option<usize>> = state.table_rows().iter().map(|&r| state.outputs.rank_of(grasps[r].id)).collect();
    assert_eq!((ranks[0], ranks[36], ranks[37]), (Some(37), Some(1), None));
}

#[test]
fn words_fates_and_a_switch_choose_the_rows() {
    let mut harness = panels(Stage::Grasps, GraspPage::Fates);
    harness.get_by_label("List 63: Hits the table").click();
    harness.run_steps(2);
    let fates = |state: &ViewerState| -> Vec<GraspStatus> {
        let grasps = state.outputs.candidates();
        state.table_rows().into_iter().map(|row| grasps[row].status.clone()).collect()
    };
    let state = &harness.state().state;
    assert_eq!(state.grasp_page(Stage::Grasps), GraspPage::Table);
    let listed = fates(state);
    assert!(listed.len() > 20 && listed.iter().all(|s| matches!(s, GraspStatus::HitsTable { .. })));
    harness.get_by_label("Clear the words").click();
    harness.run_steps(2);
    assert_eq!(fates(&harness.state().state).len(), 412);
    harness.get_by_label("Rejected 375").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.table.listed, Listed::Rejected);
    harness.get_by_label("Words in the table").focus();
    harness.run_steps(1);
    harness.get_by_label("Words in the table").type_text("JOINT 6");
    harness.run_steps(2);
    let listed = fates(&harness.state().state);
    assert!(!listed.is_empty() && listed.iter().all(|s| matches!(s, GraspStatus::NoIkAtGoal { .. })));
}

#[test]
fn columns_and_colours_are_chosen_from_lists_and_the_picture_follows() {
    let mut harness = panels(Stage::Rank, GraspPage::Table);
    let before = harness.state().state.view_key(true);
    harness.get_by_label_contains("Colour by").click();
    harness.run_steps(3);
    harness.get_by_label("Success probability").click();
    harness.run_steps(3);
    let state = &harness.state().state;
    assert_eq!((state.grasping.colored_by, state.shown_quantity()), (Some(Quantity::Success), Quantity::Success));
    assert_ne!(state.view_key(true), before);
    harness.get_by_label_contains("Columns").click();
    harness.run_steps(3);
    harness.get_by_label("Hand").click();
    harness.run_steps(3);
    assert_eq!(harness.query_all_by_label("Sort by Width between the contacts").count(), 1);
}

#[test]
fn the_grasp_page_tells_contacts_trials_reasons_and_the_terms_of_the_score() {
    let harness = panels(Stage::Rank, GraspPage::Grasp);
    for words in [
        "Holds under pose noise: 20 of 20 poses, 100 %",
        "joint 6 limit: 40 ×",
        "finger 1: 1.2 mm inside",
        "Clearance: 12 mm",
        "Width: 71 mm",
        "Arm angles within the limits: 5 arcs on 4 of 8 branches",
    ] {
        assert_eq!(harness.query_all_by_label(words).count(), 1, "{words}");
    }
    assert_eq!(harness.query_all_by_label_contains("m_g_goal: 1.00 × 0.98").count(), 1);
}

#[test]
fn a_filter_that_leaves_nothing_leaves_the_person_where_it_can_be_changed() {
    let mut state = at(Stage::Grasps, GraspPage::Filter);
    let approach = Some(ApproachCone { axis_W: Vector3::z(), half_angle_rad: 0.1 });
    let filter = GraspFilter { approach, ..GraspFilter::default() };
    let settings = GraspSettings { filter, ..GraspSettings::default() };
    let _run = state.apply(Command::Grasping(GraspCommand::Settings(settings)));
    let refusal = Refusal::new("No grasp is left.");
    let _said = state.receive(Update::Refused { revision: state.revision, stage: Stage::Plan, refusal });
    assert_eq!(state.selection.step, Step::Stage(Stage::Grasps));
    assert!(state.can_undo());
    let wrong = GraspSettings { friction: -1.0, ..GraspSettings::default() };
    let effects = state.apply(Command::Grasping(GraspCommand::Settings(wrong)));
    assert!(matches!(effects.as_slice(), [Effect::Announce(text)] if text.contains("grasp.friction")), "{effects:?}");
}

#[test]
fn the_ranked_grasps_are_written_in_every_format_and_only_when_they_are_ranked() {
    let mut harness = panels(Stage::Rank, GraspPage::Table);
    harness.get_by_label("Export the ranked grasps").click();
    harness.run_steps(3);
    harness.get_by_label("YAML, MoveIt messages").click();
    harness.run_steps(2);
    let effects = &harness.state().effects;
    assert!(matches!(effects.as_slice(), [Effect::Export(ExportFormat::Yaml)]), "{effects:?}");

    let bench = Bench::until("jar", Stage::Rank);
    let state = &bench.page.state;
    let studio = crate::studio::BuiltInStudio::default();
    for format in ExportFormat::ALL {
        let text = studio.export(&state.document, &state.outputs, format).expect("it is written");
        let word = if format == ExportFormat::Csv { "accepted" } else { "coffee_jar" };
        assert!(text.contains(word), "{format:?}: {}", &text[..200.min(text.len())]);
    }
    let fresh = invented::fresh();
    assert!(studio.export(&fresh.document, &fresh.outputs, ExportFormat::Csv).is_err());
}

#[test]
fn a_drag_in_the_view_draws_the_region_and_the_box_is_seen() {
    let mut bench = Bench::until("glass", Stage::Rank);
    for command in
        [Command::SelectStep(Step::Stage(Stage::Grasps)), Command::Grasping(GraspCommand::Page(GraspPage::Filter))]
    {
        bench.apply(command);
    }
    let mut harness = window(bench, SIZE, true);
    let _first = picture(&mut harness, "grasps-all");
    let before = harness.state().view.camera();
    harness.get_by_label("Draw a box in the view").click();
    harness.run_steps(2);
    let (from, to) = (Pos2::new(300.0, 120.0), Pos2::new(960.0, 720.0));
    harness.drag_at(from);
    harness.run_steps(1);
    for step in 1..=4 {
        harness.hover_at(from + (to - from) * (0.25 * step as f32));
        harness.run_steps(1);
    }
    let _frame = picture(&mut harness, "grasps-drawing");
    harness.drop_at(to);
    harness.run_steps(3);
    assert_eq!(harness.state().view.camera(), before, "the camera stays where it is");
    let state = &harness.state().bench.page.state;
    let region = state.scene().grasp.filter.region.expect("the drag went over the object");
    let glass = state.outputs.X_WO_start().expect("it is there").translation.vector.into();
    assert!(region.contains(&glass), "{region:?} is not around {glass}");
    assert!(region.half_m.max() < 0.2, "{region:?} is around more than the object");
    assert!(!state.grasping.draws_region);
    harness.state_mut().bench.apply(Command::Grasping(GraspCommand::TakeUpperHalf));
    harness.state_mut().bench.apply(Command::Grasping(GraspCommand::ColorBy(Some(Quantity::Width))));
    let _upper = picture(&mut harness, "grasps-upper-half");
    let id = {
        let grasps = harness.state().bench.page.state.outputs.candidates();
        grasps.iter().find(|grasp| !grasp.is_accepted() && !grasp.contacts.is_empty()).map(|grasp| grasp.id)
    };
    for command in [
        Command::Undo,
        Command::Undo,
        Command::SelectStep(Step::Stage(Stage::Rank)),
        Command::SelectGrasp(id.expect("some are rejected")),
        Command::ToggleLayer(crate::viewer::Layer::Rejected),
        Command::ToggleLayer(crate::viewer::Layer::Robot),
    ] {
        harness.state_mut().bench.apply(command);
    }
    let _rejected = picture(&mut harness, "grasps-rejected");
}
