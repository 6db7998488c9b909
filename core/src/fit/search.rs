//! From a prepared cloud to the best superquadric: all starts on few points, the best on all, with robust weights.

use nalgebra::Point3;

use super::candidate::{Candidate, DEFORMED, PLAIN};
use super::levenberg_marquardt::{Limits, Minimum, minimise};
use super::models::Model;
use super::objective::{Objective, Residual};
use super::prepare::Prepared;
use super::robust::reweighted;
use super::starts::{Start, Surroundings, bounds, half_extents, similar, starts};
use super::thin::every_nth;
use super::types::{FitRefusal, FitSettings, ObjectiveKind, RunReport, StopReason};
use super::weighted::WeightedPoints;
use crate::parallel;
use crate::segment::Plane;
use crate::watch::Watch;

/// All starts are tried on at most this many points; the best go on with all.
const COARSE_POINTS: usize = 300;
/// Weight of standing on the table, as a share of all points together; 0.1 to 1 measure alike.
const STANDING_SHARE: f64 = 0.3;
/// How strongly the semi-axes of an object on the table are drawn to half the cloud's extents while a side is open, as
/// a share of all points. Halves the volume error of unmirrored views (19 to 9 % on the rendered YCB boxes, balls, cans
/// and fruit); clouds without a table are left alone, where a half-shell's true semi-axis may be all of its extent.
const DRAWN_SHARE: f64 = 0.003;
/// Exponents of the starts: round and square. One of them alone loses 2 % of half-seen shapes.
const START_EXPONENTS: [f64; 2] = [1.0, 0.4];
/// How many starts are followed further.
const KEPT_STARTS: usize = 3;
/// A look-alike replaces the best when its cost is below this share: equal twins (a ball's) must not swap by rounding.
const BETTER: f64 = 0.98;
/// Rounds of new weights on few points and on all.
const COARSE_ROUNDS: usize = 3;
const FINE_ROUNDS: usize = 2;

/// A cloud under search: its points, how they are judged, and the history so far.
pub(crate) struct Search<'a> {
    pub(crate) points: &'a [(Point3<f64>, f64)],
    pub(crate) coarse: Vec<(Point3<f64>, f64)>,
    around: &'a Surroundings,
    table: Option<(Plane, f64)>,
    settings: &'a FitSettings,
    watch: Watch<'a>,
    /// Whether taper and bend are free.
    frees: [bool; 2],
    pub(crate) runs: Vec<RunReport>,
}

impl<'a> Search<'a> {
    /// A search over these points of a prepared cloud.
    pub(crate) fn new(
        prepared: &'a Prepared,
        points: &'a [(Point3<f64>, f64)],
        settings: &'a FitSettings,
        watch: Watch<'a>,
    ) -> Self {
        Self {
            points,
            coarse: every_nth(points, COARSE_POINTS),
            around: &prepared.around,
            table: prepared.table.map(|plane| (plane, STANDING_SHARE)),
            settings,
            watch,
            frees: [false; 2],
            runs: Vec::new(),
        }
    }

    fn limits(&self, most: u32, relative_reduction: f64) -> Limits {
        Limits { max_iterations: self.settings.max_iterations.min(most), relative_reduction }
    }

    /// One run of Levenberg–Marquardt on some of the points.
    fn run<const N: usize>(&self, points: &[(Point3<f64>, f64)], from: &Candidate, limits: &Limits) -> Minimum {
        let weighted = WeightedPoints::new(points);
        self.run_laid_out::<N>(points, &weighted, from, limits)
    }

    fn run_laid_out<const N: usize>(
        &self,
        points: &[(Point3<f64>, f64)],
        weighted: &WeightedPoints,
        from: &Candidate,
        limits: &Limits,
    ) -> Minimum {
        let objective = Objective::new(weighted, self.settings.objective).standing_on(self.table);
        let open = self.around.on_table && !self.around.complete;
        let objective =
            if open { objective.drawn_to(half_extents(points, self.around, from), DRAWN_SHARE) } else { objective };
        minimise::<N>(&objective, from, &bounds(points, self.around, from, self.frees), limits, self.watch)
    }

    fn note(&mut self, name: &str, points: &[(Point3<f64>, f64)], found: &Minimum) {
        let weight: f64 = points.iter().map(|(_, w)| w).sum();
        self.runs.push(RunReport {
            name: name.to_owned(),
            points: points.len(),
            rms: found.costs.iter().map(|cost| (cost / weight.max(1e-300)).sqrt()).collect(),
            iterations: found.iterations,
            stop: found.stop,
        });
    }

