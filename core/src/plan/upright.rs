//! Keeping what the hand carries upright: a full glass, a pan, a tray.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::collision::CollisionError;
use crate::math;
use crate::rng::Rng;
use crate::robot::ik::{ArmIk, IkSet};
use crate::robot::{ChainError, ChainState, JointKind, Robot};

/// An axis of the hand stays within an angle of straight up.
///
/// The bound is met at configurations exactly and between them to [`Upright::TOLERANCE_RAD`].
#[derive(Clone, Debug)]
pub struct Upright {
    ik: ArmIk,
    /// The axis in the hand frame H, and straight up in the frame B of the arm's base.
    axis_H: Unit<Vector3<f64>>,
    up_B: Unit<Vector3<f64>>,
    max_tilt_rad: f64,
    /// Per joint the largest change of tilt, rad per rad; 0 for joints that turn about the axis or about the vertical.
    rates: Vec<f64>,
}

/// How far something is tilted, and how far it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// Angle between the axis and straight up, rad.
    pub found_rad: f64,
    /// The largest one allowed, rad.
    pub max_rad: f64,
}

impl std::fmt::Display for Tilt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (found, max) = (self.found_rad.to_degrees(), self.max_rad.to_degrees());
        write!(f, "tilted by {found:.0}°, wanted at most {max:.0}°")
    }
}

/// Why nothing can be kept upright.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UprightError {
    /// No such arm, or rest positions of another robot.
    #[error(transparent)]
    Arm(#[from] CollisionError),
    /// The arm's joints are not those that move its hand.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// The axis has no direction.
    #[error("the axis {found:?} has no direction, wanted a vector longer than 1e-9")]
    NoAxis { found: [f64; 3] },
    /// The angle is not one.
    #[error("the largest tilt is {found} rad, wanted more than 0 and at most π")]
    BadAngle { found: f64 },
}

/// A pose whose tilt is below this share of the bound is left as it is.
const LEFT_ALONE: f64 = 0.9;
/// Poses are brought to this share of the bound, so that straight joint motions between them stay within it.
const INSIDE: f64 = 0.6;
/// Hand positions drawn until one is within reach.
const DRAWS: usize = 64;

impl Upright {
    /// Along motions the tilt exceeds its bound by less than this, rad: proofs of motions that begin or end at the bound
    /// need some room.
    pub const TOLERANCE_RAD: f64 = 1e-3;

    /// Keeps an axis of an arm's hand within `max_tilt_rad` of straight up.
    ///
    /// * `arm`: index into [`Robot::arms`].
    /// * `q_rest`: one value per degree of freedom of the robot: where the arm's base stands.
    /// * `axis_H`: the axis in the hand frame H; of an object O in the hand `R_HO · axis_O`.
    ///
    /// # Errors
    /// [`UprightError`] naming the arm, axis or angle at fault.
    pub fn new(
        robot: &Robot,
        arm: usize,
        q_rest: &[f64],
        axis_H: &Vector3<f64>,
        max_tilt_rad: f64,
    ) -> Result<Self, UprightError> {
        let arms = robot.arms.len();
        let arm = robot.arms.get(arm).ok_or(CollisionError::NoSuchArm { found: arm, arms })?;
        let (found, wanted) = (q_rest.len(), robot.dof_count());
        if found != wanted {
            return Err(CollisionError::WrongLength { found, wanted }.into());
        }
        let axis_H =
            Unit::try_new(*axis_H, 1e-9).ok_or(UprightError::NoAxis { found: [axis_H.x, axis_H.y, axis_H.z] })?;
        let is_angle = max_tilt_rad > 0.0 && max_tilt_rad <= std::f64::consts::PI;
        if !is_angle {
            return Err(UprightError::BadAngle { found: max_tilt_rad });
        }
        let ik = ArmIk::of(robot, arm)?;
        let R_WB = robot.link_poses(q_rest)[arm.base_link].rotation;
        let up_B = R_WB.inverse() * Vector3::z_axis();
        let turns = |dof: usize| {
            let revolute = robot.joints.iter().filter(|joint| joint.kind == JointKind::Revolute);
            let rate = revolute.map(|joint| match joint.mimic {
                Some(mimic) if mimic.dof == dof => mimic.multiplier.abs(),
                _ if joint.dof == Some(dof) => 1.0,
                _ => 0.0,
            });
            rate.sum::<f64>()
        };
        let mut rates: Vec<f64> = ik.chain().dofs().iter().map(|&dof| turns(dof)).collect();
        drop_idle(&ik, &axis_H, &up_B, &mut rates);
        Ok(Self { ik, axis_H, up_B, max_tilt_rad, rates })
    }

