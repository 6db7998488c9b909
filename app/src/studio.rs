//! The room behind the interface: demos, robots, and pictures of whatever state it is in.

use std::sync::Arc;

use endcomfort_core::robot::Robot;
use nalgebra::{Isometry3, Point3};

use crate::assets;
use crate::compose::{Composer, Content, merit_scale};
use crate::render::{Bounds, Theme};
use crate::viewer::{
    ComposeInput, Demo, Label, Layer, Picture, Posture, RobotChoice, ScaleBar, Situation, Studio, Tone,
};

/// Composes pictures from the robots and demos inside the program.
#[derive(Default)]
pub struct BuiltInStudio {
    composer: Composer,
}

impl Studio for BuiltInStudio {
    fn demos(&self) -> Vec<Demo> {
        assets::DEMOS
            .iter()
            .filter_map(|name| {
                let scene = Arc::new(assets::demo(name)?);
                Some(Demo { name: (*name).to_owned(), scene, thumbnail: assets::thumbnail(name).map(Arc::from) })
            })
            .collect()
    }

    fn robots(&self) -> Vec<RobotChoice> {
        let choice = |name: &str, title: &str| RobotChoice {
            name: name.into(),
            title: title.into(),
            posture: "table_ready".into(),
        };
        vec![choice("crichton", "Crichton"), choice("alita", "Alita")]
    }

    fn compose(&mut self, input: &ComposeInput<'_>) -> Picture {
        let robot = match assets::library().robot(&input.scene.robot) {
            Ok(robot) => robot,
            Err(error) => {
                log::error!("{error}");
                return Picture::default();
            }
        };
        let state = Standing::of(input, &robot);
        let outputs = input.outputs;
        let grasps = outputs.candidates();
        let under_way = matches!(input.posture, Posture::Plan { time_s } if time_s > 0.0);
        let content = Content {
            scene: input.scene,
            robot: &robot,
            q: &state.q,
            cloud: outputs.scene.as_deref(),
            segment: outputs.segment.as_deref(),
            fits: outputs.fit.as_deref(),
            grasps: if under_way { &[] } else { grasps },
            X_WO_start: outputs.grasps.as_ref().map(|g| g.X_WO_start),
            X_WO_goal: outputs.grasps.as_ref().and_then(|g| g.X_WO_goal),
            X_WO: state.X_WO,
            plan: outputs.plan.as_deref(),
            layers: input.layers,
            hovered: input.hover.grasp,
            selected: input.selection.grasp,
            theme: if input.dark { Theme::Dark } else { Theme::Light },
        };
        let frame = self.composer.compose(&content);
        let shows_grasps = input.layers.opacity(Layer::Grasps) > 0.0 && !content.grasps.is_empty();
        let has_goal = content.X_WO_goal.is_some();
        let scale = (shows_grasps && outputs.rank.is_some()).then(|| ScaleBar {
            title: format!("mean manipulability m_g at the {}", if has_goal { "goal" } else { "start" }),
            scale: merit_scale(grasps),
        });
        Picture { frame, labels: labels(input, &content), scale, bounds: Some(workspace(input)) }
    }
}

/// What a first look shows: the robot from the shoulders down to the table, and as much of the table as it works on.
fn workspace(input: &ComposeInput<'_>) -> Bounds {
    let height_m = input.scene.table.height_m;
    Bounds { min: Point3::new(-0.10, -0.48, height_m - 0.06), max: Point3::new(0.70, 0.48, height_m + 0.72) }
}

/// Joints and object at the moment of the picture.
struct Standing {
    q: Vec<f64>,
    X_WO: Option<Isometry3<f64>>,
}

impl Standing {
    fn of(input: &ComposeInput<'_>, robot: &Robot) -> Self {
        let outputs = input.outputs;
        let (X_WO_start, X_WO_goal) =
            outputs.grasps.as_ref().map_or((None, None), |g| (Some(g.X_WO_start), g.X_WO_goal));
        let q = robot.posture(&input.scene.posture).map_or_else(|| vec![0.0; robot.dof_count()], <[f64]>::to_vec);
        let at_start = Self { q, X_WO: X_WO_start };
        match input.posture {
            Posture::Start => at_start,
            Posture::Plan { time_s } => {
                let Some(plan) = outputs.plan.as_deref().filter(|plan| plan.q_start.len() == robot.dof_count()) else {
                    return at_start;
                };
                let state = plan.state_at(time_s);
                Self { X_WO: Some(plan.object_pose(robot, &state)), q: state.q }
            }
            Posture::Ik { grasp, at, index } => {
                let Some(grasp) = outputs.candidate(grasp) else { return at_start };
                let situated = match at {
                    Situation::Start => grasp.start.as_ref(),
                    Situation::Goal => grasp.goal.as_ref(),
                };
                let Some(arm) = robot.arm(input.scene.arm.name()) else { return at_start };
                let Some(solution) = situated.and_then(|s| s.solutions.get(index)) else { return at_start };
                let fingers = arm.hand.fingers.iter().flatten().zip(&grasp.closed);
                let mut q = at_start.q;
                for (&dof, &position) in arm.dofs.iter().zip(solution).chain(fingers) {
                    q[dof] = position;
                }
                Self { q, X_WO: if at == Situation::Goal { X_WO_goal } else { X_WO_start } }
            }
        }
    }
}

/// Names of what stands on the table, and of the goal.
fn labels(input: &ComposeInput<'_>, content: &Content<'_>) -> Vec<Label> {
    let mut labels = Vec::new();
    let Some(fits) = content.fits else { return labels };
    for (cluster, fit) in fits.fits.iter().enumerate() {
        let Ok(fit) = fit else { continue };
        let is_target = cluster == fits.target;
        let X_WS = if is_target { content.X_WO.unwrap_or(fit.superquadric.X_FS) } else { fit.superquadric.X_FS };
        let described = input.document.cloud.is_none().then(|| nearest_title(input, &fit.superquadric.X_FS)).flatten();
        let text = described.unwrap_or_else(|| format!("cluster {cluster}"));
        labels.push(Label { p_W: top_of(fit, &X_WS), text, tone: if is_target { Tone::Fit } else { Tone::Plain } });
        if let Some(X_WO_goal) = content.X_WO_goal.filter(|_| is_target && input.layers.opacity(Layer::Goal) > 0.0) {
            labels.push(Label { p_W: top_of(fit, &X_WO_goal), text: "goal".into(), tone: Tone::Goal });
        }
    }
    labels
}

fn top_of(fit: &endcomfort_core::fit::Fit, X_WS: &Isometry3<f64>) -> Point3<f64> {
    let posed = endcomfort_core::superquadric::Superquadric { X_FS: *X_WS, ..fit.superquadric };
    let top = X_WS.translation.z + posed.half_extents().z;
    Point3::new(X_WS.translation.x, X_WS.translation.y, top + 0.015)
}

/// Title of the described object that stands where a fit is.
fn nearest_title(input: &ComposeInput<'_>, X_WS: &Isometry3<f64>) -> Option<String> {
    let distance = |X: &Isometry3<f64>| (X.translation.vector.xy() - X_WS.translation.vector.xy()).norm();
    let placed = input.scene.objects.iter().filter(|placed| distance(&placed.X_WO) < 0.08);
    let nearest = placed.min_by(|l, r| distance(&l.X_WO).total_cmp(&distance(&r.X_WO)))?;
    Some(assets::library().object(&nearest.object).ok()?.title.clone())
}
