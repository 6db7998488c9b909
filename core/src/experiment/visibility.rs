//! Table 3.3: how noise and a partial view change error and time.

use super::Experiment;
use super::equivalence::equivalent_exponents;
use super::protocol::{Clouds, THESIS_POINTS, Visibility, even_cloud};
use super::row::rows;
use super::run::{ExperimentRefusal, ExperimentSettings, Outcome, each, plain_fit, shapes, stream};
use super::trial::{Question, Trial, Truth};
use crate::fit::{FitInput, FitSettings, ObjectiveKind};
use crate::watch::Watch;

pub(super) fn run(settings: &ExperimentSettings, watch: Watch<'_>) -> Result<Outcome, ExperimentRefusal> {
    let trials = four_clouds(Experiment::Visibility, &[ObjectiveKind::Radial], settings, watch)?;
    Ok(Outcome { rows: rows(&trials, settings.is_serial), trials })
}

/// Fits with each objective to the four clouds of every shape.
pub(super) fn four_clouds(
    experiment: Experiment,
    objectives: &[ObjectiveKind],
    settings: &ExperimentSettings,
    watch: Watch<'_>,
) -> Result<Vec<Trial>, ExperimentRefusal> {
    each(&shapes(settings)?, watch, |trial, shape| {
        let clouds = Clouds::new(even_cloud(shape, THESIS_POINTS), &mut stream(settings, trial, 1));
        let names = equivalent_exponents(shape);
        let truth = Truth::of_shape(shape, &names, &clouds.full);
        let mut trials = Vec::new();
        for visibility in Visibility::ALL {
            let points = clouds.seen(visibility);
            for &objective in objectives {
                let question = Question {
                    experiment,
                    condition: visibility.name(),
                    trial,
                    input: FitInput { points: &points, X_FC: None, table: None },
                    settings: &FitSettings { objective, ..plain_fit() },
                };
                trials.push(Trial::run(&question, &truth, watch)?);
            }
        }
        Some(trials)
    })
}
