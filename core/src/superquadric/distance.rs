//! Distances to the surface: the radial distance (3.4, corrected) and a fast signed bound for contact finding.

use nalgebra::{Matrix3, Point3, Vector3};

use super::{AxesGauge, Superquadric, fast_exp};

impl Superquadric {
    /// Radial distance (3.4) of a point of F, metres: `|p_S| · |1 - f^(-e1/2)|`, measured along the ray from the centre.
    ///
    /// The thesis prints the exponent `+e1/2`, which is no distance. Never smaller than the Euclidean distance. At the
    /// centre: the shortest semi-axis.
    pub fn radial_distance(&self, p_F: &Point3<f64>) -> f64 {
        self.signed_radial_distance(p_F).abs()
    }

    /// [`Superquadric::radial_distance`] with a sign: negative inside.
    pub fn signed_radial_distance(&self, p_F: &Point3<f64>) -> f64 {
        let p_S = self.to_axes(p_F);
        let radius = p_S.coords.norm();
        if radius <= self.centre_m() {
            return -self.semi_axes().min();
        }
        radius - radius * fast_exp(-self.gauge(&p_S).ln_rho)
    }

    /// A lower bound of the signed Euclidean distance of a point of F, metres; negative inside.
    ///
    /// It is the distance to the tangent plane where the ray from the centre leaves the surface,
    /// `(ρ - 1)/|∇ρ|` with `ρ = f^(e1/2)`. The body is convex, so outside nothing is nearer than this plane, and inside
    /// the plane is at least as deep as the surface: the value never exceeds the true signed distance, has its sign,
    /// and equals it to first order at the surface. So a fingertip may safely advance by it. Seen from far away past
    /// an edge or a corner it is too small by up to the distance along the face. At the centre: minus the shortest
    /// semi-axis.
    ///
    /// For many points of one shape, [`Superquadric::distance_field`] does the divisions once.
    pub fn signed_distance(&self, p_F: &Point3<f64>) -> f64 {
        self.distance_field().signed_distance(p_F)
    }

    /// [`Superquadric::signed_distance`] and the outward unit normal of that tangent plane, in F.
    ///
    /// The normal is the gradient of the distance for motions of the point along the plane and along the ray.
    pub fn signed_distance_and_normal(&self, p_F: &Point3<f64>) -> (f64, Vector3<f64>) {
        self.distance_field().signed_distance_and_normal(p_F)
    }

    /// The signed distance of this shape, prepared for many points.
    pub fn distance_field(&self) -> DistanceField {
        let R_FS = *self.X_FS.rotation.to_rotation_matrix().matrix();
        DistanceField {
            R_FS,
            center_F: self.X_FS.translation.vector,
            gauge: AxesGauge::new([self.a, self.b, self.c], [self.e1, self.e2]),
            shortest_m: self.semi_axes().min(),
            shortest_axis_F: R_FS.column(self.semi_axes().imin()).into_owned(),
            centre_squared: self.centre_m() * self.centre_m(),
        }
    }

    /// Points nearer to the centre than this are the centre, metres.
    fn centre_m(&self) -> f64 {
        1e-12 * self.semi_axes().min()
    }
}

/// The signed distance of one superquadric, prepared for many points of its frame F.
#[derive(Clone, Copy, Debug)]
pub struct DistanceField {
    R_FS: Matrix3<f64>,
    center_F: Vector3<f64>,
    gauge: AxesGauge,
    shortest_m: f64,
    shortest_axis_F: Vector3<f64>,
    centre_squared: f64,
}

impl DistanceField {
    /// As [`Superquadric::signed_distance`].
    #[inline]
    pub fn signed_distance(&self, p_F: &Point3<f64>) -> f64 {
        self.in_axes(p_F).map_or(-self.shortest_m, |(distance, _)| distance)
    }

    /// As [`Superquadric::signed_distance_and_normal`].
    #[inline]
    pub fn signed_distance_and_normal(&self, p_F: &Point3<f64>) -> (f64, Vector3<f64>) {
        match self.in_axes(p_F) {
            Some((distance, n_S)) => (distance, self.R_FS * n_S),
            None => (-self.shortest_m, self.shortest_axis_F),
        }
    }

