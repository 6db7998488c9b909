//! The draw list: what is to be seen, in the world frame, metres, before any GPU is involved.

use std::sync::Arc;

use endcomfort_core::mesh::Mesh;
use nalgebra::{Isometry3, Point3};

/// Everything that one picture shows.
#[derive(Clone, Default)]
pub struct Frame {
    /// Bodies.
    pub meshes: Vec<MeshDraw>,
    /// Bodies by the tens of thousands that stay where they are, uploaded once per `Arc`: data, which casts no shadow.
    pub fields: Vec<Arc<Vec<MeshDraw>>>,
    /// Clouds.
    pub points: Vec<PointsDraw>,
    /// Paths, axes, glyph stems.
    pub lines: Vec<LineDraw>,
}

impl Frame {
    /// All bodies: [`Self::meshes`], then those of [`Self::fields`].
    pub fn bodies(&self) -> impl Iterator<Item = &MeshDraw> {
        self.meshes.iter().chain(self.fields.iter().flat_map(|field| field.iter()))
    }
}

/// One instance of a mesh. Meshes are uploaded once per `Arc`, so keep and share them.
#[derive(Clone)]
#[expect(non_snake_case, reason = "frame letters")]
pub struct MeshDraw {
    /// Geometry in its own frame M.
    pub mesh: Arc<Mesh>,
    /// Pose of M in the world.
    pub X_WM: Isometry3<f64>,
    /// sRGB and opacity in [0, 1].
    pub color: [f32; 4],
    /// How it takes light.
    pub surface: Surface,
    /// What a click on it means; 0 for nothing.
    pub pick_id: u32,
}

/// How a body takes light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// Painted shell, soft highlight.
    Satin,
    /// Dark joint, rubber: almost no highlight.
    Matte,
    /// Metal or glazed: tight highlight.
    Gloss,
    /// Data: its colour as it is, no light, no shadow.
    Unlit,
    /// Data on bodies that stand side by side: no light and no shadow, but faces that look down are darker, so that one
    /// body is told from the next.
    Facet,
    /// A see-through outline of something that is not there (a goal, a ghost): brighter at the rim, no shadow.
    Ghost,
}

/// A cloud of small discs of one size on screen, unlit.
#[derive(Clone)]
pub struct PointsDraw {
    /// Points in the world; uploaded once per `Arc`.
    pub points: Arc<Vec<Point3<f64>>>,
    /// sRGB and opacity of each point, or a single colour for all, 0 to 255.
    pub colors: Arc<Vec<[u8; 4]>>,
    /// Diameter in metres (drawn at least 1.5 pixels wide).
    pub diameter_m: f32,
}

/// A polyline of constant width on screen, unlit.
#[derive(Clone)]
pub struct LineDraw {
    /// Vertices in the world.
    pub points: Vec<Point3<f64>>,
    /// sRGB and opacity in [0, 1].
    pub color: [f32; 4],
    /// Width in logical pixels.
    pub width_px: f32,
    /// Length of a dash and of the gap after it, in logical pixels; `None` for a solid line.
    pub dash_px: Option<f32>,
}

/// A colour of channels in [0, 1] as the bytes of a point's.
pub fn bytes_of(color: [f32; 4]) -> [u8; 4] {
    color.map(|channel| (channel.max(0.0).min(1.0) * 255.0).round() as u8)
}

impl LineDraw {
    /// A solid line.
    pub fn new(points: Vec<Point3<f64>>, color: [f32; 4], width_px: f32) -> Self {
        Self { points, color, width_px, dash_px: None }
    }

    /// The same line, dashed.
    pub fn dashed(self, dash_px: f32) -> Self {
        Self { dash_px: Some(dash_px), ..self }
    }
}