    /// The largest tilt, rad.
    pub fn max_tilt_rad(&self) -> f64 {
        self.max_tilt_rad
    }

    /// The tilt at a configuration of the arm, rad.
    pub fn tilt_rad(&self, q: &[f64]) -> f64 {
        let mut state = ChainState::default();
        self.ik.chain().place(q, &mut state);
        angle(&(state.R_BH * self.axis_H.into_inner()), &self.up_B)
    }

    /// The tilt at a configuration if it is too large.
    pub fn fault(&self, q: &[f64]) -> Option<Tilt> {
        let found_rad = self.tilt_rad(q);
        (found_rad > self.max_tilt_rad).then_some(Tilt { found_rad, max_rad: self.max_tilt_rad })
    }

    /// Where a straight joint motion is tilted too far; `None` proves that it is not, to the tolerance.
    ///
    /// The tilt changes by at most the sum of what the joints turn, those left out that turn about the axis or the
    /// vertical. If the middle of an interval is upright by more than half of that, all of it is; otherwise both halves
    /// are looked at, until half of what the joints turn is below the tolerance.
    pub(crate) fn tilted(&self, from: &[f64], to: &[f64]) -> Option<(f64, Tilt)> {
        if let Some(tilt) = self.fault(to) {
            return Some((1.0, tilt));
        }
        let turned: f64 = self.rates.iter().zip(from.iter().zip(to)).map(|(rate, (a, b))| rate * (b - a).abs()).sum();
        let mut intervals = vec![(0.0, 1.0)];
        let mut next = 0;
        while let Some(&(begin, end)) = intervals.get(next) {
            next += 1;
            let middle = 0.5 * (begin + end);
            let q: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + (b - a) * middle).collect();
            let found_rad = self.tilt_rad(&q);
            if found_rad > self.max_tilt_rad {
                return Some((middle, Tilt { found_rad, max_rad: self.max_tilt_rad }));
            }
            if found_rad + 0.5 * turned * (end - begin) > self.max_tilt_rad + Self::TOLERANCE_RAD {
                intervals.extend([(begin, middle), (middle, end)]);
            }
        }
        None
    }

    /// Whether every configuration between two corners of a box in joint space is proven upright, to the tolerance.
    pub(crate) fn holds_between(&self, lower: &[f64], upper: &[f64]) -> bool {
        let middle: Vec<f64> = lower.iter().zip(upper).map(|(a, b)| 0.5 * (a + b)).collect();
        let turned: f64 = self.rates.iter().zip(lower.iter().zip(upper)).map(|(rate, (a, b))| rate * (b - a)).sum();
        self.tilt_rad(&middle) + 0.5 * turned <= self.max_tilt_rad + Self::TOLERANCE_RAD
    }

    /// The configuration itself where it is upright enough, otherwise one near it with the hand at the same place, turned
    /// by the smallest rotation that brings the axis a little inside of the bound (a projection as in Berenson et al.
    /// 2009, in closed form). `None` if a joint would have to move farther than `farthest_rad`.
    pub(crate) fn raised(&self, q: &[f64], farthest_rad: f64) -> Option<Vec<f64>> {
        let X_BH = self.ik.chain().tip(q);
        let axis_B = X_BH.rotation * self.axis_H;
        let tilt = angle(&axis_B, &self.up_B);
        if tilt <= LEFT_ALONE * self.max_tilt_rad {
            return Some(q.to_vec());
        }
        // Upside down every way up is as long.
        let about = Unit::try_new(axis_B.cross(&self.up_B), 1e-9)
            .or_else(|| Unit::try_new(axis_B.cross(&Vector3::x()), 1e-9))
            .unwrap_or_else(Vector3::y_axis);
        let turn = UnitQuaternion::from_axis_angle(&about, tilt - INSIDE * self.max_tilt_rad);
        let raised = self.ik.near(&Isometry3::from_parts(X_BH.translation, turn * X_BH.rotation), q)?;
        let farthest = raised.iter().zip(q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (farthest <= farthest_rad).then_some(raised)
    }

    /// A random upright configuration: the hand anywhere within reach, turned anyhow about the vertical, tilted within
    /// the bound, its posture one of those at a random arm angle.
    pub(crate) fn drawn(&self, rng: &mut Rng) -> Option<Vec<f64>> {
        let chain = self.ik.chain();
        let (origin, reach_m) = (chain.origin(), chain.reach_m());
        let mut found = IkSet::default();
        let z_to_up = UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &self.up_B)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let axis_to_z = UnitQuaternion::rotation_between_axis(&self.axis_H, &Vector3::z_axis())
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&any_normal(&self.axis_H), std::f64::consts::PI));
        for _ in 0..DRAWS {
            let mut within = || rng.uniform(-reach_m, reach_m);
            let place = origin + Vector3::new(within(), within(), within());
            if (place - origin).norm() > reach_m {
                continue;
            }
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rng.uniform(0.0, std::f64::consts::TAU));
            let (sin, cos) = math::sin_cos(rng.uniform(0.0, std::f64::consts::TAU));
            let about = Unit::new_unchecked(Vector3::new(cos, sin, 0.0));
            // Uniform on the cap of directions, nearly.
            let tilt = INSIDE * self.max_tilt_rad * rng.unit().sqrt();
            let rotation = z_to_up * UnitQuaternion::from_axis_angle(&about, tilt) * turned * axis_to_z;
            let X_BH = Isometry3::from_parts(Translation3::from(place), rotation);
            if let Some(srs) = self.ik.closed_form() {
                found.clear();
                srs.solve_into(&X_BH, rng.uniform(-std::f64::consts::PI, std::f64::consts::PI), &mut found);
                if !found.solutions.is_empty() {
                    return Some(found.solutions[rng.index(found.solutions.len())].q.to_vec());
                }
                continue;
            }
            let q_start: Vec<f64> = chain.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect();
            let postures = self.ik.set(&X_BH, &q_start, 1);
            if !postures.is_empty() {
                return postures.iter().nth(rng.index(postures.len())).map(<[f64]>::to_vec);
            }
        }
        None
    }
}

