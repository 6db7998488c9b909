//! How comfortable a receiver's arm is at the handover.
//!
//! The posture is judged as an observer with a protractor would (RULA, McAtamney and Corlett 1993): by the angles between
//! upper arm, forearm, hand and torso, and by where the hand is. They are taken from the places of shoulder, elbow and
//! wrist, not from joint values, so one judgement serves the person and any arm that is built like one, such as Hubo's:
//! for the person's arm the angles *are* the joint values (a test checks it), and an arm that lacks a joint simply never
//! leaves the band of that angle by itself.
//!
//! Each term is 0 within its comfortable band and grows evenly to 1 at the anatomical limit. Angles beyond 90° of abduction
//! are told as flexion beyond 90°: both mean a raised arm.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::math;
use crate::robot::{Arm, Joint, Robot};

/// A comfortable range within what anatomy allows, both in the same unit.
struct Band {
    comfortable: [f64; 2],
    limit: [f64; 2],
}

impl Band {
    const fn degrees(comfortable: [f64; 2], limit: [f64; 2]) -> Self {
        const DEGREE: f64 = PI / 180.0;
        Self {
            comfortable: [comfortable[0] * DEGREE, comfortable[1] * DEGREE],
            limit: [limit[0] * DEGREE, limit[1] * DEGREE],
        }
    }

    /// 0 within the band, growing evenly to 1 at the limit and beyond.
    fn cost(&self, value: f64) -> f64 {
        let below = (self.comfortable[0] - value) / (self.comfortable[0] - self.limit[0]);
        let above = (value - self.comfortable[1]) / (self.limit[1] - self.comfortable[1]);
        below.max(above).max(0.0).min(1.0)
    }
}

// Limits: American Academy of Orthopaedic Surgeons. Bands: estimates after the scores of RULA.
/// Comfortable 0° to 45°, best -20° to 20°.
const FLEXION: Band = Band::degrees([-20.0, 45.0], [-60.0, 180.0]);
/// The table has no limit across the body; the arm of our person has 30°.
const ABDUCTION: Band = Band::degrees([0.0, 30.0], [-30.0, 180.0]);
const ROTATION: Band = Band::degrees([-30.0, 30.0], [-90.0, 70.0]);
const ELBOW: Band = Band::degrees([60.0, 100.0], [0.0, 150.0]);
const PRONATION: Band = Band::degrees([-45.0, 45.0], [-80.0, 80.0]);
const WRIST_FLEXION: Band = Band::degrees([-15.0, 15.0], [-70.0, 80.0]);
const WRIST_DEVIATION: Band = Band::degrees([-10.0, 10.0], [-30.0, 20.0]);
/// Distance from the shoulder to the grip as a share of the stretched arm; with the elbow at 90° it is 0.71.
const DISTANCE: Band = Band { comfortable: [0.45, 0.80], limit: [0.15, 1.0] };
/// How far the grip is on the side of its arm, in half shoulder widths: 0 is the middle of the body, -1 below the other
/// shoulder. Too far outwards is for the distance and the shoulder to say.
const SIDE: Band = Band { comfortable: [0.0, f64::MAX], limit: [-1.0, f64::INFINITY] };
/// Height of the grip above the shoulder, in arm lengths, when it is above; below the hanging elbow, when it is below.
const HEIGHT_ABOVE: Band = Band { comfortable: [-1.0, 0.0], limit: [-2.0, 1.0] };

/// Shares of the terms in the total: shoulder and height weigh most, since a raised arm tires first (estimates).
const WEIGHTS: Comfort =
    Comfort { shoulder: 0.25, elbow: 0.15, wrist: 0.15, distance: 0.15, side: 0.10, height: 0.20, total: 1.0 };

/// What a posture costs a receiver; every term in [0, 1], 0 is comfortable and 1 is at the limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Comfort {
    /// The worst of flexion, abduction and rotation of the upper arm.
    pub shoulder: f64,
    /// Flexion of the elbow; 60° to 100° are comfortable.
    pub elbow: f64,
    /// The worst of the turn of the forearm, and flexion and deviation of the wrist.
    pub wrist: f64,
    /// The grip too far from the shoulder, or too near to it.
    pub distance: f64,
    /// The grip beyond the middle of the body, on the other arm's side.
    pub side: f64,
    /// The grip above the shoulder or below the hanging elbow, which is at the height of the waist.
    pub height: f64,
    /// All terms, weighted.
    pub total: f64,
}

