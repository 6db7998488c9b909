//! `grasps`: the ranked grasps of an object that stands on the robot's table.

use std::path::PathBuf;

use endcomfort_core::grasp::{ExportFormat, Grasp, Quantity};
use endcomfort_core::job::{GraspsOutput, Output, RankOutput, Request, Stage};
use endcomfort_core::scene::{ArmChoice, PlacedObject, Scene, Task};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde_json::json;

use super::depth_options::DepthOptions;
use super::grasp_options::Options;
use super::{ArmName, Common, Failure, input, robot_options};
use crate::clock::stopwatch;
use crate::export::export_grasps;
use crate::{assets, jobs};

#[derive(clap::Args)]
pub(super) struct Args {
    /// A household object by name, a demo, a scene file, a cloud file, a depth image (16-bit PNG) or a mesh (.obj, .stl,
    /// .glb).
    object: String,
    #[command(flatten)]
    robot: robot_options::RobotOptions,
    #[command(flatten)]
    depth: DepthOptions,
    /// Arm.
    #[arg(long, value_enum)]
    arm: Option<ArmName>,
    /// Goal of the object: x,y,z in metres, optionally followed by a rotation qx,qy,qz,qw.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    place: Option<Vec<f64>>,
    /// A hand of your own at the acting arm: a hand description (.json).
    #[arg(long)]
    hand: Option<PathBuf>,
    /// Prints only the first N.
    #[arg(long)]
    top: Option<usize>,
    /// Leaves the rejected candidates out.
    #[arg(long)]
    accepted: bool,
    /// Writes the grasps to a file: .json with everything, .csv as a table, .yaml as MoveIt messages.
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let mut request = if assets::object_names().contains(&args.object.as_str()) {
        request_for_object(args, common)?
    } else {
        input::request(&args.object, &args.robot, &args.depth, common)?
    };
    if let Some(arm) = args.arm {
        request.scene.arm = arm.into();
    }
    if let Some(file) = &args.hand {
        request.scene.set_hand(input::hand(file)?);
    }
    if let Some(goal) = goal(args)? {
        request.scene.task = Task::place(request.scene.task.object, goal);
    }
    request.scene = args.options.apply(request.scene)?;
    let format = args.out.as_ref().map(|path| {
        ExportFormat::of_file(&path.to_string_lossy()).ok_or_else(|| {
            Failure::new(format!("--out: found {:?}, wanted a name that ends in .json, .csv or .yaml", path.display()))
        })
    });
    let format = format.transpose()?;
    let stopwatch = stopwatch();
    let results = jobs::run_until(&request, Stage::Rank)?;
    let elapsed_ms = stopwatch();
    let (mut found, mut ranked) = (None, None);
    for result in results {
        match result {
            Output::Grasps(output) => found = Some(output),
            Output::Rank(output) => ranked = Some(output),
            _ => {}
        }
    }
    let (Some(found), Some(ranked)) = (found, ranked) else {
        return Err(Failure::new("the pipeline ended without a ranking"));
    };
    let listed = if args.accepted { ranked.accepted } else { ranked.grasps.len() };
    let listed = listed.min(args.top.unwrap_or(usize::MAX));
    for (index, grasp) in ranked.grasps.iter().enumerate().take(listed) {
        let rank = (index < ranked.accepted).then_some(index + 1);
        if common.json {
            println!("{}", grasp_json(rank, grasp, elapsed_ms));
        } else {
            print_grasp(rank, grasp);
        }
    }
    eprintln!("{} of {} grasps accepted in {elapsed_ms:.0} ms", ranked.accepted, ranked.grasps.len());
    if let (Some(path), Some(format)) = (&args.out, format) {
        write(path, &request, &found, &ranked, listed, format)?;
        eprintln!("written to {}", path.display());
    }
    Ok(())
}

/// Writes the listed grasps to a file.
fn write(
    path: &std::path::Path,
    request: &Request,
    found: &GraspsOutput,
    ranked: &RankOutput,
    listed: usize,
    format: ExportFormat,
) -> Result<(), Failure> {
    let grasps = &ranked.grasps[..listed];
    let text = export_grasps(&request.scene, request.cloud.as_ref(), found, grasps, format).map_err(Failure::new)?;
    std::fs::write(path, text).map_err(|error| Failure::new(format!("{}: {error}", path.display())))
}

