//! Which arm angles are worth solving: how freely the arm moves at each, before any joint is computed.
//!
//! With the shoulder S as the origin, u = SE/|SE|, v = EW/|EW|, and the axes 1 and 7 fixed by base and hand, the
//! Jacobian of an S-R-S arm is `[A N; 0 M]`: the shoulder's axes A have no moment about S. By Cauchy and Binet
//! (6 of 7 columns at a time), with W the wrist seen from S,
//!
//! `det J Jᵀ = |SE × SW|² ( sin²q2 Σ (W · aᵢ × aⱼ)² + sin²q6 Σ (W · aₖ × aₗ)² )`,
//!
//! the first sum over pairs of the wrist's axes, the second over pairs of the shoulder's. All branches of an arm angle
//! have their axes in the same lines, and every term is `a + b cos ψ + c sin ψ` in the arm angle ψ.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Vector3};

use super::ball::Ball;
use super::solve::Posed;
use super::{IkSet, SrsArm};
use crate::math;
use crate::simd::{Kernel, widest};

/// Arm angles over the full turn from -π, as in [`SrsArm::sweep`].
pub(crate) const GLANCES: usize = 32;
/// Round-off of a cosine, generously.
const SLACK: f64 = 1e-9;
/// Least squared sine of a ball's bend that is divided by.
const ALIGNED: f64 = 1e-12;

/// One number for each arm angle.
type Turn = [f64; GLANCES];

/// Looks at an arm at evenly spread arm angles.
#[derive(Clone, Debug)]
pub(crate) struct Glancer {
    arm: SrsArm,
    cos: Turn,
    sin: Turn,
    /// Cosines of the bend that the middle joint's limits allow, least and greatest.
    shoulder: [f64; 2],
    wrist: [f64; 2],
}

/// A pose of the hand that the arm is long enough for.
pub(crate) struct Glance {
    posed: Posed,
    /// Manipulability (5.1) at each arm angle; -1 where the middle joint of a ball is beyond its limits.
    pub(crate) manipulability: Turn,
}

/// `a + b cos ψ + c sin ψ`.
#[derive(Clone, Copy)]
struct Wave {
    a: f64,
    b: f64,
    c: f64,
}

impl Glancer {
    pub(crate) fn new(arm: &SrsArm) -> Self {
        let angles: Turn = std::array::from_fn(arm_angle_rad);
        Self {
            arm: arm.clone(),
            cos: angles.map(math::cos),
            sin: angles.map(math::sin),
            shoulder: arm.bends(&arm.shoulder, 1),
            wrist: arm.bends(&arm.wrist, 5),
        }
    }

    /// `None` when the pose is out of reach or bends the elbow beyond its limits.
    pub(crate) fn glance(&self, X_BH: &Isometry3<f64>) -> Option<Glance> {
        let arm = &self.arm;
        let posed = arm.pose(X_BH).ok()?;
        let mut elbows = posed.elbows.iter().flatten();
        if !elbows.any(|elbow| arm.within(3, elbow.q4).is_ok()) {
            return None;
        }
        let elbow = posed.elbows[0].as_ref()?;
        // E and W along SW, along the elbow's axis, and across both.
        let e = elbow.frame * arm.v_SE;
        let d = (elbow.frame * (arm.v_SE + elbow.bend * arm.v_EW)).x;
        let e = e / arm.upper_m;
        // `g · u` over the arm angles.
        let wave = |g: &Vector3<f64>| {
            let (along, across, up) = (g.dot(&posed.t), g.dot(&posed.normal), g.dot(&posed.quarter));
            Wave { a: along * e.x, b: across * e.y + up * e.z, c: up * e.y - across * e.z }
        };
        let (a1, a7) = (arm.shoulder.a1, posed.turned * arm.wrist.a3);
        let W = posed.t * d;
        let mut manipulability = [0.0; GLANCES];
        let sides = (arm.shoulder.a3.dot(&arm.v_SE), arm.wrist.a1.dot(&arm.v_EW));
        widest(Look {
            glancer: self,
            first: wave(&a1),
            first_moment: wave(&W.cross(&a1)),
            last: wave(&a7),
            last_moment: wave(&W.cross(&a7)),
            on_first: [W.dot(&a1), d * e.x],
            on_last: [W.dot(&a7), (d * d - d * arm.upper_m * e.x) / arm.fore_m],
            area2: (e.y * e.y + e.z * e.z) * arm.upper_m * arm.upper_m * d * d,
            signs: [1.0_f64.copysign(sides.0), 1.0_f64.copysign(sides.1)],
            out: &mut manipulability,
        });
        Some(Glance { posed, manipulability })
    }

    /// All branches within the limits at one of the arm angles, appended.
    pub(crate) fn solve_into(&self, glance: &Glance, step: usize, set: &mut IkSet) {
        self.arm.solve_posed(&glance.posed, arm_angle_rad(step), set);
    }
}

