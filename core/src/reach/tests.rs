//! Maps of the two robots, judged by forward kinematics, dense IK and a checker of the whole robot.

use nalgebra::Isometry3;

use super::{About, ForwardSettings, InverseSettings, ReachError, ReachMap, Voxel, build_forward, build_inverse};
use crate::collision::{Checker, CollisionModel, Scratch, World};
use crate::rng::Rng;
use crate::robot::ik::SrsArm;
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

#[test]
fn a_file_keeps_the_map() {
    let crichton = samples::crichton();
    let with_torso = crichton.with_torso(0);
    let coarse = InverseSettings { voxel_m: 0.25, ..InverseSettings::default() };
    let maps = [
        (&crichton, inverse(&crichton, 0)),
        (&crichton, forward(&crichton, 0, 1)),
        (&crichton, forward(&crichton, 0, 272)),
        (&with_torso, build_inverse(&with_torso, 0, &coarse, Watch::idle()).unwrap()),
    ];
    for (robot, map) in maps {
        let bytes = map.to_bytes();
        let loaded = ReachMap::from_bytes(&bytes, robot, 0).unwrap();
        assert_eq!(loaded.to_bytes(), bytes);
        assert_eq!((loaded.about(), loaded.size()), (map.about(), map.size()));
        assert_eq!(About::of_file(&bytes).as_ref(), Ok(map.about()));
        assert!(map.is_of(robot, 0) && !map.is_of(robot, 1));
        assert!(loaded.voxels().eq(map.voxels()));
        for voxel in map.voxels() {
            assert_eq!(loaded.center(voxel), map.center(voxel));
            assert_eq!(loaded.voxel_at(&map.center(voxel)), Some(voxel));
            assert_eq!(loaded.mean_manipulability(voxel), map.mean_manipulability(voxel));
            assert!(loaded.reached(voxel).eq(map.reached(voxel)));
            let best = map.best_orientation(voxel).unwrap();
            assert_eq!(loaded.configuration(voxel, best), map.configuration(voxel, best));
            assert_eq!(loaded.manipulability(voxel, best), map.manipulability(voxel, best));
            assert!(map.mean_manipulability(voxel) <= map.manipulability(voxel, best).unwrap() + 1e-6);
        }
    }
}

#[test]
fn a_map_of_another_arm_hand_or_limit_is_refused() {
    let (crichton, alita) = (samples::crichton(), samples::alita());
    let bytes = inverse(&crichton, 0).to_bytes();
    let mut stiff = crichton.clone();
    let joint = stiff.joints.iter().position(|joint| joint.name == "left_joint_6").unwrap();
    stiff.joints[joint].limit.upper = 1.5;
    let other_hand = samples::with_hand(&crichton, "left", &samples::hand("pg70.json"));
    for (robot, arm) in [(&crichton, 1), (&alita, 0), (&crichton.with_torso(0), 0), (&stiff, 0), (&other_hand, 0)] {
        let refused = ReachMap::from_bytes(&bytes, robot, arm).unwrap_err();
        assert!(matches!(refused, ReachError::OtherArm { .. }), "{refused}");
    }
}

#[test]
fn a_damaged_file_is_refused_with_its_place() {
    let robot = samples::alita();
    let settings = InverseSettings { voxel_m: 0.3, ..InverseSettings::default() };
    let bytes = build_inverse(&robot, 0, &settings, Watch::idle()).unwrap().to_bytes();
    let read = |bytes: &[u8]| ReachMap::from_bytes(bytes, &robot, 0);
    assert!(read(&bytes).is_ok());
    for end in 0..bytes.len() {
        let refused = read(&bytes[..end]).unwrap_err();
        assert!(matches!(refused, ReachError::BadFile { .. }), "{end}: {refused}");
    }
    for at in 0..bytes.len() {
        for bit in [0x01, 0x80] {
            let mut flipped = bytes.clone();
            flipped[at] ^= bit;
            assert!(read(&flipped).is_err(), "byte {at}");
        }
    }
    let mut rng = Rng::new(3, 0);
    for _ in 0..500 {
        let noise: Vec<u8> = (0..rng.index(300)).map(|_| rng.index(256) as u8).collect();
        assert!(read(&noise).is_err());
    }
    assert_eq!(read(b"ply\nformat").unwrap_err().to_string(), "magic: found ply\\nform, wanted ECREACH\\n");
}

#[test]
fn the_number_of_threads_does_not_change_a_map() {
    let robot = samples::alita();
    let alone = crate::parallel::on_one_thread(|| (inverse(&robot, 1).to_bytes(), forward(&robot, 1, 40).to_bytes()));
    assert_eq!(alone, (inverse(&robot, 1).to_bytes(), forward(&robot, 1, 40).to_bytes()));
}

