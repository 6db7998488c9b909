//! Household objects described from published sizes: shape, mesh, where they stand.

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

/// A household object in its own frame O: z up as it usually stands, origin at the centre of its bounding box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HouseholdObject {
    /// File name without extension: `mustard_bottle`.
    pub name: String,
    /// What a person reads: `Mustard bottle`.
    pub title: String,
    /// Where the sizes come from: `YCB 006, published 50 × 85 × 175 mm`.
    pub source: String,
    /// Mass in kilograms.
    pub mass_kg: f64,
    /// sRGB colour.
    pub color: [u8; 3],
    /// Its solid parts.
    pub parts: Vec<Part>,
}

/// One solid part of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Part {
    /// Superellipse sections stacked along z: bottles, cans, boxes, fruit, glasses.
    Loft {
        /// Sections from bottom to top: `[z, semi-axis along x, semi-axis along y]` in metres.
        sections: Vec<[f64; 3]>,
        /// Exponent of every section: 1 ellipse, towards 0 rectangle.
        e2: f64,
        /// Pose of the part in O.
        #[serde(default = "Isometry3::identity")]
        X_OP: Isometry3<f64>,
    },
    /// A superquadric, its `X_FS` being its pose in O.
    Superquadric(crate::superquadric::Superquadric),
}
