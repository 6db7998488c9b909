//! Plans as a person examines them: in the view, on the timeline, as plots and lists.

use egui::{Key, Theme};
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::{Refusal, Stage, Update};
use endcomfort_core::task::Planner;

use super::bench::{Bench, picture, window};
use super::{Page, invented, page};
use crate::export::MotionFormat;
use crate::render::Frame;
use crate::studio::BuiltInStudio;
use crate::viewer::state::Step;
use crate::viewer::{
    Command, Curve, Effect, Layer, Measures, PlanCommand, PlanPage, PlayPage, Posture, Studio as _, ViewerState,
};

const SIZE: [f32; 2] = [1440.0, 900.0];

fn panels(state: ViewerState) -> egui_kittest::Harness<'static, Page> {
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(2);
    harness
}

fn with(commands: impl IntoIterator<Item = Command>) -> ViewerState {
    let mut state = invented::planned();
    for command in commands {
        let _effects = state.apply(command);
    }
    state
}

fn frame(bench: &Bench, studio: &mut BuiltInStudio) -> Frame {
    studio.compose(&bench.page.state.compose_input(true)).frame
}

#[test]
fn a_comma_and_a_point_step_through_the_samples() {
    let mut harness = panels(with([Command::Seek(4.62)]));
    let time = |harness: &egui_kittest::Harness<'_, Page>| harness.state().state.playback.time_s;
    // Transport begins at 4.6 s and has 60 samples over 3.9 s.
    for (key, wanted) in [(Key::Period, 4.6 + 3.9 / 60.0), (Key::Comma, 4.6), (Key::Comma, 4.6 - 0.5 / 60.0)] {
        harness.key_press(key);
        harness.run_steps(1);
        assert!((time(&harness) - wanted).abs() < 1e-6, "{key:?}: {} instead of {wanted}", time(&harness));
    }
    harness.get_by_label("One sample forth (.)").click();
    harness.run_steps(2);
    assert!((time(&harness) - 4.6).abs() < 1e-6);
    harness.get_by_label("One sample back (,)").click();
    harness.run_steps(2);
    assert!((time(&harness) - (4.6 - 0.5 / 60.0)).abs() < 1e-6);
}

#[test]
fn every_joint_has_its_plot_under_its_name_and_a_press_moves_through_time() {
    let open = [Command::SelectStep(Step::Play), Command::Planning(PlanCommand::PlayPage(PlayPage::Joints))];
    let mut harness = panels(with(open));
    assert_eq!(harness.query_all_by_label_contains("Position of right_joint").count(), 7);
    harness.get_by_label("Velocity").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.planning.curve, Curve::Velocity);
    let plots: Vec<_> = harness.query_all_by_label_contains("Velocity of right_joint").collect();
    let middle = plots[3].rect().center();
    drop(plots);
    harness.drag_at(middle);
    harness.run_steps(1);
    harness.drop_at(middle);
    harness.run_steps(2);
    let state = &harness.state().state;
    assert!((state.playback.time_s - 0.5 * state.duration_s()).abs() < 0.05, "{}", state.playback.time_s);
    harness.get_by_label("Joint: All joints").click();
    harness.run_steps(3);
    harness.get_by_role_and_label(egui::Role::MenuItem, "right_joint_4").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state.planning.joint, Some(3));
    for curve in Curve::ALL {
        let name = format!("{} of right_joint_4", curve.title());
        assert_eq!(harness.query_all_by_label_contains(&name).count(), 1, "{name}");
    }
}

#[test]
fn ghosts_and_the_swept_volume_are_drawn_where_the_plan_goes_and_grey_while_it_is_stale() {
    let mut bench = Bench::until("jar", Stage::Plan);
    let mut studio = BuiltInStudio::default();
    let plain = frame(&bench, &mut studio);
    bench.apply(Command::ToggleLayer(Layer::Ghosts));
    bench.apply(Command::Planning(PlanCommand::Ghosts(6)));
    let ghosts = frame(&bench, &mut studio);
    let opacities = |frame: &Frame, from: usize| {
        let mut found: Vec<u32> = frame.meshes[from..].iter().map(|draw| draw.color[3].to_bits()).collect();
        found.dedup();
        found.len()
    };
    assert_eq!(opacities(&ghosts, plain.meshes.len()), 6, "each ghost has a colour of its own");
    bench.apply(Command::ToggleLayer(Layer::Swept));
    let swept = frame(&bench, &mut studio);
    assert_eq!(swept.meshes.len(), ghosts.meshes.len() + 1);
    let skin = &swept.meshes.last().unwrap().mesh;
    // The hand's way lies inside, so the skin surrounds it.
    for line in &swept.lines {
        for p in &line.points {
            let above = skin.positions.iter().any(|q| q.z > p.z && (q.xy() - p.xy()).norm() < 0.03);
            assert!(above, "the hand comes by {p}, above which there is no skin");
        }
    }
    let again = frame(&bench, &mut studio);
    assert!(std::sync::Arc::ptr_eq(skin, &again.meshes.last().unwrap().mesh), "it is made once per plan");

    // A new request has not been answered yet.
    let _effects = bench.page.state.apply(Command::SetSeed(99));
    let stale = frame(&bench, &mut studio);
    let is_grey = |color: [f32; 4]| color[..3].iter().all(|c| (c - color[1]).abs() < 0.12);
    assert!(stale.lines.iter().take(4).all(|line| is_grey(line.color)));
    assert!(stale.meshes[plain.meshes.len()..].iter().all(|draw| is_grey(draw.color)));
}

