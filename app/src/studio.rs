//! The room behind the interface: demos, robots, and pictures of whatever state it is in.

use std::sync::Arc;

use endcomfort_core::grasp::ExportFormat;
use endcomfort_core::handover::Handover;
use endcomfort_core::job::Output;
use endcomfort_core::robot::{Link, Robot};
use endcomfort_core::scene::Obstacle;
use endcomfort_core::task::{PhaseKind, TARGET, Try};
use nalgebra::{Isometry3, Point3, Vector3};

use crate::assets;
use crate::compose::{
    Composer, Content, LabContent, MotionContent, Palette, ReachContent, cloud_scale, quantity_scale,
};
use crate::export::{MotionFormat, export_grasps, export_motion};
use crate::render::{Bounds, ColorMap, Frame, Scale, Theme};
use crate::viewer::{
    ComposeInput, Demo, Document, Label, Layer, Legend, LegendRow, Mark, Outputs, Picture, Posture, ReachArms,
    RobotChoice, ScaleBar, Situation, Studio, Tone, VoxelChoice, objective_title, unit_of,
};

/// How far from the hand's tool centre point its reason stands, metres.
const BEHIND_PALM_M: f64 = 0.16;
/// How far the body of somebody who receives reaches about the frames of its links, metres.
const BODY_M: f64 = 0.1;

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

    fn export(&self, document: &Document, outputs: &Outputs, format: ExportFormat) -> Result<String, String> {
        let (Some(found), true) = (outputs.grasps.as_deref(), outputs.is_ranked()) else {
            return Err("they are not ranked yet".to_owned());
        };
        export_grasps(&document.scene, document.cloud.as_deref(), found, outputs.candidates(), format)
    }

    fn export_motion(&self, document: &Document, outputs: &Outputs, format: MotionFormat) -> Result<Vec<u8>, String> {
        let fit = outputs.fit.as_deref().map(|fit| Output::Fit(fit.clone()));
        let grasps = outputs.grasps.as_deref().map(|grasps| Output::Grasps(grasps.clone()));
        let plan = outputs.plan.as_deref().map(|plan| Output::Plan(Box::new(plan.clone())));
        let found: Vec<Output> = [fit, grasps, plan].into_iter().flatten().collect();
        export_motion(&document.scene, &found, format)
    }

    fn compose(&mut self, input: &ComposeInput<'_>) -> Picture {
        let robot = match assets::library().robot_of(input.scene) {
            Ok(robot) => robot,
            Err(error) => {
                log::error!("{error}");
                return Picture::default();
            }
        };
        let state = Standing::of(input, &robot);
        let outputs = input.outputs;
        let grasps = outputs.candidates();
        // A try shows what stood in the way, and nothing beside it.
        let is_try = input.planning.shown_try.is_some();
        let under_way =
            is_try || input.is_presented || matches!(input.posture, Posture::Plan { time_s } if time_s > 0.0);
        let has_goal = outputs.grasps.as_ref().is_some_and(|g| g.X_WO_goal.is_some());
        let (X_WO_goal, X_WO_between) = goals(input);
        let content = Content {
            scene: input.scene,
            robot: &robot,
            arm: outputs.arm_name(input.scene),
            q: &state.q,
            cloud: outputs.scene.as_deref(),
            cloud_look: input.cloud_look,
            segment: outputs.segment.as_deref(),
            fits: outputs.fit.as_deref(),
            grasps: if under_way { &[] } else { grasps },
            X_WO_start: outputs.grasps.as_ref().map(|g| g.X_WO_start),
            X_WO_goal,
            X_WO_between,
            X_WO: state.X_WO,
            plan: outputs.plan.as_ref().map(|plan| &plan.value),
            motion: motion_content(input),
            layers: input.layers,
            hovered: input.hover.grasp,
            selected: input.selection.grasp,
            colored_by: input.colored_by(has_goal),
            filter: input.grasping.filter.as_ref(),
            reach: reach_content(input),
            hands: &input.posing.hands,
            lab: lab_content(input),
            theme: if input.dark { Theme::Dark } else { Theme::Light },
        };
        let frame = self.composer.compose(&content);
        if let Some(lab) = &content.lab {
            let scale = (lab.view == crate::viewer::FitView::Error).then(|| ScaleBar {
                title: "signed radial distance".to_owned(),
                unit: "mm",
                scale: lab.scale(),
            });
            let legend = Some(lab.legend(&Palette::of(content.theme)));
            return Picture { frame, scale, legend, bounds: lab.bounds(), ..Picture::default() };
        }
        if let Some(reach) = content.reach {
            return self.reach_picture(frame, input, &content, &reach);
        }
        let has_values = content.grasps.iter().any(|g| g.is_accepted() && content.colored_by.of(g).is_some());
        let scale = (input.layers.opacity(Layer::Grasps) > 0.0 && has_values).then(|| {
            let (unit, per_si) = unit_of(content.colored_by);
            let scale = quantity_scale(grasps, content.colored_by);
            let scale = Scale { min: per_si * scale.min, max: per_si * scale.max, ..scale };
            ScaleBar { title: content.colored_by.title().to_owned(), unit, scale }
        });
        let scale = cloud_bar(&content).or(scale);
        let object_W = object_W(&content);
        let bounds = workspace(input);
        let outline = outline(input, &robot, &bounds);
        let bounds = Some(bounds);
        // An audience reads the caption.
        let labels = if input.is_presented { Vec::new() } else { labels(input, &content) };
        Picture { frame, labels, scale, legend: None, bounds, outline, object_W, hands_W: hands_W(&content) }
    }
}

