//! Forward kinematics, the Jacobian and manipulability.

use nalgebra::{DMatrix, Isometry3, Matrix6, Translation3, UnitQuaternion, Vector3};

use super::{Arm, Chain, JointKind, Robot};

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
        // Summed column by column: a library product would use fused operations where the machine has them, and its last
        // bit would differ between machines.
        let mut gram = Matrix6::<f64>::zeros();
        for column in self.hand_jacobian(arm, X_WL).column_iter() {
            for i in 0..6 {
                for j in 0..6 {
                    gram[(i, j)] += column[i] * column[j];
                }
            }
        }
        gram.determinant().max(0.0).sqrt()
    }

    /// An arm together with the joints between the robot's root and its base, which then stand first in its `dofs`:
    /// Crichton's torso. The arm itself when there are none.
    pub fn arm_with_torso(&self, arm: &Arm) -> Arm {
        let Ok(lead) = Chain::between(self, 0, arm.base_link) else { return arm.clone() };
        let chain = self.chain(0, arm.base_link).unwrap_or_default();
        let first = chain.iter().map(|&joint| &self.joints[joint]).find(|joint| joint.kind != JointKind::Fixed);
        let base_link = first.map_or(arm.base_link, |joint| joint.parent);
        let dofs = lead.dofs().iter().chain(&arm.dofs).copied().collect();
        Arm { dofs, base_link, ..arm.clone() }
    }

    /// The robot with one arm's chain beginning at the root ([`Robot::arm_with_torso`]).
    pub fn with_torso(&self, arm_index: usize) -> Self {
        let mut robot = self.clone();
        if let Some(arm) = self.arms.get(arm_index) {
            robot.arms[arm_index] = self.arm_with_torso(arm);
        }
        robot
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::robot::samples;

    /// Posture, left finger tip in the world and approach direction: the printed digits of the published postures.
    const POSTURES: [(&str, [f64; 3], [f64; 3]); 9] = [
        ("zero", [0.0, 1.339, 1.230], [0.0, 1.0, 0.0]),
        ("resting", [0.864, 0.758, 1.230], [0.966, 0.259, 0.0]),
        ("frontal_fist", [0.845, 0.082, 1.230], [0.819, -0.574, 0.0]),
        ("hug", [0.765, -0.059, 1.230], [0.5, -0.866, 0.0]),
        ("arc_up", [0.0, 0.829, 2.025], [0.0, 0.643, 0.766]),
        ("lookup_sky", [0.0, 0.287, 2.283], [0.0, 0.0, 1.0]),
        ("demanding", [0.955, 0.038, 1.398], [0.970, -0.174, 0.171]),
        ("display", [0.385, 0.034, 0.845], [0.0, -1.0, 0.0]),
        ("table_ready", [0.509, 0.289, 0.931], [0.0, 0.0, -1.0]),
    ];

    /// From the hand frame H, 0.150 above the palm frame, to the finger tips of the straight hand, 0.245 above it.
    const TIP_FROM_H: f64 = 0.095;

    #[test]
    fn crichton_stands_where_the_posture_table_says() {
        let robot = samples::crichton();
        let tip = |arm: &str, posture: &str| {
            let X_WL = robot.link_poses(robot.posture(posture).unwrap());
            let X_WH = X_WL[robot.arm(arm).unwrap().hand.tcp_link];
            let approach_W = X_WH.rotation * Vector3::z();
            (X_WH.translation.vector + approach_W * TIP_FROM_H, approach_W)
        };
        // Half a unit of the last digit, and one more tenth for the digits themselves. TABLE_READY was recorded, and
        // its direction is straight down to four digits only.
        let near = |found: Vector3<f64>, wanted: [f64; 3], tolerance: f64| {
            assert!((found - Vector3::from(wanted)).amax() < tolerance, "{found:?} is not {wanted:?}");
        };
        for (posture, position, approach) in POSTURES {
            let (p_left, z_left) = tip("left", posture);
            near(p_left, position, 0.6e-3);
            near(z_left, approach, 0.7e-3);
            // The right arm mirrors the left one in y, except where the table gives it numbers of its own.
            let (p_right, z_right) = tip("right", posture);
            match posture {
                "demanding" => {}
                "table_ready" => {
                    near(p_right, [0.510, -0.321, 0.931], 0.6e-3);
                    near(z_right, [0.0, 0.0, -1.0], 0.7e-3);
                }
                _ => {
                    near(p_right, [position[0], -position[1], position[2]], 0.6e-3);
                    near(z_right, [approach[0], -approach[1], approach[2]], 0.7e-3);
                }
            }
        }
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_the_hand_pose() {
        // h = 1e-6: round-off ε/h ≈ 2e-10 and curvature h² ≈ 1e-12 leave 1e-8 as ample room.
        let h = 1e-6;
        for robot in [samples::crichton(), samples::alita()] {
            let mut rng = Rng::new(5, 0);
            for arm in &robot.arms {
                for _ in 0..20 {
                    let random = |joint: &usize| {
                        let limit = robot.joints[*joint].limit;
                        rng.uniform(limit.lower, limit.upper)
                    };
                    let q: Vec<f64> = robot.dof_joints.iter().map(random).collect();
                    let J_WH = robot.hand_jacobian(arm, &robot.link_poses(&q));
                    for (column, &dof) in arm.dofs.iter().enumerate() {
                        let at = |step: f64| {
                            let mut moved = q.clone();
                            moved[dof] += step;
                            robot.link_poses(&moved)[arm.hand.tcp_link]
                        };
                        let (minus, plus) = (at(-h), at(h));
                        let linear = (plus.translation.vector - minus.translation.vector) / (2.0 * h);
                        let angular = (plus.rotation * minus.rotation.inverse()).scaled_axis() / (2.0 * h);
                        let found = J_WH.column(column);
                        assert!((found.fixed_rows::<3>(0) - angular).norm() < 1e-8);
                        assert!((found.fixed_rows::<3>(3) - linear).norm() < 1e-8);
                    }
                }
            }
        }
    }

    #[test]
    fn both_robots_wait_at_home_above_the_table_and_within_their_limits() {
        for robot in [samples::crichton(), samples::alita()] {
            for (name, q) in &robot.postures {
                for (&joint, value) in robot.dof_joints.iter().zip(q) {
                    let limit = robot.joints[joint].limit;
                    assert!((limit.lower..=limit.upper).contains(value), "{name}: {}", robot.joints[joint].name);
                }
            }
            for posture in ["home", "table_ready"] {
                let X_WL = robot.link_poses(robot.posture(posture).unwrap());
                for (link, X) in robot.links.iter().zip(&X_WL) {
                    let p = X.translation.vector;
                    assert!(p.x < 0.2 || p.z > 0.80, "{posture}: {} of {} at {p:?}", link.name, robot.name);
                }
            }
        }
    }

    #[test]
    fn a_mimic_jaw_moves_with_the_jaw_it_copies() {
        let robot = samples::alita();
        for arm in &robot.arms {
            let mut q = vec![0.0; robot.dof_count()];
            q[arm.hand.fingers[0][0]] = 0.03;
            let X_WL = robot.link_poses(&q);
            let X_HW = X_WL[arm.hand.tcp_link].inverse();
            let jaws: Vec<f64> = arm
                .hand
                .links
                .iter()
                .filter(|&&link| robot.links[link].name.contains("jaw"))
                .map(|&link| (X_HW * X_WL[link]).translation.vector.x)
                .collect();
            assert_eq!(jaws.len(), 2);
            assert!((jaws[0] - 0.03).abs() < 1e-12 && (jaws[1] + 0.03).abs() < 1e-12, "{jaws:?}");
        }
    }
}
