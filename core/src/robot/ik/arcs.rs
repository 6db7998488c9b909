//! Which arm angles the joint limits allow, exactly, for a hand pose (after Shimizu et al. 2008).
//!
//! At a given bend of the elbow every entry of the shoulder's rotation is `a + b cos ψ + c sin ψ` in the arm angle ψ, and
//! so is every entry of the wrist's. The middle joint of a ball stands where the cosine of its bend is such a term; the
//! outer joints are arc tangents of two of them. Hence every limit is crossed where one such term has a given value, at
//! most twice per turn, and between neighbouring crossings nothing changes: one posture in the middle decides.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::SrsArm;
use super::ball::Ball;
use super::solve::{Elbow, Posed};
use crate::math;

/// A ball whose bend changes by less than this over all arm angles, and is that near to 0 or π, is aligned throughout.
const ALWAYS_ALIGNED: f64 = 1e-9;
/// Terms with a smaller amplitude than this are constant.
const CONSTANT: f64 = 1e-13;
/// Crossings nearer to each other than this are one, radians.
const ROUND_OFF: f64 = 1e-12;

/// Arm angles at which one branch of the inverse kinematics keeps all seven joints within their limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arc {
    /// Branch 0..8 as in [`super::IkSolution::branch`].
    pub branch: u8,
    /// First arm angle, radians in [-π, π].
    pub from: f64,
    /// Last arm angle, `from < to <= from + 2π`; an arc that passes ±π ends above π.
    pub to: f64,
}

impl Arc {
    /// Whether the arc holds an arm angle given within any whole turn.
    pub fn contains(&self, arm_angle: f64) -> bool {
        let past = arm_angle - self.from;
        past - (past / TAU).floor() * TAU <= self.to - self.from
    }
}

/// `a + b cos ψ + c sin ψ`.
#[derive(Clone, Copy)]
struct Term {
    a: f64,
    b: f64,
    c: f64,
}

impl Term {
    /// This term times one factor less another times another.
    fn mixed(self, factor: f64, other: Self, other_factor: f64) -> Self {
        let mix = |l: f64, r: f64| l * factor - r * other_factor;
        Self { a: mix(self.a, other.a), b: mix(self.b, other.b), c: mix(self.c, other.c) }
    }

    fn amplitude(self) -> f64 {
        (self.b * self.b + self.c * self.c).sqrt()
    }

    /// Where the term is largest.
    fn peak(self) -> f64 {
        math::atan2(self.c, self.b)
    }

    /// Adds the angles at which the term has a value.
    fn roots(self, value: f64, cuts: &mut Vec<f64>) {
        let (amplitude, rest) = (self.amplitude(), value - self.a);
        if amplitude > CONSTANT && rest.abs() <= amplitude {
            // By the half-angle of the chord: an arc cosine near 1 would lose half of the digits.
            let half = math::atan2(((amplitude - rest) * (amplitude + rest)).max(0.0).sqrt(), rest);
            cuts.push(math::wrap_angle(self.peak() + half));
            cuts.push(math::wrap_angle(self.peak() - half));
        }
    }
}

/// The rotation of the shoulder as a function of the arm angle.
struct Turning<'a> {
    posed: &'a Posed,
    elbow: &'a Elbow,
}

impl Turning<'_> {
    /// `g · R_shoulder(ψ) h`.
    fn term(&self, g: &Vector3<f64>, h: &Vector3<f64>) -> Term {
        let (posed, elbow) = (self.posed, self.elbow);
        let [h0, h1, h2] = [0, 1, 2].map(|row| (0..3).map(|k| elbow.frame[(row, k)] * h[k]).sum::<f64>());
        let (along, across, up) = (g.dot(&posed.t), g.dot(&posed.normal), g.dot(&posed.quarter));
        Term { a: along * h0, b: elbow.sign * (across * h1 + up * h2), c: elbow.sign * (up * h1 - across * h2) }
    }
}

