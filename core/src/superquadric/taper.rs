//! Taper along z: sections are scaled by `s(z) = 1 + K z/c` (the thesis's one-parameter taper).

use nalgebra::{Point3, Vector3};

/// The taper K of a body with semi-axis c.
///
/// Within the body, `|z| ≤ c`, the scale is `s = 1 + K z/c`. Outside, where that would reach 0 and turn space inside
/// out, it goes on with the same value and slope as `s = e²/(e + |K| (|z|/c - 1))`, `e = 1 - |K|`: never 0, so the map
/// has an inverse for every point of space. The surface, which lies in `|z| ≤ c`, does not notice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taper {
    taper: f64,
    inverse_c: f64,
    /// e: scale at the thin end.
    thin: f64,
}

/// The scale s of a section with its derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectionScale {
    /// s.
    pub(super) value: f64,
    /// ∂s/∂z, 1/m.
    pub(super) by_z: f64,
    /// ∂s/∂K.
    pub(super) by_taper: f64,
    /// ∂s/∂c, 1/m.
    pub(super) by_c: f64,
}

impl Taper {
    /// A taper with |K| < 1 along a semi-axis c in metres.
    #[inline(always)]
    pub(super) fn new(taper: f64, c: f64) -> Self {
        Self { taper, inverse_c: 1.0 / c, thin: 1.0 - taper.abs() }
    }

    /// The scale of the section at height z, metres.
    #[inline(always)]
    pub(super) fn scale(&self, z: f64) -> SectionScale {
        let t = z * self.inverse_c;
        let beyond = t.abs() - 1.0;
        let (value, by_t, by_taper) = if beyond <= 0.0 || self.taper * t >= 0.0 {
            (1.0 + self.taper * t, self.taper, t)
        } else {
            let over = 1.0 / (self.thin + self.taper.abs() * beyond);
            let ratio = self.thin * over; // s/e
            let by_magnitude = -2.0 * ratio - ratio * ratio * (beyond - 1.0);
            (self.thin * ratio, self.taper * ratio * ratio, by_magnitude * 1f64.copysign(self.taper))
        };
        let by_z = by_t * self.inverse_c;
        SectionScale { value, by_z, by_taper, by_c: -by_z * t }
    }

    /// The tapered place of a point of the base shape.
    #[inline(always)]
    pub(super) fn tapered(&self, p: &Point3<f64>) -> Point3<f64> {
        let s = self.scale(p.z).value;
        Point3::new(s * p.x, s * p.y, p.z)
    }

    /// The inverse of [`Taper::tapered`], with the scale there.
    #[inline(always)]
    pub(super) fn straightened(&self, p: &Point3<f64>) -> (Point3<f64>, SectionScale) {
        let scale = self.scale(p.z);
        let over = 1.0 / scale.value;
        (Point3::new(p.x * over, p.y * over, p.z), scale)
    }
}

impl SectionScale {
    /// `J v`: the derivative of the inverse map at the base point p0, applied to a motion v of the tapered point.
    #[inline(always)]
    pub(super) fn inverse_times(&self, p0: &Point3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
        let over = 1.0 / self.value;
        let shrink = self.by_z * v.z;
        Vector3::new((v.x - p0.x * shrink) * over, (v.y - p0.y * shrink) * over, v.z)
    }

    /// `Jᵀ g`: the gradient over tapered points of a function with gradient g over base points.
    #[inline(always)]
    pub(super) fn inverse_transposed_times(&self, p0: &Point3<f64>, g: &Vector3<f64>) -> Vector3<f64> {
        let over = 1.0 / self.value;
        Vector3::new(g.x * over, g.y * over, g.z - (g.x * p0.x + g.y * p0.y) * self.by_z * over)
    }

    /// The derivative of the base point p0 by a parameter by which the scale has the derivative `by`.
    #[inline(always)]
    pub(super) fn inverse_by(&self, p0: &Point3<f64>, by: f64) -> Vector3<f64> {
        let share = -by / self.value;
        Vector3::new(p0.x * share, p0.y * share, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_is_linear_in_the_body_smooth_at_its_end_and_positive_beyond() {
        for taper in [-0.95, -0.4, 0.0, 0.3, 0.95] {
            let c = 0.1;
            let made = Taper::new(taper, c);
            for k in -40..=40 {
                let z = 0.013 * f64::from(k);
                let scale = made.scale(z);
                assert!(scale.value > 0.0);
                if z.abs() <= c {
                    assert!((scale.value - (1.0 + taper * z / c)).abs() < 1e-15);
                }
                let h = 1e-7;
                let by_z = (made.scale(z + h).value - made.scale(z - h).value) / (2.0 * h);
                let by_c =
                    (Taper::new(taper, c + h).scale(z).value - Taper::new(taper, c - h).scale(z).value) / (2.0 * h);
                // h = 1e-7 with curvatures up to 2 K²/(c² e) = 4000 leaves rounding, 1e-16/1e-7, and 4e-4.
                assert!((scale.by_z - by_z).abs() < 1e-5 && (scale.by_c - by_c).abs() < 1e-4, "{taper} {z}");
                let at = |k: f64| Taper::new(k, c).scale(z).value;
                if taper != 0.0 {
                    let by_taper = (at(taper + h) - at(taper - h)) / (2.0 * h);
                    assert!((scale.by_taper - by_taper).abs() < 1e-4, "{taper} {z}: {} {by_taper}", scale.by_taper);
                }
            }
        }
    }
}
