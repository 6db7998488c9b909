//! The plan as an animation: which part of it, how many frames per second, and where it goes.

use std::path::{Path, PathBuf};

use endcomfort_core::job::Output;
use image::RgbaImage;

use super::Failure;
use crate::export::{AnimationFormat, Clip, Recorder};
use crate::figures::{Picture, PictureSettings, Shooting};
use crate::render::Quality;

#[derive(clap::Args)]
pub(super) struct FilmOptions {
    /// The plan as an animation: a file (.gif, .apng, or .zip with a PNG for every frame), or a folder for the PNGs.
    #[arg(long, conflicts_with = "time")]
    pub(super) animation: Option<PathBuf>,
    /// Frames per second; frame k shows the plan at k / fps seconds.
    #[arg(long, default_value_t = 25, requires = "animation")]
    fps: u32,
    /// Where the animation starts in the plan, seconds.
    #[arg(long, default_value_t = 0.0, requires = "animation")]
    from: f64,
    /// Where it ends; the end of the plan without it.
    #[arg(long, requires = "animation")]
    to: Option<f64>,
}

impl FilmOptions {
    /// Draws every frame and writes them.
    pub(super) fn record(&self, picture: Picture<'_>, settings: &PictureSettings, to: &Path) -> Result<(), Failure> {
        let refuse = |cause: String| Failure::new(format!("{}: {cause}", to.display()));
        let plan =
            picture.outputs.iter().find_map(|output| if let Output::Plan(plan) = output { Some(plan) } else { None });
        let duration_s = plan.ok_or_else(|| refuse("there is no plan that could move".to_owned()))?.duration_s();
        let format = to.extension().and_then(|extension| AnimationFormat::of_extension(extension.to_str()?));
        let clip = Clip {
            format: format.unwrap_or(AnimationFormat::Frames),
            fps: self.fps,
            from_s: self.from,
            to_s: self.to.unwrap_or(duration_s),
        };
        let mut shooting = Shooting::new(picture, settings).map_err(|error| refuse(error.to_string()))?;
        shooting.set_quality(Quality::Live);
        let mut shoot = |time_s: f64| shooting.shoot(Some(time_s)).map_err(|error| refuse(error.to_string()));
        if format.is_none() {
            clip.check(duration_s).map_err(|error| refuse(error.to_string()))?;
            write_folder(to, &clip, &mut shoot)?;
        } else {
            let recorder = Recorder::new(clip, duration_s, settings.size_px, settings.transparent);
            let mut recorder = recorder.map_err(|error| refuse(error.to_string()))?;
            while let Some(time_s) = recorder.wanted_s() {
                recorder.take(&shoot(time_s)?).map_err(|error| refuse(error.to_string()))?;
                let (taken, wanted) = recorder.progress();
                say_tenth(taken, wanted);
            }
            let bytes = recorder.finish().map_err(|error| refuse(error.to_string()))?;
            std::fs::write(to, &bytes).map_err(|error| refuse(error.to_string()))?;
        }
        let ([width, height], count) = (settings.size_px, clip.frame_count());
        eprintln!("wrote {} ({count} frames of {width} × {height} pixels, {} per second)", to.display(), clip.fps);
        Ok(())
    }
}

/// Writes `frame_0000.png` and so on.
fn write_folder(
    folder: &Path,
    clip: &Clip,
    shoot: &mut impl FnMut(f64) -> Result<RgbaImage, Failure>,
) -> Result<(), Failure> {
    let refuse = |path: &Path, cause: String| Failure::new(format!("{}: {cause}", path.display()));
    std::fs::create_dir_all(folder).map_err(|error| refuse(folder, error.to_string()))?;
    let count = clip.frame_count();
    for frame in 0..count {
        let file = folder.join(format!("frame_{frame:04}.png"));
        shoot(clip.time_s(frame))?.save(&file).map_err(|error| refuse(&file, error.to_string()))?;
        say_tenth(frame + 1, count);
    }
    Ok(())
}

/// Says how far it is, ten times in all.
fn say_tenth(done: usize, count: usize) {
    if 10 * done / count > 10 * (done - 1) / count && done < count {
        eprintln!("{done} of {count} pictures");
    }
}
