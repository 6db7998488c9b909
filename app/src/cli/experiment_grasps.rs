//! `experiment`, the tables on grasps and plans: `prioritization`, `grasps` and `motion`.

use endcomfort_core::experiment::{
    FeasibleRow, GraspExperiment, GraspExperimentSettings, HandoverRow, MotionRow, Pace, PriorityRow, Record, Summary,
    run_feasible, run_handover, run_motion, run_prioritization, thesis_handover,
};

use super::experiment::{Args, digits, watched, write_records};
use super::table::Table;
use super::{Common, Failure};
use crate::assets;
use crate::clock::stopwatch;
use endcomfort_core::task::Planner;

/// Scenes that handovers are drawn around.
const HANDOVERS: [&str; 4] = ["butler", "stool", "kneeling", "human"];

pub(super) fn run(experiment: GraspExperiment, args: &Args, common: &Common) -> Result<(), Failure> {
    if let Some(option) = args.fitting_options().first() {
        let name = experiment.name();
        return Err(Failure::new(format!("{option}: experiment {name} has no use for it, it fits nothing")));
    }
    if !args.scenario.is_empty() && experiment != GraspExperiment::Handover {
        return Err(Failure::new("--scenario: only experiment handover has scenarios"));
    }
    let settings = settings(args, common)?;
    let elapsed_ms = stopwatch();
    match experiment {
        GraspExperiment::Prioritization => {
            let outcome = watched(&elapsed_ms, |watch| run_prioritization(&settings, watch))
                .map_err(|refusal| Failure::new(refusal.to_string()))?;
            write(args, common, &outcome.rows, &outcome.cases)?;
            if !common.json {
                print_head(experiment, &settings, elapsed_ms() * 1e-3);
                print_prioritization(&outcome.rows);
            }
        }
        GraspExperiment::Grasps => {
            if args.trials.is_some() || args.clutter.is_some() || args.any_way {
                return Err(Failure::new(
                    "--trials, --clutter, --any-way: experiment grasps has its own poses, nothing is drawn",
                ));
            }
            let outcome = watched(&elapsed_ms, |watch| run_feasible(&settings, watch))
                .map_err(|refusal| Failure::new(refusal.to_string()))?;
            write(args, common, &outcome.rows, &outcome.cases)?;
            if !common.json {
                print_head(experiment, &settings, elapsed_ms() * 1e-3);
                print_feasible(&outcome.rows);
            }
        }
        GraspExperiment::Handover => {
            let outcome = watched(&elapsed_ms, |watch| run_handover(&settings, watch))
                .map_err(|refusal| Failure::new(refusal.to_string()))?;
            write(args, common, &outcome.rows, &outcome.cases)?;
            if !common.json {
                print_head(experiment, &settings, elapsed_ms() * 1e-3);
                print_handover(&outcome.rows);
            }
        }
        GraspExperiment::Motion => {
            let outcome = watched(&elapsed_ms, |watch| run_motion(&settings, watch))
                .map_err(|refusal| Failure::new(refusal.to_string()))?;
            write(args, common, &outcome.rows, &outcome.cases)?;
            if !common.json {
                print_head(experiment, &settings, elapsed_ms() * 1e-3);
                print_motion(&outcome.rows);
            }
        }
    }
    Ok(())
}

fn settings(args: &Args, common: &Common) -> Result<GraspExperimentSettings, Failure> {
    let robots = match args.robot.as_deref() {
        Some(robot) if !assets::ROBOT_NAMES.contains(&robot) => {
            return Err(Failure::new(format!("no robot {robot:?}; there are {}", assets::ROBOT_NAMES.join(" and "))));
        }
        Some(robot) => vec![robot.to_owned()],
        None => assets::ROBOT_NAMES.map(str::to_owned).to_vec(),
    };
    Ok(GraspExperimentSettings {
        library: assets::library(),
        robots,
        objects: assets::object_names().into_iter().map(str::to_owned).collect(),
        trials: args.trials,
        clutter: args.clutter.unwrap_or(0),
        any_way: args.any_way,
        scenes: HANDOVERS.iter().filter_map(|name| assets::demo(name)).collect(),
        scenarios: args.scenario.clone(),
        planner: args.planner.map(Planner::from).unwrap_or_default(),
        seed: common.seed.unwrap_or(1),
        pace: match (args.serial, args.in_turn) {
            (true, _) => Pace::OneProcessor,
            (false, true) => Pace::InTurn,
            (false, false) => Pace::SideBySide,
        },
    })
}

