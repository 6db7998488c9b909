//! The closed form: elbow from the distance, shoulder from the arm angle, wrist from what is left.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::ball::{Ball, BallAngles};
use super::{IkReject, IkSet, IkSolution, SrsArm};
use crate::math;
use crate::robot::JointLimit;

/// Positions this far outside a limit count as on it, radians: round-off of a chain of seven rotations.
const LIMIT_SLACK: f64 = 1e-10;

/// The line SW counts as lying along a reference direction below this sine.
const PARALLEL: f64 = 1e-6;

/// Below this bend (radians) the elbow counts as stretched, so that its two branches are one: round-off of 1e-16 m in
/// the length |SW| bends it by 2e-8.
const STRETCHED: f64 = 3e-8;

/// Reach beyond the stretched arm, metres, that is still taken for round-off and pulled back.
pub(super) const REACH_SLACK: f64 = 1e-12;

/// Arm angles to either side of a posture's own among which the nearest solution is looked for, radians.
const NEAR_ANGLES: [f64; 7] = [0.0, 0.04, -0.04, 0.1, -0.1, 0.2, -0.2];

/// A posture whose joints are all this near is near enough, radians: what a centimetre of the hand takes.
const NEAR_ENOUGH: f64 = 0.06;

/// What does not depend on the arm angle.
pub(super) struct Posed {
    /// `R_BH · R_HB0`: the rotation that all seven joints make together.
    pub(super) turned: Matrix3<f64>,
    /// Unit vector from S to W.
    pub(super) t: Vector3<f64>,
    /// Direction of the elbow's axis at arm angle 0, and the one a quarter turn further.
    pub(super) normal: Vector3<f64>,
    pub(super) quarter: Vector3<f64>,
    pub(super) elbows: [Option<Elbow>; 2],
}

/// One way to bend the elbow.
pub(super) struct Elbow {
    /// Joint 4, radians.
    pub(super) q4: f64,
    /// +1 or -1: which way the elbow bends about its axis.
    pub(super) sign: f64,
    /// The body frame of the bent arm before the shoulder turns it, transposed: rows SW, a4, SW × a4.
    pub(super) frame: Matrix3<f64>,
    /// `exp(a4 q4)`.
    pub(super) bend: Matrix3<f64>,
}

impl Posed {
    /// What the shoulder turns by at an arm angle.
    #[inline]
    pub(super) fn shoulder(&self, elbow: &Elbow, arm_angle: f64) -> Matrix3<f64> {
        let (sin, cos) = math::sin_cos(arm_angle);
        self.shoulder_facing(elbow, &(self.normal * cos + self.quarter * sin))
    }

    /// What the shoulder turns by when the elbow's axis points along `normal`.
    #[inline]
    fn shoulder_facing(&self, elbow: &Elbow, normal: &Vector3<f64>) -> Matrix3<f64> {
        let n = normal * elbow.sign;
        Matrix3::from_columns(&[self.t, n, self.t.cross(&n)]) * elbow.frame
    }

    /// What is left to the wrist after shoulder and elbow.
    #[inline]
    pub(super) fn wrist(&self, elbow: &Elbow, R_shoulder: &Matrix3<f64>) -> Matrix3<f64> {
        (R_shoulder * elbow.bend).tr_mul(&self.turned)
    }
}

impl SrsArm {
    /// All solutions at one arm angle, up to eight: elbow × shoulder × wrist.
    ///
    /// * `X_BH`: hand frame H in the frame B of the arm's base link.
    /// * `arm_angle`: radians; the elbow's turn about the line SW, counted from the plane of SW and the first axis.
    pub fn solve(&self, X_BH: &Isometry3<f64>, arm_angle: f64) -> IkSet {
        let mut set = IkSet::default();
        self.solve_into(X_BH, arm_angle, &mut set);
        set
    }

    /// As [`SrsArm::solve`], appended to a set.
    pub fn solve_into(&self, X_BH: &Isometry3<f64>, arm_angle: f64, set: &mut IkSet) {
        match self.pose(X_BH) {
            Ok(posed) => self.solve_posed(&posed, arm_angle, set),
            Err(reject) => set.rejected.push(reject),
        }
    }

    /// All solutions at `n_angles` arm angles spread evenly over the whole turn from -π.
    pub fn sweep(&self, X_BH: &Isometry3<f64>, n_angles: usize) -> IkSet {
        let mut set = IkSet::default();
        self.sweep_into(X_BH, n_angles, &mut set);
        set
    }

    /// As [`SrsArm::sweep`], appended to a set.
    pub fn sweep_into(&self, X_BH: &Isometry3<f64>, n_angles: usize, set: &mut IkSet) {
        match self.pose(X_BH) {
            Ok(posed) => {
                for i in 0..n_angles {
                    self.solve_posed(&posed, TAU * i as f64 / n_angles as f64 - PI, set);
                }
            }
            Err(reject) => set.rejected.push(reject),
        }
    }

