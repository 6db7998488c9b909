//! From the pipeline's results to a draw list: which bodies, points and lines show what the robot knows and does.

mod cloud;
mod grasps;
mod handover;
mod lab;
mod missing;
mod motion;
mod palette;
mod picture;
mod posing;
mod reach;
mod reach_cells;
mod swept;

use std::sync::Arc;

use endcomfort_core::grasp::{Grasp, GraspFilter, Quantity};
use endcomfort_core::handover::Handover;
use endcomfort_core::job::{FitOutput, SceneOutput, SegmentOutput};
use endcomfort_core::mesh::Mesh;
use endcomfort_core::robot::{Geometry, Link, Robot};
use endcomfort_core::scene::Scene;
use endcomfort_core::superquadric::Superquadric;
use endcomfort_core::task::{Plan, TARGET};
use nalgebra::{Isometry3, Vector3};

use crate::render::{Frame, MeshDraw, Surface, Theme, shapes};
use crate::viewer::{CloudLook, Layer, Layers, LedHand, Pick};
pub use cloud::cloud_scale;
pub use grasps::quantity_scale;
pub use lab::LabContent;
pub use motion::MotionContent;
pub use palette::Palette;
pub use picture::Picture;
pub use reach::ReachContent;
pub use reach_cells::reach_scale;

/// Resolution of a fit's mesh: 96 columns, 47 rings.
const FIT_MESH_HALF: u32 = 12;
/// Opacity of what stands around an examined fit.
const AROUND_LAB: f32 = 0.22;
/// An object that is farther than this from where it was seen has been moved, metres.
const MOVED_M: f64 = 1e-4;

/// Everything that a picture is made of.
pub struct Content<'a> {
    pub scene: &'a Scene,
    pub robot: &'a Arc<Robot>,
    /// Name of the arm that grasps.
    pub arm: &'a str,
    /// All joint positions.
    pub q: &'a [f64],
    pub cloud: Option<&'a SceneOutput>,
    /// How the points are drawn.
    pub cloud_look: CloudLook,
    pub segment: Option<&'a SegmentOutput>,
    pub fits: Option<&'a FitOutput>,
    /// Ranked grasps, or candidates before they are ranked.
    pub grasps: &'a [Grasp],
    /// Pose of the object frame at the start and, if there is one, at the goal.
    pub X_WO_start: Option<Isometry3<f64>>,
    pub X_WO_goal: Option<Isometry3<f64>>,
    /// Poses of the object frame at the ends of the earlier steps of the task.
    pub X_WO_between: Vec<Isometry3<f64>>,
    /// Where the object is now.
    pub X_WO: Option<Isometry3<f64>>,
    pub plan: Option<&'a Arc<Plan>>,
    /// How the plan is examined.
    pub motion: MotionContent<'a>,
    pub layers: &'a Layers,
    pub hovered: Option<u32>,
    pub selected: Option<u32>,
    /// What the grasps' colours mean.
    pub colored_by: Quantity,
    /// The filter whose cone and box are drawn.
    pub filter: Option<&'a GraspFilter>,
    /// Reachability maps, if there are any.
    pub reach: Option<ReachContent<'a>>,
    /// The hands that are led, while the robot is posed.
    pub hands: &'a [LedHand],
    /// The fit under examination, if there is one.
    pub lab: Option<LabContent<'a>>,
    pub theme: Theme,
}

/// The meshes of each link's visuals.
type LinkMeshes = Vec<Vec<Arc<Mesh>>>;

/// Builds draw lists and keeps the meshes that several of them share.
#[derive(Default)]
pub struct Composer {
    table: Option<([f64; 3], Arc<Mesh>)>,
    boxes: Vec<(Vector3<f64>, Arc<Mesh>)>,
    fits: Vec<(Superquadric, Arc<Mesh>)>,
    links: Option<(Arc<Robot>, LinkMeshes)>,
    cloud: Option<cloud::CloudCache>,
    glyphs: Option<grasps::Glyphs>,
    motion: Option<motion::Motion>,
    marks: Option<handover::Marks>,
    reach: reach::Drawn,
}

