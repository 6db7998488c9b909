//! Handovers on the page: the receiver is moved, places are looked at, and everything is shown to an audience.

use egui_kittest::kittest::Queryable as _;
use endcomfort_core::handover::{Agent, Receiver};
use endcomfort_core::job::Stage;
use endcomfort_core::scene::ArmChoice;

use super::bench::{Bench, Window, picture, window};
use super::page;
use crate::viewer::captions::{changes_hands_s, deed};
use crate::viewer::state::{Side, Step};
use crate::viewer::{Command, HandoverCommand, Layer, Overlay, PlanCommand, PlanPage, ViewerState};

const SMALL: [f32; 2] = [1280.0, 720.0];
const PHONE: [f32; 2] = [390.0, 844.0];

/// A demo, planned, with the page of its handover open.
fn handed(demo: &str) -> Bench {
    let mut bench = Bench::until(demo, Stage::Plan);
    let refusal = bench.page.state.refusal();
    assert!(refusal.is_none(), "{demo}: {refusal:?}");
    bench.apply(Command::SelectStep(Step::Stage(Stage::Plan)));
    bench.apply(Command::Planning(PlanCommand::Page(PlanPage::Handover)));
    bench
}

fn agent(state: &ViewerState) -> Agent {
    state.receiver().expect("somebody receives").clone()
}

fn moved(agent: &Agent, x_m: f64, turn_rad: f64) -> Command {
    let mut to = agent.clone();
    to.position_m[0] += x_m;
    to.yaw_rad += turn_rad;
    Command::Handover(HandoverCommand::DragReceiver(Box::new(to)))
}

#[test]
fn captions_tell_who_does_what_in_the_order_of_a_handover() {
    let bench = handed("butler");
    let state = &bench.page.state;
    let plan = state.outputs.plan.as_deref().expect("the butler has a plan");
    let captions: Vec<String> = (0..plan.phases.len()).map(|phase| state.caption(plan, phase)).collect();
    let place = |wanted: &str| captions.iter().position(|caption| caption == wanted);
    let order = [
        "Alita reaches for the mustard bottle",
        "Alita presents the mustard bottle to Hubo",
        "Hubo takes the mustard bottle",
        "Alita lets go: Hubo has it",
        "Hubo puts the mustard bottle down",
    ]
    .map(|wanted| place(wanted).unwrap_or_else(|| panic!("{wanted:?} is not among {captions:?}")));
    assert!(order.is_sorted(), "{captions:?}");
    let at_s = changes_hands_s(plan).expect("it changes hands");
    assert_eq!(deed(plan, plan.phase_at(at_s + 1e-6)), "lets go");
}

#[test]
fn a_dragged_receiver_is_planned_for_anew_and_one_undo_brings_it_back() {
    let mut bench = handed("butler");
    let before = agent(&bench.page.state);
    let furniture = |bench: &Bench| agent(&bench.page.state).furniture_W().map(|piece| piece.X_WB).collect::<Vec<_>>();
    let stood = furniture(&bench);
    let asked = bench.asked.len();
    for share in [0.2, 0.6, 1.0] {
        bench.apply(moved(&before, 0.05 * share, 0.1 * share));
    }
    assert!(bench.page.state.is_dragging_goal());
    bench.apply(Command::Handover(HandoverCommand::EndDrag));
    let state = &bench.page.state;
    assert!(bench.asked.len() > asked && !state.is_dragging_goal());
    let now = agent(state);
    assert!((now.position_m[0] - before.position_m[0] - 0.05).abs() < 1e-12);
    assert!((now.yaw_rad - before.yaw_rad - 0.1).abs() < 1e-12);
    assert_ne!(furniture(&bench), stood, "its tray goes with it");
    bench.apply(Command::Undo);
    assert_eq!(agent(&bench.page.state), before, "the drag was one step");
    // Esc on the way puts it back and leaves nothing to undo.
    let undone = bench.page.state.can_undo();
    bench.apply(moved(&before, 0.2, 0.0));
    bench.apply(Command::Escape);
    assert_eq!(agent(&bench.page.state), before);
    assert_eq!(bench.page.state.can_undo(), undone);
}

#[test]
fn the_pointer_moves_the_receiver_over_the_floor() {
    let mut harness = window(handed("butler"), SMALL, true);
    harness.run_steps(40);
    let before = agent(&harness.state().bench.page.state);
    let from = harness.get_by_label("Move the receiver").rect().center();
    assert_eq!(harness.query_all_by_label("Turn the receiver").count(), 1);
    assert_eq!(harness.query_all_by_label("Lift the receiver").count(), 0);
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(from + egui::vec2(-12.0, 0.0));
    harness.run_steps(2);
    assert!(harness.state().bench.page.state.is_dragging_goal());
    harness.drop_at(from + egui::vec2(-12.0, 0.0));
    harness.run_steps(3);
    let state = &harness.state().bench.page.state;
    assert!(!state.is_dragging_goal());
    let now = agent(state);
    assert_ne!(now.position_m, before.position_m);
    assert_eq!((now.yaw_rad, now.floor_m), (before.yaw_rad, before.floor_m));
    harness.state_mut().bench.apply(Command::Undo);
    assert_eq!(agent(&harness.state().bench.page.state), before);
}