/// Between which arm angles which branches of a ball are within the limits.
struct Allowed {
    /// Sorted arm angles in [-π, π]; the last part goes on from the last cut over π to the first.
    cuts: Vec<f64>,
    /// For the part after each cut; one entry for the whole turn if there is no cut.
    branches: Vec<[bool; 2]>,
}

impl Allowed {
    fn new(cuts: Vec<f64>, mut test: impl FnMut(f64) -> [bool; 2]) -> Self {
        let cuts = tidy(cuts);
        let branches = parts(&cuts).into_iter().map(|(from, to)| test(0.5 * (from + to))).collect();
        Self { cuts, branches }
    }

    fn at(&self, arm_angle: f64) -> [bool; 2] {
        let after = self.cuts.partition_point(|cut| *cut <= math::wrap_angle(arm_angle));
        self.branches[after.checked_sub(1).unwrap_or(self.branches.len() - 1)]
    }
}

/// The cuts in order, of those that round-off alone keeps apart the first; ±π is one angle.
fn tidy(mut cuts: Vec<f64>) -> Vec<f64> {
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|later, earlier| *later - *earlier < ROUND_OFF);
    if cuts.len() > 1 && cuts[0] + TAU - cuts[cuts.len() - 1] < ROUND_OFF {
        cuts.pop();
    }
    cuts
}

/// The parts of a turn between sorted cuts, the last one going over π; the whole turn from -π if there is no cut.
fn parts(cuts: &[f64]) -> Vec<(f64, f64)> {
    let Some(&first) = cuts.first() else { return vec![(-PI, PI)] };
    let ends = cuts.iter().skip(1).copied().chain([first + TAU]);
    cuts.iter().copied().zip(ends).collect()
}

