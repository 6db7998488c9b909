//! From a prepared cloud to the best superquadric: all starts on few points, the best on all, with robust weights.

use nalgebra::Point3;

use super::candidate::{Candidate, DEFORMED, PLAIN};
use super::levenberg_marquardt::{Limits, Minimum, minimise};
use super::models::{Model, deformed};
use super::objective::{Objective, Residual};
use super::prepare::Prepared;
use super::robust::reweighted;
use super::starts::{Start, Surroundings, bounds, diagonal_starts, half_extents, similar, starts};
use super::strays::is_poor;
use super::thin::every_nth;
use super::types::{FitRefusal, FitSettings, RunReport, StopReason};
use super::weighted::WeightedPoints;
use crate::parallel;
use crate::segment::Plane;
use crate::watch::Watch;

/// All starts are tried on at most this many points, the best of them on more, the winner on all.
const BRIEF_POINTS: usize = 208;
const COARSE_POINTS: usize = 304;
const MIDDLE_POINTS: usize = 1200;
/// Weight of standing on the table, as a share of all points together; 0.1 to 1 measure alike.
const STANDING_SHARE: f64 = 0.3;
/// How strongly the semi-axes of an object on the table are drawn to half the cloud's extents while a side is open, as
/// a share of all points. Halves the volume error of unmirrored views (19 to 9 % on the rendered YCB boxes, balls, cans
/// and fruit); clouds without a table are left alone, where a half-shell's true semi-axis may be all of its extent.
const DRAWN_SHARE: f64 = 0.003;
/// Up to this many points a second round on all of them costs little; half-seen noisy shapes gain 2 % by it.
const FEW_POINTS: usize = 3000;
/// Exponents of the starts: round and square. One of them alone loses 2 % of half-seen shapes.
const START_EXPONENTS: [f64; 2] = [1.0, 0.4];
/// Exponent of the boxes that deformed fits start from.
const DEFORMED_EXPONENTS: [f64; 1] = [0.6];
/// Exponent of the starts of a brief fit.
const QUICK_EXPONENTS: [f64; 1] = [0.7];
/// How many starts are followed further.
const KEPT_STARTS: usize = 4;
/// A look-alike replaces the best when its cost is below this share: equal twins (a ball's) must not swap by rounding.
const BETTER: f64 = 0.98;
/// A look-alike that is this much worse after a few steps is not followed.
const HOPELESS: f64 = 4.0;
/// Rounds of new weights on few points and, for a part of an object, from a shape that is nearly right.
const COARSE_ROUNDS: usize = 3;
const WARM_ROUNDS: usize = 2;

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
    /// Whether the points are one part of an object: a joint is an open side.
    is_part: bool,
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
        Self { is_part: false, ..Self::of_part(points, &prepared.around, prepared.table, settings, watch) }
    }

    /// A search over the points of one part of an object.
    pub(crate) fn of_part(
        points: &'a [(Point3<f64>, f64)],
        around: &'a Surroundings,
        table: Option<Plane>,
        settings: &'a FitSettings,
        watch: Watch<'a>,
    ) -> Self {
        Self {
            points,
            coarse: every_nth(points, COARSE_POINTS),
            around,
            table: table.map(|plane| (plane, STANDING_SHARE)),
            settings,
            watch,
            frees: [false; 2],
            is_part: true,
            runs: Vec::new(),
        }
    }

    /// A brief fit from every axis of the principal box: enough to judge a split.
    pub(crate) fn quick_best(&self) -> Option<Candidate> {
        let weighted = WeightedPoints::new(&self.coarse);
        let run = |from: &Candidate, most: u32| {
            self.run_laid_out::<PLAIN>(&self.coarse, &weighted, from, &self.limits(most, 1e-3))
        };
        let found =
            starts(&self.coarse, self.around, &QUICK_EXPONENTS).into_iter().map(|start| run(&start.candidate, 8));
        let best = found.min_by(|p, q| p.cost.total_cmp(&q.cost))?;
        Some(run(&best.candidate, 16).candidate)
    }

    /// The shape on these points from one that is nearly right, with new weights.
    ///
    /// # Errors
    /// [`FitRefusal::Stopped`].
    pub(crate) fn warm(&mut self, from: Candidate) -> Result<Candidate, FitRefusal> {
        let points = self.points;
        self.refined::<PLAIN>(points, from, WARM_ROUNDS, "warm")
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
        let open = self.is_part || self.around.on_table && !self.around.complete;
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

    /// The best plain shape on few points: all starts briefly, some of them further, then the best one's look-alikes.
    ///
    /// # Errors
    /// [`FitRefusal::Stopped`].
    pub(crate) fn coarse_best(&mut self) -> Result<Candidate, FitRefusal> {
        let coarse = self.coarse.clone();
        let weighted = WeightedPoints::new(&coarse);
        let few = every_nth(&coarse, BRIEF_POINTS);
        let few_weighted = WeightedPoints::new(&few);
        let all_starts = starts(&coarse, self.around, &START_EXPONENTS);
        let brief = self.limits(12, 1e-4);
        let longer = self.limits(u32::MAX, 1e-5);
        let run = |from: &Candidate, limits: &Limits| self.run_laid_out::<PLAIN>(&coarse, &weighted, from, limits);

        let run_few = |from: &Candidate| self.run_laid_out::<PLAIN>(&few, &few_weighted, from, &brief);

        let found = parallel::map(&all_starts, |start| run_few(&start.candidate));
        let mut tried: Vec<(&Start, Minimum)> = all_starts.iter().zip(found).collect();
        let mut history: Vec<(String, &[_], Minimum)> =
            tried.iter().map(|(start, found)| (start.name.clone(), &few[..], found.clone())).collect();
        tried.sort_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
        tried.truncate(KEPT_STARTS);

        let refined = parallel::map(&tried, |(_, found)| run(&found.candidate, &longer));
        history.extend(
            tried
                .iter()
                .zip(&refined)
                .map(|((start, _), found)| (format!("{}, on", start.name), &coarse[..], found.clone())),
        );
        let Some(mut best) = refined.into_iter().min_by(|p, q| p.cost.total_cmp(&q.cost)) else {
            return Err(FitRefusal::Stopped);
        };
        for _ in 0..2 {
            let twins = similar(&best.candidate);
            let at_best = run_few(&best.candidate).cost;
            let found = parallel::map(&twins, |(_, twin)| {
                let first = run_few(twin);
                if first.cost > HOPELESS * at_best {
                    Minimum { cost: f64::INFINITY, ..first }
                } else {
                    run(&first.candidate, &longer)
                }
            });
            let better = twins.iter().zip(found).min_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
            match better {
                Some(((name, _), found)) if found.cost < BETTER * best.cost => {
                    history.push((format!("look-alike, {name}"), &coarse[..], found.clone()));
                    best = found;
                }
                _ => break,
            }
        }
        if is_poor(&weighted.residuals(&best.candidate)) {
            let more = diagonal_starts(&all_starts);
            let found = parallel::map(&more, |start| run(&run_few(&start.candidate).candidate, &longer));
            let better = more.iter().zip(found).min_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
            if let Some((start, found)) = better.filter(|(_, found)| found.cost < BETTER * best.cost) {
                history.push((start.name.clone(), &coarse[..], found.clone()));
                best = found;
            }
        }
        for (name, points, found) in &history {
            self.note(name, points, found);
        }
        if self.watch.should_stop() || best.stop == StopReason::Stopped {
            return Err(FitRefusal::Stopped);
        }
        if self.settings.reject_outliers {
            return self.refined::<PLAIN>(&coarse, best.candidate, COARSE_ROUNDS, "robust weights");
        }
        Ok(best.candidate)
    }

    /// Distances of points from a candidate.
    pub(crate) fn residuals(&self, points: &[(Point3<f64>, f64)], candidate: &Candidate) -> Vec<Residual> {
        WeightedPoints::new(points).residuals(candidate)
    }

    /// The shape on all points, from one that is nearly right.
    ///
    /// # Errors
    /// [`FitRefusal::Stopped`].
    pub(crate) fn fine(&mut self, from: Candidate, model: Model, name: &str) -> Result<Candidate, FitRefusal> {
        self.frees = model.frees();
        if model == Model::Plain { self.fine_over::<PLAIN>(from, name) } else { self.fine_over::<DEFORMED>(from, name) }
    }

    /// Where a deformed fit starts: the plain shape with every axis once as z, and the boxes that plain fits start from.
    pub(crate) fn deformed_starts(&self, plain: &Candidate, model: Model) -> Vec<Candidate> {
        let mut bases = vec![*plain];
        bases.extend(similar(plain).into_iter().take(2).map(|(_, twin)| twin));
        bases.extend(starts(&self.coarse, self.around, &DEFORMED_EXPONENTS).into_iter().map(|start| start.candidate));
        deformed(&bases, model)
    }

    /// A few steps of a deformed shape on few points: enough to tell the starts apart.
    pub(crate) fn deformed_brief(&mut self, start: Candidate, model: Model) -> Candidate {
        self.frees = model.frees();
        self.run::<DEFORMED>(&self.coarse, &start, &self.limits(12, 1e-3)).candidate
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
            let middle = every_nth(points, MIDDLE_POINTS);
            let mut candidate = from;
            if points.len() > MIDDLE_POINTS {
                candidate = self.refined::<N>(&middle, candidate, 1, "many points")?;
            }
            let rounds = if points.len() > FEW_POINTS { 1 } else { 2 };
            return self.refined::<N>(points, candidate, rounds, name);
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
            let residuals = laid_out.residuals(&candidate);
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