/// Joints that turn about the axis or about the vertical wherever the others stand do not tilt: their rate becomes 0.
fn drop_idle(ik: &ArmIk, axis_H: &Unit<Vector3<f64>>, up_B: &Unit<Vector3<f64>>, rates: &mut [f64]) {
    let (mut state, mut columns) = (ChainState::default(), Vec::new());
    let mut rng = Rng::new(0, 0x7570_7269_6768);
    let mut tilts = vec![[false; 2]; rates.len()];
    // What is parallel at eight random configurations is so at all of them: the angle is analytic in the joints.
    for _ in 0..8 {
        let q: Vec<f64> = ik.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect();
        ik.chain().place(&q, &mut state);
        ik.chain().jacobian(&state, &mut columns);
        let axis_B = state.R_BH * axis_H.into_inner();
        for (tilts, column) in tilts.iter_mut().zip(&columns) {
            let w = Vector3::new(column[0], column[1], column[2]);
            tilts[0] |= w.cross(&axis_B).norm() > 1e-9;
            tilts[1] |= w.cross(up_B).norm() > 1e-9;
        }
    }
    rates.iter_mut().zip(&tilts).filter(|(_, tilts)| !tilts[0] || !tilts[1]).for_each(|(rate, _)| *rate = 0.0);
}

fn any_normal(axis: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    let aside = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    Unit::try_new(axis.cross(&aside), 1e-9).unwrap_or_else(Vector3::x_axis)
}