impl Comfort {
    fn weighted(mut self) -> Self {
        self.total = WEIGHTS.shoulder * self.shoulder
            + WEIGHTS.elbow * self.elbow
            + WEIGHTS.wrist * self.wrist
            + WEIGHTS.distance * self.distance
            + WEIGHTS.side * self.side
            + WEIGHTS.height * self.height;
        self
    }

    /// The terms with their names and their shares of the total, for tables and bars.
    pub fn terms(&self) -> [(&'static str, f64, f64); 6] {
        [
            ("shoulder", self.shoulder, WEIGHTS.shoulder),
            ("elbow", self.elbow, WEIGHTS.elbow),
            ("wrist", self.wrist, WEIGHTS.wrist),
            ("distance", self.distance, WEIGHTS.distance),
            ("side", self.side, WEIGHTS.side),
            ("height", self.height, WEIGHTS.height),
        ]
    }
}

/// Angles of an arm as anatomy counts them, radians, the same for left and right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ArmAngles {
    /// Upper arm forwards and up, in (-π, π].
    pub shoulder_flexion: f64,
    /// Upper arm out to the side, in [-π/2, π/2].
    pub shoulder_abduction: f64,
    /// Upper arm turned so that a bent forearm swings to the middle of the body.
    pub shoulder_rotation: f64,
    /// 0 is the straight arm.
    pub elbow_flexion: f64,
    /// 0 has the thumb up when the forearm is level in front; positive turns the palm down.
    pub forearm_pronation: f64,
    /// Hand towards its palm.
    pub wrist_flexion: f64,
    /// Hand towards its thumb.
    pub wrist_deviation: f64,
}

/// An arm that receives: shoulder with its first joint, elbow with its fourth, wrist with its last; the torso T carries it,
/// x forward, z up, its origin between the shoulders. Hubo's arms and a person's are such arms.
#[derive(Clone, Debug)]
pub struct ReceiverArm {
    /// Joints from the torso to the hand frame, with the place of their value in a posture of the arm.
    joints: Vec<(Joint, Option<usize>)>,
    dofs: usize,
    /// Axis of the elbow in its joint's frame, its sign so that flexion is positive.
    hinge_E: Vector3<f64>,
    /// 1 for a left arm, -1 for a right one.
    side: f64,
    upper_m: f64,
    arm_m: f64,
    half_width_m: f64,
}

/// Where the parts of the arm are, in the torso frame.
struct Placed {
    p_TS: Vector3<f64>,
    p_TE: Vector3<f64>,
    p_TW: Vector3<f64>,
    X_TH: Isometry3<f64>,
    /// Rotation of the elbow's joint frame.
    R_TE: UnitQuaternion<f64>,
}

impl ReceiverArm {
    /// The arm of a robot; `None` for arms that have no elbow with their fourth joint, or no shoulder beside the torso.
    pub fn of(robot: &Robot, arm: &Arm) -> Option<Self> {
        let chain = robot.chain(arm.base_link, arm.hand.tcp_link)?;
        let value = |joint: &Joint| arm.dofs.iter().position(|dof| joint.dof == Some(*dof));
        let joints: Vec<_> =
            chain.iter().map(|&joint| (robot.joints[joint].clone(), value(&robot.joints[joint]))).collect();
        let own: Vec<usize> = joints.iter().filter_map(|(_, value)| *value).collect();
        if own.len() < 6 || !own.is_sorted() || own.len() != arm.dofs.len() {
            return None;
        }
        let elbow = joints.iter().find(|(_, value)| *value == Some(3)).map(|(joint, _)| joint)?;
        let sign = if elbow.limit.upper.abs() >= elbow.limit.lower.abs() { 1.0 } else { -1.0 };
        let hinge_E = elbow.axis.into_inner() * sign;
        let mut found =
            Self { joints, dofs: own.len(), hinge_E, side: 1.0, upper_m: 0.0, arm_m: 0.0, half_width_m: 0.0 };
        let at_zero = found.placed(&vec![0.0; own.len()]);
        found.side = if at_zero.p_TS.y >= 0.0 { 1.0 } else { -1.0 };
        found.half_width_m = at_zero.p_TS.y.abs();
        found.upper_m = (at_zero.p_TE - at_zero.p_TS).norm();
        let [fore_m, hand_m] =
            [at_zero.p_TW - at_zero.p_TE, at_zero.X_TH.translation.vector - at_zero.p_TW].map(|v| v.norm());
        found.arm_m = found.upper_m + fore_m + hand_m;
        (found.upper_m > 1e-3 && fore_m > 1e-3 && found.half_width_m > 1e-3).then_some(found)
    }

