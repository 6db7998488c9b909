//! Table 3.2: how the voxel size changes error and time.

use super::Experiment;
use super::equivalence::equivalent_exponents;
use super::protocol::{THESIS_POINTS, even_cloud};
use super::row::rows;
use super::run::{ExperimentRefusal, ExperimentSettings, Outcome, each, plain_fit, shapes};
use super::trial::{Question, Trial, Truth};
use crate::fit::{FitInput, FitSettings};
use crate::watch::Watch;

/// The voxel sizes of the table, metres.
const VOXELS_M: [f64; 6] = [0.005, 0.010, 0.015, 0.020, 0.025, 0.030];

pub(super) fn run(settings: &ExperimentSettings, watch: Watch<'_>) -> Result<Outcome, ExperimentRefusal> {
    let trials = each(&shapes(settings)?, watch, |trial, shape| {
        let cloud = even_cloud(shape, THESIS_POINTS);
        let names = equivalent_exponents(shape);
        let truth = Truth::of_shape(shape, &names, &cloud);
        let fits = VOXELS_M.iter().map(|&voxel_m| {
            let question = Question {
                experiment: Experiment::Downsampling,
                condition: &format!("voxel {voxel_m:.3} m"),
                trial,
                input: FitInput { points: &cloud, X_FC: None, table: None },
                settings: &FitSettings { voxel_m, ..plain_fit() },
            };
            Trial::run(&question, &truth, watch)
        });
        fits.collect()
    })?;
    Ok(Outcome { rows: rows(&trials, settings.is_serial), trials })
}
