//! A robot with another hand: the old one's links and joints go, the new one's come in their place.

use std::collections::BTreeSet;

use super::hand_description::ReadHand;
use super::{Hand, HandDescription, HandError, Joint, Resolve, Robot};
use crate::collision::AllowedCollisions;
use crate::loaded::Loaded;

impl Robot {
    /// The robot with a described hand at the flange of one arm instead of its own.
    ///
    /// Links and joints of the new hand are named with the arm's name before their own: `left_palm`. They stand where
    /// the old palm stood in the order of the links, and their degrees of freedom likewise in `q`. What hangs on the
    /// flange beside the old hand (a force sensor) stays. All postures get the new hand open. Which links
    /// may touch is computed anew ([`AllowedCollisions`]).
    ///
    /// * `arm`: name of the arm.
    /// * `resolve`: gives the meshes that the hand's URDF names; one that is missing becomes a note.
    ///
    /// # Errors
    /// [`HandError`] when the description is wrong, the robot lacks the arm or has a name of the hand's already, or a
    /// finger has no collision body.
    pub fn with_hand(
        &self,
        arm: &str,
        hand: &HandDescription,
        resolve: &Resolve<'_>,
    ) -> Result<Loaded<Self>, HandError> {
        let Loaded { value: new, mut notes } = hand.read(resolve)?;
        if let Some(finger) = new.fingers.iter().position(|finger| !finger.iter().any(|&dof| moves_a_body(&new, dof))) {
            return Err(HandError::NoBody { place: format!("fingers[{finger}]") });
        }
        let arm_index = self
            .arms
            .iter()
            .position(|known| known.name == arm)
            .ok_or_else(|| HandError::NoArm { robot: self.name.clone(), arm: arm.to_owned() })?;
        let X_EM = hand.mount.isometry();
        let robot = Exchange::new(self, arm_index, &new).robot(&X_EM, &mut notes)?;
        Ok(Loaded { value: robot, notes })
    }
}

/// Whether a degree of freedom, or a mimic of it, moves a link that has a collision body.
fn moves_a_body(hand: &ReadHand, dof: usize) -> bool {
    let tree = &hand.tree;
    let is_moved = |joint: &&Joint| joint.dof == Some(dof) || joint.mimic.is_some_and(|mimic| mimic.dof == dof);
    let has_body = |top: usize| {
        (top..tree.links.len()).any(|link| tree.chain(top, link).is_some() && !tree.links[link].collisions.is_empty())
    };
    tree.joints.iter().filter(is_moved).any(|joint| has_body(joint.child))
}

/// Where every link of the robot and of the new hand comes to stand.
struct Exchange<'a> {
    old: &'a Robot,
    new: &'a ReadHand,
    arm_index: usize,
    /// In the order of the links of the robot that comes out.
    order: Vec<Source>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Source {
    /// A link of the robot.
    Old(usize),
    /// A link of the hand.
    New(usize),
}

impl<'a> Exchange<'a> {
    fn new(old: &'a Robot, arm_index: usize, new: &'a ReadHand) -> Self {
        let hand = &old.arms[arm_index].hand;
        let goes = |link: usize| hand.links.contains(&link) || old.chain(hand.palm_link, link).is_some();
        let mut order = Vec::new();
        for link in 0..old.links.len() {
            if link == hand.palm_link {
                order.extend((0..new.tree.links.len()).map(Source::New));
            } else if !goes(link) {
                order.push(Source::Old(link));
            }
        }
        Self { old, new, arm_index, order }
    }

    fn at(&self, source: Source) -> Option<usize> {
        self.order.iter().position(|other| *other == source)
    }

    /// Index of a link that stays; the flange stands for one that goes, of which nothing that stays should speak.
    fn kept(&self, link: usize) -> usize {
        let flange = self.old.arms[self.arm_index].flange_link;
        self.at(Source::Old(link)).or_else(|| self.at(Source::Old(flange))).unwrap_or(0)
    }

    /// Index of a link of the hand.
    fn added(&self, link: usize) -> usize {
        self.at(Source::New(link)).unwrap_or(0)
    }

    fn name(&self, own: &str) -> String {
        format!("{}_{own}", self.old.arms[self.arm_index].name)
    }

