//! Planning on the workloads shared with the measured peers.
//!
//! `cargo bench -p endcomfort-core --bench plan [-- FOLDER]`, FOLDER holding `srs7.urdf`, `plan_work.json` and
//! `shelf_work.json`. Timed are the search, shortcutting and timing, apart; making the checker and walking the result
//! (0.01 rad, by the exhaustive judge) are not. Every timed trajectory is walked too, at four configurations per sample,
//! and its samples are held against the limits. What is blocked or beyond a limit fails the bench. A number behind the
//! folder plans so many seeds instead of ten.
#![allow(non_snake_case, reason = "frame letters")]

#[path = "common/arm.rs"]
mod arm;
#[path = "common/report.rs"]
mod report;
#[path = "common/workload.rs"]
mod workload;

use std::error::Error;
use std::path::Path;

use arm::{Work, robot, world};
use endcomfort_core::collision::{CarriedObject, Checker, CollisionModel, ConvexHull, Exhaustive, Scratch, World};
use endcomfort_core::plan::{
    ArmSpace, BirrtSettings, MotionLimits, PlanOutcome, ShortcutSettings, TimingSettings, Upright, plan_path, shorten,
    time_path, walk, walk_path,
};
use endcomfort_core::rng::Rng;
use endcomfort_core::robot::ik::ArmIk;
use endcomfort_core::robot::{Robot, load_robot};
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use report::{Report, now_ms};

/// Seeds unless told.
const SEEDS: u64 = 10;
const STATES: usize = 20_000;

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = workload::folder("arm", "plan_work.json") else { return Ok(()) };
    let robot = robot(&folder)?;
    let model = CollisionModel::new(&robot)?;
    let seeds = workload::number().unwrap_or(SEEDS);
    let mut report = Report::new("plan", format!("0..{seeds}"));
    let mut blocked = 0;
    for set in ["plan", "shelf"] {
        let work: Work = serde_json::from_str(&std::fs::read_to_string(folder.join(format!("{set}_work.json")))?)?;
        let world = world(&work)?;
        bench_states(set, &model, &world, &mut report)?;
        let reach: Vec<_> = work.goals.iter().map(|goal| (&work.tuck, goal)).collect();
        let transport: Vec<_> = work.goals.windows(2).map(|pair| (&pair[0], &pair[1])).collect();
        for (kind, pairs) in [("reach", reach), ("transport", transport)] {
            blocked += bench_plans(&format!("{set}, {kind}"), &robot, &model, &world, &pairs, &mut report)?;
        }
        for (held, axis_H) in [("pointing down", -Vector3::z()), ("level", Vector3::x())] {
            for degrees in [10.0, 20.0, 45.0_f64] {
                let problem = format!("{set}, upright {degrees}°, {held}");
                blocked += bench_upright(&problem, &robot, &model, &world, &axis_H, degrees.to_radians(), &mut report)?;
            }
        }
    }
    bench_cloud(&model, &mut report)?;
    for name in ["crichton", "alita"] {
        bench_robot(name, &mut report)?;
    }
    report.print();
    if blocked > 0 { Err(format!("{blocked} paths are blocked when walked again").into()) } else { Ok(()) }
}

/// The making of a checker of the bench arm, then [`time_states`].
fn bench_states(set: &str, model: &CollisionModel, world: &World, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let mut make_us = Vec::new();
    for _ in 0..100 {
        let begin_ms = now_ms();
        std::hint::black_box(Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?);
        make_us.push((now_ms() - begin_ms) * 1e3);
    }
    report.add(set, "make the checker", "µs", make_us, "");
    let checker = Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?;
    time_states(set, &checker, &|rng| (0..7).map(|_| rng.uniform(-2.1, 2.1)).collect(), report)
}

