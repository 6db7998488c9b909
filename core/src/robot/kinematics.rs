//! Forward kinematics, the Jacobian and manipulability.

use nalgebra::{DMatrix, Isometry3, Matrix6, Translation3, UnitQuaternion, Vector3};

use super::{Arm, JointKind, Robot};

impl Robot {
    /// Number of degrees of freedom: the length of `q`.
    pub fn dof_count(&self) -> usize {
        self.dof_joints.len()
    }

    /// Pose of every link in the robot's root frame, which stands in the world at the origin: `X_WL`.
    ///
    /// `q` has one value per degree of freedom, radians or metres.
    pub fn link_poses(&self, q: &[f64]) -> Vec<Isometry3<f64>> {
        let mut X_WL = Vec::new();
        self.link_poses_into(q, &mut X_WL);
        X_WL
    }

    /// As [`Robot::link_poses`], into a vector that is reused.
    pub fn link_poses_into(&self, q: &[f64], X_WL: &mut Vec<Isometry3<f64>>) {
        X_WL.clear();
        X_WL.push(Isometry3::identity());
        for joint in &self.joints {
            let X_WJ = X_WL[joint.parent] * joint.X_PJ;
            X_WL.push(match joint.kind {
                JointKind::Fixed => X_WJ,
                JointKind::Revolute => {
                    let (sin, cos) = crate::math::sin_cos(0.5 * self.joint_position(joint, q));
                    let v = joint.axis.into_inner() * sin;
                    X_WJ * UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cos, v.x, v.y, v.z))
                }
                JointKind::Prismatic => {
                    X_WJ * Translation3::from(joint.axis.into_inner() * self.joint_position(joint, q))
                }
            });
        }
    }

    /// Position of one joint, mimics followed, rad or m; 0 when fixed.
    pub fn joint_position(&self, joint: &super::Joint, q: &[f64]) -> f64 {
        match (joint.dof, joint.mimic) {
            (Some(dof), _) => q[dof],
            (None, Some(mimic)) => mimic.multiplier * q[mimic.dof] + mimic.offset,
            (None, None) => 0.0,
        }
    }

    /// Jacobian `J_WH` of the hand frame for one arm: `6 × n`, rows `[ω; v]`, at the origin of H, expressed in W.
    ///
    /// `X_WL` are the link poses at the configuration.
    pub fn hand_jacobian(&self, arm: &Arm, X_WL: &[Isometry3<f64>]) -> DMatrix<f64> {
        let p_WH = X_WL[arm.hand.tcp_link].translation.vector;
        let mut J_WH = DMatrix::zeros(6, arm.dofs.len());
        for (column, &dof) in arm.dofs.iter().enumerate() {
            let joint = &self.joints[self.dof_joints[dof]];
            let X_WL_child = &X_WL[joint.child];
            let axis_W = X_WL_child.rotation * joint.axis.into_inner();
            let (angular, linear) = match joint.kind {
                JointKind::Prismatic => (Vector3::zeros(), axis_W),
                _ => (axis_W, axis_W.cross(&(p_WH - X_WL_child.translation.vector))),
            };
            J_WH.fixed_view_mut::<3, 1>(0, column).copy_from(&angular);
            J_WH.fixed_view_mut::<3, 1>(3, column).copy_from(&linear);
        }
        J_WH
    }

    /// Manipulability `√det(J Jᵀ)` (5.1) of one arm at the hand frame.
    pub fn manipulability(&self, arm: &Arm, X_WL: &[Isometry3<f64>]) -> f64 {
        let J_WH = self.hand_jacobian(arm, X_WL);
        let gram: Matrix6<f64> = (&J_WH * J_WH.transpose()).fixed_view::<6, 6>(0, 0).into_owned();
        gram.determinant().max(0.0).sqrt()
    }

    /// The arm of this name.
    pub fn arm(&self, name: &str) -> Option<&Arm> {
        self.arms.iter().find(|arm| arm.name == name)
    }

    /// The full `q` of the posture of this name.
    pub fn posture(&self, name: &str) -> Option<&[f64]> {
        self.postures.iter().find(|(known, _)| known == name).map(|(_, q)| q.as_slice())
    }
}
