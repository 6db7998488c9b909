//! Standing on a table as one more residual: the superquadric's lowest point is on the plane,
//! `n · t - h(n) - offset`, with its support function h.

use super::candidate::Candidate;
use crate::segment::Plane;
use crate::superquadric::{AxesGauge, fast_exp};

/// Height of the superquadric's lowest point above the plane, metres, and its derivatives.
///
/// Taper and bend are left out: they do not change the height of a shape that stands on an end of its own z axis.
pub(crate) fn standing_row<const N: usize>(candidate: &Candidate, plane: &Plane) -> (f64, [f64; N]) {
    let axes = candidate.axes();
    let dual = AxesGauge::new(axes.map(|a| 1.0 / a), candidate.exponents().map(|e| 2.0 - e));
    let n_D = plane.normal.into_inner();
    let n_S = candidate.R_DS.inverse_transform_vector(&n_D);
    let gauge = dual.at([n_S.x, n_S.y, n_S.z]);
    let support = fast_exp(gauge.ln_rho);
    let turning = gauge.gradient().cross(&n_S) * support;
    let residual = n_D.dot(&candidate.center()) - support - plane.offset_m;
    let plain = [
        -support * gauge.shares[0] / axes[0],
        -support * gauge.shares[1] / axes[1],
        -support * gauge.shares[2] / axes[2],
        support * gauge.by_exponent[0],
        support * gauge.by_exponent[1],
        n_D.x,
        n_D.y,
        n_D.z,
        -turning.x,
        -turning.y,
        -turning.z,
    ];
    let row = std::array::from_fn(|k| plain.get(k).copied().unwrap_or(0.0));
    (residual, row)
}

#[cfg(test)]
mod tests {
    use nalgebra::Unit;

    use super::*;
    use crate::fit::candidate::{Bounds, PLAIN, VALUES};
    use crate::rng::Rng;

    const FREE: Bounds = Bounds { lower: [-9.0; VALUES], upper: [9.0; VALUES] };

    #[test]
    fn standing_on_the_table_matches_central_difference_and_is_zero_when_it_stands() {
        let mut rng = Rng::new(33, 0);
        for _ in 0..200 {
            let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.3));
            let e = [0.0; 2].map(|_: f64| rng.uniform(0.12, 1.88));
            let candidate = Candidate::new(axes, e, rng.direction() * 0.3, rng.rotation());
            let normal = Unit::try_new(rng.direction(), 1e-9).unwrap();
            let plane = Plane { normal, offset_m: rng.uniform(-0.2, 0.2) };
            let (residual, row) = standing_row::<PLAIN>(&candidate, &plane);
            for k in 0..PLAIN {
                let h = 1e-6;
                let mut step = [0.0; PLAIN];
                step[k] = h;
                let ahead = standing_row::<PLAIN>(&candidate.stepped(&step, &FREE), &plane).0;
                step[k] = -h;
                let behind = standing_row::<PLAIN>(&candidate.stepped(&step, &FREE), &plane).0;
                let difference = (ahead - behind) / (2.0 * h);
                assert!((row[k] - difference).abs() < 1e-5 * (1.0 + difference.abs()), "unknown {k} {candidate:?}");
            }
            let moved = Plane { normal, offset_m: plane.offset_m + residual };
            assert!(standing_row::<PLAIN>(&candidate, &moved).0.abs() < 1e-12);
        }
    }
}
