//! Forward kinematics checks every answer; the generating posture must be among the answers.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use super::{IkReject, IkSet, NotSrs, SrsArm};
use crate::math::wrap_angle;
use crate::rng::Rng;
use crate::robot::{Robot, read_urdf, samples};

/// A robot, the links at both ends of an arm, and the arm's degrees of freedom.
struct Case {
    name: String,
    robot: Robot,
    base: usize,
    tip: usize,
    dofs: Vec<usize>,
    arm: SrsArm,
}

impl Case {
    fn new(name: String, robot: &Robot, base: usize, tip: usize, dofs: Vec<usize>) -> Self {
        let arm = SrsArm::between(robot, base, tip).unwrap();
        Self { name, robot: robot.clone(), base, tip, dofs, arm }
    }

    /// `X_BH` by forward kinematics.
    fn forward(&self, q: &[f64; 7]) -> Isometry3<f64> {
        let mut full = vec![0.0; self.robot.dof_count()];
        for (&dof, &value) in self.dofs.iter().zip(q) {
            full[dof] = value;
        }
        let X_WL = self.robot.link_poses(&full);
        X_WL[self.base].inverse() * X_WL[self.tip]
    }

    fn random_q(&self, rng: &mut Rng) -> [f64; 7] {
        self.arm.limits().map(|limit| rng.uniform(limit.lower, limit.upper))
    }

    /// Checks every solution and answers whether one of them is `q`.
    fn check(&self, X_BH: &Isometry3<f64>, set: &IkSet, q: &[f64; 7], q_tolerance: f64) -> bool {
        for solution in &set.solutions {
            let found = self.forward(&solution.q);
            let position = (found.translation.vector - X_BH.translation.vector).norm();
            let rotation = found.rotation.angle_to(&X_BH.rotation);
            assert!(position < 1e-9 && rotation < 1e-7, "{}: {position} m {rotation} rad {q:?}", self.name);
            // angle_to goes through an arc cosine, which is blind below 1e-8: compare the quaternions as well.
            let difference = found.rotation.rotation_to(&X_BH.rotation).imag().norm();
            assert!(2.0 * difference < 1e-9, "{}: {difference} {q:?}", self.name);
            for (value, limit) in solution.q.iter().zip(self.arm.limits()) {
                assert!((limit.lower..=limit.upper).contains(value));
            }
        }
        set.solutions.iter().any(|s| s.q.iter().zip(q).all(|(a, b)| wrap_angle(a - b).abs() < q_tolerance))
    }
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for robot in [samples::crichton(), samples::alita()] {
        for arm in &robot.arms {
            let name = format!("{} {}", robot.name, arm.name);
            cases.push(Case::new(name, &robot, arm.base_link, arm.hand.tcp_link, arm.dofs.clone()));
        }
    }
    let shared = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/bench/arm/srs7.urdf");
    match std::fs::read_to_string(shared) {
        Ok(urdf) => {
            let robot = read_urdf(&urdf, &|_| None).unwrap().value;
            let (base, tip) = (robot.link_index("base").unwrap(), robot.link_index("tcp").unwrap());
            cases.push(Case::new("srs7".to_owned(), &robot, base, tip, (0..7).collect()));
        }
        Err(_) => eprintln!("srs7 skipped: no data"),
    }
    cases
}

#[test]
fn every_branch_reaches_the_pose_and_the_generating_posture_is_among_them() {
    for case in cases() {
        let mut rng = Rng::new(11, 0);
        for _ in 0..2000 {
            let q = case.random_q(&mut rng);
            let X_BH = case.forward(&q);
            let angle = case.arm.arm_angle(&q);
            let set = case.arm.solve(&X_BH, angle);
            assert!(set.solutions.len() <= 8);
            assert!(set.solutions.iter().all(|s| wrap_angle(case.arm.arm_angle(&s.q) - angle).abs() < 1e-6));
            // Near an aligned ball the outer angles are ill-conditioned by 1 / sin: 1e-6 leaves room for 1e-10.
            assert!(case.check(&X_BH, &set, &q, 1e-6), "{}: {q:?} is missing: {set:?}", case.name);
            assert_eq!(case.arm.reach_gap_m(&X_BH), 0.0);
        }
    }
}

