//! Reachability maps in the view: voxels in the colours of their values, and at the chosen one the hands that reach it.

use std::sync::Arc;

use endcomfort_core::mesh::Mesh;
use endcomfort_core::reach::ReachMap;
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::reach_cells::{Cell, Placed, cells, reach_scale};
use super::{Composer, Content, Palette};
use crate::render::{Bounds, Frame, LineDraw, MeshDraw, Scale, Surface, shapes};
use crate::viewer::{Layer, Pick, ReachView, VoxelChoice};

/// Edge of a drawn cube as a share of its voxel's: the gap tells one from the next.
const FILLED: f64 = 0.86;
/// Opacity of a voxel without value where voxels fade.
const LEAST_OPACITY: f64 = 0.01;
/// What is left of all voxels' opacity beside a chosen one: the arm is seen through dozens of them.
const BESIDE_CHOSEN: f32 = 0.02;
/// Length of the arrow that stands for a hand, metres.
const ARROW_M: f64 = 0.12;
/// How far before the hand's frame it ends, metres: around the hand that the robot shows there.
const BEFORE_M: f64 = 0.08;
/// Half of the bar across an arrow's tail, which shows how the hand closes, metres.
const BAR_M: f64 = 0.018;

/// Maps and how they are shown.
#[derive(Clone, Copy)]
pub struct ReachContent<'a> {
    /// Of the left arm and of the right one.
    pub maps: [Option<&'a ReachMap>; 2],
    /// How they are shown.
    pub view: ReachView,
    /// The chosen voxel with one of its orientations.
    pub chosen: Option<VoxelChoice>,
    /// Another number, other maps.
    pub version: u64,
}

impl<'a> ReachContent<'a> {
    /// The maps where their bases stand. A map of another robot stands nowhere.
    fn placed(&self, input: &Content<'_>) -> [Option<Placed<'a>>; 2] {
        let X_WL = input.robot.link_poses(input.q);
        self.maps.map(|map| {
            let base = &map?.about().arm.base_link;
            let link = input.robot.links.iter().position(|link| link.name == *base)?;
            Some(Placed { map: map?, X_WB: X_WL[link] })
        })
    }

    /// What the colours mean, in the unit of the data.
    pub fn scale(&self) -> Scale {
        let shown = self.maps.into_iter().enumerate().filter(|(arm, _)| self.view.arms.needs(*arm));
        reach_scale(shown.filter_map(|(_, map)| map), &self.view)
    }
}

/// What was drawn last: voxels are placed and coloured anew only when something about them changed.
#[derive(Default)]
pub(super) struct Drawn {
    key: Option<Key>,
    voxels: Arc<Vec<MeshDraw>>,
    bounds: Option<Bounds>,
    cube: Option<(f64, Arc<Mesh>)>,
    arrow: Option<Arc<Mesh>>,
}

#[derive(PartialEq)]
struct Key {
    version: u64,
    view: ReachView,
    opacity: f32,
    bases: [Option<Isometry3<f64>>; 2],
}

impl Composer {
    /// How many voxels the last picture shows, and the box around them.
    pub fn reach_drawn(&self) -> (usize, Option<Bounds>) {
        (self.reach.voxels.len(), self.reach.bounds)
    }

    pub(super) fn add_reach(&mut self, frame: &mut Frame, input: &Content<'_>, palette: &Palette) {
        let opacity = input.layers.opacity(Layer::Reach);
        let Some(reach) = input.reach.filter(|_| opacity > 0.0) else {
            self.reach.key = None;
            self.reach.voxels = Arc::default();
            return;
        };
        let maps = reach.placed(input);
        let chosen = reach.chosen.filter(|chosen| maps.get(chosen.arm).is_some_and(Option::is_some));
        let opacity = if chosen.is_some() { BESIDE_CHOSEN * opacity } else { opacity };
        let bases = maps.map(|placed| placed.map(|placed| placed.X_WB));
        let key = Key { version: reach.version, view: reach.view, opacity, bases };
        if self.reach.key.as_ref() != Some(&key) {
            let shown = cells(maps, &reach.view);
            self.reach.place(&shown, &maps, &reach, opacity);
            self.reach.key = Some(key);
        }
        if !self.reach.voxels.is_empty() {
            frame.fields.push(self.reach.voxels.clone());
        }
        if let Some((chosen, placed)) = chosen.and_then(|chosen| Some((chosen, maps[chosen.arm]?))) {
            self.reach.add_hands(frame, &placed, chosen, palette);
        }
    }
}