    fn robot(&self, X_EM: &nalgebra::Isometry3<f64>, notes: &mut Vec<String>) -> Result<Robot, HandError> {
        let (old, new) = (self.old, &self.new.tree);
        let links = self.order.iter().map(|source| match *source {
            Source::Old(link) => old.links[link].clone(),
            Source::New(link) => {
                let mut link = new.links[link].clone();
                link.name = self.name(&link.name);
                link
            }
        });
        let flange = old.arms[self.arm_index].flange_link;
        // Joint i moves link i + 1; the root is the robot's own, since a flange stands above every palm.
        let mut joints: Vec<Joint> = Vec::new();
        for (child, source) in self.order.iter().enumerate().skip(1) {
            joints.push(match *source {
                Source::Old(link) => {
                    let joint = &old.joints[link - 1];
                    Joint { parent: self.kept(joint.parent), child, ..joint.clone() }
                }
                Source::New(0) => Joint {
                    name: self.name("hand_mount"),
                    kind: super::JointKind::Fixed,
                    parent: self.kept(flange),
                    child,
                    X_PJ: *X_EM,
                    mimic: None,
                    dof: None,
                    ..old.joints[old.arms[self.arm_index].hand.palm_link - 1].clone()
                },
                Source::New(link) => {
                    let joint = &new.joints[link - 1];
                    Joint { name: self.name(&joint.name), parent: self.added(joint.parent), child, ..joint.clone() }
                }
            });
        }
        let (dof_joints, of_old, of_new) = self.number_dofs(&mut joints);
        let mut robot = Robot {
            name: old.name.clone(),
            links: links.collect(),
            joints,
            dof_joints,
            arms: Vec::new(),
            postures: Vec::new(),
            allowed_collisions: Vec::new(),
        };
        self.refuse_taken_names(&robot)?;
        self.fill_arms(&mut robot, &of_old, &of_new);
        self.fill_postures(&mut robot, &of_old);
        robot.allowed_collisions = self.allowed_collisions(&robot, notes);
        Ok(robot)
    }

    /// Numbers the degrees of freedom anew in the order of the joints; gives their joints, and for those of the robot
    /// and of the hand the new number of each.
    fn number_dofs(&self, joints: &mut [Joint]) -> (Vec<usize>, Vec<Option<usize>>, Vec<Option<usize>>) {
        let mut of_old = vec![None; self.old.dof_count()];
        let mut of_new = vec![None; self.new.tree.dof_count()];
        let mut dof_joints = Vec::new();
        for (index, joint) in joints.iter_mut().enumerate() {
            let Some(dof) = joint.dof else { continue };
            let known = if matches!(self.order[index + 1], Source::Old(_)) { &mut of_old } else { &mut of_new };
            known[dof] = Some(dof_joints.len());
            joint.dof = Some(dof_joints.len());
            dof_joints.push(index);
        }
        for (index, joint) in joints.iter_mut().enumerate() {
            let known = if matches!(self.order[index + 1], Source::Old(_)) { &of_old } else { &of_new };
            joint.mimic = joint.mimic.and_then(|mimic| Some(super::Mimic { dof: known[mimic.dof]?, ..mimic }));
        }
        (dof_joints, of_old, of_new)
    }

    fn refuse_taken_names(&self, robot: &Robot) -> Result<(), HandError> {
        let links = robot.links.iter().map(|link| ("link", link.name.as_str()));
        let joints = robot.joints.iter().map(|joint| ("joint", joint.name.as_str()));
        let mut seen = BTreeSet::new();
        for (kind, name) in links.chain(joints) {
            if !seen.insert((kind, name)) {
                let name = name.strip_prefix(&self.name("")).unwrap_or(name).to_owned();
                return Err(HandError::NameTaken { robot: robot.name.clone(), kind, name });
            }
        }
        Ok(())
    }

    fn fill_arms(&self, robot: &mut Robot, of_old: &[Option<usize>], of_new: &[Option<usize>]) {
        let renumbered = |dofs: &[usize], known: &[Option<usize>]| dofs.iter().filter_map(|&dof| known[dof]).collect();
        for (index, arm) in self.old.arms.iter().enumerate() {
            let mut arm = arm.clone();
            arm.dofs = renumbered(&arm.dofs, of_old);
            arm.base_link = self.kept(arm.base_link);
            arm.flange_link = self.kept(arm.flange_link);
            let (hand, new) = (&arm.hand, self.new);
            arm.hand = if index == self.arm_index {
                let tree = &new.tree;
                let below_palm = (0..tree.links.len()).filter(|&link| tree.chain(new.palm, link).is_some());
                Hand {
                    name: hand.name.clone(),
                    links: below_palm.map(|link| self.added(link)).collect(),
                    palm_link: self.added(new.palm),
                    tcp_link: self.added(new.tcp),
                    fingers: new.fingers.iter().map(|finger| renumbered(finger, of_new)).collect(),
                    open: new.open.clone(),
                    closed: new.closed.clone(),
                }
            } else {
                Hand {
                    links: hand.links.iter().map(|&link| self.kept(link)).collect(),
                    palm_link: self.kept(hand.palm_link),
                    tcp_link: self.kept(hand.tcp_link),
                    fingers: hand.fingers.iter().map(|finger| renumbered(finger, of_old)).collect(),
                    ..hand.clone()
                }
            };
            robot.arms.push(arm);
        }
    }

