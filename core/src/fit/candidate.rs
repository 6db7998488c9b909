//! The eleven unknowns of a fit, how a step changes them, and the box they stay in.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::superquadric::Superquadric;

/// Number of unknowns: a, b, c, e1, e2, three of the position, three of the rotation.
pub(crate) const UNKNOWNS: usize = 11;
/// Unknowns that have bounds: all but the rotation, which has none to hit.
pub(crate) const BOUNDED: usize = 8;
/// Exponents of a fit stay in this range (thesis 3.1).
pub(crate) const EXPONENTS: [f64; 2] = [0.1, 1.9];
/// Longest rotation in one step, radians; beyond it the linear model says nothing.
const MAX_TURN_RAD: f64 = 0.6;

/// A superquadric while it is being fitted, in the working frame D.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// a, b, c, e1, e2, then the centre in D; metres.
    pub(crate) values: [f64; BOUNDED],
    /// Rotation of S in D.
    pub(crate) R_DS: UnitQuaternion<f64>,
}

/// The box of the bounded unknowns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) lower: [f64; BOUNDED],
    pub(crate) upper: [f64; BOUNDED],
}

impl Candidate {
    /// From semi-axes, exponents (e1, e2) and the pose of S in D.
    pub(crate) fn new(axes: [f64; 3], e: [f64; 2], center: Vector3<f64>, R_DS: UnitQuaternion<f64>) -> Self {
        Self { values: [axes[0], axes[1], axes[2], e[0], e[1], center.x, center.y, center.z], R_DS }
    }

    pub(crate) fn axes(&self) -> [f64; 3] {
        [self.values[0], self.values[1], self.values[2]]
    }

    pub(crate) fn exponents(&self) -> [f64; 2] {
        [self.values[3], self.values[4]]
    }

    pub(crate) fn center(&self) -> Vector3<f64> {
        Vector3::new(self.values[5], self.values[6], self.values[7])
    }

    pub(crate) fn rotation(&self) -> Matrix3<f64> {
        *self.R_DS.to_rotation_matrix().matrix()
    }

    /// The candidate after a step: values add and are held in the box, the rotation turns about its own axes by the
    /// last three numbers, `R ← R exp(δ)`.
    pub(crate) fn stepped(&self, step: &[f64; UNKNOWNS], bounds: &Bounds) -> Self {
        let mut values = self.values;
        for k in 0..BOUNDED {
            values[k] = (values[k] + step[k]).max(bounds.lower[k]).min(bounds.upper[k]);
        }
        let turn = Vector3::new(step[8], step[9], step[10]);
        let shortened = turn * (MAX_TURN_RAD / turn.norm().max(MAX_TURN_RAD));
        let R_DS = UnitQuaternion::new_unchecked(
            (self.R_DS * UnitQuaternion::from_scaled_axis(shortened)).into_inner().normalize(),
        );
        Self { values, R_DS }
    }

    /// The candidate moved into the box.
    pub(crate) fn held_in(&self, bounds: &Bounds) -> Self {
        self.stepped(&[0.0; UNKNOWNS], bounds)
    }

    /// As a superquadric in another frame F, given the pose of D in F.
    pub(crate) fn superquadric(&self, X_FD: &Isometry3<f64>) -> Superquadric {
        let [a, b, c, e1, e2, ..] = self.values;
        let X_DS = Isometry3::from_parts(Translation3::from(self.center()), self.R_DS);
        Superquadric { a, b, c, e1, e2, X_FS: X_FD * X_DS, taper: 0.0, bend_per_m: 0.0 }
    }
}
