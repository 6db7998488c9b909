//! One side of a handover: an arm, its map, and the grasps that serve its own end of the way.

use std::sync::OnceLock;

use nalgebra::{Isometry3, Point3, Translation3};

use super::effort::Effort;

use crate::collision::{Checker, CollisionError, HandChecker, Scratch};
use crate::grasp::{Grasp, Obstruction, Situated};
use crate::parallel;
use crate::reach::ReachMap;
use crate::robot::Dexterity;
use crate::task::{LEAST_LIFT, MotionSettings, Workcell};

/// Arm angles over a full turn at which a grasp is looked at.
const ARM_ANGLES: usize = 8;
/// Configurations of a hand pose that are looked for, the most manipulable first.
const CONFIGURATIONS: usize = 8;
/// Configurations of a grasp whose straight ways are looked for later.
const WITH_WAYS: usize = 4;

/// An arm that gives or takes.
pub(super) struct Side<'a> {
    pub(super) cell: &'a Workcell,
    /// `None` where no place is looked for.
    pub(super) map: Option<&'a ReachMap>,
    /// Base of the arm in the world.
    pub(super) X_WB: Isometry3<f64>,
    /// Grasps that serve the start (giver) or the goal (receiver), the most manipulable there first.
    pub(super) candidates: Vec<Candidate>,
    /// The open hand.
    pub(super) open: HandChecker,
    motion: &'a MotionSettings,
    /// Why the other grasps do not serve it.
    pub(super) rejected: Vec<Obstruction>,
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
    /// Where the object may be held at the end, the most manipulable first, the object not looked at; and where it is.
    ends: Vec<Situated>,
    end: OnceLock<Option<Situated>>,
}

/// Configurations of an arm at one pose of its hand.
#[derive(Clone)]
pub(super) struct Held {
    /// The most manipulable first.
    pub(super) q: Vec<Vec<f64>>,
    /// Mean of their manipulabilities: (5.2) over the best few.
    pub(super) m_g: f64,
}

