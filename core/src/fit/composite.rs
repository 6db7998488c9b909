//! Objects that one superquadric cannot describe: split into a few, as long as each split pays.
//!
//! A split is proposed by a plane across one of the principal axes of a part's points, at several offsets, or by what
//! the part's own fit leaves over (its largest connected piece: the handle of a mug). Both sides are fitted briefly on few
//! points, the best proposals are refined: every point goes to the nearest part, every part is fitted again to its
//! points, and so on. A split is taken when it lowers `n/4 ln(MS + σ₀²) + k ln(n/4)` over all n points of the object: the
//! Bayesian information criterion with k = 11 unknowns per part, a quarter of the points because the misfit of neighbours is the same misfit, and σ₀ the
//! larger of 3 mm (what a finger's pad gives) and a twentieth of the object's radius, below which an edge that is not
//! quite round is no reason for another part. Where a point lies deep inside another part, that depth counts as its
//! error, so that no part swallows its neighbour.

use nalgebra::{Point3, Vector3};

use super::candidate::{Candidate, PLAIN};
use super::frame::{mean_radius_m, principal_axes};
use super::models::{best_model, bic};
use super::objective::Residual;
use super::prepare::Prepared;
use super::search::Search;
use super::starts::Surroundings;
use super::strays::pieces;
use super::thin::every_nth;
use super::types::{FitRefusal, FitSettings, ModelReport, RunReport};
use super::weighted::WeightedPoints;
use crate::parallel;
use crate::watch::Watch;

/// Points that take part: the object's voxels, thinned to this many.
const POINTS: usize = 900;
/// Points of either side of a proposal.
const PROPOSAL_POINTS: usize = 120;
/// A part has at least this many points, and at least this share of the object's.
const MIN_PART_POINTS: usize = 24;
const MIN_PART_SHARE: f64 = 0.04;
/// Offsets of the planes along an axis, as shares of the points on one side.
const SHARES: [f64; 7] = [0.12, 0.25, 0.38, 0.5, 0.62, 0.75, 0.88];
/// Proposals that are refined.
const REFINED: usize = 3;
/// Rounds of giving points to the nearest part and fitting again.
const ROUNDS: usize = 4;
/// Distances count up to this, metres: what is farther is simply not explained.
const LIMIT_M: f64 = 0.012;
/// Points may lie this deep inside another part, metres: where parts are joined they overlap.
const JOINT_M: f64 = 0.006;
/// A point is left over by a part's fit beyond this, metres.
const LEFT_OVER_M: f64 = 0.006;
/// A part lower than this stands on the table, metres.
const STANDS_BELOW_M: f64 = 0.03;

/// Points whose misfit is the same misfit.
const NEIGHBOURS: usize = 4;
/// σ₀ of the criterion: at least this, metres, and this share of the object's radius.
const FLOOR_M: f64 = 0.003;
const FLOOR_SHARE: f64 = 0.05;

type Weighted = Vec<(Point3<f64>, f64)>;

/// The parts of an object and what was compared.
pub(crate) struct Composite {
    pub(crate) parts: Vec<Candidate>,
    pub(crate) models: Vec<ModelReport>,
    pub(crate) runs: Vec<RunReport>,
}

/// Splits an object that a single candidate describes so far; one part when no split pays.
///
/// # Errors
/// [`FitRefusal::Stopped`].
pub(crate) fn split(
    prepared: &Prepared,
    single: Candidate,
    settings: &FitSettings,
    watch: Watch<'_>,
) -> Result<Composite, FitRefusal> {
    let points = every_nth(&prepared.points, POINTS);
    let floor_m = FLOOR_M.max(FLOOR_SHARE * mean_radius_m(&points));
    let context = Context { prepared, points, floor_m, settings, watch };
    let mut best = vec![single];
    let mut models = vec![context.report(&best)];
    let mut criterion = models[0].criterion;
    let mut runs = Vec::new();
    while best.len() < settings.max_parts {
        let Some(next) = context.best_split(&best)? else { break };
        let report = context.report(&next);
        let next_criterion = report.criterion;
        models.push(report);
        if next_criterion >= criterion {
            break;
        }
        (best, criterion) = (next, next_criterion);
    }
    if best.len() > 1 {
        best = context.polished(&best, &mut runs)?;
    }
    for model in &mut models {
        model.is_chosen = model.criterion == criterion;
    }
    Ok(Composite { parts: best, models, runs })
}

