//! The cloud itself.

use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

/// A cloud of finite points in metres, in one frame F that its owner names.
///
/// Points that are not finite are dropped and counted where the file is read, so no later loop meets one. An
/// organised cloud keeps the pixel of each point instead of holes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PointCloud {
    /// Finite points in F, metres.
    #[serde(with = "crate::bulk")]
    pub points: Vec<Point3<f64>>,
    /// One sRGB colour per point, or empty.
    #[serde(with = "crate::bulk")]
    pub colors: Vec<[u8; 3]>,
    /// Where each point stands in the sensor's image, when the cloud is organised.
    pub grid: Option<PixelGrid>,
    /// Pose of the sensor's optical frame C (x right, y down, z forward) in F; `None` when the file does not say.
    pub X_FC: Option<Isometry3<f64>>,
}

/// The image an organised cloud came from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelGrid {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major pixel index of each point, ascending.
    #[serde(with = "crate::bulk")]
    pub pixels: Vec<u32>,
}

impl PointCloud {
    /// The same cloud in another frame G: points `X_GF · p`, sensor `X_GF · X_FC`.
    pub fn transformed(&self, X_GF: &Isometry3<f64>) -> Self {
        Self {
            points: self.points.iter().map(|p| X_GF * p).collect(),
            colors: self.colors.clone(),
            grid: self.grid.clone(),
            X_FC: self.X_FC.map(|X_FC| X_GF * X_FC),
        }
    }

    /// The points with these indices, in their order, with their colours and pixels; indices past the end are left out.
    ///
    /// The image is kept only when the indices ascend, because pixels must.
    pub fn subset(&self, indices: &[u32]) -> Self {
        fn pick<T: Copy>(from: &[T], indices: &[u32]) -> Vec<T> {
            indices.iter().filter_map(|&i| from.get(i as usize).copied()).collect()
        }
        let ascending = indices.windows(2).all(|pair| pair[0] < pair[1]);
        Self {
            points: pick(&self.points, indices),
            colors: pick(&self.colors, indices),
            grid: self.grid.as_ref().filter(|_| ascending).map(|grid| PixelGrid {
                width: grid.width,
                height: grid.height,
                pixels: pick(&grid.pixels, indices),
            }),
            X_FC: self.X_FC,
        }
    }
}