#[test]
fn building_can_be_stopped_and_tells_how_far_it_is() {
    use std::sync::Mutex;
    let robot = samples::alita();
    let stop = Watch::new(&|| true, &|_, _| (), &|| 0.0);
    let settings = ForwardSettings { samples: 1000, ..ForwardSettings::default() };
    assert_eq!(build_inverse(&robot, 0, &InverseSettings::default(), stop).unwrap_err(), ReachError::Cancelled);
    assert_eq!(build_forward(&robot, 0, &settings, stop).unwrap_err(), ReachError::Cancelled);
    let told = Mutex::new(Vec::new());
    let tell = |share: f64, _: &str| told.lock().unwrap().push(share);
    let settings = InverseSettings { voxel_m: 0.3, ..InverseSettings::default() };
    build_inverse(&robot, 0, &settings, Watch::new(&|| false, &tell, &|| 0.0)).unwrap();
    let told = told.into_inner().unwrap();
    assert!(told.len() > 5 && told.iter().all(|share| (0.0..=1.0).contains(share)));
    assert!(told.contains(&1.0));
}

#[test]
fn what_cannot_be_built_is_refused() {
    let robot = samples::crichton();
    let inverse = |arm, settings: InverseSettings| build_inverse(&robot, arm, &settings, Watch::idle()).unwrap_err();
    let forward = |settings: ForwardSettings| build_forward(&robot, 0, &settings, Watch::idle()).unwrap_err();
    let default = InverseSettings::default;
    assert!(matches!(inverse(2, default()), ReachError::NoSuchArm { found: 2, arms: 2 }));
    assert!(matches!(inverse(0, InverseSettings { voxel_m: 0.0, ..default() }), ReachError::BadVoxel { .. }));
    assert_eq!(
        inverse(0, InverseSettings { orientations: 41, ..default() }),
        ReachError::BadOrientations { found: 41 }
    );
    assert_eq!(inverse(0, InverseSettings { orientations: 1, ..default() }), ReachError::NeedsOrientations);
    let default = ForwardSettings::default;
    assert!(matches!(forward(ForwardSettings { samples: 0, ..default() }), ReachError::BadSamples { .. }));
    let fine = ForwardSettings { voxel_m: 0.012, orientations: 272, ..default() };
    assert!(matches!(forward(fine), ReachError::TooMany { .. }));
}

/// Reachable poses of the arm, by configurations that touch nothing.
fn reachable(robot: &Robot, arm: usize, count: usize) -> Vec<Isometry3<f64>> {
    let chain = Chain::between(robot, robot.arms[arm].base_link, robot.arms[arm].hand.tcp_link).unwrap();
    let model = CollisionModel::new(robot).unwrap();
    let rest = vec![0.0; robot.dof_count()];
    let checker = Checker::for_arm(&model, &World::new(), None, &[], arm, &rest).unwrap();
    let (mut rng, mut scratch) = (Rng::new(5, 0), Scratch::default());
    let draw = || chain.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect::<Vec<f64>>();
    let free = std::iter::repeat_with(draw).filter(|q| checker.is_free(&mut scratch, q));
    free.take(count).map(|q| chain.tip(&q)).collect()
}

#[test]
fn what_is_reachable_is_in_the_map_and_what_is_not_is_not_half_of_a_voxel() {
    for robot in [samples::crichton(), samples::alita()] {
        let map = build_inverse(&robot, 0, &InverseSettings::default(), Watch::idle()).unwrap();
        let poses = reachable(&robot, 0, 4_000);
        let is_in = |X_BH: &&Isometry3<f64>| map.nearest(X_BH).is_some_and(|(voxel, _)| map.fraction(voxel) > 0.0);
        let found = poses.iter().filter(is_in).count();
        assert!(found as f64 >= 0.99 * poses.len() as f64, "{found} of {}", poses.len());

        // No hand is where no wrist can be: farther from the shoulder than the stretched arm.
        let srs = SrsArm::of(&robot, &robot.arms[0]).unwrap();
        let (upper_m, fore_m) = srs.lengths_m();
        let reach_m = upper_m + fore_m + srs.wrist().coords.norm();
        let mut rng = Rng::new(6, 0);
        for _ in 0..4_000 {
            let beyond = srs.shoulder() + rng.direction() * (reach_m + rng.uniform(0.0, 0.1));
            let fraction = map.voxel_at(&beyond).map_or(0.0, |voxel| map.fraction(voxel));
            assert!(fraction < 0.5, "{fraction} at {beyond}");
        }
    }
}