struct Context<'a> {
    prepared: &'a Prepared,
    points: Weighted,
    floor_m: f64,
    settings: &'a FitSettings,
    watch: Watch<'a>,
}

impl Context<'_> {
    fn residuals(&self, parts: &[Candidate]) -> Vec<Vec<Residual>> {
        let laid_out = WeightedPoints::new(&self.points);
        parts.iter().map(|part| laid_out.residuals(part)).collect()
    }

    /// Weighted mean of the squared errors, m²: distance from the nearest part, or depth inside another.
    fn mean_square(&self, parts: &[Candidate]) -> f64 {
        let residuals = self.residuals(parts);
        let (mut sum, mut total) = (0.0, 0.0);
        for (k, (_, weight)) in self.points.iter().enumerate() {
            let nearest = residuals.iter().map(|r| r[k].normal_m.abs()).fold(f64::INFINITY, f64::min);
            let depth = residuals.iter().map(|r| -r[k].normal_m).fold(0.0, f64::max) - JOINT_M;
            let error = nearest.max(depth).min(LIMIT_M);
            sum += weight * error * error;
            total += weight;
        }
        sum / total.max(1e-300)
    }

    /// The criterion of these parts, and what a person reads.
    fn report(&self, parts: &[Candidate]) -> ModelReport {
        let mean_square = self.mean_square(parts);
        let independent = self.points.len() / NEIGHBOURS;
        let name = if parts.len() == 1 { "1 part".to_owned() } else { format!("{} parts", parts.len()) };
        let criterion = bic(mean_square, self.floor_m, independent, (PLAIN * parts.len()) as f64);
        ModelReport { name, criterion, rms_m: mean_square.sqrt(), is_chosen: false }
    }

    /// Index of the nearest part for every point.
    fn nearest(&self, parts: &[Candidate]) -> Vec<usize> {
        let residuals = self.residuals(parts);
        (0..self.points.len())
            .map(|k| {
                let distance = |part: &usize| residuals[*part][k].normal_m.abs();
                (0..parts.len()).min_by(|p, q| distance(p).total_cmp(&distance(q))).unwrap_or(0)
            })
            .collect()
    }

    fn is_enough(&self, count: usize) -> bool {
        count >= MIN_PART_POINTS && count as f64 >= MIN_PART_SHARE * self.points.len() as f64
    }

    /// The best way to split one of the parts, refined; `None` when no split leaves two parts with enough points.
    fn best_split(&self, parts: &[Candidate]) -> Result<Option<Vec<Candidate>>, FitRefusal> {
        let owner = self.nearest(parts);
        let mut proposals: Vec<(usize, Vec<bool>)> = Vec::new();
        for (part, shape) in parts.iter().enumerate() {
            let own: Vec<usize> = (0..self.points.len()).filter(|k| owner[*k] == part).collect();
            for side in self.sides(&own, shape) {
                let count = side.iter().filter(|s| **s).count();
                if self.is_enough(count) && self.is_enough(own.len() - count) {
                    let mut whole = vec![false; self.points.len()];
                    own.iter().zip(&side).for_each(|(k, is_second)| whole[*k] = *is_second);
                    proposals.push((part, whole));
                }
            }
        }
        let tried: Vec<Option<Vec<Candidate>>> = parallel::map(&proposals, |(part, second)| {
            let of = |wanted: bool| -> Weighted {
                let own = (0..self.points.len()).filter(|k| owner[*k] == *part && second[*k] == wanted);
                every_nth(&own.map(|k| self.points[k]).collect::<Vec<_>>(), PROPOSAL_POINTS)
            };
            let mut next = parts.to_vec();
            next[*part] = self.quick(&of(false))?;
            next.push(self.quick(&of(true))?);
            Some(next)
        });
        if self.watch.should_stop() {
            return Err(FitRefusal::Stopped);
        }
        let mut ranked: Vec<(f64, Vec<Candidate>)> =
            tried.into_iter().flatten().map(|next| (self.mean_square(&next), next)).collect();
        ranked.sort_by(|(p, _), (q, _)| p.total_cmp(q)); // stable: equal proposals keep their order
        ranked.truncate(REFINED);
        let refined: Vec<(f64, Vec<Candidate>)> = parallel::map(&ranked, |(score, next)| self.alternated(*score, next));
        Ok(refined.into_iter().min_by(|(p, _), (q, _)| p.total_cmp(q)).map(|(_, next)| next))
    }

    /// Which of a part's points go to a second part, once for every proposal.
    fn sides(&self, own: &[usize], part: &Candidate) -> Vec<Vec<bool>> {
        let positions: Vec<Point3<f64>> = own.iter().map(|k| self.points[*k].0).collect();
        if positions.len() < 2 * MIN_PART_POINTS {
            return Vec::new();
        }
        let mut sides = Vec::new();
        let axes = principal_axes(&positions).0;
        for axis in axes.column_iter() {
            let axis: Vector3<f64> = axis.into_owned();
            let along: Vec<f64> = positions.iter().map(|p| axis.dot(&p.coords)).collect();
            let mut sorted = along.clone();
            sorted.sort_by(f64::total_cmp);
            for share in SHARES {
                let border = sorted[(share * (sorted.len() - 1) as f64) as usize];
                sides.push(along.iter().map(|x| *x > border).collect());
            }
        }
        let laid_out = WeightedPoints::new(&own.iter().map(|k| self.points[*k]).collect::<Vec<_>>());
        let residuals = laid_out.residuals(part);
        for is_outside_only in [true, false] {
            let left: Vec<usize> = (0..positions.len())
                .filter(|k| {
                    let d = residuals[*k].normal_m;
                    if is_outside_only { d > LEFT_OVER_M } else { d.abs() > LEFT_OVER_M }
                })
                .collect();
            if let Some(piece) = pieces(&left.iter().map(|k| positions[*k]).collect::<Vec<_>>()).first() {
                let mut side = vec![false; positions.len()];
                piece.iter().for_each(|k| side[left[*k]] = true);
                sides.push(side);
            }
        }
        sides
    }

    /// A brief fit of a part on few points.
    fn quick(&self, points: &Weighted) -> Option<Candidate> {
        let around = self.around(points);
        Search::of_part(points, &around, None, self.settings, self.watch).quick_best()
    }

    /// Points to the nearest part and parts to their points, as long as the error falls.
    fn alternated(&self, score: f64, parts: &[Candidate]) -> (f64, Vec<Candidate>) {
        let mut best = (score, parts.to_vec());
        for _ in 0..ROUNDS {
            let owner = self.nearest(&best.1);
            let refitted: Option<Vec<Candidate>> = (0..best.1.len())
                .map(|part| {
                    let own: Weighted = self.owned(&owner, part);
                    if !self.is_enough(own.len()) {
                        return None;
                    }
                    let around = self.around(&own);
                    let mut search = Search::of_part(&own, &around, None, self.settings, self.watch);
                    search.warm(best.1[part]).ok()
                })
                .collect();
            let Some(next) = refitted else { break };
            let next_score = self.mean_square(&next);
            if next_score >= best.0 {
                break;
            }
            best = (next_score, next);
        }
        best
    }

    fn owned(&self, owner: &[usize], part: usize) -> Weighted {
        self.points.iter().zip(owner).filter(|(_, o)| **o == part).map(|(p, _)| *p).collect()
    }

    /// Every part on its points with all starts, the look-alikes and the deformations that the settings allow.
    fn polished(&self, parts: &[Candidate], runs: &mut Vec<RunReport>) -> Result<Vec<Candidate>, FitRefusal> {
        let owner = self.nearest(parts);
        let mut polished = parts.to_vec();
        for part in 0..parts.len() {
            let own = self.owned(&owner, part);
            let around = self.around(&own);
            let table = around.on_table.then_some(self.prepared.table).flatten();
            let mut search = Search::of_part(&own, &around, table, self.settings, self.watch);
            let plain = search.coarse_best()?;
            let (model, coarse, _) = best_model(&mut search, plain, self.settings.deform)?;
            let found = search.fine(coarse, model, "on all points of the part")?;
            let mut tried = polished.clone();
            tried[part] = found;
            // A part alone may prefer a shape that swallows its neighbour; the object as a whole decides.
            if self.mean_square(&tried) <= self.mean_square(&polished) {
                polished = tried;
            }
            runs.extend(
                search
                    .runs
                    .into_iter()
                    .map(|run| RunReport { name: format!("part {}: {}", part + 1, run.name), ..run }),
            );
        }
        Ok(polished)
    }

    fn around(&self, points: &Weighted) -> Surroundings {
        let lowest = points.iter().map(|(p, _)| p.z).fold(f64::INFINITY, f64::min);
        Surroundings {
            mirror_normal: None,
            on_table: self.prepared.table.is_some() && lowest < STANDS_BELOW_M,
            complete: false,
        }
    }
}
