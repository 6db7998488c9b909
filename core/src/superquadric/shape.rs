//! The parameters of a superquadric, checked once when it is made.

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Smallest exponent that [`Superquadric::new`] accepts; fits stay above 0.1.
pub const EXPONENT_MIN: f64 = 0.01;
/// Largest exponent that [`Superquadric::new`] accepts: from 2 on the shape has cusps; fits stay below 1.9.
pub const EXPONENT_MAX: f64 = 1.99;

/// Largest taper |K|: at 1 an end shrinks to a point and the inverse map has none.
pub const TAPER_MAX: f64 = 0.95;
/// Half the angle of a bent body's axis at most, radians: beyond π its ends would meet.
const BEND_MAX_RAD: f64 = 1.6;
/// The body's half width towards the centre of curvature, in radii of curvature, at most.
const BEND_MAX_WIDTH: f64 = 0.9;

/// Largest curvature of a body with semi-axes b and c and taper K, 1/m.
pub fn bend_limit_per_m(b: f64, c: f64, taper: f64) -> f64 {
    (BEND_MAX_RAD / c).min(BEND_MAX_WIDTH / (b * (1.0 + taper.abs())))
}

/// A superquadric (3.1): `((x/a)^(2/e2) + (y/b)^(2/e2))^(e2/e1) + (z/c)^(2/e1) = 1` in its axes S.
///
/// z is the axis of `e1`; `e2` shapes the x–y section. This base shape is tapered, then bent:
/// `(x, y, z) → (s x, s y, z)` with `s = 1 + K z/c`, then `(x, R - (R - y) cos κz, (R - y) sin κz)` with `R = 1/κ`.
/// Values read from a file pass through [`Superquadric::new`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parameters")]
pub struct Superquadric {
    /// Semi-axis along x, metres.
    pub a: f64,
    /// Semi-axis along y, metres.
    pub b: f64,
    /// Semi-axis along z, metres.
    pub c: f64,
    /// Shape exponent of the profile along z, in [0.1, 1.9] for fits.
    pub e1: f64,
    /// Shape exponent of the x–y section, in [0.1, 1.9] for fits.
    pub e2: f64,
    /// Pose of the axes S in the frame F of whoever owns the superquadric.
    pub X_FS: Isometry3<f64>,
    /// Taper K along z: sections are scaled by `1 + K z/c`; 0 leaves them alone.
    pub taper: f64,
    /// Curvature κ of the bend in the y–z plane, 1/m: towards +y when positive; 0 is straight.
    pub bend_per_m: f64,
}

/// The same fields as they stand in a file, not yet checked.
#[derive(Deserialize)]
struct Parameters {
    a: f64,
    b: f64,
    c: f64,
    e1: f64,
    e2: f64,
    X_FS: Isometry3<f64>,
    #[serde(default)]
    taper: f64,
    #[serde(default)]
    bend_per_m: f64,
}

impl TryFrom<Parameters> for Superquadric {
    type Error = SuperquadricError;

    fn try_from(p: Parameters) -> Result<Self, SuperquadricError> {
        Self::new(p.a, p.b, p.c, p.e1, p.e2, p.X_FS)?.deformed(p.taper, p.bend_per_m)
    }
}

/// Why a set of parameters is no superquadric.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SuperquadricError {
    /// A semi-axis is not a positive, finite length.
    #[error("semi-axis {name} is {found_m} m, wanted a finite length above 0")]
    SemiAxis { name: char, found_m: f64 },
    /// An exponent is outside [[`EXPONENT_MIN`], [`EXPONENT_MAX`]].
    #[error("exponent {name} is {found}, wanted {EXPONENT_MIN} to {EXPONENT_MAX}")]
    Exponent { name: &'static str, found: f64 },
    /// The pose holds NaN, infinity or a quaternion that is not of unit length.
    #[error("the pose is not a rigid motion with finite numbers")]
    Pose,
    /// The taper would turn one end inside out.
    #[error("taper is {found}, wanted -{TAPER_MAX} to {TAPER_MAX}")]
    Taper { found: f64 },
    /// The bend would fold the body over its own centre of curvature or too far around.
    #[error("bend is {found_per_m} 1/m, wanted a curvature of at most {most_per_m:.3} 1/m for these semi-axes")]
    Bend { found_per_m: f64, most_per_m: f64 },
}

