//! Which experiments there are, what they are given, and the loop over their trials.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::object_views::ObjectView;
use super::protocol::draw_shape;
use super::row::Row;
use super::trial::Trial;
use super::{deformations, downsampling, objectives, objects, outliers, peers, visibility};
use crate::fit::FitSettings;
use crate::parallel;
use crate::rng::Rng;
use crate::superquadric::{Superquadric, SuperquadricError};
use crate::watch::Watch;

/// An experiment by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Experiment {
    /// Table 3.2: six voxel sizes.
    Downsampling,
    /// Table 3.3: noise and partial views.
    Visibility,
    /// Section 3.6: the five objectives, on the clouds of Table 3.3 and on views of objects (Figure 3.6).
    Objectives,
    /// The trials on which other programs were measured.
    Peers,
    /// Views of household objects with and without mirroring.
    Objects,
    /// Clouds with points that belong to nothing.
    Outliers,
    /// Tapered and bent shapes.
    Deformations,
}

impl Experiment {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Downsampling,
        Self::Visibility,
        Self::Objectives,
        Self::Peers,
        Self::Objects,
        Self::Outliers,
        Self::Deformations,
    ];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Downsampling => "downsampling",
            Self::Visibility => "visibility",
            Self::Objectives => "objectives",
            Self::Peers => "peers",
            Self::Objects => "objects",
            Self::Outliers => "outliers",
            Self::Deformations => "deformations",
        }
    }

    /// What it finds out, for a person.
    pub fn about(self) -> &'static str {
        match self {
            Self::Downsampling => "Table 3.2: error and time against the voxel size",
            Self::Visibility => "Table 3.3: error and time against noise and partial view",
            Self::Objectives => "section 3.6: the five objectives on random shapes and on views of objects",
            Self::Peers => "the trials other programs were measured on: dense random clouds, 0.015 m voxel centroids",
            Self::Objects => "views of household objects, fitted with and without mirroring",
            Self::Outliers => "20 % of the points belong to nothing",
            Self::Deformations => "tapered and bent shapes, fitted plain and with deformations",
        }
    }

    /// How many trials it has when nobody says: the thesis's 500, the 100 of the comparison, 3 views of each object.
    pub fn default_trials(self) -> usize {
        match self {
            Self::Downsampling | Self::Visibility | Self::Objectives => 500,
            Self::Peers | Self::Outliers | Self::Deformations => 100,
            Self::Objects => 3,
        }
    }

    /// Whether it looks at objects.
    pub fn needs_objects(self) -> bool {
        matches!(self, Self::Objectives | Self::Objects)
    }

    /// Whether its trials are random superquadrics, which a trials file may replace.
    pub fn takes_shapes(self) -> bool {
        self != Self::Objects
    }
}

/// What an experiment is given.
#[derive(Clone, Debug)]
pub struct ExperimentSettings {
    /// Trials per condition.
    pub trials: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// Shapes instead of random ones; their count replaces `trials`.
    pub shapes: Option<Vec<Superquadric>>,
    /// One fit after the other on one processor, so that their times mean something.
    pub is_serial: bool,
    /// Views of objects, for the experiments that look at them.
    pub views: Vec<ObjectView>,
}

/// What an experiment gave.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// One row per condition.
    pub rows: Vec<Row>,
    /// Every fit.
    pub trials: Vec<Trial>,
}

/// Why an experiment has no outcome.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentRefusal {
    /// Nothing to do.
    #[error("experiment {experiment}: found 0 {thing}, wanted at least 1")]
    Nothing { experiment: &'static str, thing: &'static str },
    /// A random shape is none.
    #[error("trial {trial}: {source}")]
    Shape { trial: usize, source: SuperquadricError },
    /// A robot or an object cannot be used.
    #[error("{reason}")]
    Setup { reason: String },
    /// Hardly any case can be solved.
    #[error("{robot}, {condition}: found {found} cases that can be solved among {draws}, wanted {wanted}")]
    TooFewCases { robot: String, condition: &'static str, found: usize, wanted: usize, draws: usize },
    /// The caller stopped it.
    #[error("the experiment was stopped")]
    Stopped,
}

/// Runs an experiment; the outcome depends on the settings alone, but for the times.
///
/// # Errors
/// [`ExperimentRefusal`] when there is nothing to do or the caller stopped it. A fit that refuses is a result.
pub fn run_experiment(
    experiment: Experiment,
    settings: &ExperimentSettings,
    watch: Watch<'_>,
) -> Result<Outcome, ExperimentRefusal> {
    let nothing = |thing| Err(ExperimentRefusal::Nothing { experiment: experiment.name(), thing });
    if settings.trials == 0 {
        return nothing("trials");
    }
    if experiment == Experiment::Objects && settings.views.is_empty() {
        return nothing("views");
    }
    let work = || match experiment {
        Experiment::Downsampling => downsampling::run(settings, watch),
        Experiment::Visibility => visibility::run(settings, watch),
        Experiment::Objectives => objectives::run(settings, watch),
        Experiment::Peers => peers::run(settings, watch),
        Experiment::Objects => objects::run(settings, watch),
        Experiment::Outliers => outliers::run(settings, watch),
        Experiment::Deformations => deformations::run(settings, watch),
    };
    if settings.is_serial { parallel::on_one_thread(work) } else { work() }
}

/// The stream of random numbers of a trial for one purpose; the shape is purpose 0.
pub(super) fn stream(settings: &ExperimentSettings, trial: usize, purpose: u64) -> Rng {
    Rng::new(settings.seed, 8 * trial as u64 + purpose)
}

/// The settings of fits to clouds of random shapes: no camera, no table, so nothing is mirrored.
pub(super) fn plain_fit() -> FitSettings {
    FitSettings::default()
}

/// The shapes of the trials: the given ones, or draws from Table 3.1.
pub(super) fn shapes(settings: &ExperimentSettings) -> Result<Vec<Superquadric>, ExperimentRefusal> {
    if let Some(shapes) = &settings.shapes {
        return Ok(shapes.clone());
    }
    (0..settings.trials)
        .map(|trial| {
            draw_shape(&mut stream(settings, trial, 0)).map_err(|source| ExperimentRefusal::Shape { trial, source })
        })
        .collect()
}

/// Does the work of every item, in parallel, and tells how far it is; an item gives several fits, or `None` if stopped.
///
/// The answer is in the order of the items, whatever the number of threads.
pub(super) fn each<T: Sync>(
    items: &[T],
    watch: Watch<'_>,
    work: impl Fn(usize, &T) -> Option<Vec<Trial>> + Sync + Send,
) -> Result<Vec<Trial>, ExperimentRefusal> {
    let done = AtomicUsize::new(0);
    let numbered: Vec<(usize, &T)> = items.iter().enumerate().collect();
    let found = parallel::map(&numbered, |(number, item)| {
        if watch.should_stop() {
            return None;
        }
        let trials = work(*number, item)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        watch.progress(done as f64 / items.len() as f64, &format!("{done} of {}", items.len()));
        Some(trials)
    });
    let found: Option<Vec<Vec<Trial>>> = found.into_iter().collect();
    Ok(found.ok_or(ExperimentRefusal::Stopped)?.into_iter().flatten().collect())
}
