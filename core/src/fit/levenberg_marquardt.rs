//! Levenberg–Marquardt (3.3) on 11 × 11 normal equations, with a box around every bounded unknown.
//!
//! Unknowns at a bound whose gradient pushes outward are taken out of the step (active set); steps are then held in the
//! box. Damping follows Nielsen (1999): the gain ratio sets how far λ falls, and each failure doubles its growth.

use nalgebra::{SMatrix, SVector};

use super::candidate::{BOUNDED, Bounds, Candidate, UNKNOWNS};
use super::objective::{NormalEquations, Objective};
use super::types::StopReason;
use crate::watch::Watch;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Evaluations of the objective at most.
    pub(crate) max_iterations: u32,
    /// Converged when a step lowers the cost by less than this share.
    pub(crate) relative_reduction: f64,
}

/// Where it arrived.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub(crate) candidate: Candidate,
    /// Weighted sum of squares there, metres squared.
    pub(crate) cost: f64,
    pub(crate) iterations: u32,
    pub(crate) stop: StopReason,
    /// Cost at the start and after each step that was taken.
    pub(crate) costs: Vec<f64>,
}

/// A mean square below this is rounding: (1 nm)².
const ZERO_MEAN_SQUARE: f64 = 1e-18;
/// Damping beyond which steps are too short to matter.
const MAX_DAMPING: f64 = 1e12;

/// Minimises the objective from a start.
pub(crate) fn minimise(
    objective: &Objective<'_>,
    start: &Candidate,
    bounds: &Bounds,
    limits: &Limits,
    watch: Watch<'_>,
) -> Minimum {
    let mut candidate = start.held_in(bounds);
    let mut here = objective.at(&candidate);
    let mut damping = 1e-3;
    let mut growth = 2.0;
    let mut iterations = 1;
    let mut small_steps = 0;
    let mut costs = vec![here.cost];
    let stop = loop {
        if !here.cost.is_finite() {
            break StopReason::NotFinite;
        }
        if here.cost <= ZERO_MEAN_SQUARE * objective.total_weight() {
            break StopReason::Converged;
        }
        if iterations >= limits.max_iterations {
            break StopReason::IterationLimit;
        }
        if watch.should_stop() {
            break StopReason::Stopped;
        }
        let Some(step) = damped_step(&candidate, &here, bounds, damping) else {
            damping *= growth;
            growth *= 2.0;
            if damping > MAX_DAMPING {
                break StopReason::NoDescent;
            }
            continue;
        };
        let next_candidate = candidate.stepped(&step, bounds);
        let next = objective.at(&next_candidate);
        iterations += 1;
        let actual = here.cost - next.cost;
        if actual > 0.0 {
            let gain = actual / predicted_reduction(&here, &step).max(1e-300);
            small_steps = if actual < limits.relative_reduction * here.cost { small_steps + 1 } else { 0 };
            candidate = next_candidate;
            here = next;
            costs.push(here.cost);
            let twist = 2.0 * gain.min(1.0) - 1.0;
            damping = (damping * (1.0 - twist * twist * twist).max(1.0 / 5.0)).max(1e-12);
            growth = 2.0;
            // Two in a row: one short step may be a corner that the damping turns around.
            if small_steps >= 2 {
                break StopReason::Converged;
            }
        } else {
            damping *= growth;
            growth *= 2.0;
            if damping > MAX_DAMPING {
                break StopReason::NoDescent;
            }
        }
    };
    Minimum { candidate, cost: here.cost, iterations, stop, costs }
}

/// Solves `(H + λ diag H) δ = -g` for the unknowns that are free to move; `None` when H is not positive definite.
fn damped_step(candidate: &Candidate, at: &NormalEquations, bounds: &Bounds, damping: f64) -> Option<[f64; UNKNOWNS]> {
    let mut matrix = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut right = SVector::<f64, UNKNOWNS>::zeros();
    let largest = (0..UNKNOWNS).map(|k| at.hessian[k][k]).fold(0.0, f64::max);
    let is_free = |k: usize| {
        k >= BOUNDED
            || !(candidate.values[k] <= bounds.lower[k] && at.gradient[k] > 0.0
                || candidate.values[k] >= bounds.upper[k] && at.gradient[k] < 0.0)
    };
    for i in 0..UNKNOWNS {
        if !is_free(i) {
            matrix[(i, i)] = 1.0;
            continue;
        }
        for j in 0..UNKNOWNS {
            if is_free(j) {
                matrix[(i, j)] = at.hessian[i][j];
            }
        }
        // The floor keeps an unknown that no point feels (the turn of a sphere) where it is.
        matrix[(i, i)] += damping * at.hessian[i][i] + 1e-12 * largest;
        right[i] = -at.gradient[i];
    }
    let step = matrix.cholesky()?.solve(&right);
    step.iter().all(|s| s.is_finite()).then(|| std::array::from_fn(|k| step[k]))
}

