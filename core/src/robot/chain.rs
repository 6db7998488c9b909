//! The moving joints between two links, reduced to constant transforms: forward kinematics and Jacobian without the
//! rest of the robot.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::{JointKind, JointLimit, Robot};
use crate::math;

/// The moving joints from a base link B down to a tip link H; frames of joints have their z along the joint's axis.
///
/// `q` is one value per degree of freedom that moves the chain, base to tip, radians or metres.
#[derive(Clone, Debug)]
pub struct Chain {
    pub(super) joints: Vec<ChainJoint>,
    /// Tip in the frame that the last joint moves.
    pub(super) X_JH: Fixed,
    dofs: Vec<usize>,
    names: Vec<String>,
    limits: Vec<JointLimit>,
}

/// One moving joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChainJoint {
    /// The joint's frame in the frame that the joint before it moves.
    pub(super) X_PJ: Fixed,
    /// Slides along z instead of turning about it.
    pub(super) slides: bool,
    /// Column of `q`; the joint stands at `multiplier · q + offset`.
    pub(super) column: usize,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// A rigid transform with its rotation as a matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fixed {
    pub(super) R: Matrix3<f64>,
    pub(super) t: Vector3<f64>,
}

/// Why there is no chain between two links.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChainError {
    /// The tip does not hang below the base.
    #[error("link {tip:?} does not descend from {base:?}")]
    NotAChain { base: String, tip: String },
    /// Nothing moves.
    #[error("no joint moves {tip:?} relative to {base:?}")]
    NoJoints { base: String, tip: String },
    /// The arm's joints are not those that move its hand.
    #[error("joint {joint:?} is either not one of the joints of arm {arm:?} or does not move its hand {tip:?}")]
    OtherJoints { arm: String, joint: String, tip: String },
}

/// Where the joints of a chain stand at one configuration, in the base frame B; working memory that is reused.
#[derive(Clone, Debug, Default)]
pub struct ChainState {
    /// Unit axis of each joint and a point on it.
    axes: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Rotation of the tip.
    pub R_BH: Matrix3<f64>,
    /// Position of the tip, metres.
    pub p_BH: Vector3<f64>,
}

impl Fixed {
    fn of(X: &Isometry3<f64>) -> Self {
        Self { R: X.rotation.to_rotation_matrix().into_inner(), t: X.translation.vector }
    }
}

impl Chain {
    /// The moving joints between two links, given by index.
    ///
    /// # Errors
    /// [`ChainError`] when the tip does not descend from the base or nothing moves between them.
    pub fn between(robot: &Robot, base_link: usize, tip_link: usize) -> Result<Self, ChainError> {
        let name = |link: usize| robot.links.get(link).map_or_else(|| format!("#{link}"), |link| link.name.clone());
        let no_chain = || ChainError::NotAChain { base: name(base_link), tip: name(tip_link) };
        if base_link.max(tip_link) >= robot.links.len() {
            return Err(no_chain());
        }
        let between = robot.chain(base_link, tip_link).ok_or_else(no_chain)?;
        let follows = |joint: &super::Joint| match (joint.kind, joint.dof, joint.mimic) {
            (JointKind::Fixed, ..) | (_, None, None) => None,
            (_, Some(dof), _) => Some((dof, 1.0, 0.0)),
            (_, None, Some(mimic)) => Some((mimic.dof, mimic.multiplier, mimic.offset)),
        };
        let mut dofs: Vec<usize> =
            between.iter().filter_map(|&joint| follows(&robot.joints[joint])).map(|(dof, ..)| dof).collect();
        dofs.sort_unstable();
        dofs.dedup();
        if dofs.is_empty() {
            return Err(ChainError::NoJoints { base: name(base_link), tip: name(tip_link) });
        }
        let mut joints = Vec::new();
        let mut X_PJ = Isometry3::identity();
        for joint in between.iter().map(|&joint| &robot.joints[joint]) {
            X_PJ *= joint.X_PJ;
            let Some((dof, multiplier, offset)) = follows(joint) else { continue };
            let column = dofs.partition_point(|&known| known < dof);
            let R_JZ = z_to(&joint.axis);
            let slides = joint.kind == JointKind::Prismatic;
            joints.push(ChainJoint { X_PJ: Fixed::of(&(X_PJ * R_JZ)), slides, column, multiplier, offset });
            X_PJ = Isometry3::from_parts(Translation3::identity(), R_JZ.inverse());
        }
        let of_dof = |&dof: &usize| &robot.joints[robot.dof_joints[dof]];
        let names = dofs.iter().map(|dof| of_dof(dof).name.clone()).collect();
        let limits = dofs.iter().map(|dof| of_dof(dof).limit).collect();
        Ok(Self { joints, X_JH: Fixed::of(&X_PJ), dofs, names, limits })
    }