#[test]
fn singular_postures_are_solved_as_exactly_as_others() {
    for case in cases() {
        let mut rng = Rng::new(12, 0);
        for singular in [vec![1], vec![3], vec![5], vec![1, 5], vec![1, 3], vec![3, 5], vec![1, 3, 5]] {
            for _ in 0..100 {
                let mut q = case.random_q(&mut rng);
                for &joint in &singular {
                    q[joint] = 0.0;
                }
                let X_BH = case.forward(&q);
                let set = case.arm.solve(&X_BH, case.arm.arm_angle(&q));
                case.check(&X_BH, &set, &q, 1e-6);
                assert!(!set.solutions.is_empty(), "{}: {q:?}: {:?}", case.name, set.rejected);
            }
        }
        let zero = [0.0; 7];
        let X_BH = case.forward(&zero);
        assert!(case.check(&X_BH, &case.arm.solve(&X_BH, case.arm.arm_angle(&zero)), &zero, 1e-6), "{}", case.name);
    }
}

#[test]
fn a_pose_too_far_or_too_near_is_refused_with_its_gap() {
    for case in cases() {
        let (upper, fore) = case.arm.lengths_m();
        let mut rng = Rng::new(13, 0);
        for _ in 0..200 {
            let X_BH = case.forward(&case.random_q(&mut rng));
            let p_BW = X_BH * case.arm.p_HW;
            let direction = (p_BW - case.arm.shoulder()).try_normalize(1e-9).unwrap();
            let at = |distance: f64| {
                let mut moved = X_BH;
                moved.translation.vector += case.arm.shoulder() + direction * distance - p_BW;
                case.arm.sweep(&moved, 36)
            };
            let gap = rng.uniform(1e-6, 0.5);
            match at(upper + fore + gap).rejected[..] {
                [IkReject::OutOfReach { gap_m }] => assert!((gap_m - gap).abs() < 1e-9),
                ref other => panic!("{other:?}"),
            }
            let shortest = (upper - fore).abs();
            if shortest > 1e-3 {
                match at(0.4 * shortest).rejected[..] {
                    [IkReject::TooClose { gap_m }] => assert!((gap_m - 0.6 * shortest).abs() < 1e-9),
                    ref other => panic!("{other:?}"),
                }
            }
        }
    }
}

#[test]
fn a_pose_that_is_not_finite_is_out_of_reach() {
    let case = cases().swap_remove(0);
    for x in [f64::NAN, f64::INFINITY] {
        let set = case.arm.sweep(&Isometry3::translation(x, 0.0, 0.0), 4);
        assert_eq!(set.rejected, [IkReject::OutOfReach { gap_m: f64::INFINITY }]);
    }
}

#[test]
fn rejected_branches_name_the_joint_that_would_leave_its_limits() {
    let case = cases().swap_remove(0);
    let (upper, fore) = case.arm.lengths_m();
    // |SW| for |q4| = 2.5 rad, beyond the limit of 2.12.
    let distance = (upper * upper + fore * fore + 2.0 * upper * fore * crate::math::cos(2.5)).sqrt();
    let mut X_BH = case.forward(&[0.1; 7]);
    let p_BW = X_BH * case.arm.p_HW;
    X_BH.translation.vector += case.arm.shoulder() + Vector3::x() * distance - p_BW;
    let set = case.arm.solve(&X_BH, 0.3);
    assert!(set.solutions.is_empty());
    for reject in &set.rejected {
        match *reject {
            IkReject::JointLimit { joint: 3, value, .. } => assert!((value.abs() - 2.5).abs() < 1e-9),
            ref other => panic!("{other}"),
        }
    }
    assert_eq!(set.reject_counts(), [("joint 4 limit".to_owned(), 2)]);
}

