//! What the trials of one condition come to.

use super::Experiment;
use super::equivalence::EXPONENT_TOLERANCE;
use super::record::{Cell, Record};
use super::reference::{ThesisRow, thesis_row};
use super::summary::Summary;
use super::trial::{Answer, Trial};
use crate::fit::ObjectiveKind;

/// A fit whose E_r on the full clean cloud is below this has found the shape, metres.
pub const RECOVERED_M: f64 = 0.001;

/// One row of a table: the trials that share condition, objective and, where there are objects, the object.
#[derive(Clone, Debug)]
pub struct Row {
    /// The experiment it belongs to.
    pub experiment: Experiment,
    /// What was varied.
    pub condition: String,
    /// What was minimised.
    pub objective: ObjectiveKind,
    /// The object, or the set of objects, when the shapes are not random.
    pub object: Option<String>,
    /// Fits that were asked for.
    pub trials: usize,
    /// Fits that gave a shape.
    pub success: usize,
    /// Fits with E_r below [`RECOVERED_M`].
    pub recovered: usize,
    /// E_r, metres.
    pub radial_m: Option<Summary>,
    /// E_g as printed in (3.9).
    pub goodness_of_fit: Option<Summary>,
    /// E_g as the thesis's tables use it.
    pub goodness_of_fit_abs: Option<Summary>,
    /// Error of the volume, percent.
    pub volume_error_percent: Option<Summary>,
    /// Absolute errors of the extents, all axes of all trials, metres.
    pub extent_error_m: Option<Summary>,
    /// The largest of them, metres.
    pub extent_error_max_m: Option<f64>,
    /// Fits with both exponents within 0.1 of the truth's, up to equivalent parametrisations.
    pub exponents_within: Option<usize>,
    /// Fits whose kinds of deformation are the truth's.
    pub recognised: Option<usize>,
    /// Fits that were completed by a mirror image.
    pub mirrored: usize,
    /// Seconds per fit; `None` when fits ran side by side.
    pub time_s: Option<Summary>,
    /// The thesis's numbers for the same row.
    pub thesis: Option<ThesisRow>,
}

impl Row {
    /// The row of some trials of one condition and objective; `object` is what their rows are told apart by.
    ///
    /// * `is_timed`: whether each fit had a processor for itself.
    pub(super) fn of(trials: &[&Trial], object: Option<String>, is_timed: bool) -> Option<Self> {
        let first = trials.first()?;
        let answers: Vec<&Answer> = trials.iter().filter_map(|trial| trial.answer.as_ref().ok()).collect();
        let summary = |of: fn(&Answer) -> Option<f64>| Summary::of(answers.iter().filter_map(|answer| of(answer)));
        let extents = || answers.iter().filter_map(|a| a.extent_errors_m).flatten().map(f64::abs);
        let within = |e: f64| e <= EXPONENT_TOLERANCE;
        // How often a yes or no holds, if it was asked at all.
        let count = |of: &dyn Fn(&Answer) -> Option<bool>| {
            let said: Vec<bool> = answers.iter().filter_map(|answer| of(answer)).collect();
            (!said.is_empty()).then(|| said.iter().filter(|yes| **yes).count())
        };
        Some(Self {
            experiment: first.experiment,
            condition: first.condition.clone(),
            objective: first.objective,
            object,
            trials: trials.len(),
            success: answers.len(),
            recovered: answers.iter().filter(|a| a.errors.radial_m < RECOVERED_M).count(),
            radial_m: summary(|a| Some(a.errors.radial_m)),
            goodness_of_fit: summary(|a| Some(a.errors.goodness_of_fit)),
            goodness_of_fit_abs: summary(|a| Some(a.errors.goodness_of_fit_abs)),
            volume_error_percent: summary(|a| a.volume_error_percent),
            extent_error_m: Summary::of(extents()),
            extent_error_max_m: extents().reduce(f64::max),
            exponents_within: count(&|a| a.exponent_error.map(within)),
            recognised: count(&|a| a.is_recognised),
            mirrored: answers.iter().filter(|a| a.is_mirrored).count(),
            time_s: if is_timed { summary(|a| Some(a.time_s)) } else { None },
            thesis: thesis_row(first.experiment, &first.condition, first.objective),
        })
    }

    /// Share of the fits with both exponents within 0.1, percent.
    pub fn exponents_within_percent(&self) -> Option<f64> {
        Some(100.0 * self.exponents_within? as f64 / self.trials.max(1) as f64)
    }
}

/// One row per condition and objective, in the order in which they come first.
pub(super) fn rows(trials: &[Trial], is_timed: bool) -> Vec<Row> {
    let mut groups: Vec<Vec<&Trial>> = Vec::new();
    for trial in trials {
        let is_alike = |group: &&mut Vec<&Trial>| {
            group.first().is_some_and(|first| first.condition == trial.condition && first.objective == trial.objective)
        };
        match groups.iter_mut().find(is_alike) {
            Some(group) => group.push(trial),
            None => groups.push(vec![trial]),
        }
    }
    groups.iter().filter_map(|group| Row::of(group, None, is_timed)).collect()
}

impl Record for Row {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let mut cells: Vec<(&'static str, Cell)> = vec![
            ("experiment", self.experiment.name().into()),
            ("condition", self.condition.as_str().into()),
            ("objective", self.objective.name().into()),
            ("object", self.object.as_deref().into()),
            ("trials", self.trials.into()),
            ("success", self.success.into()),
            ("recovered", self.recovered.into()),
        ];
        let mut summary = |names: [&'static str; 3], of: &Option<Summary>| {
            let values = [of.map(|s| s.mean), of.map(|s| s.median), of.map(|s| s.p95)];
            cells.extend(names.into_iter().zip(values.map(Cell::from)));
        };
        summary(["radial_mean_m", "radial_median_m", "radial_p95_m"], &self.radial_m);
        summary(["goodness_of_fit_mean", "goodness_of_fit_median", "goodness_of_fit_p95"], &self.goodness_of_fit);
        summary(
            ["goodness_of_fit_abs_mean", "goodness_of_fit_abs_median", "goodness_of_fit_abs_p95"],
            &self.goodness_of_fit_abs,
        );
        summary(
            ["volume_error_mean_percent", "volume_error_median_percent", "volume_error_p95_percent"],
            &self.volume_error_percent,
        );
        summary(["extent_error_mean_m", "extent_error_median_m", "extent_error_p95_m"], &self.extent_error_m);
        summary(["time_mean_s", "time_median_s", "time_p95_s"], &self.time_s);
        let thesis = self.thesis.as_ref();
        cells.extend([
            ("extent_error_max_m", Cell::from(self.extent_error_max_m)),
            ("exponents_within_0_1_percent", self.exponents_within_percent().into()),
            ("recognised", self.recognised.into()),
            ("mirrored", self.mirrored.into()),
            ("thesis_radial_mean_m", thesis.map(|row| row.radial_mean_m).into()),
            ("thesis_radial_median_m", thesis.and_then(|row| row.radial_median_m).into()),
            ("thesis_goodness_of_fit_abs_mean", thesis.and_then(|row| row.goodness_of_fit_abs_mean).into()),
            ("thesis_volume_error_mean_percent", thesis.map(|row| row.volume_error_mean_percent).into()),
            ("thesis_time_mean_s", thesis.map(|row| row.time_mean_s).into()),
        ]);
        cells
    }
}
