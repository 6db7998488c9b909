//! One fit of one trial: what was asked, what came back, how far it is from the truth.

use nalgebra::{Point3, Vector3};

use super::Experiment;
use super::equivalence::exponent_error;
use super::object_views::ObjectView;
use super::record::{Cell, Record};
use crate::fit::{Fit, FitErrors, FitInput, FitRefusal, FitSettings, ObjectiveKind, fit, fit_errors};
use crate::superquadric::Superquadric;
use crate::watch::Watch;

/// What is known of the object that is fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Truth<'a> {
    /// Its name, if it has one.
    pub(super) object: Option<&'a str>,
    /// Its shape, if it is a superquadric.
    pub(super) shape: Option<&'a Superquadric>,
    /// Exponents of all parametrisations of the shape; empty when they are not compared.
    pub(super) names: &'a [[f64; 2]],
    /// Whether its deformations are to be recognised.
    pub(super) is_deformed: bool,
    /// Its volume, cubic metres; `None` when it is not known.
    pub(super) volume_m3: Option<f64>,
    /// Its extents along the axes of its own frame O with that frame's pose in F, metres.
    pub(super) extents: Option<(Vector3<f64>, nalgebra::Isometry3<f64>)>,
    /// The points that E_r and E_g are evaluated on.
    pub(super) surface: &'a [Point3<f64>],
}

impl<'a> Truth<'a> {
    /// A superquadric with the exponents of all its parametrisations, and its surface.
    pub(super) fn of_shape(shape: &'a Superquadric, names: &'a [[f64; 2]], surface: &'a [Point3<f64>]) -> Self {
        Self {
            object: None,
            shape: Some(shape),
            names,
            is_deformed: false,
            volume_m3: Some(shape.volume()),
            extents: None,
            surface,
        }
    }

    /// An object, and the points of its surface that errors are evaluated on.
    pub(super) fn of_view(view: &'a ObjectView, surface: &'a [Point3<f64>]) -> Self {
        Self {
            object: Some(&view.name),
            shape: None,
            names: &[],
            is_deformed: false,
            volume_m3: view.volume_m3.filter(|_| !view.is_hollow),
            extents: Some((view.extents_m, view.X_FO)),
            surface,
        }
    }
}

/// What is asked of the fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question<'a> {
    pub(super) experiment: Experiment,
    pub(super) condition: &'a str,
    pub(super) trial: usize,
    pub(super) input: FitInput<'a>,
    pub(super) settings: &'a FitSettings,
}

/// A fit with its errors.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The experiment it belongs to.
    pub experiment: Experiment,
    /// What was varied.
    pub condition: String,
    /// What was minimised.
    pub objective: ObjectiveKind,
    /// Number of the trial, from 0.
    pub trial: usize,
    /// The object, when it is not a random shape.
    pub object: Option<String>,
    /// The shape that was to be found, when it is a superquadric.
    pub truth: Option<Superquadric>,
    /// The answer, or why there is none.
    pub answer: Result<Answer, FitRefusal>,
}

/// What a fit gave.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The fitted shape; the largest one when there are several.
    pub found: Superquadric,
    /// Points of the input.
    pub points: usize,
    /// Points that were fitted.
    pub used_points: usize,
    /// Evaluations of the objective.
    pub iterations: u32,
    /// Points that were left out.
    pub rejected: usize,
    /// Superquadrics.
    pub parts: usize,
    /// Whether the unseen side was completed.
    pub is_mirrored: bool,
    /// E_r and E_g on the points that the experiment names.
    pub errors: FitErrors,
    /// `|V - V*| / V*`, percent.
    pub volume_error_percent: Option<f64>,
    /// The larger error of the two exponents, to the nearest equivalent parametrisation.
    pub exponent_error: Option<f64>,
    /// Extent of the fit less that of the truth along each axis of the object, metres.
    pub extent_errors_m: Option<[f64; 3]>,
    /// Whether the deformations of the fit are those of the truth, by kind.
    pub is_recognised: Option<bool>,
    /// Time of the fit, seconds.
    pub time_s: f64,
}

impl Trial {
    /// Fits and compares; `None` when the caller stopped it.
    pub(super) fn run(question: &Question<'_>, truth: &Truth<'_>, watch: Watch<'_>) -> Option<Self> {
        // The progress of one fit is none of the experiment's.
        let (stop, now) = (|| watch.should_stop(), || watch.now_ms());
        let silent = Watch::new(&stop, &|_, _| (), &now);
        let begin_ms = watch.now_ms();
        let fitted = fit(question.input, question.settings, silent);
        let time_s = (watch.now_ms() - begin_ms) * 1e-3;
        if matches!(fitted, Err(FitRefusal::Stopped)) {
            return None;
        }
        Some(Self {
            experiment: question.experiment,
            condition: question.condition.to_owned(),
            objective: question.settings.objective,
            trial: question.trial,
            object: truth.object.map(str::to_owned),
            truth: truth.shape.copied(),
            answer: fitted.map(|fitted| Answer::new(&fitted, truth, time_s)),
        })
    }
}

