//! An S-R-S arm behind one or two more joints, such as a turning torso: those are sampled, the rest is closed form.

use nalgebra::Isometry3;

use super::arm::most_frequent;
use super::{IkReject, IkSet, NotSrs, SrsArm};
use crate::robot::{Chain, JointKind, JointLimit, Robot};

/// Positions of each joint before an S-R-S arm, besides the present one.
pub const EXTRA_SAMPLES: usize = 5;
/// Most joints before an S-R-S arm that are sampled; a longer chain is solved numerically.
const MAX_EXTRA: usize = 2;

/// Extra joints, then an S-R-S arm of seven.
#[derive(Clone, Debug)]
pub(super) struct LedArm {
    lead: Chain,
    srs: SrsArm,
    /// Positions of each extra joint besides the present one.
    pub(super) samples: usize,
}

impl LedArm {
    /// Splits a chain into at most [`MAX_EXTRA`] joints and an S-R-S arm of the last seven; else why the seven are none,
    /// if there are that many.
    pub(super) fn between(robot: &Robot, base_link: usize, tip_link: usize) -> Result<Self, Option<NotSrs>> {
        let moving = |joint: &usize| robot.joints[*joint].kind != JointKind::Fixed;
        let chain = robot.chain(base_link, tip_link).unwrap_or_default();
        let joints: Vec<usize> = chain.into_iter().filter(moving).collect();
        let Some(extra) = joints.len().checked_sub(7).filter(|extra| (1..=MAX_EXTRA).contains(extra)) else {
            return Err(None);
        };
        let shoulder_link = robot.joints[joints[extra - 1]].child;
        let srs = SrsArm::between(robot, shoulder_link, tip_link).map_err(Some)?;
        let lead = Chain::between(robot, base_link, shoulder_link).map_err(|_| None)?;
        // A joint that copies another cannot be sampled by itself.
        let own = joints[..extra].iter().all(|&joint| robot.joints[joint].dof.is_some());
        if own { Ok(Self { lead, srs, samples: EXTRA_SAMPLES }) } else { Err(None) }
    }

    pub(super) fn extra_joints(&self) -> usize {
        self.lead.dofs().len()
    }

    /// Adds the solutions at all positions of the extra joints to `values`, joint vector by joint vector.
    pub(super) fn set(
        &self,
        X_BH: &Isometry3<f64>,
        q_now: &[f64],
        arm_angles: usize,
        values: &mut Vec<f64>,
        rejected: &mut Vec<IkReject>,
    ) {
        let mut found = IkSet::default();
        self.for_each_sample(q_now, |extra| {
            found.clear();
            self.srs.sweep_into(&self.seen_from_arm(extra, X_BH), arm_angles, &mut found);
            for solution in &found.solutions {
                values.extend(extra.iter().chain(&solution.q));
            }
            rejected.append(&mut found.rejected);
            true
        });
        keep_least_gap(rejected);
    }

    /// A solution at the first position of the extra joints that has one.
    pub(super) fn first(&self, X_BH: &Isometry3<f64>, q_now: &[f64]) -> Result<Vec<f64>, IkReject> {
        let mut answer = None;
        let mut rejected = Vec::new();
        self.for_each_sample(q_now, |extra| {
            match self.srs.first(&self.seen_from_arm(extra, X_BH)) {
                Ok(q) => answer = Some(extra.iter().chain(&q).copied().collect()),
                Err(reject) => rejected.push(reject),
            }
            answer.is_none()
        });
        keep_least_gap(&mut rejected);
        answer.ok_or_else(|| most_frequent(&rejected))
    }

    /// The solution nearest to a posture whose extra joints stay where they are.
    pub(super) fn near(&self, X_BH: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>> {
        let (extra, seven) = near.split_at_checked(self.extra_joints())?;
        let q = self.srs.near(&self.seen_from_arm(extra, X_BH), seven.try_into().ok()?)?;
        Some(extra.iter().chain(&q).copied().collect())
    }

    /// The least gap over the positions of the extra joints, metres.
    pub(super) fn reach_gap_m(&self, X_BH: &Isometry3<f64>, q_now: &[f64]) -> f64 {
        let mut least = f64::INFINITY;
        self.for_each_sample(q_now, |extra| {
            least = least.min(self.srs.reach_gap_m(&self.seen_from_arm(extra, X_BH)));
            least > 0.0
        });
        least
    }

    /// The hand in the frame of the link that carries the seven.
    fn seen_from_arm(&self, extra: &[f64], X_BH: &Isometry3<f64>) -> Isometry3<f64> {
        self.lead.tip(extra).inv_mul(X_BH)
    }

    /// All combinations of positions of the extra joints until told to stop: the present ones first, then `samples`
    /// each, evenly over the limits.
    fn for_each_sample(&self, q_now: &[f64], mut go_on: impl FnMut(&[f64]) -> bool) {
        let limits = self.lead.limits();
        let now = &q_now[..limits.len()];
        if !go_on(now) {
            return;
        }
        for index in 0..self.samples.pow(limits.len() as u32) {
            let mut rest = index;
            let position = |limit: &JointLimit| {
                let step = rest % self.samples;
                rest /= self.samples;
                // Middles of equal parts, so that no sample stands at a stop.
                limit.lower + (limit.upper - limit.lower) * (step as f64 + 0.5) / self.samples as f64
            };
            let extra: Vec<f64> = limits.iter().map(position).collect();
            let is_present = extra.iter().zip(now).all(|(a, b)| (a - b).abs() < 1e-9);
            if !is_present && !go_on(&extra) {
                return;
            }
        }
    }
}

/// Of the gaps at several positions of the extra joints only the least counts.
fn keep_least_gap(rejected: &mut Vec<IkReject>) {
    let gap = |reject: &IkReject| match reject {
        IkReject::OutOfReach { gap_m } | IkReject::TooClose { gap_m } => Some(*gap_m),
        _ => None,
    };
    let gaps = rejected.iter().filter_map(|reject| Some((gap(reject)?, *reject)));
    let least = gaps.min_by(|l, r| l.0.total_cmp(&r.0)).map(|(_, reject)| reject);
    rejected.retain(|reject| gap(reject).is_none());
    rejected.extend(least);
}