    /// The arm angle of a posture, radians in [-π, π].
    pub fn arm_angle(&self, q: &[f64; 7]) -> f64 {
        let turn = |ball: &Ball, at: usize| ball.rotation(q[at], q[at + 1], q[at + 2]);
        let R_shoulder = turn(&self.shoulder, 0);
        let v_SW = self.v_SE + axis_rotation(&self.a4, q[3]) * self.v_EW;
        let bend = math::wrap_angle(q[3] + self.elbow0);
        let Some(t) = (R_shoulder * v_SW).try_normalize(1e-9) else { return 0.0 };
        let normal = R_shoulder * self.a4 * if bend < -STRETCHED { -1.0 } else { 1.0 };
        let (zero, quarter) = self.normals(&t);
        math::atan2(normal.dot(&quarter), normal.dot(&zero))
    }

    /// The solution nearest to a posture, by its farthest joint, at arm angles near the posture's own; the first that is
    /// near enough is taken.
    pub fn near(&self, X_BH: &Isometry3<f64>, near: &[f64; 7]) -> Option<[f64; 7]> {
        let posed = self.pose(X_BH).ok()?;
        let angle = self.arm_angle(near);
        let farthest = |q: &[f64; 7]| q.iter().zip(near).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let mut found = IkSet::default();
        let mut best: Option<(f64, [f64; 7])> = None;
        for step in NEAR_ANGLES {
            found.clear();
            self.solve_posed(&posed, angle + step, &mut found);
            for solution in &found.solutions {
                let distance = farthest(&solution.q);
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, solution.q));
                }
            }
            if best.is_some_and(|(least, _)| least < NEAR_ENOUGH) {
                break;
            }
        }
        best.map(|(_, q)| q)
    }

    /// Elbow branches and everything else that all arm angles share.
    pub(super) fn pose(&self, X_BH: &Isometry3<f64>) -> Result<Posed, IkReject> {
        let v_SW = (X_BH * self.p_HW).coords - self.p_BS;
        let d = v_SW.norm();
        let longest = self.upper_m + self.fore_m;
        let shortest = (self.upper_m - self.fore_m).abs();
        // A pose that is not finite is farther away than anything.
        let gap_m = if d.is_finite() { d - longest } else { f64::INFINITY };
        if gap_m > REACH_SLACK {
            return Err(IkReject::OutOfReach { gap_m });
        }
        if d < (shortest - REACH_SLACK).max(1e-6) {
            return Err(IkReject::TooClose { gap_m: shortest.max(1e-6) - d });
        }
        // Angle between SE and EW. By half angles, cos θ = (d² - l1² - l2²) / (2 l1 l2) loses half its digits near 0.
        let near = ((longest - d) * (longest + d)).max(0.0);
        let far = ((d - shortest) * (d + shortest)).max(0.0);
        let theta = 2.0 * math::atan2(near.sqrt(), far.sqrt());
        let t = v_SW / d;
        let (normal, quarter) = self.normals(&t);
        let straight = theta < STRETCHED;
        let mut posed = Posed {
            turned: X_BH.rotation.to_rotation_matrix().into_inner() * self.R_HB0,
            t,
            normal,
            quarter,
            elbows: [self.elbow(theta, 1.0), None],
        };
        if !straight {
            posed.elbows[1] = self.elbow(theta, -1.0);
        }
        Ok(posed)
    }

    /// `None` only if S and W coincide, which `pose` has turned away.
    fn elbow(&self, theta: f64, sign: f64) -> Option<Elbow> {
        let q4 = math::wrap_angle(sign * theta - self.elbow0);
        let bend = axis_rotation(&self.a4, q4);
        let along = (self.v_SE + bend * self.v_EW).try_normalize(1e-9)?;
        let across = (self.a4 - along * along.dot(&self.a4)).try_normalize(1e-9)?;
        let frame = Matrix3::from_rows(&[along.transpose(), across.transpose(), along.cross(&across).transpose()]);
        Some(Elbow { q4, sign, frame, bend })
    }

    /// Direction of the elbow's axis at arm angle 0, and at a quarter turn.
    fn normals(&self, t: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let across = |reference: &Vector3<f64>| reference.cross(t).try_normalize(PARALLEL);
        let normal = across(&self.references[0]).or_else(|| across(&self.references[1])).unwrap_or_else(Vector3::x);
        (normal, t.cross(&normal))
    }

    pub(super) fn solve_posed(&self, posed: &Posed, arm_angle: f64, set: &mut IkSet) {
        let (sin, cos) = math::sin_cos(arm_angle);
        let normal = posed.normal * cos + posed.quarter * sin;
        for (elbow_bit, elbow) in posed.elbows.iter().enumerate() {
            let Some(elbow) = elbow else { continue };
            let q4 = match self.within(3, elbow.q4) {
                Ok(q4) => q4,
                Err(reject) => {
                    set.rejected.push(reject);
                    continue;
                }
            };
            let R_shoulder = posed.shoulder_facing(elbow, &normal);
            let shoulder = self.shoulder.angles(&R_shoulder);
            let R_wrist = posed.wrist(elbow, &R_shoulder);
            let wrist = self.wrist.angles(&R_wrist);
            let wrists = self.branches(&self.wrist, 4, &wrist, &R_wrist);
            let shoulders = self.branches(&self.shoulder, 0, &shoulder, &R_shoulder);
            for (wrist_bit, wrist) in wrists.iter().enumerate() {
                for (shoulder_bit, shoulder) in shoulders.iter().enumerate() {
                    let (Some(shoulder), Some(wrist)) = (shoulder, wrist) else { continue };
                    match (shoulder, wrist) {
                        (Ok(s), Ok(w)) => {
                            let q = [s[0], s[1], s[2], q4, w[0], w[1], w[2]];
                            let branch = (elbow_bit << 2 | wrist_bit << 1 | shoulder_bit) as u8;
                            self.push_with_whole_turns(IkSolution { q, arm_angle, branch }, set);
                        }
                        (Err(reject), _) | (_, Err(reject)) => set.rejected.push(*reject),
                    }
                }
            }
        }
    }

    /// Both branches of a ball ([`ball_branches`]).
    pub(super) fn branches(
        &self,
        ball: &Ball,
        first: usize,
        angles: &BallAngles,
        rotation: &Matrix3<f64>,
    ) -> [Option<Result<[f64; 3], IkReject>>; 2] {
        ball_branches(&self.limits, ball, first, angles, rotation)
    }

    /// The angle moved by whole turns into the limits of a joint, or how it misses them.
    pub(super) fn within(&self, joint: usize, angle: f64) -> Result<f64, IkReject> {
        within(&self.limits, joint, angle)
    }

    /// A joint that turns by more than 2π reaches some angles in several ways, each a configuration of its own.
    fn push_with_whole_turns(&self, solution: IkSolution, set: &mut IkSet) {
        let first = set.solutions.len();
        set.solutions.push(solution);
        for (joint, limit) in self.limits.iter().enumerate() {
            if limit.upper - limit.lower <= TAU + LIMIT_SLACK {
                continue;
            }
            for i in first..set.solutions.len() {
                for turn in [-TAU, TAU] {
                    let mut other = set.solutions[i];
                    other.q[joint] += turn;
                    while other.q[joint] >= limit.lower && other.q[joint] <= limit.upper {
                        set.solutions.push(other);
                        other.q[joint] += turn;
                    }
                }
            }
        }
    }

    /// Distance by which a point for the wrist centre misses the reach of the arm, metres; 0 when it is within.
    pub fn reach_gap_m(&self, X_BH: &Isometry3<f64>) -> f64 {
        let d = (X_BH * self.p_HW - Point3::from(self.p_BS)).norm();
        (d - self.upper_m - self.fore_m).max((self.upper_m - self.fore_m).abs() - d).max(0.0)
    }
}

