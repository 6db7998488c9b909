//! The robot posed by hand, on a demo with the real pipeline.

use egui::{Pos2, Rect, Theme};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::Stage;
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::bench::{Bench, Window, picture, window};
use super::page;
use crate::assets;
use crate::viewer::layout::Layout;
use crate::viewer::{Command, Jog, PoseCommand, Posture, ViewerState};

fn bench(last: Stage) -> Bench {
    let mut bench = Bench::until("mustard", last);
    bench.apply(Command::Pose(PoseCommand::Open));
    bench
}

/// Where the hand of an arm is when the robot starts as the scene has it.
fn hand(state: &ViewerState, arm: usize) -> Isometry3<f64> {
    let scene = state.scene();
    let robot = assets::library().robot_of(scene).expect("the robot is there");
    let q = scene.q_start(&robot).expect("it can stand like that");
    robot.link_poses(&q)[robot.arms[arm].hand.tcp_link]
}

#[test]
fn a_led_hand_goes_where_it_is_led_and_the_plan_starts_from_there() {
    let mut bench = bench(Stage::Plan);
    let before = bench.page.state.document.clone();
    let X_WH = hand(&bench.page.state, 0);
    for step in 1..=5 {
        let to = Translation3::new(0.0, 0.006 * f64::from(step), 0.012 * f64::from(step)) * X_WH;
        bench.apply(Command::Pose(PoseCommand::Lead(0, to)));
    }
    bench.apply(Command::Pose(PoseCommand::EndDrag));
    let moved = hand(&bench.page.state, 0).translation.vector - X_WH.translation.vector;
    assert!((moved - Vector3::new(0.0, 0.03, 0.06)).norm() < 1e-6, "moved by {moved}");
    let state = &bench.page.state;
    assert_eq!(state.posture(), Posture::Start);
    let plan = state.outputs.plan.as_ref().expect("a plan");
    assert_eq!(plan.revision, state.revision);
    let robot = assets::library().robot_of(state.scene()).expect("the robot is there");
    let q = state.scene().q_start(&robot).expect("it can stand like that");
    // The hand that acts opens before it sets out.
    let joints = robot.arms.iter().flat_map(|arm| &arm.dofs);
    assert!(joints.clone().count() == 14 && joints.clone().all(|&dof| plan.q_start[dof] == q[dof]));
    bench.apply(Command::Undo);
    assert_eq!(bench.page.state.document, before, "the drag is one step of undo");
    assert!(!bench.page.state.can_undo());
}

#[test]
fn out_of_reach_the_arm_stretches_after_its_target_and_says_why() {
    let mut bench = bench(Stage::Scene);
    let X_WH = hand(&bench.page.state, 0);
    let far = Translation3::new(1.2, 0.0, 0.3) * X_WH;
    bench.apply(Command::Pose(PoseCommand::Lead(0, far)));
    let led = bench.page.state.led_hands().remove(0);
    let target = led.target.expect("it is out of reach");
    assert_eq!(target.X_WH, far);
    assert!(target.reason.to_string().starts_with("out of reach by"), "{}", target.reason);
    let gap = |X: &Isometry3<f64>| (far.translation.vector - X.translation.vector).norm();
    assert!(gap(&led.X_WH) < 0.7 * gap(&X_WH), "the arm stayed behind: {} of {} m", gap(&led.X_WH), gap(&X_WH));
    let key = bench.page.state.posing_key();
    assert!(key.hands[0].target.is_some() && key.hands[1].target.is_none());
    bench.apply(Command::Pose(PoseCommand::Recall(0)));
    assert_eq!(bench.page.state.led_hands()[0].target, None);
    // Esc while it is dragged puts everything back.
    bench.apply(Command::Pose(PoseCommand::EndDrag));
    let document = bench.page.state.document.clone();
    bench.apply(Command::Pose(PoseCommand::Lead(1, Translation3::new(0.0, 0.0, 0.05) * hand(&bench.page.state, 1))));
    bench.apply(Command::Escape);
    assert_eq!(bench.page.state.document, document);
    assert!(bench.page.state.posing.is_open, "only the drag was ended");
    bench.apply(Command::Escape);
    assert!(!bench.page.state.posing.is_open);
}

#[test]
fn a_pose_in_the_table_is_blamed_as_it_happens_and_refused_by_the_planner() {
    let mut bench = bench(Stage::Plan);
    assert_eq!(bench.page.state.meeting().expect("the page is open").hits, Vec::new());
    let X_WH = hand(&bench.page.state, 0);
    let table = bench.page.state.scene().table.height_m;
    let down = Translation3::new(0.05, 0.0, table - 0.03 - X_WH.translation.z) * X_WH;
    bench.apply(Command::Pose(PoseCommand::Lead(0, down)));
    bench.apply(Command::Pose(PoseCommand::EndDrag));
    let key = bench.page.state.posing_key();
    assert!(key.met.iter().any(|name| name == "table"), "{:?}", key.met);
    assert!(key.met.iter().any(|name| name.starts_with("left")), "{:?}", key.met);
}

