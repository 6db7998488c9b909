//! Maps of the two robots, judged by forward kinematics, dense IK and a checker of the whole robot.

use nalgebra::{Isometry3, Point3};

use super::clear::SelfClear;
use super::{ForwardSettings, InverseSettings, ReachError, ReachMap, Voxel, build_forward, build_inverse};
use crate::collision::{Checker, CollisionModel, Scratch, World};
use crate::rng::Rng;
use crate::robot::ik::{IkSet, SrsArm};
use crate::robot::{Chain, Dexterity, Robot, samples};
use crate::watch::Watch;

/// Coarse enough to be quick.
const COARSE_M: f64 = 0.1;

fn inverse(robot: &Robot, arm: usize) -> ReachMap {
    let settings = InverseSettings { voxel_m: COARSE_M, ..InverseSettings::default() };
    build_inverse(robot, arm, &settings, Watch::idle()).unwrap()
}

fn forward(robot: &Robot, arm: usize, orientations: usize) -> ReachMap {
    let settings = ForwardSettings { voxel_m: COARSE_M, orientations, samples: 100_000, ..ForwardSettings::default() };
    build_forward(robot, arm, &settings, Watch::idle()).unwrap()
}

/// Every pose of a map, or every so many: the configuration is within the limits, has the manipulability that the map
/// tells, touches nothing of the robot, and puts the hand into the pose; exactly so if the map was made that way.
fn check(robot: &Robot, arm: usize, map: &ReachMap, is_exact: bool, every: usize) {
    let chain = Chain::between(robot, robot.arms[arm].base_link, robot.arms[arm].hand.tcp_link).unwrap();
    let model = CollisionModel::new(robot).unwrap();
    // The judge is a checker of the whole robot whose other arm is out of the way, stretched out sideways.
    let checker = Checker::whole(&model, &World::new(), None, &[]).unwrap();
    let mut scratch = Scratch::default();
    let mut dexterity = Dexterity::new(&chain);
    let poses: Vec<(Voxel, usize)> =
        map.voxels().flat_map(|voxel| map.reached(voxel).map(move |orientation| (voxel, orientation))).collect();
    assert_eq!(poses.len(), map.reached_poses());
    let mut other_arm = 0;
    for &(voxel, orientation) in poses.iter().step_by(every) {
        let q = map.configuration(voxel, orientation).unwrap();
        assert!(q.iter().zip(chain.limits()).all(|(q, limit)| (limit.lower..=limit.upper).contains(q)));
        let X_BH = chain.tip(&q);
        if is_exact {
            let wanted = map.pose(voxel, orientation).unwrap();
            let off = wanted.inv_mul(&X_BH);
            assert!(off.translation.vector.norm() < 1e-9 && off.rotation.imag().norm() < 1e-9, "{off}");
        }
        assert_eq!(map.nearest(&X_BH), Some((voxel, orientation)));
        let m = dexterity.at(&q).manipulability;
        let told = map.manipulability(voxel, orientation).unwrap();
        assert!((told / m - 1.0).abs() < 0.015 || m < 1.1e-3 * map.most_manipulable(), "{told} {m}");
        let mut full = vec![0.0; robot.dof_count()];
        robot.arms[arm].dofs.iter().zip(&q).for_each(|(&dof, value)| full[dof] = *value);
        let hand = &robot.arms[arm].hand;
        hand.fingers.iter().flatten().zip(&hand.open).for_each(|(&dof, value)| full[dof] = *value);
        if let Some(hit) = checker.first_hit(&mut scratch, &full) {
            let other = &robot.arms[1 - arm].name;
            assert!(hit.a.starts_with(other.as_str()) || hit.b.starts_with(other.as_str()), "{hit}");
            other_arm += 1;
        }
    }
    assert!(other_arm * 10 < poses.len(), "{other_arm} touch the other arm");
}

#[test]
fn every_configuration_of_an_inverse_map_is_what_the_map_says() {
    for robot in [samples::crichton(), samples::alita()] {
        for arm in 0..2 {
            check(&robot, arm, &inverse(&robot, arm), true, 7);
        }
    }
}

#[test]
fn every_configuration_of_a_map_with_torso_is_what_the_map_says() {
    let robot = samples::crichton().with_torso(1);
    let settings = InverseSettings { voxel_m: 0.2, ..InverseSettings::default() };
    let map = build_inverse(&robot, 1, &settings, Watch::idle()).unwrap();
    check(&robot, 1, &map, true, 7);
    let settings = ForwardSettings { samples: 50_000, voxel_m: 0.2, ..ForwardSettings::default() };
    check(&robot, 1, &build_forward(&robot, 1, &settings, Watch::idle()).unwrap(), false, 7);
}

#[test]
fn every_configuration_of_a_forward_map_is_what_the_map_says() {
    for robot in [samples::crichton(), samples::alita()] {
        for orientations in [1, 40] {
            check(&robot, 0, &forward(&robot, 0, orientations), false, 7);
        }
    }
}
