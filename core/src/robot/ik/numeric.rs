//! Inverse kinematics of any chain of joints: damped least squares from many starts.
//!
//! Each start descends on `½‖e‖²` by Levenberg–Marquardt steps `Δq = Jᵀ (J Jᵀ + μ I)⁻¹ e` (Wampler 1986; Nakamura and
//! Hanafusa 1986) with the analytic Jacobian. A joint at a limit that a step would push further out is held and the step
//! computed again without it. Starts come from a seed, so equal questions have equal answers. It cannot prove that a
//! pose has no solution: the reason it gives is that of its nearest attempt.

use nalgebra::{Isometry3, Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3, Vector6};

use super::IkReject;
use crate::math;
use crate::rng::Rng;
use crate::robot::{Chain, ChainState, JointKind, JointLimit, Robot};

/// A solution is at most this far off, metres and radians; descents go on to a hundredth of it where they can.
const TOLERANCE: f64 = 5e-10;
/// Steps of one descent.
const MAX_STEPS: usize = 80;
/// A descent is given up after this many steps in a row that gain less than 2 %.
const SLOW_STEPS: usize = 6;
/// Starts until a first solution is found.
const FIRST_STARTS: usize = 100;
/// Starts of a search for the reason of a failure.
const REASON_STARTS: usize = 8;
/// Configurations nearer to each other than this in every joint are one solution, rad or m.
const SAME: f64 = 1e-4;
/// By how much rotation counts more than position when the reach alone is asked for.
const TURNED_FIRST: f64 = 30.0;
/// By how much rotation counts less than position for a hand that goes after what it cannot reach.
const PLACE_FIRST: f64 = 0.3;

/// A chain of joints that is solved step by step.
#[derive(Clone, Debug)]
pub(super) struct NumericArm {
    chain: Chain,
    /// Whether each joint slides; such a one has no whole turns.
    slides: Vec<bool>,
    /// 1 / reach: brings metres to the size of radians.
    per_m: f64,
    /// Seed of the starts.
    seed: u64,
}

/// What is left to the target.
#[derive(Clone, Copy, Debug)]
struct Gap {
    m: f64,
    rad: f64,
}

impl Gap {
    fn is_closed(&self) -> bool {
        self.m < TOLERANCE && self.rad < TOLERANCE
    }
}

/// What one descent minimises.
#[derive(Clone, Copy)]
struct Goal {
    R_BH: Matrix3<f64>,
    p_BH: Vector3<f64>,
    /// Factor of the rotation's part of the error.
    turn_weight: f64,
    /// Whether joints stay within their limits.
    limited: bool,
}

/// Memory of descents.
#[derive(Default)]
struct Memory {
    state: ChainState,
    columns: Vec<[f64; 6]>,
    held: Vec<bool>,
    step: Vec<f64>,
    trial: Vec<f64>,
}

impl NumericArm {
    pub(super) fn new(robot: &Robot, chain: Chain) -> Self {
        let kind = |&dof: &usize| robot.joints[robot.dof_joints[dof]].kind == JointKind::Prismatic;
        let slides = chain.dofs().iter().map(kind).collect();
        let per_m = 1.0 / chain.reach_m().max(1e-3);
        Self { chain, slides, per_m, seed: 0 }
    }

    pub(super) fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    pub(super) fn limits(&self) -> &[JointLimit] {
        self.chain.limits()
    }

    /// Distance by which the pose is beyond all segments in one line, metres; 0 when it is not.
    pub(super) fn reach_gap_m(&self, X_BH: &Isometry3<f64>) -> f64 {
        let far = (X_BH.translation.vector - self.chain.origin()).norm();
        if far.is_finite() { (far - self.chain.reach_m()).max(0.0) } else { f64::INFINITY }
    }

    /// Distinct solutions found from a number of starts, `q_now` the first of them.
    pub(super) fn set(
        &self,
        X_BH: &Isometry3<f64>,
        q_now: &[f64],
        starts: usize,
        mut found: impl FnMut(&[f64]),
    ) -> Result<(), IkReject> {
        let mut known: Vec<Vec<f64>> = Vec::new();
        let result = self.search(X_BH, q_now, starts, |q| {
            let apart = |old: &Vec<f64>| old.iter().zip(q).any(|(a, b)| (a - b).abs() > SAME);
            if known.iter().all(apart) {
                found(q);
                known.push(q.to_vec());
            }
            true
        });
        if known.is_empty() { result } else { Ok(()) }
    }

    /// The first solution found.
    pub(super) fn first(&self, X_BH: &Isometry3<f64>, q_now: &[f64]) -> Result<Vec<f64>, IkReject> {
        let mut first = None;
        self.search(X_BH, q_now, FIRST_STARTS, |q| {
            first = Some(q.to_vec());
            false
        })?;
        first.ok_or(IkReject::Stalled { gap_m: f64::INFINITY, gap_rad: f64::INFINITY })
    }