fn write<R: Record, C: Record>(args: &Args, common: &Common, rows: &[R], cases: &[C]) -> Result<(), Failure> {
    if let Some(file) = &args.out {
        write_records(file, rows)?;
    }
    if let Some(file) = &args.fits {
        write_records(file, cases)?;
    }
    if common.json {
        rows.iter().for_each(|row| println!("{}", row.json()));
    }
    Ok(())
}

fn print_head(experiment: GraspExperiment, settings: &GraspExperimentSettings, elapsed_s: f64) {
    println!("{}: {}", experiment.name(), experiment.about());
    let threads = match settings.pace {
        Pace::SideBySide => "cases side by side, so without times",
        Pace::InTurn => "one case after the other on all processors",
        Pace::OneProcessor => "one case after the other on one processor",
    };
    let boxes = match settings.clutter {
        0 => String::from("nothing else on the table"),
        count => format!("{count} boxes beside the object"),
    };
    let objects = settings.objects.len();
    println!("{objects} known objects, {boxes}, seed {}, {threads}, {elapsed_s:.1} s\n", settings.seed);
}

/// The rows of Table 5.1 for a person, each followed by the thesis's own where it has one.
fn print_prioritization(rows: &[PriorityRow]) {
    let heads = vec![
        "",
        "robot",
        "condition",
        "order",
        "first works",
        "%",
        "95 %",
        "tried",
        "planning s",
        "grasps",
        "set aside",
    ];
    let mut table = Table::new(4, heads);
    let three = |summary: Option<Summary>| {
        let text = |s: Summary| format!("{} / {} / {}", digits(s.mean), digits(s.median), digits(s.p95));
        summary.map(text).unwrap_or_default()
    };
    for row in rows {
        let [low, high] = row.success_interval_percent;
        let excluded = row.excluded;
        table.push(vec![
            String::new(),
            row.robot.clone(),
            row.condition.name().to_owned(),
            row.metric.name().to_owned(),
            format!("{}/{}", row.success, row.trials),
            format!("{:.1}", row.success_percent()),
            format!("{low:.1} … {high:.1}"),
            three(row.tried),
            three(row.planning_time_s),
            row.accepted.map(|s| digits(s.mean)).unwrap_or_default(),
            format!("{} + {} + {} + {}", excluded.hand, excluded.start, excluded.goal, excluded.path),
        ]);
        if let Some(thesis) = &row.thesis {
            let mut line = vec![String::new(); 11];
            line[0] = String::from("thesis");
            line[2] = row.condition.name().to_owned();
            line[3] = row.metric.name().to_owned();
            line[4] = format!("{}/{}", thesis.success, thesis.trials);
            line[5] = format!("{:.1}", 100.0 * thesis.success / thesis.trials as f64);
            line[8] = format!("{:.2} / - / -", thesis.planning_time_s);
            table.push(line);
        }
    }
    println!("{table}");
    println!(
        "first works: cases in which the grasp that the order puts first yields both paths; 95 %: Wilson's interval."
    );
    println!("tried, planning: until a grasp worked, mean / median / 95 % of the cases. grasps: usable at both poses.");
    println!(
        "set aside, as in the thesis: cases that no grasp solves, because the hand cannot hold the object + none is"
    );
    println!("reached at the start + none can be used at both poses + no grasp yields all paths.");
    println!("thesis: its own numbers for the same table, not measured here.");
}

