//! The fit lab on the program's own scenes, from the pipeline to the pixels.

use egui::{Key, Theme};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::fit::{DeformMode, FitSettings, MirrorMode, ObjectiveKind};
use endcomfort_core::job::{SetShape, Stage, Update};
use endcomfort_core::superquadric::Superquadric;

use super::Page;
use super::bench::{Bench, picture, window};
use crate::viewer::state::Step;
use crate::viewer::{Command, Effect, FitView, LabCommand, LabPage};

impl Bench {
    fn radial_m(&self) -> f64 {
        self.page.state.examined_fit().expect("there is a fit").radial_m
    }

    /// The present shape with its first semi-axis longer by a factor.
    fn stretched(&self, factor: f64) -> SetShape {
        self.changed(|shape| shape.a *= factor)
    }

    /// The examined fit's shape with a change.
    fn changed(&self, change: impl FnOnce(&mut Superquadric)) -> SetShape {
        let cluster = self.page.state.examined_cluster().expect("there is a cluster");
        let mut superquadric = self.page.state.examined_fit().expect("there is a fit").superquadric;
        change(&mut superquadric);
        SetShape { cluster, superquadric }
    }
}

#[test]
fn a_shape_set_by_hand_stands_with_its_errors_and_undo_takes_it_back() {
    let mut bench = Bench::new("mustard");
    let (fitted_m, fitted) = (bench.radial_m(), bench.page.state.examined_fit().unwrap().superquadric);
    let shape = bench.stretched(1.4);
    bench.lab(LabCommand::SetShape(shape));
    let state = &bench.page.state;
    assert_eq!(state.document.shape, Some(shape));
    assert_eq!(state.examined_fit().unwrap().superquadric, shape.superquadric);
    assert!(bench.radial_m() > 2.0 * fitted_m, "{} against {fitted_m}", bench.radial_m());
    let volume = state.examined_fit().unwrap().volume_m3 / state.automatic_fit().unwrap().volume_m3;
    assert!((volume - 1.4).abs() < 1e-9, "the volume grows with the semi-axis: {volume}");
    assert_eq!(state.automatic_fit().unwrap().superquadric, fitted, "the fit itself is remembered");
    let request = bench.asked.last().unwrap();
    assert_eq!((request.shape, request.first, request.last), (Some(shape), Stage::Fit, Stage::Plan));

    bench.apply(Command::Undo);
    assert_eq!(bench.radial_m(), fitted_m);
    assert!(bench.page.state.document.shape.is_none() && bench.page.state.automatic_fit().is_none());
    bench.apply(Command::Redo);
    assert_eq!(bench.page.state.examined_fit().unwrap().superquadric, shape.superquadric);
    bench.lab(LabCommand::BackToFit);
    assert_eq!(bench.radial_m(), fitted_m);
}

#[test]
fn a_drag_asks_for_the_fit_alone_and_is_one_step_of_undo() {
    let mut bench = Bench::new("mustard");
    let fitted_m = bench.radial_m();
    let before = bench.asked.len();
    for step in 1..=5 {
        let shape = bench.stretched(1.0 + 0.01 * f64::from(step));
        bench.lab(LabCommand::DragShape(shape));
        assert!(bench.page.state.is_dragging_shape());
    }
    let live = &bench.asked[before..];
    assert!(live.iter().all(|request| (request.first, request.last) == (Stage::Fit, Stage::Fit)), "{live:?}");
    assert!(bench.radial_m() > fitted_m && !bench.page.state.is_stale(Stage::Fit));
    bench.lab(LabCommand::EndDrag);
    let request = bench.asked.last().unwrap();
    assert_eq!((request.first, request.last), (Stage::Fit, Stage::Plan));
    assert!(!bench.page.state.is_dragging_shape());
    bench.apply(Command::Undo);
    assert_eq!(bench.radial_m(), fitted_m);
    assert!(!bench.page.state.can_undo(), "one step for the whole drag");
}

