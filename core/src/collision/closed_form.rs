//! Exact squared distances of segments, points and boxes.

use nalgebra::Vector3;

/// Squared distance of the segments `a0 a1` and `b0 b1`, m²; either may be a point.
///
/// The minimum of a convex quadratic over the unit square: the free minimum of one parameter is clamped, the other
/// follows, and is clamped in turn (Ericson, Real-Time Collision Detection, 5.1.9).
pub(crate) fn segment_segment(a0: &Vector3<f64>, a1: &Vector3<f64>, b0: &Vector3<f64>, b1: &Vector3<f64>) -> f64 {
    let da = a1 - a0;
    let db = b1 - b0;
    let r = a0 - b0;
    let aa = da.norm_squared();
    let bb = db.norm_squared();
    let fb = db.dot(&r);
    // Below this squared length (1e-12 m) a segment is a point.
    const POINT: f64 = 1e-24;
    let (s, t) = if aa <= POINT && bb <= POINT {
        (0.0, 0.0)
    } else if aa <= POINT {
        (0.0, unit(fb / bb))
    } else {
        let ca = da.dot(&r);
        if bb <= POINT {
            (unit(-ca / aa), 0.0)
        } else {
            let ab = da.dot(&db);
            let denominator = aa * bb - ab * ab;
            // Parallel segments: any s is as good as another before t is clamped.
            let s = if denominator > 1e-14 * aa * bb { unit((ab * fb - ca * bb) / denominator) } else { 0.0 };
            let t = (ab * s + fb) / bb;
            if t < 0.0 {
                (unit(-ca / aa), 0.0)
            } else if t > 1.0 {
                (unit((ab - ca) / aa), 1.0)
            } else {
                (s, t)
            }
        }
    };
    (r + da * s - db * t).norm_squared()
}

/// Squared distance of the segment `a b` and the box of these half edge lengths about the origin, m²; 0 if they meet.
///
/// Along the segment the squared distance is convex and its derivative piecewise linear, with a kink where a
/// coordinate crosses a face: bracketing its root between the at most six kinks leaves one linear piece.
pub(crate) fn segment_box(a: &Vector3<f64>, b: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
    let d = b - a;
    let excess = |t: f64| -> Vector3<f64> {
        let p = a + d * t;
        Vector3::new(outside(p.x, half.x), outside(p.y, half.y), outside(p.z, half.z))
    };
    let e0 = excess(0.0);
    let mut slope_lo = d.dot(&e0);
    if slope_lo >= 0.0 {
        return e0.norm_squared();
    }
    let e1 = excess(1.0);
    let mut slope_hi = d.dot(&e1);
    if slope_hi <= 0.0 {
        return e1.norm_squared();
    }
    let (mut lo, mut hi) = (0.0, 1.0);
    for axis in 0..3 {
        if d[axis] == 0.0 {
            continue;
        }
        for face in [-half[axis], half[axis]] {
            let t = (face - a[axis]) / d[axis];
            if t > lo && t < hi {
                let slope = d.dot(&excess(t));
                if slope <= 0.0 {
                    (lo, slope_lo) = (t, slope);
                } else {
                    (hi, slope_hi) = (t, slope);
                }
            }
        }
    }
    let span = slope_hi - slope_lo;
    let t = if span > 0.0 { lo - (hi - lo) * slope_lo / span } else { lo };
    excess(t).norm_squared()
}

/// How far a coordinate lies outside of [-half, half], signed.
#[inline]
fn outside(x: f64, half: f64) -> f64 {
    x - x.max(-half).min(half)
}

#[inline]
fn unit(x: f64) -> f64 {
    x.max(0.0).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn point(rng: &mut Rng, scale: f64) -> Vector3<f64> {
        Vector3::new(rng.uniform(-scale, scale), rng.uniform(-scale, scale), rng.uniform(-scale, scale))
    }

    /// The smallest value of a convex function on [0, 1], by thirds.
    fn searched(value: impl Fn(f64) -> f64) -> f64 {
        let (mut lo, mut hi) = (0.0, 1.0);
        for _ in 0..120 {
            let third = (hi - lo) / 3.0;
            if value(lo + third) < value(hi - third) {
                hi -= third;
            } else {
                lo += third;
            }
        }
        value(lo).min(value(0.5 * (lo + hi)))
    }

    #[test]
    fn segment_and_box_agree_with_a_search_along_the_segment() {
        let mut rng = Rng::new(11, 0);
        for k in 0..500 {
            let half = Vector3::new(rng.uniform(0.01, 0.5), rng.uniform(0.01, 0.5), rng.uniform(0.01, 0.5));
            let a = point(&mut rng, 1.0);
            // Every fourth segment is parallel to an axis: the kinks of two coordinates vanish.
            let b = if k % 4 == 0 { a + Vector3::x() * rng.uniform(-1.0, 1.0) } else { point(&mut rng, 1.0) };
            let wanted = searched(|t| {
                let p = a + (b - a) * t;
                Vector3::from_fn(|i, _| (p[i].abs() - half[i]).max(0.0)).norm_squared()
            });
            let exact = segment_box(&a, &b, &half);
            // Squared distances carry round-off of 1e-16, whose root is 1e-8.
            assert!((exact.sqrt() - wanted.sqrt()).abs() < 1e-7, "{a} {b} {half}: {exact} {wanted}");
        }
    }

    #[test]
    fn segments_agree_with_a_search_over_one_of_them() {
        let mut rng = Rng::new(12, 0);
        for k in 0..500 {
            let (a0, a1) = (point(&mut rng, 1.0), point(&mut rng, 1.0));
            let b0 = point(&mut rng, 1.0);
            let b1 = match k % 4 {
                0 => b0,
                1 => b0 + (a1 - a0) * rng.uniform(-1.0, 1.0),
                _ => point(&mut rng, 1.0),
            };
            let wanted = searched(|t| {
                let p = a0 + (a1 - a0) * t;
                let d = b1 - b0;
                let u = if d.norm() > 0.0 { unit(d.dot(&(p - b0)) / d.norm_squared()) } else { 0.0 };
                (p - b0 - d * u).norm_squared()
            });
            let exact = segment_segment(&a0, &a1, &b0, &b1);
            assert!((exact.sqrt() - wanted.sqrt()).abs() < 1e-7, "case {k}: {exact} {wanted}");
        }
    }

    #[test]
    fn crossing_shapes_are_at_distance_zero() {
        let x = Vector3::x();
        assert_eq!(segment_segment(&-x, &x, &-Vector3::y(), &Vector3::y()), 0.0);
        assert_eq!(segment_box(&-x, &x, &Vector3::new(0.1, 0.1, 0.1)), 0.0);
    }
}