#[test]
fn plans_in_the_window() {
    let mut bench = Bench::until("jar", Stage::Plan);
    bench.apply(Command::SelectStep(Step::Stage(Stage::Plan)));
    bench.apply(Command::Seek(1.5));
    let mut harness = window(bench, [1280.0, 720.0], true);
    let plain = picture(&mut harness, "plans-path");
    for (layer, name) in [(Layer::Ghosts, "plans-ghosts"), (Layer::Swept, "plans-swept")] {
        harness.state_mut().bench.apply(Command::ToggleLayer(layer));
        let shown = picture(&mut harness, name);
        let changed = shown.pixels().zip(plain.pixels()).filter(|(a, b)| a != b).count();
        assert!(changed > 8_000, "{name}: {changed} pixels");
        harness.state_mut().bench.apply(Command::ToggleLayer(layer));
    }
    harness.state_mut().bench.apply(Command::ToggleLayer(Layer::Ghosts));
    let _effects = harness.state_mut().bench.page.state.apply(Command::SetSeed(99));
    let _stale = picture(&mut harness, "plans-stale");
    assert!(matches!(harness.state().bench.page.state.posture(), Posture::Plan { .. }));
}

#[test]
fn the_ways_of_a_plan_are_those_of_a_finer_walk() {
    let robot = crate::assets::library().robot("crichton").unwrap();
    let state = invented::planned();
    let plan = state.outputs.plan.as_deref().unwrap();
    let measures = Measures::of(plan, &robot, 7);
    let steps = 20_000;
    let (mut arm_rad, mut hand_m, mut last) = (0.0, 0.0, None);
    for k in 0..=steps {
        let q = plan.state_at(plan.duration_s() * f64::from(k) / f64::from(steps)).q;
        let p_W = robot.link_poses(&q)[plan.legs[0].tcp_link].translation.vector;
        let arm = nalgebra::DVector::from_iterator(7, plan.dofs[..7].iter().map(|&dof| q[dof]));
        if let Some((before, from)) = last.replace((arm.clone(), p_W)) {
            arm_rad += (arm - before).norm();
            hand_m += (p_W - from).norm();
        }
    }
    // Chords of a fiftieth of a second are shorter than the way by far less than a hundredth.
    assert!((measures.arm_rad / arm_rad - 1.0).abs() < 0.01, "{} {arm_rad}", measures.arm_rad);
    assert!((measures.hand_m / hand_m - 1.0).abs() < 0.01, "{} {hand_m}", measures.hand_m);
    assert_eq!((measures.phases, measures.tries), (plan.phases.len(), plan.tries.len()));
}

fn plan_page(page: PlanPage) -> egui_kittest::Harness<'static, Page> {
    panels(with([Command::SelectStep(Step::Stage(Stage::Plan)), Command::Planning(PlanCommand::Page(page))]))
}

fn asked(harness: &egui_kittest::Harness<'_, Page>) -> Option<Stage> {
    harness.state().effects.iter().rev().find_map(|effect| match effect {
        Effect::Run(request) => Some(request.first),
        _ => None,
    })
}

