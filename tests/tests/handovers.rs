//! Handovers from the camera's cloud to the motions of both arms: what a person watching would insist on.

#![allow(non_snake_case, reason = "frame letters: X_WO is the pose of O in W")]
#![allow(clippy::unwrap_used, reason = "a test may stop at what is missing")]

use endcomfort::assets;
use endcomfort_core::handover::{Handover, HandoverReport, PERSON, Receiver};
use endcomfort_core::job::{Output, Refusal, Request, Update};
use endcomfort_core::pipeline::Pipeline;
use endcomfort_core::scene::Scene;
use endcomfort_core::task::{PhaseKind, Plan};
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Vector3};

/// Configurations per sample when a plan is walked again.
const DENSITY: usize = 4;
const GIVES: usize = 0;
const TAKES: usize = 1;

fn scenes() -> Vec<Scene> {
    let scenes = assets::DEMOS.into_iter().map(|name| assets::demo(name).unwrap());
    scenes.filter(|scene| scene.handover.is_some()).collect()
}

fn planned(pipeline: &mut Pipeline, scene: Scene) -> Result<Plan, Refusal> {
    let mut answer = Err(Refusal::new("no answer"));
    pipeline.run(&Request::new(scene), &Watch::idle(), &mut |update| match update {
        Update::Done { output, .. } => {
            if let Output::Plan(plan) = *output {
                answer = Ok(*plan);
            }
        }
        Update::Refused { refusal, .. } => answer = Err(refusal),
        _ => {}
    });
    answer
}

fn report(plan: &Plan) -> &HandoverReport {
    plan.handover.as_ref().unwrap()
}

#[test]
fn every_handover_is_planned_and_neither_arm_hand_nor_object_touches_anything_when_walked_again() {
    let scenes = scenes();
    assert_eq!(scenes.len(), 5);
    for scene in scenes {
        let name = scene.name.clone();
        let mut pipeline = Pipeline::new(assets::library());
        let plan = planned(&mut pipeline, scene).unwrap_or_else(|refusal| panic!("{name}: {refusal:?}"));
        let mut samples = 0;
        for (number, phase) in plan.phases.iter().enumerate().filter(|(_, phase)| !phase.kind.is_of_fingers()) {
            let cell = pipeline.workcell_during(number).unwrap();
            let hit = cell.rewalk_phase(&plan, phase, DENSITY).unwrap();
            assert_eq!(hit, None, "{name}: {:?} of leg {}", phase.kind, phase.leg);
            samples += phase.trajectory.positions.len();
        }
        assert_eq!(plan.certificate.states, DENSITY * samples, "{name}");
    }
}