/// The angle between two unit vectors, exact also near 0.
fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    math::atan2(a.cross(b).norm(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::testing::Bench;

    fn upright(max_tilt_rad: f64) -> (Bench, Upright) {
        let bench = Bench::new(&[]);
        let upright = Upright::new(bench.model.robot(), 0, &bench.rest(), &Vector3::x(), max_tilt_rad).unwrap();
        (bench, upright)
    }

    fn tilt_by_links(bench: &Bench, q: &[f64]) -> f64 {
        let axis_W = bench.model.robot().link_poses(q)[7].rotation * Vector3::x();
        axis_W.angle(&Vector3::z())
    }

    #[test]
    fn the_tilt_is_that_of_the_links_and_no_motion_turns_it_faster_than_its_bound() {
        let (bench, upright) = upright(0.3);
        let space = bench.space();
        let mut rng = Rng::new(1, 0);
        for _ in 0..200 {
            let q: Vec<f64> = space.lower.iter().zip(&space.upper).map(|(l, u)| rng.uniform(*l, *u)).collect();
            assert!((upright.tilt_rad(&q) - tilt_by_links(&bench, &q)).abs() < 1e-7);
            let to: Vec<f64> = q.iter().map(|q| q + rng.uniform(-0.3, 0.3)).collect();
            let turned: f64 =
                upright.rates.iter().zip(q.iter().zip(&to)).map(|(rate, (a, b))| rate * (b - a).abs()).sum();
            assert!((upright.tilt_rad(&q) - upright.tilt_rad(&to)).abs() <= turned + 1e-12);
        }
        // The first joint turns about the vertical, the others tilt.
        assert_eq!(upright.rates, [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        let along_last = Upright::new(bench.model.robot(), 0, &bench.rest(), &Vector3::z(), 0.3).unwrap();
        assert_eq!(along_last.rates[6], 0.0, "the last joint turns about the axis");
    }

    #[test]
    fn motions_that_tilt_too_far_in_passing_are_found_and_upright_ones_proven() {
        let (bench, upright) = upright(0.2);
        let mut rng = Rng::new(2, 0);
        let (mut held, mut tilted) = (0, 0);
        while held < 50 || tilted < 50 {
            let Some(from) = upright.drawn(&mut rng) else { continue };
            let away = rng.uniform(0.0, 1.0);
            let to: Vec<f64> = from.iter().map(|q| q + rng.uniform(-away, away)).collect();
            let Some(to) = upright.raised(&to, 1.0) else { continue };
            let most = (0..=400)
                .map(|k| {
                    let q: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + (b - a) * f64::from(k) / 400.0).collect();
                    tilt_by_links(&bench, &q)
                })
                .fold(0.0, f64::max);
            match upright.tilted(&from, &to) {
                None => {
                    held += 1;
                    assert!(most <= 0.2 + Upright::TOLERANCE_RAD, "proven, but tilted by {most}");
                }
                Some((fraction, tilt)) => {
                    tilted += 1;
                    assert!(most > 0.2 - 1e-2 && tilt.found_rad > 0.2 && fraction > 0.0, "{most} {tilt}");
                }
            }
        }
    }

    #[test]
    fn drawn_and_raised_configurations_are_upright() {
        let (bench, upright) = upright(0.2);
        let mut rng = Rng::new(3, 0);
        let (mut drawn, mut raised) = (0, 0);
        for _ in 0..300 {
            let Some(q) = upright.drawn(&mut rng) else { continue };
            drawn += 1;
            assert!(tilt_by_links(&bench, &q) < 0.2);
            let pushed: Vec<f64> = q.iter().map(|q| q + rng.uniform(-0.2, 0.2)).collect();
            if let Some(found) = upright.raised(&pushed, 0.5) {
                raised += 1;
                assert!(tilt_by_links(&bench, &found) <= 0.2);
                let at = |q: &[f64]| bench.model.robot().link_poses(q)[7].translation.vector;
                assert!((at(&found) - at(&pushed)).norm() < 1e-6, "the hand stays where it is");
            }
        }
        assert!(drawn > 250 && raised > drawn / 2, "{raised} raised of {drawn} drawn of 300");
    }

    #[test]
    fn axes_and_angles_that_are_none_are_refused() {
        let bench = Bench::new(&[]);
        let new = |arm, axis: [f64; 3], angle| {
            Upright::new(bench.model.robot(), arm, &bench.rest(), &Vector3::from(axis), angle).map(|_| ())
        };
        assert!(matches!(new(1, [0.0, 0.0, 1.0], 0.1), Err(UprightError::Arm(_))));
        assert!(matches!(new(0, [0.0; 3], 0.1), Err(UprightError::NoAxis { .. })));
        assert!(matches!(new(0, [0.0, 0.0, 1.0], f64::NAN), Err(UprightError::BadAngle { .. })));
        let tilt = Tilt { found_rad: 34.0_f64.to_radians(), max_rad: 15.0_f64.to_radians() };
        assert_eq!(tilt.to_string(), "tilted by 34°, wanted at most 15°");
    }
}