    fn fill_postures(&self, robot: &mut Robot, of_old: &[Option<usize>]) {
        let hand = &robot.arms[self.arm_index].hand;
        let open: Vec<(usize, f64)> = hand.fingers.iter().flatten().copied().zip(hand.open.iter().copied()).collect();
        let posture = |(name, q_old): &(String, Vec<f64>)| {
            let mut q = vec![0.0; robot.dof_joints.len()];
            let kept = of_old.iter().zip(q_old).filter_map(|(dof, position)| Some((((*dof)?), *position)));
            kept.chain(open.iter().copied()).for_each(|(dof, position)| q[dof] = position);
            (name.clone(), q)
        };
        robot.postures = self.old.postures.iter().map(posture).collect();
    }

    /// What the robot that comes out shows, and what the old one's SRDF allows of links that stay.
    fn allowed_collisions(&self, robot: &Robot, notes: &mut Vec<String>) -> Vec<(usize, usize)> {
        let kept = |&(a, b): &(usize, usize)| Some((self.at(Source::Old(a))?, self.at(Source::Old(b))?));
        let mut pairs: BTreeSet<(usize, usize)> = self.old.allowed_collisions.iter().filter_map(kept).collect();
        match AllowedCollisions::compute(robot, AllowedCollisions::SEED) {
            Ok(computed) => pairs.extend(computed.pairs.iter().map(|pair| (pair.a, pair.b))),
            Err(error) => notes.push(format!("{error}: of the new hand no pair of links is known that may touch")),
        }
        pairs.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Vector3};

    use super::*;
    use crate::grasp::{GraspSettings, HandModel, Touched, candidates};
    use crate::rng::Rng;
    use crate::robot::samples::{alita, crichton, hand, with_hand};
    use crate::superquadric::Superquadric;

    /// Names of the pairs that may touch and could: both have bodies.
    fn pairs(robot: &Robot) -> Vec<(&str, &str)> {
        let has_body = |link: usize| !robot.links[link].collisions.is_empty();
        let name = |link: usize| robot.links[link].name.as_str();
        let can_touch = robot.allowed_collisions.iter().filter(|(a, b)| has_body(*a) && has_body(*b));
        can_touch.map(|&(a, b)| (name(a), name(b))).collect()
    }

    #[test]
    fn the_built_in_hands_described_are_the_built_in_hands() {
        for (robot, file) in [(alita(), "pg70.json"), (crichton(), "sdh.json")] {
            for (number, arm) in robot.arms.iter().enumerate() {
                let other = with_hand(&robot, &arm.name, &hand(file));
                let names = |robot: &Robot| robot.links.iter().map(|link| link.name.clone()).collect::<Vec<_>>();
                assert_eq!(names(&other), names(&robot));
                assert_eq!(pairs(&other), pairs(&robot));
                assert_eq!(other.dof_joints, robot.dof_joints);
                assert_eq!(format!("{:?}", other.arms), format!("{:?}", robot.arms));
                let rng = &mut Rng::new(3, number as u64);
                for _ in 0..20 {
                    let limits = robot.dof_joints.iter().map(|&joint| robot.joints[joint].limit);
                    let q: Vec<f64> = limits.map(|limit| rng.uniform(limit.lower, limit.upper)).collect();
                    for (X, X_other) in robot.link_poses(&q).iter().zip(other.link_poses(&q)) {
                        assert!((X.to_homogeneous() - X_other.to_homogeneous()).amax() < 1e-12);
                    }
                }
                let can = [Superquadric::new(0.03, 0.03, 0.05, 0.1, 1.0, Isometry3::identity()).unwrap()];
                let settings = GraspSettings { density: 8, ..GraspSettings::default() };
                let grasps = |robot: &Robot| {
                    let hand = HandModel::new(robot, &robot.arms[number]);
                    format!(
                        "{:?}",
                        candidates(&hand, &can, Touched::Bodies, &settings, &Isometry3::identity(), &|_, _| None)
                    )
                };
                assert_eq!(grasps(&other), grasps(&robot), "the same candidates to the last bit");
            }
        }
    }