/// The object alone on the table, in front of the arm that shall grasp it.
fn request_for_object(args: &Args, common: &Common) -> Result<Request, Failure> {
    let mut request = input::request(assets::DEMOS[0], &args.robot, &args.depth, common)?;
    let base = &request.scene;
    let object = assets::library().object(&args.object).map_err(|error| Failure::new(error.to_string()))?;
    let arm: ArmChoice = args.arm.map_or(base.arm, Into::into);
    let side = if arm == ArmChoice::Left { 1.0 } else { -1.0 };
    let height = base.table.height_m + object.half_extents().z;
    let X_WO = Isometry3::translation(0.50, 0.25 * side, height);
    request.scene = Scene {
        name: args.object.clone(),
        title: object.title.clone(),
        arm,
        objects: vec![PlacedObject { object: args.object.clone(), X_WO }],
        obstacles: Vec::new(),
        task: Task::pick(0),
        ..request.scene
    };
    Ok(request)
}

fn goal(args: &Args) -> Result<Option<Isometry3<f64>>, Failure> {
    let Some(numbers) = &args.place else { return Ok(None) };
    let (position, rotation) = match numbers.as_slice() {
        [x, y, z] => (Translation3::new(*x, *y, *z), UnitQuaternion::identity()),
        [x, y, z, qx, qy, qz, qw] => {
            let quaternion = UnitQuaternion::try_new(Quaternion::new(*qw, *qx, *qy, *qz), 1e-6)
                .ok_or_else(|| Failure::new("--place: the rotation has length 0"))?;
            (Translation3::new(*x, *y, *z), quaternion)
        }
        other => return Err(Failure::new(format!("--place: found {} numbers, wanted 3 or 7", other.len()))),
    };
    if !numbers.iter().all(|n| n.is_finite()) {
        return Err(Failure::new("--place: every number must be finite"));
    }
    Ok(Some(Isometry3::from_parts(position, rotation)))
}

fn grasp_json(rank: Option<usize>, grasp: &Grasp, elapsed_ms: f64) -> serde_json::Value {
    let matrix = grasp.X_OH.to_homogeneous();
    let rows: Vec<f64> = (0..16).map(|k| matrix[(k / 4, k % 4)]).collect();
    json!({
        "rank": rank, "object_from_hand": rows,
        "m_g_start": grasp.start.as_ref().map(|s| s.m_g), "m_g_goal": grasp.goal.as_ref().map(|s| s.m_g),
        "ik_count_start": grasp.start.as_ref().map_or(0, |s| s.ik_count),
        "ik_count_goal": grasp.goal.as_ref().map_or(0, |s| s.ik_count),
        "contacts": grasp.contacts.len(), "epsilon": grasp.epsilon, "width_m": grasp.width_m,
        "status": grasp.status.name(), "reason": grasp.status.reason(), "elapsed_ms": elapsed_ms,
        "id": grasp.id, "part": grasp.part, "m_g_mean": Quantity::MgMean.of(grasp),
        "score": Quantity::Score.of(grasp), "gws_volume": Quantity::Volume.of(grasp),
        "success_probability": Quantity::Success.of(grasp), "clearance_m": grasp.clearance_m,
    })
}

fn print_grasp(rank: Option<usize>, grasp: &Grasp) {
    let rank = rank.map_or_else(|| "–".to_owned(), |r| r.to_string());
    let m_g = |s: &Option<endcomfort_core::grasp::Situated>| {
        s.as_ref().map_or_else(|| "     –".to_owned(), |s| format!("{:.4}", s.m_g))
    };
    println!(
        "{rank:>4}  grasp {:>4}  m_g start {}  goal {}  contacts {:>2}  ε {:.3}  width {:>3.0} mm  {} {}",
        grasp.id,
        m_g(&grasp.start),
        m_g(&grasp.goal),
        grasp.contacts.len(),
        grasp.epsilon,
        grasp.width_m * 1e3,
        grasp.status.name(),
        grasp.status.reason()
    );
}
