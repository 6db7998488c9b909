//! An S-R-S arm, perhaps behind one joint that is sampled, seen from the base frame of a map.

use nalgebra::{Isometry3, Point3};

use super::ReachError;
use crate::robot::ik::{GLANCES, Glancer, IkSet, SrsArm, arm_angle_rad};
use crate::robot::{Arm, Chain, Robot};

/// Positions at which a joint before the arm is sampled: middles of equal parts of its range, 0 of a torso among them.
const TORSO_POSITIONS: u8 = 7;
/// Arm angles over a full turn that a code can name.
pub(super) const ARM_ANGLES: usize = GLANCES;
/// Joints of an S-R-S arm.
const SEVEN: usize = 7;

/// The closed form of an arm at each position of the joint before it.
#[derive(Clone, Debug)]
pub(super) struct ClosedForm {
    pub(super) srs: SrsArm,
    pub(super) glancer: Glancer,
    pub(super) stands: Vec<Stand>,
}

/// The arm's own base A when the joint before it stands still.
#[derive(Clone, Debug)]
pub(super) struct Stand {
    /// Position of that joint, if there is one.
    pub(super) lead: Option<f64>,
    pub(super) X_AB: Isometry3<f64>,
    /// Shoulder centre.
    pub(super) p_BS: Point3<f64>,
}

impl ClosedForm {
    pub(super) fn of(robot: &Robot, arm: &Arm) -> Result<Self, ReachError> {
        let refuse = |because| ReachError::NoClosedForm { because };
        let extra = arm.dofs.len().saturating_sub(SEVEN);
        if extra > 1 {
            return Err(ReachError::TooManyJoints { found: extra });
        }
        let lead = arm.dofs.first().filter(|_| extra == 1).map(|&dof| robot.dof_joints[dof]);
        let shoulder_link = lead.map_or(arm.base_link, |joint| robot.joints[joint].child);
        let srs = SrsArm::between(robot, shoulder_link, arm.hand.tcp_link).map_err(refuse)?;
        let mut closed = Self { glancer: Glancer::new(&srs), srs, stands: Vec::new() };
        match lead {
            None => closed.stand(None, Isometry3::identity()),
            Some(joint) => {
                let chain = Chain::between(robot, arm.base_link, shoulder_link)?;
                let limit = robot.joints[joint].limit;
                for step in 0..TORSO_POSITIONS {
                    let share = (f64::from(step) + 0.5) / f64::from(TORSO_POSITIONS);
                    let position = limit.lower + (limit.upper - limit.lower) * share;
                    closed.stand(Some(position), chain.tip(&[position]));
                }
            }
        }
        Ok(closed)
    }

    fn stand(&mut self, lead: Option<f64>, X_BA: Isometry3<f64>) {
        self.stands.push(Stand { lead, X_AB: X_BA.inverse(), p_BS: X_BA * self.srs.shoulder() });
    }

    /// Greatest distance of the hand frame from the shoulder, metres.
    pub(super) fn reach_m(&self) -> f64 {
        let (upper_m, fore_m) = self.srs.lengths_m();
        upper_m + fore_m + self.srs.wrist().coords.norm()
    }

    /// The configuration of a code for a pose of the hand; `None` if the code is none of this pose.
    pub(super) fn configuration(&self, X_BH: &Isometry3<f64>, code: u32) -> Option<Vec<f64>> {
        let code = Code::unpack(code);
        let stand = self.stands.get(code.stand)?;
        let mut found = IkSet::default();
        self.srs.solve_into(&(stand.X_AB * X_BH), code.arm_angle_rad(), &mut found);
        let solution = found.solutions.iter().find(|solution| solution.branch == code.branch)?;
        Some(stand.lead.iter().chain(&solution.q).copied().collect())
    }
}

/// What a configuration is made from, given the pose of the hand: in 16 bits the position of the joint before the arm,
/// the arm angle in 32 steps over the full turn from -π, and the branch of the closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Code {
    pub(super) stand: usize,
    pub(super) arm_angle: usize,
    pub(super) branch: u8,
}

impl Code {
    /// As a sweep over the arm angles computes it.
    pub(super) fn arm_angle_rad(self) -> f64 {
        arm_angle_rad(self.arm_angle)
    }

    pub(super) fn pack(self) -> u32 {
        (self.stand as u32) << 8 | (self.arm_angle as u32) << 3 | u32::from(self.branch)
    }

    pub(super) fn unpack(code: u32) -> Self {
        let arm_angle = (code >> 3) as usize % ARM_ANGLES;
        Self { stand: (code >> 8) as usize, arm_angle, branch: (code & 7) as u8 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::samples;

    #[test]
    fn a_code_survives_its_packing() {
        for stand in [0, 6] {
            for arm_angle in 0..ARM_ANGLES {
                for branch in 0..8 {
                    let code = Code { stand, arm_angle, branch };
                    assert_eq!(Code::unpack(code.pack()), code);
                }
            }
        }
    }

    #[test]
    fn the_torso_stands_straight_among_others() {
        let robot = samples::crichton().with_torso(0);
        let closed = ClosedForm::of(&robot, &robot.arms[0]).unwrap();
        assert_eq!(closed.stands.len(), 7);
        assert!(closed.stands[3].lead.unwrap().abs() < 1e-12);
        // The shoulder is 0.28675 m beside the torso's axis wherever the torso turns.
        for stand in &closed.stands {
            assert!((stand.p_BS.coords.xy().norm() - 0.28675).abs() < 1e-9, "{}", stand.p_BS);
        }
        assert!((closed.reach_m() - (0.328 + 0.323 + 0.0824 + 0.0742 + 0.150)).abs() < 1e-6, "{}", closed.reach_m());
    }
}
