//! Fits under examination: a shape set by a person in place of a fit, and the five objectives side by side.

use nalgebra::Point3;

use super::perceive::fit_cluster;
use crate::fit::{Fit, FitSettings, ObjectiveKind, fit_errors_of_parts};
use crate::job::{FitOutput, ObjectiveFit, Refusal, SceneOutput, SegmentOutput, SetShape};
use crate::scene::Scene;
use crate::superquadric::Superquadric;
use crate::watch::Watch;

/// Signed radial distance of every point from the nearest of the object's parts, metres, negative inside.
pub(super) fn signed_distances(fit: &Fit, points: &[Point3<f64>]) -> Vec<f64> {
    let of = |p_F: &Point3<f64>| fit.bodies().map(|body| body.signed_radial_distance(p_F)).min_by(f64::total_cmp);
    points.iter().map(|p_F| of(p_F).unwrap_or(f64::NAN)).collect()
}

/// The fits with a person's shape in place of one of them, its errors and volume computed anew.
///
/// Further parts of a composite object stay as they were fitted, and so do the history of the search, the mirrored and
/// the rejected points: they tell of the fit that the shape stands in for.
///
/// # Errors
/// A [`Refusal`] when there is no such fit.
pub(super) fn with_shape(fits: &FitOutput, segments: &SegmentOutput, shape: &SetShape) -> Result<FitOutput, Refusal> {
    let (Some(Ok(automatic)), Some(points)) = (fits.fits.get(shape.cluster), segments.clusters.get(shape.cluster))
    else {
        let message = format!("cluster {} has no fit whose shape could be set: go back to the fit", shape.cluster + 1);
        return Err(Refusal::new(message));
    };
    let mut fit = Fit { superquadric: shape.superquadric, ..automatic.clone() };
    let bodies: Vec<Superquadric> = fit.bodies().copied().collect();
    let (errors, _) = fit_errors_of_parts(&bodies, points);
    fit.radial_m = errors.radial_m;
    fit.goodness_of_fit = errors.goodness_of_fit;
    fit.goodness_of_fit_abs = errors.goodness_of_fit_abs;
    fit.volume_m3 += shape.superquadric.volume() - automatic.superquadric.volume();
    let mut shaped = fits.clone();
    shaped.distances_m[shape.cluster] = signed_distances(&fit, points);
    shaped.fits[shape.cluster] = Ok(fit);
    shaped.automatic = Some(Box::new(automatic.clone()));
    Ok(shaped)
}

/// Fits one cluster with each objective in turn and tells each result with its time in milliseconds.
pub(super) fn compare(
    scene: &Scene,
    seen: &SceneOutput,
    segments: &SegmentOutput,
    cluster: usize,
    watch: Watch<'_>,
    tell: &mut dyn FnMut(f64, ObjectiveFit),
) {
    let Some(points) = segments.clusters.get(cluster) else { return };
    for objective in ObjectiveKind::ALL {
        let started = watch.now_ms();
        let fit = fit_cluster(points, &FitSettings { objective, ..scene.fit.clone() }, seen, segments, watch);
        if watch.should_stop() {
            return;
        }
        tell(watch.now_ms() - started, ObjectiveFit { cluster, objective, fit });
    }
}
