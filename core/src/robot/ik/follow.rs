//! A hand that is led by hand: where the arm goes when somebody drags its target about.

use nalgebra::Isometry3;

use super::numeric::NumericArm;
use super::{ArmIk, IkReject};
use crate::robot::Robot;

/// A posture whose joints are all this near to the present one is a continuation of it, radians or metres.
const CONTINUES: f64 = 0.8;
/// Arm angles over a full turn that are looked through where no continuation is found.
const ANGLES: usize = 72;

/// Where an arm goes for a pose of its hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// The joints, within their limits.
    pub q: Vec<f64>,
    /// Why the hand stays short of the pose; `None` if it is there.
    pub short: Option<IkReject>,
}

impl ArmIk {
    /// The posture for a hand that is led somewhere: the one that continues the present posture, else the nearest of all.
    /// Where the pose cannot be had the arm still goes after it, as near as a descent within the limits gets
    /// (damped least squares, Wampler 1986), and tells why it stays short.
    ///
    /// * `robot`: the robot that the arm is of.
    /// * `X_BH`: hand frame H in the frame B of the arm's base link.
    /// * `q_now`: the present joints, in the order of [`crate::robot::Arm::dofs`].
    pub fn follow(&self, robot: &Robot, X_BH: &Isometry3<f64>, q_now: &[f64]) -> Followed {
        let farthest = |q: &[f64]| q.iter().zip(q_now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let beside = self.near(X_BH, q_now);
        if let Some(q) = beside.as_ref().filter(|q| farthest(q) <= CONTINUES) {
            return Followed { q: q.clone(), short: None };
        }
        let found = self.set(X_BH, q_now, ANGLES);
        let all = found.iter().map(<[f64]>::to_vec).chain(beside);
        if let Some(q) = all.min_by(|l, r| farthest(l).total_cmp(&farthest(r))) {
            return Followed { q, short: None };
        }
        let short = self.first(X_BH, q_now).err();
        let q = NumericArm::new(robot, self.chain().clone()).towards(X_BH, q_now);
        Followed { q, short }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, Vector3};

    use super::*;
    use crate::rng::Rng;
    use crate::robot::samples;

    #[test]
    fn a_hand_that_is_led_gently_is_followed_without_a_leap() {
        for robot in [samples::alita(), samples::crichton()] {
            for arm in &robot.arms {
                let ik = ArmIk::of(&robot, arm).unwrap();
                let mut q = robot.posture("table_ready").unwrap().to_vec();
                let now = |q: &[f64]| arm.dofs.iter().map(|&dof| q[dof]).collect::<Vec<f64>>();
                let hand = |q: &[f64]| {
                    let X_WL = robot.link_poses(q);
                    (X_WL[arm.base_link], X_WL[arm.hand.tcp_link])
                };
                let (_, start) = hand(&q);
                for step in 1..=40 {
                    let (X_WB, X_WH) = hand(&q);
                    let wanted = Translation3::new(0.0, 0.0, 0.003) * X_WH;
                    let before = now(&q);
                    let led = ik.follow(&robot, &X_WB.inv_mul(&wanted), &before);
                    assert_eq!(led.short, None, "{} {} step {step}", robot.name, arm.name);
                    let leap = led.q.iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    assert!(leap < 0.1, "{} {} step {step}: {leap} rad", robot.name, arm.name);
                    arm.dofs.iter().zip(&led.q).for_each(|(&dof, value)| q[dof] = *value);
                }
                let risen = hand(&q).1.translation.vector.z - start.translation.vector.z;
                assert!((risen - 0.12).abs() < 1e-6, "{risen} m");
            }
        }
    }

    #[test]
    fn an_arm_goes_after_what_it_cannot_reach_and_says_why_it_stays_short() {
        let robot = samples::alita();
        let arm = &robot.arms[0];
        let ik = ArmIk::of(&robot, arm).unwrap();
        let q = robot.posture("table_ready").unwrap().to_vec();
        let q_now: Vec<f64> = arm.dofs.iter().map(|&dof| q[dof]).collect();
        let X_BH = ik.chain().tip(&q_now);
        let shoulder = ik.chain().origin();
        let mut rng = Rng::new(7, 0);
        for _ in 0..20 {
            let away = Vector3::new(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
            let Some(away) = away.try_normalize(1e-3) else { continue };
            let wanted = Isometry3::from_parts((shoulder + 2.0 * away).into(), X_BH.rotation);
            let led = ik.follow(&robot, &wanted, &q_now);
            assert!(matches!(led.short, Some(IkReject::OutOfReach { .. })), "{:?}", led.short);
            let gap = |q: &[f64]| (ik.chain().tip(q).translation.vector - wanted.translation.vector).norm();
            assert!(gap(&led.q) < gap(&q_now), "{} m before, {} m after", gap(&q_now), gap(&led.q));
            let within = |(q, limit): (&f64, &crate::robot::JointLimit)| *q >= limit.lower && *q <= limit.upper;
            assert!(led.q.iter().zip(ik.limits()).all(within));
        }
    }
}
