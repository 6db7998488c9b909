//! A grasp at a place: the set of arm configurations that reach it, and the mean of their manipulability (5.2).

use nalgebra::Isometry3;

use super::{Obstruction, Situated};
use crate::robot::ik::ArmIk;
use crate::robot::{Arm, Dexterity, Robot};

/// The arm, and what decides whether one of its configurations may be used.
pub struct Reach<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The arm that grasps.
    pub arm: &'a Arm,
    /// Its inverse kinematics.
    pub ik: &'a ArmIk,
    /// All joint positions; the arm's own are those from which a search starts.
    pub q_rest: &'a [f64],
    /// Arm angles over a full turn at which all branches are solved; starts of a numeric search.
    pub arm_angles: usize,
}

impl Reach<'_> {
    /// All configurations that bring the hand to `X_WH`; `hit` names what one of them runs into.
    ///
    /// `hit` gets the arm's joints from shoulder to wrist.
    pub fn situate(&self, X_WH: &Isometry3<f64>, mut hit: impl FnMut(&[f64]) -> Option<Obstruction>) -> Situated {
        let X_WB = self.robot.link_poses(self.q_rest)[self.arm.base_link];
        let q_now: Vec<f64> = self.arm.dofs.iter().map(|&dof| self.q_rest[dof]).collect();
        let X_BH = X_WB.inv_mul(X_WH);
        let found = self.ik.set(&X_BH, &q_now, self.arm_angles);

        let feasible = self.ik.closed_form().map(|arm| arm.feasible_arcs(&X_BH)).unwrap_or_default();
        let mut situated = Situated { feasible, ..Situated::default() };
        let mut reasons: Vec<(Obstruction, usize)> = Vec::new();
        let mut turn_away = |reason: Obstruction| match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => reasons.push((reason, 1)),
        };
        found.rejected.iter().for_each(|reject| turn_away(reject.into()));
        let mut free: Vec<f64> = Vec::new();
        for solution in found.iter() {
            match hit(solution) {
                Some(reason) => turn_away(reason),
                None => {
                    free.extend_from_slice(solution);
                    situated.solutions.push(solution.to_vec());
                }
            }
        }
        let mut placed = Vec::new();
        Dexterity::new(self.ik.chain()).all(&free, &mut placed);
        situated.manipulability = placed.iter().map(|placed| placed.manipulability).collect();
        situated.ik_count = situated.solutions.len();
        if situated.ik_count > 0 {
            situated.m_g = situated.manipulability.iter().sum::<f64>() / situated.ik_count as f64;
        }
        // A stable sort: equally frequent ones stay in the order in which they were met.
        reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        situated.rejected = reasons;
        situated
    }
}

impl Situated {
    /// The most frequent reason why configurations were turned away.
    pub fn main_reason(&self) -> Obstruction {
        let none = || Obstruction::Invalid { reason: "no arm configuration".to_owned() };
        self.rejected.first().map_or_else(none, |(reason, _)| reason.clone())
    }
}