/// Checks drawn states one by one, in batches, and their distances.
fn time_states(
    set: &str,
    checker: &Checker,
    draw: &dyn Fn(&mut Rng) -> Vec<f64>,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let mut rng = Rng::new(1, 0);
    let states: Vec<Vec<f64>> = (0..STATES).map(|_| draw(&mut rng)).collect();
    let mut scratch = Scratch::default();
    let free: Vec<&Vec<f64>> = states.iter().filter(|q| checker.is_free(&mut scratch, q)).collect();
    let mut batches = |states: &[&Vec<f64>], check: &mut dyn FnMut(&mut Scratch, &[f64])| -> Vec<f64> {
        states
            .chunks(100)
            .map(|batch| {
                let begin_ms = now_ms();
                batch.iter().for_each(|q| check(&mut scratch, q));
                (now_ms() - begin_ms) * 1e3 / batch.len() as f64
            })
            .collect()
    };
    let all: Vec<&Vec<f64>> = states.iter().collect();
    let mut is_free = |scratch: &mut Scratch, q: &[f64]| {
        std::hint::black_box(checker.is_free(scratch, q));
    };
    let (any_us, free_us) = (batches(&all, &mut is_free), batches(&free, &mut is_free));
    let in_batches = |states: &[&Vec<f64>], scratch: &mut Scratch| -> Vec<f64> {
        let mut check = |batch: &[&Vec<f64>]| {
            let begin_ms = now_ms();
            std::hint::black_box(checker.surely_free(scratch, batch));
            (now_ms() - begin_ms) * 1e6 / batch.len() as f64
        };
        states.chunks(400).map(&mut check).collect()
    };
    let (any_ns, free_ns) = (in_batches(&all, &mut Scratch::default()), in_batches(&free, &mut Scratch::default()));
    let passed = checker.surely_free(&mut Scratch::default(), &free).into_iter().filter(|sure| *sure).count();
    let passed = format!("{:.1} % of the free ones pass", 100.0 * passed as f64 / free.len() as f64);
    let mut nearest_m = f64::INFINITY;
    let distance_us =
        batches(&free, &mut |scratch, q| nearest_m = nearest_m.min(checker.distance(scratch, q).distance_m));
    let share = format!("{:.0} % of {STATES} states free", 100.0 * free.len() as f64 / STATES as f64);
    report.add(set, "check any state", "µs", any_us, share);
    report.add(set, "check a free state", "µs", free_us, "");
    report.add(set, "check any state in batches", "ns", any_ns, "");
    report.add(set, "check a free state in batches", "ns", free_ns, passed);
    report.add(set, "distance of a free state", "µs", distance_us, format!("least {:.1} mm", nearest_m * 1e3));
    if nearest_m < 0.0 { Err("a free state is in collision".into()) } else { Ok(()) }
}

/// A bowl of points around the arm's base, as the boxes of its occupied cells.
fn bench_cloud(model: &CollisionModel, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let mut rng = Rng::new(2, 0);
    let points: Vec<Point3<f64>> = (0..60_000)
        .map(|_| Point3::from(rng.direction().component_mul(&Vector3::new(0.8, 0.8, 0.8)) * rng.uniform(0.99, 1.01)))
        .filter(|p| p.x > 0.2)
        .collect();
    let mut world = World::new();
    let count = world.add_cloud("bowl", &points, 0.02)?;
    let set = format!("cloud of {} boxes", count.boxes);
    bench_states(&set, model, &world, &mut *report)
}

/// One arm of a robot of ours above a table with five cans, carrying a can of many corners.
fn bench_robot(name: &str, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let text = |end: &str| std::fs::read_to_string(folder.join(name).join(format!("{name}.{end}")));
    let mesh = |file: &str| std::fs::read(folder.join("meshes").join(file.rsplit('/').next()?)).ok();
    let robot = load_robot(&text("urdf")?, &text("srdf")?, &mesh)?.value;
    let model = CollisionModel::new(&robot)?;
    let mut world = World::new();
    world.add_box("table", Vector3::new(0.75, 1.5, 0.04), &Isometry3::translation(0.7, 0.0, 0.67))?;
    let can: Vec<Point3<f64>> = (0..400)
        .map(|k| {
            let (sin, cos) = endcomfort_core::math::sin_cos(0.1 * f64::from(k));
            Point3::new(0.035 * cos, 0.035 * sin, if k % 2 == 0 { -0.06 } else { 0.06 })
        })
        .collect();
    let can = ConvexHull::new("can", &can)?;
    for k in 0..5 {
        let place = Isometry3::translation(0.6, 0.2 * f64::from(k) - 0.4, 0.75);
        world.add_hull(&format!("can_{k}"), &can, &place)?;
    }
    let carried = CarriedObject::new("carried", &[can], &Isometry3::identity(), &robot, 0)?;
    let q_rest = robot.postures.first().map_or_else(|| vec![0.0; robot.dof_joints.len()], |(_, q)| q.clone());
    let checker = Checker::for_arm(&model, &world, Some(&carried), &[], 0, &q_rest)?;
    let limits: Vec<_> = checker.dofs().iter().map(|&dof| robot.joints[robot.dof_joints[dof]].limit).collect();
    let draw = |rng: &mut Rng| limits.iter().map(|l| rng.uniform(l.lower, l.upper)).collect();
    time_states(&format!("{name}, carrying"), &checker, &draw, report)
}

