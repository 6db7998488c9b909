//! The independent judge: every body against every body, with parry's own shapes, forward kinematics and no margin.

use nalgebra::Isometry3;

use super::checker::Hit;
use super::model::{CollisionError, CollisionModel};
use super::parry::ForeignBody;
use super::setup::{CarriedObject, MayTouch, Party};
use super::solid::{Core, Solid};
use super::world::World;
use crate::robot::Robot;

/// A slow checker that shares neither the kinematics nor the geometry of [`super::Checker`].
pub struct Exhaustive {
    robot: std::sync::Arc<Robot>,
    model: CollisionModel,
    bodies: Vec<Judged>,
    may_touch: Vec<MayTouch>,
    touching: Vec<usize>,
}

struct Judged {
    party: Party,
    name: String,
    /// Link that carries it; `None` stands still in the world.
    link: Option<usize>,
    body: ForeignBody,
}

impl Exhaustive {
    /// Takes the same description as [`super::Checker::whole`].
    ///
    /// # Errors
    /// [`CollisionError::NoVolume`] if parry cannot make a shape.
    pub fn new(
        model: &CollisionModel,
        world: &World,
        carried: Option<&CarriedObject>,
        may_touch: &[MayTouch],
    ) -> Result<Self, CollisionError> {
        let mut bodies = Vec::new();
        for (link, solids) in model.solids_L.iter().enumerate() {
            for solid in solids {
                let name = &model.robot.links[link].name;
                bodies.push(judged(Party::Link(link), name, Some(link), solid)?);
            }
        }
        if let Some(carried) = carried {
            for solid_H in &carried.solids_H {
                bodies.push(judged(Party::Carried, &carried.name, Some(carried.tcp_link), solid_H)?);
            }
        }
        for obstacle in &world.obstacles {
            bodies.push(judged(Party::Obstacle(obstacle.name.clone()), &obstacle.name, None, &obstacle.solid_W)?);
        }
        Ok(Self {
            robot: model.robot.clone(),
            model: model.clone(),
            bodies,
            may_touch: may_touch.to_vec(),
            touching: carried.map(|carried| carried.touching.clone()).unwrap_or_default(),
        })
    }

    /// The first touching pair at a full configuration of the robot.
    pub fn first_hit(&self, q: &[f64]) -> Option<Hit> {
        self.search(q, false)
    }

    /// As [`Exhaustive::first_hit`], passing over pairs whose enclosing balls are apart.
    pub fn first_hit_with_balls(&self, q: &[f64]) -> Option<Hit> {
        self.search(q, true)
    }

    /// Signed distance of the closest pair that is looked at, metres.
    pub fn distance_m(&self, q: &[f64]) -> f64 {
        let X_WL = self.robot.link_poses(q);
        let mut best = f64::INFINITY;
        for (index, a) in self.bodies.iter().enumerate() {
            for b in &self.bodies[..index] {
                if self.depth_m(a, b) == Some(0.0) {
                    best = best.min(a.body.distance(&pose(a, &X_WL), &b.body, &pose(b, &X_WL)));
                }
            }
        }
        best
    }

    fn search(&self, q: &[f64], balls: bool) -> Option<Hit> {
        if q.len() != self.robot.dof_joints.len() || !q.iter().all(|x| x.is_finite()) {
            return Some(Hit { a: "joint positions".to_owned(), b: "not a configuration".to_owned() });
        }
        let X_WL = self.robot.link_poses(q);
        let around: Vec<_> =
            if balls { self.bodies.iter().map(|b| b.body.ball(&pose(b, &X_WL))).collect() } else { Vec::new() };
        for (i, a) in self.bodies.iter().enumerate() {
            for (j, b) in self.bodies[..i].iter().enumerate() {
                if let (Some((p, r)), Some((q, s))) = (around.get(i), around.get(j))
                    && (p - q).norm() > r + s
                {
                    continue;
                }
                let Some(depth_m) = self.depth_m(a, b) else { continue };
                let (X_WA, X_WB) = (pose(a, &X_WL), pose(b, &X_WL));
                let touching = if depth_m > 0.0 {
                    a.body.distance(&X_WA, &b.body, &X_WB) < -depth_m
                } else {
                    a.body.meets(&X_WA, &b.body, &X_WB)
                };
                if touching {
                    return Some(Hit { a: a.name.clone(), b: b.name.clone() });
                }
            }
        }
        None
    }

    /// Depth to which two bodies may touch, metres; `None` if they are not looked at.
    fn depth_m(&self, a: &Judged, b: &Judged) -> Option<f64> {
        let skipped = match (&a.party, &b.party) {
            (Party::Link(a), Party::Link(b)) => !self.model.looked_at(*a, *b),
            (Party::Carried, Party::Link(link)) | (Party::Link(link), Party::Carried) => self.touching.contains(link),
            (Party::Obstacle(_), Party::Obstacle(_)) | (Party::Carried, Party::Carried) => true,
            _ => false,
        };
        let depth_m = self
            .may_touch
            .iter()
            .filter(|m| (m.a == a.party && m.b == b.party) || (m.a == b.party && m.b == a.party))
            .map(|m| m.depth_m.max(0.0))
            .fold(0.0, f64::max);
        (!skipped && depth_m < f64::INFINITY).then_some(depth_m)
    }
}

fn pose(body: &Judged, X_WL: &[Isometry3<f64>]) -> Isometry3<f64> {
    body.link.and_then(|link| X_WL.get(link).copied()).unwrap_or_else(Isometry3::identity)
}

fn judged(party: Party, name: &str, link: Option<usize>, solid: &Solid) -> Result<Judged, CollisionError> {
    let X_FB = Isometry3::from_parts(
        solid.X_FB.t.into(),
        nalgebra::UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(solid.X_FB.R)),
    );
    let points = match &solid.core {
        Core::Hull(hull) => hull.corners().len(),
        _ => 0,
    };
    let body = ForeignBody::new(&solid.core, solid.radius, &X_FB)
        .ok_or_else(|| CollisionError::NoVolume { thing: name.to_owned(), points })?;
    Ok(Judged { party, name: name.to_owned(), link, body })
}
