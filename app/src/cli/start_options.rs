//! Options that say how the robot stands before it moves.

use endcomfort_core::robot::JointKind;
use endcomfort_core::scene::Scene;

use super::Failure;
use crate::assets;

#[derive(clap::Args)]
#[group(skip)]
pub(super) struct Options {
    /// Posture of the robot from which it starts, by its name in the SRDF.
    #[arg(long, help_heading = "Start")]
    posture: Option<String>,
    /// Where a joint starts instead: its name in the URDF, =, and degrees (millimetres if it slides); may be repeated.
    #[arg(long = "joint", value_name = "NAME=VALUE", value_parser = position, help_heading = "Start")]
    joints: Vec<(String, f64)>,
}

fn position(text: &str) -> Result<(String, f64), String> {
    let parsed = text.split_once('=').and_then(|(name, value)| Some((name.trim().to_owned(), value.parse().ok()?)));
    parsed.ok_or_else(|| format!("found {text:?}, wanted NAME=VALUE, as in left_arm_2=-35"))
}

impl Options {
    /// Puts what was given into a scene.
    ///
    /// # Errors
    /// The posture or the joint that the robot does not have, or the limits that a joint would leave.
    pub(super) fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        if let Some(posture) = &self.posture {
            scene.posture.clone_from(posture);
            scene.joints.clear();
        }
        let failure = |error: &dyn std::error::Error| Failure::new(error.to_string());
        let robot = assets::library().robot_of(scene).map_err(|error| failure(&error))?;
        for (name, value) in &self.joints {
            let slides = robot.joints.iter().any(|joint| joint.name == *name && joint.kind == JointKind::Prismatic);
            let si = if slides { 1e-3 * value } else { value.to_radians() };
            scene.joints.insert(name.clone(), si);
        }
        scene.q_start(&robot).map_err(|error| failure(&error))?;
        Ok(())
    }
}
