//! Pictures without a window: a scene at a moment, drawn off-screen.

mod fit_pair;

use std::sync::Arc;

use endcomfort_core::grasp::Quantity;
use endcomfort_core::job::Output;
use endcomfort_core::robot::Robot;
use endcomfort_core::scene::Scene;
use image::RgbaImage;
use nalgebra::Point3;

use crate::compose::{Composer, Content, MotionContent};
use crate::render::{Camera, Offscreen, OffscreenError, Theme, View};
use crate::viewer::Layers;

pub use fit_pair::draw_fits;

/// What a picture shows: a scene and whatever the pipeline found.
pub struct Picture<'a> {
    pub scene: &'a Scene,
    pub robot: &'a Arc<Robot>,
    pub outputs: &'a [Output],
}

/// How a picture is taken.
pub struct PictureSettings {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Eye and target in the world, metres; the usual view without.
    pub camera: Option<([f64; 3], [f64; 3])>,
    /// Time in the plan, seconds; without it the robot stands in its start posture.
    pub time_s: Option<f64>,
    /// No background.
    pub transparent: bool,
    /// Colours.
    pub theme: Theme,
}

impl Picture<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// [`OffscreenError`] when there is no graphics adapter or the size is beyond its limit.
    pub fn draw(&self, settings: &PictureSettings) -> Result<RgbaImage, OffscreenError> {
        let plan = self.outputs.iter().find_map(|output| match output {
            Output::Plan(plan) => Some(Arc::new((**plan).clone())),
            _ => None,
        });
        let mut content = Content {
            scene: self.scene,
            robot: self.robot,
            q: &[],
            cloud: None,
            segment: None,
            fits: None,
            grasps: &[],
            X_WO_start: None,
            X_WO_goal: None,
            X_WO: None,
            plan: plan.as_ref(),
            motion: MotionContent::default(),
            layers: &Layers::default(),
            hovered: None,
            selected: None,
            colored_by: Quantity::MgStart,
            filter: Some(&self.scene.grasp.filter),
            lab: None,
            theme: settings.theme,
        };
        for output in self.outputs {
            match output {
                Output::Scene(value) => content.cloud = Some(value),
                Output::Segment(value) => content.segment = Some(value),
                Output::Fit(value) => content.fits = Some(value),
                Output::Grasps(value) => {
                    (content.X_WO_start, content.X_WO_goal) = (Some(value.X_WO_start), value.X_WO_goal);
                    content.grasps = &value.grasps;
                    let quantity = self.scene.rank.by.quantity(value.X_WO_goal.is_some());
                    content.colored_by = quantity.unwrap_or(Quantity::MgStart);
                }
                Output::Rank(value) => {
                    content.grasps = &value.grasps;
                    content.selected = value.grasps.first().filter(|g| g.is_accepted()).map(|g| g.id);
                }
                Output::Plan(_) | Output::Objective(_) | Output::Quality(_) => {}
            }
        }
        let resting = self.robot.posture(&self.scene.posture);
        let mut q = resting.map_or_else(|| vec![0.0; self.robot.dof_count()], <[f64]>::to_vec);
        content.X_WO = content.X_WO_start;
        if let (Some(plan), Some(time_s)) = (content.plan, settings.time_s) {
            let state = plan.state_at(time_s);
            content.X_WO = Some(plan.object_pose(self.robot, &state));
            q = state.q;
            content.grasps = &[];
        }
        content.q = &q;
        let frame = Composer::default().compose(&content);
        let camera = settings.camera.map_or_else(Camera::default, |(eye, target)| looking(eye.into(), target.into()));
        let view = View { transparent: settings.transparent, ..View::new(camera, settings.theme, settings.size_px) };
        Offscreen::new()?.render(&frame, &view)
    }
}

/// The camera at `eye` that looks at `target`.
fn looking(eye: Point3<f64>, target: Point3<f64>) -> Camera {
    let back = eye - target;
    let distance_m = back.norm().max(1e-3);
    Camera {
        target,
        distance_m,
        yaw_rad: back.y.atan2(back.x),
        pitch_rad: (back.z / distance_m).asin(),
        ..Camera::default()
    }
}