impl BuiltInStudio {
    /// The picture of a robot in its maps.
    fn reach_picture(
        &self,
        frame: Frame,
        input: &ComposeInput<'_>,
        content: &Content<'_>,
        reach: &ReachContent<'_>,
    ) -> Picture {
        let palette = Palette::of(content.theme);
        let (count, around) = self.composer.reach_drawn();
        let (unit, per_si) = reach.view.quantity.unit();
        let scale = reach.scale();
        let scale = Scale { min: per_si * scale.min, max: per_si * scale.max, ..scale };
        let bar = ScaleBar { title: reach.view.quantity.title().to_owned(), unit, scale };
        let mut rows = vec![LegendRow {
            mark: Mark::Body,
            color: ColorMap::Viridis.at(0.6),
            text: format!("{} voxels shown", crate::viewer::count(count)),
        }];
        if let Some(chosen) = reach.chosen {
            let reached = reach.maps[chosen.arm].map_or(0, |map| map.reached(chosen.voxel).count());
            let others = format!("{} orientations that reach the voxel", crate::viewer::count(reached));
            rows.push(LegendRow { mark: Mark::Line, color: palette.other_hands, text: others });
            let text = "the one that the robot shows".to_owned();
            rows.push(LegendRow { mark: Mark::Line, color: palette.chosen, text });
        }
        let title = match reach.view.arms {
            ReachArms::Left => "Reachability of the left arm",
            ReachArms::Right => "Reachability of the right arm",
            ReachArms::Both => "Reachability of both arms",
            ReachArms::Overlap => "Reachability, overlap of both arms",
        };
        let legend = Some(Legend { title: title.to_owned(), rows });
        let (bounds, outline) = match around.filter(|_| input.reaching.is_open) {
            Some(around) => (around, Vec::new()),
            None => (workspace(input), outline(input, content.robot, &workspace(input))),
        };
        let (labels, bounds) = (labels(input, content), Some(bounds));
        let scale = (count > 0).then_some(bar);
        let (object_W, hands_W) = (object_W(content), hands_W(content));
        Picture { frame, labels, scale, legend, bounds, outline, object_W, hands_W }
    }
}