/// Whole plans on random cases, for a person.
fn print_motion(rows: &[MotionRow]) {
    let heads = vec![
        "robot",
        "condition",
        "cases",
        "planned",
        "regrasped",
        "tries",
        "fit → plan ms",
        "plan ms",
        "trajectories",
        "blocked",
        "beyond limits",
        "duration s",
        "clearance mm",
    ];
    let mut table = Table::new(2, heads);
    let two = |summary: Option<Summary>, scale: f64| {
        summary.map(|s| format!("{} / {}", digits(scale * s.median), digits(scale * s.p95))).unwrap_or_default()
    };
    for row in rows {
        let [trajectories, blocked, beyond_limits] = row.trajectories;
        table.push(vec![
            row.robot.clone(),
            row.condition.name().to_owned(),
            row.trials.to_string(),
            format!("{}/{}", row.success, row.solvable),
            row.regrasped.to_string(),
            row.tries.map(|s| digits(s.mean)).unwrap_or_default(),
            two(row.fit_to_plan_ms, 1.0),
            two(row.plan_ms, 1.0),
            trajectories.to_string(),
            blocked.to_string(),
            beyond_limits.to_string(),
            two(row.duration_s, 1.0),
            two(row.clearance_m, 1e3),
        ]);
    }
    println!("{table}");
    println!("planned: of the cases in which some grasp can be used at both poses; regrasped: further ones, with the");
    println!("object put down in between. tries: grasps that failed before, mean. Two numbers: median / 95 %.");
    println!("blocked, beyond limits: found by walking every trajectory again at 4 configurations per sample with");
    println!("bodies and kinematics of its own, and by differences of its samples.");
}

/// How many grasps each object offers each robot, for a person.
fn print_feasible(rows: &[FeasibleRow]) {
    let heads =
        vec!["robot", "object", "poses", "10 or more", "best", "mean", "median", "not accepted at the best pose"];
    let mut table = Table::new(2, heads);
    for row in rows {
        table.push(vec![
            row.robot.clone(),
            row.object.clone(),
            row.poses.to_string(),
            row.enough.to_string(),
            row.best.accepted.to_string(),
            row.accepted.map(|s| digits(s.mean)).unwrap_or_default(),
            row.accepted.map(|s| digits(s.median)).unwrap_or_default(),
            row.best.reasons_text(),
        ]);
    }
    println!("{table}");
    println!("best, mean, median: grasps that the arm reaches without collision, over the poses of a grid in front of");
    println!("both arms (2 distances, 2 sides, 2 headings each).");
}

/// The rows of Table 6.1 for a person, each followed by the thesis's own where it has one.
fn print_handover(rows: &[HandoverRow]) {
    let heads = vec![
        "",
        "scenario",
        "order",
        "success",
        "plan ms",
        "95 %",
        "grasps ms",
        "giver",
        "receiver",
        "places",
        "m receiver",
        "gain",
        "motions",
        "blocked",
    ];
    let mut table = Table::new(3, heads);
    let whole = |summary: Option<Summary>| summary.map(|s| format!("{:.0}", s.mean)).unwrap_or_default();
    let pair = |m: Option<[f64; 2]>| m.map(|[mean, half]| format!("{mean:.4} ± {half:.4}")).unwrap_or_default();
    for row in rows {
        table.push(vec![
            "here".to_owned(),
            row.scenario.clone(),
            if row.receiver_first { "receiver first" } else { "nearest to the way" }.to_owned(),
            format!("{}/{}", row.success, row.trials),
            row.plan_ms.map(|s| digits(s.mean)).unwrap_or_default(),
            row.plan_ms.map(|s| digits(s.p95)).unwrap_or_default(),
            row.synthesis_ms.map(|s| digits(s.mean)).unwrap_or_default(),
            whole(row.giver_grasps),
            whole(row.receiver_grasps),
            whole(row.places),
            pair(row.receiver_manipulability),
            pair(row.gain),
            row.blocked[1].to_string(),
            row.blocked[0].to_string(),
        ]);
        if let Some(thesis) = thesis_handover(&row.scenario).filter(|_| row.receiver_first) {
            let [giver, receiver, places] = thesis.counts.map(|count| count.to_string());
            let (success, plan_ms) = (format!("{}/100", thesis.success), digits(1e3 * thesis.plan_s));
            let nothing = String::new;
            table.push(vec![
                "thesis".to_owned(),
                row.scenario.clone(),
                nothing(),
                success,
                plan_ms,
                nothing(),
                nothing(),
                giver,
                receiver,
                places,
                nothing(),
                nothing(),
                nothing(),
                nothing(),
            ]);
        }
    }
    println!("{table}");
    println!("\nplan ms: mean, from candidate grasps to the timed plan; grasps ms: their synthesis for both hands");
    println!("m receiver: manipulability of the receiver's arm when its hand has closed; ±: 95 % confidence");
}
