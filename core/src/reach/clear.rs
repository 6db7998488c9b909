//! Self-collision: the first of a pose's configurations in which the robot touches nothing of itself.

use crate::collision::{Checker, CollisionModel, Owner, Pair, Scratch, State, World};
use crate::robot::{JointKind, Robot};

use super::ReachError;

/// An arm with its hand open, among the links that no other arm moves: those can be moved out of the way.
#[derive(Clone, Debug)]
pub(super) struct SelfClear {
    checker: Checker,
    /// Of each link whether it goes where the hand goes.
    with_hand: Vec<bool>,
    /// Of each link whether no joint of the arm moves it.
    still: Vec<bool>,
}

/// Adds the next configuration of a pose to the end of a list; `false` when it has no more.
pub(super) type Next<'a> = &'a mut dyn FnMut(usize, &mut Vec<f64>) -> bool;

impl SelfClear {
    pub(super) fn of(robot: &Robot, arm_index: usize) -> Result<Self, ReachError> {
        let arms = robot.arms.len();
        let arm = robot.arms.get(arm_index).ok_or(ReachError::NoSuchArm { found: arm_index, arms })?;
        let moved_by = |link: usize| -> Vec<usize> {
            let joints = robot.chain(0, link).unwrap_or_default();
            let moving = joints.iter().map(|&joint| &robot.joints[joint]).filter(|j| j.kind != JointKind::Fixed);
            moving.filter_map(|joint| joint.dof.or(joint.mimic.map(|mimic| mimic.dof))).collect()
        };
        let moved_by: Vec<Vec<usize>> = (0..robot.links.len()).map(moved_by).collect();
        let is_own = |dof: &usize| arm.dofs.contains(dof);
        let is_others = |dof: &usize| !is_own(dof) && robot.arms.iter().any(|other| other.dofs.contains(dof));
        let mut alone = robot.clone();
        for (link, dofs) in alone.links.iter_mut().zip(&moved_by) {
            if dofs.iter().any(is_others) {
                link.collisions.clear();
            }
        }
        let mut q_rest = vec![0.0; robot.dof_count()];
        for (&dof, &open) in arm.hand.fingers.iter().flatten().zip(&arm.hand.open) {
            q_rest[dof] = open;
        }
        let model = CollisionModel::new(&alone)?;
        let checker = Checker::for_arm(&model, &World::new(), None, &[], arm_index, &q_rest)?;
        let with_hand = moved_by.iter().map(|dofs| arm.dofs.iter().all(|dof| dofs.contains(dof))).collect();
        let still = moved_by.iter().map(|dofs| !dofs.iter().any(is_own)).collect();
        Ok(Self { checker, with_hand, still })
    }

    /// For each pose whether one of its configurations touches nothing: then it is the last one that was asked for.
    ///
    /// The first of all poses go through the sieve of the checker side by side, then the second of those that are
    /// left, and so on. A pose at which the hand touches something that stands still is given up at once.
    pub(super) fn first_free(&self, scratch: &mut Scratch, poses: usize, next: Next<'_>) -> Vec<bool> {
        let joints = self.checker.dofs().len();
        let mut is_free = vec![false; poses];
        let mut open: Vec<usize> = (0..poses).collect();
        let mut q = Vec::new();
        while !open.is_empty() {
            q.clear();
            open.retain(|&pose| next(pose, &mut q));
            let configurations: Vec<&[f64]> = q.chunks_exact(joints).collect();
            let mut sure = self.checker.surely_free(scratch, &configurations).into_iter();
            let mut asked = configurations.iter();
            open.retain(|&pose| {
                let (Some(sure), Some(q)) = (sure.next(), asked.next()) else { return false };
                if !sure && let State::Hit(pair) = self.checker.state(scratch, q, None) {
                    return !self.is_hopeless(pair);
                }
                is_free[pose] = true;
                false
            });
        }
        is_free
    }

    /// Whether the pair touches wherever the rest of the arm is.
    fn is_hopeless(&self, pair: Pair) -> bool {
        let (Owner::Link(a), Owner::Link(b)) = (pair.a, pair.b) else { return false };
        let is_fixed = |link: usize| self.with_hand[link] || self.still[link];
        is_fixed(a) && is_fixed(b)
    }
}
