//! Tapered and bent shapes: what a plain fit makes of them, and whether the deformation is recognised.

use super::Experiment;
use super::protocol::{THESIS_POINTS, even_cloud};
use super::row::rows;
use super::run::{ExperimentRefusal, ExperimentSettings, Outcome, each, plain_fit, shapes, stream};
use super::trial::{Question, Trial, Truth};
use crate::fit::{DeformMode, FitInput, FitSettings};
use crate::rng::Rng;
use crate::superquadric::{Superquadric, SuperquadricError, bend_limit_per_m};
use crate::watch::Watch;

/// Size of a taper, either sign.
const TAPERS: [f64; 2] = [0.2, 0.8];
/// Size of a bend as a share of the largest one that the body allows, either sign.
const BENDS: [f64; 2] = [0.3, 0.8];

/// The deformations of a shape: name, whether tapered, whether bent.
const KINDS: [(&str, bool, bool); 4] =
    [("plain", false, false), ("taper", true, false), ("bend", false, true), ("taper and bend", true, true)];

pub(super) fn run(settings: &ExperimentSettings, watch: Watch<'_>) -> Result<Outcome, ExperimentRefusal> {
    let trials = each(&shapes(settings)?, watch, |trial, plain| {
        let mut trials = Vec::new();
        for (kind, is_tapered, is_bent) in KINDS {
            let rng = &mut stream(settings, trial, 3);
            // A taper within ±0.95 and a bend below the limit are always a shape; should one not be, it stays plain.
            let shape = deformed(*plain, is_tapered, is_bent, rng).unwrap_or(*plain);
            let cloud = even_cloud(&shape, THESIS_POINTS);
            let truth = Truth { is_deformed: true, ..Truth::of_shape(&shape, &[], &cloud) };
            for (fitted, deform) in [("plain", DeformMode::None), ("auto", DeformMode::Auto)] {
                let question = Question {
                    experiment: Experiment::Deformations,
                    condition: &format!("{kind}, fitted {fitted}"),
                    trial,
                    input: FitInput { points: &cloud, X_FC: None, table: None },
                    settings: &FitSettings { deform, ..plain_fit() },
                };
                trials.push(Trial::run(&question, &truth, watch)?);
            }
        }
        Some(trials)
    })?;
    Ok(Outcome { rows: rows(&trials, settings.is_serial), trials })
}

/// The shape with a random taper, a random bend, or both.
fn deformed(
    shape: Superquadric,
    is_tapered: bool,
    is_bent: bool,
    rng: &mut Rng,
) -> Result<Superquadric, SuperquadricError> {
    let mut either_sign = |[least, most]: [f64; 2]| {
        let sign = if rng.unit() < 0.5 { -1.0 } else { 1.0 };
        sign * rng.uniform(least, most)
    };
    let (taper, bend) = (either_sign(TAPERS), either_sign(BENDS));
    let taper = if is_tapered { taper } else { 0.0 };
    let bend_per_m = if is_bent { bend * bend_limit_per_m(shape.b, shape.c, taper) } else { 0.0 };
    shape.deformed(taper, bend_per_m)
}