impl Superquadric {
    /// A superquadric with checked parameters: semi-axes in metres, exponents, pose of its axes S in F.
    ///
    /// # Errors
    /// [`SuperquadricError`] names the first parameter that is not finite or out of range.
    pub fn new(a: f64, b: f64, c: f64, e1: f64, e2: f64, X_FS: Isometry3<f64>) -> Result<Self, SuperquadricError> {
        for (name, found_m) in [('a', a), ('b', b), ('c', c)] {
            if !(found_m.is_finite() && found_m > 0.0) {
                return Err(SuperquadricError::SemiAxis { name, found_m });
            }
        }
        for (name, found) in [("e1", e1), ("e2", e2)] {
            if !(EXPONENT_MIN..=EXPONENT_MAX).contains(&found) {
                return Err(SuperquadricError::Exponent { name, found });
            }
        }
        let finite = X_FS.translation.vector.iter().chain(X_FS.rotation.coords.iter()).all(|v| v.is_finite());
        // 1e-6 is what six printed digits of a quaternion leave.
        if !finite || (X_FS.rotation.coords.norm() - 1.0).abs() > 1e-6 {
            return Err(SuperquadricError::Pose);
        }
        Ok(Self { a, b, c, e1, e2, X_FS, taper: 0.0, bend_per_m: 0.0 })
    }

    /// The same shape tapered, then bent: K without unit, κ in 1/m.
    ///
    /// # Errors
    /// [`SuperquadricError`] when K or κ is not finite or out of range.
    pub fn deformed(self, taper: f64, bend_per_m: f64) -> Result<Self, SuperquadricError> {
        if !(taper.is_finite() && taper.abs() <= TAPER_MAX) {
            return Err(SuperquadricError::Taper { found: taper });
        }
        let most_per_m = bend_limit_per_m(self.b, self.c, taper);
        if !(bend_per_m.is_finite() && bend_per_m.abs() <= most_per_m) {
            return Err(SuperquadricError::Bend { found_per_m: bend_per_m, most_per_m });
        }
        Ok(Self { taper, bend_per_m, ..self })
    }

    /// Whether it is tapered or bent.
    pub fn is_deformed(&self) -> bool {
        self.taper != 0.0 || self.bend_per_m != 0.0
    }

    /// The semi-axes (a, b, c) as a vector, metres.
    pub fn semi_axes(&self) -> Vector3<f64> {
        Vector3::new(self.a, self.b, self.c)
    }

    /// A point of F in the superquadric's axes S.
    pub fn to_axes(&self, p_F: &Point3<f64>) -> Point3<f64> {
        self.X_FS.inverse_transform_point(p_F)
    }

    /// The same shape in another frame G: its pose becomes `X_GF · X_FS`.
    pub fn transformed(&self, X_GF: &Isometry3<f64>) -> Self {
        Self { X_FS: X_GF * self.X_FS, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_out_of_range_are_named() {
        let at = Isometry3::identity();
        let made = |a, e1| Superquadric::new(a, 0.1, 0.1, e1, 1.0, at);
        assert!(made(0.1, 1.0).is_ok());
        assert_eq!(made(-0.1, 1.0), Err(SuperquadricError::SemiAxis { name: 'a', found_m: -0.1 }));
        assert!(matches!(made(f64::NAN, 1.0), Err(SuperquadricError::SemiAxis { name: 'a', .. })));
        assert_eq!(made(0.1, 2.5), Err(SuperquadricError::Exponent { name: "e1", found: 2.5 }));
        assert!(matches!(made(0.1, f64::NAN), Err(SuperquadricError::Exponent { name: "e1", .. })));
        let lost = Isometry3::translation(f64::INFINITY, 0.0, 0.0);
        assert_eq!(Superquadric::new(0.1, 0.1, 0.1, 1.0, 1.0, lost), Err(SuperquadricError::Pose));
    }

    #[test]
    fn a_file_with_a_bad_exponent_is_refused_with_its_reason() {
        let good = Superquadric::new(0.1, 0.2, 0.3, 0.5, 1.5, Isometry3::translation(1.0, 2.0, 3.0)).unwrap();
        let text = serde_json::to_string(&good).unwrap();
        assert_eq!(serde_json::from_str::<Superquadric>(&text).unwrap(), good);
        let error = serde_json::from_str::<Superquadric>(&text.replace("1.5", "9.5")).unwrap_err();
        assert!(error.to_string().contains("exponent e2 is 9.5"), "{error}");
    }
}
