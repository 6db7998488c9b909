//! The task as a person edits it: step by step in the panel, and by its goals in the view.

use egui::{Key, Pos2, Theme};
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::{Request, Stage, Update};
use endcomfort_core::scene::Action;
use nalgebra::{Isometry3, Vector3};

use super::bench::{Bench, picture, window};
use super::{Page, invented, page};
use crate::viewer::state::Step;
use crate::viewer::{Command, Effect, PlanCommand, PlanPage, Posture, ViewerState};

const SIZE: [f32; 2] = [1440.0, 900.0];

fn task_page() -> egui_kittest::Harness<'static, Page> {
    let mut state = invented::planned();
    let open = [Command::SelectStep(Step::Stage(Stage::Plan)), Command::Planning(PlanCommand::Page(PlanPage::Task))];
    for command in open {
        let _none = state.apply(command);
    }
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(2);
    harness
}

fn click(harness: &mut egui_kittest::Harness<'_, Page>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(2);
}

fn requests(effects: &[Effect]) -> Vec<&Request> {
    let asked = effects.iter().filter_map(|effect| match effect {
        Effect::Run(request) => Some(&**request),
        _ => None,
    });
    asked.collect()
}

fn goal(state: &ViewerState, step: usize) -> Isometry3<f64> {
    state.scene().task.steps[step].X_WO_goal
}

#[test]
fn steps_are_added_turned_into_others_moved_and_removed_and_each_edit_is_undone_alone() {
    let mut harness = task_page();
    let steps = |harness: &egui_kittest::Harness<'_, Page>| harness.state().state.scene().task.steps.clone();
    let first = steps(&harness);
    click(&mut harness, "Add a step");
    assert_eq!((steps(&harness).len(), harness.state().state.planning.step), (2, 1));
    assert_eq!(requests(&harness.state().effects).last().unwrap().first, Stage::Grasps);
    click(&mut harness, "Pour");
    assert!(matches!(steps(&harness)[1].action, Action::Pour { hold_s } if hold_s == 2.0));
    assert_eq!(harness.query_all_by_role_and_label(egui::Role::SpinButton, "Held for, s").count(), 1);
    harness.get_by_role_and_label(egui::Role::Switch, "Keep it upright").click();
    harness.run_steps(2);
    assert!(steps(&harness)[1].keep_upright_rad.is_some());
    click(&mut harness, "Earlier: step 2");
    assert!(matches!(steps(&harness)[0].action, Action::Pour { .. }));
    assert_eq!(harness.state().state.planning.step, 0, "the selection goes with it");
    click(&mut harness, "Later: step 1");
    click(&mut harness, "Slide");
    assert_eq!(steps(&harness)[1].action, Action::Slide);
    click(&mut harness, "Remove: step 2");
    assert_eq!(steps(&harness), first);
    for _ in 0..7 {
        let _run = harness.state_mut().state.apply(Command::Undo);
    }
    assert_eq!(steps(&harness), first);
    assert!(!harness.state().state.can_undo(), "seven edits, seven steps of undo");
}

#[test]
fn every_number_of_a_goal_and_its_freedom_can_be_typed() {
    let mut harness = task_page();
    let typed = |harness: &mut egui_kittest::Harness<'_, Page>, name: &str, text: &str| {
        harness.get_by_role_and_label(egui::Role::SpinButton, name).focus();
        harness.run_steps(2);
        harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
        harness.event(egui::Event::Text(text.to_owned()));
        harness.run_steps(1);
        harness.key_press(Key::Enter);
        harness.run_steps(3);
    };
    for (name, text) in [
        ("Goal x, mm", "500"),
        ("Goal y, mm", "-120"),
        ("Goal z, mm", "900"),
        ("Goal yaw, °", "90"),
        ("Goal roll, °", "20"),
        ("Free yaw, °", "180"),
        ("Free area x, mm", "40"),
        ("Free area y, mm", "60"),
        ("Free tilt, °", "10"),
    ] {
        typed(&mut harness, name, text);
    }
    let step = harness.state().state.scene().task.steps[0].clone();
    assert!((step.X_WO_goal.translation.vector - Vector3::new(0.5, -0.12, 0.9)).norm() < 1e-9, "{step:?}");
    let (roll, pitch, yaw) = step.X_WO_goal.rotation.euler_angles();
    let wanted = [20.0_f64, 0.0, 90.0].map(f64::to_radians);
    for (found, wanted) in [roll, pitch, yaw].into_iter().zip(wanted) {
        assert!((found - wanted).abs() < 1e-9, "{step:?}");
    }
    assert_eq!(step.freedom.yaw_rad, std::f64::consts::PI);
    assert!((step.freedom.area_m[0] - 0.04).abs() < 1e-9 && (step.freedom.area_m[1] - 0.06).abs() < 1e-9);
    assert!((step.freedom.cone_rad - 10.0_f64.to_radians()).abs() < 1e-9);
    assert!(!harness.state().state.is_dragging_goal());
}

