//! One view of an object with and without mirroring: size, volume and surface against the truth.

use super::Experiment;
use super::object_views::ObjectView;
use super::row::Row;
use super::run::{ExperimentRefusal, ExperimentSettings, Outcome, each};
use super::trial::{Question, Trial, Truth};
use crate::fit::{FitInput, FitSettings, MirrorMode};
use crate::watch::Watch;

/// Conditions in the order of the rows.
const CONDITIONS: [(&str, MirrorMode); 2] = [("mirrored", MirrorMode::Auto), ("not mirrored", MirrorMode::Off)];

pub(super) fn run(settings: &ExperimentSettings, watch: Watch<'_>) -> Result<Outcome, ExperimentRefusal> {
    let views = &settings.views;
    let trials = each(views, watch, |trial, view| {
        let truth = Truth::of_view(view, &view.surface);
        let fits = CONDITIONS.iter().map(|(condition, mirror)| {
            let question = Question {
                experiment: Experiment::Objects,
                condition,
                trial,
                input: FitInput { points: &view.points, X_FC: view.X_FC, table: view.table },
                settings: &FitSettings { mirror: *mirror, ..FitSettings::default() },
            };
            Trial::run(&question, &truth, watch)
        });
        fits.collect()
    })?;
    Ok(Outcome { rows: rows(views, &trials, settings.is_serial), trials })
}

/// All objects together, the convex and solid ones together, then each object, the worst first.
fn rows(views: &[ObjectView], trials: &[Trial], is_timed: bool) -> Vec<Row> {
    let is_plain = |trial: &Trial| views.get(trial.trial).is_some_and(|view| view.is_convex && !view.is_hollow);
    let row = |condition: &str, object: &str, is_wanted: &dyn Fn(&Trial) -> bool| {
        let chosen: Vec<&Trial> = trials.iter().filter(|t| t.condition == condition && is_wanted(t)).collect();
        Row::of(&chosen, Some(object.to_owned()), is_timed)
    };
    let mut rows: Vec<Row> = Vec::new();
    for (set, is_wanted) in [("all", &(|_: &Trial| true) as &dyn Fn(&Trial) -> bool), ("convex and solid", &is_plain)] {
        rows.extend(CONDITIONS.iter().filter_map(|(condition, _)| row(condition, set, is_wanted)));
    }
    let mut names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let mut objects: Vec<Vec<Row>> = names
        .into_iter()
        .map(|name| {
            let is_it = |trial: &Trial| trial.object.as_deref() == Some(name);
            CONDITIONS.iter().filter_map(|(condition, _)| row(condition, name, &is_it)).collect()
        })
        .collect();
    // No fit at all is worst.
    let badness = |rows: &Vec<Row>| {
        rows.first().and_then(|row| row.extent_error_m).map_or(f64::INFINITY, |extent_error_m| extent_error_m.mean)
    };
    objects.sort_by(|p, q| badness(q).total_cmp(&badness(p)));
    rows.extend(objects.into_iter().flatten());
    rows
}
