//! A state to lay out: its numbers are invented and mean nothing.

use std::sync::Arc;

use endcomfort_core::cloud::{PixelGrid, PointCloud};
use endcomfort_core::fit::{Fit, FitSettings, ModelReport, ObjectiveKind, RejectedPoint, RunReport, StopReason};
use endcomfort_core::grasp::{
    Contact, Grasp, GraspSettings, GraspStatus, Obstruction, RankSettings, Score, Situated, Success, Term,
};
use endcomfort_core::job::{
    FitOutput, GraspsOutput, ObjectiveFit, Output, RankOutput, SceneOutput, SegmentOutput, Update,
};
use endcomfort_core::plan::Trajectory;
use endcomfort_core::rng::Rng;
use endcomfort_core::robot::JointLimit;
use endcomfort_core::robot::ik::Arc as ArmArc;
use endcomfort_core::scene::{ArmChoice, Obstacle, PlacedObject, SCENE_VERSION, Scene, TableTop, Task};
use endcomfort_core::segment::{Plane, PointFate, SegmentSettings};
use endcomfort_core::superquadric::Superquadric;
use endcomfort_core::task::{Certificate, Leg, MotionSettings, Phase, PhaseKind, Plan, Route, Try};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use crate::viewer::{Demo, Document, RobotChoice, ViewerState};

pub(super) fn scene(name: &str, title: &str, summary: &str, robot: &str) -> Arc<Scene> {
    let placed = |object: &str, x: f64, y: f64| PlacedObject {
        object: object.to_owned(),
        X_WO: Isometry3::translation(x, y, 0.83),
    };
    Arc::new(Scene {
        version: SCENE_VERSION,
        name: name.to_owned(),
        title: title.to_owned(),
        summary: summary.to_owned(),
        robot: robot.to_owned(),
        arm: ArmChoice::Right,
        posture: "home".to_owned(),
        joints: std::collections::BTreeMap::new(),
        table: TableTop { center_m: [0.75, 0.0], size_m: [0.8, 1.4], height_m: 0.74, thickness_m: 0.04 },
        objects: vec![placed("tall_glass", 0.6, -0.2), placed("soup_can", 0.7, 0.2), placed("cracker_box", 0.8, 0.0)],
        obstacles: vec![Obstacle {
            name: "shelf board".to_owned(),
            size_m: Vector3::new(0.2, 0.3, 0.02),
            X_WB: Isometry3::translation(0.8, 0.4, 1.0),
        }],
        X_WC: Isometry3::from_parts(
            Vector3::new(0.1, 0.0, 1.5).into(),
            UnitQuaternion::from_euler_angles(-2.2, 0.0, -1.57),
        ),
        task: Task::place(0, Isometry3::translation(0.62, 0.24, 0.83)),
        seed: 7,
        segment: SegmentSettings::default(),
        fit: FitSettings::default(),
        grasp: GraspSettings::default(),
        rank: RankSettings::default(),
        motion: MotionSettings::default(),
        torso: false,
        handover: None,
        hand: None,
    })
}

pub(super) fn fresh() -> ViewerState {
    let demos: Vec<Demo> = [
        (
            "mustard",
            "Alita picks the mustard bottle",
            "A gripper, a bottle in a row of neighbours, one way that fits.",
            "alita",
        ),
        (
            "jar",
            "Crichton moves a jar onto a box",
            "Three fingers around a jar that has to end up on top of a box.",
            "crichton",
        ),
        (
            "glass",
            "Upside-down glass",
            "The glass stands on its rim. Turned over at the goal, an awkward grasp now is the easy one then.",
            "crichton",
        ),
    ]
    .into_iter()
    .map(|(name, title, summary, robot)| Demo {
        name: name.to_owned(),
        scene: scene(name, title, summary, robot),
        thumbnail: None,
    })
    .collect();
    let robots = ["Crichton", "Alita"].map(|title| RobotChoice {
        name: title.to_lowercase(),
        title: title.to_owned(),
        posture: "home".to_owned(),
    });
    let mut state = ViewerState::new(Document::new(demos[2].scene.clone()), demos, robots.to_vec());
    state.demo = Some("glass".to_owned());
    state
}