#[test]
fn numbers_posture_arms_and_choice_are_asked_for_in_the_panel() {
    let bench = handed("butler");
    let waits = agent(&bench.page.state).posture;
    let mut harness = page(bench.page.state, [1280.0, 2400.0], egui::Theme::Dark);
    harness.run_steps(2);
    for name in [
        "Receiver x, mm",
        "Receiver y, mm",
        "Receiver height, mm",
        "Receiver turn, °",
        "Threshold, %",
        "Places",
        "Hand speed, mm/s",
    ] {
        assert_eq!(harness.query_all_by_role_and_label(egui::Role::SpinButton, name).count(), 1, "{name}");
    }
    assert_eq!(harness.query_all_by_label("Sitting").count(), 0, "Hubo has no such posture");
    harness.get_by_role_and_label(egui::Role::RadioButton, "Kneeling").click();
    harness.run_steps(2);
    assert_eq!(agent(&harness.state().state).posture, "kneeling");
    harness.get_by_role_and_label(egui::Role::Switch, "The receiver's ease first").click();
    harness.run_steps(2);
    let state = &harness.state().state;
    let handover = state.scene().handover.as_ref().expect("a handover");
    assert!(!handover.choice.receiver_first && matches!(handover.receiver, Receiver::Agent(_)));
    let arms = harness.query_all_by_role_and_label(egui::Role::RadioButton, "Right arm");
    let lowest = arms.max_by(|a, b| a.rect().top().total_cmp(&b.rect().top())).expect("the giver's");
    lowest.click();
    harness.run_steps(2);
    let giver = harness.state().state.scene().handover.as_ref().and_then(|handover| handover.giver_arm);
    assert_eq!(giver, Some(ArmChoice::Right));
    let _run = harness.state_mut().state.apply(Command::Undo);
    let _run = harness.state_mut().state.apply(Command::Undo);
    let _run = harness.state_mut().state.apply(Command::Undo);
    assert_eq!(agent(&harness.state().state).posture, waits);
}

#[test]
fn places_are_listed_with_their_numbers_and_shown_in_the_view() {
    let bench = handed("human");
    let report = bench.page.state.handover_report().expect("a handover").clone();
    let other = (0..report.places.len()).find(|&index| index != report.chosen).expect("there is a choice");
    let mut harness = page(bench.page.state, [1280.0, 2400.0], egui::Theme::Dark);
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label_contains("Place ").count(), report.places.len());
    for (term, _, _) in report.places[report.chosen].comfort.expect("a person has comfort").terms() {
        assert_eq!(harness.query_all_by_label_contains(&format!("{term} costs ")).count(), 1, "{term}");
    }
    let before = harness.state().state.view_key(true);
    let row = format!("Place {}: ", other + 1);
    let middle = harness.get_by_label_contains(&row).rect().center();
    harness.hover_at(middle);
    harness.run_steps(2);
    assert_eq!(harness.state().state.shown_place(), Some(other));
    assert_ne!(harness.state().state.view_key(true), before);
    harness.get_by_label_contains(&row).click();
    harness.run_steps(2);
    harness.hover_at(egui::pos2(600.0, 1200.0));
    harness.run_steps(2);
    assert_eq!(harness.state().state.planning.selected_place, Some(other));
    assert_eq!(harness.query_all_by_label_contains("Hide Handover").count(), 1, "the layer has an eye");
}

#[test]
fn the_presentation_hides_the_panels_and_esc_brings_them_back() {
    let mut harness = window(handed("butler"), SMALL, true);
    harness.run_steps(4);
    assert_eq!(harness.query_all_by_label_contains("Open a demo").count(), 1);
    harness.get_by_label("Presentation without panels (P)").click();
    harness.run_steps(3);
    let playback = &harness.state().bench.page.state.playback;
    assert!(playback.playing && playback.looping);
    assert_eq!(harness.query_all_by_label_contains("Open a demo").count(), 0);
    assert_eq!(harness.query_all_by_label_contains("Caption: Alita").count(), 1);
    assert_eq!(harness.query_all_by_label_contains("the receiver").count(), 0, "nothing to drag is in the way");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    let state = &harness.state().bench.page.state;
    assert!(state.presentation.is_none() && !state.playback.looping && !state.playback.playing);
    assert_eq!(harness.query_all_by_label_contains("Open a demo").count(), 1);
    assert_eq!(harness.query_all_by_label_contains("Caption: ").count(), 0);
    harness.key_press(egui::Key::P);
    harness.run_steps(3);
    assert!(harness.state().bench.page.state.presentation.is_some());
}

