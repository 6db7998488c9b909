//! One interface for the inverse kinematics of every arm.

use std::fmt;

use nalgebra::Isometry3;

use super::led::LedArm;
use super::numeric::NumericArm;
use super::six::SixArm;
use super::{IkReject, IkSet, NotSrs, SrsArm};
use crate::robot::{Arm, Chain, ChainError, JointLimit, Robot};

/// Arm angles tried for a first solution before the feasible arcs are asked, radians.
const FIRST_ANGLES: [f64; 5] = [0.0, 1.3, -1.3, 2.5, -2.5];
/// Arm angles whose reasons are counted when none is feasible.
const REASON_ANGLES: usize = 36;

/// The inverse kinematics of an arm: closed form where the arm allows it, numeric where it does not.
///
/// Postures are joint vectors in the order of [`Arm::dofs`], as long as that list.
#[derive(Clone, Debug)]
pub struct ArmIk {
    kind: Kind,
    chain: Chain,
}

#[derive(Clone, Debug)]
enum Kind {
    /// Seven joints in closed form.
    Srs(Box<SrsArm>),
    /// Six joints in closed form.
    Six(Box<SixArm>),
    /// Joints that are sampled, then seven in closed form.
    Led(Box<LedArm>),
    /// Step by step.
    Numeric { arm: Box<NumericArm>, because: NotSrs },
}

/// How an arm is solved.
#[derive(Clone, Debug, PartialEq)]
pub enum IkMethod {
    /// Closed form over the arm angle.
    ClosedForm,
    /// Closed form of six joints: ball, hinge, two axes that meet.
    ClosedForm6,
    /// The first joints at a number of positions each, the other seven in closed form.
    Sampled { joints: usize, samples: usize },
    /// Damped least squares from many starts, because the arm is not of the S-R-S kind.
    Numeric { because: NotSrs },
}

impl fmt::Display for IkMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ClosedForm => write!(f, "closed form (S-R-S)"),
            Self::ClosedForm6 => write!(f, "closed form (six joints)"),
            Self::Sampled { joints: 1, samples } => {
                write!(f, "closed form (S-R-S), first joint at {samples} positions")
            }
            Self::Sampled { joints, samples } => {
                write!(f, "closed form (S-R-S), first {joints} joints at {samples} positions each")
            }
            Self::Numeric { because } => write!(f, "numeric, since the arm is not S-R-S: {because}"),
        }
    }
}

/// Postures of one hand pose, and why there are no more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Postures {
    dofs: usize,
    values: Vec<f64>,
    /// One reason for each branch that is no solution, or one for the whole pose.
    pub rejected: Vec<IkReject>,
}

impl Postures {
    /// The postures, each with one value per joint of the arm, within the limits.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.dofs.max(1))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.iter().len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
}

impl ArmIk {
    /// The arm with its hand frame H as the tip.
    ///
    /// # Errors
    /// [`ChainError`] when the joints of the arm are not those that move its hand.
    pub fn of(robot: &Robot, arm: &Arm) -> Result<Self, ChainError> {
        let chain = Chain::between(robot, arm.base_link, arm.hand.tcp_link)?;
        let one_sided = |a: &[usize], b: &[usize]| a.iter().find(|dof| !b.contains(dof)).copied();
        if let Some(dof) = one_sided(&arm.dofs, chain.dofs()).or_else(|| one_sided(chain.dofs(), &arm.dofs)) {
            let joint = robot.joints[robot.dof_joints[dof]].name.clone();
            let tip = robot.links[arm.hand.tcp_link].name.clone();
            return Err(ChainError::OtherJoints { arm: arm.name.clone(), joint, tip });
        }
        Ok(Self::solving(robot, chain, arm.base_link, arm.hand.tcp_link))
    }

    /// All joints between two links; the tip's frame is the hand frame H, the base's frame is B.
    ///
    /// # Errors
    /// [`ChainError`] when the tip does not descend from the base or nothing moves between them.
    pub fn between(robot: &Robot, base_link: usize, tip_link: usize) -> Result<Self, ChainError> {
        Ok(Self::solving(robot, Chain::between(robot, base_link, tip_link)?, base_link, tip_link))
    }