/// A state in which all stages are done.
pub(super) fn planned() -> ViewerState {
    let mut state = fresh();
    for (elapsed_ms, output) in outputs() {
        done(&mut state, elapsed_ms, output);
    }
    let _announced = state.receive(Update::Finished { revision: state.revision });
    state
}

pub(super) fn done(state: &mut ViewerState, elapsed_ms: f64, output: Output) {
    let revision = state.revision;
    let _announced = state.receive(Update::Done { revision, elapsed_ms, output: Box::new(output) });
}

pub(super) fn outputs() -> Vec<(f64, Output)> {
    let mut rng = Rng::new(3, 0);
    let mut random = move || rng.unit();
    let points: Vec<Point3<f64>> = (0..6766).map(|_| Point3::new(random(), random(), 0.75)).collect();
    let clusters: Vec<Vec<Point3<f64>>> = [1820, 1204, 640].map(|n| points[..n].to_vec()).to_vec();
    let mut fates = vec![PointFate::Table; points.len()];
    for (range, fate) in [
        (0..3664, PointFate::Cluster(0)),
        (3664..3800, PointFate::TooLow),
        (3800..3990, PointFate::OffTable),
        (3990..4020, PointFate::SmallCluster),
    ] {
        fates[range].fill(fate);
    }
    let fit = |a: f64| fit(a, &points);
    let distances: Vec<Vec<f64>> = [1820, 1204, 0]
        .map(|n| (0..n).map(|i| 0.0012 * ((i as f64 * 0.7).sin() + (i as f64 * 1.3).cos())).collect())
        .to_vec();
    let candidates = candidates();
    let mut handled = candidates.clone();
    for grasp in handled
        .iter_mut()
        .filter(|grasp| matches!(grasp.status, GraspStatus::NoIkAtGoal { .. } | GraspStatus::NoIkAtStart { .. }))
    {
        grasp.status = GraspStatus::Accepted;
    }
    for grasp in &mut handled {
        (grasp.start, grasp.goal) = (None, None);
    }
    let accepted = candidates.iter().filter(|grasp| grasp.status == GraspStatus::Accepted).count();
    vec![
        (
            2.1,
            Output::Scene(SceneOutput {
                cloud: PointCloud {
                    points: points.clone(),
                    colors: Vec::new(),
                    grid: Some(PixelGrid { width: 640, height: 480, pixels: Vec::new() }),
                    X_FC: None,
                },
                notes: vec!["Seen by the simulated camera with the noise of a Carmine 1.09.".to_owned()],
            }),
        ),
        (
            9.0,
            Output::Segment(SegmentOutput {
                table: Plane { normal: Vector3::z_axis(), offset_m: 0.7402 },
                fates,
                clusters,
                target: 0,
            }),
        ),
        (
            3.2,
            Output::Fit(FitOutput {
                fits: vec![Ok(fit(0.0351)), Ok(fit(0.04)), Err("Only 24 points are left after thinning.".to_owned())],
                target: 0,
                distances_m: distances,
                automatic: None,
            }),
        ),
        (
            14.0,
            Output::Grasps(GraspsOutput {
                arm: "right".to_owned(),
                grasps: handled,
                X_WO_start: Isometry3::translation(0.6, -0.2, 0.81),
                X_WO_goal: Some(Isometry3::translation(0.62, 0.24, 0.81)),
            }),
        ),
        (21.4, Output::Rank(RankOutput { grasps: candidates.clone(), accepted })),
        (6.3, Output::Plan(Box::new(plan(candidates[0].clone())))),
    ]
}