#[test]
fn the_camera_follows_the_object_and_stays_when_it_is_told_to() {
    let mut harness = window(handed("butler"), SMALL, true);
    harness.run_steps(40);
    let target = |harness: &egui_kittest::Harness<'_, Window>| harness.state().view.camera().target;
    let object = |harness: &egui_kittest::Harness<'_, Window>| {
        let state = &harness.state().bench.page.state;
        let plan = state.outputs.plan.as_deref().expect("a plan");
        let robot = crate::assets::library().robot_of(state.scene()).expect("both");
        plan.object_pose(&robot, &plan.state_at(state.playback.time_s)).translation.vector
    };
    harness.get_by_label("The camera follows the object (O)").click();
    harness.run_steps(120);
    assert!((target(&harness).coords - object(&harness)).norm() < 5e-3);
    let end_s = harness.state().bench.page.state.duration_s();
    harness.state_mut().bench.apply(Command::Seek(end_s));
    harness.run_steps(120);
    assert!((target(&harness).coords - object(&harness)).norm() < 5e-3);
    harness.key_press(egui::Key::O);
    harness.run_steps(2);
    let stood = target(&harness);
    harness.state_mut().bench.apply(Command::Seek(0.0));
    harness.run_steps(60);
    assert_eq!(target(&harness), stood);
}

#[test]
fn the_camera_follows_any_hand() {
    let mut harness = window(handed("butler"), SMALL, true);
    harness.run_steps(40);
    let hands = harness.state().bench.page.state.hands_to_follow();
    let titles: Vec<&str> = hands.iter().map(|(_, title)| title.as_str()).collect();
    assert_eq!(&titles[..2], ["Follow the left hand", "Follow the right hand"]);
    harness.state_mut().bench.apply(Command::Follow(hands[1].0));
    harness.run_steps(120);
    let robot = crate::assets::library().robot_of(harness.state().bench.page.state.scene()).expect("both");
    let q = harness.state().bench.page.state.scene().q_start(&robot).expect("a posture");
    let hand = robot.link_poses(&q)[robot.arms[1].hand.tcp_link].translation.vector;
    assert!((harness.state().view.camera().target.coords - hand).norm() < 5e-3);
    harness.state_mut().bench.apply(Command::Follow(hands[1].0));
    assert_eq!(harness.state().bench.page.state.playback.follows, None, "asked again, it lets go");
}

/// The looks of it: kept with `ENDCOMFORT_LOOK`.
#[test]
fn handovers_are_drawn_in_both_themes_and_on_a_phone() {
    let time = |bench: &Bench| {
        let plan = bench.page.state.outputs.plan.as_deref().expect("a plan");
        changes_hands_s(plan).expect("it changes hands") - 0.1
    };
    for (demo, dark) in [("butler", true), ("human", false), ("self-handover", true)] {
        let mut bench = handed(demo);
        let at_s = time(&bench);
        bench.apply(Command::Seek(at_s));
        let mut harness = window(bench, SMALL, dark);
        let _picture = picture(&mut harness, &format!("handover-{demo}"));
        assert_eq!(harness.query_all_by_label("Handover page").count(), 1, "{demo}");
        harness.state_mut().bench.apply(Command::Present(true));
        harness.state_mut().bench.apply(Command::SetPlaying(false));
        harness.state_mut().bench.apply(Command::Seek(at_s));
        let _picture = picture(&mut harness, &format!("handover-{demo}-presented"));
        assert_eq!(harness.query_all_by_label_contains("Caption: ").count(), 1, "{demo}");
    }
    let mut bench = handed("human");
    let at_s = time(&bench);
    bench.apply(Command::Seek(at_s));
    let mut harness = window(bench, PHONE, true);
    let _picture = picture(&mut harness, "handover-phone");
    harness.state_mut().bench.apply(Command::ToggleDrawer(Side::Right));
    let _picture = picture(&mut harness, "handover-phone-drawer");
    harness.state_mut().bench.apply(Command::Present(true));
    harness.state_mut().bench.apply(Command::SetPlaying(false));
    harness.state_mut().bench.apply(Command::Seek(at_s));
    let _picture = picture(&mut harness, "handover-phone-presented");
    harness.state_mut().bench.apply(Command::Present(false));
    harness.state_mut().bench.apply(Command::Show(Overlay::Gallery));
    let _picture = picture(&mut harness, "handover-phone-gallery");
    let mut harness = window(handed("kneeling"), SMALL, false);
    let there = agent(&harness.state().bench.page.state);
    harness.run_steps(40);
    // On its way: the old plan is grey.
    let effects = harness.state_mut().bench.page.state.apply(moved(&there, 0.25, 0.4));
    let _picture = picture(&mut harness, "handover-kneeling-dragged");
    assert!(harness.state().bench.page.state.is_dragging_goal());
    harness.state_mut().bench.carry_out(effects);
    let mut bench = handed("stool");
    bench.apply(Command::SelectStep(Step::Stage(Stage::Scene)));
    let mut harness = window(bench, [1440.0, 1400.0], false);
    harness.state_mut().bench.apply(Command::ToggleLayer(Layer::Path));
    let _picture = picture(&mut harness, "handover-stool-scene");
    harness.state_mut().bench.apply(Command::Show(Overlay::Gallery));
    harness.run_steps(2);
    harness.get_by_label("From hand to hand · 5").click();
    let _picture = picture(&mut harness, "handover-gallery");
    let last = harness.get_by_label("Open Crichton hands a hammer to a person");
    assert!(last.rect().top() < 1300.0, "the handovers have been scrolled to");
}
