//! Two robots as one: the giver of a handover and, beside it, the receiver.

use nalgebra::{Isometry3, Unit, Vector3};

use super::{Arm, Hand, Joint, JointKind, JointLimit, Link, Mimic, Robot};

impl Robot {
    /// This robot A with another robot R standing beside it, as one robot.
    ///
    /// Links, joints, arms and hands of the other bear the prefix before their names (`hubo_left`), its root hangs on
    /// this robot's root by a fixed joint. Whatever has an order has this robot's own first, then the other's in its own
    /// order: a `q` of both is a `q` of this robot followed by one of the other. Postures are this robot's, the other
    /// standing at `q_other` in all of them. What each may touch of itself is as before; the two may not touch each
    /// other, except where both are welded to their roots and so to each other.
    ///
    /// Meshes are shared and nothing is computed anew, so a receiver that is dragged around costs microseconds.
    ///
    /// * `q_other`: where the other stands, one value per degree of freedom of its own, radians or metres.
    /// * `prefix`: tells the names apart; no name of this robot may begin with it and an underscore.
    /// * `X_AR`: root of the other robot in the root of this one.
    pub fn beside(&self, other: &Self, q_other: &[f64], prefix: &str, X_AR: &Isometry3<f64>) -> Self {
        let shift = Shift { prefix, links: self.links.len(), dofs: self.dof_count() };
        let mount = Joint {
            name: format!("{prefix}_mount"),
            kind: JointKind::Fixed,
            parent: 0,
            child: shift.links,
            X_PJ: *X_AR,
            axis: Unit::new_unchecked(Vector3::z()),
            limit: JointLimit { lower: 0.0, upper: 0.0, velocity: 1.0, acceleration: 1.0, jerk: 1.0 },
            mimic: None,
            dof: None,
        };
        // Joint i moves link i + 1 in each of them, so the mount takes the place between.
        let joints =
            self.joints.iter().cloned().chain([mount]).chain(other.joints.iter().map(|joint| shift.joint(joint)));
        let dof_joints = other.dof_joints.iter().map(|joint| joint + shift.links);
        let allowed = other.allowed_collisions.iter().map(|&(a, b)| (a + shift.links, b + shift.links));
        let posture = |(name, q): &(String, Vec<f64>)| (name.clone(), [q.as_slice(), q_other].concat());
        Self {
            name: self.name.clone(),
            links: self.links.iter().cloned().chain(other.links.iter().map(|link| shift.link(link))).collect(),
            joints: joints.collect(),
            dof_joints: self.dof_joints.iter().copied().chain(dof_joints).collect(),
            arms: self.arms.iter().cloned().chain(other.arms.iter().map(|arm| shift.arm(arm))).collect(),
            postures: self.postures.iter().map(posture).collect(),
            allowed_collisions: self.allowed_collisions.iter().copied().chain(allowed).collect(),
        }
    }
}

/// By what names and indices of the other robot change.
struct Shift<'a> {
    prefix: &'a str,
    links: usize,
    dofs: usize,
}