/// What the colours of the points mean, where they are amounts.
fn cloud_bar(content: &Content<'_>) -> Option<ScaleBar> {
    let cloud = content.cloud.filter(|_| content.layers.opacity(Layer::Cloud) > 0.0)?;
    let by = content.cloud_look.by;
    Some(ScaleBar { title: by.title().to_owned(), unit: "m", scale: cloud_scale(cloud, by)? })
}

/// Where the object is that the task is about.
fn object_W(content: &Content<'_>) -> Option<Point3<f64>> {
    content.X_WO.map(|X_WO| X_WO.translation.vector.into())
}

/// Where the hands of all arms are.
fn hands_W(content: &Content<'_>) -> Vec<Point3<f64>> {
    let X_WL = content.robot.link_poses(content.q);
    content.robot.arms.iter().map(|arm| X_WL[arm.hand.tcp_link].translation.vector.into()).collect()
}

/// The maps that are shown.
fn reach_content<'a>(input: &ComposeInput<'a>) -> Option<ReachContent<'a>> {
    let reaching = input.reaching;
    let maps = [reaching.map(0), reaching.map(1)];
    let is_shown = input.layers.opacity(Layer::Reach) > 0.0 && maps.iter().any(Option::is_some);
    let chosen = if let Posture::Reach(chosen) = input.posture { Some(chosen) } else { None };
    is_shown.then(|| ReachContent { maps, view: reaching.view, chosen, version: reaching.version() })
}

/// Where the task wants the object frame last, and before that: as the pipeline found it, or as the scene has it while
/// a goal is on its way.
fn goals(input: &ComposeInput<'_>) -> (Option<Isometry3<f64>>, Vec<Isometry3<f64>>) {
    let Some(found) = &input.outputs.grasps else { return (None, Vec::new()) };
    let task = &input.scene.task;
    let Some(placed) = input.scene.objects.get(task.object) else { return (found.X_WO_goal, Vec::new()) };
    let moved = |X_WO_goal: &Isometry3<f64>| {
        if input.document.cloud.is_some() {
            let shift = X_WO_goal.translation.vector - placed.X_WO.translation.vector;
            nalgebra::Translation3::from(shift) * found.X_WO_start
        } else {
            X_WO_goal * placed.X_WO.inverse() * found.X_WO_start
        }
    };
    let wanted: Vec<Isometry3<f64>> = match input.scene.handover.as_ref().and_then(Handover::agent) {
        // Somebody else's goal moves with them.
        Some(agent) => agent.goal.iter().map(|goal| agent.X_WA() * goal.X_AO).collect(),
        None => task.steps.iter().map(|step| step.X_WO_goal).collect(),
    };
    let mut poses: Vec<Isometry3<f64>> = wanted.iter().map(moved).collect();
    let last = poses.pop();
    (if found.revision == input.revision { found.X_WO_goal } else { last }, poses)
}

/// How the plan is examined.
fn motion_content<'a>(input: &'a ComposeInput<'a>) -> MotionContent<'a> {
    let is_stale = input.outputs.plan.as_ref().is_some_and(|plan| plan.revision != input.revision);
    let shown = input.planning.shown_try.and_then(|index| input.tries.get(index));
    MotionContent {
        is_stale: is_stale && shown.is_none(),
        ghosts: input.planning.ghosts,
        hovered_route: input.planning.hovered_route,
        shown_place: input.planning.shown_place,
        is_presented: input.is_presented,
        kept: input.kept.map_or(&[], |kept| &kept.trail),
        culprits: shown.map_or(&input.posing.met, |tried| &tried.culprits),
        strained: &input.posing.strained,
    }
}