    #[test]
    fn any_hand_on_any_arm_gives_a_robot_that_hangs_together() {
        for robot in [alita(), crichton()] {
            for file in ["pg70.json", "sdh.json", "adaptive.json"] {
                for arm in ["left", "right"] {
                    let other = with_hand(&robot, arm, &hand(file));
                    assert_eq!(other.joints.len() + 1, other.links.len());
                    for (index, joint) in other.joints.iter().enumerate() {
                        assert!(joint.child == index + 1 && joint.parent <= index, "{}", joint.name);
                        assert!(joint.mimic.is_none_or(|mimic| mimic.dof < other.dof_count()));
                    }
                    for (dof, &joint) in other.dof_joints.iter().enumerate() {
                        assert_eq!(other.joints[joint].dof, Some(dof));
                    }
                    assert!(other.postures.iter().all(|(_, q)| q.len() == other.dof_count()));
                    // What is not the hand stands where it stood, in every posture.
                    for (name, q) in &robot.postures {
                        let (X_WL, X_other) = (robot.link_poses(q), other.link_poses(other.posture(name).unwrap()));
                        let hands: Vec<usize> = robot.arm(arm).unwrap().hand.links.clone();
                        for link in (0..robot.links.len()).filter(|link| !hands.contains(link)) {
                            let at = other.link_index(&robot.links[link].name).unwrap();
                            let moved = (X_WL[link].to_homogeneous() - X_other[at].to_homogeneous()).amax();
                            // The other arm's fingers keep the positions of the posture.
                            assert!(moved < 1e-12, "{name}: {}", robot.links[link].name);
                        }
                    }
                    let hand = &other.arm(arm).unwrap().hand;
                    assert!(hand.links.iter().all(|link| other.links[*link].name.starts_with(arm)));
                }
            }
        }
    }

    #[test]
    fn an_invented_hand_opens_between_its_pads_and_holds_a_can() {
        let robot = with_hand(&alita(), "right", &hand("adaptive.json"));
        let arm = robot.arm("right").unwrap();
        let model = HandModel::new(&robot, arm);
        // The adapter is welded to the flange: part of the arm, not of what grasps.
        assert_eq!(model.links[0].name, "right_palm");
        // Knuckles at 50 mm, 60 mm of inner link leaning out by 0.5 rad, pads by 0.2 rad, 8 mm thick.
        let knuckle_to_pad = 0.05 + 0.06 * crate::math::sin(0.5);
        let opening_m = model.opening_m();
        assert!((opening_m - 2.0 * (knuckle_to_pad - 0.008)).abs() < 0.012, "{opening_m}");
        let X_WL = robot.link_poses(&vec![0.0; robot.dof_count()]);
        let X_EH = X_WL[arm.flange_link].inv_mul(&X_WL[arm.hand.tcp_link]);
        assert!((X_EH.translation.vector - Vector3::new(0.0, 0.0, 0.012 + 0.17)).norm() < 1e-12);
        let can = [Superquadric::new(0.03, 0.03, 0.05, 0.1, 1.0, Isometry3::identity()).unwrap()];
        let found =
            candidates(&model, &can, Touched::Bodies, &GraspSettings::default(), &Isometry3::identity(), &|_, _| None);
        let held = found.iter().filter(|grasp| grasp.is_accepted() && grasp.epsilon > 0.0).count();
        assert!(held > 20, "{held} of {}", found.len());
    }

    #[test]
    fn what_does_not_fit_the_robot_is_refused_by_name() {
        let robot = alita();
        let refused =
            |arm: &str, hand: &HandDescription| robot.with_hand(arm, hand, &|_| None).unwrap_err().to_string();
        assert_eq!(refused("third", &hand("adaptive.json")), "alita has no third arm");
        let mut taken = hand("adaptive.json");
        taken.urdf = taken.urdf.replace("\"adapter\"", "\"arm_7\"");
        assert!(refused("left", &taken).contains("alita has a link \"arm_7\" already"), "{}", refused("left", &taken));
        let mut bare = hand("adaptive.json");
        bare.urdf = bare.urdf.replace("collision>", "inertial>");
        assert_eq!(refused("left", &bare), "fingers[0]: its joints move no link with a collision body");
    }
}
