//! Planning without random numbers: diverse hand routes that the arm follows, and a roadmap, on the workloads shared with
//! the measured peers.
//!
//! `cargo bench -p endcomfort-core --bench routes [-- FOLDER]`, FOLDER holding `srs7.urdf`, `plan_work.json` and
//! `shelf_work.json`. Transports: the hand goes from where goal i puts it to where goal i + 1 puts it; the arm begins at
//! goal i, or in any posture that puts the hand there, and ends in any posture. Nothing is random, so every pair is
//! asked once. A path that the walk (0.01 rad, by the exhaustive judge) finds blocked fails the bench.
#![allow(non_snake_case, reason = "frame letters")]

#[path = "common/arm.rs"]
mod arm;
#[path = "common/report.rs"]
mod report;
#[path = "common/workload.rs"]
mod workload;

use std::error::Error;

use arm::{Work, robot, world};
use endcomfort_core::collision::{BallChecker, Checker, CollisionModel, Exhaustive, World};
use endcomfort_core::plan::{
    ArmSpace, BirrtSettings, FollowReason, FollowSettings, FollowingArm, FreeSpace, PlanOutcome, Roadmap,
    RoadmapSettings, RouteSettings, diverse_routes, follow_route, plan_by_roadmap, plan_path, walk_path,
};
use endcomfort_core::robot::Robot;
use endcomfort_core::robot::ik::ArmIk;
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Point3};
use report::{Report, now_ms};

/// Nodes of the roadmap.
const ROADMAP_NODES: usize = 4096;
/// Radius of the ball around the hand, metres; the hand's capsule has 0.045.
const BALL_M: f64 = 0.05;
const CELL_M: f64 = 0.025;
/// Nearer to the shoulder no route leads, metres.
const INNER_M: f64 = 0.22;
/// Least straight ways out and in that are tried, metres.
const RETREATS_M: [f64; 2] = [0.0, 0.15];

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = workload::folder("arm", "plan_work.json") else { return Ok(()) };
    let robot = robot(&folder)?;
    let model = CollisionModel::new(&robot)?;
    let mut report = Report::new("routes", "none");
    let mut blocked = 0;
    for set in ["plan", "shelf"] {
        let work: Work = serde_json::from_str(&std::fs::read_to_string(folder.join(format!("{set}_work.json")))?)?;
        for any_start in [false, true] {
            blocked += bench_routes(set, any_start, &robot, &model, &work, &mut report)?;
        }
    }
    let begin_ms = now_ms();
    let (lower, upper) = space_limits(&robot);
    let roadmap = Roadmap::new(&lower, &upper, ROADMAP_NODES);
    report.add("any scene", "make the roadmap", "ms", [now_ms() - begin_ms], format!("{ROADMAP_NODES} nodes"));
    for set in ["plan", "shelf"] {
        let work: Work = serde_json::from_str(&std::fs::read_to_string(folder.join(format!("{set}_work.json")))?)?;
        let reach: Vec<_> = work.goals.iter().map(|goal| (&work.tuck, goal)).collect();
        let transport: Vec<_> = work.goals.windows(2).map(|pair| (&pair[0], &pair[1])).collect();
        for (kind, pairs) in [("reach", reach), ("transport", transport)] {
            let problem = format!("{set}, {kind}");
            blocked += bench_roadmap(&problem, &robot, &model, &world(&work)?, &roadmap, &pairs, &mut report)?;
        }
    }
    report.print();
    if blocked > 0 { Err(format!("{blocked} paths are blocked when walked again").into()) } else { Ok(()) }
}

/// Plans every pair on the roadmap, and with ten seeds at random; gives how many paths are blocked when walked again.
fn bench_roadmap(
    problem: &str,
    robot: &Robot,
    model: &CollisionModel,
    world: &World,
    roadmap: &Roadmap,
    pairs: &[(&Vec<f64>, &Vec<f64>)],
    report: &mut Report,
) -> Result<u32, Box<dyn Error>> {
    let space = ArmSpace::new(robot, 0, Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?)?;
    let judge = Exhaustive::new(model, world, None, &[])?;
    let (mut map_ms, mut random_ms, mut map_rad, mut random_rad) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut blocked = 0;
    for (start, goal) in pairs {
        let goals = [(*goal).clone()];
        let begin_ms = now_ms();
        let outcome = plan_by_roadmap(&space, roadmap, start, &goals, &RoadmapSettings::default(), &Watch::idle());
        map_ms.push(now_ms() - begin_ms);
        if let PlanOutcome::Found(found) = outcome {
            map_rad.push(found.path.length_rad());
            blocked += u32::from(walk_path(&judge, space.checker.dofs(), &[0.0; 7], &found.path, 0.01).is_some());
        }
        for seed in 0..10 {
            let begin_ms = now_ms();
            let outcome = plan_path(&space, start, &goals, &BirrtSettings::default(), seed, &Watch::idle());
            random_ms.push(now_ms() - begin_ms);
            if let PlanOutcome::Found(found) = outcome {
                random_rad.push(found.path.length_rad());
            }
        }
    }
    let note = format!("{} of {} found, {blocked} blocked", map_rad.len(), map_ms.len());
    report.add(problem, "on the roadmap", "ms", map_ms, note);
    let note = format!("{} of {} found, seeds 0..10", random_rad.len(), random_ms.len());
    report.add(problem, "IK-BiRRT", "ms", random_ms, note);
    report.add(problem, "path on the roadmap", "rad", map_rad, "");
    report.add(problem, "path of IK-BiRRT", "rad", random_rad, "");
    Ok(blocked)
}