#[test]
fn a_dragged_goal_asks_again_only_when_it_was_answered_and_is_one_step_of_undo() {
    let mut state = invented::planned();
    let before = goal(&state, 0);
    let to = |k: f64| Isometry3::translation(0.02 * k, 0.0, 0.0) * before;
    let drag = |state: &mut ViewerState, k: f64| {
        state.apply(Command::Planning(PlanCommand::DragGoal { step: 0, X_WO_goal: to(k) }))
    };
    let asked = drag(&mut state, 1.0);
    let revision = requests(&asked)[0].revision;
    assert!(state.is_dragging_goal() && state.is_stale(Stage::Plan));
    for k in [2.0, 3.0, 4.0] {
        assert!(drag(&mut state, k).is_empty(), "the first request is still under way");
    }
    // The plan for where the goal was a moment ago is shown, but as out of date.
    let plan = invented::outputs().pop().unwrap().1;
    let again = state.receive(Update::Done { revision, elapsed_ms: 5.0, output: Box::new(plan) });
    let again = requests(&again);
    assert_eq!(again.len(), 1);
    assert_eq!(again[0].scene.task.steps[0].X_WO_goal, to(4.0));
    assert_eq!(state.outputs.plan.as_ref().unwrap().revision, revision);
    assert!(state.is_stale(Stage::Plan));
    let revision = again[0].revision;
    let end = state.apply(Command::Planning(PlanCommand::EndDrag));
    assert!(end.is_empty(), "the plan for this place is on its way");
    let none = state.receive(Update::Finished { revision });
    assert!(none.is_empty() && !state.is_dragging_goal());
    assert_eq!(goal(&state, 0), to(4.0));
    let _run = state.apply(Command::Undo);
    assert_eq!(goal(&state, 0), before);
    assert!(!state.can_undo());
}

#[test]
fn letting_go_asks_at_once_and_esc_puts_the_goal_back() {
    let mut state = invented::planned();
    let before = goal(&state, 0);
    let to = |k: f64| Isometry3::translation(0.02 * k, 0.0, 0.0) * before;
    for k in [1.0, 2.0] {
        let _effects = state.apply(Command::Planning(PlanCommand::DragGoal { step: 0, X_WO_goal: to(k) }));
    }
    let end = state.apply(Command::Planning(PlanCommand::EndDrag));
    assert_eq!(requests(&end)[0].scene.task.steps[0].X_WO_goal, to(2.0), "the answer is not waited for");
    let _effects = state.apply(Command::Planning(PlanCommand::DragGoal { step: 0, X_WO_goal: to(3.0) }));
    let back = state.apply(Command::Escape);
    assert_eq!(requests(&back)[0].scene.task.steps[0].X_WO_goal, to(2.0));
    assert!(!state.is_dragging_goal());
    assert_eq!(goal(&state, 0), to(2.0));
    let _run = state.apply(Command::Undo);
    assert_eq!(goal(&state, 0), before);
}

#[test]
fn a_goal_that_nobody_can_reach_keeps_the_task_open_and_the_way_back() {
    let mut state = invented::planned();
    let _none = state.apply(Command::SelectStep(Step::Stage(Stage::Plan)));
    let far = Isometry3::translation(2.0, 0.0, 0.8);
    let _run = state.apply(Command::Planning(PlanCommand::DragGoal { step: 0, X_WO_goal: far }));
    let refusal = endcomfort_core::job::Refusal::new("Out of reach.");
    let announced = state.receive(Update::Refused { revision: state.revision, stage: Stage::Rank, refusal });
    assert!(announced.is_empty(), "nobody wants to hear of every place on the way");
    assert_eq!(state.selection.step, Step::Stage(Stage::Plan));
    assert!(state.plan_pages().contains(&PlanPage::Task) && state.goal_step() == Some(0));
}