/// Plans every pair with every seed; gives how many paths are blocked when walked again.
fn bench_plans(
    problem: &str,
    robot: &Robot,
    model: &CollisionModel,
    world: &World,
    pairs: &[(&Vec<f64>, &Vec<f64>)],
    report: &mut Report,
) -> Result<u32, Box<dyn Error>> {
    let space = ArmSpace::new(robot, 0, Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?)?;
    let judge = Exhaustive::new(model, world, None, &[])?;
    let limits = MotionLimits::of(&space);
    // Crichton's arm: about 0.43 rad/s and 0.4 rad/s².
    let slow = MotionLimits { velocity: vec![0.43; 7], acceleration: vec![0.4; 7], jerk: vec![4.0; 7] };
    let dofs: Vec<usize> = (0..7).collect();
    let (mut plan_ms, mut short_ms, mut time_ms) = (Vec::new(), Vec::new(), Vec::new());
    let (mut found_rad, mut short_rad) = (Vec::new(), Vec::new());
    let mut durations_s = [const { Vec::new() }; 4];
    let (mut straight, mut blocked, mut beyond) = (0, 0, 0);
    for seed in 0..workload::number().unwrap_or(SEEDS) {
        for (start, goal) in pairs {
            let goals = [(*goal).clone()];
            let begin_ms = now_ms();
            let outcome = plan_path(&space, start, &goals, &BirrtSettings::default(), seed, &Watch::idle());
            plan_ms.push(now_ms() - begin_ms);
            let PlanOutcome::Found(found) = outcome else { continue };
            straight += u32::from(found.nodes == 0);
            let begin_ms = now_ms();
            let short = shorten(&space, &found.path, &ShortcutSettings::default(), seed, &Watch::idle());
            short_ms.push(now_ms() - begin_ms);
            let begin_ms = now_ms();
            let trajectory = time_path(&space, &short, &limits, &TimingSettings::default())?;
            time_ms.push(now_ms() - begin_ms);
            found_rad.push(found.path.length_rad());
            short_rad.push(short.length_rad());
            for (which, limits) in
                [&limits, &without_jerk(&limits), &slow, &without_jerk(&slow)].into_iter().enumerate()
            {
                let trajectory = time_path(&space, &short, limits, &TimingSettings::default())?;
                durations_s[which].push(trajectory.duration_s());
                blocked += u32::from(limits.first_violation(&trajectory).is_some());
            }
            for path in [&found.path, &short] {
                blocked += u32::from(walk_path(&judge, &dofs, &[0.0; 7], path, 0.01).is_some());
            }
            blocked += u32::from(walk(&judge, &dofs, &[0.0; 7], &trajectory, 4).is_some());
            beyond += u32::from(limits.first_violation(&trajectory).is_some());
        }
    }
    let note = format!(
        "{} of {} found, {straight} straight, {blocked} blocked, {beyond} beyond limits",
        found_rad.len(),
        plan_ms.len()
    );
    report.add(problem, "search", "ms", plan_ms, note);
    report.add(problem, "shortcut", "ms", short_ms, "");
    report.add(problem, "timing", "ms", time_ms, "");
    report.add(problem, "path as found", "rad", found_rad, "");
    report.add(problem, "path after shortcut", "rad", short_rad, "");
    let whats = ["duration", "duration, any jerk", "duration at 0.4 rad/s²", "duration at 0.4 rad/s², any jerk"];
    for (what, duration_s) in whats.into_iter().zip(durations_s) {
        report.add(problem, what, "s", duration_s, "");
    }
    Ok(blocked + beyond)
}