/// A fit of a cluster with semi-axis a, metres.
pub(super) fn fit(a: f64, points: &[Point3<f64>]) -> Fit {
    Fit {
        superquadric: Superquadric {
            a,
            b: 0.0347,
            c: 0.0661,
            e1: 0.24,
            e2: 0.98,
            X_FS: Isometry3::translation(0.6, -0.2, 0.81),
            taper: 0.0,
            bend_per_m: 0.0,
        },
        radial_m: 0.000_82,
        goodness_of_fit: 0.0143,
        goodness_of_fit_abs: 0.0871,
        volume_m3: 4.1e-4,
        iterations: 84,
        points: 1820,
        used_points: 212,
        mirrored: points[..106].to_vec(),
        mirror_note: "Mirrored across the plane through the axis, 12° from the line of sight; 106 points were added."
            .to_owned(),
        runs: (1..=9)
            .map(|i| RunReport {
                name: format!("principal box, axis {i} as z"),
                points: 212,
                rms: (0..(6 + i % 5)).map(|k| 0.0008 * f64::from(i) + 0.012 * 0.45_f64.powi(k as i32)).collect(),
                iterations: 20 + i,
                stop: if i == 4 { StopReason::IterationLimit } else { StopReason::Converged },
            })
            .collect(),
        rejected: points[..14]
            .iter()
            .map(|p_F| RejectedPoint { p_F: *p_F, distance_m: 0.021, limit_m: 0.0083 })
            .collect(),
        models: [("plain", -1204.0, 0.0019, false), ("taper", -1239.5, 0.0011, true), ("bend", -1198.1, 0.0019, false)]
            .map(|(name, criterion, rms_m, is_chosen)| ModelReport { name: name.into(), criterion, rms_m, is_chosen })
            .to_vec(),
        others: Vec::new(),
    }
}

/// What a comparison of the objectives sends.
pub(super) fn objectives(revision: u64) -> Vec<Update> {
    let made = |(index, objective): (usize, ObjectiveKind)| {
        let fit = if objective == ObjectiveKind::Ichim {
            Err("the cluster has 9 finite points, a fit wants at least 12".to_owned())
        } else {
            let factor = 1.0 + 0.37 * index as f64;
            let plain = fit(0.0351 * factor, &[Point3::origin(); 200]);
            Ok(Fit { radial_m: 0.000_82 * factor, goodness_of_fit: 0.0143 / factor, ..plain })
        };
        let row = ObjectiveFit { cluster: 0, objective, fit };
        let output = Box::new(Output::Objective(Box::new(row)));
        Update::Done { revision, elapsed_ms: 3.2 + 11.0 * index as f64, output }
    };
    let rows = ObjectiveKind::ALL.into_iter().enumerate().map(made);
    rows.chain([Update::Finished { revision }]).collect()
}

