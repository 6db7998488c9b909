//! Where the sensor stood and how it looked, found from the pixels of an organised cloud.
//!
//! Files do not agree on what a VIEWPOINT's rotation means: some turn the optical frame, some a viewer's frame, and
//! some clouds are stored with x right, y down, z forward, others with y up and the scene along -z. The pixels cannot
//! lie: the ray through pixel (u, v) leaves the sensor's origin towards the point that was measured there.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, SMatrix, SymmetricEigen, UnitQuaternion, Vector3};

use super::PointCloud;

/// Points that the projection is fitted to.
const SAMPLE: usize = 4096;
/// A projection whose pixels are off by more than this (root mean square) is none. Uncorrected lens distortion and
/// sub-pixel noise reach one pixel; a wrong origin is off by tens.
const MAX_RMS_PX: f64 = 3.0;
/// Within this angle of the fitted axes a stated rotation is taken as it is written, rad (2°).
const SAME_RAD: f64 = 0.035;

/// The pose of the optical frame C (x right, y down, z forward) in the frame F of the cloud.
///
/// `stated` is the pose in the file, identity where the file is silent. An organised cloud whose pixels fit a pinhole
/// at the stated origin gets the axes of that pinhole. Otherwise the stated pose counts if it says anything at all:
/// its rotation when most points lie in front of it, else the direction to the middle of the points.
pub(super) fn find_sensor(
    cloud: &PointCloud,
    stated: &Isometry3<f64>,
    notes: &mut Vec<String>,
) -> Option<Isometry3<f64>> {
    let origin = Point3::from(stated.translation.vector);
    if let Some(R_FC) = axes_from_pixels(cloud, &origin) {
        if R_FC.angle_to(&stated.rotation) < SAME_RAD {
            return Some(*stated);
        }
        notes.push(String::from("the sensor's axes were found from the pixels, not taken from VIEWPOINT"));
        return Some(Isometry3::from_parts(stated.translation, R_FC));
    }
    if *stated == Isometry3::identity() {
        return None;
    }
    let in_front = cloud.points.iter().filter(|p| stated.inverse_transform_point(p).z > 0.0).count();
    if 2 * in_front > cloud.points.len() {
        return Some(*stated);
    }
    let count = cloud.points.len() as f64;
    let middle = cloud.points.iter().fold(Vector3::zeros(), |sum, p| sum + (p - origin) / count);
    let R_FC = look_along(&middle)?;
    notes.push(String::from(
        "the rotation in VIEWPOINT turns the sensor away from the points: it was taken to look at their middle",
    ));
    Some(Isometry3::from_parts(stated.translation, R_FC))
}

/// Axes of an optical frame that looks along a direction; the roll about it is arbitrary but fixed.
fn look_along(direction: &Vector3<f64>) -> Option<UnitQuaternion<f64>> {
    let z = direction.try_normalize(1e-9)?;
    let down = if z.y.abs() < 0.9 { Vector3::y() } else { Vector3::z() };
    let x = down.cross(&z).try_normalize(1e-9)?;
    Some(from_axes(&x, &z.cross(&x), &z))
}

fn from_axes(x: &Vector3<f64>, y: &Vector3<f64>, z: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[*x, *y, *z])))
}

