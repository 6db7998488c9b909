//! Distance to a bent box: the box around a tapered body, bent with it.

use nalgebra::{Point3, Vector3};

use super::bend::{Bend, Straightened};

/// The box `|x| ≤ X, |y| ≤ Y, |z| ≤ c`, bent: an arc of an annulus, extruded along x.
#[derive(Clone, Copy, Debug)]
pub(super) struct BentBox {
    half: Vector3<f64>,
    /// Middle of the end at z = c, in S; the other end has -z.
    end: Point3<f64>,
    /// cos κc and sin κc.
    cos: f64,
    sin: f64,
}

impl BentBox {
    /// Half extents before the bend, metres.
    pub(super) fn new(half: Vector3<f64>, bend: &Bend) -> Self {
        let tip = Point3::new(0.0, 0.0, half.z);
        let turn = bend.straight(&tip);
        Self { half, end: bend.bent(&tip), cos: turn.cos, sin: turn.sin }
    }

    /// Euclidean distance of a point of S, given with its place before the bend; 0 inside.
    ///
    /// Between the ends the nearest point lies at the same angle, on the nearer arc. Beyond, it lies on the end face
    /// that is nearer by angle, for a point at radius ϱ is `ϱ² + ϱ'² - 2 ϱϱ' cos Δ` from one at ϱ' (squared), and that
    /// grows with the angle Δ between them.
    #[inline(always)]
    pub(super) fn distance(&self, p_S: &Point3<f64>, straight: &Straightened) -> f64 {
        let p = &straight.p;
        let mut excess = (p.coords.abs() - self.half).sup(&Vector3::zeros());
        if excess.z > 0.0 {
            // In the frame of that end; the body is symmetric in z.
            let (dy, dz) = (p_S.y - self.end.y, p_S.z.abs() - self.end.z);
            excess.y = ((self.cos * dy - self.sin * dz).abs() - self.half.y).max(0.0);
            excess.z = self.sin * dy + self.cos * dz;
        }
        excess.norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn distance_equals_the_nearest_of_many_points_of_the_bent_box() {
        let mut rng = Rng::new(40, 0);
        for per_m in [0.0, 1e-9, 3.0, -8.0, 10.0] {
            let (half, bend) = (Vector3::new(0.03, 0.05, 0.15), Bend { per_m });
            let bent_box = BentBox::new(half, &bend);
            let n = 30;
            let at = |k: i32| f64::from(k) / f64::from(n);
            let mut grid = Vec::new();
            for j in -n..=n {
                for k in -3 * n..=3 * n {
                    grid.push(bend.bent(&Point3::new(0.0, half.y * at(j), half.z * at(k) / 3.0)));
                }
            }
            for _ in 0..200 {
                let p_S = Point3::from(rng.direction() * rng.uniform(0.0, 0.4));
                let found = bent_box.distance(&p_S, &bend.straightened(&p_S));
                let flat = |q: &Point3<f64>| (q - p_S).yz().norm();
                let nearest = grid.iter().map(flat).min_by(f64::total_cmp).unwrap();
                let wanted = ((p_S.x.abs() - half.x).max(0.0).powi(2) + nearest * nearest).sqrt();
                // The grid is 1.7 mm fine (3.2 mm on the outer arc), and its nearest point is off by up to half of it.
                assert!(found <= wanted + 1e-12 && found > wanted - 0.0025, "{found} {wanted} κ {per_m} {p_S:?}");
            }
        }
    }
}
