//! A plan's motion as a file, in the format of its extension.

use std::sync::Arc;

use endcomfort_core::job::Output;
use endcomfort_core::scene::Scene;
use endcomfort_core::task::{TrajectoryFormat, trajectory_text};

use super::glb;
use crate::assets;
use crate::compose::Picture;
use crate::render::Theme;
use crate::viewer::CloudLook;

/// Time between the poses of an animation, seconds.
const ANIMATION_STEP_S: f64 = 1.0 / 30.0;

/// A format for motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionFormat {
    /// Joint positions over time.
    Trajectory(TrajectoryFormat),
    /// The scene with its bodies moving.
    Glb,
}

impl MotionFormat {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Trajectory(TrajectoryFormat::Csv),
        Self::Trajectory(TrajectoryFormat::Json),
        Self::Trajectory(TrajectoryFormat::Yaml),
        Self::Glb,
    ];

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Trajectory(format) => format.extension(),
            Self::Glb => "glb",
        }
    }

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Trajectory(format) => format.title(),
            Self::Glb => "glTF animation (GLB)",
        }
    }

    /// The format of a file by its extension.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(extension))
    }
}

/// The plan among the outputs of a scene as a file.
///
/// # Errors
/// A sentence when there is no plan, the scene's robot does not exist, or the file would be too large.
pub fn export_motion(scene: &Scene, outputs: &[Output], format: MotionFormat) -> Result<Vec<u8>, String> {
    let plan = outputs.iter().find_map(|output| if let Output::Plan(plan) = output { Some(plan) } else { None });
    let plan = plan.ok_or("there is no plan to export")?;
    let robot = assets::library().robot_of(scene).map_err(|error| error.to_string())?;
    match format {
        MotionFormat::Trajectory(format) => Ok(trajectory_text(plan, &robot, format).into_bytes()),
        MotionFormat::Glb => {
            let picture =
                Picture { scene, robot: &Arc::clone(&robot), outputs, cloud_look: CloudLook::default(), cloud: None };
            glb(&picture.moments(ANIMATION_STEP_S, Theme::Light))
        }
    }
}
