//! A fifth of the points belongs to nothing: does the fit leave them out, and what do they cost?

use nalgebra::Point3;

use super::Experiment;
use super::equivalence::equivalent_exponents;
use super::protocol::{Clouds, THESIS_POINTS, Visibility, even_cloud};
use super::row::rows;
use super::run::{ExperimentRefusal, ExperimentSettings, Outcome, each, plain_fit, shapes, stream};
use super::trial::{Question, Trial, Truth};
use crate::fit::{FitInput, FitSettings};
use crate::rng::Rng;
use crate::watch::Watch;

/// Share of the cloud that belongs to nothing.
const SHARE: f64 = 0.2;
/// They fill the bounding box of the cloud, grown about its middle by this factor.
const BOX: f64 = 2.0;

pub(super) fn run(settings: &ExperimentSettings, watch: Watch<'_>) -> Result<Outcome, ExperimentRefusal> {
    let trials = each(&shapes(settings)?, watch, |trial, shape| {
        let clouds = Clouds::new(even_cloud(shape, THESIS_POINTS), &mut stream(settings, trial, 1));
        let names = equivalent_exponents(shape);
        let truth = Truth::of_shape(shape, &names, &clouds.full);
        let mut trials = Vec::new();
        for visibility in [Visibility::FullNoisy, Visibility::PartialNoisy] {
            let clean = clouds.seen(visibility);
            let spoilt = with_outliers(&clean, &mut stream(settings, trial, 2));
            let name = visibility.name();
            for (condition, points, reject_outliers) in [
                (format!("{name}, no outliers"), &clean, true),
                (format!("{name}, outliers rejected"), &spoilt, true),
                (format!("{name}, outliers kept"), &spoilt, false),
            ] {
                let question = Question {
                    experiment: Experiment::Outliers,
                    condition: &condition,
                    trial,
                    input: FitInput { points, X_FC: None, table: None },
                    settings: &FitSettings { reject_outliers, ..plain_fit() },
                };
                trials.push(Trial::run(&question, &truth, watch)?);
            }
        }
        Some(trials)
    })?;
    Ok(Outcome { rows: rows(&trials, settings.is_serial), trials })
}

/// The cloud with so many uniform points more that they are [`SHARE`] of all.
fn with_outliers(points: &[Point3<f64>], rng: &mut Rng) -> Vec<Point3<f64>> {
    let first = points.first().copied().unwrap_or_default();
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let (middle, half) = (nalgebra::center(&low, &high), 0.5 * BOX * (high - low));
    let count = (points.len() as f64 * SHARE / (1.0 - SHARE)).round() as usize;
    let outlier = |_| middle + half.map(|half_m| rng.uniform(-half_m, half_m));
    let outliers: Vec<Point3<f64>> = (0..count).map(outlier).collect();
    points.iter().copied().chain(outliers).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fifth_of_the_points_is_spread_over_twice_the_box() {
        let mut rng = Rng::new(8, 0);
        let cloud: Vec<Point3<f64>> = (0..4000).map(|_| Point3::from(rng.direction())).collect();
        let spoilt = with_outliers(&cloud, &mut rng);
        assert_eq!((spoilt.len(), &spoilt[..4000]), (5000, &cloud[..]));
        let reach = spoilt[4000..].iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        assert!((1.99..=2.0).contains(&reach), "{reach}");
    }
}
