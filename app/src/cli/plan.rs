//! `plan pick|place`: phases with joint trajectories and timings, or the refusal.

use std::path::PathBuf;

use clap::ValueEnum;
use endcomfort_core::job::{Output, Stage};
use endcomfort_core::task::plan_json_lines;

use super::{Common, Failure, input};
use crate::assets;
use crate::jobs;

#[derive(clap::Args)]
pub(super) struct Args {
    /// What to do with the object.
    task: TaskName,
    /// A demo, a scene file or a cloud file.
    scene: String,
    /// Robot, instead of the scene's own.
    #[arg(long)]
    robot: Option<String>,
    /// Grasp to plan with, by its number; default: in the order of rank until one succeeds.
    #[arg(long)]
    grasp: Option<u32>,
    /// A hand of your own at the acting arm: a hand description (.json).
    #[arg(long)]
    hand: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TaskName {
    /// Grasp and lift.
    Pick,
    /// Grasp, move to the scene's goal and put down.
    Place,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let mut request = input::request(&args.scene, args.robot.as_deref(), common)?;
    match args.task {
        TaskName::Pick => request.scene.task.steps.clear(),
        TaskName::Place if request.scene.task.steps.is_empty() => {
            return Err(Failure::new(format!("{}: the scene has no goal to place at", args.scene)));
        }
        TaskName::Place => {}
    }
    request.grasp = args.grasp;
    if let Some(file) = &args.hand {
        request.scene.set_hand(input::hand(file)?);
    }
    let robot = assets::library().robot_of(&request.scene).map_err(|error| Failure::new(error.to_string()))?;
    let results = jobs::run_until(&request, Stage::Plan)?;
    let Some(Output::Plan(plan)) = results.into_iter().find(|output| matches!(output, Output::Plan(_))) else {
        return Err(Failure::new("the pipeline ended without a plan"));
    };
    if common.json {
        plan_json_lines(&plan, &robot).iter().for_each(|line| println!("{line}"));
        return Ok(());
    }
    println!("{} arm, grasp {}, {:.2} s", plan.arm, plan.grasp().id, plan.duration_s());
    for phase in &plan.phases {
        let clearance = phase.clearance_m.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "  {:9} {:6.2} s … {:6.2} s   clearance {:.0} mm",
            phase.kind.name(),
            phase.start_s,
            phase.start_s + phase.trajectory.duration_s(),
            clearance * 1e3
        );
    }
    for tried in &plan.tries {
        println!("  before it {tried}");
    }
    Ok(())
}