/// Limits of the arm's joints, rad.
fn space_limits(robot: &Robot) -> (Vec<f64>, Vec<f64>) {
    let limits = || robot.arms[0].dofs.iter().map(|&dof| &robot.joints[robot.dof_joints[dof]].limit);
    (limits().map(|limit| limit.lower).collect(), limits().map(|limit| limit.upper).collect())
}

/// Routes of all transports; gives how many paths are blocked when walked again.
fn bench_routes(
    set: &str,
    any_start: bool,
    robot: &Robot,
    model: &CollisionModel,
    work: &Work,
    report: &mut Report,
) -> Result<u32, Box<dyn Error>> {
    let world = world(work)?;
    let space = ArmSpace::new(robot, 0, Checker::for_arm(model, &world, None, &[], 0, &[0.0; 7])?)?;
    let judge = Exhaustive::new(model, &world, None, &[])?;
    let ik = ArmIk::of(robot, &robot.arms[0])?;
    let watch = Watch::idle();
    let ball = BallChecker::new(&world, BALL_M);
    let room = |p: &Point3<f64>| ball.clearance_m(p);
    let shoulder = Point3::from(ik.chain().origin());
    let mut grid_ms = Vec::new();
    for _ in 0..10 {
        let begin_ms = now_ms();
        std::hint::black_box(FreeSpace::new(&shoulder, [INNER_M, ik.chain().reach_m()], CELL_M, &room));
        grid_ms.push(now_ms() - begin_ms);
    }
    let free = FreeSpace::new(&shoulder, [INNER_M, ik.chain().reach_m()], CELL_M, &room);
    let (mut routes_ms, mut found_ms, mut failed_ms, mut pair_ms) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut lengths_m, mut turned_rad) = (Vec::new(), Vec::new());
    let (mut refused, mut one, mut two, mut blocked, mut found_routes) = (0, 0, 0, 0, 0);
    let mut reasons: Vec<(String, usize)> = Vec::new();
    let mut evenly = 0;
    let pairs = work.goals.len() - 1;
    for pair in work.goals.windows(2) {
        let [from, to] = [0, 1].map(|k| robot.link_poses(&pair[k])[robot.arms[0].hand.tcp_link]);
        let mut starts = vec![pair[0].clone()];
        if any_start {
            starts.extend(ik.set(&from, &pair[0], 36).iter().map(<[f64]>::to_vec));
        }
        let arm = FollowingArm { ik: &ik, X_WB: Isometry3::identity(), starts: &starts, goals: None };
        let mut followed_here = 0;
        let mut reasons_here = Vec::new();
        let begin_pair_ms = now_ms();
        for least_retreat_m in RETREATS_M {
            let settings = RouteSettings { least_retreat_m, ..RouteSettings::default() };
            let begin_ms = now_ms();
            let routes = diverse_routes(&free, &from, &to, &settings, &watch);
            routes_ms.push(now_ms() - begin_ms);
            let Ok(routes) = routes else {
                refused += 1;
                continue;
            };
            found_routes += routes.len();
            let mut here = 0;
            for route in &routes {
                let begin_ms = now_ms();
                let followed = follow_route(&space, &arm, route, &FollowSettings::default(), &watch);
                let took_ms = now_ms() - begin_ms;
                match followed {
                    Ok(followed) => {
                        found_ms.push(took_ms);
                        here += 1;
                        lengths_m.push(route.length_m);
                        turned_rad.push(followed.followed.path.length_rad());
                        evenly += usize::from(followed.poses == route.poses());
                        let path = &followed.followed.path;
                        blocked += u32::from(walk_path(&judge, space.checker.dofs(), &[0.0; 7], path, 0.01).is_some());
                    }
                    Err(stop) => {
                        failed_ms.push(took_ms);
                        let reason = match stop.reason {
                            FollowReason::NoIk(reject) => format!("no ik: {}", reject.reason()),
                            FollowReason::Blocked(hit) => hit.to_string(),
                            FollowReason::Jump { joint, .. } => format!("jump of {joint}"),
                            other => format!("{other:?}"),
                        };
                        reasons_here.push(reason);
                    }
                }
            }
            followed_here = followed_here.max(here);
            if followed_here > 1 {
                break;
            }
        }
        pair_ms.push(now_ms() - begin_pair_ms);
        if followed_here == 0 {
            reasons_here.into_iter().for_each(|reason| count(&mut reasons, reason));
        }
        one += usize::from(followed_here > 0);
        two += usize::from(followed_here > 1);
    }
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    reasons.truncate(5);
    let set = &format!("{set}, {} start", if any_start { "any" } else { "one" });
    if !any_start {
        report.add(set, "free voxels", "ms", grid_ms, format!("{} free cells", free.free_cells()));
        report.add(set, "diverse routes", "ms", routes_ms, format!("{found_routes} routes, {refused} refusals"));
    }
    report.add(set, "follow a route", "ms", found_ms, format!("{blocked} blocked, {evenly} turning evenly"));
    report.add(set, "refuse a route", "ms", failed_ms, format!("pairs without any: {reasons:?}"));
    let note = format!("of {pairs} pairs {one} with a followed route, {two} with two or more");
    report.add(set, "everything for a pair", "ms", pair_ms, note);
    report.add(set, "length of a followed route", "m", lengths_m, "");
    report.add(set, "its joint motion", "rad", turned_rad, "");
    Ok(blocked)
}

fn count(counts: &mut Vec<(String, usize)>, what: String) {
    match counts.iter_mut().find(|(known, _)| *known == what) {
        Some((_, count)) => *count += 1,
        None => counts.push((what, 1)),
    }
}