#[test]
fn the_giver_opens_only_after_the_receiver_has_closed_and_the_object_never_jumps() {
    for scene in scenes() {
        let name = scene.name.clone();
        let robot = assets::library().robot_of(&scene).unwrap();
        let plan = planned(&mut Pipeline::new(assets::library()), scene).unwrap();
        let at = |leg: usize, kind: PhaseKind| {
            plan.phases.iter().position(|phase| phase.leg == leg && phase.kind == kind).unwrap()
        };
        let order = [
            at(GIVES, PhaseKind::Close),
            at(GIVES, PhaseKind::Transport),
            at(TAKES, PhaseKind::Close),
            at(GIVES, PhaseKind::Open),
            at(GIVES, PhaseKind::Retreat),
            at(TAKES, PhaseKind::Transport),
        ];
        assert!(order.is_sorted(), "{name}: {order:?}");

        let mut last: Option<(Isometry3<f64>, Vec<f64>)> = None;
        let steps = (plan.duration_s() / 0.01) as usize;
        for k in 0..=steps {
            let state = plan.state_at(0.01 * k as f64);
            let X_WO = plan.object_pose(&robot, &state);
            if let Some((before, q)) = &last {
                let moved_m = (X_WO.translation.vector - before.translation.vector).norm();
                let turned_rad = X_WO.rotation.angle_to(&before.rotation);
                assert!(moved_m < 0.03 && turned_rad < 0.2, "{name} at {:.2} s: {moved_m} m", 0.01 * k as f64);
                let jump = q.iter().zip(&state.q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(jump < 0.1, "{name} at {:.2} s: a joint jumps by {jump}", 0.01 * k as f64);
            }
            last = Some((X_WO, state.q));
        }
    }
}

#[test]
fn the_receiver_puts_the_object_where_it_wants_it() {
    let scene = assets::demo("butler").unwrap();
    let Some(Receiver::Agent(agent)) = scene.handover.as_ref().map(|handover| &handover.receiver) else { panic!() };
    let goal = agent.goal.unwrap();
    let wanted = agent.X_WA() * goal.X_AO;
    let plan = planned(&mut Pipeline::new(assets::library()), scene.clone()).unwrap();
    let shift = agent.X_WA().rotation.inverse() * (plan.X_WO_end().translation.vector - wanted.translation.vector);
    let reach = Vector3::new(goal.freedom.area_m[0], goal.freedom.area_m[1], 0.0).norm() + 0.012;
    assert!(shift.xy().norm() < reach && shift.z.abs() < 0.02, "{shift}");
    let up = plan.X_WO_end().rotation * (plan.X_WO_start().rotation.inverse() * Vector3::z());
    assert!(up.angle(&Vector3::z()) < 1e-6, "on a tray it stands");
}

#[test]
fn a_person_gets_the_handle_slowly_and_keeps_its_space() {
    let scene = assets::demo("human").unwrap();
    let library = assets::library();
    let robot = library.robot_of(&scene).unwrap();
    let speed = scene.handover.as_ref().unwrap().choice.hand_speed_m_s;
    let plan = planned(&mut Pipeline::new(library.clone()), scene).unwrap();
    let place = &report(&plan).places[report(&plan).chosen];
    assert!(place.by_handle && place.comfort.unwrap().total < 0.25, "{place:?}");

    let hand = |time_s: f64| robot.link_poses(&plan.state_at(time_s).q)[plan.legs[GIVES].tcp_link].translation.vector;
    let present = plan.phases.iter().find(|phase| phase.leg == GIVES && phase.kind == PhaseKind::Transport).unwrap();
    let end_s = present.start_s + present.trajectory.duration_s();
    let mut time_s = present.start_s;
    while time_s + 0.01 < end_s {
        let found = (hand(time_s + 0.01) - hand(time_s)).norm() / 0.01;
        assert!(found < 1.02 * speed, "{found} m/s at {time_s:.2} s");
        time_s += 0.01;
    }

    // No origin of a giver's link comes nearer to the head's than the keep-out.
    let head = robot.link_index(&format!("{PERSON}_head")).unwrap();
    let givers = library.robot("crichton").unwrap().links.len();
    for k in 0..=200 {
        let X_WL = robot.link_poses(&plan.state_at(plan.duration_s() * f64::from(k) / 200.0).q);
        for X_WG in &X_WL[..givers] {
            assert!((X_WG.translation.vector - X_WL[head].translation.vector).norm() > 0.15);
        }
    }
}

#[test]
fn a_receiver_out_of_reach_is_told_with_the_distance_and_the_scene_stays_plannable() {
    let scene = assets::demo("butler").unwrap();
    let mut far = scene.clone();
    let Some(Handover { receiver: Receiver::Agent(agent), .. }) = &mut far.handover else { panic!() };
    agent.position_m = [0.5, -3.0];
    let mut pipeline = Pipeline::new(assets::library());
    let refusal = planned(&mut pipeline, far).unwrap_err();
    assert!(refusal.message.contains("reach no place together"), "{refusal:?}");
    assert!(planned(&mut pipeline, scene).is_ok());
}

#[test]
fn the_arm_that_reaches_the_object_gives_whatever_the_scene_says() {
    let mut scene = assets::demo("self-handover").unwrap();
    scene.arm = scene.arm.other();
    let plan = planned(&mut Pipeline::new(assets::library()), scene).unwrap();
    assert_eq!(report(&plan).arms, ["right", "left"]);
}

#[test]
fn the_same_seed_gives_the_same_handover() {
    let scene = assets::demo("stool").unwrap();
    let text =
        || serde_json::to_string(&planned(&mut Pipeline::new(assets::library()), scene.clone()).unwrap()).unwrap();
    assert_eq!(text(), text());
}