#[test]
fn while_an_answer_is_awaited_a_drag_asks_no_second_time_and_then_for_the_newest_value() {
    let mut bench = Bench::new("mustard");
    let first = bench.stretched(1.1);
    let effects = bench.page.state.apply(Command::Lab(LabCommand::DragShape(first)));
    let [Effect::Run(request)] = effects.as_slice() else { panic!("{effects:?}") };
    let (second, third) = (bench.stretched(1.2), bench.stretched(1.3));
    for shape in [second, third] {
        let effects = bench.page.state.apply(Command::Lab(LabCommand::DragShape(shape)));
        assert!(effects.is_empty(), "{effects:?}");
    }
    let effects = bench.page.state.apply(Command::Lab(LabCommand::EndDrag));
    assert!(effects.is_empty(), "{effects:?}");
    let mut next = Vec::new();
    for update in bench.answers(request) {
        next.extend(bench.page.state.receive(update));
    }
    // The answer to a value that has moved on is shown all the same.
    assert_eq!(bench.page.state.examined_fit().unwrap().superquadric, first.superquadric);
    let [Effect::Run(request)] = next.as_slice() else { panic!("{next:?}") };
    assert_eq!((request.shape, request.last), (Some(third), Stage::Plan));
    bench.carry_out(next);
    assert_eq!(bench.page.state.examined_fit().unwrap().superquadric, third.superquadric);
    assert!(!bench.page.state.running && !bench.page.state.is_stale(Stage::Fit));
}

#[test]
fn values_out_of_range_are_refused_with_their_reason() {
    let mut bench = Bench::new("mustard");
    let fitted_m = bench.radial_m();
    for (change, word) in [
        (bench.changed(|shape| shape.e1 = 2.7), "e1"),
        (bench.stretched(-1.0), "semi-axis a"),
        (bench.changed(|shape| shape.taper = 1.2), "taper"),
        (bench.changed(|shape| shape.bend_per_m = 900.0), "bend"),
        (bench.stretched(f64::NAN), "semi-axis a"),
    ] {
        bench.lab(LabCommand::SetShape(change));
        let reason = bench.page.state.lab.refused.clone().unwrap_or_default();
        assert!(reason.contains(word), "{reason:?} does not speak of {word}");
        assert!(bench.page.state.document.shape.is_none() && !bench.page.state.can_undo());
    }
    assert_eq!(bench.radial_m(), fitted_m);
}

#[test]
fn other_settings_ask_from_the_fit_on_and_undo_brings_them_back() {
    let mut bench = Bench::new("mustard");
    let shape = bench.stretched(1.1);
    bench.lab(LabCommand::SetShape(shape));
    let settings = FitSettings {
        objective: ObjectiveKind::Solina,
        voxel_m: 0.01,
        deform: DeformMode::Auto,
        hierarchical: true,
        reject_outliers: false,
        max_parts: 2,
        ..FitSettings::default()
    };
    bench.lab(LabCommand::Settings(settings.clone()));
    let request = bench.asked.last().unwrap();
    assert_eq!((&request.scene.fit, request.shape, request.first), (&settings, None, Stage::Fit));
    bench.apply(Command::Undo);
    assert_eq!(bench.page.state.scene().fit, FitSettings::default());
    assert_eq!(bench.page.state.document.shape, Some(shape), "the shape comes back with them");
}

#[test]
fn objectives_are_compared_on_the_examined_cluster_and_one_is_adopted() {
    let mut bench = Bench::new("mustard");
    bench.lab(LabCommand::Compare);
    let asked = bench.asked.last().unwrap();
    assert_eq!(asked.compare, bench.page.state.examined_cluster());
    let state = &bench.page.state;
    let rows = &state.comparison().expect("it belongs to this cluster").rows;
    let objectives: Vec<ObjectiveKind> = rows.iter().map(|(_, row)| row.objective).collect();
    assert_eq!(objectives, ObjectiveKind::ALL);
    assert!(!state.running && !state.is_stale(Stage::Fit));
    let fit = rows[0].1.fit.as_ref().unwrap();
    assert_eq!(fit.radial_m, bench.radial_m(), "the first is the one that stands");

    let settings = FitSettings { objective: ObjectiveKind::Chevalier, ..state.scene().fit.clone() };
    bench.lab(LabCommand::Settings(settings));
    assert_eq!(bench.page.state.scene().fit.objective, ObjectiveKind::Chevalier);
    assert!(bench.page.state.comparison().is_some(), "which one is taken does not matter to it");
    bench.lab(LabCommand::Settings(FitSettings { voxel_m: 0.02, ..FitSettings::default() }));
    assert!(bench.page.state.comparison().is_none(), "with other voxels the numbers would be others");
    bench.apply(Command::Undo);
    bench.apply(Command::Undo);
    assert_eq!(bench.page.state.scene().fit.objective, ObjectiveKind::Radial);
    assert!(bench.page.state.comparison().is_some());
}

