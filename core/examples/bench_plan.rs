//! Planning on the workloads shared with the measured peers: `cargo run --release --example bench_plan [FOLDER]`.
//!
//! Prints one JSON object per problem set. Timed are the search, shortcutting and timing, apart; making the checker
//! and walking the result (0.01 rad, by the exhaustive judge) are not. A path that the walk finds blocked fails.

use std::error::Error;

use endcomfort_core::collision::{Checker, CollisionModel, Exhaustive, Scratch, World};
use endcomfort_core::plan::{
    ArmSpace, BirrtSettings, MotionLimits, PlanOutcome, ShortcutSettings, TimingSettings, plan_path, shorten,
    time_path, walk, walk_path,
};
use endcomfort_core::rng::Rng;
use endcomfort_core::robot::{Arm, CollisionBody, Geometry, Hand, Joint, JointKind, JointLimit, Link, Robot};
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Unit, Vector3};
use serde::Deserialize;

const SEEDS: u64 = 10;

#[derive(Deserialize)]
struct Work {
    tuck: Vec<f64>,
    goals: Vec<Vec<f64>>,
    boxes_centre_half: Vec<[f64; 6]>,
    cylinders_centre_r_halfheight: Vec<[f64; 5]>,
    capsule_radii: [f64; 4],
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "../shared/bench/arm".to_owned());
    for set in ["plan", "shelf"] {
        let text = std::fs::read_to_string(format!("{folder}/{set}_work.json"))?;
        let work: Work = serde_json::from_str(&text)?;
        let robot = robot(&work.capsule_radii);
        let model = CollisionModel::new(&robot)?;
        let world = world(&work)?;
        check_bench(set, &model, &world)?;
        let pairs = |kind| -> Vec<(&Vec<f64>, &Vec<f64>)> {
            match kind {
                "reach" => work.goals.iter().map(|goal| (&work.tuck, goal)).collect(),
                _ => work.goals.windows(2).map(|pair| (&pair[0], &pair[1])).collect(),
            }
        };
        for kind in ["reach", "transport"] {
            plan_bench(set, kind, &robot, &model, &world, &pairs(kind))?;
        }
    }
    Ok(())
}

/// Time of one state check, of a distance, and of making a checker.
fn check_bench(set: &str, model: &CollisionModel, world: &World) -> Result<(), Box<dyn Error>> {
    let begin = now_ms();
    for _ in 0..100 {
        Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?;
    }
    let make_us = (now_ms() - begin) * 10.0;
    let checker = Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?;
    let mut rng = Rng::new(1, 0);
    let states: Vec<Vec<f64>> = (0..20_000).map(|_| (0..7).map(|_| rng.uniform(-2.1, 2.1)).collect()).collect();
    let mut scratch = Scratch::default();
    let begin = now_ms();
    let free = states.iter().filter(|q| checker.is_free(&mut scratch, q)).count();
    let all_us = (now_ms() - begin) * 1e3 / states.len() as f64;
    let only_free: Vec<_> = states.iter().filter(|q| checker.is_free(&mut scratch, q)).collect();
    let begin = now_ms();
    let again = only_free.iter().filter(|q| checker.is_free(&mut scratch, q)).count();
    let free_us = (now_ms() - begin) * 1e3 / only_free.len() as f64;
    let begin = now_ms();
    let nearest = only_free.iter().map(|q| checker.distance(&mut scratch, q).distance_m).fold(f64::INFINITY, f64::min);
    let distance_us = (now_ms() - begin) * 1e3 / only_free.len() as f64;
    assert!(again == free && nearest >= 0.0);
    println!(
        "{}",
        serde_json::json!({
            "bench": "state", "set": set, "samples": states.len(), "seed": 1, "free_share": free as f64 / states.len() as f64,
            "check_mean_us": all_us, "check_free_mean_us": free_us, "distance_free_mean_us": distance_us,
            "make_checker_us": make_us,
        })
    );
    Ok(())
}