/// A robot of one S-R-S arm: roll limits and an offset of the elbow as asked for.
fn one_arm(roll_limit: f64, elbow_offset: f64) -> Robot {
    let mut urdf = String::from("<robot name='one'><link name='l0'/>");
    let z = [0.0, 0.25, 0.0, 0.3, 0.0, 0.2, 0.0];
    for (i, z) in z.iter().enumerate() {
        let (axis, limit) = if i % 2 == 0 { ("0 0 1", roll_limit) } else { ("0 1 0", 2.0) };
        let x = if i == 3 { elbow_offset } else { 0.0 };
        urdf += &format!(
            "<link name='l{n}'/><joint name='j{n}' type='revolute'><parent link='l{i}'/><child link='l{n}'/>\
             <origin xyz='{x} 0 {z}'/><axis xyz='{axis}'/><limit lower='-{limit}' upper='{limit}' velocity='1'/></joint>",
            n = i + 1,
        );
    }
    read_urdf(&(urdf + "</robot>"), &|_| None).unwrap().value
}

#[test]
fn joints_that_turn_further_than_once_give_every_configuration_once() {
    let robot = one_arm(6.25, 0.0);
    let case = Case::new("turns".to_owned(), &robot, 0, 7, (0..7).collect());
    let q = [4.0, 0.5, -5.0, 0.7, 0.3, 0.9, 1.0];
    let X_BH = case.forward(&q);
    let set = case.arm.solve(&X_BH, case.arm.arm_angle(&q));
    case.check(&X_BH, &set, &q, 1e-6);
    assert!(set.solutions.iter().any(|s| s.q.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-6)));
    // Four rolls of ±6.25 rad hold every angle but a few near 0 twice.
    assert_eq!(set.solutions.len(), 8 * 16);
    for (i, one) in set.solutions.iter().enumerate() {
        for other in &set.solutions[i + 1..] {
            assert!(one.q.iter().zip(&other.q).any(|(a, b)| (a - b).abs() > 1e-3));
        }
    }
}

#[test]
fn arms_of_another_kind_are_refused_with_the_reason() {
    let offset = one_arm(3.0, 0.03);
    match SrsArm::between(&offset, 0, 7).unwrap_err() {
        NotSrs::AxesMiss { joints: "3, 4 and 5", miss_m } => assert!((miss_m - 0.03).abs() < 1e-12),
        other => panic!("{other}"),
    }
    let straight = one_arm(3.0, 0.0);
    assert!(matches!(SrsArm::between(&straight, 0, 6).unwrap_err(), NotSrs::JointCount { found: 6, .. }));
    assert!(matches!(SrsArm::between(&straight, 7, 0).unwrap_err(), NotSrs::NotAChain { .. }));
}

#[test]
fn a_sweep_is_the_solutions_of_its_angles_in_order() {
    let case = cases().swap_remove(1);
    let X_BH = case.forward(&[0.2, 0.7, -0.4, 1.2, 0.3, -0.8, 0.5]);
    let sweep = case.arm.sweep(&X_BH, 12);
    let mut apart = IkSet::default();
    for i in 0..12 {
        case.arm.solve_into(&X_BH, TAU * f64::from(i) / 12.0 - PI, &mut apart);
    }
    assert_eq!(sweep, apart);
    assert!(sweep.solutions.len() > 12);
    let order: Vec<_> = sweep.solutions.iter().map(|s| (s.arm_angle, s.branch)).collect();
    assert!(order.windows(2).all(|pair| pair[0] < pair[1]));
}