#[test]
fn a_comparison_can_be_stopped() {
    let mut bench = Bench::new("mustard");
    let effects = bench.page.state.apply(Command::Lab(LabCommand::Compare));
    assert!(matches!(effects.as_slice(), [Effect::Run(_)]) && bench.page.state.is_comparing());
    let effects = bench.page.state.apply(Command::Cancel);
    assert!(matches!(effects.as_slice(), [Effect::Cancel]));
    assert!(!bench.page.state.is_comparing() && !bench.page.state.running);
}

#[test]
fn the_lab_draws_the_fit_in_three_ways_with_a_legend() {
    for (demo, size, dark) in
        [("mustard", [1440.0, 900.0], true), ("glass", [1280.0, 720.0], false), ("jar", [390.0, 844.0], true)]
    {
        let mut harness = window(Bench::new(demo), size, dark);
        let mut pictures = Vec::new();
        for view in FitView::ALL {
            harness.state_mut().bench.lab(LabCommand::View(view));
            pictures.push(picture(&mut harness, &format!("lab-{demo}-{}", view.title().to_lowercase())));
            assert_eq!(harness.query_all_by_label_contains("input points").count(), 1, "the legend of {demo}");
        }
        assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    }
}

#[test]
fn v_goes_through_the_ways_and_a_typed_number_sets_the_shape() {
    let mut harness = window(Bench::new("mustard"), [1280.0, 720.0], true);
    harness.run_steps(2);
    harness.key_press(Key::V);
    harness.run_steps(1);
    assert_eq!(harness.state().bench.page.state.lab.view, FitView::Wire);
    harness.get_by_label("Shape page").click();
    harness.run_steps(2);
    assert_eq!(harness.state().bench.page.state.lab.page, LabPage::Shape);
    let fitted_m = harness.state().bench.radial_m();
    harness.get_by_label("Semi-axis a, mm").click();
    harness.run_steps(2);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    harness.get_by_role(egui::Role::TextInput).type_text("61.5");
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let shape = harness.state().bench.page.state.document.shape.expect("it was set");
    assert!((shape.superquadric.a - 0.0615).abs() < 1e-12, "{shape:?}");
    assert_ne!(harness.state().bench.radial_m(), fitted_m);
    let _picture = picture(&mut harness, "lab-by-hand");
    harness.get_by_label("Back to the fit").click();
    harness.run_steps(3);
    assert_eq!(harness.state().bench.radial_m(), fitted_m);
}

#[test]
fn dragging_a_number_moves_the_error_and_hovering_an_objective_draws_it() {
    // A window so low that the page scrolls: the drag must be the number's, not the page's.
    let mut harness = window(Bench::new("mustard"), [1280.0, 657.0], true);
    harness.state_mut().bench.lab(LabCommand::Page(LabPage::Shape));
    harness.run_steps(3);
    let fitted_m = harness.state().bench.radial_m();
    let at = harness.get_by_label("Semi-axis b, mm").rect().center();
    // Long enough for the tooltip to come; it goes again with the press.
    harness.hover_at(at);
    harness.run_steps(8);
    assert!(harness.query_by_label_contains("Half of the extent").is_some(), "the tooltip");
    harness.drag_at(at);
    harness.run_steps(1);
    for step in 1..=8 {
        harness.hover_at(at + egui::vec2(20.0 * step as f32, 0.0));
        harness.run_steps(1);
    }
    assert!(harness.state().bench.page.state.is_dragging_shape());
    let live_m = harness.state().bench.radial_m();
    assert_ne!(live_m, fitted_m, "the error follows the drag");
    harness.drop_at(at + egui::vec2(160.0, 0.0));
    harness.run_steps(3);
    assert!(!harness.state().bench.page.state.is_dragging_shape());
    harness.state_mut().bench.apply(Command::Undo);
    assert_eq!(harness.state().bench.radial_m(), fitted_m);

    harness.state_mut().bench.lab(LabCommand::Page(LabPage::Search));
    harness.run_steps(3);
    harness.get_by_label("Compare objectives").click();
    harness.run_steps(3);
    let row = harness.get_by_label_contains("Objective Solina").rect();
    harness.hover_at(row.center());
    harness.run_steps(3);
    assert_eq!(harness.state().bench.page.state.lab.hovered, Some(ObjectiveKind::Solina));
    let _picture = picture(&mut harness, "lab-compare");
    harness.get_by_label_contains("Objective Solina").click();
    harness.run_steps(3);
    assert_eq!(harness.state().bench.page.state.scene().fit.objective, ObjectiveKind::Solina);
}