#[test]
fn a_row_of_the_tries_shows_the_robot_where_it_failed_while_it_is_pointed_at_or_selected() {
    let mut harness = plan_page(PlanPage::Plan);
    harness.get_by_label("Tried page").click();
    harness.run_steps(2);
    let label = "Try 2:";
    let middle = harness.get_by_label_contains(label).rect().center();
    harness.hover_at(middle);
    harness.run_steps(2);
    assert_eq!(harness.state().state.posture(), Posture::Try { index: 1 });
    harness.remove_cursor();
    harness.run_steps(2);
    assert!(matches!(harness.state().state.posture(), Posture::Plan { .. }));
    harness.get_by_label_contains(label).click();
    harness.run_steps(2);
    harness.remove_cursor();
    harness.run_steps(2);
    assert_eq!(harness.state().state.posture(), Posture::Try { index: 1 });
    harness.key_press(Key::Space);
    harness.run_steps(1);
    harness.key_press(Key::Space);
    harness.run_steps(1);
    assert!(matches!(harness.state().state.posture(), Posture::Plan { .. }), "whoever plays wants the plan");
    harness.get_by_label_contains(label).click();
    harness.run_steps(2);
    harness.remove_cursor();
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(matches!(harness.state().state.posture(), Posture::Plan { .. }), "Esc leaves it");
}

#[test]
fn the_culprits_of_a_try_are_coral_and_named_in_the_view() {
    let mut bench = Bench::until("jar", Stage::Rank);
    let mut studio = BuiltInStudio::default();
    let revision = bench.page.state.revision;
    let neighbour = bench.page.state.scene().objects.iter().map(|placed| placed.object.replace('_', " ")).next_back();
    let obstacle = bench.page.state.scene().obstacles[0].name.clone();
    let mut tries = invented::tries(&[0.2; 7]);
    tries[0].culprits = vec!["right_palm_link".to_owned(), obstacle.clone(), neighbour.unwrap()];
    let robot = crate::assets::library().robot("crichton").unwrap();
    tries[0].culprits[0] = robot.links[robot.arm("right").unwrap().hand.palm_link].name.clone();
    let refusal = Refusal { tries, ..Refusal::new("No way.") };
    let _announced = bench.page.state.receive(Update::Refused { revision, stage: Stage::Plan, refusal });
    let coral = |bench: &Bench, studio: &mut BuiltInStudio| {
        let picture = studio.compose(&bench.page.state.compose_input(true));
        let is_coral = |c: [f32; 4]| c[..3] == [238.0 / 255.0, 106.0 / 255.0, 92.0 / 255.0];
        let bodies = picture.frame.meshes.iter().filter(|draw| is_coral(draw.color)).count();
        let named = picture.labels.iter().filter(|label| label.tone == crate::viewer::Tone::Rejected).count();
        (bodies, named)
    };
    assert_eq!(coral(&bench, &mut studio), (0, 0));
    bench.apply(Command::Planning(PlanCommand::HoverTry(Some(0))));
    let (bodies, named) = coral(&bench, &mut studio);
    assert!(bodies >= 3, "palm, box and neighbour: {bodies} bodies");
    assert_eq!(named, 3);
    assert_eq!(bench.page.state.posture(), Posture::Try { index: 0 });
}

#[test]
fn a_refused_plan_lists_its_tries_and_its_settings() {
    let mut state = with([Command::SelectStep(Step::Stage(Stage::Plan))]);
    let refusal = Refusal { tries: invented::tries(&[]), ..Refusal::new("No way to the goal.") };
    let _announced = state.receive(Update::Refused { revision: state.revision, stage: Stage::Plan, refusal });
    let mut harness = panels(state);
    assert_eq!(harness.query_all_by_label_contains("Try ").count(), 3);
    assert_eq!(
        harness
            .query_all_by_label("3 tries with 3 grasps failed: 2 in transport, 1 in retreat. Point at one to see it.")
            .count(),
        1
    );
    harness.get_by_label("Settings page").click();
    harness.run_steps(2);
    harness.get_by_label("Roadmap").click();
    harness.run_steps(2);
    assert_eq!(asked(&harness), Some(Stage::Plan));
    assert_eq!(harness.state().state.scene().motion.planner, Planner::Roadmap);
}

