//! Superquadrics: implicit and explicit form, normals, volume, uniform sampling, meshing (thesis 3.1 and 4.2).

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

/// A superquadric (3.1): `((x/a)^(2/e2) + (y/b)^(2/e2))^(e2/e1) + (z/c)^(2/e1) = 1` in its axes S.
///
/// z is the axis of `e1`; `e2` shapes the x–y section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Superquadric {
    /// Semi-axis along x, metres.
    pub a: f64,
    /// Semi-axis along y, metres.
    pub b: f64,
    /// Semi-axis along z, metres.
    pub c: f64,
    /// Shape exponent of the profile along z, in [0.1, 1.9].
    pub e1: f64,
    /// Shape exponent of the x–y section, in [0.1, 1.9].
    pub e2: f64,
    /// Pose of the axes S in the frame F of whoever owns the superquadric.
    pub X_FS: Isometry3<f64>,
}