    /// Degrees of freedom, indices into the robot's `q`: the columns of the chain's own `q`.
    pub fn dofs(&self) -> &[usize] {
        &self.dofs
    }

    /// Names of those joints.
    pub fn joint_names(&self) -> &[String] {
        &self.names
    }

    /// Limits of those joints.
    pub fn limits(&self) -> &[JointLimit] {
        &self.limits
    }

    /// Forward kinematics into working memory.
    pub fn place(&self, q: &[f64], state: &mut ChainState) {
        state.axes.clear();
        let (mut R, mut t) = (Matrix3::identity(), Vector3::zeros());
        for joint in &self.joints {
            t += R * joint.X_PJ.t;
            R *= joint.X_PJ.R;
            let position = joint.multiplier * q[joint.column] + joint.offset;
            let z = R.column(2).into_owned();
            state.axes.push((z, t));
            if joint.slides {
                t += z * position;
            } else {
                let (sin, cos) = math::sin_cos(position);
                let (x, y) = (R.column(0).into_owned(), R.column(1).into_owned());
                R.set_column(0, &(x * cos + y * sin));
                R.set_column(1, &(y * cos - x * sin));
            }
        }
        state.p_BH = t + R * self.X_JH.t;
        state.R_BH = R * self.X_JH.R;
    }

    /// Pose of the tip in the base frame.
    pub fn tip(&self, q: &[f64]) -> Isometry3<f64> {
        let mut state = ChainState::default();
        self.place(q, &mut state);
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(state.R_BH));
        Isometry3::from_parts(state.p_BH.into(), rotation)
    }

    /// Columns `[ω; v]` of the Jacobian `J_BH` at the origin of the tip, expressed in B, one per entry of `q`.
    pub fn jacobian(&self, state: &ChainState, columns: &mut Vec<[f64; 6]>) {
        columns.clear();
        columns.resize(self.dofs.len(), [0.0; 6]);
        for (joint, (axis, point)) in self.joints.iter().zip(&state.axes) {
            let (w, v) =
                if joint.slides { (Vector3::zeros(), *axis) } else { (*axis, axis.cross(&(state.p_BH - point))) };
            let column = &mut columns[joint.column];
            for k in 0..3 {
                column[k] += joint.multiplier * w[k];
                column[3 + k] += joint.multiplier * v[k];
            }
        }
    }

    /// Distance that the tip cannot be farther from the first joint than, metres: all segments in one line.
    pub fn reach_m(&self) -> f64 {
        let slide = |joint: &ChainJoint| {
            let limit = &self.limits[joint.column];
            let at = |position: f64| (joint.multiplier * position + joint.offset).abs();
            if joint.slides { at(limit.lower).max(at(limit.upper)) } else { 0.0 }
        };
        let segments = self.joints.iter().skip(1).map(|joint| joint.X_PJ.t.norm()).sum::<f64>();
        segments + self.joints.iter().map(slide).sum::<f64>() + self.X_JH.t.norm()
    }

    /// A point on the first joint's axis, in B, metres.
    pub fn origin(&self) -> Vector3<f64> {
        self.joints[0].X_PJ.t
    }
}

