//! The trials on which other programs were measured: what is fitted is exactly what they were given.
//!
//! A dense cloud drawn at random by area, one point per square of 2 mm and between 20 000 and 200 000 of them; noise and
//! cut on the dense cloud; then the centroids of 0.015 m voxels without their counts, fitted as they are.

use super::Experiment;
use super::equivalence::equivalent_exponents;
use super::protocol::{Clouds, Visibility, random_cloud};
use super::row::rows;
use super::run::{ExperimentRefusal, ExperimentSettings, Outcome, each, plain_fit, shapes, stream};
use super::trial::{Question, Trial, Truth};
use crate::cloud::voxel_centroids;
use crate::fit::{FitInput, FitSettings};
use crate::rng::Rng;
use crate::superquadric::Superquadric;
use crate::watch::Watch;

/// Side of the square that each point of the dense cloud stands for, metres.
const SPACING_M: f64 = 0.002;
/// Fewest and most points of the dense cloud.
const COUNTS: [usize; 2] = [20_000, 200_000];
/// Edge of the voxels, metres.
const VOXEL_M: f64 = 0.015;

/// The dense clouds of a shape.
pub fn peers_clouds(shape: &Superquadric, rng: &mut Rng) -> Clouds {
    let full = random_cloud(shape, SPACING_M, COUNTS, rng);
    Clouds::new(full, rng)
}

/// What is given to the fit under a condition: voxel centroids.
pub fn peers_input(clouds: &Clouds, visibility: Visibility) -> Vec<nalgebra::Point3<f64>> {
    voxel_centroids(&clouds.seen(visibility), VOXEL_M)
}

pub(super) fn run(settings: &ExperimentSettings, watch: Watch<'_>) -> Result<Outcome, ExperimentRefusal> {
    let trials = each(&shapes(settings)?, watch, |trial, shape| {
        let clouds = peers_clouds(shape, &mut stream(settings, trial, 1));
        let names = equivalent_exponents(shape);
        let truth = Truth::of_shape(shape, &names, &clouds.full);
        let fits = Visibility::ALL.into_iter().map(|visibility| {
            let question = Question {
                experiment: Experiment::Peers,
                condition: visibility.name(),
                trial,
                input: FitInput { points: &peers_input(&clouds, visibility), X_FC: None, table: None },
                settings: &FitSettings { voxel_m: 0.0, ..plain_fit() },
            };
            Trial::run(&question, &truth, watch)
        });
        fits.collect()
    })?;
    Ok(Outcome { rows: rows(&trials, settings.is_serial), trials })
}
