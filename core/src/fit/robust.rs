//! Weights that keep noise and strays from pulling the fit.
//!
//! Two things make a plain least-squares fit of radial distances err, and both are weighed here, after each round, at
//! the shape that the round before found (iteratively reweighted least squares):
//!
//! * **Obliqueness.** Noise σ along the normal moves the radial distance by `σ √s` where the ray from the centre meets
//!   the surface obliquely (`s = (radial / normal)²`), so such points count `1/s`: the inverse of their variance. To
//!   second order the variance grows further, by `(κ σ/r)² s²`. Without it noisy half-shells come out short.
//! * **Strays.** Cauchy's weight `1 / (1 + (d / 0.7 σ)²)` of the distance d along the normal; σ is 1.4826 times the median of
//!   |d|. Rounded voxel edges, spill of noise into neighbouring voxels and gross outliers hardly count.
//!
//! On 200 half-seen noisy shapes this raises the share fitted within 1 mm from 51 to 60 %, on half-seen clean ones from
//! 91 to 94 %.

use nalgebra::Point3;

use super::objective::Residual;
use super::types::ObjectiveKind;

/// κ above: how fast the surface bends away under a shift of σ, in radii. Of 0, 1, 3 and 8 the best on noisy shapes.
const SECOND_ORDER: f64 = 1.0;
/// Strays count half at this many σ. Of 0.5, 0.7, 1, 2 and 3 the best on noisy shapes.
const STRAY_SIGMAS: f64 = 0.7;
/// Ratio of a Gaussian's σ to the median of its magnitude.
const SIGMA_PER_MEDIAN: f64 = 1.4826;
/// A residual scale below this is rounding, metres.
const MIN_SIGMA_M: f64 = 1e-5;

/// Scale of the residuals along the normal, metres: robust against up to half of the points being strays.
pub(crate) fn sigma_m(residuals: &[Residual]) -> f64 {
    if residuals.is_empty() {
        return MIN_SIGMA_M;
    }
    let mut magnitudes: Vec<f64> = residuals.iter().map(|r| r.normal_m.abs()).collect();
    let middle = magnitudes.len() / 2;
    let (_, median, _) = magnitudes.select_nth_unstable_by(middle, f64::total_cmp);
    (SIGMA_PER_MEDIAN * *median).max(MIN_SIGMA_M)
}

/// The points with their weights times what their residuals leave of them.
pub(crate) fn reweighted(
    points: &[(Point3<f64>, f64)],
    residuals: &[Residual],
    kind: ObjectiveKind,
) -> Vec<(Point3<f64>, f64)> {
    let sigma = sigma_m(residuals);
    points
        .iter()
        .zip(residuals)
        .map(|((p, weight), residual)| {
            let stray = residual.normal_m / (STRAY_SIGMAS * sigma);
            // The other objectives scale their residuals in ways of their own: theirs is the published weighting.
            let oblique = if kind == ObjectiveKind::Radial {
                let s = residual.obliqueness;
                let bent = SECOND_ORDER * sigma / residual.radius_m * s;
                s * (1.0 + bent * bent)
            } else {
                1.0
            };
            (*p, weight / (oblique * (1.0 + stray * stray)))
        })
        .collect()
}

/// Mean of the squared distances along the normal, each at most `limit_m²`: a score that strays cannot spoil, m².
pub(crate) fn truncated_mean_square(residuals: &[Residual], weights: &[(Point3<f64>, f64)], limit_m: f64) -> f64 {
    let (sum, total) = residuals.iter().zip(weights).fold((0.0, 0.0), |(sum, total), (residual, (_, weight))| {
        let d = residual.normal_m.abs().min(limit_m);
        (sum + weight * d * d, total + weight)
    });
    sum / total.max(1e-300)
}