fn candidates() -> Vec<Grasp> {
    let situated = |m_g: f64, ik_count: usize| Situated {
        X_WO: Isometry3::identity(),
        poses: 1,
        m_g,
        ik_count,
        with_ways: Vec::new(),
        solutions: vec![vec![0.1; 7]; ik_count],
        manipulability: (0..ik_count)
            .map(|i| m_g + 0.5 * m_g * ((i as f64 * 0.7).sin() + (i as f64 * 1.3).cos()) / 2.0)
            .collect(),
        rejected: vec![(Obstruction::JointLimit { joint: 6 }, 40), (elbow_meets_table(), 12)],
        feasible: [(0, -2.1, 0.4), (1, 2.2, 4.0), (4, -0.8, 1.9), (4, 2.3, 2.6), (7, -3.0, 3.2)]
            .map(|(branch, from, to)| ArmArc { branch, from, to })
            .to_vec(),
    };
    (0..412_u32)
        .map(|i| {
            let status = match i {
                0..37 => GraspStatus::Accepted,
                _ => match i % 6 {
                    0 => GraspStatus::NoIkAtGoal { reason: Obstruction::JointLimit { joint: 6 } },
                    1 => GraspStatus::HitsTable { link: "right thumb".to_owned() },
                    2 => GraspStatus::TooFewContacts { found: 2, wanted: 3 },
                    3 => GraspStatus::HitsNeighbour { link: "palm".to_owned(), neighbour: "cluster 2".to_owned() },
                    4 => GraspStatus::TooWide { width_m: 0.131, opening_m: 0.1 },
                    _ => GraspStatus::NoIkAtStart { reason: Obstruction::OutOfReach { gap_m: 0.04 } },
                },
            };
            let rank = f64::from(i);
            let (start, goal) = match &status {
                GraspStatus::Accepted => (
                    Some(situated(0.041 + 0.001 * (rank * 0.9).sin(), 80)),
                    Some(situated(0.093 - 0.0015 * rank, 108 - i as usize)),
                ),
                GraspStatus::NoIkAtGoal { .. } => (
                    Some(situated(0.066, 71)),
                    Some(Situated {
                        rejected: vec![(Obstruction::JointLimit { joint: 6 }, 96)],
                        ..Situated::default()
                    }),
                ),
                _ => (None, None),
            };
            let contact = |link: &str| Contact {
                p_O: Point3::new(0.03, 0.0, 0.0),
                n_O: Vector3::x(),
                penetration_m: 0.0004 * (link.len() as f64 - 5.0),
                link: link.to_owned(),
            };
            let score = || Score {
                total: 0.86 - 0.01 * rank,
                terms: [
                    ("m_g_goal", 1.0, 0.98),
                    ("m_g_start", 0.5, 0.61),
                    ("success", 0.5, 0.9),
                    ("clearance", 0.0, 0.2),
                ]
                .map(|(name, weight, share)| Term { name: name.to_owned(), weight, share })
                .to_vec(),
            };
            Grasp {
                id: (i * 131) % 412,
                part: 0,
                X_OH: Isometry3::rotation(Vector3::new(0.3, 2.0 + 0.3 * rank.sin(), 0.4 * rank.cos())),
                closed: vec![0.5; 7],
                contacts: vec![contact("thumb"), contact("finger 1"), contact("finger 2"), contact("palm")],
                width_m: 0.071,
                epsilon: 0.21 - 0.001 * rank / 4.0,
                volume: Some(0.08),
                success: (i < 37).then(|| Success { held: 20 - i % 9, trials: 20 }),
                clearance_m: (i < 80).then(|| 0.012 + 0.001 * rank.sin()),
                score: (i < 37).then(score),
                start,
                via: Vec::new(),
                goal,
                status,
            }
        })
        .collect()
}