#[test]
fn settings_of_the_motion_ask_for_the_plan_alone_and_undo_takes_them_back() {
    let mut harness = plan_page(PlanPage::Settings);
    for (label, says) in [("Roadmap", Planner::Roadmap), ("Routes", Planner::Routes), ("Search", Planner::Search)] {
        harness.get_by_role_and_label(egui::Role::RadioButton, label).click();
        harness.run_steps(2);
        assert_eq!(harness.state().state.scene().motion.planner, says);
        assert_eq!(asked(&harness), Some(Stage::Plan));
    }
    for name in [
        "Clearance, mm",
        "Speed, %",
        "Acceleration, %",
        "Jerk, %",
        "Approach, mm",
        "Shortest approach, mm",
        "Lift, mm",
        "Grasps tried",
        "Seed",
    ] {
        assert_eq!(harness.query_all_by_role_and_label(egui::Role::SpinButton, name).count(), 1, "{name}");
    }
    harness.get_by_role_and_label(egui::Role::Switch, "Put it down and grasp it anew if need be").click();
    harness.run_steps(2);
    assert!(!harness.state().state.scene().motion.regrasp);
    harness.get_by_label("Usual motion").click();
    harness.run_steps(2);
    assert!(harness.state().state.scene().motion.regrasp);
    let _run = harness.state_mut().state.apply(Command::Undo);
    assert!(!harness.state().state.scene().motion.regrasp);
}

#[test]
fn a_route_is_pointed_at_in_the_view_and_taken_by_a_click() {
    let mut harness = plan_page(PlanPage::Routes);
    let middle = harness.get_by_label_contains("Route 2:").rect().center();
    harness.hover_at(middle);
    harness.run_steps(2);
    let before = harness.state().state.view_key(true);
    assert_eq!(harness.state().state.planning.hovered_route, Some(1));
    harness.get_by_label_contains("Route 2:").click();
    harness.run_steps(2);
    let state = &harness.state().state;
    assert_eq!((state.scene().motion.planner, state.scene().motion.route), (Planner::Routes, Some(1)));
    assert_eq!(asked(&harness), Some(Stage::Plan));
    assert_ne!(state.view_key(true), before);
    harness.get_by_label("Take the first that works").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.scene().motion.route, None);
}

#[test]
fn a_kept_plan_stands_beside_the_present_one_until_it_is_cleared() {
    let mut harness = plan_page(PlanPage::Plan);
    harness.get_by_label("Keep as A").click();
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label("Duration: A 11.40 s, now 11.40 s").count(), 1);
    assert!(harness.state().state.planning_key().kept.is_some());
    let state = &harness.state().state;
    let input = state.compose_input(true);
    let dashed =
        BuiltInStudio::default().compose(&input).frame.lines.iter().filter(|line| line.dash_px.is_some()).count();
    assert!(dashed >= 1, "its trail is drawn");
    harness.get_by_label("Clear A").click();
    harness.run_steps(2);
    assert!(harness.state().state.planning.kept.is_none());
}

#[test]
fn the_plan_is_saved_in_the_format_that_is_picked() {
    let mut harness = plan_page(PlanPage::Plan);
    harness.get_by_label("Export the plan").click();
    harness.run_steps(2);
    harness.get_by_label("glTF animation (GLB)").click();
    harness.run_steps(2);
    let effects = &harness.state().effects;
    assert!(effects.iter().any(|effect| matches!(effect, Effect::ExportMotion(MotionFormat::Glb))), "{effects:?}");
}

#[test]
fn layers_of_the_plan_are_switched_in_its_panel() {
    let mut harness = plan_page(PlanPage::Plan);
    for (name, layer) in [("Ghost poses", Layer::Ghosts), ("Swept volume", Layer::Swept)] {
        harness.get_by_role_and_label(egui::Role::Switch, name).click();
        harness.run_steps(2);
        assert!(harness.state().state.layers.get(layer).visible, "{name}");
    }
    assert_eq!(harness.query_all_by_role_and_label(egui::Role::SpinButton, "Ghosts").count(), 1);
}

#[test]
fn a_task_of_several_steps_is_shown_with_all_its_goals_and_phases() {
    let mut bench = Bench::until("pour", Stage::Plan);
    bench.apply(Command::SelectStep(Step::Stage(Stage::Plan)));
    let mut studio = BuiltInStudio::default();
    let goals = |bench: &Bench, studio: &mut BuiltInStudio| -> Vec<String> {
        let labels = studio.compose(&bench.page.state.compose_input(true)).labels;
        labels.into_iter().filter(|label| label.tone == crate::viewer::Tone::Goal).map(|label| label.text).collect()
    };
    assert_eq!(goals(&bench, &mut studio), ["goal 2"], "the first one can be moved: the gizmo stands there");
    bench.apply(Command::Planning(PlanCommand::SelectGoal(1)));
    assert_eq!(goals(&bench, &mut studio), ["goal 1"]);
    let mut harness = window(bench, [1280.0, 720.0], true);
    let _picture = picture(&mut harness, "plans-pour");
    assert_eq!(harness.query_all_by_label("Go to Pour").count(), 1);
    assert_eq!(harness.query_all_by_label("Lift the goal of step 2").count(), 1);
}
