//! The unknowns of a fit, how a step changes them, and the box they stay in.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::superquadric::{Superquadric, TAPER_MAX, bend_limit_per_m};

/// Unknowns of a plain superquadric: a, b, c, e1, e2, three of the position, three of the rotation.
pub(crate) const PLAIN: usize = 11;
/// Unknowns of a deformed one: the same, then taper K and curvature κ.
pub(crate) const DEFORMED: usize = 13;
/// Unknowns that have bounds: all but the rotation, which has none to hit.
pub(crate) const VALUES: usize = 10;
/// Where taper and curvature stand among the values.
pub(crate) const TAPER: usize = 8;
pub(crate) const BEND: usize = 9;
/// Exponents of a fit stay in this range (thesis 3.1).
pub(crate) const EXPONENTS: [f64; 2] = [0.1, 1.9];
/// Longest rotation in one step, radians; beyond it the linear model says nothing.
const MAX_TURN_RAD: f64 = 0.6;
/// Share of the largest taper and curvature that a fit may reach.
const DEFORM_SHARE: f64 = 0.98;

/// Which of the values an unknown is; `None` for the rotation.
pub(crate) fn value_of(unknown: usize) -> Option<usize> {
    match unknown {
        0..8 => Some(unknown),
        8..11 => None,
        _ => Some(unknown - 3),
    }
}

/// A superquadric while it is being fitted, in the working frame D.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// a, b, c, e1, e2, the centre in D, K and κ; metres, 1/m.
    pub(crate) values: [f64; VALUES],
    /// Rotation of S in D.
    pub(crate) R_DS: UnitQuaternion<f64>,
}

/// The box of the bounded unknowns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) lower: [f64; VALUES],
    pub(crate) upper: [f64; VALUES],
}

impl Candidate {
    /// From semi-axes, exponents (e1, e2) and the pose of S in D; not deformed.
    pub(crate) fn new(axes: [f64; 3], e: [f64; 2], center: Vector3<f64>, R_DS: UnitQuaternion<f64>) -> Self {
        Self { values: [axes[0], axes[1], axes[2], e[0], e[1], center.x, center.y, center.z, 0.0, 0.0], R_DS }
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

    pub(crate) fn is_deformed(&self) -> bool {
        self.values[TAPER] != 0.0 || self.values[BEND] != 0.0
    }

    /// The candidate after a step: values add and are held in the box, the rotation turns about its own axes,
    /// `R ← R exp(δ)`; the curvature stays below what these semi-axes allow.
    pub(crate) fn stepped<const N: usize>(&self, step: &[f64; N], bounds: &Bounds) -> Self {
        let mut values = self.values;
        for (k, change) in step.iter().enumerate() {
            if let Some(value) = value_of(k) {
                values[value] = (values[value] + change).max(bounds.lower[value]).min(bounds.upper[value]);
            }
        }
        values[TAPER] = held(values[TAPER], DEFORM_SHARE * TAPER_MAX);
        values[BEND] = held(values[BEND], DEFORM_SHARE * bend_limit_per_m(values[1], values[2], values[TAPER]));
        let turn = Vector3::new(step[8], step[9], step[10]);
        let shortened = turn * (MAX_TURN_RAD / turn.norm().max(MAX_TURN_RAD));
        let R_DS = UnitQuaternion::new_unchecked(
            (self.R_DS * UnitQuaternion::from_scaled_axis(shortened)).into_inner().normalize(),
        );
        Self { values, R_DS }
    }

    /// The candidate moved into the box.
    pub(crate) fn held_in(&self, bounds: &Bounds) -> Self {
        let mut held = self.stepped(&[0.0; PLAIN], bounds);
        for k in [TAPER, BEND] {
            held.values[k] = held.values[k].max(bounds.lower[k]).min(bounds.upper[k]);
        }
        held
    }

    /// As a superquadric in another frame F, given the pose of D in F.
    pub(crate) fn superquadric(&self, X_FD: &Isometry3<f64>) -> Superquadric {
        let [a, b, c, e1, e2, _, _, _, taper, bend_per_m] = self.values;
        let X_DS = Isometry3::from_parts(Translation3::from(self.center()), self.R_DS);
        Superquadric { a, b, c, e1, e2, X_FS: X_FD * X_DS, taper, bend_per_m }
    }
}

fn held(value: f64, most: f64) -> f64 {
    value.max(-most).min(most)
}