impl Composer {
    /// The draw list of one moment.
    pub fn compose(&mut self, input: &Content<'_>) -> Frame {
        let palette = Palette::of(input.theme);
        let mut frame = Frame::default();
        self.add_furniture(&mut frame, input, &palette);
        if input.lab.is_none() && input.layers.opacity(Layer::Robot) > 0.0 {
            self.add_robot(&mut frame, input, &palette);
        }
        if let Some(cloud) = input.cloud.filter(|_| input.layers.opacity(Layer::Cloud) > 0.0) {
            self.add_cloud(&mut frame, cloud, input, &palette);
        }
        if let Some(fits) = input.fits {
            self.add_fits(&mut frame, fits, input, &palette);
        }
        if let Some(lab) = &input.lab {
            // What is examined is seen alone: no hands, no paths.
            self.add_lab(&mut frame, lab, &palette);
            return frame;
        }
        self.add_grasps(&mut frame, input, &palette);
        grasps::add_filter(&mut frame, input, &palette);
        self.add_motion(&mut frame, input, &palette);
        self.add_handover(&mut frame, input, &palette);
        self.add_reach(&mut frame, input, &palette);
        self.add_posing(&mut frame, input, &palette);
        frame
    }

    fn box_mesh(&mut self, size_m: Vector3<f64>) -> Arc<Mesh> {
        if let Some((_, mesh)) = self.boxes.iter().find(|(known, _)| *known == size_m) {
            return mesh.clone();
        }
        let mesh = Arc::new(shapes::rounded_cuboid(size_m, 0.004_f64.min(0.2 * size_m.min())));
        self.boxes.push((size_m, mesh.clone()));
        mesh
    }

    fn add_furniture(&mut self, frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
        let scene = input.scene;
        let color = |name: &str, usual: [f32; 4]| if input.motion.blames(name) { palette.culprit } else { usual };
        let table = &scene.table;
        let size = [table.size_m[0], table.size_m[1], table.thickness_m];
        if self.table.as_ref().is_none_or(|(known, _)| *known != size) {
            self.table =
                Some((size, Arc::new(shapes::rounded_cuboid(Vector3::from(size), 0.012_f64.min(0.45 * size[2])))));
        }
        if let Some((_, mesh)) = &self.table {
            let z = table.height_m - 0.5 * table.thickness_m;
            frame.meshes.push(MeshDraw {
                mesh: mesh.clone(),
                X_WM: Isometry3::translation(table.center_m[0], table.center_m[1], z),
                color: color("table", palette.table),
                surface: Surface::Satin,
                pick_id: 0,
            });
        }
        let agent = scene.handover.as_ref().and_then(Handover::agent);
        let own = scene.obstacles.iter().cloned().zip((0..).map(|index| Pick::Obstacle(index).id()));
        let furniture = agent.iter().flat_map(|agent| agent.furniture_W()).map(|piece| (piece, 0));
        for (obstacle, pick_id) in own.chain(furniture) {
            let mesh = self.box_mesh(obstacle.size_m);
            frame.meshes.push(MeshDraw {
                mesh,
                X_WM: obstacle.X_WB,
                color: color(&obstacle.name, palette.obstacle),
                surface: Surface::Satin,
                pick_id,
            });
        }
    }

    fn link_meshes(&mut self, robot: &Arc<Robot>) -> &[Vec<Arc<Mesh>>] {
        // Held, not only its address: another robot may come to stand at the address of one that is gone.
        match &mut self.links {
            Some((known, _)) if Arc::ptr_eq(known, robot) => {}
            // A receiver that is dragged: the same bodies at another place.
            Some((known, _)) if has_same_bodies(known, robot) => *known = robot.clone(),
            links => {
                let meshes = robot
                    .links
                    .iter()
                    .map(|link| link.visuals.iter().map(|visual| shapes::geometry_mesh(&visual.geometry)).collect())
                    .collect();
                *links = Some((robot.clone(), meshes));
            }
        }
        self.links.as_ref().map_or(&[], |(_, meshes)| meshes)
    }

    fn add_robot(&mut self, frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
        let X_WL = input.robot.link_poses(input.q);
        let is_old = input.motion.is_stale && input.plan.is_some();
        let meshes = self.link_meshes(input.robot);
        for ((link, meshes), X_WL) in input.robot.links.iter().zip(meshes).zip(&X_WL) {
            for (visual, mesh) in link.visuals.iter().zip(meshes) {
                let opacity = input.layers.opacity(Layer::Robot);
                let (mut color, surface) = palette.material(&visual.material, opacity);
                if input.motion.blames(&link.name) {
                    color = palette.culprit;
                    color[3] *= opacity;
                } else if input.motion.strained.contains(&link.name) {
                    color = palette.goal;
                    color[3] *= opacity;
                } else if is_old {
                    color = palette.greyed(color);
                }
                let X_WM = X_WL * visual.X_LV;
                missing::mark(frame, visual, &X_WM, opacity);
                frame.meshes.push(MeshDraw { mesh: mesh.clone(), X_WM, color, surface, pick_id: Pick::Robot.id() });
            }
        }
    }

