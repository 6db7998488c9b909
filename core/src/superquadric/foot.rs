//! The nearest point of the surface: where a contact is.

use nalgebra::Point3;

use super::SurfaceSample;
use super::distance::DistanceField;

/// Corrections at most; about four are usual.
const ROUNDS: u32 = 24;
/// The foot is found when the way to it leaves the normal by less than this angle's sine, or this length, metres.
const SKEW: f64 = 1e-3;
const SKEW_M: f64 = 1e-7;

impl DistanceField {
    /// The foot of a point of F on the surface, and the normal there: exactly on the surface, and nearest within a
    /// neighbourhood of where the ray of [`DistanceField::signed_distance`] leaves it.
    ///
    /// Steps along the tangent plane, back onto the surface along the (base) ray, and shorter ones while the distance
    /// does not fall. In a hollow with two feet either may be found.
    pub fn foot(&self, p_F: &Point3<f64>) -> SurfaceSample {
        let (distance_m, n_F) = self.signed_distance_and_normal(p_F);
        let mut foot = self.onto_surface(&(p_F - n_F * distance_m));
        let mut length = 1.0;
        for _ in 0..ROUNDS {
            let to_point = p_F - foot.p_F;
            let skew = to_point - foot.n_F * foot.n_F.dot(&to_point);
            if skew.norm() <= SKEW * to_point.norm() + SKEW_M {
                break;
            }
            let next = self.onto_surface(&(foot.p_F + skew * length));
            if (p_F - next.p_F).norm() < to_point.norm() {
                foot = next;
            } else {
                length *= 0.5;
            }
        }
        foot
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::super::{Superquadric, bend_limit_per_m};
    use crate::rng::Rng;

    #[test]
    fn feet_lie_on_the_surface_and_are_nearest() {
        let mut rng = Rng::new(50, 0);
        for round in 0..16 {
            let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.12));
            let (e1, e2) = (rng.uniform(0.1, 1.5), rng.uniform(0.1, 1.5));
            let plain = Superquadric::new(axes[0], axes[1], axes[2], e1, e2, Isometry3::identity()).unwrap();
            let taper = if round % 3 == 0 { 0.0 } else { rng.uniform(-0.6, 0.6) };
            let most = if round % 2 == 0 { 0.0 } else { 0.6 * bend_limit_per_m(plain.b, plain.c, taper) };
            let s = plain.deformed(taper, rng.uniform(-most, most)).unwrap();
            let field = s.distance_field();
            let samples = s.samples_spaced(0.003);
            for q in samples.iter().step_by(41) {
                let p = q.p_F + q.n_F * rng.uniform(0.0, 0.012);
                let foot = field.foot(&p);
                assert!(s.ln_inside_outside(&foot.p_F).abs() < 1e-9, "{s:?}");
                assert!(foot.n_F.dot(&s.normal_at(&foot.p_F)) > 1.0 - 1e-9);
                let nearest = samples.iter().map(|q| (q.p_F - p).norm()).min_by(f64::total_cmp).unwrap();
                // No sample is nearer: to 0.1 mm, which a hollow or an edge may leave.
                assert!((p - foot.p_F).norm() < nearest + 1e-4, "{} {nearest} {s:?}", (p - foot.p_F).norm());
            }
        }
    }
}
