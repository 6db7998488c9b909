//! The working frame D, which belongs to the object and its view and not to the frame the cloud came in.
//!
//! The voxel grid, the search grids and the rounding all live in D, so a cloud that is moved rigidly gives the fit
//! that is moved rigidly (up to rounding).

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, SymmetricEigen, Translation3, Unit, UnitQuaternion, Vector3};

use crate::segment::Plane;

/// Mean of a set of points; the origin for none.
pub(crate) fn centroid<'a>(points: impl ExactSizeIterator<Item = &'a Point3<f64>>) -> Point3<f64> {
    let count = points.len().max(1) as f64;
    Point3::from(points.map(|p| p.coords).sum::<Vector3<f64>>() / count)
}

/// Mean distance of the points from their mean, metres.
pub(crate) fn mean_radius_m(points: &[(Point3<f64>, f64)]) -> f64 {
    let center = centroid(points.iter().map(|(p, _)| p));
    points.iter().map(|(p, _)| (p - center).norm()).sum::<f64>() / points.len().max(1) as f64
}

/// Principal axes as columns of a right-handed matrix, longest deviation first, and the deviations in metres.
///
/// Each axis points to the side with the longer tail (third moment), so that the axes turn with the cloud.
pub(crate) fn principal_axes(points: &[Point3<f64>]) -> (Matrix3<f64>, Vector3<f64>) {
    let mean = centroid(points.iter());
    let mut covariance = Matrix3::zeros();
    for p in points {
        let v = p - mean;
        covariance += v * v.transpose();
    }
    covariance /= points.len().max(1) as f64;
    let eigen = SymmetricEigen::new(covariance);
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| eigen.eigenvalues[*j].total_cmp(&eigen.eigenvalues[*i]));
    let mut axes = order.map(|k| {
        let axis = Vector3::from(eigen.eigenvectors.column(k));
        let skew: f64 = points.iter().map(|p| axis.dot(&(p - mean))).map(|x| x * x * x).sum();
        if skew < 0.0 { -axis } else { axis }
    });
    axes[2] = axes[0].cross(&axes[1]);
    let deviations = Vector3::from(order.map(|k| eigen.eigenvalues[k].max(0.0).sqrt()));
    (Matrix3::from_columns(&axes), deviations)
}

/// Pose of the working frame D in F.
///
/// * Table known: z_D is its normal and the origin lies on it below the cloud; x_D points away from the camera if that
///   is known, else along the cloud's first principal axis.
/// * Camera alone: the axes of the camera, the origin in the cloud.
/// * Neither: the principal axes.
pub(crate) fn working_frame(
    points: &[Point3<f64>],
    X_FC: Option<&Isometry3<f64>>,
    table: Option<&Plane>,
) -> Isometry3<f64> {
    let mean = centroid(points.iter());
    let Some(table) = table else {
        let rotation = match X_FC {
            Some(X_FC) => X_FC.rotation,
            None => rotation_of(principal_axes(points).0),
        };
        return Isometry3::from_parts(Translation3::from(mean.coords), rotation);
    };
    let up = table.normal.into_inner();
    let flat = |v: Vector3<f64>| Unit::try_new(v - up * up.dot(&v), 1e-6);
    let ahead = X_FC
        .and_then(|X_FC| flat(mean.coords - X_FC.translation.vector))
        .or_else(|| flat(principal_axes(points).0.column(0).into()))
        .or_else(|| flat(Vector3::x()))
        .unwrap_or_else(Vector3::y_axis);
    let axes = Matrix3::from_columns(&[ahead.into_inner(), up.cross(&ahead), up]);
    let origin = mean.coords - up * table.height(&mean);
    Isometry3::from_parts(Translation3::from(origin), rotation_of(axes))
}

/// The rotation with these right-handed orthonormal columns.
pub(crate) fn rotation_of(axes: Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}