impl Drawn {
    fn place(&mut self, cells: &[Cell], maps: &[Option<Placed<'_>>; 2], reach: &ReachContent<'_>, opacity: f32) {
        let scale = reach.scale();
        self.bounds = None;
        let mut voxels = Vec::new();
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for (arm, placed) in maps.iter().enumerate() {
            let Some(placed) = placed else { continue };
            let mesh = self.cube(FILLED * placed.map.voxel_m());
            for cell in cells.iter().filter(|cell| cell.arm == arm) {
                let mut color = scale.color(cell.value);
                let share = if reach.view.fades { scale.share(cell.value).max(0.0).min(1.0) } else { 1.0 };
                // Dozens stand behind each other: only a steep rise leaves the inside visible.
                color[3] *= opacity * (LEAST_OPACITY + (1.0 - LEAST_OPACITY) * share.powi(4)) as f32;
                (low, high) = (low.inf(&cell.p_W.coords), high.sup(&cell.p_W.coords));
                voxels.push(MeshDraw {
                    mesh: mesh.clone(),
                    X_WM: Isometry3::from_parts(cell.p_W.into(), placed.X_WB.rotation),
                    color,
                    surface: Surface::Facet,
                    pick_id: Pick::Voxel { arm: arm as u32, voxel: cell.voxel.0 }.id(),
                });
            }
        }
        self.voxels = Arc::new(voxels);
        self.bounds = (!self.voxels.is_empty()).then(|| Bounds { min: low.into(), max: high.into() });
    }

    fn cube(&mut self, edge_m: f64) -> Arc<Mesh> {
        let known = self.cube.as_ref().filter(|(known_m, _)| *known_m == edge_m);
        let mesh = known.map(|(_, mesh)| mesh.clone());
        let mesh = mesh.unwrap_or_else(|| Arc::new(shapes::cuboid(Vector3::repeat(edge_m))));
        self.cube = Some((edge_m, mesh.clone()));
        mesh
    }

    /// The chosen voxel's edges, and an arrow for each orientation in which the hand reaches it: it points where the
    /// hand points, and the bar across its tail lies along the line on which the fingers close.
    fn add_hands(&mut self, frame: &mut Frame, placed: &Placed<'_>, chosen: VoxelChoice, palette: &Palette) {
        let Placed { map, X_WB } = *placed;
        let X_WV = X_WB * Translation3::from(map.center(chosen.voxel).coords);
        for edge in edges(0.5 * map.voxel_m()) {
            frame.lines.push(LineDraw::new(edge.map(|p_V| X_WV * p_V).to_vec(), palette.chosen, 1.6));
        }
        let arrow = self.arrow.get_or_insert_with(|| Arc::new(shapes::arrow(ARROW_M, 0.0022))).clone();
        let tail = Translation3::new(0.0, 0.0, -ARROW_M - BEFORE_M);
        for orientation in map.reached(chosen.voxel) {
            let Some(X_BH) = map.pose(chosen.voxel, orientation) else { continue };
            let X_WT = X_WB * X_BH * tail;
            let is_current = orientation == chosen.orientation;
            let color = if is_current { palette.chosen } else { palette.other_hands };
            let bar = [-BAR_M, BAR_M].map(|x_m| X_WT * Point3::new(x_m, 0.0, 0.0));
            frame.lines.push(LineDraw::new(bar.to_vec(), color, if is_current { 3.0 } else { 1.4 }));
            let mesh = arrow.clone();
            frame.meshes.push(MeshDraw { mesh, X_WM: X_WT, color, surface: Surface::Unlit, pick_id: 0 });
        }
    }
}

/// The twelve edges of a cube about the origin.
fn edges(half_m: f64) -> impl Iterator<Item = [Point3<f64>; 2]> {
    (0..3).flat_map(move |axis| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].into_iter().map(move |(u, v)| {
            [-1.0, 1.0].map(|along| {
                let mut p = Point3::origin();
                p[axis] = half_m * along;
                p[(axis + 1) % 3] = half_m * u;
                p[(axis + 2) % 3] = half_m * v;
                p
            })
        })
    })
}
