//! Point clouds: reading, voxel grids, normals and the synthetic RGB-D camera.

use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

/// A cloud of finite points in metres, in one frame F that its owner names.
///
/// Points that are not finite are dropped and counted where the file is read, so no later loop meets one. An
/// organised cloud keeps the pixel of each point instead of holes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PointCloud {
    /// Finite points in F, metres.
    pub points: Vec<Point3<f64>>,
    /// One sRGB colour per point, or empty.
    pub colors: Vec<[u8; 3]>,
    /// Where each point stands in the sensor's image, when the cloud is organised.
    pub grid: Option<PixelGrid>,
    /// Pose of the sensor's optical frame C (x right, y down, z forward) in F; `None` when the file does not say.
    pub X_FC: Option<Isometry3<f64>>,
}

/// The image an organised cloud came from.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PixelGrid {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major pixel index of each point, ascending.
    pub pixels: Vec<u32>,
}
