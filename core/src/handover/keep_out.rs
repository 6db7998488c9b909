//! The space about a person's head and body that a giver's arm stays out of.

use std::collections::BTreeSet;

use crate::robot::{CollisionBody, Geometry, Joint, JointKind, Link, Robot};

/// How the names of keep-outs end.
pub const KEEP_OUT: &str = "_keep_out";

/// Links that get a keep-out, and how far it goes beyond their bodies, metres.
const MARGINS: [(&str, f64); 3] = [("head", 0.15), ("torso", 0.05), ("pelvis", 0.05)];

/// A space that moves with a link.
#[derive(Clone, Debug)]
pub struct KeepOut {
    /// `head_keep_out`.
    pub name: String,
    /// Link that it surrounds.
    pub link: usize,
    /// How far it goes beyond the link's bodies, metres.
    pub margin_m: f64,
    /// Bodies in the link's frame: those of the link, grown by the margin.
    pub bodies: Vec<CollisionBody>,
}

/// The spaces about head, torso and pelvis of a receiver, as far as it has links of these names.
pub fn keep_out(receiver: &Robot) -> Vec<KeepOut> {
    let around = |&(name, margin_m): &(&str, f64)| {
        let link = receiver.link_index(name)?;
        let bodies = receiver.links[link].collisions.iter().map(|body| grown(body, margin_m)).collect();
        Some(KeepOut { name: format!("{name}{KEEP_OUT}"), link, margin_m, bodies })
    };
    MARGINS.iter().filter_map(around).collect()
}

/// The receiver with its keep-outs as links that collide with whatever is not its own, so that a planner sees them and
/// names them. They are not drawn, and the receiver itself may be in them.
pub fn guarded(receiver: &Robot) -> Robot {
    let mut robot = receiver.clone();
    let own = robot.links.len();
    for keep_out in keep_out(receiver) {
        let link = robot.links.len();
        let X_LK = nalgebra::Isometry3::identity();
        robot.joints.push(Joint {
            name: format!("{}_joint", keep_out.name),
            kind: JointKind::Fixed,
            parent: keep_out.link,
            child: link,
            X_PJ: X_LK,
            mimic: None,
            dof: None,
            // A fixed joint uses neither axis nor limits: those of any other will do.
            ..robot.joints[keep_out.link.max(1) - 1].clone()
        });
        robot.links.push(Link { name: keep_out.name, visuals: Vec::new(), collisions: keep_out.bodies });
    }
    let among_themselves = (own..robot.links.len()).flat_map(|link| (0..link).map(move |other| (other, link)));
    let allowed: BTreeSet<_> = robot.allowed_collisions.iter().copied().chain(among_themselves).collect();
    robot.allowed_collisions = allowed.into_iter().collect();
    robot
}

/// A body whose surface is everywhere at least a margin farther out; exactly that for balls and capsules.
fn grown(body: &CollisionBody, margin_m: f64) -> CollisionBody {
    let geometry = match &body.geometry {
        Geometry::Sphere { radius_m } => Geometry::Sphere { radius_m: radius_m + margin_m },
        Geometry::Capsule { radius_m, length_m } => {
            Geometry::Capsule { radius_m: radius_m + margin_m, length_m: *length_m }
        }
        Geometry::Cylinder { radius_m, length_m } => {
            Geometry::Cylinder { radius_m: radius_m + margin_m, length_m: length_m + 2.0 * margin_m }
        }
        Geometry::Box { size_m } => Geometry::Box { size_m: size_m.add_scalar(2.0 * margin_m) },
        Geometry::Mesh { mesh, .. } => {
            let farthest = mesh.positions.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
            Geometry::Sphere { radius_m: farthest + margin_m }
        }
    };
    CollisionBody { geometry, X_LC: body.X_LC }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Vector3};

    use super::*;
    use crate::collision::{CollisionModel, Exhaustive, World};
    use crate::robot::samples;

    fn hit(robot: &Robot, q: &[f64]) -> Option<String> {
        let model = CollisionModel::new(robot).unwrap();
        let judge = Exhaustive::new(&model, &World::new(), None, &[]).unwrap();
        judge.first_hit(q).map(|hit| hit.to_string())
    }

    #[test]
    fn a_person_is_free_in_every_posture_with_the_space_about_it() {
        let person = guarded(&samples::human());
        assert_eq!(person.links.len(), samples::human().links.len() + 3);
        for (name, q) in person.postures.iter().filter(|(name, _)| name != "zero") {
            assert_eq!(hit(&person, q), None, "{name}");
        }
    }

    #[test]
    fn a_giver_that_comes_near_the_head_is_told_so_and_elsewhere_only_what_it_touches() {
        let giver = samples::alita();
        let (person, safe) = (samples::human(), guarded(&samples::human()));
        let q = person.posture("standing").unwrap();
        let beside = |receiver: &Robot, z: f64| {
            let X_AR = Isometry3::translation(0.0, 1.34, z) * Isometry3::rotation(Vector3::z() * 1.6);
            let both = giver.beside(receiver, q, "human", &X_AR);
            hit(&both, both.posture("zero").unwrap())
        };
        // The arm is straight out sideways 1.23 m above the floor; the crown of the head is 0.09 m below that.
        assert_eq!(beside(&person, -0.62), None);
        let found = beside(&safe, -0.62).unwrap();
        assert!(found.contains("human_head_keep_out"), "{found}");
        assert_eq!(beside(&safe, -2.5), None);
    }
}