impl Answer {
    fn new(fitted: &Fit, truth: &Truth<'_>, time_s: f64) -> Self {
        let found = fitted.superquadric;
        let volume_m3: f64 = fitted.bodies().map(Superquadric::volume).sum();
        let is_recognised = truth.shape.filter(|_| truth.is_deformed).map(|shape| {
            (shape.taper != 0.0) == (found.taper != 0.0) && (shape.bend_per_m != 0.0) == (found.bend_per_m != 0.0)
        });
        Self {
            found,
            points: fitted.points,
            used_points: fitted.used_points,
            iterations: fitted.iterations,
            rejected: fitted.rejected.len(),
            parts: 1 + fitted.others.len(),
            is_mirrored: !fitted.mirrored.is_empty(),
            errors: fit_errors(&found, truth.surface),
            volume_error_percent: truth.volume_m3.map(|wanted| 100.0 * (volume_m3 / wanted - 1.0).abs()),
            exponent_error: (!truth.names.is_empty()).then(|| exponent_error(truth.names, [found.e1, found.e2])),
            extent_errors_m: truth.extents.map(|(extents, X_FO)| {
                let half = found.half_extents_in(&X_FO.inverse());
                [0, 1, 2].map(|axis| 2.0 * half[axis] - extents[axis])
            }),
            is_recognised,
            time_s,
        }
    }
}

impl Record for Trial {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let answer = self.answer.as_ref().ok();
        let number = |of: fn(&Answer) -> f64| Cell::from(answer.map(of));
        let mut cells: Vec<(&'static str, Cell)> = vec![
            ("experiment", self.experiment.name().into()),
            ("condition", self.condition.as_str().into()),
            ("objective", self.objective.name().into()),
            ("trial", self.trial.into()),
            ("object", self.object.as_deref().into()),
            ("success", answer.is_some().into()),
            ("refusal", self.answer.as_ref().err().map(FitRefusal::to_string).into()),
            ("radial_m", number(|a| a.errors.radial_m)),
            ("goodness_of_fit", number(|a| a.errors.goodness_of_fit)),
            ("goodness_of_fit_abs", number(|a| a.errors.goodness_of_fit_abs)),
            ("volume_error_percent", answer.and_then(|a| a.volume_error_percent).into()),
            ("exponent_error", answer.and_then(|a| a.exponent_error).into()),
            ("extent_error_x_m", answer.and_then(|a| a.extent_errors_m).map(|e| e[0]).into()),
            ("extent_error_y_m", answer.and_then(|a| a.extent_errors_m).map(|e| e[1]).into()),
            ("extent_error_z_m", answer.and_then(|a| a.extent_errors_m).map(|e| e[2]).into()),
            ("recognised", answer.and_then(|a| a.is_recognised).into()),
            ("mirrored", answer.map(|a| a.is_mirrored).into()),
            ("time_s", number(|a| a.time_s)),
            ("points", answer.map(|a| a.points).into()),
            ("used_points", answer.map(|a| a.used_points).into()),
            ("rejected", answer.map(|a| a.rejected).into()),
            ("parts", answer.map(|a| a.parts).into()),
            ("iterations", answer.map(|a| a.iterations as usize).into()),
        ];
        cells.extend(TRUE.into_iter().zip(parameters(self.truth.as_ref())));
        cells.extend(FOUND.into_iter().zip(parameters(answer.map(|answer| &answer.found))));
        cells
    }
}

/// Names of the parameters of the truth.
const TRUE: [&str; 14] = [
    "true_a_m",
    "true_b_m",
    "true_c_m",
    "true_e1",
    "true_e2",
    "true_taper",
    "true_bend_per_m",
    "true_x_m",
    "true_y_m",
    "true_z_m",
    "true_qx",
    "true_qy",
    "true_qz",
    "true_qw",
];
/// Names of the parameters of the fit.
const FOUND: [&str; 14] = [
    "found_a_m",
    "found_b_m",
    "found_c_m",
    "found_e1",
    "found_e2",
    "found_taper",
    "found_bend_per_m",
    "found_x_m",
    "found_y_m",
    "found_z_m",
    "found_qx",
    "found_qy",
    "found_qz",
    "found_qw",
];

fn parameters(shape: Option<&Superquadric>) -> [Cell; 14] {
    let Some(s) = shape else { return [const { Cell::Nothing }; 14] };
    let (t, r) = (s.X_FS.translation.vector, s.X_FS.rotation.coords);
    [s.a, s.b, s.c, s.e1, s.e2, s.taper, s.bend_per_m, t.x, t.y, t.z, r.x, r.y, r.z, r.w].map(Cell::Number)
}
