//! Taper, then bend: from the base shape to the deformed one and back, with all derivatives of the way back.

use nalgebra::{Matrix3, Point3, Vector3};

use super::Superquadric;
use super::bend::{Bend, Straightened};
use super::taper::{SectionScale, Taper};

/// The deformation of one body: `p_S = bend(taper(p_0))` takes points p_0 of the base shape to the axes S.
///
/// The base shape is (3.1) itself, in the same axes. Both maps and their inverses are defined and finite for every
/// point; beyond the axis of curvature the inverse jumps (see [`Bend::straightened`]), far from any body that
/// [`Superquadric::deformed`](super::Superquadric::deformed) accepts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deformation {
    taper: Taper,
    bend: Bend,
}

/// A point before taper and bend, with the derivatives of that map.
#[derive(Clone, Copy, Debug)]
#[allow(dead_code, reason = "the fit reads ∂p_0/∂p_S")]
pub(crate) struct Undeformed {
    /// The base point p_0, metres.
    pub(crate) p_0: Point3<f64>,
    /// ∂p_0/∂p_S.
    pub(crate) by_point: Matrix3<f64>,
    /// ∂p_0/∂K, metres.
    pub(crate) by_taper: Vector3<f64>,
    /// ∂p_0/∂κ, m².
    pub(crate) by_bend: Vector3<f64>,
    /// ∂p_0/∂c at the same K: the taper K z/c changes with c.
    pub(crate) by_c: Vector3<f64>,
}

/// A point before taper and bend, with what its gradients need.
#[derive(Clone, Copy, Debug)]
pub(super) struct BasePoint {
    /// The base point, metres.
    pub(super) p_0: Point3<f64>,
    /// Before the bend, after the taper.
    pub(super) tapered: Straightened,
    /// Taper there.
    pub(super) scale: SectionScale,
}

impl Deformation {
    /// Taper K without unit and curvature κ in 1/m of a body with semi-axis c in metres.
    #[inline(always)]
    pub(crate) fn new(taper: f64, bend_per_m: f64, c: f64) -> Self {
        Self { taper: Taper::new(taper, c), bend: Bend { per_m: bend_per_m } }
    }

    /// The bend alone.
    pub(super) fn bend(&self) -> &Bend {
        &self.bend
    }

    /// The point of S where the base point p_0 ends up.
    #[inline(always)]
    pub(crate) fn deformed(&self, p_0: &Point3<f64>) -> Point3<f64> {
        self.bend.bent(&self.taper.tapered(p_0))
    }

    /// The base point p_0 of a point of S.
    #[inline(always)]
    pub(crate) fn undeformed(&self, p_S: &Point3<f64>) -> Point3<f64> {
        self.base_point(p_S).p_0
    }

    /// The base point with what its gradients need.
    #[inline(always)]
    pub(super) fn base_point(&self, p_S: &Point3<f64>) -> BasePoint {
        let tapered = self.bend.straightened(p_S);
        let (p_0, scale) = self.taper.straightened(&tapered.p);
        BasePoint { p_0, tapered, scale }
    }

    /// What [`Deformation::base_point`] gives for the deformed place of a base point of the body.
    #[inline(always)]
    pub(super) fn at_base(&self, p_0: &Point3<f64>) -> BasePoint {
        let p = self.taper.tapered(p_0);
        BasePoint { p_0: *p_0, tapered: self.bend.straight(&p), scale: self.taper.scale(p_0.z) }
    }

    /// The base point of a point of S with its derivatives by the point and by K, κ and c: what a fit needs.
    ///
    /// A residual `d(p_0)` has `∂d/∂p_S = by_pointᵀ ∇d`, `∂d/∂K = ∇d · by_taper`, and so on; d's own dependence on c
    /// comes on top of `∇d · by_c`.
    #[inline(always)]
    pub(crate) fn undeformed_with_derivatives(&self, p_S: &Point3<f64>) -> Undeformed {
        let BasePoint { p_0, tapered, scale } = self.base_point(p_S);
        let straight = tapered.inverse_jacobian();
        let columns = [0, 1, 2].map(|i| scale.inverse_times(&p_0, &straight.column(i).into_owned()));
        let by_curvature = self.bend.straightened_by_curvature(p_S, &tapered);
        Undeformed {
            p_0,
            by_point: Matrix3::from_columns(&columns),
            by_taper: scale.inverse_by(&p_0, scale.by_taper),
            by_bend: scale.inverse_times(&p_0, &by_curvature),
            by_c: scale.inverse_by(&p_0, scale.by_c),
        }
    }
}

impl BasePoint {
    /// The gradient over points of S of a function with gradient g over base points: `J^T g`.
    ///
    /// For a surface point and the base shape's normal this is the normal of the deformed surface (Barr 1984), J being
    /// the Jacobian of the way back.
    #[inline(always)]
    pub(super) fn gradient_in_axes(&self, g: &Vector3<f64>) -> Vector3<f64> {
        self.tapered.inverse_transposed_times(&self.scale.inverse_transposed_times(&self.p_0, g))
    }
}

impl Superquadric {
    /// Taper and bend of this shape.
    #[inline]
    pub(crate) fn deformation(&self) -> Deformation {
        Deformation::new(self.taper, self.bend_per_m, self.c)
    }

    /// The base point of a point of the axes S: where it was before taper and bend; itself for a plain shape.
    pub fn to_base(&self, p_S: &Point3<f64>) -> Point3<f64> {
        if self.is_deformed() { self.deformation().undeformed(p_S) } else { *p_S }
    }

