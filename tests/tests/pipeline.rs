//! The whole pipeline on every demo and, alone on the table, on every household object, with both robots.

#![allow(non_snake_case, reason = "frame letters: X_WO is the pose of O in W")]

use std::sync::Arc;

use endcomfort::assets;
use endcomfort_core::job::{Output, RankOutput, Refusal, Request, SetShape, Stage, Update};
use endcomfort_core::pipeline::Pipeline;
use endcomfort_core::scene::{ArmChoice, Freedom, PlacedObject, Scene, Task};
use endcomfort_core::task::{LegTask, Phase, PhaseKind, Plan, Planner, assemble, plan_leg};
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Vector3};

/// Steps per sample of a trajectory when it is walked again.
const DENSITY: usize = 4;

fn request(scene: Scene) -> Request {
    Request { revision: 1, ..Request::new(scene) }
}

fn run(pipeline: &mut Pipeline, request: &Request) -> (Vec<Output>, Option<Refusal>) {
    let (mut outputs, mut refused) = (Vec::new(), None);
    pipeline.run(request, &Watch::idle(), &mut |update| match update {
        Update::Done { output, .. } => outputs.push(*output),
        Update::Refused { refusal, .. } => refused = Some(refusal),
        Update::Progress { .. } | Update::Mapping { .. } | Update::Finished { .. } => {}
    });
    (outputs, refused)
}

fn plan_of(outputs: Vec<Output>) -> Option<Plan> {
    outputs.into_iter().find_map(|output| if let Output::Plan(plan) = output { Some(*plan) } else { None })
}

fn check_phases(plan: &Plan, wanted: &[PhaseKind]) {
    let kinds: Vec<PhaseKind> = plan.phases.iter().map(|phase| phase.kind).collect();
    assert_eq!(kinds, wanted);
    let last = |phase: &Phase| phase.trajectory.positions.last().cloned().unwrap_or_default();
    for pair in plan.phases.windows(2) {
        let (end, start) = (last(&pair[0]), &pair[1].trajectory.positions[0]);
        let jump = end.iter().zip(start).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(jump < 1e-9, "{:?} ends {jump} away from where {:?} starts", pair[0].kind, pair[1].kind);
        assert!((pair[0].start_s + pair[0].trajectory.duration_s() - pair[1].start_s).abs() < 1e-9);
    }
    for phase in &plan.phases {
        let samples = phase.trajectory.times_s.len();
        assert_eq!((phase.manipulability.len(), phase.clearance_m.len()), (samples, samples));
        assert!(phase.trajectory.positions.iter().all(|q| q.len() == plan.dofs.len()));
    }
}

use PhaseKind::{Close, Lift, Open, Place, Pour, Reach, Retreat, Slide, Transport};

const PICK_AND_PLACE: [PhaseKind; 7] = [Reach, Close, Lift, Transport, Place, Open, Retreat];

/// The demos of one arm; handovers have their own tests.
fn tasks() -> impl Iterator<Item = &'static str> {
    assets::DEMOS.into_iter().filter(|name| assets::demo(name).is_some_and(|scene| scene.handover.is_none()))
}

/// The phases of a demo's plan.
fn phases_of(demo: &str) -> Vec<PhaseKind> {
    match demo {
        "across" => vec![Reach, Close, Slide, Open, Retreat],
        "pour" => vec![Reach, Close, Lift, Transport, Pour, Transport, Place, Open, Retreat],
        "regrasp" => [PICK_AND_PLACE, PICK_AND_PLACE].concat(),
        _ => PICK_AND_PLACE.to_vec(),
    }
}

#[test]
fn every_demo_is_planned_and_stays_free_when_walked_again_at_four_times_the_density() {
    for name in tasks() {
        let mut pipeline = Pipeline::new(assets::library());
        let (outputs, refused) = run(&mut pipeline, &request(assets::demo(name).unwrap()));
        assert_eq!(refused, None, "{name}");
        let plan = plan_of(outputs).unwrap();
        check_phases(&plan, &phases_of(name));
        let hit = pipeline.workcell().unwrap().rewalk(&plan, DENSITY).unwrap();
        assert_eq!(hit, None, "{name}");
        let moving = plan.phases.iter().filter(|phase| !phase.kind.is_of_fingers());
        let samples: usize = moving.map(|phase| phase.trajectory.positions.len()).sum();
        assert_eq!((plan.certificate.density, plan.certificate.states), (DENSITY, DENSITY * samples), "{name}");
    }
}

