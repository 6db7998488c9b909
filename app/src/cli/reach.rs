//! `reach`: builds the reachability map of a robot's arms, or says what is in a map's file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ValueEnum;
use endcomfort_core::reach::{
    About, ForwardSettings, InverseSettings, ReachError, ReachMap, build_forward, build_inverse,
};
use endcomfort_core::robot::Robot;
use endcomfort_core::watch::Watch;
use serde_json::json;

use super::experiment::watched;
use super::robot_options::{ArmOptions, hand_over};
use super::{Common, Failure, input};
use crate::clock::stopwatch;
use crate::{assets, brought};

#[derive(clap::Args)]
pub(super) struct Args {
    /// A robot (crichton, alita, or yours: a URDF, a folder, a .zip), of which maps are built, or the file of a map, which
    /// is read and checked.
    #[arg(value_name = "ROBOT_OR_FILE")]
    what: String,
    /// Which arm.
    #[arg(long, value_enum, default_value = "both")]
    arm: Arms,
    /// Edge length of the voxels, metres.
    #[arg(long, value_name = "M", default_value_t = 0.05)]
    voxel: f64,
    /// Orientations of the hand that are told apart: 40 or 272; 1 for a map of positions alone (forward).
    #[arg(long, value_name = "N", default_value_t = 40)]
    orientations: usize,
    /// Solve every pose for the joints, or draw configurations and see where they lead. Default: inverse where the arm
    /// has a closed form and orientations are told apart.
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Configurations that are drawn (forward).
    #[arg(long, value_name = "N")]
    samples: Option<usize>,
    /// The joints before the arm turn as well.
    #[arg(long)]
    torso: bool,
    /// File that receives the map; for both arms the arm's name is put before its extension.
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    own: ArmOptions,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Arms {
    Left,
    Right,
    Both,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    Inverse,
    Forward,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let path = Path::new(&args.what);
    let robot = if assets::ROBOT_NAMES.contains(&args.what.as_str()) {
        args.own.refuse_alone()?;
        robot(&args.what)?
    } else if brought::disk::is_robot(path) {
        let mut scene = input::demo(assets::DEMOS[0])?;
        let guest = args.own.guest(path, &scene.table)?;
        hand_over(&mut scene, &guest)?;
        robot(&scene.robot)?
    } else {
        args.own.refuse_alone()?;
        return read(path, common);
    };
    for (index, arm) in robot.arms.iter().enumerate().filter(|(_, arm)| args.arm.holds(&arm.name)) {
        let elapsed_ms = stopwatch();
        let refuse = |error: ReachError| Failure::new(format!("{}, arm {}: {error}", args.what, arm.name));
        let of_torso = args.torso.then(|| robot.with_torso(index));
        let robot = of_torso.as_ref().unwrap_or(&robot);
        let map = watched(&elapsed_ms, |watch| build(robot, index, args, common, watch)).map_err(refuse)?;
        let build_ms = elapsed_ms();
        let bytes = map.to_bytes();
        print(&map, bytes.len(), ("build_ms", build_ms), common);
        if let Some(out) = &args.out {
            let path = if args.arm == Arms::Both { with_arm(out, &arm.name) } else { out.clone() };
            std::fs::write(&path, &bytes).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
            eprintln!("wrote {}", path.display());
        }
    }
    Ok(())
}

impl Arms {
    fn holds(self, name: &str) -> bool {
        match self {
            Self::Left => name == "left",
            Self::Right => name == "right",
            Self::Both => true,
        }
    }
}

fn robot(name: &str) -> Result<Arc<Robot>, Failure> {
    assets::library().robot(name).map_err(|error| Failure::new(error.to_string()))
}

fn build(robot: &Robot, arm: usize, args: &Args, common: &Common, watch: Watch<'_>) -> Result<ReachMap, ReachError> {
    let (voxel_m, orientations) = (args.voxel, args.orientations);
    let draws = args.samples.is_some() || orientations == 1;
    if args.method != Some(Method::Forward) && (args.method.is_some() || !draws) {
        let inverse = build_inverse(robot, arm, &InverseSettings { voxel_m, orientations }, watch);
        let has_none = matches!(inverse, Err(ReachError::NoClosedForm { .. } | ReachError::TooManyJoints { .. }));
        if args.method.is_some() || !has_none {
            return inverse;
        }
    }
    let default = ForwardSettings::default();
    let samples = args.samples.unwrap_or(default.samples);
    let seed = common.seed.unwrap_or(default.seed);
    build_forward(robot, arm, &ForwardSettings { voxel_m, orientations, samples, seed }, watch)
}

/// `map.reach` becomes `map_left.reach`.
fn with_arm(path: &Path, arm: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map(|extension| format!(".{}", extension.to_string_lossy())).unwrap_or_default();
    path.with_file_name(format!("{stem}_{arm}{extension}"))
}

/// The summary of a file of one of our robots, which is read whole.
fn read(path: &Path, common: &Common) -> Result<(), Failure> {
    let known = assets::ROBOT_NAMES;
    if !path.exists() {
        let wanted = known.join(", ");
        return Err(Failure::new(format!("{}: neither a robot ({wanted}) nor a file", path.display())));
    }
    let refuse = |error: String| Failure::new(format!("{}: {error}", path.display()));
    let bytes = input::read_file(path)?;
    let of = About::of_file(&bytes).map_err(|error| refuse(error.to_string()))?.arm;
    if !known.contains(&of.robot.as_str()) {
        return Err(refuse(format!("found a map of {of}, wanted one of {}", known.join(" or "))));
    }
    let robot = robot(&of.robot)?;
    let arm = robot.arms.iter().position(|arm| arm.name == of.arm);
    let arm = arm.ok_or_else(|| refuse(format!("found a map of {of}, but the robot has no such arm")))?;
    let own_base = &robot.links[robot.arms[arm].base_link].name;
    let of_torso = (of.base_link != *own_base).then(|| robot.with_torso(arm));
    let elapsed_ms = stopwatch();
    let map = ReachMap::from_bytes(&bytes, of_torso.as_ref().unwrap_or(&robot), arm)
        .map_err(|error| refuse(error.to_string()))?;
    print(&map, bytes.len(), ("load_ms", elapsed_ms()), common);
    Ok(())
}

fn print(map: &ReachMap, bytes: usize, (what, ms): (&str, f64), common: &Common) {
    let about = map.about();
    let voxels = map.voxels().count();
    let mean = |value: &dyn Fn(endcomfort_core::reach::Voxel) -> f64| {
        map.voxels().map(value).sum::<f64>() / voxels.max(1) as f64
    };
    let fraction = mean(&|voxel| map.fraction(voxel));
    let manipulability = mean(&|voxel| map.mean_manipulability(voxel));
    let (poses, orientations) = (map.reached_poses(), map.orientations().count());
    if common.json {
        let row = json!({
            "robot": about.arm.robot, "arm": about.arm.arm, "base_link": about.arm.base_link,
            "joints": about.arm.joints, "method": about.method.to_string(), "voxel_m": map.voxel_m(),
            "orientations": orientations, "voxels": voxels, "poses": poses, "mean_fraction": fraction,
            "mean_manipulability": manipulability, "max_manipulability": map.most_manipulable(),
            "bytes": bytes, what: ms,
        });
        println!("{row}");
        return;
    }
    println!("{}, {} arm from {}, {} joints", about.arm.robot, about.arm.arm, about.arm.base_link, about.arm.joints);
    println!("  {}; voxels of {} m, {orientations} orientations", about.method, map.voxel_m());
    println!("  {voxels} voxels and {poses} poses reached, mean fraction {fraction:.3}");
    println!("  manipulability: mean {manipulability:.4}, at most {:.4}", map.most_manipulable());
    println!("  {bytes} bytes, {} {ms:.0} ms", if what == "load_ms" { "loaded in" } else { "built in" });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arm_stands_before_the_extension() {
        assert_eq!(with_arm(Path::new("maps/alita.reach"), "left"), Path::new("maps/alita_left.reach"));
        assert_eq!(with_arm(Path::new("map"), "right"), Path::new("map_right"));
    }
}
