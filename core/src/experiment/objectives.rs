//! Section 3.6: the five objectives, on the clouds of Table 3.3 and on single views of objects (Figure 3.6).
//!
//! As in the thesis, errors on views of objects are evaluated on what was seen, because their true surface was not known
//! there. The curves of the figure are the trials with condition `objects`, each metric sorted.

use super::Experiment;
use super::row::rows;
use super::run::{ExperimentRefusal, ExperimentSettings, Outcome, each};
use super::trial::{Question, Trial, Truth};
use super::visibility::four_clouds;
use crate::fit::{FitInput, FitSettings, ObjectiveKind};
use crate::watch::Watch;

pub(super) fn run(settings: &ExperimentSettings, watch: Watch<'_>) -> Result<Outcome, ExperimentRefusal> {
    let mut trials = four_clouds(Experiment::Objectives, &ObjectiveKind::ALL, settings, watch)?;
    trials.extend(each(&settings.views, watch, |trial, view| {
        let truth = Truth::of_view(view, &view.points);
        let fits = ObjectiveKind::ALL.into_iter().map(|objective| {
            let question = Question {
                experiment: Experiment::Objectives,
                condition: "objects",
                trial,
                input: FitInput { points: &view.points, X_FC: view.X_FC, table: view.table },
                settings: &FitSettings { objective, ..FitSettings::default() },
            };
            Trial::run(&question, &truth, watch)
        });
        fits.collect()
    })?);
    Ok(Outcome { rows: rows(&trials, settings.is_serial), trials })
}
