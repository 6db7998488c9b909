//! `plan pick|place|handover`: phases with joint trajectories and timings, or the refusal.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use endcomfort_core::handover::HandoverReport;
use endcomfort_core::job::{Output, Stage};
use endcomfort_core::task::plan_json_lines;

use super::depth_options::DepthOptions;
use super::{Common, Failure, input, motion_options, robot_options, start_options};
use crate::assets;
use crate::export::{MotionFormat, export_motion};
use crate::jobs;

#[derive(clap::Args)]
pub(super) struct Args {
    /// What to do with the object.
    task: TaskName,
    /// A demo, a scene file, a cloud file, a depth image (16-bit PNG) or a mesh (.obj, .stl, .glb).
    scene: String,
    #[command(flatten)]
    robot: robot_options::RobotOptions,
    #[command(flatten)]
    depth: DepthOptions,
    /// Grasp to plan with, by its number; default: in the order of rank until one succeeds.
    #[arg(long)]
    grasp: Option<u32>,
    /// A hand of your own at the acting arm: a hand description (.json).
    #[arg(long)]
    hand: Option<PathBuf>,
    /// File that receives the motion: .csv, .json, .yaml (ROS JointTrajectory) or .glb (the scene, animated).
    #[arg(long, value_parser = motion_file)]
    out: Option<PathBuf>,
    #[command(flatten)]
    start: start_options::Options,
    #[command(flatten)]
    motion: motion_options::Options,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TaskName {
    /// Grasp and lift.
    Pick,
    /// Grasp, and move the object through the scene's steps to its goal.
    Place,
    /// Hand the object over: to the other hand, to another robot, or to a person.
    Handover,
}

fn format_of(file: &Path) -> Option<MotionFormat> {
    MotionFormat::of_extension(file.extension()?.to_str()?)
}

fn motion_file(text: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(text);
    match format_of(&file) {
        Some(_) => Ok(file),
        None => {
            Err(format!("wanted a file that ends in {}", MotionFormat::ALL.map(MotionFormat::extension).join(", ")))
        }
    }
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let mut request = input::request(&args.scene, &args.robot, &args.depth, common)?;
    args.start.apply(&mut request.scene)?;
    match args.task {
        TaskName::Pick => {
            request.scene.task.steps.clear();
            request.scene.handover = None;
        }
        TaskName::Place => request.scene.handover = None,
        TaskName::Handover if request.scene.handover.is_none() => {
            return Err(Failure::new(format!("{}: nobody receives the object in this scene", args.scene)));
        }
        TaskName::Handover => {}
    }
    request.scene = args.motion.apply(request.scene)?;
    if args.task == TaskName::Place && request.scene.task.steps.is_empty() {
        return Err(Failure::new(format!("{}: the scene has no goal to place at; give one with --goal", args.scene)));
    }
    request.grasp = args.grasp;
    if let Some(file) = &args.hand {
        request.scene.set_hand(input::hand(file)?);
    }
    let robot = assets::library().robot_of(&request.scene).map_err(|error| Failure::new(error.to_string()))?;
    let results = jobs::run_until(&request, Stage::Plan)?;
    let Some(Output::Plan(plan)) = results.iter().find(|output| matches!(output, Output::Plan(_))) else {
        return Err(Failure::new("the pipeline ended without a plan"));
    };
    if let Some((file, format)) = args.out.as_ref().and_then(|file| Some((file, format_of(file)?))) {
        let bytes = export_motion(&request.scene, &results, format).map_err(Failure::new)?;
        std::fs::write(file, &bytes).map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
        eprintln!("wrote {} ({} bytes)", file.display(), bytes.len());
    }
    if common.json {
        plan_json_lines(plan, &robot).iter().for_each(|line| println!("{line}"));
        return Ok(());
    }
    let grasps: Vec<String> = plan.legs.iter().map(|leg| leg.grasp.id.to_string()).collect();
    println!("{} arm, grasp {}, {:.2} s", plan.arms().join(" and "), grasps.join(" then "), plan.duration_s());
    for phase in &plan.phases {
        let clearance = phase.clearance_m.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "  {:9} {:6.2} s … {:6.2} s   clearance {:.0} mm, {} to {}",
            phase.kind.name(),
            phase.start_s,
            phase.start_s + phase.trajectory.duration_s(),
            clearance * 1e3,
            phase.closest[0],
            phase.closest[1],
        );
    }
    for (index, route) in plan.routes.iter().enumerate() {
        let fate = match (&route.refused, route.duration_s) {
            (Some(reason), _) => format!("not followed: {reason}"),
            (None, Some(duration_s)) => format!("{duration_s:.2} s"),
            (None, None) => "not tried".to_owned(),
        };
        let (mark, cm, mm) = (if route.chosen { "→" } else { " " }, route.length_m * 1e2, route.clearance_m * 1e3);
        println!("  {mark} route {}: {cm:.0} cm, clearance {mm:.0} mm, {fate}", index + 1);
    }
    if let Some(handover) = &plan.handover {
        print_handover(handover);
    }
    let checked = plan.certificate;
    println!("  walked again: {} states, {} per sample, nothing touches", checked.states, checked.density);
    for tried in &plan.tries {
        println!("  before it {tried}");
    }
    Ok(())
}

/// How the place of a handover was chosen.
fn print_handover(handover: &HandoverReport) {
    let HandoverReport { arms, grasps, voxels, places, chosen, .. } = handover;
    let place = &places[*chosen];
    let p = place.X_WO.translation.vector;
    println!("  {} hands over to {} at {:.2}, {:.2}, {:.2} m", arms[0], arms[1], p.x, p.y, p.z);
    let (line_deg, way_cm) = (place.off_line_rad.to_degrees(), place.off_way_m * 1e2);
    println!(
        "    m_g {:.3} gives, {:.3} takes; {line_deg:.0}° off the line of the shoulders, {way_cm:.0} cm off the way",
        place.m_g[0], place.m_g[1]
    );
    println!(
        "    {} places in {voxels} voxels; {} grasps serve the start, {} the goal",
        places.len(),
        grasps[0],
        grasps[1]
    );
    if let Some(comfort) = &place.comfort {
        println!("    discomfort of the receiver {:.2}", comfort.total);
    }
}
