//! Where a ray meets the surface: for picking with a pointer.

use nalgebra::{Point3, Vector3};

use super::Superquadric;

/// A ray this close to the surface has met it, metres.
const TOUCH_M: f64 = 1e-9;
/// Advances at most; a ray that grazes the surface halves its distance with each.
const MAX_ADVANCES: u32 = 400;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance from the ray's origin, metres.
    pub distance_m: f64,
    /// The point, in F, within a nanometre of the surface.
    pub p_F: Point3<f64>,
    /// Outward unit normal of the surface there.
    pub n_F: Vector3<f64>,
}

impl Superquadric {
    /// Where a ray from a point of F first meets the surface; `None` when it does not, or when the direction is none.
    ///
    /// The direction need not be of unit length. A ray that starts inside meets the body at once, at distance 0.
    ///
    /// The ray is advanced to the plane that separates its tip from the body ([`Superquadric::signed_distance`]), which
    /// is Newton's method on a convex function from its safe side; for a deformed body, as far as its tip is provably
    /// outside. So it passes no thin edge, for any exponent.
    pub fn ray_hit(&self, origin_F: &Point3<f64>, direction_F: &Vector3<f64>) -> Option<RayHit> {
        let u_F = direction_F.try_normalize(0.0)?;
        if !origin_F.iter().chain(u_F.iter()).all(|x| x.is_finite()) {
            return None;
        }
        let field = self.distance_field();
        // Enter the ball that holds the body, wherever it is bent to.
        let widest = 1.0 + self.taper.abs();
        let reach_m = self.c + widest * (self.a * self.a + self.b * self.b).sqrt();
        let to_center = Point3::from(self.X_FS.translation.vector) - origin_F;
        let nearest_m = to_center.dot(&u_F);
        let chord_m = (reach_m * reach_m - (to_center - u_F * nearest_m).norm_squared()).max(0.0).sqrt();
        let (mut along_m, end_m) = ((nearest_m - chord_m).max(0.0), nearest_m + chord_m);
        for _ in 0..MAX_ADVANCES {
            let p_F = origin_F + u_F * along_m;
            let (distance_m, step_m) = field.distance_and_step(&p_F, &u_F);
            if distance_m <= TOUCH_M {
                return Some(RayHit { distance_m: along_m, p_F, n_F: self.normal_at(&p_F).into_inner() });
            }
            along_m += step_m;
            if along_m > end_m {
                return None;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3};

    use super::super::bend_limit_per_m;
    use super::*;
    use crate::rng::Rng;

    fn shapes() -> Vec<Superquadric> {
        let mut rng = Rng::new(60, 0);
        (0..40)
            .map(|k| {
                let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
                let axes = [0.0; 3].map(|_: f64| rng.uniform(0.02, 0.2));
                let (e1, e2) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9));
                let plain = Superquadric::new(axes[0], axes[1], axes[2], e1, e2, X_FS).unwrap();
                let taper = if k % 2 == 0 { 0.0 } else { rng.uniform(-0.95, 0.95) };
                let most = if k % 4 < 2 { 0.0 } else { bend_limit_per_m(plain.b, plain.c, taper) };
                plain.deformed(taper, rng.uniform(-most, most)).unwrap()
            })
            .collect()
    }

    /// The first point inside on a walk in steps of 0.1 mm, and whether the walk came near the surface at all.
    fn walked(s: &Superquadric, origin: &Point3<f64>, u: &Vector3<f64>, end_m: f64) -> Option<f64> {
        let steps = (end_m / 1e-4) as u32;
        (0..=steps).map(|k| f64::from(k) * 1e-4).find(|t| s.contains(&(origin + u * *t)))
    }

    #[test]
    fn hits_are_where_a_fine_walk_enters_the_body() {
        let mut rng = Rng::new(61, 0);
        let (mut hits, mut misses) = (0, 0);
        for s in shapes() {
            let center = Point3::from(s.X_FS.translation.vector);
            for _ in 0..40 {
                let origin = center + rng.direction() * 0.6;
                let target = center + rng.direction() * rng.uniform(0.0, 0.25);
                let u = (target - origin).try_normalize(0.0).unwrap();
                let found = s.ray_hit(&origin, &(u * rng.uniform(0.1, 9.0)));
                match (&found, walked(&s, &origin, &u, 1.1)) {
                    (Some(hit), walked) => {
                        hits += 1;
                        assert!((origin + u * hit.distance_m - hit.p_F).norm() < 1e-12);
                        assert!(s.signed_distance(&hit.p_F).abs() < 1e-8, "{s:?}");
                        assert!(hit.n_F.dot(&u) < 1e-3 && (hit.n_F.norm() - 1.0).abs() < 1e-9);
                        // A walk may step over a sliver, but it does not enter before the hit.
                        if let Some(walked) = walked {
                            assert!(hit.distance_m <= walked + 1e-9, "{} {walked} {s:?}", hit.distance_m);
                            let sliver = (0..20)
                                .any(|k| !s.contains(&(origin + u * (hit.distance_m + 1e-6 + 5e-6 * f64::from(k)))));
                            assert!(walked - hit.distance_m < 1.01e-4 || sliver, "{} {walked} {s:?}", hit.distance_m);
                        }
                    }
                    (None, walked) => {
                        misses += 1;
                        assert_eq!(walked, None, "{s:?} {origin:?} {u:?}");
                    }
                }
            }
        }
        assert!(hits > 400 && misses > 200, "{hits} {misses}");
    }

    #[test]
    fn rays_at_surface_points_from_outside_arrive_there_unless_something_is_in_between() {
        let mut rng = Rng::new(62, 0);
        for s in shapes() {
            for q in s.samples(10) {
                let u = (q.n_F + rng.direction() * 0.7).try_normalize(0.0).unwrap();
                let origin = q.p_F + u * 0.01;
                let is_clear = (1..100).all(|k| !s.contains(&(q.p_F + u * (1e-4 * f64::from(k)))));
                if u.dot(&q.n_F) > 0.2 && is_clear {
                    let hit = s.ray_hit(&origin, &-u).unwrap();
                    assert!((hit.p_F - q.p_F).norm() < 1e-7, "{} {s:?}", hit.distance_m);
                }
            }
        }
    }

    #[test]
    fn rays_from_inside_away_and_without_direction_have_their_answers() {
        let s = Superquadric::new(0.1, 0.1, 0.1, 1.0, 1.0, Isometry3::identity()).unwrap();
        assert_eq!(s.ray_hit(&Point3::new(0.01, 0.0, 0.0), &Vector3::x()).unwrap().distance_m, 0.0);
        assert_eq!(s.ray_hit(&Point3::new(0.2, 0.0, 0.0), &Vector3::x()), None);
        assert_eq!(s.ray_hit(&Point3::new(0.2, 0.0, 0.0), &Vector3::zeros()), None);
        assert_eq!(s.ray_hit(&Point3::new(0.2, 0.0, f64::NAN), &Vector3::x()), None);
        // Grazing: 1 µm inside and 1 µm outside of the top.
        assert!(s.ray_hit(&Point3::new(-1.0, 0.0, 0.1 - 1e-6), &Vector3::x()).is_some());
        assert!(s.ray_hit(&Point3::new(-1.0, 0.0, 0.1 + 1e-6), &Vector3::x()).is_none());
    }
}