/// By how much the linear model expects the cost to fall: `-2 gᵀδ - δᵀHδ`.
fn predicted_reduction(at: &NormalEquations, step: &[f64; UNKNOWNS]) -> f64 {
    (0..UNKNOWNS)
        .map(|i| {
            let curved: f64 = (0..UNKNOWNS).map(|j| at.hessian[i][j] * step[j]).sum();
            -step[i] * (2.0 * at.gradient[i] + curved)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

    use super::*;
    use crate::fit::objective::WeightedPoints;
    use crate::rng::Rng;

    const WIDE: Bounds = Bounds {
        lower: [0.005, 0.005, 0.005, 0.1, 0.1, -1.0, -1.0, -1.0],
        upper: [0.5, 0.5, 0.5, 1.9, 1.9, 1.0, 1.0, 1.0],
    };
    const LIMITS: Limits = Limits { max_iterations: 200, relative_reduction: 1e-9 };

    fn cloud_of(truth: &Candidate) -> WeightedPoints {
        let samples = truth.superquadric(&Isometry3::identity()).samples(24);
        WeightedPoints::new(&samples.iter().map(|q| (q.p_F, 1.0)).collect::<Vec<_>>())
    }

    #[test]
    fn perfect_data_give_the_parameters_back() {
        let mut rng = Rng::new(41, 0);
        for _ in 0..20 {
            let axes = [rng.uniform(0.03, 0.08), rng.uniform(0.1, 0.16), rng.uniform(0.18, 0.3)];
            let e = [rng.uniform(0.2, 1.5), rng.uniform(0.2, 1.5)];
            let truth = Candidate::new(axes, e, rng.direction() * 0.4, rng.rotation());
            let points = cloud_of(&truth);
            let off = truth.R_DS * UnitQuaternion::from_scaled_axis(rng.direction() * 0.15);
            let start = Candidate::new(axes.map(|a| a * 1.1), [1.0, 1.0], truth.center() + rng.direction() * 0.01, off);
            let found = minimise(&Objective::new(&points, None), &start, &WIDE, &LIMITS, Watch::idle());
            assert_eq!(found.stop, StopReason::Converged);
            for k in 0..BOUNDED {
                // The cost ends below (1 nm)² per point; exponents move the surface by about a tenth of their change.
                assert!((found.candidate.values[k] - truth.values[k]).abs() < 1e-6, "{k}: {found:?} {truth:?}");
            }
            assert!(found.candidate.R_DS.angle_to(&truth.R_DS) < 1e-5);
        }
    }

    #[test]
    fn bounds_hold_and_the_rest_still_fits() {
        let truth = Candidate::new([0.05, 0.06, 0.2], [0.3, 0.3], Vector3::zeros(), UnitQuaternion::identity());
        let points = cloud_of(&truth);
        let mut bounds = WIDE;
        bounds.upper[2] = 0.15;
        let start = Candidate { values: [0.05, 0.05, 0.1, 1.0, 1.0, 0.0, 0.0, 0.0], ..truth };
        let found = minimise(&Objective::new(&points, None), &start, &bounds, &LIMITS, Watch::idle());
        assert_eq!(found.candidate.values[2], 0.15);
        for k in 0..BOUNDED {
            assert!(found.candidate.values[k] >= bounds.lower[k] && found.candidate.values[k] <= bounds.upper[k]);
        }
        assert!((found.candidate.values[0] - 0.05).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn limits_and_cancelling_are_named() {
        let truth = Candidate::new([0.05, 0.06, 0.2], [0.3, 0.3], Vector3::zeros(), UnitQuaternion::identity());
        let points = cloud_of(&truth);
        let objective = Objective::new(&points, None);
        let start = Candidate { values: [0.1, 0.1, 0.1, 1.0, 1.0, 0.05, 0.0, 0.0], ..truth };
        let few = Limits { max_iterations: 3, ..LIMITS };
        assert_eq!(minimise(&objective, &start, &WIDE, &few, Watch::idle()).stop, StopReason::IterationLimit);
        let always = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        assert_eq!(minimise(&objective, &start, &WIDE, &LIMITS, always).stop, StopReason::Stopped);
        let lost = WeightedPoints::new(&[(Point3::new(1e200, 0.0, 0.0), 1.0)]);
        let objective = Objective::new(&lost, None);
        assert_eq!(minimise(&objective, &start, &WIDE, &LIMITS, Watch::idle()).stop, StopReason::NotFinite);
    }
}