impl Shift<'_> {
    fn name(&self, name: &str) -> String {
        format!("{}_{name}", self.prefix)
    }

    fn dofs(&self, dofs: &[usize]) -> Vec<usize> {
        dofs.iter().map(|dof| dof + self.dofs).collect()
    }

    fn link(&self, link: &Link) -> Link {
        Link { name: self.name(&link.name), ..link.clone() }
    }

    fn joint(&self, joint: &Joint) -> Joint {
        Joint {
            name: self.name(&joint.name),
            parent: joint.parent + self.links,
            child: joint.child + self.links,
            mimic: joint.mimic.map(|mimic| Mimic { dof: mimic.dof + self.dofs, ..mimic }),
            dof: joint.dof.map(|dof| dof + self.dofs),
            ..joint.clone()
        }
    }

    fn arm(&self, arm: &Arm) -> Arm {
        let hand = &arm.hand;
        Arm {
            name: self.name(&arm.name),
            dofs: self.dofs(&arm.dofs),
            base_link: arm.base_link + self.links,
            flange_link: arm.flange_link + self.links,
            hand: Hand {
                name: self.name(&hand.name),
                links: hand.links.iter().map(|link| link + self.links).collect(),
                palm_link: hand.palm_link + self.links,
                tcp_link: hand.tcp_link + self.links,
                fingers: hand.fingers.iter().map(|finger| self.dofs(finger)).collect(),
                open: hand.open.clone(),
                closed: hand.closed.clone(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Translation3;

    use super::*;
    use crate::collision::testing::random_q;
    use crate::collision::{CollisionModel, Exhaustive, World};
    use crate::rng::Rng;
    use crate::robot::ik::ArmIk;
    use crate::robot::samples;

    fn placed(x: f64, y: f64, yaw: f64) -> Isometry3<f64> {
        Isometry3::new(Vector3::new(x, y, 0.0), Vector3::z() * yaw)
    }

    #[test]
    fn both_robots_stand_in_the_merged_one_as_they_stand_alone() {
        let mut rng = Rng::new(1, 0);
        for (giver, receiver) in [
            (samples::crichton(), samples::hubo()),
            (samples::alita(), samples::human()),
            (samples::alita(), samples::alita()),
        ] {
            let X_AR = placed(1.3, -0.4, 2.6) * Translation3::new(0.0, 0.0, -0.34);
            let both = giver.beside(&receiver, &vec![0.0; receiver.dof_count()], "receiver", &X_AR);
            assert_eq!(both.dof_count(), giver.dof_count() + receiver.dof_count());
            for (index, joint) in both.joints.iter().enumerate() {
                assert!(joint.child == index + 1 && joint.parent <= index, "{}", joint.name);
            }
            assert!(both.dof_joints.iter().enumerate().all(|(dof, &joint)| both.joints[joint].dof == Some(dof)));
            assert!(both.allowed_collisions.is_sorted());
            for _ in 0..20 {
                let (q_A, q_R) = (random_q(&giver, &mut rng), random_q(&receiver, &mut rng));
                let X_AL = both.link_poses(&[q_A.as_slice(), &q_R].concat());
                let alone = giver.link_poses(&q_A);
                let beside = receiver.link_poses(&q_R).into_iter().map(|X_RL| X_AR * X_RL);
                for (found, wanted) in X_AL.iter().zip(alone.into_iter().chain(beside)) {
                    assert!((found.to_homogeneous() - wanted.to_homogeneous()).amax() < 1e-12);
                }
            }
            for arm in &receiver.arms {
                let same = both.arm(&format!("receiver_{}", arm.name)).unwrap();
                assert_eq!(both.links[same.hand.tcp_link].name, format!("receiver_{}_tcp", arm.name));
                let method =
                    |robot: &Robot, arm: &Arm| std::mem::discriminant(&ArmIk::of(robot, arm).unwrap().method());
                assert_eq!(method(&both, same), method(&receiver, arm));
            }
        }
    }

    #[test]
    fn what_each_touches_of_itself_is_as_before_and_what_the_two_touch_is_found_by_name() {
        let (giver, receiver) = (samples::alita(), samples::human());
        let judge = |robot: &Robot| {
            let model = CollisionModel::new(robot).unwrap();
            Exhaustive::new(&model, &World::new(), None, &[]).unwrap()
        };
        let q_R = receiver.posture("standing").unwrap();
        let far = giver.beside(&receiver, q_R, "human", &placed(5.0, 0.0, 3.1));
        let (one, other, both) = (judge(&giver), judge(&receiver), judge(&far));
        let mut rng = Rng::new(2, 0);
        let mut hits = 0;
        for _ in 0..400 {
            let (q_A, q_R) = (random_q(&giver, &mut rng), random_q(&receiver, &mut rng));
            let alone = one.first_hit(&q_A).is_some() || other.first_hit(&q_R).is_some();
            assert_eq!(both.first_hit(&[q_A, q_R].concat()).is_some(), alone);
            hits += usize::from(alone);
        }
        assert!(hits > 20 && hits < 380, "{hits} of 400");

        // The left hand stretched sideways reaches 1.4 m: a person stands there.
        let near = giver.beside(&receiver, q_R, "human", &placed(0.0, 1.0, 0.0));
        let hit = judge(&near).first_hit(near.posture("zero").unwrap()).unwrap();
        assert!(hit.to_string().contains("human_"), "{hit}");
        assert!(judge(&far).first_hit(far.posture("home").unwrap()).is_none());
    }
}