impl<'a> Side<'a> {
    /// Looks at each grasp at the poses that the object may have at that end of its way, and takes for each the one at
    /// which it is the most manipulable; without a pose all are kept.
    pub(super) fn new(
        cell: &'a Workcell,
        map: Option<&'a ReachMap>,
        motion: &'a MotionSettings,
        grasps: &[Grasp],
        end: (EndKind, &[Isometry3<f64>]),
        effort: Effort,
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
            open: HandChecker::new(&cell.model, &cell.world, &cell.may_touch, cell.arm_index, &cell.hand.open)?,
            motion,
            rejected: Vec::new(),
            most: map
                .map_or(1e-12, |map| map.voxels().map(|voxel| map.mean_manipulability(voxel)).fold(1e-12, f64::max)),
            arm: cell.checker(&empty)?,
            q_now: cell.arm().dofs.iter().map(|&dof| cell.q_start[dof]).collect(),
        };
        let holding: Vec<&Grasp> = grasps.iter().filter(|grasp| grasp.is_accepted()).collect();
        let judged = parallel::map(&holding, |grasp| side.candidate(grasp, end, effort));
        for candidate in judged {
            match candidate? {
                Ok(candidate) => side.candidates.push(candidate),
                Err(reason) => side.rejected.push(reason),
            }
        }
        let m_g = |candidate: &Candidate| {
            let grasp = &candidate.grasp;
            let end = candidate.ends.first().or(grasp.goal.as_ref()).or(grasp.start.as_ref());
            end.map_or(grasp.epsilon, |set| set.m_g)
        };
        // A stable sort: equal ones stay in the order of generation.
        side.candidates.sort_by(|l, r| m_g(r).total_cmp(&m_g(l)));
        Ok(side)
    }

    fn candidate(
        &self,
        grasp: &Grasp,
        (kind, poses): (EndKind, &[Isometry3<f64>]),
        effort: Effort,
    ) -> Result<Result<Candidate, Obstruction>, CollisionError> {
        let cell = self.cell;
        let hand = HandChecker::new(&cell.model, &cell.world, &cell.may_touch, cell.arm_index, &grasp.closed)?;
        let mut candidate = Candidate { grasp: grasp.clone(), hand, ends: Vec::new(), end: OnceLock::new() };
        candidate.grasp.start = None;
        candidate.grasp.goal = None;
        let mut first = None;
        for X_WO in &poses[..poses.len().min(effort.poses())] {
            if candidate.ends.len() == effort.served_poses() {
                break;
            }
            let X_WH = X_WO * grasp.X_OH;
            let held = self.held(&candidate, &X_WH);
            match held.and_then(|held| if kind == EndKind::Held { Ok(held) } else { self.with_ways(held, &X_WH) }) {
                Ok(Held { q, m_g }) => candidate.ends.push(Situated {
                    X_WO: *X_WO,
                    poses: poses.len(),
                    m_g,
                    ik_count: q.len(),
                    with_ways: (0..q.len().min(WITH_WAYS)).collect(),
                    solutions: q,
                    ..Situated::default()
                }),
                Err(reason) => first = first.or(Some(reason)),
            }
        }
        if candidate.ends.is_empty() && !poses.is_empty() {
            return Ok(
                Err(first.unwrap_or_else(|| Obstruction::Invalid { reason: "no arm configuration".to_owned() })),
            );
        }
        // A stable sort: equal ones stay in the order of the poses.
        candidate.ends.sort_by(|l, r| r.m_g.total_cmp(&l.m_g));
        match kind {
            EndKind::Start => candidate.grasp.start = candidate.ends.first().cloned(),
            EndKind::Goal => candidate.grasp.goal = candidate.ends.first().cloned(),
            // Where it is held, the object is in the arm's way too: that is looked at for few.
            EndKind::Held => return Ok(Ok(candidate)),
        }
        candidate.ends.clear();
        Ok(Ok(candidate))
    }

    /// The grasp with the end of the way that it serves; `None` if the object in the hand hits something there. What is
    /// found out is kept.
    pub(super) fn serving(&self, candidate: &Candidate) -> Option<Grasp> {
        if candidate.ends.is_empty() {
            return Some(candidate.grasp.clone());
        }
        let look = || {
            let carrying = self.cell.carrying(&candidate.grasp, &[]).and_then(|carrying| self.cell.checker(&carrying));
            let carrying = carrying.ok()?;
            let mut scratch = Scratch::default();
            candidate.ends.iter().find_map(|end| {
                let free = end.solutions.iter().filter(|q| carrying.is_free(&mut scratch, q));
                let solutions: Vec<Vec<f64>> = free.cloned().collect();
                (!solutions.is_empty()).then(|| Situated { solutions, ..end.clone() })
            })
        };
        let end = candidate.end.get_or_init(look).clone()?;
        Some(Grasp { goal: Some(end), ..candidate.grasp.clone() })
    }

    /// The configurations from which the hand can back off and, where the object stands on something, rise with it: at
    /// the ends of these ways the arm is looked at, the motions are proven later.
    fn with_ways(&self, held: Held, X_WH: &Isometry3<f64>) -> Result<Held, Obstruction> {
        let back = X_WH * Translation3::new(0.0, 0.0, -self.motion.min_approach_m);
        let up = Translation3::new(0.0, 0.0, LEAST_LIFT * self.motion.lift_m) * X_WH;
        let ends = [back, up].map(|X_WH_end| self.X_WB.inv_mul(&X_WH_end));
        let mut scratch = Scratch::default();
        let mut q = held.q;
        q.retain(|q| {
            ends.iter().all(|X_BH| {
                let near = self.cell.ik.near(X_BH, q);
                near.is_some_and(|q| self.arm.first_hit_besides_hand(&mut scratch, &q).is_none())
            })
        });
        if q.is_empty() {
            return Err(Obstruction::Invalid { reason: "no straight way in or up".to_owned() });
        }
        Ok(Held { q, ..held })
    }

    /// The arm with its hand at a pose, the hand free of everything that stands around.
    ///
    /// # Errors
    /// What keeps it from there.
    pub(super) fn held(&self, candidate: &Candidate, X_WH: &Isometry3<f64>) -> Result<Held, Obstruction> {
        // Most poses are out of reach, which is told fastest.
        let X_BH = self.X_WB.inv_mul(X_WH);
        let gap_m = self.cell.ik.reach_gap_m(&X_BH, &self.q_now);
        if gap_m > 0.0 {
            let told = self.cell.ik.first(&X_BH, &self.q_now).err();
            return Err(told.map_or(Obstruction::OutOfReach { gap_m }, |reject| (&reject).into()));
        }
        match candidate.hand.first_hit(X_WH) {
            Some(hit) => Err(hit.into()),
            None => self.configurations(X_WH),
        }
    }

    /// The manipulability that the map promises for a pose of the hand, if it is worth a closer look: quickly, if the map
    /// says that the arm gets there; thoroughly, if the arm is long enough.
    pub(super) fn promise(&self, X_WH: &Isometry3<f64>, effort: Effort) -> Option<f64> {
        let X_BH = self.X_WB.inv_mul(X_WH);
        let known = self.map.and_then(|map| {
            let (voxel, orientation) = map.nearest(&X_BH)?;
            map.manipulability(voxel, orientation)
        });
        match effort {
            Effort::Quick => known,
            Effort::Thorough => {
                (self.cell.ik.reach_gap_m(&X_BH, &self.q_now) <= 0.0).then(|| known.unwrap_or_default())
            }
        }
    }

    /// Configurations that bring the hand to a pose, the hand itself not looked at.
    ///
    /// # Errors
    /// What keeps the arm from there.
    pub(super) fn configurations(&self, X_WH: &Isometry3<f64>) -> Result<Held, Obstruction> {
        let cell = self.cell;
        let found = cell.ik.set(&self.X_WB.inv_mul(X_WH), &self.q_now, ARM_ANGLES);
        let solutions: Vec<&[f64]> = found.iter().collect();
        let mut placed = Vec::new();
        Dexterity::new(cell.ik.chain()).all(&solutions.concat(), &mut placed);
        let mut order: Vec<usize> = (0..solutions.len()).collect();
        order.sort_by(|&l, &r| placed[r].manipulability.total_cmp(&placed[l].manipulability).then(l.cmp(&r)));
        let mut scratch = Scratch::default();
        let mut hit = None;
        let (mut q, mut sum) = (Vec::new(), 0.0);
        for index in order {
            match self.arm.first_hit_besides_hand(&mut scratch, solutions[index]) {
                Some(found) => hit = hit.or(Some(found)),
                None => {
                    q.push(solutions[index].to_vec());
                    sum += placed[index].manipulability;
                }
            }
            if q.len() == CONFIGURATIONS {
                break;
            }
        }
        if q.is_empty() {
            let none = || Obstruction::Invalid { reason: "no arm configuration".to_owned() };
            return Err(hit
                .map(Obstruction::from)
                .or(found.rejected.first().map(Obstruction::from))
                .unwrap_or_else(none));
        }
        Ok(Held { m_g: sum / q.len() as f64, q })
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
        let mean = |map: &ReachMap| {
            let voxel = map.voxel_at(&self.X_WB.inverse_transform_point(p_W))?;
            Some(map.mean_manipulability(voxel) / self.most)
        };
        self.map.and_then(mean).unwrap_or(0.0)
    }
}

/// How many grasps of an arm serve a pose of the object at which it is taken up or put down.
///
/// # Errors
/// [`CollisionError`] when bodies make no sense.
pub(crate) fn count_serving(
    cell: &Workcell,
    motion: &MotionSettings,
    grasps: &[Grasp],
    poses: &[Isometry3<f64>],
) -> Result<usize, CollisionError> {
    let end = (EndKind::Goal, poses);
    Ok(if poses.is_empty() { 0 } else { Side::new(cell, None, motion, grasps, end, Effort::Quick)?.candidates.len() })
}

/// Which end of the object's way a side serves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum EndKind {
    /// It is taken up there.
    Start,
    /// It is put down there.
    Goal,
    /// It is held there.
    Held,
}
