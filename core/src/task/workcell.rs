//! Everything that ranking and planning share: robot, arm, obstacles, and the object at its start and goal.

use std::sync::Arc;

use nalgebra::Isometry3;

use super::{Leg, PhaseKind, Plan};
use crate::collision::{
    CarriedObject, Checker, CollisionError, CollisionModel, ConvexHull, Exhaustive, MayTouch, Party, World,
};
use crate::grasp::{Grasp, HandModel};
use crate::plan::{WalkHit, walk};
use crate::robot::ik::ArmIk;
use crate::robot::{Arm, ChainError, Robot};

/// What reasons call the object that is grasped.
pub const TARGET: &str = "object";
/// Open fingers may dip this far into the hull of the target, metres: the error of a good fit.
const OPEN_FINGER_DEPTH_M: f64 = 0.002;
/// How far the object may sink into what it stands on, metres: a fit's bottom is known to about a centimetre.
const REST_DEPTH_M: f64 = 0.012;

/// One arm of a robot in front of a scene, with one object to handle.
pub struct Workcell {
    /// The robot.
    pub robot: Arc<Robot>,
    /// Its bodies.
    pub model: CollisionModel,
    /// Index of the acting arm in [`Robot::arms`].
    pub arm_index: usize,
    /// Inverse kinematics of that arm.
    pub ik: ArmIk,
    /// Its hand.
    pub hand: HandModel,
    /// All joints before anything moves.
    pub q_start: Vec<f64>,
    /// Obstacles, the object itself left out.
    pub world: World,
    /// The object's convex pieces in its frame O.
    pub target_O: Vec<ConvexHull>,
    /// Pose of O in the world where the object stands now.
    pub X_WO_start: Isometry3<f64>,
    /// Pose of O where it shall be put, if anywhere.
    pub X_WO_goal: Option<Isometry3<f64>>,
}

/// What surrounds the arm while it moves: what stands, what is carried, what may touch.
pub struct Situation {
    /// Obstacles, the standing object among them.
    pub world: World,
    /// The object, when the hand holds it.
    pub carried: Option<CarriedObject>,
    /// Contacts that are intended.
    pub may_touch: Vec<MayTouch>,
    /// All joints; those of the arm are not used.
    pub q_rest: Vec<f64>,
}

/// Why a workcell cannot be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorkcellError {
    /// The robot has no such arm.
    #[error("{robot} has no {arm} arm")]
    NoArm { robot: String, arm: String },
    /// The robot has no such posture.
    #[error("{robot} has no posture {posture:?}")]
    NoPosture { robot: String, posture: String },
    /// The arm's joints are no chain to its hand.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// A body makes no sense.
    #[error(transparent)]
    Collision(#[from] CollisionError),
}

impl Workcell {
    /// The arm that acts.
    pub fn arm(&self) -> &Arm {
        &self.robot.arms[self.arm_index]
    }

    /// All joints with the hand's fingers at these positions.
    pub fn q_with_fingers(&self, fingers: &[f64]) -> Vec<f64> {
        let mut q = self.q_start.clone();
        for (&dof, &position) in self.arm().hand.fingers.iter().flatten().zip(fingers) {
            q[dof] = position;
        }
        q
    }

    /// The open hand on its way to or from the object, which stands at `X_WO`.
    ///
    /// # Errors
    /// [`CollisionError`] when the object's hull has no volume.
    pub fn approaching(&self, X_WO: &Isometry3<f64>) -> Result<Situation, CollisionError> {
        self.beside_object(X_WO, &self.hand.open, OPEN_FINGER_DEPTH_M)
    }

    /// The closed hand at the object, which stands at `X_WO`: the hand may touch it.
    ///
    /// # Errors
    /// As [`Workcell::approaching`].
    pub fn grasping(&self, X_WO: &Isometry3<f64>, fingers: &[f64]) -> Result<Situation, CollisionError> {
        self.beside_object(X_WO, fingers, f64::INFINITY)
    }