    /// The best plain shape on few points: all starts briefly, three of them further, then its look-alikes.
    ///
    /// # Errors
    /// [`FitRefusal::Stopped`].
    pub(crate) fn coarse_best(&mut self) -> Result<Candidate, FitRefusal> {
        let coarse = self.coarse.clone();
        let weighted = WeightedPoints::new(&coarse);
        let all_starts = starts(&coarse, self.around, &START_EXPONENTS);
        let brief = self.limits(12, 1e-4);
        let longer = self.limits(u32::MAX, 1e-5);
        let run = |from: &Candidate, limits: &Limits| self.run_laid_out::<PLAIN>(&coarse, &weighted, from, limits);

        let found = parallel::map(&all_starts, |start| run(&start.candidate, &brief));
        let mut tried: Vec<(&Start, Minimum)> = all_starts.iter().zip(found).collect();
        let mut history: Vec<(String, Minimum)> =
            tried.iter().map(|(start, found)| (start.name.clone(), found.clone())).collect();
        tried.sort_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
        tried.truncate(KEPT_STARTS);

        let refined = parallel::map(&tried, |(_, found)| run(&found.candidate, &longer));
        history.extend(
            tried.iter().zip(&refined).map(|((start, _), found)| (format!("{}, on", start.name), found.clone())),
        );
        let Some(mut best) = refined.into_iter().min_by(|p, q| p.cost.total_cmp(&q.cost)) else {
            return Err(FitRefusal::Stopped);
        };
        for _ in 0..2 {
            let twins = similar(&best.candidate);
            let found = parallel::map(&twins, |(_, twin)| run(twin, &longer));
            let better = twins.iter().zip(found).min_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
            match better {
                Some(((name, _), found)) if found.cost < BETTER * best.cost => {
                    history.push((format!("look-alike, {name}"), found.clone()));
                    best = found;
                }
                _ => break,
            }
        }
        for (name, found) in &history {
            self.note(name, &coarse, found);
        }
        if self.watch.should_stop() || best.stop == StopReason::Stopped {
            return Err(FitRefusal::Stopped);
        }
        if self.settings.reject_outliers {
            return self.refined::<PLAIN>(&coarse, best.candidate, COARSE_ROUNDS, "robust weights");
        }
        Ok(best.candidate)
    }

    /// The objective that is minimised.
    pub(crate) fn objective_kind(&self) -> ObjectiveKind {
        self.settings.objective
    }

    /// Distances of points from a candidate.
    pub(crate) fn residuals(&self, points: &[(Point3<f64>, f64)], candidate: &Candidate) -> Vec<Residual> {
        Objective::new(&WeightedPoints::new(points), self.settings.objective).residuals(candidate)
    }

    /// The shape on all points, from one that is nearly right.
    ///
    /// # Errors
    /// [`FitRefusal::Stopped`].
    pub(crate) fn fine(&mut self, from: Candidate, model: Model, name: &str) -> Result<Candidate, FitRefusal> {
        self.frees = model.frees();
        if model == Model::Plain { self.fine_over::<PLAIN>(from, name) } else { self.fine_over::<DEFORMED>(from, name) }
    }

    /// A deformed shape on some points, from a start that is deformed a little.
    ///
    /// # Errors
    /// [`FitRefusal::Stopped`].
    pub(crate) fn deformed(
        &mut self,
        points: &[(Point3<f64>, f64)],
        start: Candidate,
        model: Model,
        rounds: usize,
        name: &str,
    ) -> Result<Candidate, FitRefusal> {
        self.frees = model.frees();
        let found = self.run::<DEFORMED>(points, &start, &self.limits(40, 1e-4));
        self.note(name, points, &found);
        if self.settings.reject_outliers {
            return self.refined::<DEFORMED>(points, found.candidate, rounds, name);
        }
        if found.stop == StopReason::Stopped { Err(FitRefusal::Stopped) } else { Ok(found.candidate) }
    }

    fn fine_over<const N: usize>(&mut self, from: Candidate, name: &str) -> Result<Candidate, FitRefusal> {
        let points = self.points;
        if self.settings.reject_outliers {
            return self.refined::<N>(points, from, FINE_ROUNDS, name);
        }
        let found = self.run::<N>(points, &from, &self.limits(u32::MAX, 1e-7));
        self.note(name, points, &found);
        if found.stop == StopReason::Stopped { Err(FitRefusal::Stopped) } else { Ok(found.candidate) }
    }

    /// Rounds of new weights, each followed by a run.
    fn refined<const N: usize>(
        &mut self,
        points: &[(Point3<f64>, f64)],
        from: Candidate,
        rounds: usize,
        name: &str,
    ) -> Result<Candidate, FitRefusal> {
        let kind = self.settings.objective;
        let laid_out = WeightedPoints::new(points);
        let mut candidate = from;
        for round in 1..=rounds {
            let residuals = Objective::new(&laid_out, kind).residuals(&candidate);
            let weighted = reweighted(points, &residuals, kind);
            let found = self.run::<N>(&weighted, &candidate, &self.limits(30, 1e-5));
            self.note(&format!("{name}, round {round}"), &weighted, &found);
            if found.stop == StopReason::Stopped {
                return Err(FitRefusal::Stopped);
            }
            candidate = found.candidate;
        }
        Ok(candidate)
    }
}
