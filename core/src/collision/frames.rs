//! Rigid transforms as matrices, and the chain of moving frames of a set of joints.

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::math;
use crate::robot::JointKind;

/// A rigid transform whose rotation is a matrix: a point costs nine multiplications.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rigid {
    pub(crate) R: Matrix3<f64>,
    pub(crate) t: Vector3<f64>,
}

impl Rigid {
    pub(crate) fn identity() -> Self {
        Self { R: Matrix3::identity(), t: Vector3::zeros() }
    }

    pub(crate) fn from_isometry(X: &Isometry3<f64>) -> Self {
        Self { R: X.rotation.to_rotation_matrix().into_inner(), t: X.translation.vector }
    }

    /// The product: `X_AB.then(X_BC)` is `X_AC`.
    #[inline]
    pub(crate) fn then(&self, other: &Self) -> Self {
        Self { R: self.R * other.R, t: self.point(&other.t) }
    }

    #[inline]
    pub(crate) fn point(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.R * p + self.t
    }

    /// The point in this frame: `Rᵀ (p − t)`.
    #[inline]
    pub(crate) fn inverse_point(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.R.tr_mul(&(p - self.t))
    }
}

/// A frame F that one joint moves relative to its parent frame P; frame 0 is the world and has no joint.
#[derive(Clone, Debug)]
pub(crate) struct MovingFrame {
    /// Index of the parent frame, smaller than the frame's own.
    pub(crate) parent: usize,
    /// Joint frame in the parent frame, at joint position 0.
    pub(crate) X_PJ: Rigid,
    /// Unit axis in the joint frame.
    pub(crate) axis: Vector3<f64>,
    /// Revolute or prismatic.
    pub(crate) kind: JointKind,
    /// Index into the checker's `q`.
    pub(crate) column: usize,
    /// Joint position = multiplier · q + offset.
    pub(crate) multiplier: f64,
    pub(crate) offset: f64,
    /// Largest distance by which a prismatic joint moves from position 0, metres; 0 when revolute.
    pub(crate) slide_m: f64,
}

impl MovingFrame {
    /// Pose of the frame in the parent's parent, given the parent's pose.
    #[inline]
    pub(crate) fn placed(&self, X_WP: &Rigid, q: &[f64]) -> Rigid {
        let position = self.multiplier * q[self.column] + self.offset;
        let X_WJ = X_WP.then(&self.X_PJ);
        match self.kind {
            JointKind::Prismatic => Rigid { R: X_WJ.R, t: X_WJ.t + X_WJ.R * self.axis * position },
            _ => Rigid { R: X_WJ.R * rotation(&self.axis, position), t: X_WJ.t },
        }
    }
}

/// Rotation about a unit axis by an angle in radians (Rodrigues).
#[inline]
fn rotation(axis: &Vector3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let (s, c) = math::sin_cos(angle_rad);
    let v = 1.0 - c;
    let (x, y, z) = (axis.x, axis.y, axis.z);
    Matrix3::new(
        c + x * x * v,
        x * y * v - z * s,
        x * z * v + y * s,
        x * y * v + z * s,
        c + y * y * v,
        y * z * v - x * s,
        x * z * v - y * s,
        y * z * v + x * s,
        c + z * z * v,
    )
}