    fn beside_object(&self, X_WO: &Isometry3<f64>, fingers: &[f64], depth_m: f64) -> Result<Situation, CollisionError> {
        let mut world = self.world.clone();
        for piece_O in &self.target_O {
            world.add_hull(TARGET, piece_O, X_WO)?;
        }
        let links = &self.arm().hand.links;
        let contact = |&link: &usize| MayTouch { a: Party::Link(link), b: Party::Obstacle(TARGET.into()), depth_m };
        let may_touch = links.iter().map(contact).collect();
        Ok(Situation { world, carried: None, may_touch, q_rest: self.q_with_fingers(fingers) })
    }

    /// The hand that carries the object by a grasp; `resting` names what the object may stand on.
    ///
    /// # Errors
    /// As [`Workcell::approaching`].
    pub fn carrying(&self, grasp: &Grasp, resting: &[String]) -> Result<Situation, CollisionError> {
        let X_HO = grasp.X_OH.inverse();
        let carried = CarriedObject::new(TARGET, &self.target_O, &X_HO, &self.robot, self.arm_index)?;
        Ok(Situation {
            world: self.world.clone(),
            carried: Some(carried),
            may_touch: resting.iter().map(|name| MayTouch::carried(name, REST_DEPTH_M)).collect(),
            q_rest: self.q_with_fingers(&grasp.closed),
        })
    }

    /// What surrounds the arm in a phase of a leg.
    ///
    /// # Errors
    /// As [`Workcell::approaching`].
    pub fn situation(&self, kind: PhaseKind, leg: &Leg) -> Result<Situation, CollisionError> {
        let Leg { grasp, X_WO_start, X_WO_end } = leg;
        match kind {
            PhaseKind::Reach => self.approaching(X_WO_start),
            PhaseKind::Close => self.grasping(X_WO_start, &grasp.closed),
            PhaseKind::Lift => self.carrying(grasp, &self.supports(X_WO_start)),
            PhaseKind::Transport | PhaseKind::Pour => self.carrying(grasp, &[]),
            PhaseKind::Slide | PhaseKind::Place => self.carrying(grasp, &self.supports(X_WO_end)),
            PhaseKind::Open => self.grasping(X_WO_end, &grasp.closed),
            PhaseKind::Retreat => self.approaching(X_WO_end),
        }
    }

    /// A checker of the acting arm in a situation.
    ///
    /// # Errors
    /// As [`Workcell::approaching`].
    pub fn checker(&self, situation: &Situation) -> Result<Checker, CollisionError> {
        let Situation { world, carried, may_touch, q_rest } = situation;
        Checker::for_arm(&self.model, world, carried.as_ref(), may_touch, self.arm_index, q_rest)
    }

    /// Walks every motion of a plan at `density` steps per sample with the exhaustive judge, which shares no code with
    /// the planner's checker, and tells the first collision and its phase.
    ///
    /// # Errors
    /// As [`Workcell::approaching`].
    pub fn rewalk(&self, plan: &Plan, density: usize) -> Result<Option<(PhaseKind, WalkHit)>, CollisionError> {
        for phase in plan.phases.iter().filter(|phase| !phase.kind.is_of_fingers()) {
            let Situation { world, carried, may_touch, q_rest } = self.situation(phase.kind, &plan.legs[phase.leg])?;
            let judge = Exhaustive::new(&self.model, &world, carried.as_ref(), &may_touch)?;
            if let Some(hit) = walk(&judge, &plan.dofs, &q_rest, &phase.trajectory, density) {
                return Ok(Some((phase.kind, hit)));
            }
        }
        Ok(None)
    }

    /// Names of everything that the object rests on, or nearly so, when it stands at `X_WO`.
    pub fn supports(&self, X_WO: &Isometry3<f64>) -> Vec<String> {
        let near_piece = |piece_O| self.world.near_hull(piece_O, X_WO, REST_DEPTH_M);
        let mut names: Vec<String> = Vec::new();
        for (name, _) in self.target_O.iter().flat_map(near_piece) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}
