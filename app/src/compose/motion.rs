//! A plan in the view: the hand's way, ghosts of the arm along it, the space that it sweeps, and routes beside it.

use std::sync::Arc;

use endcomfort_core::mesh::Mesh;
use endcomfort_core::robot::Robot;
use endcomfort_core::task::{PhaseKind, Plan};
use nalgebra::{Isometry3, Point3};

use super::{Composer, Content, Palette, swept};
use crate::render::{Frame, LineDraw, MeshDraw, Surface, shapes};
use crate::viewer::Layer;

/// Samples of the hand's way per phase.
const TRAIL: u32 = 48;
/// Samples from which ghosts and the swept volume are taken.
const FINE: u32 = 1200;
/// A turn of the hand counts like a way of its length times this, metres: about what its fingertips go.
const HAND_M: f64 = 0.2;
/// Opacity of a ghost.
const GHOST: f32 = 0.20;
/// Opacity of the swept volume.
const SWEPT: f32 = 0.30;

/// What examining a plan adds to a picture.
#[derive(Clone, Copy, Default)]
pub struct MotionContent<'a> {
    /// Whether the plan belongs to the scene as it was: a new one is on its way.
    pub is_stale: bool,
    /// How many ghosts are drawn.
    pub ghosts: usize,
    /// The route that is pointed at.
    pub hovered_route: Option<usize>,
    /// The place of the handover that is looked at; `None` is the one that is used.
    pub shown_place: Option<usize>,
    /// Whether an audience looks on: of a handover the chosen place alone.
    pub is_presented: bool,
    /// The hand's way of another plan, to compare with.
    pub kept: &'a [Point3<f64>],
    /// Names of what stands in the way in the posture that is shown.
    pub culprits: &'a [String],
    /// Names of the links whose joints are at a limit in that posture.
    pub strained: &'a [String],
}

impl MotionContent<'_> {
    /// Whether something of this name stands in the way.
    pub fn blames(&self, name: &str) -> bool {
        let plain = |name: &str| name.replace('_', " ").to_lowercase();
        self.culprits.iter().any(|culprit| plain(culprit) == plain(name))
    }
}

/// Where everything is at a sampled time.
struct Pose {
    kind: PhaseKind,
    q: Vec<f64>,
    X_WO: Option<Isometry3<f64>>,
    /// Way of the hand so far, turns included, metres.
    way_m: f64,
}

/// What is kept of a plan between pictures.
pub(super) struct Motion {
    plan: Arc<Plan>,
    robot: Arc<Robot>,
    trail: Vec<(PhaseKind, Vec<Point3<f64>>)>,
    /// Samples over the whole plan, once somebody asked for ghosts or the swept volume.
    poses: Option<Vec<Pose>>,
    skin: Option<Option<Arc<Mesh>>>,
}

impl Motion {
    fn new(plan: &Arc<Plan>, robot: &Arc<Robot>) -> Self {
        let arm_phases = plan.phases.iter().filter(|phase| !phase.kind.is_of_fingers());
        let trail = arm_phases.map(|phase| {
            let duration_s = phase.trajectory.duration_s();
            let times = (0..=TRAIL).map(|k| phase.start_s + duration_s * f64::from(k) / f64::from(TRAIL));
            let tcp_link = plan.legs[phase.leg].tcp_link;
            let hand_at = |time_s: f64| robot.link_poses(&plan.state_at(time_s).q)[tcp_link].translation.vector.into();
            (phase.kind, times.map(hand_at).collect())
        });
        Self { trail: trail.collect(), plan: plan.clone(), robot: robot.clone(), poses: None, skin: None }
    }

    fn is_of(&self, plan: &Arc<Plan>, robot: &Arc<Robot>) -> bool {
        // Held, not only their addresses: another plan may come to stand at the address of one that is gone.
        Arc::ptr_eq(&self.plan, plan) && Arc::ptr_eq(&self.robot, robot)
    }