    /// Where taper and bend take a base point, in S.
    pub fn from_base(&self, p_0: &Point3<f64>) -> Point3<f64> {
        if self.is_deformed() { self.deformation().deformed(p_0) } else { *p_0 }
    }

    /// The gradient in S, at the place of a base point of the body, of a function with gradient `g` there in the base.
    ///
    /// `J⁻ᵀ g` with the deformation's Jacobian J: takes normals to normals (Barr 1984), not to unit length.
    pub(super) fn gradient_from_base(&self, p_0: &Point3<f64>, g: &Vector3<f64>) -> Vector3<f64> {
        if self.is_deformed() { self.deformation().at_base(p_0).gradient_in_axes(g) } else { *g }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Parameters (K, κ, c) over the whole range, small curvatures of either sign among them.
    fn parameters(rng: &mut Rng) -> Vec<(f64, f64, f64)> {
        let mut all = vec![(0.0, 0.0, 0.1), (0.5, 0.0, 0.1), (-0.95, 0.0, 0.05), (0.0, 9.0, 0.15), (0.95, -7.0, 0.2)];
        all.extend([1e-9, -1e-6, 1e-3, -0.02, 0.3].map(|bend| (0.3, bend, 0.1)));
        all.extend((0..40).map(|_| (rng.uniform(-0.95, 0.95), rng.uniform(-8.0, 8.0), rng.uniform(0.03, 0.19))));
        all
    }

    /// Base points in and around the body, up to 1.3 c along z and away from the axis of curvature.
    fn base_point(rng: &mut Rng, bend: f64, c: f64) -> Point3<f64> {
        let p = Point3::new(rng.uniform(-0.1, 0.1), rng.uniform(-0.05, 0.05), c * rng.uniform(-1.3, 1.3));
        if bend.abs() * 0.1 > 0.8 { Point3::new(p.x, 0.5 * p.y, p.z) } else { p }
    }

    #[test]
    fn deforming_and_undeforming_are_inverse() {
        let mut rng = Rng::new(31, 0);
        for (taper, bend, c) in parameters(&mut rng) {
            let map = Deformation::new(taper, bend, c);
            for _ in 0..100 {
                let p_0 = base_point(&mut rng, bend, c);
                let back = map.undeformed(&map.deformed(&p_0));
                // The thin end of K = 0.95 magnifies rounding by 20.
                assert!((back - p_0).norm() < 1e-13, "K {taper} κ {bend} c {c} {p_0:?}");
            }
        }
    }

    #[test]
    fn all_derivatives_of_the_way_back_match_central_differences() {
        let mut rng = Rng::new(32, 0);
        for (taper, bend, c) in parameters(&mut rng) {
            for _ in 0..60 {
                let p_0 = base_point(&mut rng, bend, c);
                let p_S = Deformation::new(taper, bend, c).deformed(&p_0);
                let found = Deformation::new(taper, bend, c).undeformed_with_derivatives(&p_S);
                let h = 1e-6;
                let difference = |at: &dyn Fn(f64) -> Point3<f64>| (at(h) - at(-h)) / (2.0 * h);
                let close = |found: Vector3<f64>, wanted: Vector3<f64>, what: &str| {
                    // Rounding 1e-15/1e-6 and h² of third derivatives, 1e-12 · (20/c)³ · |x| at the thin end.
                    let scale = 1.0 + wanted.norm();
                    assert!(
                        (found - wanted).norm() < 1e-5 * scale,
                        "{what}: {found} {wanted} K {taper} κ {bend} {p_0:?}"
                    );
                };
                for axis in 0..3 {
                    let at = |h: f64| {
                        let mut moved = p_S;
                        moved[axis] += h;
                        Deformation::new(taper, bend, c).undeformed(&moved)
                    };
                    close(found.by_point.column(axis).into_owned(), difference(&at), "point");
                }
                if taper != 0.0 {
                    let by_taper = difference(&|h| Deformation::new(taper + h, bend, c).undeformed(&p_S));
                    close(found.by_taper, by_taper, "K");
                }
                close(found.by_bend, difference(&|h| Deformation::new(taper, bend + h, c).undeformed(&p_S)), "κ");
                close(found.by_c, difference(&|h| Deformation::new(taper, bend, c + h).undeformed(&p_S)), "c");
            }
        }
    }

    #[test]
    fn gradients_pull_back_through_the_jacobian() {
        let mut rng = Rng::new(33, 0);
        for (taper, bend, c) in parameters(&mut rng) {
            let map = Deformation::new(taper, bend, c);
            let p_S = map.deformed(&base_point(&mut rng, bend, c));
            let g = rng.direction();
            let wanted = map.undeformed_with_derivatives(&p_S).by_point.tr_mul(&g);
            assert!((map.base_point(&p_S).gradient_in_axes(&g) - wanted).norm() < 1e-12);
        }
    }

    #[test]
    fn everything_stays_finite_on_the_axis_of_curvature_and_far_away() {
        let map = Deformation::new(0.9, 8.0, 0.15);
        for p in [[0.0, 0.125, 0.0], [0.1, 0.125, 1e-12], [0.0, 0.5, 0.0], [3.0, -2.0, 9.0], [0.0, 0.2, -0.0]] {
            let found = map.undeformed_with_derivatives(&Point3::from(p));
            let numbers = found.by_point.iter().chain(found.by_bend.iter()).chain(found.p_0.iter());
            assert!(numbers.chain(found.by_taper.iter()).chain(found.by_c.iter()).all(|x| x.is_finite()), "{p:?}");
        }
    }
}
