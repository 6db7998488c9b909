//! What grasp synthesis is asked for: how densely to look, how a hand holds, and which grasps a person wants at all.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Settings of the grasp synthesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GraspSettings {
    /// Density N of the surface samples from which candidates start (about N²/π of them).
    pub density: u32,
    /// Rolls of the hand about its approach at each sample, evenly over half a turn; the first has x_H along the
    /// smallest principal axis, as in the thesis.
    pub rolls: u32,
    /// Stand-off depths at each sample, evenly from the power grasp (palm at the surface) to the fingertips.
    pub depths: u32,
    /// Gap left between the palm and the object in a power grasp, metres.
    pub palm_gap_m: f64,
    /// How far the open fingers reach below the surface in a fingertip grasp, metres.
    pub fingertip_depth_m: f64,
    /// A grasp needs at least this many contacts (3 in the thesis).
    pub min_contacts: usize,
    /// On what the fingers close.
    pub surface: ContactSurface,
    /// Coulomb friction coefficient of every contact.
    pub friction: f64,
    /// Uncertainty of the object's pose, for the success probability.
    pub noise: PoseNoise,
    /// Which grasps are wanted.
    pub filter: GraspFilter,
}

impl Default for GraspSettings {
    fn default() -> Self {
        Self {
            density: 12,
            rolls: 1,
            depths: 3,
            palm_gap_m: 0.008,
            fingertip_depth_m: 0.027,
            min_contacts: 3,
            surface: ContactSurface::Superquadric,
            friction: 0.5,
            noise: PoseNoise::default(),
            filter: GraspFilter::default(),
        }
    }
}

/// What stands for the object's surface when the fingers close.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactSurface {
    /// The fitted superquadrics: exact positions and normals.
    #[default]
    Superquadric,
    /// The object's points as they were measured, normals from their neighbours.
    Cloud,
    /// The surface of the fit as triangles, or the object's own mesh where one is known.
    Mesh,
}

impl ContactSurface {
    /// All surfaces.
    pub const ALL: [Self; 3] = [Self::Superquadric, Self::Cloud, Self::Mesh];

    /// The name in JSON and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Superquadric => "superquadric",
            Self::Cloud => "cloud",
            Self::Mesh => "mesh",
        }
    }
}

/// Gaussian uncertainty of where the object is in the hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PoseNoise {
    /// Poses tried per grasp; 0 leaves the success probability out.
    pub trials: u32,
    /// Standard deviation of the position along each axis, metres.
    pub position_m: f64,
    /// Standard deviation of the rotation about each axis, radians.
    pub rotation_rad: f64,
}

impl Default for PoseNoise {
    fn default() -> Self {
        Self { trials: 20, position_m: 0.005, rotation_rad: 0.05 }
    }
}

/// Which grasps a person wants; whatever is `None` or zero lets all of them pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GraspFilter {
    /// Directions from which the hand may come.
    pub approach: Option<ApproachCone>,
    /// Where the hand may hold the object, as it stands at its start.
    pub region: Option<Region>,
    /// The only body of a composite object that may be held, in the order of the fit.
    pub part: Option<usize>,
    /// The closed hand stays this far from table and neighbours where it grasps, metres.
    pub min_clearance_m: f64,
}

/// Approach directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ApproachCone {
    /// Axis in W, along which the hand moves towards the object; its length does not matter, but must not be 0.
    pub axis_W: Vector3<f64>,
    /// Half the opening angle, radians.
    pub half_angle_rad: f64,
}

/// A box in W, its edges along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Centre in W, metres.
    pub center_W: Point3<f64>,
    /// Half its edge lengths, metres.
    pub half_m: Vector3<f64>,
}

impl Region {
    /// Whether a point is inside.
    pub fn contains(&self, p_W: &Point3<f64>) -> bool {
        (p_W - self.center_W).abs().iter().zip(&self.half_m).all(|(distance, half)| distance <= half)
    }
}

/// Which wish of a [`GraspFilter`] a grasp does not meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "filter", rename_all = "snake_case")]
pub enum Unwanted {
    /// It comes from outside the approach cone.
    Approach { angle_rad: f64, limit_rad: f64 },
    /// It holds the object outside the region.
    Region { p_W: Point3<f64> },
    /// It holds another part.
    Part { part: usize, wanted: usize },
    /// The hand is too near to something.
    Clearance { found_m: f64, wanted_m: f64, other: String },
}

impl Unwanted {
    /// The reason in a few words.
    pub fn reason(&self) -> String {
        match self {
            Self::Approach { angle_rad, limit_rad } => {
                format!(
                    "approach {:.0}° off the wanted one, limit {:.0}°",
                    angle_rad.to_degrees(),
                    limit_rad.to_degrees()
                )
            }
            Self::Region { .. } => "holds the object outside the region".to_owned(),
            Self::Part { part, wanted } => format!("holds part {}, wanted part {}", part + 1, wanted + 1),
            Self::Clearance { found_m, wanted_m, other } => {
                format!("{:.0} mm from {other}, wanted {:.0} mm", found_m * 1e3, wanted_m * 1e3)
            }
        }
    }
}
