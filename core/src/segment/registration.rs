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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::{Plane, PointFate};
    use nalgebra::Unit;

    /// One cluster at (0, 0, 0.1) above the plane z = 0, everything moved by `X_FG`; the sensor stands at `eye` in G.
    fn moved(X_FG: &Isometry3<f64>, eye: Option<Vector3<f64>>) -> (Segmentation, PointCloud) {
        let normal = Unit::try_new(X_FG.rotation * Vector3::z(), 0.5).unwrap();
        let segmentation = Segmentation {
            table: Plane { normal, offset_m: normal.dot(&X_FG.translation.vector) },
            outline: Vec::new(),
            table_points: 0,
            table_rms_m: 0.0,
            fates: vec![PointFate::Cluster(0); 2],
            clusters: vec![vec![0, 1]],
        };
        let points = vec![X_FG * Point3::new(-0.1, 0.0, 0.1), X_FG * Point3::new(0.1, 0.0, 0.1)];
        let X_FC = eye.map(|eye| X_FG * Isometry3::from_parts(eye.into(), UnitQuaternion::identity()));
        (segmentation, PointCloud { points, colors: Vec::new(), grid: None, X_FC })
    }

    #[test]
    fn table_spot_and_viewing_direction_come_out_right_in_any_frame() {
        let spot = TableSpot { height_m: 0.69, spot_m: [0.5, -0.2], cluster: 0 };
        for k in 0..20 {
            let mut rng = crate::rng::Rng::new(11, k);
            let X_FG = Isometry3::from_parts((rng.direction() * 3.0).into(), rng.rotation());
            // The sensor looks along +y of G.
            let (segmentation, cloud) = moved(&X_FG, Some(Vector3::new(0.0, -0.6, 0.9)));
            let X_WG = table_to_robot(&segmentation, &cloud, &spot) * X_FG;
            let at = X_WG * Point3::new(0.0, 0.0, 0.1);
            assert!((at - Point3::new(0.5, -0.2, 0.79)).norm() < 1e-9, "{at}");
            assert!((X_WG.rotation * Vector3::y() - Vector3::x()).norm() < 1e-9);
            assert!((X_WG.rotation * Vector3::z() - Vector3::z()).norm() < 1e-9);
        }
    }

    #[test]
    fn without_a_sensor_or_with_one_straight_above_the_axes_still_decide() {
        let spot = TableSpot { height_m: 0.0, spot_m: [0.0, 0.0], cluster: 7 };
        let (segmentation, cloud) = moved(&Isometry3::identity(), None);
        let X_WF = table_to_robot(&segmentation, &cloud, &spot);
        assert!((X_WF.rotation * Vector3::x() - Vector3::x()).norm() < 1e-9);
        let (segmentation, cloud) = moved(&Isometry3::identity(), Some(Vector3::new(0.0, 0.0, 1.0)));
        let X_WF = table_to_robot(&segmentation, &cloud, &spot);
        // The image's upward direction is -y here.
        assert!((X_WF.rotation * -Vector3::y() - Vector3::x()).norm() < 1e-9);
    }
}