    /// Length of the stretched arm from the shoulder to the hand frame, metres.
    pub fn length_m(&self) -> f64 {
        self.arm_m
    }

    /// What a posture costs.
    ///
    /// * `q`: one value per joint of the arm, as in [`Arm::dofs`], radians.
    pub fn comfort(&self, q: &[f64]) -> Comfort {
        let placed = self.placed(q);
        let angles = self.angles_of(&placed);
        let p_TH = placed.X_TH.translation.vector;
        let worst = |costs: [f64; 3]| costs.into_iter().fold(0.0, f64::max);
        let above_m = p_TH.z - placed.p_TS.z;
        let below_m = -self.upper_m - above_m;
        Comfort {
            shoulder: worst([
                // An arm out to the side is neither in front nor behind.
                FLEXION.cost(angles.shoulder_flexion) * math::cos(angles.shoulder_abduction),
                ABDUCTION.cost(angles.shoulder_abduction),
                ROTATION.cost(angles.shoulder_rotation),
            ]),
            elbow: ELBOW.cost(angles.elbow_flexion),
            wrist: worst([
                PRONATION.cost(angles.forearm_pronation),
                WRIST_FLEXION.cost(angles.wrist_flexion),
                WRIST_DEVIATION.cost(angles.wrist_deviation),
            ]),
            distance: DISTANCE.cost((p_TH - placed.p_TS).norm() / self.arm_m),
            side: SIDE.cost(self.side * p_TH.y / self.half_width_m),
            height: HEIGHT_ABOVE
                .cost(above_m / self.arm_m)
                .max(HEIGHT_ABOVE.cost(below_m / (self.arm_m - self.upper_m))),
            total: 0.0,
        }
        .weighted()
    }

    /// The angles of a posture.
    ///
    /// * `q`: one value per joint of the arm, as in [`Arm::dofs`], radians.
    pub fn angles(&self, q: &[f64]) -> ArmAngles {
        self.angles_of(&self.placed(q))
    }

