//! Closed form of a six-joint arm: a ball at the shoulder S, a hinge, and two axes that meet at the wrist W (Hubo).
//!
//! Such an arm has no arm angle to choose: what a third wrist axis would do, the elbow's turn about SW has to. Seen from
//! the hand, W stands still and S is at a known place, so
//! 1. the distance |SW| gives the hinge by the law of cosines, two ways;
//! 2. the two wrist joints turn the line from W to S to where the hand sees it: two circles on a ball about W, which meet in
//!    two points (Paden–Kahan subproblem 2; Murray, Li, Sastry 1994, 3.3.2);
//! 3. what is left is a rotation of the shoulder, which splits two ways.
//!
//! Eight branches at most. A pose whose W is within reach may still have none: the two circles need not meet.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

use super::IkReject;
use super::arm::most_frequent;
use super::ball::Ball;
use super::extract::{Line, TOLERANCE};
use super::solve::{REACH_SLACK, axis_rotation, ball_branches, within};
use crate::math;
use crate::robot::{JointKind, JointLimit, Robot};

/// Upper arm and forearm are at least this long, metres.
const SHORTEST_M: f64 = 1e-3;

/// Wrist axes whose sine is below this are nearly parallel and leave most poses without a solution.
const NEARLY_PARALLEL: f64 = 0.1;

/// A hinge that is bent by less than this, radians, is taken as straight: |SW| changes by 2e-15 m, and round-off of 1e-16 m
/// in |SW| bends it by 4e-8.
const STRAIGHT: f64 = 2e-7;

/// Circles touch when they cut or miss each other by less than this fraction of the smaller one's radius squared: the error
/// of taking them so is that fraction of the radius.
const TOUCHING: f64 = 1e-14;

/// A circle whose radius is below the root of this fraction of |SW| is a point.
const POINT: f64 = 1e-26;

/// A direction this near to an axis (sine) leaves the turn about the axis free.
const ALONG: f64 = 1e-10;

/// Turns tried for a wrist joint that is free, besides the present one, radians; the first that the limits allow is
/// taken.
const FREE_TURNS: [f64; 12] = [0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2, 1.8, -1.8, 2.5, -2.5, PI];

/// A six-joint arm, ready to be solved. All vectors are at q = 0 in the frame B of the arm's base link.
#[derive(Clone, Debug)]
pub(super) struct SixArm {
    shoulder: Ball,
    a4: Vector3<f64>,
    a5: Vector3<f64>,
    a6: Vector3<f64>,
    p_BS: Vector3<f64>,
    /// From S to the nearest point E of the hinge.
    v_SE: Vector3<f64>,
    v_EW: Vector3<f64>,
    p_HW: Point3<f64>,
    /// Rotation of the hand at q = 0, transposed.
    R_HB0: Matrix3<f64>,
    /// |SE|, metres.
    upper_m: f64,
    /// Distance of W to the hinge, metres.
    fore_m: f64,
    /// Distance of W to the plane of S across the hinge, metres.
    beside_m: f64,
    /// Signed angle from SE to EW about the hinge at q = 0.
    elbow0: f64,
    limits: [JointLimit; 6],
}

/// What the hinge leaves to the other joints.
struct Bent {
    q4: f64,
    bend: Matrix3<f64>,
    /// From W to S, as the forearm sees it at the wrist's zero.
    u: Vector3<f64>,
}