    /// Whether a joint that the plan moves is on the way from the root to each link.
    fn moving(&self) -> Vec<bool> {
        let robot = &self.robot;
        let mut moving = vec![false; robot.links.len()];
        // Joint i moves link i + 1, and parents stand before their children.
        for (joint, child) in robot.joints.iter().zip(1..) {
            let dof = joint.dof.or(joint.mimic.as_ref().map(|mimic| mimic.dof));
            moving[child] = moving[joint.parent] || dof.is_some_and(|dof| self.plan.dofs.contains(&dof));
        }
        moving
    }

    fn poses(&mut self) -> &[Pose] {
        let (plan, robot) = (&self.plan, &self.robot);
        self.poses.get_or_insert_with(|| {
            let mut poses: Vec<Pose> = Vec::with_capacity(FINE as usize + 1);
            let mut last: Option<Isometry3<f64>> = None;
            for k in 0..=FINE {
                let state = plan.state_at(plan.duration_s() * f64::from(k) / f64::from(FINE));
                let X_WH = robot.link_poses(&state.q)[plan.tcp_link(&state)];
                let step_m = last.map_or(0.0, |last| {
                    let turn_rad = last.rotation.angle_to(&X_WH.rotation);
                    (X_WH.translation.vector - last.translation.vector).norm() + HAND_M * turn_rad
                });
                last = Some(X_WH);
                let way_m = poses.last().map_or(0.0, |pose| pose.way_m) + step_m;
                let phase = &plan.phases[state.phase];
                let X_WO = phase.carries.then(|| plan.object_pose(robot, &state));
                poses.push(Pose { kind: phase.kind, q: state.q, X_WO, way_m });
            }
            poses
        })
    }

    /// Samples that are evenly apart on the way: `count` of them, each in the middle of its share.
    fn evenly(&mut self, count: usize) -> Vec<&Pose> {
        let poses = self.poses();
        let whole_m = poses.last().map_or(0.0, |pose| pose.way_m);
        let at = |share: f64| poses.partition_point(|pose| pose.way_m < share * whole_m).min(poses.len() - 1);
        (0..count).map(|k| &poses[at((k as f64 + 0.5) / count as f64)]).collect()
    }
}

impl Composer {
    /// Everything about the plan but the robot itself.
    pub(super) fn add_motion(&mut self, frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
        if input.layers.opacity(Layer::Path) > 0.0 && !input.motion.kept.is_empty() {
            let mut color = palette.kept;
            color[3] *= input.layers.opacity(Layer::Path);
            frame.lines.push(LineDraw::new(input.motion.kept.to_vec(), color, 1.6).dashed(7.0));
        }
        // A plan for another robot or hand is still there until the new one comes.
        let Some(plan) = input.plan.filter(|plan| plan.q_start.len() == input.robot.dof_count()) else { return };
        if plan.phases.is_empty() {
            return;
        }
        let mut motion = match self.motion.take() {
            Some(motion) if motion.is_of(plan, input.robot) => motion,
            _ => Motion::new(plan, input.robot),
        };
        let opacity = |layer: Layer| input.layers.opacity(layer);
        if opacity(Layer::Path) > 0.0 {
            for (kind, points) in &motion.trail {
                let mut color = palette.phase(*kind, input.motion.is_stale);
                color[3] *= opacity(Layer::Path);
                frame.lines.push(LineDraw::new(points.clone(), color, 3.0));
            }
        }
        if opacity(Layer::Routes) > 0.0 {
            add_routes(frame, plan, input, palette);
        }
        if opacity(Layer::Ghosts) > 0.0 {
            self.add_ghosts(frame, &mut motion, input, palette);
        }
        if opacity(Layer::Swept) > 0.0
            && let Some(mesh) = self.skin_of(&mut motion, input)
        {
            let mut color = if input.motion.is_stale { palette.stale } else { palette.swept };
            color[3] = SWEPT * opacity(Layer::Swept);
            frame.meshes.push(MeshDraw {
                mesh,
                X_WM: Isometry3::identity(),
                color,
                surface: Surface::Ghost,
                pick_id: 0,
            });
        }
        self.motion = Some(motion);
    }

