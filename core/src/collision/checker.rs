//! The checker: bodies sorted into what stands still and what moves, ready for many questions.

use std::sync::Arc;

use nalgebra::Vector3;

use super::frames::{MovingFrame, Rigid};
use super::lanes::Lanes;
use super::model::{CollisionError, CollisionModel};
use super::setup::{CarriedObject, MayTouch};
use super::sieve::Sieve;
use super::solid::Solid;
use super::tree::Tree;
use super::world::World;

/// Two things that touch, by the names of the URDF and of the world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hit {
    /// A link or the carried object.
    pub a: String,
    /// A link, the carried object or an obstacle.
    pub b: String,
}

impl std::fmt::Display for Hit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} meets {}", self.a, self.b)
    }
}

/// The smallest distance and between whom it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Metres; negative is a depth of penetration, infinity means that there is nothing to meet.
    pub distance_m: f64,
    /// A link or the carried object; empty when there is nothing to meet.
    pub a: String,
    /// A link, the carried object or an obstacle; empty when there is nothing to meet.
    pub b: String,
}

/// Who owns a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    Link(usize),
    Obstacle(usize),
    Carried,
}

/// Two owners that meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pair {
    pub(crate) a: Owner,
    pub(crate) b: Owner,
}

/// What a configuration is, given margins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Everything is farther away than its margin.
    Free,
    /// Nothing touches, but something is within its margin.
    Near,
    /// A pair touches.
    Hit(Pair),
}

/// How far each moving frame's bodies may come without being noticed, metres, one value per frame.
pub(crate) type Margins<'a> = Option<(&'a [f64], f64)>;

/// A body that a joint moves.
#[derive(Clone, Debug)]
pub(crate) struct Cluster {
    pub(crate) owner: Owner,
    pub(crate) frame: usize,
    /// Ball around the cluster in its frame.
    pub(crate) center: Vector3<f64>,
    pub(crate) bound: f64,
    /// Bodies in the frame.
    pub(crate) solids: Vec<Solid>,
    /// Fixed things it may meet: index and allowed depth (0 unless intended contact).
    pub(crate) against: Vec<(usize, f64)>,
    /// The same for fixed things that it cannot reach.
    pub(crate) out_of_reach: Vec<(usize, f64)>,
}

/// A body that stands still, in the world.
#[derive(Clone, Debug)]
pub(crate) struct Fixed {
    pub(crate) owner: Owner,
    pub(crate) solid: Solid,
    pub(crate) lower: Vector3<f64>,
    pub(crate) upper: Vector3<f64>,
}

/// Two clusters that move relative to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingPair {
    pub(crate) a: usize,
    pub(crate) b: usize,
    /// Allowed depth, metres.
    pub(crate) depth_m: f64,
    /// Whether `b` hangs on `a`'s frame, so that only the joints between them move one relative to the other.
    pub(crate) b_hangs_on_a: bool,
}

/// A pair whose distance no joint changes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ConstantPair {
    /// Two fixed bodies.
    Fixed(usize, usize),
    /// Two clusters in one frame.
    Welded(usize, usize),
}

/// Answers who touches whom, for the whole robot or for one arm that moves while the rest stands still.
///
/// Everything that does not depend on the moving joints is decided once, when the checker is made. It may be shared
/// between threads; each brings its own [`Scratch`].
#[derive(Clone, Debug)]
pub struct Checker {
    pub(crate) dofs: Vec<usize>,
    pub(crate) frames: Vec<MovingFrame>,
    pub(crate) clusters: Vec<Cluster>,
    pub(crate) fixed: Vec<Fixed>,
    pub(crate) pairs: Vec<MovingPair>,
    pub(crate) constant: Vec<(ConstantPair, f64)>,
    pub(crate) constant_hit: Option<Pair>,
    /// Lever arms: for each frame, per column of `q`, see [`Checker::displacement_m`].
    pub(crate) levers: Vec<Vec<f64>>,
    pub(crate) margin_m: f64,
    pub(crate) link_names: Vec<String>,
    pub(crate) obstacle_names: Vec<String>,
    pub(crate) carried_name: String,
    pub(crate) sieve: Sieve,
    /// Where there are many obstacles.
    pub(crate) tree: Option<Obstacles>,
}

/// The first fixed bodies of a checker, which are the obstacles of its world, in a tree.
#[derive(Clone, Debug)]
pub(crate) struct Obstacles {
    pub(crate) tree: Arc<Tree>,
    pub(crate) count: usize,
}

/// Working memory of a checker's questions; one per thread, reused from call to call.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(crate) X_WF: Vec<Rigid>,
    pub(crate) centers: Vec<Vector3<f64>>,
    pub(crate) intervals: Vec<(f64, f64)>,
    pub(crate) later: Vec<(f64, f64)>,
    pub(crate) q: Vec<f64>,
    pub(crate) margins: Vec<f64>,
    pub(crate) lanes: Lanes,
    pub(crate) flat: Vec<f64>,
    pub(crate) travel: Vec<[f32; 2]>,
}