    fn solving(robot: &Robot, chain: Chain, base_link: usize, tip_link: usize) -> Self {
        let kind = match SrsArm::between(robot, base_link, tip_link) {
            Ok(srs) => Kind::Srs(Box::new(srs)),
            Err(because) => {
                match (LedArm::between(robot, base_link, tip_link), SixArm::between(robot, base_link, tip_link)) {
                    (Ok(led), _) => Kind::Led(Box::new(led)),
                    (_, Some(six)) => Kind::Six(Box::new(six)),
                    (Err(seven), None) => Kind::Numeric {
                        arm: Box::new(NumericArm::new(robot, chain.clone())),
                        because: seven.unwrap_or(because),
                    },
                }
            }
        };
        Self { kind, chain }
    }

    /// The same with another number of positions for each joint before an S-R-S arm, besides the present one.
    pub fn with_samples(mut self, count: usize) -> Self {
        if let Kind::Led(led) = &mut self.kind {
            led.samples = count;
        }
        self
    }

    /// The same with another seed of the numeric starts.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.kind = match self.kind {
            Kind::Numeric { arm, because } => Kind::Numeric { arm: Box::new(arm.with_seed(seed)), because },
            other => other,
        };
        self
    }

    /// How the arm is solved.
    pub fn method(&self) -> IkMethod {
        match &self.kind {
            Kind::Srs(_) => IkMethod::ClosedForm,
            Kind::Six(_) => IkMethod::ClosedForm6,
            Kind::Led(led) => IkMethod::Sampled { joints: led.extra_joints(), samples: led.samples + 1 },
            Kind::Numeric { because, .. } => IkMethod::Numeric { because: because.clone() },
        }
    }

    /// The arm itself when its seven joints are solved in closed form, without extra joints.
    pub fn closed_form(&self) -> Option<&SrsArm> {
        if let Kind::Srs(srs) = &self.kind { Some(srs) } else { None }
    }

    /// The joints from the base link to the hand.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Limits of the joints.
    pub fn limits(&self) -> &[JointLimit] {
        self.chain.limits()
    }

    /// Postures that bring the hand to a pose.
    ///
    /// * `X_BH`: hand frame H in the frame B of the arm's base link.
    /// * `q_now`: the present joints; extra joints stand there first, numeric descents start there first.
    /// * `arm_angles`: arm angles over a full turn at which all branches are solved; starts of a numeric arm. An arm of
    ///   six joints has none: all its branches are answered.
    pub fn set(&self, X_BH: &Isometry3<f64>, q_now: &[f64], arm_angles: usize) -> Postures {
        let mut postures = Postures { dofs: self.limits().len(), ..Postures::default() };
        match &self.kind {
            Kind::Srs(srs) => {
                let mut found = IkSet::default();
                found.solutions.reserve(8 * arm_angles);
                srs.sweep_into(X_BH, arm_angles, &mut found);
                postures.values.reserve_exact(7 * found.solutions.len());
                found.solutions.iter().for_each(|solution| postures.values.extend(solution.q));
                postures.rejected = found.rejected;
            }
            Kind::Six(six) => six.solve(X_BH, q_now, &mut postures.values, &mut postures.rejected),
            Kind::Led(led) => led.set(X_BH, q_now, arm_angles, &mut postures.values, &mut postures.rejected),
            Kind::Numeric { arm, .. } => {
                let values = &mut postures.values;
                postures.rejected.extend(arm.set(X_BH, q_now, arm_angles, |q| values.extend(q)).err());
            }
        }
        postures
    }

    /// One posture that brings the hand to a pose, or the reason why none was found.
    ///
    /// # Errors
    /// [`IkReject`]: of all branches the most frequent reason.
    pub fn first(&self, X_BH: &Isometry3<f64>, q_now: &[f64]) -> Result<Vec<f64>, IkReject> {
        match &self.kind {
            Kind::Srs(srs) => srs.first(X_BH).map(|q| q.to_vec()),
            Kind::Six(six) => six.first(X_BH, q_now),
            Kind::Led(led) => led.first(X_BH, q_now),
            Kind::Numeric { arm, .. } => arm.first(X_BH, q_now),
        }
    }

    /// The posture for a hand pose that is nearest to another one, for straight ways: extra joints stay where they are.
    pub fn near(&self, X_BH: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>> {
        match &self.kind {
            Kind::Srs(srs) => Some(srs.near(X_BH, near.try_into().ok()?)?.to_vec()),
            Kind::Six(six) => six.near(X_BH, near),
            Kind::Led(led) => led.near(X_BH, near),
            Kind::Numeric { arm, .. } => arm.near(X_BH, near),
        }
    }

    /// Distance by which a pose misses the reach of the arm, metres; 0 when it is within. Extra joints stand at `q_now`
    /// or one of their samples; of a numeric arm it is the length that even all its segments in one line do not have.
    pub fn reach_gap_m(&self, X_BH: &Isometry3<f64>, q_now: &[f64]) -> f64 {
        match &self.kind {
            Kind::Srs(srs) => srs.reach_gap_m(X_BH),
            Kind::Six(six) => six.reach_gap_m(X_BH),
            Kind::Led(led) => led.reach_gap_m(X_BH, q_now),
            Kind::Numeric { arm, .. } => arm.reach_gap_m(X_BH),
        }
    }
}