/// Of every sample of a fine sweep: whether it lies within a feasible arc of its branch is whether it is solved.
/// Samples within 1e-6 rad of an end of an arc are left out; answers how many were compared and how many solved.
fn compare_arcs_with_a_sweep(case: &Case, X_BH: &Isometry3<f64>, angles: usize) -> (usize, usize) {
    let arcs = case.arm.feasible_arcs(X_BH);
    assert!(arcs.iter().all(|arc| arc.from < arc.to && arc.to <= arc.from + TAU && arc.from.abs() <= PI + 1e-12));
    let (mut compared, mut solved) = (0, 0);
    let mut set = IkSet::default();
    for i in 0..angles {
        let angle = TAU * (i as f64 + 0.37) / angles as f64 - PI;
        set.clear();
        case.arm.solve_into(X_BH, angle, &mut set);
        for branch in 0..8 {
            let own = || arcs.iter().filter(|arc| arc.branch == branch);
            let at_an_end = |end: f64| wrap_angle(end - angle).abs() < 1e-6;
            if own().any(|arc| arc.to - arc.from < TAU && (at_an_end(arc.from) || at_an_end(arc.to))) {
                continue;
            }
            let is_solved = set.solutions.iter().any(|solution| solution.branch == branch);
            let is_inside = own().any(|arc| arc.contains(angle));
            assert_eq!(is_solved, is_inside, "{}: branch {branch} at {angle}: {arcs:?} for {X_BH:?}", case.name);
            compared += 1;
            solved += usize::from(is_solved);
        }
    }
    (compared, solved)
}

#[test]
fn feasible_arcs_are_where_a_fine_sweep_has_solutions() {
    for case in cases() {
        let mut rng = Rng::new(14, 0);
        let (mut compared, mut solved) = (0, 0);
        for _ in 0..1500 {
            let (more, found) = compare_arcs_with_a_sweep(&case, &case.forward(&case.random_q(&mut rng)), 90);
            (compared, solved) = (compared + more, solved + found);
        }
        // Neither all nor nothing: the comparison has something to find on both sides.
        assert!(solved > compared / 50 && solved < compared * 49 / 50, "{}: {solved} of {compared}", case.name);
    }
}

#[test]
fn feasible_arcs_are_right_at_singular_postures_and_with_narrow_limits() {
    for case in cases() {
        let mut rng = Rng::new(15, 0);
        for singular in [vec![1], vec![3], vec![5], vec![1, 5], vec![1, 3], vec![3, 5], vec![1, 3, 5]] {
            for _ in 0..60 {
                let mut q = case.random_q(&mut rng);
                singular.iter().for_each(|&joint| q[joint] = 0.0);
                compare_arcs_with_a_sweep(&case, &case.forward(&q), 90);
            }
        }
    }
    for (roll, seed) in [(0.4, 1), (1.2, 2), (3.3, 3), (4.5, 4)] {
        let case = Case::new(format!("rolls within {roll}"), &one_arm(roll, 0.0), 0, 7, (0..7).collect());
        let mut rng = Rng::new(seed, 0);
        for _ in 0..300 {
            compare_arcs_with_a_sweep(&case, &case.forward(&case.random_q(&mut rng)), 90);
        }
        for singular in [vec![1], vec![3], vec![1, 3, 5]] {
            for _ in 0..40 {
                let mut q = case.random_q(&mut rng);
                singular.iter().for_each(|&joint| q[joint] = 0.0);
                compare_arcs_with_a_sweep(&case, &case.forward(&q), 90);
            }
        }
    }
}

#[test]
fn a_pose_out_of_reach_has_no_feasible_arcs() {
    let case = cases().swap_remove(0);
    assert!(case.arm.feasible_arcs(&Isometry3::translation(3.0, 0.0, 0.0)).is_empty());
}

proptest! {
    /// Any hand pose at all: an answer without panic, and every solution is true.
    #[test]
    fn any_pose_is_answered(seed in any::<u64>(), scale in 0.0..2.0f64, angle in -10.0..10.0f64) {
        thread_local!(static CASE: Case = cases().swap_remove(0));
        let answered = CASE.with(|case| {
            let mut rng = Rng::new(seed, 0);
            let X_BH = Isometry3::from_parts((rng.direction() * scale).into(), rng.rotation());
            let set = case.arm.solve(&X_BH, angle);
            case.check(&X_BH, &set, &[0.0; 7], 0.0);
            !set.solutions.is_empty() || !set.rejected.is_empty()
        });
        prop_assert!(answered);
    }
}
