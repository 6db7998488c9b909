//! `render`: one picture of a demo, a scene or a cloud, without a window.

use std::path::PathBuf;

use clap::ValueEnum;
use endcomfort_core::job::Output;

use super::depth_options::DepthOptions;
use super::{Common, Failure, input, reach_options, robot_options};
use crate::figures::{Picture, PictureSettings};
use crate::render::Theme;
use crate::{assets, jobs};

#[derive(clap::Args)]
pub(super) struct Args {
    /// A demo, a scene file, a cloud file, a depth image (16-bit PNG) or a mesh (.obj, .stl, .glb).
    scene: String,
    /// The PNG file.
    #[arg(long)]
    out: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "1440x900", value_parser = size)]
    size: [u32; 2],
    /// Where the camera stands and looks: x,y,z,tx,ty,tz in metres.
    #[arg(long, value_parser = input::numbers::<6>, allow_hyphen_values = true)]
    camera: Option<[f64; 6]>,
    /// Time in the plan, seconds; before it, the first moment; without it, no plan is made.
    #[arg(long)]
    time: Option<f64>,
    /// No background, so that the picture can be laid over another.
    #[arg(long)]
    transparent: bool,
    /// Colours.
    #[arg(long, value_enum, default_value = "dark")]
    theme: ThemeName,
    #[command(flatten)]
    robot: robot_options::RobotOptions,
    #[command(flatten)]
    depth: DepthOptions,
    #[command(flatten)]
    reach: reach_options::Options,
}

#[derive(Clone, Copy, ValueEnum)]
enum ThemeName {
    Dark,
    Light,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed
        .filter(|[w, h]| *w > 0 && *h > 0)
        .ok_or_else(|| format!("found {text:?}, wanted WIDTHxHEIGHT, as in 1440x900"))
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let request = input::request(&args.scene, &args.robot, &args.depth, common)?;
    let last = if args.time.is_some() { endcomfort_core::job::Stage::Plan } else { endcomfort_core::job::Stage::Rank };
    let robot = assets::library().robot_of(&request.scene).map_err(|error| Failure::new(error.to_string()))?;
    // A picture of a scene that cannot be planned still shows what was found on the way.
    let (outputs, refusal) = jobs::run_as_far_as_possible(&request, last);
    if let Some(refusal) = refusal {
        eprintln!("{}", Failure::from(refusal));
        if outputs.iter().all(|output| !matches!(output, Output::Scene(_))) {
            return Err(Failure::new("there is nothing to draw"));
        }
    }
    let settings = PictureSettings {
        size_px: args.size,
        camera: args.camera.map(|[x, y, z, tx, ty, tz]| ([x, y, z], [tx, ty, tz])),
        time_s: args.time,
        transparent: args.transparent,
        theme: match args.theme {
            ThemeName::Dark => Theme::Dark,
            ThemeName::Light => Theme::Light,
        },
        reach: args.reach.picture(&request.scene)?,
    };
    let image = Picture { scene: &request.scene, robot: &robot, outputs: &outputs }
        .draw(&settings)
        .map_err(|error| Failure::new(error.to_string()))?;
    image.save(&args.out).map_err(|error| Failure::new(format!("{}: {error}", args.out.display())))?;
    eprintln!("wrote {} ({} × {} pixels)", args.out.display(), args.size[0], args.size[1]);
    Ok(())
}