    /// Distance and unit normal in S; `None` at the centre.
    #[inline(always)]
    fn in_axes(&self, p_F: &Point3<f64>) -> Option<(f64, Vector3<f64>)> {
        let p_S = self.R_FS.tr_mul(&(p_F.coords - self.center_F));
        if p_S.norm_squared() <= self.centre_squared {
            return None;
        }
        let gauge = self.gauge.at([p_S.x, p_S.y, p_S.z]);
        let gradient = gauge.gradient(); // of ln ρ, so |∇ρ| = ρ · |gradient|
        let per_slope = 1.0 / gradient.norm();
        Some(((1.0 - fast_exp(-gauge.ln_rho)) * per_slope, gradient * per_slope))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3};

    use super::*;
    use crate::rng::Rng;

    fn shapes() -> Vec<Superquadric> {
        let mut rng = Rng::new(8, 0);
        (0..30)
            .map(|_| {
                let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
                let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.2));
                let (e1, e2) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9));
                Superquadric::new(axes[0], axes[1], axes[2], e1, e2, X_FS).unwrap()
            })
            .collect()
    }

    #[test]
    fn radial_distance_ends_on_the_surface() {
        let mut rng = Rng::new(9, 0);
        for s in shapes() {
            for _ in 0..50 {
                let v = s.X_FS.rotation * rng.direction().component_mul(&s.semi_axes()) * rng.uniform(0.2, 3.0);
                let p_F = Point3::from(s.X_FS.translation.vector + v);
                let foot = p_F - v.scale(s.signed_radial_distance(&p_F) / v.norm());
                assert!(s.ln_inside_outside(&s.to_axes(&foot)).abs() < 1e-9, "{s:?}");
            }
        }
    }

    #[test]
    fn signed_distance_is_a_lower_bound_with_the_right_sign() {
        let mut rng = Rng::new(10, 0);
        for s in shapes() {
            let surface = s.samples_spaced(0.012);
            for _ in 0..60 {
                let v = s.X_FS.rotation * rng.direction().component_mul(&s.semi_axes()) * rng.uniform(0.3, 2.0);
                let p_F = Point3::from(s.X_FS.translation.vector + v);
                let nearest = surface.iter().map(|q| (q.p_F - p_F).norm()).min_by(f64::total_cmp).unwrap();
                let inside = s.contains(&p_F);
                let bound = s.signed_distance(&p_F);
                assert_eq!(inside, bound <= 0.0, "{s:?}");
                // `nearest` is over samples, so it may exceed the true distance by at most their spacing.
                let truth = if inside { -nearest } else { nearest };
                assert!(bound <= truth + if inside { 0.016 } else { 1e-9 }, "{bound} {truth} {s:?}");
            }
        }
    }

    #[test]
    fn signed_distance_is_exact_to_first_order_at_the_surface() {
        for s in shapes() {
            for q in s.samples(24) {
                let (distance, normal) = s.signed_distance_and_normal(&(q.p_F + q.n_F.scale(1e-7)));
                // Near an edge of radius 1 µm the plane turns within the step; elsewhere it is exact to h².
                assert!(distance > 0.0 && distance <= 1.000_001e-7 && normal.norm() > 0.999, "{distance} {s:?}");
            }
            // Above a pole, without the rounding of a pose: next to a cusp (e near 2) that alone tilts the plane.
            let upright = Superquadric { X_FS: Isometry3::identity(), ..s };
            assert!((upright.signed_distance(&Point3::new(0.0, 0.0, s.c + 1e-4)) - 1e-4).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sphere_has_the_euclidean_distance() {
        let s = Superquadric::new(0.05, 0.05, 0.05, 1.0, 1.0, Isometry3::translation(1.0, 0.0, 0.0)).unwrap();
        let mut rng = Rng::new(11, 0);
        for _ in 0..100 {
            let r = rng.uniform(0.001, 0.2);
            let p_F = Point3::from(s.X_FS.translation.vector + rng.direction() * r);
            assert!((s.signed_distance(&p_F) - (r - 0.05)).abs() < 1e-12);
            assert!((s.radial_distance(&p_F) - (r - 0.05).abs()).abs() < 1e-12);
        }
        assert_eq!(s.signed_distance(&Point3::new(1.0, 0.0, 0.0)), -0.05);
    }
}