/// The fit under examination, with everything that the view needs of it.
fn lab_content<'a>(input: &ComposeInput<'a>) -> Option<LabContent<'a>> {
    let key = input.lab?;
    let (segment, fits) = (input.outputs.segment.as_deref()?, input.outputs.fit.as_deref()?);
    let fit = fits.fits.get(key.cluster)?.as_ref().ok()?;
    let described = input.document.cloud.is_none().then(|| nearest_title(input, &fit.superquadric.X_FS)).flatten();
    let number = format!("cluster {}", key.cluster + 1);
    let is_by_hand = input.document.shape.is_some_and(|shape| shape.cluster == key.cluster);
    Some(LabContent {
        cluster: key.cluster,
        title: described.map_or_else(|| format!("C{}", &number[1..]), |title| format!("{title}, {number}")),
        points: segment.clusters.get(key.cluster)?,
        distances_m: fits.distances_m.get(key.cluster).map_or(&[], Vec::as_slice),
        fit,
        automatic: fits.automatic.as_deref().filter(|_| is_by_hand),
        trial: key.objective.and_then(|objective| Some((objective_title(objective), input.trial?))),
        view: key.view,
        points_out_rejected: key.points_out_rejected,
    })
}

/// What a first look shows: the robot from the shoulders down to the table, and as much of the table as it works on.
fn workspace(input: &ComposeInput<'_>) -> Bounds {
    let height_m = input.scene.table.height_m;
    Bounds { min: Point3::new(-0.10, -0.48, height_m - 0.06), max: Point3::new(0.70, 0.48, height_m + 0.72) }
}