impl SrsArm {
    /// For each branch the arm angles at which all seven joints are within their limits, by branch and angle; empty when
    /// the pose is out of reach.
    ///
    /// The ends are exact but for round-off: some 1e-15 rad, and the root of that where a joint only just touches its
    /// limit. A ball that is aligned at every arm angle is judged by the one split of its free turn that
    /// [`SrsArm::solve`] takes.
    ///
    /// * `X_BH`: hand frame H in the frame B of the arm's base link.
    pub fn feasible_arcs(&self, X_BH: &Isometry3<f64>) -> Vec<Arc> {
        let Ok(posed) = self.pose(X_BH) else { return Vec::new() };
        let mut arcs = Vec::new();
        for (elbow_bit, elbow) in posed.elbows.iter().enumerate() {
            let Some(elbow) = elbow.as_ref().filter(|elbow| self.within(3, elbow.q4).is_ok()) else { continue };
            let turning = Turning { posed: &posed, elbow };
            let shoulder_cuts = self.cuts(&self.shoulder, 0, |g, h| turning.term(g, h));
            let shoulder = Allowed::new(shoulder_cuts, |arm_angle| {
                self.allowed(&self.shoulder, 0, &posed.shoulder(elbow, arm_angle))
            });
            // g · R_wrist h = (turned h) · R_shoulder (bend g).
            let wrist_cuts = self.cuts(&self.wrist, 4, |g, h| turning.term(&(posed.turned * h), &(elbow.bend * g)));
            let wrist = Allowed::new(wrist_cuts, |arm_angle| {
                self.allowed(&self.wrist, 4, &posed.wrist(elbow, &posed.shoulder(elbow, arm_angle)))
            });
            let parts = parts(&tidy(shoulder.cuts.iter().chain(&wrist.cuts).copied().collect()));
            for (wrist_bit, shoulder_bit) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let branch = (elbow_bit << 2 | wrist_bit << 1 | shoulder_bit) as u8;
                let is_allowed = |&(from, to): &(f64, f64)| {
                    let middle = 0.5 * (from + to);
                    shoulder.at(middle)[shoulder_bit] && wrist.at(middle)[wrist_bit]
                };
                join(branch, &parts, is_allowed, &mut arcs);
            }
        }
        arcs
    }

    /// Both branches of a ball at a rotation.
    fn allowed(&self, ball: &Ball, first: usize, rotation: &Matrix3<f64>) -> [bool; 2] {
        self.branches(ball, first, &ball.angles(rotation), rotation).map(|branch| matches!(branch, Some(Ok(_))))
    }

    /// Arm angles at which a joint of a ball crosses a limit, in either branch, or its bend turns back; `term(g, h)` is
    /// `g · R h` of the ball's rotation R.
    fn cuts(&self, ball: &Ball, first: usize, term: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Term) -> Vec<f64> {
        let Ball { a1, a2, a3, e1, e3, bend0 } = ball;
        let bend = term(a1, a3);
        let mut cuts = Vec::with_capacity(16);
        let limits = |joint: usize| [self.limits[first + joint].lower, self.limits[first + joint].upper];
        if bend.amplitude() < ALWAYS_ALIGNED && 1.0 - bend.a.abs() < ALWAYS_ALIGNED {
            // Only the sum of the outer joints counts; the last takes all of it, a half, or three halves against the first.
            let (sine, cosine) = (term(a2, e3), term(a2, a2));
            let (first, last) = (limits(0), limits(2));
            let whole = [last[0], last[1], PI].into_iter();
            let halves = first.iter().chain(&last).flat_map(|limit| [2.0 * limit, -2.0 * limit]);
            let more = last.iter().flat_map(|limit| [-TAU, 0.0, TAU].map(|turn| (limit + turn) / 1.5));
            for sum in whole.chain(halves).chain(more) {
                // The sum is atan2(-sine, cosine).
                let (sin, cos) = math::sin_cos(sum);
                sine.mixed(cos, cosine, -sin).roots(0.0, &mut cuts);
            }
            return cuts;
        }
        // The outer joints jump by half a turn where the bend goes through 0 or π, its extremes.
        if bend.amplitude() > CONSTANT {
            cuts.extend([bend.peak(), math::wrap_angle(bend.peak() + PI)]);
        }
        for limit in limits(1) {
            bend.roots(math::cos(limit + bend0), &mut cuts);
        }
        // sin(bend) cos q and sin(bend) sin q of the outer joints: the carried third axis seen from the first, and back.
        for (joint, cosine, sine) in [(0, term(e1, a3), term(a2, a3)), (2, term(a1, e3), term(a1, a2))] {
            let limit = &self.limits[first + joint];
            if limit.upper - limit.lower < TAU {
                for limit in limits(joint) {
                    let (sin, cos) = math::sin_cos(limit);
                    cosine.mixed(sin, sine, cos).roots(0.0, &mut cuts);
                }
            }
        }
        cuts
    }
}

/// Adds the arcs of one branch: neighbouring allowed parts joined, also over ±π.
fn join(branch: u8, parts: &[(f64, f64)], is_allowed: impl Fn(&(f64, f64)) -> bool, arcs: &mut Vec<Arc>) {
    let own = arcs.len();
    for part in parts.iter().filter(|part| is_allowed(part)) {
        match arcs[own..].last_mut() {
            Some(last) if last.to == part.0 => last.to = part.1,
            _ => arcs.push(Arc { branch, from: part.0, to: part.1 }),
        }
    }
    let (Some(&first), Some(&last)) = (arcs.get(own), arcs.last()) else { return };
    if arcs.len() == own + 1 {
        if first.to - first.from >= TAU - 1e-12 {
            arcs[own] = Arc { branch, from: -PI, to: PI };
        }
    } else if last.to == first.from + TAU {
        arcs.pop();
        arcs[own] = Arc { branch, from: last.from, to: first.to + TAU };
        // The joined arc begins last: the others stay in the order of their angles.
        arcs[own..].rotate_left(1);
    }
}
