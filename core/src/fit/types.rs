//! What a fit is asked, what it answers, and why it may refuse.

use std::fmt;

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
    /// What is minimised.
    pub objective: ObjectiveKind,
    /// Whether the unseen side is completed by a mirror image.
    pub mirror: MirrorMode,
    /// Which deformations may be used.
    pub deform: DeformMode,
    /// Coarse to fine (0.03 m to 0.005 m, each level warm-started) instead of one voxel size.
    pub hierarchical: bool,
    /// Whether points that no superquadric near the others explains are left out of the fit.
    pub reject_outliers: bool,
    /// Superquadrics that one object may be split into; 1 never splits.
    pub max_parts: usize,
    /// Iterations of Levenberg–Marquardt per start.
    pub max_iterations: u32,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            voxel_m: 0.015,
            objective: ObjectiveKind::Radial,
            mirror: MirrorMode::Auto,
            deform: DeformMode::None,
            hierarchical: false,
            reject_outliers: true,
            max_parts: 1,
            max_iterations: 100,
        }
    }
}

/// The five objectives of the thesis (3.2.1), as corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectiveKind {
    /// Radial distance (3.4): `|p_S| (1 - f^(-e1/2))`, metres.
    Radial,
    /// Solina and Bajcsy (3.5): `√(abc) (f^e1 - 1)`.
    Solina,
    /// Ichim (3.7) as its author computes it: `√(abc) |p_S| (f^e1 - 1)`.
    Ichim,
    /// Chevalier (3.6): `|p_S| (f^(e1/2) - 1)`.
    Chevalier,
    /// f5 (3.8): `|p_S| (f^e1 - 1)`.
    F5,
}

impl ObjectiveKind {
    /// All five, in the order of the thesis.
    pub const ALL: [Self; 5] = [Self::Radial, Self::Solina, Self::Ichim, Self::Chevalier, Self::F5];

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radial => "radial",
            Self::Solina => "solina",
            Self::Ichim => "ichim",
            Self::Chevalier => "chevalier",
            Self::F5 => "f5",
        }
    }
}

/// Which deformations a fit may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeformMode {
    /// None.
    None,
    /// Taper along z.
    Taper,
    /// Bend in the y–z plane.
    Bend,
    /// Taper, then bend.
    Both,
    /// Whatever lowers the criterion of the fit, plain if nothing does.
    Auto,
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
    #[serde(with = "crate::bulk")]
    pub mirrored: Vec<Point3<f64>>,
    /// What became of mirroring, for a person.
    pub mirror_note: String,
    /// Every run of Levenberg–Marquardt, in order.
    pub runs: Vec<RunReport>,
    /// Points of the input that were left out, with the reason.
    pub rejected: Vec<RejectedPoint>,
    /// The models that were compared, when there was a choice.
    pub models: Vec<ModelReport>,
    /// Further parts of a composite object; empty when one superquadric describes it.
    pub others: Vec<Part>,
}

impl Fit {
    /// All superquadrics of the object, the largest first.
    pub fn bodies(&self) -> impl Iterator<Item = &Superquadric> {
        std::iter::once(&self.superquadric).chain(self.others.iter().map(|part| &part.superquadric))
    }
}

/// One run of Levenberg–Marquardt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunReport {
    /// What it started from: `principal box, first axis as z`.
    pub name: String,
    /// Points (voxels) it ran on.
    pub points: usize,
    /// Weighted root mean square of the residuals at the start and after each step that was taken; metres for the
    /// radial objective and Chevalier's, in the objective's own unit otherwise.
    pub rms: Vec<f64>,
    /// Evaluations of the objective.
    pub iterations: u32,
    /// Why it stopped.
    pub stop: StopReason,
}

/// Why Levenberg–Marquardt stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// The cost hardly changes any more, or is zero to rounding.
    Converged,
    /// No step, however short, lowers the cost.
    NoDescent,
    /// `max_iterations` were made.
    IterationLimit,
    /// The cost is not a finite number.
    NotFinite,
    /// The caller stopped it.
    Stopped,
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::NoDescent => "no step lowers the cost",
            Self::IterationLimit => "iteration limit",
            Self::NotFinite => "cost not finite",
            Self::Stopped => "stopped",
        })
    }
}

/// A point of the input that the fit left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RejectedPoint {
    /// The point in F, metres.
    pub p_F: Point3<f64>,
    /// Its radial distance from the surface, metres; negative inside.
    pub distance_m: f64,
    /// Points farther than this were left out, metres.
    pub limit_m: f64,
}

/// A model that was compared with others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelReport {
    /// `plain`, `taper`, `bend`, `taper and bend`, `2 parts`, ….
    pub name: String,
    /// Bayesian information criterion: the least wins.
    pub criterion: f64,
    /// Root mean square of the residuals, metres.
    pub rms_m: f64,
    /// Whether it was taken.
    pub is_chosen: bool,
}

/// A part of a composite object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its shape, in the frame of the input.
    pub superquadric: Superquadric,
    /// Points of the input that belong to it.
    pub points: usize,
    /// Their mean radial distance, metres.
    pub radial_m: f64,
}

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitRefusal {
    /// Eleven parameters need more points than this.
    #[error("the cluster has {found} different finite points, a fit wants at least {wanted}")]
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