impl SixArm {
    /// The six joints between two links; `None` when the chain is of another kind.
    pub(super) fn between(robot: &Robot, base_link: usize, tip_link: usize) -> Option<Self> {
        let chain = robot.chain(base_link, tip_link)?;
        let moving = chain.iter().map(|&joint| &robot.joints[joint]).filter(|joint| joint.kind != JointKind::Fixed);
        let joints: [_; 6] = moving.collect::<Vec<_>>().try_into().ok()?;
        if joints.iter().any(|joint| joint.kind != JointKind::Revolute || joint.dof.is_none()) {
            return None;
        }
        let X_WL = robot.link_poses(&vec![0.0; robot.dof_count()]);
        let X_BW = X_WL[base_link].inverse();
        let lines: [Line; 6] = joints.map(|joint| {
            let X_BL = X_BW * X_WL[joint.child];
            Line { p: X_BL.translation.vector, a: Unit::new_unchecked(X_BL.rotation * joint.axis.into_inner()) }
        });
        let [S, W] = [(1, 0), (5, 4)].map(|(one, other)| lines[one].nearest_to(&lines[other]));
        let meet = |point: &Vector3<f64>, through: &[Line]| through.iter().all(|l| l.distance_to(point) <= TOLERANCE);
        let is_right = |a: usize, b: usize| lines[a].a.dot(&lines[b].a).abs() <= TOLERANCE;
        let [a4, a5, a6] = [3, 4, 5].map(|joint| lines[joint].a.into_inner());
        let is_ball = meet(&S, &lines[..3]) && is_right(0, 1) && is_right(1, 2);
        if !is_ball || !meet(&W, &lines[4..]) || a5.cross(&a6).norm() < NEARLY_PARALLEL {
            return None;
        }
        let E = lines[3].p + a4 * a4.dot(&(S - lines[3].p));
        let (v_SE, v_EW) = (E - S, W - E);
        let beside_m = v_EW.dot(&a4);
        let across = v_EW - a4 * beside_m;
        let (upper_m, fore_m) = (v_SE.norm(), across.norm());
        if upper_m.min(fore_m) < SHORTEST_M {
            return None;
        }
        let X_BH = X_BW * X_WL[tip_link];
        Some(Self {
            shoulder: Ball::new(&lines[0].a, &lines[1].a, &lines[2].a),
            a4,
            a5,
            a6,
            p_BS: S,
            v_SE,
            v_EW,
            p_HW: X_BH.inverse() * Point3::from(W),
            R_HB0: X_BH.rotation.to_rotation_matrix().into_inner().transpose(),
            upper_m,
            fore_m,
            beside_m,
            elbow0: math::atan2(v_SE.cross(&across).dot(&a4), v_SE.dot(&across)),
            limits: joints.map(|joint| joint.limit),
        })
    }

    /// Adds all solutions of a pose, joint vector by joint vector, and a reason for each branch that is none. A joint that
    /// turns further than once is given once.
    ///
    /// * `X_BH`: hand frame H in the frame B of the arm's base link.
    /// * `q_now`: the present joints; a wrist joint that the pose leaves free stays there if the limits allow.
    pub(super) fn solve(
        &self,
        X_BH: &Isometry3<f64>,
        q_now: &[f64],
        values: &mut Vec<f64>,
        rejected: &mut Vec<IkReject>,
    ) {
        let w = self.p_BS - (X_BH * self.p_HW).coords;
        let turned = X_BH.rotation.to_rotation_matrix().into_inner() * self.R_HB0;
        let v = turned.tr_mul(&w);
        let elbows = match self.elbows(w.norm()) {
            Ok(elbows) => elbows,
            Err(reject) => return rejected.push(reject),
        };
        for q4 in elbows {
            let bent = match within(&self.limits, 3, q4) {
                Ok(q4) => self.bent(q4),
                Err(reject) => {
                    rejected.push(reject);
                    continue;
                }
            };
            match self.meeting_points(&bent.u, &v) {
                Ok(points) => {
                    for c in points {
                        self.solve_from(&turned, &bent, &v, &c, q_now, values, rejected);
                    }
                }
                Err(reject) => rejected.push(reject),
            }
        }
    }

