//! What a fit is asked, what it answers, and why it may refuse.

use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

use crate::segment::Plane;
use crate::superquadric::Superquadric;

/// Settings of a fit; the defaults are the thesis's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FitSettings {
    /// Edge of the voxel grid that thins the cloud, metres; 0 takes the cloud as it is.
    pub voxel_m: f64,
    /// Whether the unseen side is completed by a mirror image.
    pub mirror: MirrorMode,
    /// Iterations of Levenberg–Marquardt per start.
    pub max_iterations: u32,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self { voxel_m: 0.015, mirror: MirrorMode::Auto, max_iterations: 100 }
    }
}

/// Whether the unseen side is completed by a mirror image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MirrorMode {
    /// When the camera and the table are known and a plane of symmetry passes the test.
    Auto,
    /// As `Auto`, and a fit without a mirror plane is refused.
    On,
    /// Never.
    Off,
}

/// What is fitted.
#[derive(Clone, Copy, Debug)]
pub struct FitInput<'a> {
    /// Points of one object in F, metres.
    pub points: &'a [Point3<f64>],
    /// Pose of the camera's optical frame in F, if the points are one view.
    pub X_FC: Option<Isometry3<f64>>,
    /// The table that the object stands on, in F.
    pub table: Option<Plane>,
}

/// A fitted superquadric with its errors and its history.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fit {
    /// The result, in the frame of the input.
    pub superquadric: Superquadric,
    /// E_r: mean radial distance of the input points, metres.
    pub radial_m: f64,
    /// E_g as printed in (3.9): mean (f^e1 - 1)².
    pub goodness_of_fit: f64,
    /// E_g as the thesis's tables use it: mean |f - 1|.
    pub goodness_of_fit_abs: f64,
    /// Volume (3.11), cubic metres.
    pub volume_m3: f64,
    /// Iterations of Levenberg–Marquardt over all starts.
    pub iterations: u32,
    /// Points of the input.
    pub points: usize,
    /// Points after thinning, mirrored ones included.
    pub used_points: usize,
    /// Points that mirroring added, in F.
    pub mirrored: Vec<Point3<f64>>,
    /// What became of mirroring, for a person.
    pub mirror_note: String,
    /// One line per start: which axis, its cost, why it stopped.
    pub starts: Vec<String>,
}

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitRefusal {
    /// Eleven parameters need more points than this.
    #[error("the cluster has {found} finite points, a fit wants at least {wanted}")]
    TooFewPoints { found: usize, wanted: usize },
    /// The points lie on a line or in one place: the second of their three principal deviations is too small.
    #[error(
        "the points lie on a line: they spread {:.2} mm across it, a fit wants at least {:.2} mm",
        found_m * 1e3,
        wanted_m * 1e3
    )]
    Degenerate { found_m: f64, wanted_m: f64 },
    /// A setting is not a usable number.
    #[error("setting {name} is {found}, wanted {wanted}")]
    Setting { name: &'static str, found: f64, wanted: &'static str },
    /// Mirroring was asked for, but the view or the table is missing.
    #[error("mirroring was asked for, but the {missing} is not known")]
    MirrorNeeds { missing: &'static str },
    /// Mirroring was asked for, but the best plane of symmetry contradicts what the camera saw.
    #[error(
        "mirroring was asked for, but the best plane of symmetry puts points {:.1} mm on average where the camera saw \
         nothing; at most {:.1} mm pass",
        best_m * 1e3,
        wanted_m * 1e3
    )]
    NoMirrorPlane { best_m: f64, wanted_m: f64 },
    /// The caller stopped it.
    #[error("the fit was stopped")]
    Stopped,
}
