//! Everything that ranking and planning share: robot, arm, obstacles, and the object at its start and goal.

use std::sync::Arc;

use nalgebra::Isometry3;

use super::{Leg, Phase, PhaseKind, Plan};
use crate::collision::{
    CarriedObject, Checker, CollisionError, CollisionModel, ConvexHull, Exhaustive, MayTouch, Party, World,
};
use crate::grasp::{Grasp, HandModel};
use crate::plan::{WalkHit, walk};
use crate::robot::ik::ArmIk;
use crate::robot::{Arm, ChainError, Robot, StartError};
use crate::scene::Action;

/// What reasons call the object that is grasped.
pub const TARGET: &str = "object";
/// Open fingers may dip this far into the hull of the target, metres: the error of a good fit.
const OPEN_FINGER_DEPTH_M: f64 = 0.002;
/// How far the object may sink into what it stands on, metres: a fit's bottom is known to about a centimetre.
const REST_DEPTH_M: f64 = 0.012;

/// One arm of a robot in front of a scene, with one object to handle.
#[derive(Clone)]
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
    /// Places that O goes to, one after the other.
    pub stops: Vec<Stop>,
    /// Contacts that are intended besides those of the acting hand: of another hand that holds the object.
    pub may_touch: Vec<MayTouch>,
}

/// A place that the object goes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// What happens there.
    pub action: Action,
    /// Poses of O in the world that will do, the wanted one first.
    pub poses_WO: Vec<Isometry3<f64>>,
    /// On the way there, the axis that was upright at the start stays within this of the vertical, rad.
    pub keep_upright_rad: Option<f64>,
}

impl Stop {
    /// The object is put down, nowhere yet.
    pub fn put() -> Self {
        Self { action: Action::Put, poses_WO: Vec::new(), keep_upright_rad: None }
    }

    /// Whether the object is let go here, which ends a leg.
    pub fn lets_go(&self) -> bool {
        matches!(self.action, Action::Put | Action::Slide)
    }
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
    /// The robot cannot start as the scene says.
    #[error(transparent)]
    Start(#[from] StartError),
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

    /// The places up to the first at which the object is let go: what one grasp has to serve.
    pub fn leg(&self) -> &[Stop] {
        let count = self.stops.iter().position(Stop::lets_go).map_or(self.stops.len(), |index| index + 1);
        &self.stops[..count]
    }

    /// The wanted pose at the last stop.
    pub fn X_WO_goal(&self) -> Option<Isometry3<f64>> {
        self.stops.last().and_then(|stop| stop.poses_WO.first()).copied()
    }

    /// The same robot and obstacles for an object that stands elsewhere, the arm being where `q_start` says.
    pub fn later(&self, X_WO_start: Isometry3<f64>, stops: &[Stop], q_start: Vec<f64>) -> Self {
        Self { X_WO_start, stops: stops.to_vec(), q_start, ..self.clone() }
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
        let may_touch = links.iter().map(contact).chain(self.may_touch.iter().cloned()).collect();
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
            may_touch: resting
                .iter()
                .map(|name| MayTouch::carried(name, REST_DEPTH_M))
                .chain(self.may_touch.iter().cloned())
                .collect(),
            q_rest: self.q_with_fingers(&grasp.closed),
        })
    }

    /// What surrounds the arm in a phase of a leg.
    ///
    /// # Errors
    /// As [`Workcell::approaching`].
    pub fn situation(&self, kind: PhaseKind, leg: &Leg) -> Result<Situation, CollisionError> {
        let Leg { grasp, X_WO_start, X_WO_end, .. } = leg;
        match kind {
            PhaseKind::Reach => self.approaching(X_WO_start),
            PhaseKind::Close => self.grasping(X_WO_start, &grasp.closed),
            PhaseKind::Lift => self.carrying(grasp, &self.supports(X_WO_start)),
            PhaseKind::Transport | PhaseKind::Pour => self.carrying(grasp, &[]),
            PhaseKind::Slide => self.carrying(grasp, &self.all_supports(&[*X_WO_start, *X_WO_end])),
            PhaseKind::Place => self.carrying(grasp, &self.supports(X_WO_end)),
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
            if let Some(hit) = self.rewalk_phase(plan, phase, density)? {
                return Ok(Some((phase.kind, hit)));
            }
        }
        Ok(None)
    }

    /// As [`Workcell::rewalk`], one phase of the plan.
    ///
    /// # Errors
    /// As [`Workcell::approaching`].
    pub fn rewalk_phase(&self, plan: &Plan, phase: &Phase, density: usize) -> Result<Option<WalkHit>, CollisionError> {
        let Situation { world, carried, may_touch, q_rest } = self.situation(phase.kind, &plan.legs[phase.leg])?;
        let judge = Exhaustive::new(&self.model, &world, carried.as_ref(), &may_touch)?;
        Ok(walk(&judge, &plan.dofs, &q_rest, &phase.trajectory, density))
    }

    /// As [`Workcell::supports`], of several poses together.
    pub fn all_supports(&self, poses_WO: &[Isometry3<f64>]) -> Vec<String> {
        let mut names: Vec<String> = poses_WO.iter().flat_map(|X_WO| self.supports(X_WO)).collect();
        names.sort();
        names.dedup();
        names
    }

    /// What the object itself would be inside of at a pose, by more than a rest on it explains: its name and how deep,
    /// metres.
    pub fn object_hits(&self, X_WO: &Isometry3<f64>) -> Option<(String, f64)> {
        let near = self.target_O.iter().flat_map(|piece_O| self.world.near_hull(piece_O, X_WO, -REST_DEPTH_M));
        near.map(|(name, distance_m)| (name, -distance_m)).max_by(|l, r| l.1.total_cmp(&r.1))
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