    /// The solution nearest to a posture, by its farthest joint.
    pub(super) fn near(&self, X_BH: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>> {
        let (mut values, mut rejected) = (Vec::new(), Vec::new());
        self.solve(X_BH, near, &mut values, &mut rejected);
        let farthest = |q: &&[f64]| q.iter().zip(near).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        values.chunks_exact(6).min_by(|l, r| farthest(l).total_cmp(&farthest(r))).map(<[f64]>::to_vec)
    }

    /// The first solution, or the most frequent reason why there is none.
    pub(super) fn first(&self, X_BH: &Isometry3<f64>, q_now: &[f64]) -> Result<Vec<f64>, IkReject> {
        let (mut values, mut rejected) = (Vec::new(), Vec::new());
        self.solve(X_BH, q_now, &mut values, &mut rejected);
        values.chunks_exact(6).next().map_or_else(|| Err(most_frequent(&rejected)), |q| Ok(q.to_vec()))
    }

    /// Distance by which W misses what the hinge allows, metres; 0 when it is within.
    pub(super) fn reach_gap_m(&self, X_BH: &Isometry3<f64>) -> f64 {
        let d = ((X_BH * self.p_HW).coords - self.p_BS).norm();
        let [shortest, longest] = self.range_m();
        (d - longest).max(shortest - d).max(0.0)
    }

    /// Least and greatest |SW|, limits aside, metres.
    fn range_m(&self) -> [f64; 2] {
        let hypot = |x: f64| (x * x + self.beside_m * self.beside_m).sqrt();
        [hypot(self.upper_m - self.fore_m), hypot(self.upper_m + self.fore_m)]
    }

    /// Positions of the hinge at a distance |SW| = `d`, metres.
    fn elbows(&self, d: f64) -> Result<Vec<f64>, IkReject> {
        let [shortest, longest] = self.range_m();
        // A pose that is not finite is farther away than anything.
        let gap_m = if d.is_finite() { d - longest } else { f64::INFINITY };
        if gap_m > REACH_SLACK {
            return Err(IkReject::OutOfReach { gap_m });
        }
        if d < (shortest - REACH_SLACK).max(1e-6) {
            return Err(IkReject::TooClose { gap_m: shortest.max(1e-6) - d });
        }
        // By half angles, as for the arm of seven joints.
        let (near, far) = ((longest - d) * (longest + d), (d - shortest) * (d + shortest));
        let theta = 2.0 * math::atan2(near.max(0.0).sqrt(), far.max(0.0).sqrt());
        let turns = if theta < STRAIGHT { vec![0.0] } else { vec![theta, -theta] };
        Ok(turns.into_iter().map(|turn| math::wrap_angle(turn - self.elbow0)).collect())
    }

    fn bent(&self, q4: f64) -> Bent {
        let bend = axis_rotation(&self.a4, q4);
        Bent { q4, bend, u: -(bend.tr_mul(&self.v_SE) + self.v_EW) }
    }

    /// Where the circle of `u` about axis 5 and that of `v` about axis 6 meet: one point when they touch, else two.
    fn meeting_points(&self, u: &Vector3<f64>, v: &Vector3<f64>) -> Result<Vec<Vector3<f64>>, IkReject> {
        let m = self.a5.dot(&self.a6);
        let n = self.a5.cross(&self.a6);
        let (along5, along6) = (self.a5.dot(u), self.a6.dot(v));
        let (over5, over6) = (along5 - m * along6, along6 - m * along5);
        let middle = (self.a5 * over5 + self.a6 * over6) / n.norm_squared();
        // What the smaller circle's radius leaves beside the plane of the axes; the larger one would drown it in round-off.
        let squared = |vector: &Vector3<f64>, axis: &Vector3<f64>| vector.cross(axis).norm_squared();
        let of_circle = |radius2: f64, over: f64| (radius2, radius2 - over * over / n.norm_squared());
        let (of_u, of_v) = (of_circle(squared(u, &self.a5), over6), of_circle(squared(v, &self.a6), over5));
        let (radius2, left) = if of_u.0 < of_v.0 { of_u } else { of_v };
        let slack = TOUCHING * radius2 + POINT * u.norm_squared();
        if left < -slack {
            return Err(IkReject::Stalled { gap_m: 0.0, gap_rad: self.turn_missing(u, v) });
        }
        if left <= slack {
            return Ok(vec![middle]);
        }
        let aside = n * (left.sqrt() / n.norm());
        Ok(vec![middle + aside, middle - aside])
    }

    /// Angle by which the two circles miss each other, radians.
    fn turn_missing(&self, u: &Vector3<f64>, v: &Vector3<f64>) -> f64 {
        let angle = |a: &Vector3<f64>, b: &Vector3<f64>| math::atan2(a.cross(b).norm(), a.dot(b));
        let (axes, of_u, of_v) = (angle(&self.a5, &self.a6), angle(&self.a5, u), angle(&self.a6, v));
        let nearest = (axes - of_u).abs();
        let farthest = (axes + of_u).min(2.0 * PI - axes - of_u);
        (nearest - of_v).max(of_v - farthest).max(0.0)
    }

    /// The solutions in which the wrist's first joint carries `c` to `u` and the second carries `v` to `c`.
    #[expect(clippy::too_many_arguments, reason = "one step of `solve`, split off for its length")]
    fn solve_from(
        &self,
        turned: &Matrix3<f64>,
        bent: &Bent,
        v: &Vector3<f64>,
        c: &Vector3<f64>,
        q_now: &[f64],
        values: &mut Vec<f64>,
        rejected: &mut Vec<IkReject>,
    ) {
        let turn = |axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>| {
            let across = |x: &Vector3<f64>| x - axis * axis.dot(x);
            let (from, to) = (across(from), across(to));
            let is_free = from.norm() < ALONG * bent.u.norm();
            (!is_free).then(|| math::atan2(axis.dot(&from.cross(&to)), from.dot(&to)))
        };
        let choices = |fixed: Option<f64>, joint: usize| match fixed {
            Some(angle) => vec![angle],
            None => q_now.get(joint).copied().into_iter().chain(FREE_TURNS).collect(),
        };
        // The circle of a vector along its axis is a point: then c is u, or v, itself.
        let (first, second) = (turn(&self.a5, c, &bent.u), turn(&self.a6, v, c));
        let (is_free, found, refused) = (first.is_none() || second.is_none(), values.len(), rejected.len());
        for q5 in choices(first, 4) {
            for q6 in choices(second, 5) {
                match within(&self.limits, 4, q5).and_then(|q5| Ok((q5, within(&self.limits, 5, q6)?))) {
                    Ok((q5, q6)) => self.push_shoulders(turned, bent, q5, q6, values, rejected),
                    Err(reject) => rejected.push(reject),
                }
                if is_free && values.len() > found {
                    return rejected.truncate(refused);
                }
            }
        }
    }

    fn push_shoulders(
        &self,
        turned: &Matrix3<f64>,
        bent: &Bent,
        q5: f64,
        q6: f64,
        values: &mut Vec<f64>,
        rejected: &mut Vec<IkReject>,
    ) {
        let wrist = axis_rotation(&self.a5, q5) * axis_rotation(&self.a6, q6);
        let R_shoulder = turned * (bent.bend * wrist).transpose();
        let angles = self.shoulder.angles(&R_shoulder);
        for branch in ball_branches(&self.limits, &self.shoulder, 0, &angles, &R_shoulder).into_iter().flatten() {
            match branch {
                Ok([q1, q2, q3]) => values.extend([q1, q2, q3, bent.q4, q5, q6]),
                Err(reject) => rejected.push(reject),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::robot::ik::{ArmIk, IkMethod};
    use crate::robot::{read_urdf, samples};

    /// An arm as no robot has it: axes askew to the base, the hinge beside both segments, wrist axes at 70°.
    fn askew() -> Robot {
        let joints = [
            ("0.1 0.2 0.9", "0.3 -0.2 0.5", "0 0 1"),
            ("0 0 0", "0 0 0", "1 0 0"),
            ("0 0 0", "0 0 0", "0 0.6 0.8"),
            ("0.03 0.02 -0.25", "0.2 0.1 -0.3", "0.2 1 0.1"),
            ("-0.04 0.05 -0.22", "0 0.3 0.1", "0 0 1"),
            ("0 0 0", "0 0 0.4", "0 0.93969262 0.34202014"),
        ];
        let mut urdf = String::from("<robot name='askew'><link name='l0'/><link name='tip'/>");
        for (i, (xyz, rpy, axis)) in joints.iter().enumerate() {
            urdf += &format!(
                "<link name='l{n}'/><joint name='j{n}' type='revolute'><parent link='l{i}'/><child link='l{n}'/>\
                 <origin xyz='{xyz}' rpy='{rpy}'/><axis xyz='{axis}'/><limit lower='-2.6' upper='2.6' velocity='1'/></joint>",
                n = i + 1,
            );
        }
        urdf += "<joint name='tool' type='fixed'><parent link='l6'/><child link='tip'/>\
                 <origin xyz='0.02 -0.05 -0.15' rpy='1 2 3'/></joint></robot>";
        read_urdf(&urdf, &|_| None).unwrap().value
    }

    fn arms() -> Vec<ArmIk> {
        let hubo = samples::hubo();
        let mut arms: Vec<ArmIk> = hubo.arms.iter().map(|arm| ArmIk::of(&hubo, arm).unwrap()).collect();
        let askew = askew();
        arms.push(ArmIk::between(&askew, 0, askew.link_index("tip").unwrap()).unwrap());
        assert!(arms.iter().all(|ik| ik.method() == IkMethod::ClosedForm6));
        arms
    }

    fn random(ik: &ArmIk, rng: &mut Rng) -> Vec<f64> {
        ik.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect()
    }

    /// Farthest joint of two postures, radians.
    fn apart(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// Every posture makes the pose and keeps the limits.
    fn check(ik: &ArmIk, X_BH: &Isometry3<f64>, postures: &crate::robot::ik::Postures) {
        for q in postures.iter() {
            let error = ik.chain().tip(q).inv_mul(X_BH);
            assert!(error.translation.vector.norm() < 1e-12, "{q:?}: {}", error.translation.vector.norm());
            assert!(2.0 * error.rotation.imag().norm() < 1e-12, "{q:?}: {}", error.rotation.imag().norm());
            assert!(q.iter().zip(ik.limits()).all(|(q, limit)| (limit.lower..=limit.upper).contains(q)), "{q:?}");
        }
    }

    #[test]
    fn the_posture_itself_is_among_the_solutions_and_all_of_them_are_true() {
        for ik in arms() {
            let mut rng = Rng::new(5, 0);
            let mut counts = [0; 9];
            for _ in 0..1000 {
                let q = random(&ik, &mut rng);
                let X_BH = ik.chain().tip(&q);
                let postures = ik.set(&X_BH, &[0.0; 6], 1);
                check(&ik, &X_BH, &postures);
                // Round-off of 1e-16 moves a joint by the root of it where two branches are about to become one.
                assert!(postures.iter().any(|found| apart(found, &q) < 1e-7), "{q:?}");
                assert!(apart(&ik.near(&X_BH, &q).unwrap(), &q) < 1e-7);
                assert!(ik.first(&X_BH, &q).is_ok());
                assert!(ik.reach_gap_m(&X_BH, &q) < 1e-12);
                counts[postures.len()] += 1;
            }
            assert!(counts[2..].iter().sum::<usize>() > 300, "{counts:?}");
        }
    }

    #[test]
    fn without_limits_there_are_up_to_eight_different_postures() {
        let mut robot = samples::hubo();
        for joint in &mut robot.joints {
            (joint.limit.lower, joint.limit.upper) = (-PI, PI);
        }
        let ik = ArmIk::of(&robot, &robot.arms[0]).unwrap();
        let mut rng = Rng::new(6, 0);
        let mut most = 0;
        for _ in 0..200 {
            let X_BH = ik.chain().tip(&random(&ik, &mut rng));
            let postures = ik.set(&X_BH, &[0.0; 6], 1);
            check(&ik, &X_BH, &postures);
            let all: Vec<&[f64]> = postures.iter().collect();
            for (index, one) in all.iter().enumerate() {
                assert!(all[index + 1..].iter().all(|other| apart(one, other) > 1e-6));
            }
            most = most.max(all.len());
        }
        assert_eq!(most, 8);
    }

    #[test]
    fn stretched_and_aligned_arms_are_solved_as_exactly_as_others() {
        let hubo = samples::hubo();
        let ik = ArmIk::of(&hubo, &hubo.arms[0]).unwrap();
        let mut rng = Rng::new(7, 0);
        for singular in [vec![3], vec![5], vec![1], vec![3, 5], vec![1, 3], vec![1, 3, 5], vec![0, 1, 2, 3, 4, 5]] {
            for _ in 0..100 {
                let mut q = random(&ik, &mut rng);
                singular.iter().for_each(|&joint| q[joint] = 0.0);
                let X_BH = ik.chain().tip(&q);
                let postures = ik.set(&X_BH, &q, 1);
                check(&ik, &X_BH, &postures);
                assert!(!postures.is_empty(), "{q:?}");
                assert!(ik.near(&X_BH, &q).is_some());
            }
        }
    }

    #[test]
    fn a_pose_without_solution_says_by_how_much_and_no_search_finds_one() {
        let hubo = samples::hubo();
        let ik = ArmIk::of(&hubo, &hubo.arms[0]).unwrap();
        let far = Isometry3::translation(2.0, 0.0, 0.0);
        let gap_m = ik.reach_gap_m(&far, &[0.0; 6]);
        assert!(gap_m > 1.0 && matches!(ik.first(&far, &[0.0; 6]), Err(IkReject::OutOfReach { .. })));
        assert_eq!(
            ik.set(&Isometry3::translation(f64::NAN, 0.0, 0.0), &[0.0; 6], 1).rejected,
            [IkReject::OutOfReach { gap_m: f64::INFINITY }]
        );
        // The arm straight down, then the hand turned about the axis that the wrist lacks: W is within reach, nothing
        // else can make that turn.
        let X_BH = ik.chain().tip(&[0.0; 6]);
        let W = X_BH * Isometry3::translation(0.0, 0.0, -0.12065 - 0.055);
        let aside = W * Isometry3::rotation(Vector3::y() * 0.5) * W.inv_mul(&X_BH);
        match ik.first(&aside, &[0.0; 6]) {
            Err(IkReject::Stalled { gap_rad, .. }) => assert!((gap_rad - 0.5).abs() < 1e-6, "{gap_rad}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn arms_of_another_kind_are_left_to_others() {
        let crichton = samples::crichton();
        let left = &crichton.arms[0];
        assert!(SixArm::between(&crichton, left.base_link, left.hand.tcp_link).is_none());
        // A shoulder yaw that misses the shoulder by 1 mm.
        let mut hubo = samples::hubo();
        let (base, tip) = (hubo.arms[0].base_link, hubo.arms[0].hand.tcp_link);
        let yaw = hubo.joints.iter_mut().find(|joint| joint.name == "left_shoulder_yaw_joint").unwrap();
        yaw.X_PJ.translation.x = 1e-3;
        assert!(SixArm::between(&hubo, base, tip).is_none());
        assert!(matches!(ArmIk::between(&hubo, base, tip).unwrap().method(), IkMethod::Numeric { .. }));
    }
}
