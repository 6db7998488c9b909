//! Options of whatever takes a cloud: what a depth image needs to become one.

use std::path::{Path, PathBuf};

use endcomfort_core::cloud::Intrinsics;
use endcomfort_core::job::DroppedCloud;

use super::{Failure, input};
use crate::brought::DepthImage;

#[derive(clap::Args, Clone, Default)]
pub(super) struct DepthOptions {
    /// Intrinsics of a depth image (16-bit PNG): JSON with fx, fy, cx, cy, or as in ROS camera_info.
    #[arg(long, value_name = "FILE", conflicts_with = "fov", help_heading = "Depth image")]
    intrinsics: Option<PathBuf>,
    /// Horizontal field of view of a depth image, degrees, where its intrinsics are not known.
    #[arg(long, value_name = "DEG", help_heading = "Depth image")]
    fov: Option<f64>,
}

impl DepthOptions {
    /// The cloud of a file: a depth image with its camera, or what the file holds.
    pub(super) fn cloud(&self, path: &Path) -> Result<DroppedCloud, Failure> {
        let bytes = input::read_file(path)?;
        let name = path.file_name().map_or_else(|| "cloud".to_owned(), |name| name.to_string_lossy().into_owned());
        if !crate::brought::is_png(&bytes) {
            self.refuse_alone()?;
            return Ok(DroppedCloud { name, bytes });
        }
        let image = DepthImage::read(&name, &bytes).map_err(Failure::new)?;
        let camera = match (&self.intrinsics, self.fov) {
            (Some(file), _) => {
                let text = input::read_file(file)?;
                Intrinsics::parse(&String::from_utf8_lossy(&text))
                    .map_err(|error| Failure::new(format!("{}: {error}", file.display())))?
            }
            (None, Some(degrees)) => image.camera_of_view(degrees).map_err(Failure::new)?,
            (None, None) => {
                return Err(Failure::new(format!(
                    "{}: a depth image has no scale without its camera: give --intrinsics FILE.json, or --fov DEGREES",
                    path.display()
                )));
            }
        };
        camera.notes.iter().for_each(|note| eprintln!("{note}"));
        image.cloud(&camera).map_err(Failure::new)
    }

    /// A camera without an image that it could have made.
    pub(super) fn refuse_alone(&self) -> Result<(), Failure> {
        if self.intrinsics.is_some() || self.fov.is_some() {
            return Err(Failure::new("--intrinsics and --fov are about a depth image: a PNG of 16 bits"));
        }
        Ok(())
    }
}