    /// Bodies of the object in its frame O.
    pub(super) fn object_bodies(&mut self, input: &Content<'_>) -> Vec<(Arc<Mesh>, Isometry3<f64>)> {
        let Some(Ok(fit)) = input.fits.and_then(|fits| fits.fits.get(fits.target)) else { return Vec::new() };
        let X_OW = fit.superquadric.X_FS.inverse();
        fit.bodies().map(|body| (self.fit_mesh(body), X_OW * body.X_FS)).collect()
    }

    fn add_ghosts(&mut self, frame: &mut Frame, motion: &mut Motion, input: &Content<'_>, palette: &Palette) {
        let object = self.object_bodies(input);
        let moving = motion.moving();
        let meshes = self.link_meshes(input.robot);
        for (number, pose) in motion.evenly(input.motion.ghosts.max(1)).into_iter().enumerate() {
            let mut color = palette.phase(pose.kind, input.motion.is_stale);
            // Neighbours in the list that share a colour would melt into one ghost.
            color[3] = (GHOST - 1e-5 * number as f32) * input.layers.opacity(Layer::Ghosts);
            let mut add = |mesh: &Arc<Mesh>, X_WM: Isometry3<f64>| {
                frame.meshes.push(MeshDraw { mesh: mesh.clone(), X_WM, color, surface: Surface::Ghost, pick_id: 0 });
            };
            let X_WL = input.robot.link_poses(&pose.q);
            for (index, link) in input.robot.links.iter().enumerate().filter(|(index, _)| moving[*index]) {
                for (visual, mesh) in link.visuals.iter().zip(&meshes[index]) {
                    add(mesh, X_WL[index] * visual.X_LV);
                }
            }
            for (mesh, X_OP) in object.iter().filter(|_| pose.X_WO.is_some()) {
                add(mesh, pose.X_WO.unwrap_or_default() * X_OP);
            }
        }
    }

    fn skin_of(&mut self, motion: &mut Motion, input: &Content<'_>) -> Option<Arc<Mesh>> {
        if let Some(skin) = &motion.skin {
            return skin.clone();
        }
        let object = self.object_bodies(input);
        let moving = motion.moving();
        let whole_m = motion.poses().last().map_or(0.0, |pose| pose.way_m);
        // Steps of two voxels: each covers a neighbourhood of three.
        let count = ((whole_m / (2.0 * swept::VOXEL_M)).ceil() as usize).max(2).min(FINE as usize);
        let poses = motion.evenly(count);
        let placed: Vec<Vec<Isometry3<f64>>> = poses.iter().map(|pose| input.robot.link_poses(&pose.q)).collect();
        let (mut clouds, mut places) = (Vec::new(), Vec::new());
        for (index, link) in input.robot.links.iter().enumerate().filter(|(index, _)| moving[*index]) {
            for body in &link.collisions {
                clouds.push(swept::surface_points(&shapes::geometry_mesh(&body.geometry), &body.X_LC));
                places.push(placed.iter().map(|X_WL| X_WL[index]).collect());
            }
        }
        for (mesh, X_OP) in &object {
            clouds.push(swept::surface_points(mesh, X_OP));
            places.push(poses.iter().filter_map(|pose| pose.X_WO).collect());
        }
        motion.skin.insert(swept::skin(&clouds, &places).map(Arc::new)).clone()
    }
}

/// The hand's routes: the one that is taken strong, the one that is pointed at bright, those that the arm cannot
/// follow dashed.
fn add_routes(frame: &mut Frame, plan: &Plan, input: &Content<'_>, palette: &Palette) {
    for (index, route) in plan.routes.iter().enumerate() {
        let is_hovered = input.motion.hovered_route == Some(index);
        let mut color = if input.motion.is_stale { palette.stale } else { palette.route(index) };
        let quiet = if route.chosen || is_hovered { 1.0 } else { 0.65 };
        color[3] *= quiet * input.layers.opacity(Layer::Routes);
        let width_px = match (is_hovered, route.chosen) {
            (true, _) => 6.0,
            (false, true) => 4.5,
            (false, false) => 2.0,
        };
        let line = LineDraw::new(route.points_W.clone(), color, width_px);
        frame.lines.push(if route.refused.is_some() { line.dashed(6.0) } else { line });
    }
}
