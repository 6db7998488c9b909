//! A scene and whatever the pipeline found, at a time of the plan.

use std::sync::Arc;

use endcomfort_core::grasp::Quantity;
use endcomfort_core::job::{DroppedCloud, Output};
use endcomfort_core::robot::Robot;
use endcomfort_core::scene::Scene;
use endcomfort_core::task::Plan;

use super::{Composer, Content, MotionContent, ReachContent};
use crate::export::Moment;
use crate::render::{Frame, Theme};
use crate::viewer::{CloudLook, Layer, Layers};

/// What a picture shows: a scene and whatever the pipeline found.
pub struct Picture<'a> {
    pub scene: &'a Scene,
    pub robot: &'a Arc<Robot>,
    pub outputs: &'a [Output],
    /// How points are drawn.
    pub cloud_look: CloudLook,
    /// The cloud that was dropped, if the scene is one.
    pub cloud: Option<&'a DroppedCloud>,
}

impl Picture<'_> {
    /// The bodies at every `step_s` of the plan, the last moment included; without a plan, at the start alone.
    pub fn moments(&self, step_s: f64, theme: Theme) -> Vec<Moment> {
        let mut layers = Layers::default();
        for layer in Layer::ALL.into_iter().filter(|layer| !matches!(layer, Layer::Robot | Layer::Fits)) {
            layers.get_mut(layer).visible = false;
        }
        let plan = self.plan();
        let duration_s = plan.as_ref().map_or(0.0, |plan| plan.duration_s());
        let steps = (duration_s / step_s.max(1e-3)).ceil() as usize;
        let mut composer = Composer::default();
        let moment = |k: usize| {
            let time_s = (k as f64 * step_s).min(duration_s);
            let frame = self.frame(&mut composer, plan.as_ref(), Some(time_s), theme, &layers, None);
            Moment { time_s, meshes: frame.bodies().cloned().collect() }
        };
        (0..=steps).map(moment).collect()
    }

    /// The plan, to be shared by all pictures of it: what depends on the whole of it is made once.
    pub(crate) fn plan(&self) -> Option<Arc<Plan>> {
        let plan =
            self.outputs.iter().find_map(|output| if let Output::Plan(plan) = output { Some(plan) } else { None });
        plan.map(|plan| Arc::new((**plan).clone()))
    }

    /// What is drawn at a time of the plan, see [`Self::plan`]; without a time, the robot in its start posture.
    pub(crate) fn frame(
        &self,
        composer: &mut Composer,
        plan: Option<&Arc<Plan>>,
        time_s: Option<f64>,
        theme: Theme,
        layers: &Layers,
        reach: Option<ReachContent<'_>>,
    ) -> Frame {
        let mut content = Content {
            scene: self.scene,
            robot: self.robot,
            arm: self.scene.arm.name(),
            q: &[],
            cloud: None,
            cloud_look: self.cloud_look,
            segment: None,
            fits: None,
            grasps: &[],
            X_WO_start: None,
            X_WO_goal: None,
            X_WO_between: Vec::new(),
            X_WO: None,
            plan,
            motion: MotionContent::default(),
            layers,
            hovered: None,
            selected: None,
            colored_by: Quantity::MgStart,
            filter: Some(&self.scene.grasp.filter),
            hands: &[],
            lab: None,
            reach,
            theme,
        };
        for output in self.outputs {
            match output {
                Output::Scene(value) => content.cloud = Some(value),
                Output::Segment(value) => content.segment = Some(value),
                Output::Fit(value) => content.fits = Some(value),
                Output::Grasps(value) => {
                    (content.X_WO_start, content.X_WO_goal) = (Some(value.X_WO_start), value.X_WO_goal);
                    content.grasps = &value.grasps;
                    content.arm = &value.arm;
                    let quantity = self.scene.rank.by.quantity(value.X_WO_goal.is_some());
                    content.colored_by = quantity.unwrap_or(Quantity::MgStart);
                }
                Output::Rank(value) => {
                    content.grasps = &value.grasps;
                    content.selected = value.grasps.first().filter(|g| g.is_accepted()).map(|g| g.id);
                }
                Output::Plan(_) | Output::Objective(_) | Output::Quality(_) | Output::Map(_) => {}
            }
        }
        let mut q = self.scene.q_start(self.robot).unwrap_or_else(|_| vec![0.0; self.robot.dof_count()]);
        content.X_WO = content.X_WO_start;
        if let (Some(plan), Some(time_s)) = (content.plan, time_s) {
            let state = plan.state_at(time_s);
            content.X_WO = Some(plan.object_pose(self.robot, &state));
            q = state.q;
            content.grasps = &[];
        }
        content.q = &q;
        composer.compose(&content)
    }
}