fn plan(grasp: Grasp) -> Plan {
    let robot = crate::assets::library().robot("crichton").expect("it travels inside the program");
    let arm = robot.arm("right").expect("it has two arms");
    let dofs: Vec<usize> = arm.dofs.iter().chain(arm.hand.fingers.iter().flatten()).copied().collect();
    let limits = dofs.iter().map(|&dof| robot.joints[robot.dof_joints[dof]].limit);
    let limits: Vec<JointLimit> = limits.collect();
    let waves = |t: f64| -> Vec<f64> {
        let wave = |(k, limit): (usize, &JointLimit)| {
            let u = 0.5 + 0.10 * (0.45 * t + 1.3 * k as f64).sin();
            limit.lower + u * (limit.upper - limit.lower)
        };
        limits.iter().enumerate().map(wave).collect()
    };
    // Slow at both ends: every phase starts and ends at rest.
    let eased = |u: f64| u * u * (3.0 - 2.0 * u);
    let (mut start_s, mut moved_s) = (0.0, 0.0);
    let kinds = [
        (PhaseKind::Reach, 3.5),
        (PhaseKind::Close, 0.6),
        (PhaseKind::Lift, 0.5),
        (PhaseKind::Transport, 3.9),
        (PhaseKind::Place, 0.4),
        (PhaseKind::Open, 0.5),
        (PhaseKind::Retreat, 2.0),
    ];
    let phases = kinds
        .into_iter()
        .map(|(kind, length_s)| {
            // The arm stands still in short phases.
            let goes_s = if length_s > 1.0 { length_s } else { 0.0 };
            let times_s: Vec<f64> = (0..=60).map(|i| length_s * f64::from(i) / 60.0).collect();
            let at = |t: &f64| 0.06 + 0.03 * (0.9 * (start_s + t)).sin();
            let phase = Phase {
                kind,
                leg: 0,
                start_s,
                carries: matches!(kind, PhaseKind::Lift | PhaseKind::Transport | PhaseKind::Place),
                manipulability: times_s.iter().map(at).collect(),
                closest: ["right_thumb".to_owned(), "table".to_owned()],
                clearance_m: times_s.iter().map(|t| 0.02 + 0.5 * at(t)).collect(),
                trajectory: Trajectory {
                    positions: times_s.iter().map(|t| waves(moved_s + goes_s * eased(t / length_s))).collect(),
                    times_s,
                },
            };
            start_s += length_s;
            moved_s += goes_s;
            phase
        })
        .collect();
    Plan {
        legs: vec![Leg {
            arm: "right".to_owned(),
            tcp_link: arm.hand.tcp_link,
            grasp,
            X_WO_start: Isometry3::identity(),
            X_WO_end: Isometry3::identity(),
        }],
        phases,
        q_start: robot.posture("home").expect("it waits there").to_vec(),
        dofs,
        tries: tries(&waves(6.0)),
        routes: routes(),
        handover: None,
        certificate: Certificate { states: 1640, density: 4 },
    }
}

/// What was tried in vain, in a posture of arm and fingers.
pub(super) fn tries(q: &[f64]) -> Vec<Try> {
    [
        (131, PhaseKind::Transport, "the carried glass meets the cracker box", ["object", "cracker box"], true),
        (
            262,
            PhaseKind::Transport,
            "right_upper_arm_link meets the shelf board on every way that was found",
            ["right_upper_arm_link", "shelf board"],
            true,
        ),
        (393, PhaseKind::Retreat, "no straight way: right_palm meets the table", ["right_palm", "table"], false),
    ]
    .map(|(grasp, phase, reason, culprits, carries)| Try {
        grasp: Some(grasp),
        phase: Some(phase),
        reason: reason.to_owned(),
        culprits: culprits.map(str::to_owned).to_vec(),
        q: q.to_vec(),
        carries,
        arm: None,
        X_WO: None,
    })
    .to_vec()
}

fn routes() -> Vec<Route> {
    let bow = |side: f64, up: f64| -> Vec<Point3<f64>> {
        let at = |k: i32| {
            let u = f64::from(k) / 12.0;
            let bump = (std::f64::consts::PI * u).sin();
            Point3::new(0.6 + side * bump, -0.2 + 0.44 * u, 0.9 + up * bump)
        };
        (0..=12).map(at).collect()
    };
    let route = |points_W, length_m, clearance_m, duration_s: Option<f64>, chosen| Route {
        points_W,
        length_m,
        clearance_m,
        duration_s,
        refused: duration_s.is_none().then(|| "joint 6 reaches its limit after 0.31 m".to_owned()),
        chosen,
    };
    vec![
        route(bow(0.0, 0.2), 0.612, 0.041, Some(3.42), true),
        route(bow(-0.25, 0.05), 0.743, 0.058, Some(4.1), false),
        route(bow(0.3, 0.05), 0.811, 0.022, None, false),
    ]
}

fn elbow_meets_table() -> Obstruction {
    Obstruction::Collision { a: "elbow".to_owned(), b: "table".to_owned() }
}
