//! A hand alone, placed somewhere without its arm: which grasp candidates are hopeless before any inverse kinematics.

use nalgebra::{Isometry3, Vector3};

use super::build::squared_distance_to_box;
use super::checker::{CONTACT_M, Clearance, Hit};
use super::frames::Rigid;
use super::model::{CollisionError, CollisionModel};
use super::narrow::{Proximity, proximity, signed_distance};
use super::setup::{MayTouch, Party};
use super::solid::Solid;
use super::world::World;

/// Checks one hand in one finger posture against a world, for many hand poses.
#[derive(Clone, Debug)]
pub struct HandChecker {
    /// Name of the link and its body in the hand frame H, palm first.
    parts: Vec<(usize, Solid)>,
    link_names: Vec<String>,
    obstacles: Vec<Target>,
}

#[derive(Clone, Debug)]
struct Target {
    name: String,
    solid: Solid,
    lower: Vector3<f64>,
    upper: Vector3<f64>,
    /// Links that may touch it, with the depth.
    intended: Vec<(usize, f64)>,
}

impl HandChecker {
    /// * `arm`: index into [`crate::robot::Robot::arms`].
    /// * `finger_positions`: one value per entry of [`crate::robot::Hand::fingers`] flattened, rad or m.
    ///
    /// # Errors
    /// [`CollisionError`] if there is no such arm or the number of finger positions is wrong.
    pub fn new(
        model: &CollisionModel,
        world: &World,
        may_touch: &[MayTouch],
        arm: usize,
        finger_positions: &[f64],
    ) -> Result<Self, CollisionError> {
        let robot = &*model.robot;
        let hand = &robot.arms.get(arm).ok_or(CollisionError::NoSuchArm { found: arm, arms: robot.arms.len() })?.hand;
        let wanted = hand.fingers.iter().map(Vec::len).sum();
        if finger_positions.len() != wanted {
            return Err(CollisionError::WrongLength { found: finger_positions.len(), wanted });
        }
        let mut q = vec![0.0; robot.dof_joints.len()];
        for (&dof, &position) in hand.fingers.iter().flatten().zip(finger_positions) {
            if let Some(slot) = q.get_mut(dof) {
                *slot = position;
            }
        }
        let X_WL = robot.link_poses(&q);
        let X_HW = X_WL[hand.tcp_link].inverse();
        let bodies = |&link: &usize| {
            let X_HL = X_HW * X_WL[link];
            model.solids_L[link].iter().map(move |solid| (link, solid.carried_by(&X_HL))).collect::<Vec<_>>()
        };
        let obstacles = world.obstacles.iter().map(|obstacle| {
            let (lower, upper) = (obstacle.lower, obstacle.upper);
            let intended = may_touch
                .iter()
                .filter_map(|contact| match (&contact.a, &contact.b) {
                    (Party::Link(link), Party::Obstacle(name)) | (Party::Obstacle(name), Party::Link(link)) => {
                        (*name == obstacle.name).then_some((*link, contact.depth_m))
                    }
                    _ => None,
                })
                .collect();
            Target { name: obstacle.name.clone(), solid: obstacle.solid_W.clone(), lower, upper, intended }
        });
        Ok(Self {
            parts: hand.links.iter().flat_map(bodies).collect(),
            link_names: robot.links.iter().map(|link| link.name.clone()).collect(),
            obstacles: obstacles.collect(),
        })
    }

    /// The first link of the hand, palm first, that touches an obstacle with the hand frame H at `X_WH`.
    pub fn first_hit(&self, X_WH: &Isometry3<f64>) -> Option<Hit> {
        let X = Rigid::from_isometry(X_WH);
        let world = Rigid::identity();
        for (link, solid) in &self.parts {
            let center = X.point(&solid.center);
            for target in &self.obstacles {
                let Some(depth_m) = target.depth_m(*link) else { continue };
                let reach = solid.bound + CONTACT_M;
                // Written so that a pose that is not finite touches nothing instead of reaching GJK.
                let close = squared_distance_to_box(&center, &target.lower, &target.upper) <= reach * reach;
                let gap = CONTACT_M - depth_m;
                if close && proximity(solid, &X, &target.solid, &world, gap, gap) == Proximity::Touching {
                    return Some(Hit { a: self.link_names[*link].clone(), b: target.name.clone() });
                }
            }
        }
        None
    }

    /// The first link of this hand, palm first, that touches a link of another hand; both hand frames in one frame, which
    /// may be that of an object that both hold.
    pub fn first_hit_with(&self, X_WH: &Isometry3<f64>, other: &Self, X_WH_other: &Isometry3<f64>) -> Option<Hit> {
        let (X, X_other) = (Rigid::from_isometry(X_WH), Rigid::from_isometry(X_WH_other));
        let others: Vec<(&(usize, Solid), Vector3<f64>)> =
            other.parts.iter().map(|part| (part, X_other.point(&part.1.center))).collect();
        for (link, solid) in &self.parts {
            let center = X.point(&solid.center);
            for ((other_link, other_solid), other_center) in &others {
                let reach = solid.bound + other_solid.bound + CONTACT_M;
                let close = (center - other_center).norm_squared() <= reach * reach;
                if close && proximity(solid, &X, other_solid, &X_other, CONTACT_M, CONTACT_M) == Proximity::Touching {
                    return Some(Hit { a: self.link_names[*link].clone(), b: other.link_names[*other_link].clone() });
                }
            }
        }
        None
    }

    /// The smallest distance between the hand and the world with the hand frame H at `X_WH`; intended contacts are
    /// left out.
    pub fn distance(&self, X_WH: &Isometry3<f64>) -> Clearance {
        let X = Rigid::from_isometry(X_WH);
        let world = Rigid::identity();
        let mut best = Clearance { distance_m: f64::INFINITY, a: String::new(), b: String::new() };
        for (link, solid) in &self.parts {
            let center = X.point(&solid.center);
            for target in &self.obstacles {
                let reach = solid.bound + best.distance_m;
                let close =
                    reach >= 0.0 && squared_distance_to_box(&center, &target.lower, &target.upper) <= reach * reach;
                if target.depth_m(*link) != Some(0.0) || !close {
                    continue;
                }
                let distance_m = signed_distance(solid, &X, &target.solid, &world);
                if distance_m < best.distance_m {
                    best = Clearance { distance_m, a: self.link_names[*link].clone(), b: target.name.clone() };
                }
            }
        }
        best
    }
}

impl Target {
    /// Depth to which a link may touch it, metres; `None` if the pair is not looked at.
    fn depth_m(&self, link: usize) -> Option<f64> {
        let depths = self.intended.iter().filter(|(named, _)| *named == link).map(|(_, depth_m)| depth_m.max(0.0));
        let depth_m = depths.fold(0.0, f64::max);
        (depth_m < f64::INFINITY).then_some(depth_m)
    }
}