fn plan_bench(
    set: &str,
    kind: &str,
    robot: &Robot,
    model: &CollisionModel,
    world: &World,
    pairs: &[(&Vec<f64>, &Vec<f64>)],
) -> Result<(), Box<dyn Error>> {
    let space = ArmSpace::new(robot, 0, Checker::for_arm(model, world, None, &[], 0, &[0.0; 7])?)?;
    let judge = Exhaustive::new(model, world, None, &[])?;
    let limits = MotionLimits::of(&space);
    let dofs: Vec<usize> = (0..7).collect();
    let (mut plan_ms, mut short_ms, mut time_ms) = (Vec::new(), Vec::new(), Vec::new());
    let (mut found_rad, mut short_rad, mut duration_s) = (Vec::new(), Vec::new(), Vec::new());
    let (mut straight, mut blocked, mut samples) = (0, 0, 0);
    let mut failures = Vec::new();
    for seed in 0..SEEDS {
        for (start, goal) in pairs {
            samples += 1;
            let goals = [(*goal).clone()];
            let begin = now_ms();
            let outcome = plan_path(&space, start, &goals, &BirrtSettings::default(), seed, &Watch::idle());
            plan_ms.push(now_ms() - begin);
            let PlanOutcome::Found(found) = outcome else {
                failures.push(format!("{outcome:?}"));
                continue;
            };
            straight += u32::from(found.nodes == 0);
            let begin = now_ms();
            let short = shorten(&space, &found.path, &ShortcutSettings::default(), seed, &Watch::idle());
            short_ms.push(now_ms() - begin);
            let begin = now_ms();
            let trajectory = time_path(&space, &short, &limits, &TimingSettings::default())?;
            time_ms.push(now_ms() - begin);
            found_rad.push(found.path.length_rad());
            short_rad.push(short.length_rad());
            duration_s.push(trajectory.duration_s());
            for path in [&found.path, &short] {
                blocked += u32::from(walk_path(&judge, &dofs, &[0.0; 7], path, 0.01).is_some());
            }
            if seed == 0 {
                blocked += u32::from(walk(&judge, &dofs, &[0.0; 7], &trajectory, 4).is_some());
            }
        }
    }
    let quantile = |values: &mut Vec<f64>, share: f64| {
        values.sort_by(f64::total_cmp);
        values.get(((values.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN)
    };
    println!(
        "{}",
        serde_json::json!({
            "bench": "plan", "set": set, "kind": kind, "samples": samples, "seeds": SEEDS,
            "success": 1.0 - failures.len() as f64 / f64::from(samples), "straight_share": f64::from(straight) / f64::from(samples),
            "plan_median_ms": quantile(&mut plan_ms, 0.5), "plan_p75_ms": quantile(&mut plan_ms, 0.75),
            "plan_p95_ms": quantile(&mut plan_ms, 0.95), "plan_max_ms": quantile(&mut plan_ms, 1.0),
            "shortcut_median_ms": quantile(&mut short_ms, 0.5), "shortcut_p95_ms": quantile(&mut short_ms, 0.95),
            "timing_median_ms": quantile(&mut time_ms, 0.5), "timing_p95_ms": quantile(&mut time_ms, 0.95),
            "path_median_rad": quantile(&mut found_rad, 0.5), "shortened_median_rad": quantile(&mut short_rad, 0.5),
            "duration_median_s": quantile(&mut duration_s, 0.5), "blocked_on_walk": blocked, "failures": failures,
        })
    );
    if blocked > 0 { Err(format!("{blocked} paths are blocked when walked again").into()) } else { Ok(()) }
}

fn now_ms() -> f64 {
    use std::sync::OnceLock;
    static BEGIN: OnceLock<std::time::Instant> = OnceLock::new();
    #[expect(clippy::disallowed_methods, reason = "a native bench may read the clock")]
    let begin = BEGIN.get_or_init(std::time::Instant::now);
    begin.elapsed().as_secs_f64() * 1e3
}

/// The S-R-S arm of the workload: 0.300 / 0.328 / 0.323 / 0.2024 m, one capsule per segment.
fn robot(radii: &[f64; 4]) -> Robot {
    let pitch = 123.0_f64.to_radians();
    let roll = 170.0_f64.to_radians();
    let chain = [(0.0, true), (0.3, false), (0.0, true), (0.328, false), (0.0, true), (0.323, false), (0.0, true)];
    let mut links = vec![link("base", Some((radii[0], 0.3)))];
    let mut joints = Vec::new();
    let bodies = [None, None, Some((radii[1], 0.328)), None, Some((radii[2], 0.323)), None, Some((radii[3], 0.2024))];
    for (index, ((z, turns), body)) in chain.into_iter().zip(bodies).enumerate() {
        let bound = if turns { roll } else { pitch };
        joints.push(Joint {
            name: format!("j{}", index + 1),
            kind: JointKind::Revolute,
            parent: index,
            child: index + 1,
            X_PJ: Isometry3::translation(0.0, 0.0, z),
            axis: Unit::new_unchecked(if turns { Vector3::z() } else { Vector3::y() }),
            limit: JointLimit { lower: -bound, upper: bound, velocity: 1.0, acceleration: 1.0 },
            mimic: None,
            dof: Some(index),
        });
        links.push(link(&format!("l{}", index + 1), body));
    }
    let hand = Hand {
        name: "hand".to_owned(),
        links: vec![7],
        palm_link: 7,
        tcp_link: 7,
        fingers: Vec::new(),
        open: Vec::new(),
        closed: Vec::new(),
    };
    Robot {
        name: "srs7".to_owned(),
        links,
        joints,
        dof_joints: (0..7).collect(),
        arms: vec![Arm { name: "arm".to_owned(), dofs: (0..7).collect(), base_link: 0, flange_link: 7, hand }],
        postures: Vec::new(),
        allowed_collisions: vec![(0, 3), (3, 5), (5, 7)],
    }
}

fn link(name: &str, capsule: Option<(f64, f64)>) -> Link {
    let collisions = capsule.map(|(radius_m, length_m)| CollisionBody {
        X_LC: Isometry3::translation(0.0, 0.0, 0.5 * length_m),
        geometry: Geometry::Capsule { radius_m, length_m },
    });
    Link { name: name.to_owned(), visuals: Vec::new(), collisions: collisions.into_iter().collect() }
}

fn world(work: &Work) -> Result<World, Box<dyn Error>> {
    let mut world = World::new();
    for (index, [x, y, z, hx, hy, hz]) in work.boxes_centre_half.iter().enumerate() {
        let size = 2.0 * Vector3::new(*hx, *hy, *hz);
        world.add_box(&format!("box_{index}"), size, &Isometry3::translation(*x, *y, *z))?;
    }
    for (index, [x, y, z, radius, half]) in work.cylinders_centre_r_halfheight.iter().enumerate() {
        world.add_cylinder(&format!("can_{index}"), *radius, 2.0 * half, &Isometry3::translation(*x, *y, *z))?;
    }
    Ok(world)
}
