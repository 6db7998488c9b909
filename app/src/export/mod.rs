//! Files for other programs and for papers: ranked grasps, motions, tables, pictures, and scenes that
//! move.

mod animation;
mod glb;
mod motion;
mod picture;
mod plots;
mod tables;

pub use animation::{AnimationError, AnimationFormat, Clip, Recorder};
pub use glb::{Moment, glb, glb_scene};
pub use motion::{MotionFormat, export_motion};
pub use picture::png_bytes;
#[cfg(not(target_arch = "wasm32"))]
pub use plots::fit_svgs;
pub use plots::{HISTOGRAM_BARS, Histogram, PlotKind, plot_svg, taken_run};
pub use tables::{Results, TableFormat, TableKind, table_lines, table_text};

use endcomfort_core::grasp::{ExportFormat, Grasp, GraspExport, StraightWays};
use endcomfort_core::job::{DroppedCloud, GraspsOutput};
use endcomfort_core::scene::Scene;

use crate::assets;

/// The grasps of a scene, ranked, as text of a format.
///
/// # Errors
/// A sentence when the scene's robot or its arm does not exist.
pub fn export_grasps(
    scene: &Scene,
    cloud: Option<&DroppedCloud>,
    found: &GraspsOutput,
    ranked: &[Grasp],
    format: ExportFormat,
) -> Result<String, String> {
    let robot = assets::library().robot_of(scene).map_err(|error| error.to_string())?;
    let arm_name = found.arm.as_str();
    let arm = robot.arm(arm_name).ok_or_else(|| format!("{} has no {arm_name} arm", scene.robot))?;
    // What a dropped file shows has no other name than the file's.
    let object = cloud.map_or_else(|| scene.objects[scene.task.object].object.as_str(), |cloud| &cloud.name);
    let motion = &scene.motion;
    let export = GraspExport {
        grasps: ranked,
        robot: &robot,
        arm,
        object,
        X_WO_start: found.X_WO_start,
        X_WO_goal: found.X_WO_goal,
        ranked_by: scene.rank.by.quantity(found.X_WO_goal.is_some()),
        ways: StraightWays {
            approach_m: motion.approach_m,
            min_approach_m: motion.min_approach_m,
            lift_m: motion.lift_m,
        },
    };
    Ok(export.text(format))
}
