//! Scenes for the tests of this room: a superquadric on the table z = 0, seen by a camera from the front and above.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::segment::Plane;
use crate::superquadric::Superquadric;

/// What one camera sees of a superquadric that stands on z = 0.
pub(super) struct Scene {
    pub(super) seen: Vec<Point3<f64>>,
    pub(super) X_DC: Isometry3<f64>,
    pub(super) truth: Superquadric,
}

/// An upright shape at (0.7, 0.1) on the table, seen from 0.6 m above and behind the origin (about 40° down).
pub(super) fn standing(axes: [f64; 3], e: [f64; 2], yaw_rad: f64) -> Scene {
    let at = Translation3::new(0.7, 0.1, axes[2]);
    let X_FS = Isometry3::from_parts(at, UnitQuaternion::from_scaled_axis(Vector3::z() * yaw_rad));
    let truth = Superquadric::new(axes[0], axes[1], axes[2], e[0], e[1], X_FS).unwrap();
    let X_DC =
        Isometry3::face_towards(&Point3::new(0.0, 0.0, 0.65), &Point3::from(X_FS.translation.vector), &-Vector3::z());
    let camera = Point3::from(X_DC.translation.vector);
    // The shape is convex, so what faces the camera is what it sees; segmentation drops the lowest centimetre.
    let seen = truth
        .samples_spaced(0.0025)
        .into_iter()
        .filter(|q| q.n_F.dot(&(camera - q.p_F)) > 0.05 && q.p_F.z > 0.01)
        .map(|q| q.p_F)
        .collect();
    Scene { seen, X_DC, truth }
}

/// The table of these scenes.
pub(super) fn table() -> Plane {
    Plane { normal: Vector3::z_axis(), offset_m: 0.0 }
}
