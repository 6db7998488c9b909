//! Joint motions that keep the hand on its way.

use nalgebra::{Isometry3, Translation3};

use super::space::{ArmSpace, lerp};
use crate::collision::{Hit, Scratch};
use crate::robot::ik::ArmIk;

/// A motion is halved at most this often: into sixteen pieces.
const HALVINGS: u32 = 4;

/// How far the hand may be beside its way in the middle of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sag {
    pub(super) m: f64,
    pub(super) rad: f64,
}

/// Why a motion between two hand poses is not made.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum EdgeFault {
    /// Something touches.
    Blocked(Hit),
    /// No posture near the middle keeps the hand on its way.
    Strays,
}

/// Proves motions free and bent so that the hand stays on its way.
pub(super) struct HandEdges<'a> {
    pub(super) space: &'a ArmSpace,
    pub(super) ik: &'a ArmIk,
    pub(super) sag: Sag,
}

impl HandEdges<'_> {
    /// The configurations to pass between `from` and `to`, none where the straight motion is good enough.
    ///
    /// * `X_BH_from`, `X_BH_to`: hand poses at the ends; between them the hand shall move on a line, turning by slerp.
    ///
    /// Where the hand would leave that way in the middle of the joint motion by more than the sag, the motion is led
    /// through a solution at the middle pose and both halves are looked at in turn.
    pub(super) fn bend(
        &self,
        scratch: &mut Scratch,
        from: (&[f64], &Isometry3<f64>),
        to: (&[f64], &Isometry3<f64>),
    ) -> Result<Vec<Vec<f64>>, EdgeFault> {
        let mut between = Vec::new();
        self.bend_into(scratch, from, to, HALVINGS, &mut between)?;
        Ok(between)
    }

    fn bend_into(
        &self,
        scratch: &mut Scratch,
        (from, X_BH_from): (&[f64], &Isometry3<f64>),
        (to, X_BH_to): (&[f64], &Isometry3<f64>),
        halvings: u32,
        between: &mut Vec<Vec<f64>>,
    ) -> Result<(), EdgeFault> {
        let X_BH_middle = middle(X_BH_from, X_BH_to);
        let q_middle = lerp(from, to, 0.5);
        if gap(&self.ik.chain().tip(&q_middle), &X_BH_middle).within(self.sag) {
            return match self.space.edge_hit(scratch, from, to) {
                Some(blocked) => Err(EdgeFault::Blocked(blocked.hit)),
                None => Ok(()),
            };
        }
        if halvings == 0 {
            return Err(EdgeFault::Strays);
        }
        let q_middle = self.ik.near(&X_BH_middle, &q_middle).ok_or(EdgeFault::Strays)?;
        // A solution that is farther from an end than the other end is one of another branch.
        let farthest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let whole = farthest(from, to);
        if farthest(from, &q_middle) > whole || farthest(&q_middle, to) > whole {
            return Err(EdgeFault::Strays);
        }
        self.bend_into(scratch, (from, X_BH_from), (&q_middle, &X_BH_middle), halvings - 1, between)?;
        between.push(q_middle.clone());
        self.bend_into(scratch, (&q_middle, &X_BH_middle), (to, X_BH_to), halvings - 1, between)
    }
}

/// Halfway: positions on a line, rotations by slerp.
fn middle(a: &Isometry3<f64>, b: &Isometry3<f64>) -> Isometry3<f64> {
    let translation = a.translation.vector.lerp(&b.translation.vector, 0.5);
    let rotation = a.rotation.try_slerp(&b.rotation, 0.5, 1e-9).unwrap_or(b.rotation);
    Isometry3::from_parts(Translation3::from(translation), rotation)
}

/// Distance and angle between two hand poses.
pub(super) fn gap(a: &Isometry3<f64>, b: &Isometry3<f64>) -> Sag {
    // Twice the sine of half the angle: as good as the angle where it is small, and cheaper.
    let rad = 2.0 * (a.rotation.inverse() * b.rotation).imag().norm();
    Sag { m: (a.translation.vector - b.translation.vector).norm(), rad }
}

impl Sag {
    pub(super) fn within(self, bound: Self) -> bool {
        self.m <= bound.m && self.rad <= bound.rad
    }
}
