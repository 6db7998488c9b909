//! A convex body: a core swept by a ball.

use nalgebra::{Isometry3, Vector3};

use super::frames::Rigid;
use super::hull::ConvexHull;

/// The part of a body that remains when its rounding is taken off.
#[derive(Clone, Debug)]
pub(crate) enum Core {
    /// A segment in the frame that carries the body; a point when both ends are equal.
    Segment { a: Vector3<f64>, b: Vector3<f64> },
    /// A box about the origin of the body's own frame.
    Box { half: Vector3<f64> },
    /// A cylinder along z about the origin of the body's own frame.
    Cylinder { radius: f64, half_length: f64 },
    /// A triangle in the body's own frame, its middle at the origin.
    Triangle { corners: [Vector3<f64>; 3] },
    /// A convex hull in the body's own frame.
    Hull(ConvexHull),
}

/// A body B in the frame F that carries it: `core ⊕ ball(radius)`.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pub(crate) core: Core,
    /// Pose of the body's own frame; identity for segments, whose ends stand in F already.
    pub(crate) X_FB: Rigid,
    /// Rounding, metres.
    pub(crate) radius: f64,
    /// Centre of a ball around the body, in F.
    pub(crate) center: Vector3<f64>,
    /// Radius of that ball, metres.
    pub(crate) bound: f64,
}

impl Solid {
    /// A body at a pose in the frame that carries it.
    pub(crate) fn new(core: Core, radius: f64, X_FB: &Isometry3<f64>) -> Self {
        let X = Rigid::from_isometry(X_FB);
        let (core, X_FB) = match core {
            Core::Segment { a, b } => (Core::Segment { a: X.point(&a), b: X.point(&b) }, Rigid::identity()),
            other => (other, X),
        };
        let (center_B, core_bound) = match &core {
            Core::Segment { a, b } => (0.5 * (a + b), 0.5 * (a - b).norm()),
            Core::Box { half } => (Vector3::zeros(), half.norm()),
            Core::Cylinder { radius, half_length } => {
                (Vector3::zeros(), (radius * radius + half_length * half_length).sqrt())
            }
            Core::Triangle { corners } => (Vector3::zeros(), corners.iter().map(|p| p.norm()).fold(0.0, f64::max)),
            Core::Hull(hull) => hull.ball(),
        };
        Self { center: X_FB.point(&center_B), core, X_FB, radius, bound: core_bound + radius }
    }

    /// The same body carried by another frame G.
    pub(crate) fn carried_by(&self, X_GF: &Isometry3<f64>) -> Self {
        let X = Rigid::from_isometry(X_GF);
        let (core, X_GB) = match &self.core {
            Core::Segment { a, b } => (Core::Segment { a: X.point(a), b: X.point(b) }, Rigid::identity()),
            other => (other.clone(), X.then(&self.X_FB)),
        };
        Self { core, X_FB: X_GB, radius: self.radius, center: X.point(&self.center), bound: self.bound }
    }

    /// Pose of the body's own frame, given the pose of the frame that carries it.
    #[inline]
    pub(crate) fn placed(&self, X_WF: &Rigid) -> Rigid {
        match self.core {
            Core::Segment { .. } => *X_WF,
            _ => X_WF.then(&self.X_FB),
        }
    }

    /// Corners of the axis-aligned box around the body in the frame that carries it.
    pub(crate) fn aabb(&self) -> (Vector3<f64>, Vector3<f64>) {
        let extreme = |axis: usize, sign: f64| {
            let mut direction = Vector3::zeros();
            direction[axis] = sign;
            let support = self.core.support(&self.X_FB.R.tr_mul(&direction));
            self.X_FB.point(&support)[axis] + sign * self.radius
        };
        (Vector3::from_fn(|i, _| extreme(i, -1.0)), Vector3::from_fn(|i, _| extreme(i, 1.0)))
    }
}

impl Core {
    /// The farthest point of the core in a direction, both in the body's own frame.
    #[inline]
    pub(crate) fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Segment { a, b } => {
                if direction.dot(&(b - a)) > 0.0 {
                    *b
                } else {
                    *a
                }
            }
            Self::Box { half } => Vector3::from_fn(|i, _| if direction[i] < 0.0 { -half[i] } else { half[i] }),
            Self::Cylinder { radius, half_length } => {
                let planar = (direction.x * direction.x + direction.y * direction.y).sqrt();
                let scale = if planar > 0.0 { radius / planar } else { 0.0 };
                let z = if direction.z < 0.0 { -half_length } else { *half_length };
                Vector3::new(direction.x * scale, direction.y * scale, z)
            }
            Self::Triangle { corners: [a, b, c] } => {
                let farther =
                    |p: &Vector3<f64>, q: &Vector3<f64>| if q.dot(direction) > p.dot(direction) { *q } else { *p };
                farther(&farther(a, b), c)
            }
            Self::Hull(hull) => hull.support(direction),
        }
    }
}