/// Transports between seeded upright configurations with the hand in front of the arm: the hand points down or lies level.
fn bench_upright(
    problem: &str,
    robot: &Robot,
    model: &CollisionModel,
    world: &World,
    axis_H: &Vector3<f64>,
    max_tilt_rad: f64,
    report: &mut Report,
) -> Result<u32, Box<dyn Error>> {
    let upright = Upright::new(robot, 0, &[0.0; 7], axis_H, max_tilt_rad)?;
    let checker = Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?;
    let space = ArmSpace::new(robot, 0, checker)?.keeping_upright(upright);
    let judge = Exhaustive::new(model, world, None, &[])?;
    let ik = ArmIk::of(robot, &robot.arms[0])?;
    let dofs: Vec<usize> = (0..7).collect();
    let mut rng = Rng::new(6, 0);
    let mut scratch = Scratch::default();
    let axis_to_z = UnitQuaternion::rotation_between(axis_H, &Vector3::z())
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let mut ends: Vec<Vec<f64>> = Vec::new();
    while ends.len() < 51 {
        let place = Vector3::new(rng.uniform(0.35, 0.75), rng.uniform(-0.5, 0.5), rng.uniform(0.15, 0.8));
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rng.uniform(0.0, std::f64::consts::TAU));
        let postures = ik.set(&Isometry3::from_parts(place.into(), turned * axis_to_z), &[0.0; 7], 16);
        let free: Vec<&[f64]> = postures.iter().filter(|q| space.checker.is_free(&mut scratch, q)).collect();
        if !free.is_empty() {
            ends.push(free[rng.index(free.len())].to_vec());
        }
    }
    let (mut plan_ms, mut short_ms, mut time_ms) = (Vec::new(), Vec::new(), Vec::new());
    let (mut found_rad, mut short_rad, mut most_rad, mut faulty) = (Vec::new(), Vec::new(), 0.0_f64, 0);
    for (seed, pair) in ends.windows(2).enumerate() {
        let seed = seed as u64;
        let begin_ms = now_ms();
        let outcome = plan_path(&space, &pair[0], &[pair[1].clone()], &BirrtSettings::default(), seed, &Watch::idle());
        plan_ms.push(now_ms() - begin_ms);
        let PlanOutcome::Found(found) = outcome else { continue };
        let begin_ms = now_ms();
        let short = shorten(&space, &found.path, &ShortcutSettings::default(), seed, &Watch::idle());
        short_ms.push(now_ms() - begin_ms);
        let begin_ms = now_ms();
        let trajectory = time_path(&space, &short, &MotionLimits::of(&space), &TimingSettings::default())?;
        time_ms.push(now_ms() - begin_ms);
        found_rad.push(found.path.length_rad());
        short_rad.push(short.length_rad());
        for points in [found.path.points, short.points, trajectory.positions] {
            for pair in points.windows(2) {
                let steps = (pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()).sum::<f64>() / 0.005).ceil();
                for k in 0..=steps as usize {
                    let u = k as f64 / steps.max(1.0);
                    let q: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| a + (b - a) * u).collect();
                    let axis_W = robot.link_poses(&q)[robot.arms[0].hand.tcp_link].rotation * axis_H;
                    most_rad = most_rad.max(axis_W.angle(&Vector3::z()));
                }
            }
            let path = endcomfort_core::plan::Path { points };
            faulty += u32::from(walk_path(&judge, &dofs, &[0.0; 7], &path, 0.01).is_some());
        }
    }
    faulty += u32::from(most_rad > max_tilt_rad + Upright::TOLERANCE_RAD);
    let (found, tried, tilt) = (found_rad.len(), plan_ms.len(), most_rad.to_degrees());
    report.add(
        problem,
        "upright search",
        "ms",
        plan_ms,
        format!("{found} of {tried} found, tilted by {tilt:.1}° at most"),
    );
    report.add(problem, "upright shortcut", "ms", short_ms, "");
    report.add(problem, "upright timing", "ms", time_ms, "");
    report.add(problem, "upright path as found", "rad", found_rad, "");
    report.add(problem, "upright path after shortcut", "rad", short_rad, "");
    Ok(faulty)
}

/// The same limits with as much jerk as the samples can show.
fn without_jerk(limits: &MotionLimits) -> MotionLimits {
    MotionLimits { jerk: vec![1e9; limits.jerk.len()], ..limits.clone() }
}
