//! One side of a handover: an arm, its map, and the grasps that serve its own end of the way.

use nalgebra::{Isometry3, Point3};

use crate::collision::{Checker, CollisionError, HandChecker, Scratch};
use crate::grasp::{Grasp, Situated};
use crate::parallel;
use crate::reach::ReachMap;
use crate::robot::Dexterity;
use crate::task::Workcell;

/// Arm angles over a full turn at which a grasp is looked at.
const ARM_ANGLES: usize = 12;
/// Configurations of a grasp whose straight ways are looked for later.
const WITH_WAYS: usize = 4;

/// An arm that gives or takes.
pub(super) struct Side<'a> {
    pub(super) cell: &'a Workcell,
    pub(super) map: &'a ReachMap,
    /// Base of the arm in the world.
    pub(super) X_WB: Isometry3<f64>,
    /// Grasps that serve the start (giver) or the goal (receiver), the most manipulable there first.
    pub(super) candidates: Vec<Candidate>,
    /// Largest mean manipulability of a voxel of the map.
    most: f64,
    /// The arm alone, everything else at rest.
    arm: Checker,
    q_now: Vec<f64>,
}

/// A grasp of one side.
pub(super) struct Candidate {
    /// Situated at the start of the object or at its goal.
    pub(super) grasp: Grasp,
    /// The closed hand among what stands around.
    pub(super) hand: HandChecker,
}

/// Configurations of an arm at one pose of its hand.
pub(super) struct Held {
    /// The most manipulable first.
    pub(super) q: Vec<Vec<f64>>,
    /// Mean of the manipulabilities (5.2).
    pub(super) m_g: f64,
}

impl<'a> Side<'a> {
    /// Looks at each grasp at the pose `X_WO` of the object, resting there on `supports`; without a pose all are kept.
    pub(super) fn new(
        cell: &'a Workcell,
        map: &'a ReachMap,
        grasps: &[Grasp],
        end: Option<(Isometry3<f64>, EndKind)>,
    ) -> Result<Self, CollisionError> {
        let empty = crate::task::Situation {
            world: cell.world.clone(),
            carried: None,
            may_touch: cell.may_touch.clone(),
            q_rest: cell.q_with_fingers(&cell.hand.open),
        };
        let mut side = Side {
            cell,
            map,
            X_WB: cell.robot.link_poses(&cell.q_start)[cell.arm().base_link],
            candidates: Vec::new(),
            most: map.voxels().map(|voxel| map.mean_manipulability(voxel)).fold(1e-12, f64::max),
            arm: cell.checker(&empty)?,
            q_now: cell.arm().dofs.iter().map(|&dof| cell.q_start[dof]).collect(),
        };
        let holding: Vec<&Grasp> = grasps.iter().filter(|grasp| grasp.is_accepted()).collect();
        let judged = parallel::map(&holding, |grasp| side.candidate(grasp, end));
        for candidate in judged {
            side.candidates.extend(candidate?);
        }
        let m_g = |candidate: &Candidate| {
            let grasp = &candidate.grasp;
            grasp.goal.as_ref().or(grasp.start.as_ref()).map_or(grasp.epsilon, |set| set.m_g)
        };
        // A stable sort: equal ones stay in the order of generation.
        side.candidates.sort_by(|l, r| m_g(r).total_cmp(&m_g(l)));
        Ok(side)
    }

    fn candidate(
        &self,
        grasp: &Grasp,
        end: Option<(Isometry3<f64>, EndKind)>,
    ) -> Result<Option<Candidate>, CollisionError> {
        let cell = self.cell;
        let hand = HandChecker::new(&cell.model, &cell.world, &cell.may_touch, cell.arm_index, &grasp.closed)?;
        let mut candidate = Candidate { grasp: grasp.clone(), hand };
        candidate.grasp.start = None;
        candidate.grasp.goal = None;
        let Some((X_WO, kind)) = end else { return Ok(Some(candidate)) };
        let Some(held) = self.held(&candidate, &(X_WO * grasp.X_OH)) else { return Ok(None) };
        let situated = Situated {
            X_WO,
            poses: 1,
            m_g: held.m_g,
            ik_count: held.q.len(),
            with_ways: (0..held.q.len().min(WITH_WAYS)).collect(),
            solutions: held.q,
            ..Situated::default()
        };
        match kind {
            EndKind::Start => candidate.grasp.start = Some(situated),
            EndKind::Goal => candidate.grasp.goal = Some(situated),
        }
        Ok(Some(candidate))
    }

    /// The arm with its hand at a pose, the hand free of everything that stands around; `None` if there is no such
    /// configuration.
    pub(super) fn held(&self, candidate: &Candidate, X_WH: &Isometry3<f64>) -> Option<Held> {
        candidate.hand.first_hit(X_WH).is_none().then(|| self.configurations(X_WH))?
    }

    /// Configurations that bring the hand to a pose, the hand itself not looked at.
    pub(super) fn configurations(&self, X_WH: &Isometry3<f64>) -> Option<Held> {
        let cell = self.cell;
        let found = cell.ik.set(&self.X_WB.inv_mul(X_WH), &self.q_now, ARM_ANGLES);
        let mut scratch = Scratch::default();
        let free: Vec<&[f64]> =
            found.iter().filter(|q| self.arm.first_hit_besides_hand(&mut scratch, q).is_none()).collect();
        let mut placed = Vec::new();
        Dexterity::new(cell.ik.chain()).all(&free.concat(), &mut placed);
        let sum: f64 = placed.iter().map(|placed| placed.manipulability).sum();
        let mut order: Vec<usize> = (0..free.len()).collect();
        order.sort_by(|&l, &r| placed[r].manipulability.total_cmp(&placed[l].manipulability).then(l.cmp(&r)));
        let q: Vec<Vec<f64>> = order.into_iter().map(|index| free[index].to_vec()).collect();
        (!q.is_empty()).then(|| Held { m_g: sum / q.len() as f64, q })
    }

    /// The largest mean manipulability of the arm's map, for shares of it.
    pub(super) fn most_of_arm(&self) -> f64 {
        self.most
    }

    /// Where the arm begins, in the world.
    pub(super) fn shoulder(&self) -> Point3<f64> {
        self.X_WB * Point3::from(self.cell.ik.chain().origin())
    }

    /// Share of the map's largest mean manipulability that the voxel around a point of the world has; 0 out of reach.
    pub(super) fn share(&self, p_W: &Point3<f64>) -> f64 {
        let voxel = self.map.voxel_at(&self.X_WB.inverse_transform_point(p_W));
        voxel.map_or(0.0, |voxel| self.map.mean_manipulability(voxel) / self.most)
    }
}

/// Which end of the object's way a side serves.
#[derive(Clone, Copy)]
pub(super) enum EndKind {
    Start,
    Goal,
}