/// Bodies count as touching when they are closer than this, metres: far above round-off, far below what matters.
pub(crate) const CONTACT_M: f64 = 1e-4;

impl Checker {
    /// A checker of the whole robot; its `q` has one value per degree of freedom.
    ///
    /// # Errors
    /// [`CollisionError`] if the carried object's hand is not one of this robot.
    pub fn whole(
        model: &CollisionModel,
        world: &World,
        carried: Option<&CarriedObject>,
        may_touch: &[MayTouch],
    ) -> Result<Self, CollisionError> {
        let dofs = (0..model.robot.dof_joints.len()).collect();
        let q_rest = vec![0.0; model.robot.dof_joints.len()];
        super::build::build(model, world, carried, may_touch, dofs, &q_rest)
    }

    /// A checker of one arm's motion; its `q` has one value per joint of the arm, all others stay as in `q_rest`.
    ///
    /// * `arm`: index into [`crate::robot::Robot::arms`].
    /// * `q_rest`: one value per degree of freedom of the robot; the arm's own entries are not used.
    ///
    /// # Errors
    /// [`CollisionError`] if there is no such arm or `q_rest` has the wrong length.
    pub fn for_arm(
        model: &CollisionModel,
        world: &World,
        carried: Option<&CarriedObject>,
        may_touch: &[MayTouch],
        arm: usize,
        q_rest: &[f64],
    ) -> Result<Self, CollisionError> {
        let arms = model.robot.arms.len();
        let dofs = model.robot.arms.get(arm).ok_or(CollisionError::NoSuchArm { found: arm, arms })?.dofs.clone();
        super::build::build(model, world, carried, may_touch, dofs, q_rest)
    }

    /// The same checker with another margin: bodies closer than this count as touching. 0.1 mm unless set.
    pub fn with_margin(mut self, margin_m: f64) -> Self {
        self.margin_m = margin_m.max(0.0);
        self.constant_hit = self.find_constant_hit();
        self
    }

    /// Bodies closer than this count as touching, metres.
    pub fn margin_m(&self) -> f64 {
        self.margin_m
    }

    /// Degrees of freedom of the robot that the columns of `q` stand for.
    pub fn dofs(&self) -> &[usize] {
        &self.dofs
    }

    /// Whether nothing touches.
    pub fn is_free(&self, scratch: &mut Scratch, q: &[f64]) -> bool {
        self.first_hit(scratch, q).is_none()
    }

    /// A touching pair, the hand's before the shoulder's; the same `q` always gives the same one.
    ///
    /// A `q` of the wrong length or with a value that is not finite is nowhere: it counts as a hit of
    /// `joint positions` with `not a configuration`.
    pub fn first_hit(&self, scratch: &mut Scratch, q: &[f64]) -> Option<Hit> {
        if !self.is_configuration(q) {
            return Some(Hit { a: "joint positions".to_owned(), b: "not a configuration".to_owned() });
        }
        match self.state(scratch, q, None) {
            State::Hit(pair) => Some(self.name(pair)),
            _ => None,
        }
    }

    /// Whether `q` has the right length and finite values.
    pub(crate) fn is_configuration(&self, q: &[f64]) -> bool {
        q.len() == self.dofs.len() && q.iter().all(|x| x.is_finite())
    }

    /// An upper bound of the distance that any point of a moving body travels along the straight joint motion from
    /// `from` to `to`, metres.
    ///
    /// A point's speed is at most the sum over the joints of |q̇| times its distance to the joint's axis. For each
    /// body and each joint before it the largest such distance over all configurations is bounded once: outwards from
    /// the joint, the offset of the next joint perpendicular to the axis plus the reach of everything beyond it.
    pub fn displacement_m(&self, from: &[f64], to: &[f64]) -> f64 {
        let mut half = Vec::new();
        self.half_travel(from, to, &mut half);
        2.0 * half.into_iter().fold(0.0, f64::max)
    }

    /// Per moving frame, an upper bound of the distance that its bodies travel along half of the straight motion from
    /// `from` to `to`, metres; see [`Checker::displacement_m`].
    pub(crate) fn half_travel(&self, from: &[f64], to: &[f64], travel: &mut Vec<f64>) {
        travel.clear();
        travel.extend(self.levers.iter().map(|levers| {
            0.5 * levers.iter().zip(from.iter().zip(to)).map(|(lever, (a, b))| lever * (b - a).abs()).sum::<f64>()
        }));
    }

    pub(crate) fn name(&self, pair: Pair) -> Hit {
        Hit { a: self.owner_name(pair.a), b: self.owner_name(pair.b) }
    }

    pub(crate) fn owner_name(&self, owner: Owner) -> String {
        match owner {
            Owner::Link(link) => self.link_names[link].clone(),
            Owner::Obstacle(obstacle) => self.obstacle_names[obstacle].clone(),
            Owner::Carried => self.carried_name.clone(),
        }
    }
}
