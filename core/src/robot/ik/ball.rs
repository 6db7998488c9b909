//! A ball of three joints: a rotation split into turns about three successive perpendicular axes.

use nalgebra::{Matrix3, Unit, Vector3};

use super::solve::axis_rotation;
use crate::math;

/// Below this sine of the middle joint's angle the outer axes count as aligned. The outer angles come from a vector
/// of that length computed to 1e-16, and the third joint takes up what the first leaves, so 1e-10 costs no accuracy.
const ALIGNED: f64 = 1e-10;

/// Three joint axes through one point, `a1 ⟂ a2 ⟂ a3`, at q = 0, in the arm's base frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) a1: Vector3<f64>,
    pub(super) a2: Vector3<f64>,
    pub(super) a3: Vector3<f64>,
    /// `a2 × a1`, which completes `a1` and `a2` to a frame.
    pub(super) e1: Vector3<f64>,
    /// `a3 × a2`.
    pub(super) e3: Vector3<f64>,
    /// Angle from `a1` to `a3` about `a2` at q = 0.
    pub(super) bend0: f64,
}

/// Joint angles of a ball; the other branch is `(q1 + π, -bend, q3 + π)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct BallAngles {
    pub(super) q1: f64,
    pub(super) q2: f64,
    pub(super) q3: f64,
    pub(super) other_q2: f64,
    /// The outer axes are aligned: only `q1 ± q3` is fixed and both branches are the same.
    pub(super) aligned: bool,
}

impl Ball {
    pub(super) fn new(a1: &Unit<Vector3<f64>>, a2: &Unit<Vector3<f64>>, a3: &Unit<Vector3<f64>>) -> Self {
        let (a1, a2, a3) = (a1.into_inner(), a2.into_inner(), a3.into_inner());
        let e1 = a2.cross(&a1);
        Self { a1, a2, a3, e1, e3: a3.cross(&a2), bend0: math::atan2(a3.dot(&e1), a3.dot(&a1)) }
    }

    /// `exp(a1 q1) exp(a2 q2) exp(a3 q3)`.
    pub(super) fn rotation(&self, q1: f64, q2: f64, q3: f64) -> Matrix3<f64> {
        axis_rotation(&self.a1, q1) * axis_rotation(&self.a2, q2) * axis_rotation(&self.a3, q3)
    }

    /// Angles with `rotation = exp(a1 q1) exp(a2 q2) exp(a3 q3)`, `bend = q2 + bend0` in [0, π]; q1 = 0 when aligned.
    pub(super) fn angles(&self, rotation: &Matrix3<f64>) -> BallAngles {
        // exp(a2 ·) turns a1 towards e1, so the third axis is carried to u = a1 cos b + sin b · exp(a1 q1) e1.
        let u = rotation * self.a3;
        let (x, y, along) = (u.dot(&self.e1), u.dot(&self.a2), u.dot(&self.a1));
        let sine = (x * x + y * y).sqrt();
        let bend = math::atan2(sine, along);
        let aligned = sine < ALIGNED;
        let (q1, cos1, sin1) = if aligned { (0.0, 1.0, 0.0) } else { (math::atan2(y, x), x / sine, y / sine) };
        // exp(a1 q1) a2 is where the second joint's axis stands; the third joint turns it to rotation · a2.
        let axis2 = self.a2 * cos1 - self.e1 * sin1;
        let q3 = self.last_angle(rotation, &axis2);
        BallAngles { q1, q2: bend - self.bend0, q3, other_q2: -bend - self.bend0, aligned }
    }

    /// `q3` when the first joint stands at `q1`, for splits of an aligned ball.
    pub(super) fn last_for_first(&self, rotation: &Matrix3<f64>, q1: f64) -> f64 {
        let (sin1, cos1) = math::sin_cos(q1);
        self.last_angle(rotation, &(self.a2 * cos1 - self.e1 * sin1))
    }

    /// Angle about the carried third axis from the carried second axis to `rotation · a2`.
    fn last_angle(&self, rotation: &Matrix3<f64>, axis2: &Vector3<f64>) -> f64 {
        // In the rotated frame: Rᵀ axis2 = exp(-a3 q3) a2 = a2 cos q3 - (a3 × a2) sin q3.
        let back = rotation.tr_mul(axis2);
        math::atan2(-back.dot(&self.e3), back.dot(&self.a2))
    }
}