#[test]
fn a_goal_beyond_the_arm_is_reached_once_the_torso_may_move() {
    // The right hand shall put the jar down on the far left.
    let mut scene = assets::demo("jar").unwrap();
    let X_WO_goal = Isometry3::translation(0.50, 0.52, 0.78);
    scene.task = Task::place(scene.task.object, X_WO_goal);
    let (_, refused) = run(&mut Pipeline::new(assets::library()), &request(scene.clone()));
    let refusal = refused.expect("the arm alone does not reach so far");
    assert!(refusal.details.iter().any(|line| line.contains("goal: out of reach by")), "{refusal:?}");

    let mut pipeline = Pipeline::new(assets::library());
    let (outputs, refused) = run(&mut pipeline, &request(Scene { torso: true, ..scene }));
    assert_eq!(refused, None);
    let plan = plan_of(outputs).unwrap();
    check_phases(&plan, &PICK_AND_PLACE);
    let cell = pipeline.workcell().unwrap();
    assert_eq!(cell.rewalk(&plan, DENSITY).unwrap(), None);
    assert_eq!(cell.robot.joints[cell.robot.dof_joints[plan.dofs[0]]].name, "torso_joint");
    assert!(plan.grasp().goal.as_ref().unwrap().solutions.iter().all(|q| q.len() == 8));
    let turned = |phase: &Phase| phase.trajectory.positions.iter().any(|q| (q[0] - plan.q_start[0]).abs() > 0.1);
    assert!(plan.phases.iter().any(turned));
}

#[test]
fn the_object_ends_where_the_task_wants_it() {
    for name in tasks() {
        let scene = assets::demo(name).unwrap();
        let (object, step) = (scene.task.object, scene.task.steps.last().expect("a goal"));
        let (X_WO_goal, freedom) = (step.X_WO_goal, step.freedom);
        let moved = X_WO_goal * scene.objects[object].X_WO.inverse();
        let (outputs, _) = run(&mut Pipeline::new(assets::library()), &request(scene));
        let plan = plan_of(outputs).unwrap();
        let wanted = moved * plan.X_WO_start();
        let shift = plan.X_WO_end().translation.vector - wanted.translation.vector;
        // The fit's bottom is a few millimetres off the table's, and the object is let go just above.
        let [x_m, y_m] = freedom.area_m;
        assert!(shift.x.abs() < x_m + 0.012 && shift.y.abs() < y_m + 0.012 && shift.z.abs() < 0.012, "{name}: {shift}");
        let turn = plan.X_WO_end().rotation * wanted.rotation.inverse();
        assert!(turn.angle() < freedom.yaw_rad + 1e-9, "{name}");
        assert!((turn * Vector3::z()).angle(&Vector3::z()) < 1e-6, "{name}: a goal with a free yaw stays upright");

        // The last carried pose, by forward kinematics, is that goal.
        let last = plan.phases.iter().rposition(|phase| phase.carries).unwrap();
        let end_s = plan.phases[last].start_s + plan.phases[last].trajectory.duration_s();
        let state = plan.state_at(end_s - 1e-9);
        let robot = assets::library().robot(&assets::demo(name).unwrap().robot).unwrap();
        let grasp = &plan.legs[plan.phases[last].leg].grasp;
        let X_WO = robot.link_poses(&state.q)[plan.legs[0].tcp_link] * grasp.X_OH.inverse();
        assert!((X_WO.translation.vector - plan.X_WO_end().translation.vector).norm() < 1e-6, "{name}");
    }
}