/// The panels alone, on invented results that hold everything at once.
fn panels(page: LabPage) -> Harness<'static, Page> {
    let mut state = super::invented::planned();
    for command in [Command::SelectStep(Step::Stage(Stage::Fit)), Command::Lab(LabCommand::Page(page))] {
        let _none = state.apply(command);
    }
    let mut harness = super::page(state, [1440.0, 1500.0], Theme::Dark);
    harness.run_steps(2);
    harness
}

#[test]
fn the_result_page_tells_every_metric_and_points_the_view_at_rejected_points() {
    let mut harness = panels(LabPage::Result);
    for words in [
        "E_r, mean radial distance: 0.820 mm",
        "E_g (3.9), mean (f^e1 – 1)²: 0.0143",
        "E_g of the tables, mean |f – 1|: 0.0871",
        "Volume: 410 ml",
        "Histogram: 95 % within",
        "14 points left out of the fit: farther than 8.30 mm",
        "Farthest: 21.0 mm outside",
    ] {
        assert_eq!(harness.query_all_by_label_contains(words).count(), 1, "{words}");
    }
    harness.get_by_label("Show them in the view").click();
    harness.run_steps(2);
    assert!(harness.state().state.lab_key().is_some_and(|lab| lab.points_out_rejected));
    harness.get_by_label("Back to the whole cluster").click();
    harness.run_steps(2);
    assert!(harness.state().state.lab_key().is_some_and(|lab| !lab.points_out_rejected));
}

#[test]
fn the_search_page_tells_models_and_runs() {
    let harness = panels(LabPage::Search);
    for words in ["taper", "BIC least", "Cost of 9 runs over their steps", "(taken)", "Compare objectives"] {
        assert!(harness.query_all_by_label_contains(words).count() >= 1, "{words}");
    }
}

#[test]
fn every_setting_is_a_control_and_one_step_of_undo() {
    let mut harness = panels(LabPage::Settings);
    for (control, holds) in [
        ("Chevalier", (|s| s.objective == ObjectiveKind::Chevalier) as fn(&FitSettings) -> bool),
        ("Coarse to fine", |s| s.hierarchical),
        ("Leave out points that nothing explains", |s| !s.reject_outliers),
        ("Never", |s| s.mirror == MirrorMode::Off),
        ("Auto", |s| s.deform == DeformMode::Auto),
        ("3", |s| s.max_parts == 3),
    ] {
        harness
            .get_by_role_and_label(
                if control.contains(' ') { egui::Role::Switch } else { egui::Role::RadioButton },
                control,
            )
            .click();
        harness.run_steps(2);
        assert!(holds(&harness.state().state.scene().fit), "{control}");
        let asked = harness.state().effects.iter().rev().find_map(|effect| match effect {
            Effect::Run(request) => Some((request.first, holds(&request.scene.fit))),
            _ => None,
        });
        assert_eq!(asked, Some((Stage::Fit, true)), "{control}");
    }
    for _ in 0..6 {
        harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::Z);
        harness.run_steps(1);
    }
    assert_eq!(harness.state().state.scene().fit, FitSettings::default());
}

#[test]
fn a_plan_that_the_new_shape_does_not_allow_leaves_the_person_in_the_lab() {
    let mut bench = Bench::new("mustard");
    let shape = bench.stretched(1.2);
    let _run = bench.page.state.apply(Command::Lab(LabCommand::SetShape(shape)));
    let refusal = endcomfort_core::job::Refusal::new("no path");
    let revision = bench.page.state.revision;
    let _announced = bench.page.state.receive(Update::Refused { revision, stage: Stage::Plan, refusal });
    assert_eq!(bench.page.state.selection.step, Step::Stage(Stage::Fit));
}