impl SrsArm {
    /// A solution, or the most frequent reason why there is none.
    pub(super) fn first(&self, X_BH: &Isometry3<f64>) -> Result<[f64; 7], IkReject> {
        let mut found = IkSet::default();
        for arm_angle in FIRST_ANGLES {
            self.solve_into(X_BH, arm_angle, &mut found);
            // A pose out of reach is so at every arm angle.
            if !found.solutions.is_empty() || self.reach_gap_m(X_BH) > 0.0 {
                break;
            }
        }
        if found.solutions.is_empty() {
            // Then in the middle of the widest arc that the limits allow, which has one if there is any.
            let arcs = self.feasible_arcs(X_BH);
            match arcs.iter().max_by(|l, r| (l.to - l.from).total_cmp(&(r.to - r.from))) {
                Some(widest) => self.solve_into(X_BH, 0.5 * (widest.from + widest.to), &mut found),
                None => {
                    found.clear();
                    self.sweep_into(X_BH, REASON_ANGLES, &mut found);
                }
            }
        }
        found.solutions.first().map_or_else(|| Err(most_frequent(&found.rejected)), |solution| Ok(solution.q))
    }
}

/// The reason that occurs most often, the first of equals.
pub(super) fn most_frequent(rejected: &[IkReject]) -> IkReject {
    let same = |l: &IkReject, r: &IkReject| match (l, r) {
        (IkReject::JointLimit { joint: l, .. }, IkReject::JointLimit { joint: r, .. }) => l == r,
        _ => std::mem::discriminant(l) == std::mem::discriminant(r),
    };
    let mut counts: Vec<(IkReject, usize)> = Vec::new();
    for reject in rejected {
        match counts.iter_mut().find(|(known, _)| same(known, reject)) {
            Some((_, count)) => *count += 1,
            None => counts.push((*reject, 1)),
        }
    }
    // The last of equal maxima is taken, hence the reversed order.
    let most = counts.into_iter().rev().max_by_key(|(_, count)| *count);
    most.map_or(IkReject::Stalled { gap_m: f64::INFINITY, gap_rad: f64::INFINITY }, |(reject, _)| reject)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::rng::Rng;
    use crate::robot::{read_urdf, samples};

    /// A chain of hinges: origin and axis of each joint, limits ±`limit`, and the length of the tool.
    fn hinges(joints: &[([f64; 3], [f64; 3])], limit: f64, tool: [f64; 3]) -> Robot {
        let mut urdf = String::from("<robot name='hinges'><link name='l0'/><link name='tip'/>");
        let text = |v: &[f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
        for (i, (origin, axis)) in joints.iter().enumerate() {
            urdf += &format!(
                "<link name='l{n}'/><joint name='j{n}' type='revolute'><parent link='l{i}'/><child link='l{n}'/>\
                 <origin xyz='{}'/><axis xyz='{}'/><limit lower='-{limit}' upper='{limit}' velocity='1'/></joint>",
                text(origin),
                text(axis),
                n = i + 1,
            );
        }
        urdf += &format!(
            "<joint name='tool' type='fixed'><parent link='l{}'/><child link='tip'/><origin xyz='{}'/></joint></robot>",
            joints.len(),
            text(&tool),
        );
        read_urdf(&urdf, &|_| None).unwrap().value
    }

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    /// Six joints with the offsets of a common light arm: no ball at the wrist.
    fn six(limit: f64) -> Robot {
        let joints = [
            ([0.0, 0.0, 0.09], Z),
            ([0.0, 0.136, 0.0], Y),
            ([0.0, -0.12, 0.425], Y),
            ([0.0, 0.0, 0.392], Y),
            ([0.0, 0.093, 0.0], Z),
            ([0.0, 0.0, 0.095], Y),
        ];
        hinges(&joints, limit, [0.0, 0.082, 0.0])
    }

    /// Seven joints, the elbow's axis 5 cm beside the line of the segments.
    fn offset_elbow() -> Robot {
        let joints = [
            ([0.0, 0.0, 0.3], Z),
            ([0.0, 0.0, 0.0], Y),
            ([0.0, 0.0, 0.3], Z),
            ([0.05, 0.0, 0.0], Y),
            ([-0.05, 0.0, 0.3], Z),
            ([0.0, 0.0, 0.0], Y),
            ([0.0, 0.0, 0.1], X),
        ];
        hinges(&joints, 2.4, [0.0, 0.0, 0.1])
    }

    fn arms() -> Vec<(&'static str, ArmIk, Chain)> {
        let mut arms = Vec::new();
        let mut add = |name, robot: &Robot, base, tip| {
            arms.push((name, ArmIk::between(robot, base, tip).unwrap(), Chain::between(robot, base, tip).unwrap()));
        };
        let crichton = samples::crichton();
        let left = &crichton.arms[0];
        add("crichton", &crichton, left.base_link, left.hand.tcp_link);
        add("torso", &crichton, crichton.arm_with_torso(left).base_link, left.hand.tcp_link);
        for (name, robot) in [("six", six(3.1)), ("offset elbow", offset_elbow())] {
            let tip = robot.link_index("tip").unwrap();
            add(name, &robot, 0, tip);
        }
        arms
    }

    fn random(ik: &ArmIk, rng: &mut Rng) -> Vec<f64> {
        ik.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect()
    }

    fn assert_reaches(name: &str, ik: &ArmIk, chain: &Chain, q: &[f64], X_BH: &Isometry3<f64>) {
        let found = chain.tip(q);
        let off_m = (found.translation.vector - X_BH.translation.vector).norm();
        let off_rad = 2.0 * found.rotation.rotation_to(&X_BH.rotation).imag().norm();
        assert!(off_m < 1e-9 && off_rad < 1e-9, "{name}: {off_m} m, {off_rad} rad at {q:?}");
        assert_eq!(q.len(), ik.limits().len());
        for (value, limit) in q.iter().zip(ik.limits()) {
            assert!((limit.lower..=limit.upper).contains(value), "{name}: {q:?}");
        }
    }

    #[test]
    fn every_kind_of_arm_answers_alike() {
        for (name, ik, chain) in arms() {
            let mut rng = Rng::new(21, 0);
            let mut missed = 0;
            for _ in 0..200 {
                let q = random(&ik, &mut rng);
                let X_BH = chain.tip(&q);
                assert_eq!(ik.reach_gap_m(&X_BH, &q), 0.0, "{name}");
                let set = ik.set(&X_BH, &q, 12);
                assert!(!set.is_empty(), "{name}: the posture itself is an answer: {q:?}, {:?}", set.rejected);
                set.iter().for_each(|found| assert_reaches(name, &ik, &chain, found, &X_BH));
                let near = ik.near(&X_BH, &q).expect("the posture itself is near");
                assert_reaches(name, &ik, &chain, &near, &X_BH);
                assert!(near.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-5), "{name}: {near:?} for {q:?}");
                // From a posture that knows nothing of the answer.
                match ik.first(&X_BH, &vec![0.1; q.len()]) {
                    Ok(first) => assert_reaches(name, &ik, &chain, &first, &X_BH),
                    Err(_) => missed += 1,
                }
            }
            // Six positions of the torso may all lie beside a narrow range.
            let allowed = if matches!(ik.method(), IkMethod::Sampled { .. }) { 20 } else { 0 };
            assert!(missed <= allowed, "{name}: {missed} of 200 poses missed");
        }
    }

    #[test]
    fn the_method_follows_from_the_arm() {
        let methods: Vec<String> = arms().iter().map(|(_, ik, _)| ik.method().to_string()).collect();
        assert_eq!(methods[0], "closed form (S-R-S)");
        assert_eq!(methods[1], "closed form (S-R-S), first joint at 6 positions");
        assert!(methods[2].starts_with("numeric, since the arm is not S-R-S: 6 joints between"), "{}", methods[2]);
        assert!(methods[3].contains("miss each other"), "{}", methods[3]);
    }

    #[test]
    fn a_torso_stands_still_first_and_is_sampled_within_its_limits() {
        let (_, ik, chain) = arms().swap_remove(1);
        let q = [0.3, 0.5, -0.7, 0.4, -1.2, 0.2, 0.9, 0.3];
        let set = ik.clone().with_samples(4).set(&chain.tip(&q), &q, 24);
        let mut stands: Vec<f64> = set.iter().map(|q| q[0]).collect();
        stands.dedup();
        assert_eq!(stands[0], 0.3);
        assert!(stands.len() > 1 && stands.len() <= 5, "{stands:?}");
        let alone = ik.with_samples(0).set(&chain.tip(&q), &q, 24);
        assert!(!alone.is_empty() && alone.iter().all(|q| q[0] == 0.3));
    }

    #[test]
    fn reasons_name_the_gap_or_the_joint() {
        for (name, ik, chain) in arms() {
            let q_now = vec![0.1; ik.limits().len()];
            let mut far = chain.tip(&q_now);
            far.translation.vector = Vector3::new(0.0, 0.0, 5.0);
            let set = ik.set(&far, &q_now, 8);
            assert!(set.is_empty() && set.rejected.len() == 1, "{name}: {:?}", set.rejected);
            let text = ik.first(&far, &q_now).unwrap_err().to_string();
            assert!(text.starts_with("out of reach by ") && text.ends_with(" cm"), "{name}: {text}");
        }
        // Straight up and 4 cm beyond what six joints in the needed rotation can do, still within the sum of segments.
        let robot = six(3.1);
        let ik = ArmIk::between(&robot, 0, robot.link_index("tip").unwrap()).unwrap();
        let chain = Chain::between(&robot, 0, robot.link_index("tip").unwrap()).unwrap();
        let mut X_BH = chain.tip(&[0.0; 6]);
        X_BH.translation.vector.z += 0.04;
        assert_eq!(ik.reach_gap_m(&X_BH, &[0.0; 6]), 0.0);
        assert_eq!(ik.first(&X_BH, &[0.1; 6]).unwrap_err().to_string(), "out of reach by 4 cm");

        // A planar arm, folded further than its second joint allows.
        let planar = |limit| hinges(&[([0.0; 3], Z), ([0.5, 0.0, 0.0], Z)], limit, [0.5, 0.0, 0.0]);
        let tip = planar(1.0).link_index("tip").unwrap();
        let free = Chain::between(&planar(3.1), 0, tip).unwrap();
        let ik = ArmIk::between(&planar(2.0), 0, tip).unwrap();
        match ik.first(&free.tip(&[0.3, 2.5]), &[0.0; 2]).unwrap_err() {
            IkReject::JointLimit { joint: 1, value, .. } => assert!((value - 2.5).abs() < 1e-6, "{value}"),
            other => panic!("{other}"),
        }
    }

    #[test]
    fn numeric_answers_repeat_and_differ_from_each_other() {
        let (_, ik, chain) = arms().swap_remove(2);
        let X_BH = chain.tip(&[0.4, -0.8, 1.1, 0.5, 0.9, -0.3]);
        let set = ik.set(&X_BH, &[0.0; 6], 64);
        assert_eq!(set, ik.set(&X_BH, &[0.0; 6], 64));
        // Shoulder, elbow and wrist: up to eight postures, here at least four within the limits.
        assert!((4..=16).contains(&set.len()), "{}", set.len());
        let found: Vec<&[f64]> = set.iter().collect();
        for (i, one) in found.iter().enumerate() {
            for other in &found[i + 1..] {
                assert!(one.iter().zip(*other).any(|(a, b)| (a - b).abs() > 1e-4));
            }
        }
    }

    #[test]
    fn joints_that_are_not_the_arm_s_are_refused() {
        let robot = samples::crichton();
        let mut arm = robot.arms[0].clone();
        arm.dofs.remove(2);
        let error = ArmIk::of(&robot, &arm).unwrap_err().to_string();
        assert!(error.contains("left_joint_3"), "{error}");
        let longer = robot.with_torso(0);
        let ik = ArmIk::of(&longer, &longer.arms[0]).unwrap();
        assert_eq!(ik.chain().joint_names()[0], "torso_joint");
        assert_eq!(ik.limits().len(), 8);
    }
}
