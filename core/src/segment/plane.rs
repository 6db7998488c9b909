//! A plane, and the best one through points.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Unit, Vector3};
use serde::{Deserialize, Serialize};

/// The plane `normal · p = offset_m`; for a table the normal points up, away from the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Unit normal.
    pub normal: Unit<Vector3<f64>>,
    /// Distance of the plane from the origin along the normal, metres.
    pub offset_m: f64,
}

impl Plane {
    /// Signed distance of a point, positive on the side of the normal, metres.
    pub fn height(&self, p: &Point3<f64>) -> f64 {
        self.normal.dot(&p.coords) - self.offset_m
    }

    /// The same plane with its other side up.
    pub fn flipped(&self) -> Self {
        Self { normal: -self.normal, offset_m: -self.offset_m }
    }

    /// The plane with the least sum of squared distances to the points; `None` when they lie on a line.
    pub(super) fn through<'a>(points: impl Iterator<Item = &'a Point3<f64>> + Clone) -> Option<Self> {
        let (count, sum) = points.clone().fold((0.0, Vector3::zeros()), |(n, sum), p| (n + 1.0, sum + p.coords));
        let mean = sum / count;
        let scatter = points.fold(Matrix3::zeros(), |scatter, p| {
            let d = p.coords - mean;
            scatter + d * d.transpose()
        });
        let eigen = SymmetricEigen::try_new(scatter, 1e-15, 100)?;
        let least = eigen.eigenvalues.imin();
        let middle = eigen.eigenvalues.sum() - eigen.eigenvalues.min() - eigen.eigenvalues.max();
        let is_flat = middle > 1e-12 * eigen.eigenvalues.max();
        if !is_flat {
            return None;
        }
        let normal = Unit::try_new(eigen.eigenvectors.column(least).into_owned(), 1e-9)?;
        Some(Self { offset_m: normal.dot(&mean), normal })
    }

    /// Two unit vectors that span the plane, right-handed with the normal.
    pub(super) fn basis(&self) -> (Vector3<f64>, Vector3<f64>) {
        let n = self.normal.into_inner();
        // The coordinate axis that is farthest from the normal is never parallel to it.
        let axis = match n.iamin() {
            0 => Vector3::x(),
            1 => Vector3::y(),
            _ => Vector3::z(),
        };
        let u = Unit::try_new(axis - n * n.dot(&axis), 1e-9).map_or(Vector3::x(), Unit::into_inner);
        (u, n.cross(&u))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_plane_of_points_in_a_plane_is_that_plane() {
        for k in 0..50 {
            let mut rng = crate::rng::Rng::new(3, k);
            let plane =
                Plane { normal: Unit::try_new(rng.direction(), 0.1).unwrap(), offset_m: rng.uniform(-2.0, 2.0) };
            let (u, v) = plane.basis();
            assert!(u.cross(&v).dot(&plane.normal) > 1.0 - 1e-12);
            let points: Vec<Point3<f64>> = (0..40)
                .map(|_| Point3::from(plane.normal.into_inner() * plane.offset_m + u * rng.normal() + v * rng.normal()))
                .collect();
            let found = Plane::through(points.iter()).unwrap();
            assert!(points.iter().all(|p| found.height(p).abs() < 1e-9));
        }
    }

    #[test]
    fn points_on_a_line_span_no_plane() {
        let points: Vec<Point3<f64>> = (0..9).map(|k| Point3::new(f64::from(k), 2.0 * f64::from(k), 0.0)).collect();
        assert_eq!(Plane::through(points.iter()), None);
        assert_eq!(Plane::through([].iter()), None);
    }
}
