//! Levenberg–Marquardt (3.3) on 11 × 11 normal equations (13 × 13 with deformations), with a box around every bounded unknown.
//!
//! Unknowns at a bound whose gradient pushes outward are taken out of the step (active set); steps are then held in the
//! box. Damping follows Nielsen (1999): the gain ratio sets how far λ falls, and each failure doubles its growth.

use super::candidate::{Bounds, Candidate, value_of};
use super::normal_equations::NormalEquations;
use super::objective::Objective;
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

/// Minimises the objective from a start over N unknowns: `PLAIN` or `DEFORMED`.
pub(crate) fn minimise<const N: usize>(
    objective: &Objective<'_>,
    start: &Candidate,
    bounds: &Bounds,
    limits: &Limits,
    watch: Watch<'_>,
) -> Minimum {
    let mut candidate = start.held_in(bounds);
    let mut here = objective.at::<N>(&candidate);
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
        let next = objective.at::<N>(&next_candidate);
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
#[expect(clippy::needless_range_loop, reason = "rows and columns of matrices, as in the formula")]
fn damped_step<const N: usize>(
    candidate: &Candidate,
    at: &NormalEquations<N>,
    bounds: &Bounds,
    damping: f64,
) -> Option<[f64; N]> {
    let largest = (0..N).map(|k| at.hessian[k][k]).fold(0.0, f64::max);
    let is_free = |k: usize| {
        value_of(k).is_none_or(|value| {
            !(candidate.values[value] <= bounds.lower[value] && at.gradient[k] >= 0.0
                || candidate.values[value] >= bounds.upper[value] && at.gradient[k] <= 0.0)
        })
    };
    let mut matrix = [[0.0; N]; N];
    let mut right = [0.0; N];
    for i in 0..N {
        if !is_free(i) {
            matrix[i][i] = 1.0;
            continue;
        }
        for j in 0..N {
            if is_free(j) {
                matrix[i][j] = at.hessian[i][j];
            }
        }
        // The floor keeps an unknown that no point feels (the turn of a sphere) where it is.
        matrix[i][i] += damping * at.hessian[i][i] + 1e-12 * largest;
        right[i] = -at.gradient[i];
    }
    let step = solved(&mut matrix, right)?;
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// Solves a symmetric positive definite system by Cholesky's decomposition, in place; `None` when it is not definite.
///
/// Ours and not nalgebra's because its bits must not depend on the processor.
#[expect(clippy::needless_range_loop, reason = "rows and columns of matrices, as in the formula")]
fn solved<const N: usize>(matrix: &mut [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    for j in 0..N {
        let mut pivot = matrix[j][j];
        for k in 0..j {
            pivot -= matrix[j][k] * matrix[j][k];
        }
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        let root = pivot.sqrt();
        matrix[j][j] = root;
        for i in j + 1..N {
            let mut entry = matrix[i][j];
            for k in 0..j {
                entry -= matrix[i][k] * matrix[j][k];
            }
            matrix[i][j] = entry / root;
        }
    }
    for i in 0..N {
        for k in 0..i {
            right[i] -= matrix[i][k] * right[k];
        }
        right[i] /= matrix[i][i];
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            right[i] -= matrix[k][i] * right[k];
        }
        right[i] /= matrix[i][i];
    }
    Some(right)
}

/// By how much the linear model expects the cost to fall: `-2 gᵀδ - δᵀHδ`.
fn predicted_reduction<const N: usize>(at: &NormalEquations<N>, step: &[f64; N]) -> f64 {
    (0..N)
        .map(|i| {
            let curved: f64 = (0..N).map(|j| at.hessian[i][j] * step[j]).sum();
            -step[i] * (2.0 * at.gradient[i] + curved)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

    use super::*;
    use crate::fit::candidate::{PLAIN, VALUES};
    use crate::fit::types::ObjectiveKind;
    use crate::fit::weighted::WeightedPoints;
    use crate::rng::Rng;

    const WIDE: Bounds = Bounds {
        lower: [0.005, 0.005, 0.005, 0.1, 0.1, -1.0, -1.0, -1.0, 0.0, 0.0],
        upper: [0.5, 0.5, 0.5, 1.9, 1.9, 1.0, 1.0, 1.0, 0.0, 0.0],
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
            let found = minimise::<PLAIN>(
                &Objective::new(&points, ObjectiveKind::Radial),
                &start,
                &WIDE,
                &LIMITS,
                Watch::idle(),
            );
            assert_eq!(found.stop, StopReason::Converged);
            for k in 0..VALUES {
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
        let start = Candidate { values: [0.05, 0.05, 0.1, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], ..truth };
        let found =
            minimise::<PLAIN>(&Objective::new(&points, ObjectiveKind::Radial), &start, &bounds, &LIMITS, Watch::idle());
        assert_eq!(found.candidate.values[2], 0.15);
        for k in 0..VALUES {
            assert!(found.candidate.values[k] >= bounds.lower[k] && found.candidate.values[k] <= bounds.upper[k]);
        }
        assert!((found.candidate.values[0] - 0.05).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn limits_and_cancelling_are_named() {
        let truth = Candidate::new([0.05, 0.06, 0.2], [0.3, 0.3], Vector3::zeros(), UnitQuaternion::identity());
        let points = cloud_of(&truth);
        let objective = Objective::new(&points, ObjectiveKind::Radial);
        let start = Candidate { values: [0.1, 0.1, 0.1, 1.0, 1.0, 0.05, 0.0, 0.0, 0.0, 0.0], ..truth };
        let few = Limits { max_iterations: 3, ..LIMITS };
        assert_eq!(minimise::<PLAIN>(&objective, &start, &WIDE, &few, Watch::idle()).stop, StopReason::IterationLimit);
        let always = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        assert_eq!(minimise::<PLAIN>(&objective, &start, &WIDE, &LIMITS, always).stop, StopReason::Stopped);
        let lost = WeightedPoints::new(&[(Point3::new(1e200, 0.0, 0.0), 1.0)]);
        let objective = Objective::new(&lost, ObjectiveKind::Radial);
        assert_eq!(minimise::<PLAIN>(&objective, &start, &WIDE, &LIMITS, Watch::idle()).stop, StopReason::NotFinite);
    }
}