    fn placed(&self, q: &[f64]) -> Placed {
        let mut X_TJ = Isometry3::identity();
        let mut placed = Placed {
            p_TS: Vector3::zeros(),
            p_TE: Vector3::zeros(),
            p_TW: Vector3::zeros(),
            X_TH: X_TJ,
            R_TE: UnitQuaternion::identity(),
        };
        for (joint, value) in &self.joints {
            X_TJ *= joint.X_PJ;
            let Some(index) = *value else { continue };
            let (sin, cos) = math::sin_cos(0.5 * q[index]);
            let v = joint.axis.into_inner() * sin;
            X_TJ.rotation *= UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cos, v.x, v.y, v.z));
            let p = X_TJ.translation.vector;
            match index {
                0 => placed.p_TS = p,
                3 => (placed.p_TE, placed.R_TE) = (p, X_TJ.rotation),
                _ if index + 1 == self.dofs => placed.p_TW = p,
                _ => {}
            }
        }
        placed.X_TH = X_TJ;
        placed
    }

    fn angles_of(&self, placed: &Placed) -> ArmAngles {
        let unit = |v: Vector3<f64>| v.try_normalize(1e-9).unwrap_or_else(|| -Vector3::z());
        let (u, d) = (unit(placed.p_TE - placed.p_TS), unit(placed.p_TW - placed.p_TE));
        let flexion = math::atan2(u.x, -u.z);
        let abduction = math::asin(self.side * u.y);
        // The hinge of an arm that is flexed and abducted but not rotated, and as it is.
        let (sin_f, cos_f) = math::sin_cos(flexion);
        let (sin_a, cos_a) = math::sin_cos(abduction);
        let hinge = placed.R_TE * self.hinge_E;
        let unrotated = Vector3::new(self.side * sin_a * sin_f, -cos_a, -self.side * sin_a * cos_f);
        let rotation = self.side * math::atan2(u.dot(&unrotated.cross(&hinge)), unrotated.dot(&hinge));
        // The forearm F with the palm to the body: x out of the palm, z towards the hand.
        let across = (hinge - d * d.dot(&hinge)).try_normalize(1e-9).unwrap_or(hinge) * self.side;
        let R_TF = Matrix3::from_columns(&[across, d.cross(&across), d]);
        let R = R_TF.transpose() * placed.X_TH.rotation.to_rotation_matrix().into_inner();
        ArmAngles {
            shoulder_flexion: flexion,
            shoulder_abduction: abduction,
            shoulder_rotation: rotation,
            elbow_flexion: math::atan2(u.cross(&d).norm(), u.dot(&d)),
            forearm_pronation: self.side * math::atan2(R[(1, 0)], R[(0, 0)]),
            wrist_flexion: math::asin(-R[(2, 0)]),
            wrist_deviation: self.side * math::atan2(R[(2, 1)], R[(2, 2)]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::robot::samples;

    fn person() -> (Robot, [ReceiverArm; 2]) {
        let robot = samples::human();
        let arms = [0, 1].map(|index| ReceiverArm::of(&robot, &robot.arms[index]).unwrap());
        (robot, arms)
    }

    fn radians(degrees: [f64; 7]) -> [f64; 7] {
        degrees.map(f64::to_radians)
    }

    /// Flexion, abduction and rotation of the shoulder, elbow, pronation, flexion and deviation of the wrist.
    const NEUTRAL: [f64; 7] = [20.0, 10.0, 0.0, 90.0, 0.0, 0.0, 0.0];

    #[test]
    fn the_angles_of_a_person_are_the_joint_values() {
        let (_, arms) = person();
        let mut rng = Rng::new(3, 0);
        for arm in &arms {
            assert!((arm.length_m() - (0.327 + 0.257 + (0.122_f64 * 0.122 + 0.02 * 0.02).sqrt())).abs() < 1e-9);
            for _ in 0..500 {
                // Short of 90° of abduction, where flexion takes over, and of a straight elbow.
                let lower = radians([-60.0, -30.0, -90.0, 1.0, -80.0, -70.0, -30.0]);
                let upper = radians([180.0, 88.0, 70.0, 150.0, 80.0, 80.0, 20.0]);
                let q: Vec<f64> = lower.iter().zip(upper).map(|(lower, upper)| rng.uniform(*lower, upper)).collect();
                let a = arm.angles(&q);
                let found = [
                    a.shoulder_flexion,
                    a.shoulder_abduction,
                    a.shoulder_rotation,
                    a.elbow_flexion,
                    a.forearm_pronation,
                    a.wrist_flexion,
                    a.wrist_deviation,
                ];
                for (found, wanted) in found.iter().zip(&q) {
                    assert!((found - wanted).abs() < 1e-9, "{a:?} is not {q:?}");
                }
            }
        }
    }

    #[test]
    fn the_neutral_posture_costs_nothing_and_both_arms_cost_the_same() {
        let (_, [left, right]) = person();
        assert_eq!(left.comfort(&radians(NEUTRAL)).total, 0.0);
        let mut rng = Rng::new(4, 0);
        for _ in 0..200 {
            let q = NEUTRAL.map(|degrees| (degrees + rng.uniform(-25.0, 25.0)).to_radians());
            let (l, r) = (left.comfort(&q), right.comfort(&q));
            for ((name, l, share), (_, r, _)) in l.terms().into_iter().zip(r.terms()) {
                assert!((l - r).abs() < 1e-9, "{name}");
                assert!((0.0..=1.0).contains(&l) && share > 0.0);
            }
        }
    }

    #[test]
    fn weights_share_one_whole() {
        let all = Comfort { shoulder: 1.0, elbow: 1.0, wrist: 1.0, distance: 1.0, side: 1.0, height: 1.0, total: 0.0 };
        assert!((all.weighted().total - 1.0).abs() < 1e-12);
    }

    #[test]
    fn each_angle_costs_more_the_farther_it_leaves_its_band_and_all_at_its_limit() {
        let (robot, [left, _]) = person();
        let term: [fn(&Comfort) -> f64; 7] =
            [|c| c.shoulder, |c| c.shoulder, |c| c.shoulder, |c| c.elbow, |c| c.wrist, |c| c.wrist, |c| c.wrist];
        for (joint, term) in term.iter().enumerate() {
            let limit = robot.joints[robot.dof_joints[robot.arms[0].dofs[joint]]].limit;
            for end in [limit.lower, limit.upper] {
                // Abduction is told as flexion beyond 90°.
                let end = if joint == 1 { end.min(1.5) } else { end };
                let costs: Vec<f64> = (0..=40)
                    .map(|step| {
                        let mut q = radians(NEUTRAL);
                        q[joint] += (end - q[joint]) * f64::from(step) / 40.0;
                        term(&left.comfort(&q))
                    })
                    .collect();
                assert!(costs.is_sorted(), "joint {joint} to {end}: {costs:?}");
                let last = costs[40];
                assert!(if joint == 1 && end > 0.0 { last > 0.3 } else { last > 0.98 }, "{joint}: {last}");
            }
        }
    }

    #[test]
    fn stretching_reaching_across_and_reaching_up_or_down_cost_more_and_say_why() {
        let (_, [left, _]) = person();
        let cost = |degrees: [f64; 7]| left.comfort(&radians(degrees));
        let stretched = cost([80.0, 5.0, 0.0, 5.0, 0.0, 0.0, 0.0]);
        assert!(stretched.distance > 0.9 && stretched.elbow > 0.9, "{stretched:?}");
        let across = cost([50.0, -20.0, 60.0, 60.0, 0.0, 0.0, 0.0]);
        assert!(across.side > 0.1 && across.shoulder > 0.5, "{across:?}");
        let up = cost([150.0, 5.0, 0.0, 60.0, 0.0, 0.0, 0.0]);
        assert!(up.height > 0.3 && up.shoulder > 0.7, "{up:?}");
        let hanging = cost([0.0, 8.0, 0.0, 5.0, 0.0, 0.0, 0.0]);
        assert!(hanging.height > 0.9 && hanging.shoulder == 0.0, "{hanging:?}");
        for worse in [stretched, across, up, hanging] {
            assert!(worse.total > 0.2, "{worse:?}");
        }
    }

    #[test]
    fn the_same_judgement_serves_hubo() {
        let hubo = samples::hubo();
        for (arm, side) in hubo.arms.iter().zip([1.0, -1.0]) {
            let receiver = ReceiverArm::of(&hubo, arm).unwrap();
            // Pitch forwards 20°, roll outwards 10°, elbow 90°: the person's neutral posture.
            let q = [-20.0, 10.0 * side, 0.0, -90.0, 0.0, 0.0].map(f64::to_radians);
            let a = receiver.angles(&q);
            assert!((a.shoulder_flexion.to_degrees() - 20.0).abs() < 1e-9, "{a:?}");
            assert!((a.shoulder_abduction.to_degrees() - 10.0).abs() < 1e-9);
            assert!((a.elbow_flexion.to_degrees() - 90.0).abs() < 1e-9);
            assert!(a.shoulder_rotation.abs() + a.forearm_pronation.abs() + a.wrist_flexion.abs() < 1e-9);
            assert!(receiver.comfort(&q).total < 0.02, "{:?}", receiver.comfort(&q));
            let raised = [-110.0, 10.0 * side, 0.0, -10.0, 0.0, 0.0].map(f64::to_radians);
            assert!(receiver.comfort(&raised).total > 0.3);
        }
        let crichton = samples::crichton();
        assert!(ReceiverArm::of(&crichton, &crichton.arms[0]).is_none(), "its arms hang on no torso frame");
    }
}