#[test]
fn velocities_and_accelerations_stay_within_the_limits_sample_by_sample() {
    let scene = assets::demo("mustard").unwrap();
    let robot = assets::library().robot(&scene.robot).unwrap();
    let (outputs, _) = run(&mut Pipeline::new(assets::library()), &request(scene));
    let plan = plan_of(outputs).unwrap();
    let arm_columns = robot.arm(&plan.legs[0].arm).unwrap().dofs.len();
    for phase in &plan.phases {
        let (times, positions) = (&phase.trajectory.times_s, &phase.trajectory.positions);
        for (column, &dof) in plan.dofs.iter().enumerate().take(arm_columns) {
            let limit = robot.joints[robot.dof_joints[dof]].limit;
            let speed = |k: usize| (positions[k + 1][column] - positions[k][column]) / (times[k + 1] - times[k]);
            for k in 0..times.len() - 1 {
                assert!(speed(k).abs() <= limit.velocity * 1.001, "{:?} joint {column}", phase.kind);
            }
            for k in 0..times.len().saturating_sub(3) {
                // The last step of a trajectory may be shorter than the others and is left out.
                let acceleration = (speed(k + 1) - speed(k)) / (times[k + 1] - times[k]);
                assert!(acceleration.abs() <= limit.acceleration * 1.01, "{:?} joint {column}", phase.kind);
            }
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_plan_and_another_seed_another_cloud() {
    let scene = assets::demo("glass").unwrap();
    let plan = |seed: u64| {
        let (outputs, _) = run(&mut Pipeline::new(assets::library()), &request(Scene { seed, ..scene.clone() }));
        serde_json::to_string(&plan_of(outputs)).unwrap()
    };
    assert_eq!(plan(3), plan(3));
    assert_ne!(plan(3), plan(4));
}

#[test]
fn a_stage_is_answered_from_memory_when_only_later_inputs_change() {
    let scene = assets::demo("mustard").unwrap();
    let mut pipeline = Pipeline::new(assets::library());
    let (first, _) = run(&mut pipeline, &request(scene.clone()));
    let (object, X_WO_goal) = (scene.task.object, *scene.task.X_WO_goal().unwrap());
    let X_WO_goal = Isometry3::translation(0.0, -0.05, 0.0) * X_WO_goal;
    let moved = Scene { task: Task::place(object, X_WO_goal), ..scene };
    let (remembered, _) = run(&mut pipeline, &request(moved.clone()));
    let (fresh, _) = run(&mut Pipeline::new(assets::library()), &request(moved));
    let text = |outputs: &Vec<Output>| outputs.iter().map(|o| serde_json::to_string(o).unwrap()).collect::<Vec<_>>();
    let (first, remembered, fresh) = (text(&first), text(&remembered), text(&fresh));
    assert_eq!(remembered, fresh);
    assert_eq!(first[..3], remembered[..3]);
    assert_ne!(first[5], remembered[5]);
}

#[test]
fn every_rejected_grasp_says_why_and_every_accepted_one_can_be_reached() {
    // Out of the crate and upside down no single grasp leads: there nothing is accepted.
    for name in tasks().filter(|name| *name != "regrasp") {
        let (outputs, _) = run(&mut Pipeline::new(assets::library()), &request(assets::demo(name).unwrap()));
        let ranked = outputs.iter().find_map(|o| if let Output::Rank(rank) = o { Some(rank) } else { None }).unwrap();
        let (accepted, rejected) = ranked.grasps.split_at(ranked.accepted);
        assert!(!accepted.is_empty() && !rejected.is_empty(), "{name}");
        for grasp in accepted {
            let (start, goal) = (grasp.start.as_ref().unwrap(), grasp.goal.as_ref().unwrap());
            assert!(grasp.is_accepted() && start.ik_count > 0 && goal.ik_count > 0 && grasp.contacts.len() >= 3);
            let mean = goal.manipulability.iter().sum::<f64>() / goal.ik_count as f64;
            assert!((mean - goal.m_g).abs() < 1e-12);
        }
        // With several stops all of them count.
        let merit = |k: usize| {
            let m_g: Vec<f64> = accepted[k].stops().map(|set| set.m_g).collect();
            m_g.iter().sum::<f64>() / m_g.len() as f64
        };
        assert!((1..accepted.len()).all(|k| merit(k - 1) >= merit(k)), "{name} is not ranked by m_g at the goal");
        assert!(rejected.iter().all(|grasp| !grasp.is_accepted() && !grasp.status.reason().is_empty()));
    }
}

#[test]
fn a_slid_object_stays_on_the_table_and_a_poured_one_is_tilted_only_there() {
    let height_and_tilt = |name: &str| {
        let scene = assets::demo(name).unwrap();
        let robot = assets::library().robot(&scene.robot).unwrap();
        let plan = plan_of(run(&mut Pipeline::new(assets::library()), &request(scene.clone())).0).unwrap();
        let up_O = plan.X_WO_start().rotation.inverse() * Vector3::z();
        let at = |phase: &Phase, k: usize| {
            let state = plan.state_at(phase.start_s + phase.trajectory.times_s[k]);
            let X_WO = plan.object_pose(&robot, &state);
            (X_WO.translation.z, (X_WO.rotation * up_O).angle(&Vector3::z()))
        };
        let carried = plan.phases.iter().filter(|phase| phase.carries);
        let samples = carried.flat_map(|phase| (1..phase.trajectory.times_s.len() - 1).map(move |k| (phase, k)));
        let all: Vec<(PhaseKind, (f64, f64))> = samples.map(|(phase, k)| (phase.kind, at(phase, k))).collect();
        (scene, plan.X_WO_start().translation.z, all)
    };
    let (_, start_m, slid) = height_and_tilt("across");
    assert!(slid.iter().all(|(kind, (z, tilt))| *kind == Slide && (z - start_m).abs() < 0.006 && *tilt < 0.02));

    let (scene, _, poured) = height_and_tilt("pour");
    let kept_rad = scene.task.steps[0].keep_upright_rad.unwrap();
    let most = |wanted: PhaseKind| {
        poured.iter().filter(|(kind, _)| *kind == wanted).map(|(_, (_, tilt))| *tilt).fold(0.0, f64::max)
    };
    assert!(most(Lift) < 0.02 && (most(Pour) - 110_f64.to_radians()).abs() < 0.02, "{}", most(Pour));
    let pours = poured.iter().position(|(kind, _)| *kind == Pour).unwrap();
    let before = poured[..pours].iter().map(|(_, (_, tilt))| *tilt).fold(0.0, f64::max);
    assert!(before <= kept_rad + 1e-6, "tilted by {before} rad on the way to the mug, wanted {kept_rad} at most");
}

#[test]
fn a_soft_goal_is_never_worse_than_its_middle_and_different_grasps_choose_different_poses() {
    let soft = assets::demo("box-on").unwrap();
    let mut hard = soft.clone();
    hard.task.steps[0].freedom = Freedom::default();
    let ranked = |scene: Scene| {
        let asked = Request { last: Stage::Rank, ..request(scene) };
        let outputs = run(&mut Pipeline::new(assets::library()), &asked).0;
        outputs.into_iter().find_map(|o| if let Output::Rank(rank) = o { Some(rank) } else { None }).unwrap()
    };
    let (soft, hard) = (ranked(soft), ranked(hard));
    assert!(soft.accepted >= hard.accepted, "{} against {}", soft.accepted, hard.accepted);
    let best = |ranked: &RankOutput| ranked.grasps[0].goal.as_ref().unwrap().m_g;
    assert!(best(&soft) >= best(&hard), "{} against {}", best(&soft), best(&hard));
    let chosen: Vec<_> = soft.grasps[..soft.accepted].iter().map(|grasp| grasp.goal.as_ref().unwrap()).collect();
    assert!(chosen.iter().all(|set| set.poses > 1) && chosen.iter().any(|set| set.X_WO != chosen[0].X_WO));
}

#[test]
fn what_was_tried_in_vain_is_kept_with_its_phase_and_its_place() {
    // The fourth route of the hand squeezes past the box, where the arm cannot follow.
    let mut scene = assets::demo("jar").unwrap();
    (scene.motion.planner, scene.motion.route) = (Planner::Routes, Some(3));
    (scene.motion.max_grasps, scene.motion.regrasp) = (2, false);
    let (_, refused) = run(&mut Pipeline::new(assets::library()), &request(scene));
    let refusal = refused.expect("no grasp follows that route");
    assert_eq!((refusal.tries.len(), refusal.details.len()), (2, 2), "{refusal:?}");
    for (tried, line) in refusal.tries.iter().zip(&refusal.details) {
        assert!(tried.grasp.is_some() && tried.phase == Some(Transport) && tried.carries, "{tried:?}");
        assert!(tried.reason.starts_with("route 4 of") && *line == tried.to_string(), "{tried:?}");
    }
    assert!(refusal.tries.iter().any(|tried| tried.culprits.contains(&"box".to_owned())), "{refusal:?}");
}

#[test]
fn planners_without_random_numbers_do_not_ask_for_the_seed() {
    for planner in [Planner::Roadmap, Planner::Routes] {
        let plan = |motion_seed: u64| {
            let mut scene = assets::demo("mustard").unwrap();
            scene.motion.planner = planner;
            let mut pipeline = Pipeline::new(assets::library());
            let ranked = Request { last: Stage::Rank, ..request(scene.clone()) };
            let (outputs, _) = run(&mut pipeline, &ranked);
            let rank = outputs.into_iter().find_map(|o| if let Output::Rank(rank) = o { Some(rank) } else { None });
            let (cell, rank) = (pipeline.workcell().unwrap(), rank.unwrap());
            let task = LegTask { cell, ranked: &rank.grasps, chosen: None, seed: motion_seed };
            let leg = plan_leg(&task, &scene.motion, Watch::idle()).unwrap();
            serde_json::to_string(&assemble(cell, vec![leg])).unwrap()
        };
        assert_eq!(plan(1), plan(2), "{planner:?}");
    }
}

/// The object alone on the table, in reach of the left arm, to be moved 12 cm outwards.
fn alone(object: &str, robot: &str) -> Scene {
    let base = assets::demo("mustard").expect("the demo is there");
    let object_height = assets::library().object(object).expect("the object is there").half_extents().z;
    let height = base.table.height_m + object_height;
    Scene {
        robot: robot.to_owned(),
        arm: ArmChoice::Left,
        objects: vec![PlacedObject { object: object.to_owned(), X_WO: Isometry3::translation(0.48, 0.20, height) }],
        obstacles: Vec::new(),
        task: Task::place(0, Isometry3::translation(0.46, 0.32, height)),
        ..base
    }
}

#[test]
fn both_robots_place_at_least_eight_objects_without_a_collision() {
    for robot in assets::ROBOT_NAMES {
        let mut placed = Vec::new();
        let mut refusals = Vec::new();
        for object in assets::object_names() {
            let mut pipeline = Pipeline::new(Arc::clone(&assets::library()));
            let (outputs, refused) = run(&mut pipeline, &request(alone(object, robot)));
            match plan_of(outputs) {
                None => refusals.push(format!("{object}: {:?}", refused.map(|r| r.message))),
                Some(plan) => {
                    let hit = pipeline.workcell().unwrap().rewalk(&plan, DENSITY).unwrap();
                    assert_eq!(hit, None, "{robot} with {object}");
                    placed.push(object);
                }
            }
        }
        println!("{robot} placed {} of {}: {placed:?}; {refusals:#?}", placed.len(), placed.len() + refusals.len());
        assert!(placed.len() >= 8, "{robot} placed only {placed:?}; {refusals:#?}");
    }
}

#[test]
fn a_goal_that_cannot_be_reached_is_refused_with_counted_reasons() {
    let scene = assets::demo("mustard").unwrap();
    let task = Task::place(scene.task.object, Isometry3::translation(1.6, 0.0, 0.8));
    let (outputs, refused) = run(&mut Pipeline::new(assets::library()), &request(Scene { task, ..scene }));
    let refusal = refused.unwrap();
    assert!(outputs.iter().any(|output| matches!(output, Output::Rank(_))), "the ranking itself still stands");
    assert!(refusal.message.contains("none of the"), "{refusal:?}");
    assert!(refusal.details.iter().any(|line| line.contains("goal: out of reach")), "{refusal:?}");
}

#[test]
fn a_shape_set_by_hand_is_grasped_without_fitting_again() {
    let scene = assets::demo("mustard").expect("the demo is there");
    let mut pipeline = Pipeline::new(assets::library());
    let fitted = Request { last: Stage::Fit, ..request(scene) };
    let fit_of = |outputs: Vec<Output>| {
        outputs.into_iter().find_map(|output| if let Output::Fit(fit) = output { Some(fit) } else { None }).unwrap()
    };
    let automatic = fit_of(run(&mut pipeline, &fitted).0);
    let target = automatic.target;
    let mut superquadric = automatic.fits[target].as_ref().unwrap().superquadric;
    superquadric.X_FS.translation.vector.x += 0.004;
    let shape = Some(SetShape { cluster: target, superquadric });
    let asked = Request { shape, first: Stage::Fit, last: Stage::Grasps, ..fitted.clone() };

    // Levenberg-Marquardt asks at every step whether it shall stop; the pipeline itself once per stage.
    let asks = std::sync::atomic::AtomicUsize::new(0);
    let counting = || {
        asks.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        false
    };
    let mut outputs = Vec::new();
    pipeline.run(&asked, &Watch::new(&counting, &|_, _| (), &|| 0.0), &mut |update| {
        if let Update::Done { output, .. } = update {
            outputs.push(*output);
        }
    });
    assert!(asks.into_inner() <= 2, "the clusters are not fitted again");
    let [Output::Fit(shaped), Output::Grasps(grasps)] = outputs.as_slice() else { panic!("{}", outputs.len()) };
    let fit = shaped.fits[target].as_ref().unwrap();
    assert_eq!(fit.superquadric, superquadric);
    assert!(fit.radial_m > automatic.fits[target].as_ref().unwrap().radial_m);
    assert_eq!(shaped.automatic.as_ref().unwrap().superquadric, automatic.fits[target].as_ref().unwrap().superquadric);
    assert_eq!(grasps.X_WO_start, superquadric.X_FS, "the hand goes to the shape that was set");
    let mean_m = shaped.distances_m[target].iter().map(|d| d.abs()).sum::<f64>() / fit.points as f64;
    assert!((mean_m - fit.radial_m).abs() < 1e-9, "E_r is the mean of the distances: {mean_m} {}", fit.radial_m);

    let lost = SetShape { cluster: 99, superquadric };
    let (_, refusal) = run(&mut pipeline, &Request { shape: Some(lost), ..fitted });
    assert!(refusal.is_some_and(|refusal| refusal.message.contains("cluster 100 has no fit")));
}
