//! Hubo and the person, who receive what is handed over: lengths, limits, postures and hands.

use nalgebra::{Isometry3, Vector3};

use super::ik::{ArmIk, IkMethod};
use super::{Robot, samples};
use crate::collision::{CollisionModel, Exhaustive, World};
use crate::grasp::{GraspSettings, HandModel, Touched, candidates};
use crate::superquadric::Superquadric;

fn receivers() -> [Robot; 2] {
    [samples::hubo(), samples::human()]
}

fn distance_m(robot: &Robot, posture: &str, a: &str, b: &str) -> f64 {
    let X_BL = robot.link_poses(robot.posture(posture).unwrap());
    let p = |name: &str| X_BL[robot.link_index(name).unwrap()].translation.vector;
    (p(a) - p(b)).norm()
}

#[test]
fn segments_are_as_long_as_published() {
    let [hubo, human] = receivers();
    for (robot, a, b, wanted) in [
        (&hubo, "left_arm_1", "right_arm_1", 0.429),
        (&hubo, "left_arm_1", "left_palm", 0.48138),
        (&hubo, "right_arm_1", "right_arm_6", 0.36073),
        (&hubo, "left_thigh", "left_foot", 0.60041),
        (&human, "left_arm_1", "right_arm_1", 0.456),
        (&human, "left_arm_1", "left_arm_4", 0.327),
        (&human, "right_arm_4", "right_palm", 0.257),
        (&human, "left_thigh", "left_shank", 0.431),
    ] {
        let found_m = distance_m(robot, "zero", a, b);
        assert!((found_m - wanted).abs() < 1e-9, "{}: {a} to {b} is {found_m}", robot.name);
    }
}

#[test]
fn the_arm_of_a_person_is_solved_in_closed_form() {
    let human = samples::human();
    for arm in &human.arms {
        assert_eq!(ArmIk::of(&human, arm).unwrap().method(), IkMethod::ClosedForm);
    }
}

#[test]
fn left_and_right_mirror_each_other_in_every_posture() {
    for robot in receivers() {
        // Who serves carries a tray on one side.
        for (name, q) in robot.postures.iter().filter(|(name, _)| name != "serving") {
            let X_BL = robot.link_poses(q);
            for link in robot.links.iter().filter(|link| link.name.starts_with("left_")) {
                let at = |name: &str| X_BL[robot.link_index(name).unwrap()];
                let (left, right) = (at(&link.name), at(&link.name.replace("left_", "right_")));
                let mirrored = left.translation.vector.component_mul(&Vector3::new(1.0, -1.0, 1.0));
                assert!((mirrored - right.translation.vector).norm() < 1e-6, "{} {name}: {}", robot.name, link.name);
            }
        }
    }
}

#[test]
fn receivers_do_not_touch_themselves_in_their_postures() {
    for robot in receivers() {
        let model = CollisionModel::new(&robot).unwrap();
        let judge = Exhaustive::new(&model, &World::new(), None, &[]).unwrap();
        // At `zero` the arms hang straight down, the open thumbs in the thighs.
        for (name, q) in robot.postures.iter().filter(|(name, _)| name != "zero") {
            let hit = judge.first_hit(q);
            assert!(hit.is_none(), "{} {name}: {hit:?}", robot.name);
        }
    }
}

#[test]
fn both_hands_open_as_far_as_said_and_hold_a_can_and_a_box() {
    for (robot, opening) in receivers().iter().zip([0.075..0.09, 0.08..0.1]) {
        for arm in &robot.arms {
            let hand = HandModel::new(robot, arm);
            let opening_m = hand.opening_m();
            assert!(opening.contains(&opening_m), "{} {}: {opening_m}", robot.name, arm.name);
            // Half sizes, metres: a can of 6 cm and a box of 5 cm by 4 cm.
            for (a, b, c, e2) in [(0.03, 0.03, 0.05, 1.0), (0.025, 0.02, 0.06, 0.2)] {
                let thing = [Superquadric::new(a, b, c, 0.1, e2, Isometry3::identity()).unwrap()];
                let settings = GraspSettings::default();
                let found = candidates(&hand, &thing, Touched::Bodies, &settings, &Isometry3::identity(), &|_, _| None);
                let held = found.iter().filter(|grasp| grasp.is_accepted() && grasp.epsilon > 0.0).count();
                assert!(held > 20, "{} {}: {held} of {}", robot.name, arm.name, found.len());
            }
        }
    }
}
