//! `render`: a picture, an animation or the bodies of a demo, a scene or a cloud, without a window.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use endcomfort_core::job::{Output, Stage};

use super::depth_options::DepthOptions;
use super::{Common, Failure, film_options, input, look_options, reach_options, robot_options, start_options};
use crate::compose::cloud_scale;
use crate::figures::{Picture, PictureSettings, Shooting};
use crate::render::{MAX_SIDE_PX, Theme, check_scale, check_size};
use crate::{assets, jobs};

#[derive(clap::Args)]
pub(super) struct Args {
    /// A demo, a scene file, a cloud file, a depth image (16-bit PNG) or a mesh (.obj, .stl, .glb).
    scene: String,
    /// The file: a picture (.png), or everything that it shows as bodies, points and lines (.glb).
    #[arg(long, value_parser = picture_file, required_unless_present = "animation", conflicts_with = "animation")]
    out: Option<PathBuf>,
    /// Width and height in pixels.
    #[arg(long, default_value = "1440x900", value_parser = size)]
    size: [u32; 2],
    /// Pixels per point: how thick lines and points are.
    #[arg(long, default_value_t = 1.0)]
    scale: f32,
    /// Where the camera stands and looks: x,y,z,tx,ty,tz in metres.
    #[arg(long, value_parser = input::numbers::<6>, allow_hyphen_values = true)]
    camera: Option<[f64; 6]>,
    /// Time in the plan, seconds; before it, the first moment; without it, no plan is made.
    #[arg(long)]
    time: Option<f64>,
    /// No background, so that the picture can be laid over another.
    #[arg(long)]
    transparent: bool,
    /// With the labels and the scale that stand over the view.
    #[arg(long, conflicts_with = "reach")]
    words: bool,
    /// Colours.
    #[arg(long, value_enum, default_value = "dark")]
    theme: ThemeName,
    #[command(flatten)]
    robot: robot_options::RobotOptions,
    #[command(flatten)]
    depth: DepthOptions,
    #[command(flatten)]
    start: start_options::Options,
    #[command(flatten)]
    look: look_options::Options,
    #[command(flatten)]
    film: film_options::FilmOptions,
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

fn picture_file(text: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(text);
    match ["png", "glb"].iter().any(|extension| has_extension(&file, extension)) {
        true => Ok(file),
        false => Err("wanted a file that ends in .png or .glb".to_owned()),
    }
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let mut request = input::request(&args.scene, &args.robot, &args.depth, common)?;
    args.start.apply(&mut request.scene)?;
    check_size(args.size, MAX_SIDE_PX).map_err(|error| Failure::new(format!("--size: {error}")))?;
    check_scale(args.scale).map_err(|error| Failure::new(format!("--scale: {error}")))?;
    let moves = args.time.is_some() || args.film.animation.is_some();
    let last = if moves { Stage::Plan } else { Stage::Rank };
    let robot = assets::library().robot_of(&request.scene).map_err(|error| Failure::new(error.to_string()))?;
    // A picture of a scene that cannot be planned still shows what was found on the way.
    let (outputs, refusal) = jobs::run_as_far_as_possible(&request, last);
    if let Some(refusal) = refusal {
        eprintln!("{}", Failure::from(refusal));
        if outputs.iter().all(|output| !matches!(output, Output::Scene(_))) {
            return Err(Failure::new("there is nothing to draw"));
        }
    }
    let seen = outputs.iter().find_map(|output| if let Output::Scene(seen) = output { Some(seen) } else { None });
    let look = args.look.cloud_look();
    if let Some(scale) = seen.and_then(|seen| cloud_scale(seen, look.by)) {
        eprintln!("colours: {}, viridis from {:.3} m to {:.3} m", look.by.title(), scale.min, scale.max);
    }
    let settings = PictureSettings {
        size_px: args.size,
        scale: args.scale,
        camera: args.camera.map(|[x, y, z, tx, ty, tz]| ([x, y, z], [tx, ty, tz])),
        transparent: args.transparent,
        words: args.words,
        theme: match args.theme {
            ThemeName::Dark => Theme::Dark,
            ThemeName::Light => Theme::Light,
        },
        cut: args.look.cut(),
        reach: args.reach.picture(&request.scene)?,
    };
    let cloud = request.cloud.as_ref();
    let picture = Picture { scene: &request.scene, robot: &robot, outputs: &outputs, cloud_look: look, cloud };
    match (&args.out, &args.film.animation) {
        (Some(file), _) if has_extension(file, "glb") => {
            let bytes = picture.glb(&settings, args.time).map_err(Failure::new)?;
            std::fs::write(file, &bytes).map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
            eprintln!("wrote {} ({} bytes)", file.display(), bytes.len());
        }
        (Some(file), _) => {
            let shot = Shooting::new(picture, &settings).and_then(|mut shooting| shooting.shoot(args.time));
            let image = shot.map_err(|error| Failure::new(error.to_string()))?;
            image.save(file).map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
            eprintln!("wrote {} ({} × {} pixels)", file.display(), args.size[0], args.size[1]);
        }
        (None, Some(file)) => args.film.record(picture, &settings, file)?,
        (None, None) => {}
    }
    Ok(())
}

fn has_extension(file: &Path, extension: &str) -> bool {
    file.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