/// Both branches of a ball; an aligned ball has one, its free turn split so that it stays within the limits.
pub(super) fn ball_branches(
    limits: &[JointLimit],
    ball: &Ball,
    first: usize,
    angles: &BallAngles,
    rotation: &Matrix3<f64>,
) -> [Option<Result<[f64; 3], IkReject>>; 2] {
    let check = |q1: f64, q2: f64, q3: f64| -> Result<[f64; 3], IkReject> {
        Ok([within(limits, first, q1)?, within(limits, first + 1, q2)?, within(limits, first + 2, q3)?])
    };
    let one = check(angles.q1, angles.q2, angles.q3);
    if angles.aligned {
        let halves = [0.5 * angles.q3, -0.5 * angles.q3];
        let split = |half: f64| check(half, angles.q2, ball.last_for_first(rotation, half));
        let found = one.or_else(|reject| split(halves[0]).or_else(|_| split(halves[1])).map_err(|_| reject));
        return [Some(found), None];
    }
    [Some(one), Some(check(angles.q1 + PI, angles.other_q2, angles.q3 + PI))]
}

/// The angle moved by whole turns into the limits of a joint, or how it misses them.
pub(super) fn within(limits: &[JointLimit], joint: usize, angle: f64) -> Result<f64, IkReject> {
    let limit = &limits[joint];
    let value = math::wrap_angle(angle);
    for candidate in [value, value - TAU, value + TAU] {
        if candidate >= limit.lower - LIMIT_SLACK && candidate <= limit.upper + LIMIT_SLACK {
            return Ok(candidate.max(limit.lower).min(limit.upper));
        }
    }
    Err(IkReject::JointLimit { joint, value, lower: limit.lower, upper: limit.upper })
}

/// `exp(axis · angle)` by Rodrigues' formula.
pub(super) fn axis_rotation(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (sin, cos) = math::sin_cos(angle);
    let v = axis * sin;
    let outer = axis * axis.transpose() * (1.0 - cos);
    outer + Matrix3::new(cos, -v.z, v.y, v.z, cos, -v.x, -v.y, v.x, cos)
}