/// Where somebody receives, what has to be seen of both: the corners of the workspace, points about the receiver and
/// its furniture.
fn outline(input: &ComposeInput<'_>, robot: &Robot, workspace: &Bounds) -> Vec<Point3<f64>> {
    let Some(agent) = input.scene.handover.as_ref().and_then(Handover::agent) else { return Vec::new() };
    let mut points = workspace.corners().to_vec();
    let X_WL = input.scene.q_start(robot).map(|q| robot.link_poses(&q)).unwrap_or_default();
    let prefix = format!("{}_", agent.model);
    let is_seen = |link: &Link| link.name.starts_with(&prefix) && !link.visuals.is_empty();
    for (_, X_WL) in robot.links.iter().zip(&X_WL).filter(|(link, _)| is_seen(link)) {
        let p_WL = Point3::from(X_WL.translation.vector);
        let about = |side: Vector3<f64>| [p_WL - BODY_M * side, p_WL + BODY_M * side];
        points.extend([Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(about));
    }
    for piece in agent.furniture_W() {
        let half = 0.5 * piece.size_m;
        let own = Bounds { min: (-half).into(), max: half.into() };
        points.extend(own.corners().map(|corner| piece.X_WB * corner));
    }
    points
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
        let q = input.scene.q_start(robot).unwrap_or_else(|_| vec![0.0; robot.dof_count()]);
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
            Posture::Reach(chosen) => {
                let placed = Self::in_map(chosen, input, robot, &at_start);
                placed.unwrap_or(at_start)
            }
            Posture::Try { index } => {
                let placed = input.tries.get(index).and_then(|tried| Self::of_try(tried, input, robot));
                placed.unwrap_or(at_start)
            }
            Posture::Ik { grasp, at, index } => {
                let Some(grasp) = outputs.candidate(grasp) else { return at_start };
                let situated = match at {
                    Situation::Start => grasp.start.as_ref(),
                    Situation::Goal => grasp.goal.as_ref(),
                };
                let Some(arm) = robot.arm(outputs.arm_name(input.scene)) else { return at_start };
                let arm = if input.scene.torso { robot.arm_with_torso(arm) } else { arm.clone() };
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

impl Standing {
    /// In the configuration of a map; `None` if the map is of another robot.
    fn in_map(chosen: VoxelChoice, input: &ComposeInput<'_>, robot: &Robot, at_start: &Self) -> Option<Self> {
        let map = input.reaching.map(chosen.arm)?;
        let positions = map.configuration(chosen.voxel, chosen.orientation)?;
        let arm = robot.arm(&map.about().arm.arm)?;
        let arm = if positions.len() > arm.dofs.len() { robot.arm_with_torso(arm) } else { arm.clone() };
        let mut q = at_start.q.clone();
        for (&dof, position) in arm.dofs.iter().zip(positions) {
            *q.get_mut(dof)? = position;
        }
        Some(Self { q, X_WO: at_start.X_WO })
    }

    /// Where a try failed; `None` if it belongs to another robot or hand.
    fn of_try(tried: &Try, input: &ComposeInput<'_>, robot: &Robot) -> Option<Self> {
        let outputs = input.outputs;
        let plan = outputs.plan.as_deref().filter(|plan| plan.q_start.len() == robot.dof_count());
        let resting = || input.scene.q_start(robot).ok();
        let mut q = plan.map(|plan| plan.q_start.clone()).or_else(resting)?;
        let arm = robot.arm(tried.arm.as_deref().unwrap_or(outputs.arm_name(input.scene)))?;
        let arm = if input.scene.torso { robot.arm_with_torso(arm) } else { arm.clone() };
        let dofs: Vec<usize> = arm.dofs.iter().chain(arm.hand.fingers.iter().flatten()).copied().collect();
        if tried.q.len() > dofs.len() {
            return None;
        }
        for (&dof, &position) in dofs.iter().zip(&tried.q) {
            q[dof] = position;
        }
        let found = outputs.grasps.as_ref()?;
        let X_OH = tried.grasp.and_then(|id| outputs.candidate(id)).map(|grasp| grasp.X_OH);
        let X_WO = match (X_OH, tried.phase) {
            (Some(X_OH), _) if tried.carries => robot.link_poses(&q)[arm.hand.tcp_link] * X_OH.inverse(),
            _ if tried.X_WO.is_some() => tried.X_WO?,
            (_, Some(PhaseKind::Open | PhaseKind::Retreat)) => found.X_WO_goal.unwrap_or(found.X_WO_start),
            _ => found.X_WO_start,
        };
        Some(Self { q, X_WO: Some(X_WO) })
    }
}

/// Names of what stands on the table, and of the goal.
fn labels(input: &ComposeInput<'_>, content: &Content<'_>) -> Vec<Label> {
    let mut labels: Vec<Label> = rejected_label(content).into_iter().collect();
    labels.extend(culprit_labels(content));
    labels.extend(route_labels(content));
    let kept = input.kept.filter(|_| input.layers.opacity(Layer::Path) > 0.0);
    labels.extend(kept.and_then(|kept| Some(Label { p_W: kept.label_place()?, text: "A".into(), tone: Tone::Plain })));
    let Some(fits) = content.fits else { return labels };
    for (cluster, fit) in fits.fits.iter().enumerate() {
        let Ok(fit) = fit else { continue };
        let is_target = cluster == fits.target;
        let X_WS = if is_target { content.X_WO.unwrap_or(fit.superquadric.X_FS) } else { fit.superquadric.X_FS };
        let title = || nearest_title(input, &fit.superquadric.X_FS).or_else(|| task_title(input).filter(|_| is_target));
        let described = input.document.cloud.is_none().then(title).flatten();
        let placed = input.scene.object_at(&fit.superquadric.X_FS).map(|placed| placed.object.as_str());
        let is_blamed = is_target && content.motion.blames(TARGET)
            || !is_target && content.motion.blames(placed.unwrap_or(&format!("cluster {cluster}")));
        let text = described.unwrap_or_else(|| format!("cluster {cluster}"));
        let tone = match (is_blamed, is_target) {
            (true, _) => Tone::Rejected,
            (false, true) => Tone::Fit,
            (false, false) => Tone::Plain,
        };
        labels.push(Label { p_W: top_of(fit, &X_WS), text, tone });
        if let Some(X_WO_goal) = content.X_WO_goal.filter(|_| is_target && input.layers.opacity(Layer::Goal) > 0.0) {
            let count = content.X_WO_between.len();
            let goals = content.X_WO_between.iter().chain([&X_WO_goal]).enumerate();
            // Where the goal can be moved, there is no room for a word.
            let goals = goals.filter(|(step, _)| Some(*step) != input.planning.goal_step);
            labels.extend(goals.map(|(step, X_WO)| {
                let text = if count == 0 { "goal".to_owned() } else { format!("goal {}", step + 1) };
                Label { p_W: top_of(fit, X_WO), text, tone: Tone::Goal }
            }));
        }
    }
    labels
}

/// Why the selected grasp was rejected, at its hand.
fn rejected_label(content: &Content<'_>) -> Option<Label> {
    let grasp = content.grasps.iter().find(|grasp| Some(grasp.id) == content.selected && !grasp.is_accepted())?;
    let X_WH = content.X_WO.or(content.X_WO_start)? * grasp.X_OH;
    // Behind the palm, where it hides neither the fingers nor the object.
    let p_W = X_WH * Point3::new(0.0, 0.0, -BEHIND_PALM_M);
    Some(Label { p_W, text: grasp.status.reason(), tone: Tone::Rejected })
}

/// Names of the links and known boxes that stand in the way in the posture that is shown.
fn culprit_labels(content: &Content<'_>) -> Vec<Label> {
    let X_WL = content.robot.link_poses(content.q);
    let links = content.robot.links.iter().zip(&X_WL);
    let links = links.map(|(link, X_WL)| (link.name.as_str(), Point3::from(X_WL.translation.vector)));
    let agent = content.scene.handover.as_ref().and_then(Handover::agent);
    let furniture: Vec<Obstacle> = agent.iter().flat_map(|agent| agent.furniture_W()).collect();
    let boxes = content.scene.obstacles.iter().chain(&furniture).map(|obstacle| {
        let top = obstacle.X_WB.translation.vector + 0.5 * obstacle.size_m.z * Vector3::z();
        (obstacle.name.as_str(), top.into())
    });
    let table = &content.scene.table;
    let table = ("table", Point3::new(table.center_m[0], table.center_m[1], table.height_m));
    let blamed = links.chain(boxes).chain([table]).filter(|(name, _)| content.motion.blames(name));
    let mut blamed: Vec<(&str, Point3<f64>)> = blamed.collect();
    // A crate is several boxes of one name.
    blamed.dedup_by(|after, before| after.0 == before.0);
    blamed.into_iter().map(|(name, p_W)| Label { p_W, text: name.replace('_', " "), tone: Tone::Rejected }).collect()
}

/// Numbers of the hand's routes beside them.
fn route_labels(content: &Content<'_>) -> Vec<Label> {
    let Some(plan) = content.plan.filter(|_| content.layers.opacity(Layer::Routes) > 0.0) else { return Vec::new() };
    // Routes part and meet again: each has its number at another share of its way.
    let count = plan.routes.len() + 1;
    let place = |index: usize, points: &[Point3<f64>]| points.get(points.len() * (index + 1) / count).copied();
    let label = |(index, route): (usize, &endcomfort_core::task::Route)| {
        let tone = if route.refused.is_some() { Tone::Rejected } else { Tone::Goal };
        Some(Label { p_W: place(index, &route.points_W)?, text: format!("route {}", index + 1), tone })
    };
    plan.routes.iter().enumerate().filter_map(label).collect()
}

fn top_of(fit: &endcomfort_core::fit::Fit, X_WS: &Isometry3<f64>) -> Point3<f64> {
    let posed = endcomfort_core::superquadric::Superquadric { X_FS: *X_WS, ..fit.superquadric };
    let top = X_WS.translation.z + posed.half_extents().z;
    Point3::new(X_WS.translation.x, X_WS.translation.y, top + 0.015)
}

/// Title of the described object that the task is about.
fn task_title(input: &ComposeInput<'_>) -> Option<String> {
    let placed = input.scene.objects.get(input.scene.task.object)?;
    Some(assets::library().object(&placed.object).ok()?.title.clone())
}

/// Title of the described object that stands where a fit is.
fn nearest_title(input: &ComposeInput<'_>, X_WS: &Isometry3<f64>) -> Option<String> {
    let placed = input.scene.object_at(X_WS)?;
    Some(assets::library().object(&placed.object).ok()?.title.clone())
}