/// From the pixels of the gizmo to a new plan.
#[test]
fn the_goal_follows_the_pointer_in_the_view_and_the_plan_follows_the_goal() {
    let mut bench = Bench::until("jar", Stage::Plan);
    bench.apply(Command::SelectStep(Step::Stage(Stage::Plan)));
    bench.apply(Command::Planning(PlanCommand::Page(PlanPage::Task)));
    let mut harness = window(bench, [1280.0, 720.0], true);
    let _before = picture(&mut harness, "task-gizmo");
    let state = |harness: &egui_kittest::Harness<'_, super::bench::Window>| {
        let state = &harness.state().bench.page.state;
        (goal(state, 0), state.revision, state.outputs.plan.is_some())
    };
    let camera = harness.state().view.camera();
    let (before, first, _) = state(&harness);
    let drag = |harness: &mut egui_kittest::Harness<'_, super::bench::Window>, name: &str, by: [f32; 2], esc: bool| {
        let from = harness.get_by_label(name).rect().center();
        harness.hover_at(from);
        harness.run_steps(2);
        harness.drag_at(from);
        harness.run_steps(2);
        let to = from + egui::vec2(by[0], by[1]);
        harness.hover_at(to);
        harness.run_steps(2);
        if esc {
            harness.key_press(Key::Escape);
            harness.run_steps(2);
        }
        harness.drop_at(to);
        harness.run_steps(3);
        let _moved: Pos2 = to;
    };
    drag(&mut harness, "Move the goal of step 1", [0.0, 24.0], false);
    let (moved, second, _) = state(&harness);
    let shift = moved.translation.vector - before.translation.vector;
    assert!(second > first && shift.xy().norm() > 0.01 && shift.z == 0.0, "{shift:?}");
    drag(&mut harness, "Lift the goal of step 1", [0.0, -30.0], false);
    let (lifted, _, _) = state(&harness);
    let shift = lifted.translation.vector - moved.translation.vector;
    assert!(shift.z > 0.01 && shift.xy().norm() < 1e-9, "{shift:?}");
    drag(&mut harness, "Turn the goal of step 1", [40.0, -20.0], false);
    let (turned, last, _) = state(&harness);
    assert!(turned.rotation.angle_to(&lifted.rotation) > 0.05 && turned.translation == lifted.translation);
    drag(&mut harness, "Move the goal of step 1", [0.0, 30.0], true);
    let (back, _, _) = state(&harness);
    assert_eq!(back, turned, "Esc puts it back");
    assert!(last > second);
    assert_eq!(harness.state().view.camera(), camera, "the camera stands still");
    let _after = picture(&mut harness, "task-moved");
    for _ in 0..3 {
        harness.state_mut().bench.apply(Command::Undo);
    }
    let state = &harness.state().bench.page.state;
    assert_eq!(goal(state, 0), before);
    assert!(state.outputs.plan.as_ref().is_some_and(|plan| plan.revision == state.revision));
    assert!(matches!(state.posture(), Posture::Plan { .. }));
}

#[test]
fn the_scene_leads_to_its_task() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(2);
    click(&mut harness, "Edit the task");
    let state = &harness.state().state;
    assert_eq!((state.selection.step, state.plan_page()), (Step::Stage(Stage::Plan), PlanPage::Task));
}

#[test]
fn undo_in_the_middle_of_a_drag_ends_it() {
    let mut state = invented::planned();
    let before = goal(&state, 0);
    let to = Isometry3::translation(0.02, 0.0, 0.0) * before;
    let _run = state.apply(Command::Planning(PlanCommand::DragGoal { step: 0, X_WO_goal: to }));
    let _run = state.apply(Command::Undo);
    assert!(!state.is_dragging_goal() && goal(&state, 0) == before);
    let end = state.apply(Command::Planning(PlanCommand::EndDrag));
    assert!(end.is_empty() && goal(&state, 0) == before);
}
