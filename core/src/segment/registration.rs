//! Bringing a cloud of unknown origin onto the robot's table.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::Segmentation;
use crate::cloud::PointCloud;

/// Where on the robot's table a dropped cloud shall come to stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableSpot {
    /// Height of the table top in the world, metres.
    pub height_m: f64,
    /// Where the chosen cluster's centroid comes to stand, world x and y, metres.
    pub spot_m: [f64; 2],
    /// The chosen cluster.
    pub cluster: usize,
}

/// The pose `X_WF` that puts the cloud's table onto the robot's.
///
/// The table's normal becomes +z, with the plane at the given height. The horizontal part of the viewing direction, from
/// the sensor to the chosen cluster, becomes +x: the robot looks along +x, so the sensor comes to stand on the robot's
/// side and the robot sees the surfaces that were measured. A sensor straight above gives its image's upward direction
/// instead, and a cloud without a sensor its own x axis (y, when x is nearly normal to the table). The centroid of the
/// chosen cluster (of all clusters, when there is no such cluster) comes to the given spot.
pub fn table_to_robot(segmentation: &Segmentation, cloud: &PointCloud, spot: &TableSpot) -> Isometry3<f64> {
    let chosen = segmentation.clusters.get(spot.cluster);
    let indices = chosen.into_iter().chain(segmentation.clusters.iter().filter(|_| chosen.is_none())).flatten();
    let (count, sum) = indices
        .filter_map(|index| cloud.points.get(*index as usize))
        .fold((0.0, Vector3::zeros()), |(count, sum), p| (count + 1.0, sum + p.coords));
    let centroid = Point3::from(sum / f64::max(count, 1.0));

    let z = segmentation.table.normal.into_inner();
    let flat = |direction: Vector3<f64>| {
        let part = direction - z * z.dot(&direction);
        // Within 6° of the normal (sine 0.1) a direction says nothing about forward.
        (part.norm() > 0.1 * direction.norm()).then(|| part.try_normalize(1e-9)).flatten()
    };
    let from_sensor = cloud.X_FC.and_then(|X_FC| {
        flat(centroid - Point3::from(X_FC.translation.vector)).or_else(|| flat(X_FC.rotation * -Vector3::y()))
    });
    let x = from_sensor.or_else(|| flat(Vector3::x())).or_else(|| flat(Vector3::y())).unwrap_or_else(Vector3::x);
    let R_FW = Matrix3::from_columns(&[x, z.cross(&x), z]);
    let R_WF = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R_FW.transpose()));
    let turned = R_WF * centroid;
    // In the turned frame the table plane is z = offset.
    let shift =
        Vector3::new(spot.spot_m[0] - turned.x, spot.spot_m[1] - turned.y, spot.height_m - segmentation.table.offset_m);
    Isometry3::from_parts(shift.into(), R_WF)
}