#[test]
fn buttons_move_along_the_world_or_the_hand_and_joints_stop_at_their_limits() {
    let mut bench = bench(Stage::Scene);
    let before = hand(&bench.page.state, 0);
    bench.apply(Command::Pose(PoseCommand::Jog(Jog { turns: false, axis: 2, back: false })));
    let up = hand(&bench.page.state, 0).translation.vector - before.translation.vector;
    assert!((up - Vector3::new(0.0, 0.0, 0.01)).norm() < 1e-6, "{up}");
    bench.apply(Command::Pose(PoseCommand::AlongHand(true)));
    let before = hand(&bench.page.state, 0);
    bench.apply(Command::Pose(PoseCommand::Jog(Jog { turns: true, axis: 2, back: true })));
    let turn = before.rotation.inverse() * hand(&bench.page.state, 0).rotation;
    let about_own_z = turn.scaled_axis() - Vector3::new(0.0, 0.0, -0.0873);
    assert!(about_own_z.norm() < 1e-6, "{}", turn.scaled_axis());
    let robot = assets::library().robot_of(bench.page.state.scene()).expect("the robot is there");
    let dof = robot.arms[0].dofs[3];
    let limit = robot.joints[robot.dof_joints[dof]].limit;
    bench.apply(Command::Pose(PoseCommand::DragJoint(dof, 99.0)));
    bench.apply(Command::Pose(PoseCommand::EndDrag));
    let q = bench.page.state.scene().q_start(&robot).expect("it can stand like that");
    assert_eq!(q[dof], limit.upper);
    let link = &robot.links[robot.joints[robot.dof_joints[dof]].child].name;
    assert!(bench.page.state.posing_key().strained.contains(link));
}

#[test]
fn the_page_lists_every_joint_and_its_sliders_and_buttons_move_the_robot() {
    let state = bench(Stage::Scene).page.state;
    let mut harness = page(state, [1280.0, 1500.0], Theme::Light);
    harness.run_steps(2);
    let robot = assets::library().robot_of(harness.state().state.scene()).expect("the robot is there");
    for &dof in &robot.arms[0].dofs {
        let name = &robot.joints[robot.dof_joints[dof]].name;
        let _slider = harness.get_by_label_contains(&format!("{name}:"));
    }
    let before = hand(&harness.state().state, 0);
    harness.get_by_label("Move the hand along z").click();
    harness.run_steps(3);
    let risen = hand(&harness.state().state, 0).translation.z - before.translation.z;
    assert!((risen - 0.01).abs() < 1e-6, "{risen} m");
    let before = harness.state().state.document.scene.joints.clone();
    let name = robot.joints[robot.dof_joints[robot.arms[0].dofs[0]]].name.clone();
    harness.get_by_label_contains(&format!("{name}:")).focus();
    harness.run_steps(1);
    harness.key_press(egui::Key::ArrowRight);
    harness.run_steps(4);
    assert_ne!(harness.state().state.document.scene.joints, before);
    assert!(!harness.state().state.is_dragging_goal(), "a key is let go at once");
    harness.get_by_label("Right arm").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.posing.arm, 1);
    harness.get_by_label("Close Pose").click();
    harness.run_steps(2);
    assert!(!harness.state().state.posing.is_open);
}

#[test]
fn the_dot_of_a_hand_is_dragged_in_the_view() {
    let size = [1280.0, 720.0];
    for dark in [true, false] {
        let mut harness = window(bench(Stage::Fit), size, dark);
        let name = |what: &str| format!("posing-{what}-{}", if dark { "dark" } else { "light" });
        let _before = picture(&mut harness, &name("before"));
        let rect = Layout::new(Rect::from_min_size(Pos2::ZERO, size.into()), None).picture();
        let on_screen = |harness: &Harness<'_, Window>, X: &Isometry3<f64>| {
            let p = Point3::from(X.translation.vector);
            let at = harness.state().view.camera().project(&p, [f64::from(rect.width()), f64::from(rect.height())]);
            let at = at.expect("it is before the camera");
            rect.min + egui::vec2(at.x as f32, at.y as f32)
        };
        let before = hand(&harness.state().bench.page.state, 0);
        let from = on_screen(&harness, &before);
        harness.hover_at(from);
        harness.run_steps(1);
        harness.drag_at(from);
        harness.run_steps(1);
        for step in [20.0, 40.0, 60.0] {
            harness.hover_at(from - egui::vec2(0.0, step));
            harness.run_steps(2);
        }
        let _held = picture(&mut harness, &name("held"));
        harness.drop_at(from - egui::vec2(0.0, 60.0));
        harness.run_steps(2);
        let state = &harness.state().bench.page.state;
        let after = on_screen(&harness, &hand(state, 0));
        assert!((after - from - egui::vec2(0.0, -60.0)).length() < 1.0, "from {from} to {after}");
        let far = Translation3::new(0.5, 0.2, 0.25) * hand(state, 1);
        harness.state_mut().bench.apply(Command::Pose(PoseCommand::Lead(1, far)));
        harness.state_mut().bench.apply(Command::Pose(PoseCommand::EndDrag));
        let _short = picture(&mut harness, &name("short"));
    }
}
