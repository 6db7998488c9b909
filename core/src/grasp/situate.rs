//! A grasp at a place: the set of arm configurations that reach it, and the mean of their manipulability (5.2).

use nalgebra::Isometry3;

use super::Situated;
use crate::robot::ik::{IkReject, IkSet, SrsArm};
use crate::robot::{Arm, Robot};

/// The arm, and what decides whether one of its configurations may be used.
pub struct Reach<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The arm that grasps.
    pub arm: &'a Arm,
    /// Its closed-form inverse kinematics.
    pub ik: &'a SrsArm,
    /// All joint positions; the arm's own are not used.
    pub q_rest: &'a [f64],
    /// Arm angles over a full turn at which all branches are solved.
    pub arm_angles: usize,
}

impl Reach<'_> {
    /// All configurations that bring the hand to `X_WH`; `hit` names what one of them runs into.
    ///
    /// `hit` gets the arm's joints from shoulder to wrist.
    pub fn situate(&self, X_WH: &Isometry3<f64>, mut hit: impl FnMut(&[f64]) -> Option<String>) -> Situated {
        let X_WB = self.robot.link_poses(self.q_rest)[self.arm.base_link];
        let mut found = IkSet::default();
        self.ik.sweep_into(&X_WB.inv_mul(X_WH), self.arm_angles, &mut found);

        let mut situated = Situated::default();
        let mut reasons: Vec<(String, usize)> = Vec::new();
        let mut turn_away = |reason: String, times: usize| match reasons.iter_mut().find(|(known, _)| *known == reason)
        {
            Some((_, count)) => *count += times,
            None => reasons.push((reason, times)),
        };
        match found.rejected.first() {
            // One reject for the whole pose says by how much.
            Some(reject @ (IkReject::OutOfReach { .. } | IkReject::TooClose { .. })) => {
                turn_away(reject.to_string(), 1)
            }
            _ => found.reject_counts().into_iter().for_each(|(reason, times)| turn_away(reason, times)),
        }
        let mut q = self.q_rest.to_vec();
        let mut X_WL = Vec::new();
        for solution in &found.solutions {
            if let Some(reason) = hit(&solution.q) {
                turn_away(reason, 1);
                continue;
            }
            for (&dof, &position) in self.arm.dofs.iter().zip(&solution.q) {
                q[dof] = position;
            }
            self.robot.link_poses_into(&q, &mut X_WL);
            situated.manipulability.push(self.robot.manipulability(self.arm, &X_WL));
            situated.solutions.push(solution.q.to_vec());
        }
        situated.ik_count = situated.solutions.len();
        if situated.ik_count > 0 {
            situated.m_g = situated.manipulability.iter().sum::<f64>() / situated.ik_count as f64;
        }
        reasons.sort_by(|l, r| r.1.cmp(&l.1).then_with(|| l.0.cmp(&r.0)));
        situated.rejected = reasons;
        situated
    }
}

impl Situated {
    /// The most frequent reason why configurations were turned away, for a person.
    pub fn main_reason(&self) -> String {
        self.rejected.first().map_or_else(|| "no arm configuration".to_owned(), |(reason, _)| reason.clone())
    }
}