/// A rotation that carries z to an axis.
fn z_to(axis: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::robot::{read_urdf, samples};

    fn check(robot: &Robot, base: usize, tip: usize) {
        let chain = Chain::between(robot, base, tip).unwrap();
        let mut rng = Rng::new(3, 0);
        let (mut state, mut columns) = (ChainState::default(), Vec::new());
        for _ in 0..50 {
            let q: Vec<f64> = chain.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect();
            let tip_at = |q: &[f64]| {
                let mut full = vec![0.0; robot.dof_count()];
                chain.dofs().iter().zip(q).for_each(|(&dof, value)| full[dof] = *value);
                let X_WL = robot.link_poses(&full);
                X_WL[base].inverse() * X_WL[tip]
            };
            let (found, wanted) = (chain.tip(&q), tip_at(&q));
            assert!((found.translation.vector - wanted.translation.vector).norm() < 1e-13);
            assert!(found.rotation.rotation_to(&wanted.rotation).imag().norm() < 1e-13);
            chain.place(&q, &mut state);
            chain.jacobian(&state, &mut columns);
            assert!((wanted.translation.vector - chain.origin()).norm() <= chain.reach_m() + 1e-12);
            // h = 1e-6: round-off ε/h ≈ 2e-10 and curvature h² ≈ 1e-12 leave 1e-8 as ample room.
            for (column, found) in columns.iter().enumerate() {
                let at = |h: f64| {
                    let mut moved = q.clone();
                    moved[column] += h;
                    tip_at(&moved)
                };
                let (minus, plus) = (at(-1e-6), at(1e-6));
                let v = (plus.translation.vector - minus.translation.vector) / 2e-6;
                let w = (plus.rotation * minus.rotation.inverse()).scaled_axis() / 2e-6;
                for k in 0..3 {
                    assert!((found[k] - w[k]).abs() < 1e-8 && (found[3 + k] - v[k]).abs() < 1e-8);
                }
            }
        }
    }

    #[test]
    fn a_chain_is_the_robot_between_its_ends() {
        for robot in [samples::crichton(), samples::alita()] {
            for arm in &robot.arms {
                check(&robot, arm.base_link, arm.hand.tcp_link);
                check(&robot, 0, arm.hand.tcp_link);
            }
        }
    }

    #[test]
    fn sliding_and_copying_joints_count() {
        let urdf = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>\
            <joint name='one' type='prismatic'><parent link='a'/><child link='b'/><origin xyz='0 0.1 0' rpy='0.3 0 0'/>\
              <axis xyz='0 0 -1'/><limit lower='-0.2' upper='0.5' velocity='1'/></joint>\
            <joint name='two' type='revolute'><parent link='b'/><child link='c'/><origin xyz='0.2 0 0'/>\
              <axis xyz='1 2 0'/><limit lower='-2' upper='2' velocity='1'/></joint>\
            <joint name='three' type='revolute'><parent link='c'/><child link='d'/><origin xyz='0.3 0 0.1'/>\
              <axis xyz='0 1 0'/><limit lower='-2' upper='2' velocity='1'/>\
              <mimic joint='two' multiplier='-0.5' offset='0.1'/></joint></robot>";
        let robot = read_urdf(urdf, &|_| None).unwrap().value;
        check(&robot, 0, 3);
        let chain = Chain::between(&robot, 0, 3).unwrap();
        assert_eq!(chain.joint_names(), ["one", "two"]);
        let no_chain = ChainError::NotAChain { base: "d".into(), tip: "a".into() };
        assert_eq!(Chain::between(&robot, 3, 0).unwrap_err(), no_chain);
        assert!(matches!(Chain::between(&robot, 2, 2), Err(ChainError::NoJoints { .. })));
        assert!(matches!(Chain::between(&robot, 2, 9), Err(ChainError::NotAChain { .. })));
    }
}