    /// The bodies of every fit where they stand, or where the robot has moved them, and the target's at the goal.
    fn add_fits(&mut self, frame: &mut Frame, fits: &FitOutput, input: &Content<'_>, palette: &Palette) {
        let examined = input.lab.as_ref().map(|lab| lab.cluster);
        for (cluster, fit) in fits.fits.iter().enumerate().filter(|(cluster, _)| Some(*cluster) != examined) {
            let Ok(fit) = fit else { continue };
            let X_WS = fit.superquadric.X_FS;
            let is_target = cluster == fits.target;
            let X_WO = input.X_WO.filter(|_| is_target).unwrap_or(X_WS);
            let goals = input.X_WO_goal.iter().chain(&input.X_WO_between);
            let goals: Vec<&Isometry3<f64>> = goals.filter(|_| is_target && examined.is_none()).collect();
            let name = match input.scene.object_at(&X_WS) {
                _ if is_target => TARGET.to_owned(),
                Some(placed) => placed.object.clone(),
                None => format!("cluster {cluster}"),
            };
            let is_composite = is_target && !fit.others.is_empty();
            for (part, body) in fit.bodies().enumerate() {
                let cluster = cluster as u32;
                let pick =
                    if is_composite { Pick::Part { cluster, part: part as u32 } } else { Pick::Cluster(cluster) };
                let mesh = self.fit_mesh(body);
                let X_OP = X_WS.inverse() * body.X_FS;
                if input.layers.opacity(Layer::Fits) > 0.0 {
                    let mut color = if is_target { palette.target } else { palette.neighbour(input.scene, &X_WS) };
                    if input.motion.blames(&name) {
                        color = palette.culprit;
                    }
                    color[3] *= input.layers.opacity(Layer::Fits);
                    if examined.is_some() {
                        color[3] *= AROUND_LAB;
                    }
                    frame.meshes.push(MeshDraw {
                        mesh: mesh.clone(),
                        X_WM: X_WO * X_OP,
                        color,
                        surface: Surface::Satin,
                        pick_id: pick.id(),
                    });
                }
                for X_WO in goals.iter().filter(|_| input.layers.opacity(Layer::Goal) > 0.0) {
                    let mut color = palette.goal;
                    color[3] *= input.layers.opacity(Layer::Goal);
                    let mesh = mesh.clone();
                    frame.meshes.push(MeshDraw {
                        mesh,
                        X_WM: *X_WO * X_OP,
                        color,
                        surface: Surface::Ghost,
                        pick_id: 0,
                    });
                }
            }
        }
    }
}

/// Whether the links of two robots are drawn as the same bodies.
fn has_same_bodies(a: &Robot, b: &Robot) -> bool {
    let same = |(a, b): (&Link, &Link)| {
        let mut visuals = a.visuals.iter().zip(&b.visuals);
        a.visuals.len() == b.visuals.len() && visuals.all(|(a, b)| is_same_shape(&a.geometry, &b.geometry))
    };
    a.links.len() == b.links.len() && a.links.iter().zip(&b.links).all(same)
}

fn is_same_shape(a: &Geometry, b: &Geometry) -> bool {
    match (a, b) {
        (Geometry::Box { size_m: a }, Geometry::Box { size_m: b }) => a == b,
        (Geometry::Sphere { radius_m: a }, Geometry::Sphere { radius_m: b }) => a == b,
        (
            Geometry::Cylinder { radius_m: a, length_m: long },
            Geometry::Cylinder { radius_m: b, length_m: also_long },
        )
        | (Geometry::Capsule { radius_m: a, length_m: long }, Geometry::Capsule { radius_m: b, length_m: also_long }) => {
            a == b && long == also_long
        }
        (Geometry::Mesh { mesh: a, .. }, Geometry::Mesh { mesh: b, .. }) => Arc::ptr_eq(a, b),
        _ => false,
    }
}