/// Fits `(u, v, 1) ~ K R_CF (p - origin)` (direct linear transform with a known centre) and takes it apart.
fn axes_from_pixels(cloud: &PointCloud, origin: &Point3<f64>) -> Option<UnitQuaternion<f64>> {
    let grid = cloud.grid.as_ref()?;
    if grid.pixels.len() != cloud.points.len() || grid.width < 8 || grid.height < 8 {
        return None;
    }
    // Pixel coordinates are brought to about ±1, so that the normal equations are well scaled.
    let scale = f64::from(grid.width.max(grid.height)) / 2.0;
    let samples: Vec<(f64, f64, Vector3<f64>)> = (cloud.points.iter().zip(&grid.pixels))
        .step_by(cloud.points.len().div_ceil(SAMPLE).max(1))
        .filter_map(|(p, pixel)| {
            let u = (f64::from(pixel % grid.width) - f64::from(grid.width) / 2.0) / scale;
            let v = (f64::from(pixel / grid.width) - f64::from(grid.height) / 2.0) / scale;
            Some((u, v, (p - origin).try_normalize(1e-9)?))
        })
        .collect();
    if samples.len() < 50 {
        return None;
    }
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (u, v, d) in &samples {
        let row_u = SMatrix::<f64, 9, 1>::from_column_slice(&[d.x, d.y, d.z, 0., 0., 0., -u * d.x, -u * d.y, -u * d.z]);
        let row_v = SMatrix::<f64, 9, 1>::from_column_slice(&[0., 0., 0., d.x, d.y, d.z, -v * d.x, -v * d.y, -v * d.z]);
        normal += row_u * row_u.transpose() + row_v * row_v.transpose();
    }
    let eigen = SymmetricEigen::try_new(normal, 1e-14, 1000)?;
    let least = eigen.eigenvalues.imin();
    let h = eigen.eigenvectors.column(least).into_owned();
    let row = |k: usize| Vector3::new(h[3 * k], h[3 * k + 1], h[3 * k + 2]);
    let length = row(2).norm();
    let front = samples.iter().filter(|(_, _, d)| row(2).dot(d) > 0.0).count();
    let sign = if 2 * front > samples.len() { 1.0 } else { -1.0 };
    if length < 1e-9 {
        return None;
    }
    let [p_u, p_v, z] = [0, 1, 2].map(|k| row(k) * (sign / length));
    let mut squares = 0.0;
    for (u, v, d) in &samples {
        let depth = z.dot(d).max(1e-6);
        squares += (p_u.dot(d) / depth - u).powi(2) + (p_v.dot(d) / depth - v).powi(2);
    }
    let rms_px = (squares / samples.len() as f64).sqrt() * scale;
    let x = (p_u - z * p_u.dot(&z)).try_normalize(1e-9)?;
    let y = z.cross(&x);
    // A mirrored image would need a left-handed frame.
    (rms_px < MAX_RMS_PX && y.dot(&p_v) > 0.0).then(|| from_axes(&x, &y, &z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::PixelGrid;

    /// A bumpy wall seen by a pinhole camera whose optical frame has this pose in F.
    fn wall(X_FC: &Isometry3<f64>) -> PointCloud {
        let (width, height, focal) = (64u32, 48u32, 52.5);
        let mut cloud = PointCloud {
            points: Vec::new(),
            colors: Vec::new(),
            grid: Some(PixelGrid { width, height, pixels: (0..width * height).collect() }),
            X_FC: None,
        };
        for pixel in 0..width * height {
            let (u, v) = (f64::from(pixel % width) - 31.5, f64::from(pixel / width) - 23.5);
            let z = 0.9 + 0.1 * f64::from(pixel % 7);
            cloud.points.push(X_FC * Point3::new(u * z / focal, v * z / focal, z));
        }
        cloud
    }

    #[test]
    fn axes_follow_the_pixels_whatever_the_frame() {
        let mut notes = Vec::new();
        for k in 0..20 {
            let mut rng = crate::rng::Rng::new(5, k);
            let X_FC = Isometry3::from_parts((rng.direction() * 2.0).into(), rng.rotation());
            let stated = Isometry3::from_parts(X_FC.translation, UnitQuaternion::identity());
            let found = find_sensor(&wall(&X_FC), &stated, &mut notes).unwrap();
            assert!(found.rotation.angle_to(&X_FC.rotation) < 1e-6, "{found:?} for {X_FC:?}");
        }
    }

    #[test]
    fn a_cloud_that_was_moved_away_from_its_sensor_does_not_say_where_the_sensor_is() {
        let X_FC = Isometry3::new(Vector3::new(0.4, -0.3, 1.5), Vector3::new(2.5, 0.0, 0.0));
        assert_eq!(find_sensor(&wall(&X_FC), &Isometry3::identity(), &mut Vec::new()), None);
    }

    #[test]
    fn a_stated_pose_that_sees_nothing_is_turned_towards_the_points() {
        let mut cloud = wall(&Isometry3::identity());
        cloud.grid = None;
        let stated = Isometry3::new(Vector3::zeros(), Vector3::x() * std::f64::consts::PI);
        let mut notes = Vec::new();
        let found = find_sensor(&cloud, &stated, &mut notes).unwrap();
        assert!((found.rotation * Vector3::z()).z > 0.99);
        assert_eq!(notes.len(), 1);
        assert_eq!(find_sensor(&cloud, &Isometry3::identity(), &mut notes), None);
    }
}