/// Arm angle of a step.
pub(crate) fn arm_angle_rad(step: usize) -> f64 {
    TAU * step as f64 / GLANCES as f64 - PI
}

impl SrsArm {
    /// Between which cosines the bend of a ball lies when its middle joint is within its limits, in either branch.
    fn bends(&self, ball: &Ball, middle: usize) -> [f64; 2] {
        let (lower, upper) = (self.limits[middle].lower + ball.bend0, self.limits[middle].upper + ball.bend0);
        let (mut least, mut most) = (PI, 0.0_f64);
        for (from, to) in [(lower, upper), (-upper, -lower)] {
            for turn in [-TAU, 0.0, TAU] {
                let (from, to) = ((from + turn).max(0.0), (to + turn).min(PI));
                if from <= to {
                    (least, most) = (least.min(from), most.max(to));
                }
            }
        }
        [math::cos(most) - SLACK, math::cos(least) + SLACK]
    }
}

/// What is known of a pose when its arm angles are looked at side by side.
struct Look<'a> {
    glancer: &'a Glancer,
    /// `a₁ · u` and `W × a₁ · u`.
    first: Wave,
    first_moment: Wave,
    /// `a₇ · u` and `W × a₇ · u`.
    last: Wave,
    last_moment: Wave,
    /// `W · a₁`, `W · u`.
    on_first: [f64; 2],
    /// `W · a₇`, `W · v`.
    on_last: [f64; 2],
    /// `|SE × SW|²`.
    area2: f64,
    /// Whether axis 3 goes from S to E, and axis 5 from E to W: 1 or -1.
    signs: [f64; 2],
    out: &'a mut Turn,
}

impl Kernel for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Glancer { arm, cos, sin, shoulder, wrist } = self.glancer;
        let (upper, fore) = (arm.upper_m, arm.fore_m);
        for k in 0..GLANCES {
            let at = |wave: &Wave| wave.a + wave.b * cos[k] + wave.c * sin[k];
            let c2 = at(&self.first);
            let c6 = (self.on_last[0] - upper * at(&self.last)) / fore;
            let first_moment = at(&self.first_moment);
            let last_moment = at(&self.last_moment) * (upper / fore);
            let (s2, s6) = (1.0 - c2 * c2, 1.0 - c6 * c6);
            let sum = |[p, r]: [f64; 2], c: f64, s: f64, moment: f64| {
                let (one, other) = (p * c - r, r * c - p);
                (one * one + other * other) / s.max(ALIGNED) + moment * moment
            };
            let of_shoulder = sum(self.on_first, c2, s2, first_moment);
            let of_wrist = sum(self.on_last, c6, s6, last_moment);
            let determinant = self.area2 * (s2 * of_wrist + s6 * of_shoulder);
            let (bend2, bend6) = (c2 * self.signs[0], c6 * self.signs[1]);
            let allowed = bend2 >= shoulder[0] && bend2 <= shoulder[1] && bend6 >= wrist[0] && bend6 <= wrist[1];
            self.out[k] = if allowed { determinant.max(0.0).sqrt() } else { -1.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::robot::{Chain, Dexterity, samples};

    #[test]
    fn a_glance_knows_the_manipulability_of_every_solution() {
        for robot in [samples::crichton(), samples::alita()] {
            for arm in &robot.arms {
                let srs = SrsArm::of(&robot, arm).unwrap();
                let chain = Chain::between(&robot, arm.base_link, arm.hand.tcp_link).unwrap();
                let mut dexterity = Dexterity::new(&chain);
                let glancer = Glancer::new(&srs);
                let mut rng = Rng::new(11, 0);
                let (mut looked, mut solved) = (0, 0);
                for _ in 0..300 {
                    let q: Vec<f64> = srs.limits().iter().map(|l| rng.uniform(l.lower, l.upper)).collect();
                    let X_BH = chain.tip(&q);
                    let glance = glancer.glance(&X_BH).unwrap();
                    for step in 0..GLANCES {
                        let mut set = IkSet::default();
                        glancer.solve_into(&glance, step, &mut set);
                        assert_eq!(set, srs.solve(&X_BH, arm_angle_rad(step)));
                        looked += usize::from(glance.manipulability[step] >= 0.0);
                        solved += usize::from(!set.solutions.is_empty());
                        for solution in &set.solutions {
                            let wanted = dexterity.at(&solution.q).manipulability;
                            let found = glance.manipulability[step];
                            // The determinant of the judge loses half of the digits near a singular posture.
                            assert!((found - wanted).abs() < 1e-9 + 1e-15 / wanted.max(1e-9), "{found} {wanted}");
                        }
                    }
                }
                assert!(solved > 2_000 && solved as f64 > 0.9 * looked as f64, "{solved} {looked}");
                let far = Isometry3::translation(3.0, 0.0, 0.0);
                assert!(glancer.glance(&far).is_none());
            }
        }
    }
}