    /// The solution to which the descent from `near` leads, if it leads to one.
    pub(super) fn near(&self, X_BH: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>> {
        let mut q = near.to_vec();
        let gap = self.descend(&Goal::within_limits(X_BH), &mut q, &mut Memory::default());
        gap.is_closed().then_some(q)
    }

    /// Where the descent from `q_now` ends, near the pose or short of it: the hand's place counts more than its rotation.
    pub(super) fn towards(&self, X_BH: &Isometry3<f64>, q_now: &[f64]) -> Vec<f64> {
        let mut q = self.clipped(q_now);
        let goal = Goal { turn_weight: PLACE_FIRST, ..Goal::within_limits(X_BH) };
        let _gap = self.descend(&goal, &mut q, &mut Memory::default());
        q
    }

    /// Descends from every start and hands over each solution until told to stop; the reason if there was none.
    fn search(
        &self,
        X_BH: &Isometry3<f64>,
        q_now: &[f64],
        starts: usize,
        mut go_on: impl FnMut(&[f64]) -> bool,
    ) -> Result<(), IkReject> {
        let gap_m = self.reach_gap_m(X_BH);
        if gap_m > 0.0 {
            return Err(IkReject::OutOfReach { gap_m });
        }
        let goal = Goal::within_limits(X_BH);
        let mut rng = Rng::new(self.seed, 0);
        let mut memory = Memory::default();
        let mut best: Option<(Gap, Vec<f64>)> = None;
        let mut any = false;
        let merit = |gap: &Gap| gap.m * self.per_m + gap.rad;
        for start in 0..starts.max(1) {
            let mut q = if start == 0 { self.clipped(q_now) } else { self.random(&mut rng) };
            let gap = self.descend(&goal, &mut q, &mut memory);
            if gap.is_closed() {
                any = true;
                if !go_on(&q) {
                    return Ok(());
                }
            } else if best.as_ref().is_none_or(|(least, _)| merit(&gap) < merit(least)) {
                best = Some((gap, q));
            }
        }
        match best {
            Some((gap, q)) if !any => Err(self.reason(X_BH, &q, gap, &mut memory)),
            _ => Ok(()),
        }
    }

    /// Why the nearest attempt is none: a limit if the pose can be had without limits, else the missing length.
    fn reason(&self, X_BH: &Isometry3<f64>, nearest: &[f64], gap: Gap, memory: &mut Memory) -> IkReject {
        let goal = Goal { turn_weight: TURNED_FIRST, limited: false, ..Goal::within_limits(X_BH) };
        let mut rng = Rng::new(self.seed, 1);
        let mut missing = gap;
        let mut outside: Option<(f64, IkReject)> = None;
        for start in 0..REASON_STARTS {
            let mut q = if start == 0 { nearest.to_vec() } else { self.random(&mut rng) };
            let free = self.descend(&goal, &mut q, memory);
            if free.is_closed() {
                // The nearest posture outside of the limits names its worst joint.
                if let Some((miss, reject)) = self.worst(&q)
                    && outside.as_ref().is_none_or(|(least, _)| miss < *least)
                {
                    outside = Some((miss, reject));
                }
            } else if start == 0 || free.m < missing.m {
                missing = free;
            }
        }
        match outside {
            Some((_, reject)) => reject,
            None if missing.rad < 1.0 / TURNED_FIRST => IkReject::OutOfReach { gap_m: missing.m },
            None => IkReject::Stalled { gap_m: gap.m, gap_rad: gap.rad },
        }
    }

    /// By how much a posture leaves its limits, and the joint that does so the most.
    fn worst(&self, q: &[f64]) -> Option<(f64, IkReject)> {
        let mut worst: Option<(f64, IkReject)> = None;
        for (joint, (&value, limit)) in q.iter().zip(self.limits()).enumerate() {
            let value = if self.slides[joint] { value } else { math::wrap_angle(value) };
            let miss = (limit.lower - value).max(value - limit.upper);
            if miss > 0.0 && worst.as_ref().is_none_or(|(most, _)| miss > *most) {
                let reject = IkReject::JointLimit { joint, value, lower: limit.lower, upper: limit.upper };
                worst = Some((miss, reject));
            }
        }
        worst
    }

    fn clipped(&self, q: &[f64]) -> Vec<f64> {
        q.iter().zip(self.limits()).map(|(q, limit)| q.max(limit.lower).min(limit.upper)).collect()
    }

    fn random(&self, rng: &mut Rng) -> Vec<f64> {
        self.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect()
    }

    /// Descends from `q` to a least error and answers what is left.
    fn descend(&self, goal: &Goal, q: &mut Vec<f64>, memory: &mut Memory) -> Gap {
        let mut damping = 1e-3;
        let mut slow = 0;
        let (mut gap, mut e) = self.error(goal, q, &mut memory.state);
        for _ in 0..MAX_STEPS {
            if gap.m < 0.01 * TOLERANCE && gap.rad < 0.01 * TOLERANCE || slow >= SLOW_STEPS || damping > 1e6 {
                break;
            }
            self.chain.place(q, &mut memory.state);
            self.chain.jacobian(&memory.state, &mut memory.columns);
            for column in &mut memory.columns {
                (0..3).for_each(|k| column[k] *= goal.turn_weight);
                (3..6).for_each(|k| column[k] *= self.per_m);
            }
            // A rejected step is tried again shorter, from the same Jacobian.
            while damping <= 1e6 {
                if !self.step(goal, q, &e, damping, memory) {
                    return gap;
                }
                let (next_gap, next_e) = self.error(goal, &memory.trial, &mut memory.state);
                let (before, after) = (e.norm_squared(), next_e.norm_squared());
                if after < before {
                    slow = if after > 0.96 * before { slow + 1 } else { 0 };
                    (gap, e) = (next_gap, next_e);
                    std::mem::swap(q, &mut memory.trial);
                    damping = (damping * 0.1).max(1e-14);
                    break;
                }
                damping *= 8.0;
            }
        }
        gap
    }

    /// `[rotation vector; translation]` from the tip to the goal, weighted, and the same as plain sizes.
    fn error(&self, goal: &Goal, q: &[f64], state: &mut ChainState) -> (Gap, Vector6<f64>) {
        self.chain.place(q, state);
        let turn = goal.R_BH * state.R_BH.transpose();
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn)).scaled_axis();
        let way = goal.p_BH - state.p_BH;
        let (w, v) = (turn * goal.turn_weight, way * self.per_m);
        (Gap { m: way.norm(), rad: turn.norm() }, Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z))
    }

    /// One damped step into `memory.trial`; `false` if no joint can move.
    fn step(&self, goal: &Goal, q: &[f64], e: &Vector6<f64>, damping: f64, memory: &mut Memory) -> bool {
        let Memory { columns, held, step, trial, .. } = memory;
        held.clear();
        held.resize(q.len(), false);
        loop {
            let mut gram = Matrix6::identity() * damping;
            for (column, _) in columns.iter().zip(held.iter()).filter(|(_, held)| !**held) {
                for i in 0..6 {
                    for j in 0..6 {
                        gram[(i, j)] += column[i] * column[j];
                    }
                }
            }
            let Some(factor) = gram.cholesky() else { return false };
            let y = factor.solve(e);
            step.clear();
            step.extend(
                columns
                    .iter()
                    .zip(held.iter())
                    .map(|(column, held)| if *held { 0.0 } else { (0..6).map(|k| column[k] * y[k]).sum::<f64>() }),
            );
            if !goal.limited {
                break;
            }
            let mut pushed = false;
            for (joint, limit) in self.limits().iter().enumerate() {
                let outwards =
                    q[joint] <= limit.lower && step[joint] < 0.0 || q[joint] >= limit.upper && step[joint] > 0.0;
                if outwards && !held[joint] && !self.turns_round(joint) {
                    held[joint] = true;
                    pushed = true;
                }
            }
            if !pushed {
                break;
            }
            if held.iter().all(|held| *held) {
                return false;
            }
        }
        trial.clear();
        trial.extend(q.iter().zip(step.iter()).enumerate().map(|(joint, (q, step))| {
            let limit = &self.limits()[joint];
            let moved = q + step;
            match goal.limited {
                false => moved,
                true if self.turns_round(joint) => limit.lower + round(moved - limit.lower),
                true => moved.max(limit.lower).min(limit.upper),
            }
        }));
        true
    }

    /// Whether the joint's limits leave no angle out, so that it may go on past one end at the other.
    fn turns_round(&self, joint: usize) -> bool {
        let limit = &self.limits()[joint];
        !self.slides[joint] && (limit.upper - limit.lower - std::f64::consts::TAU).abs() < 1e-5
    }
}

impl Goal {
    fn within_limits(X_BH: &Isometry3<f64>) -> Self {
        let R_BH = X_BH.rotation.to_rotation_matrix().into_inner();
        Self { R_BH, p_BH: X_BH.translation.vector, turn_weight: 1.0, limited: true }
    }
}

/// The angle moved by whole turns into [0, 2π).
fn round(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - (angle / turn).floor() * turn
}
