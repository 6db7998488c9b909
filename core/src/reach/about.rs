//! What a map is of and how it was made.

use nalgebra::Vector3;

use super::ReachError;
use crate::robot::{Chain, Robot};

/// How a map was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReachMethod {
    /// Every pose of the map was solved for the joints in closed form.
    Inverse {
        /// Positions of the joint before the arm, 1 if there is none.
        torso_positions: u8,
    },
    /// Configurations were drawn and sorted into the poses that they reach.
    Forward {
        /// How many.
        samples: u32,
        /// Where their sequence begins.
        seed: u64,
    },
}

/// Which arm a map is of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MappedArm {
    /// Name of the robot.
    pub robot: String,
    /// Name of the arm.
    pub arm: String,
    /// Link whose frame is B: the torso's parent if the map is one with the torso.
    pub base_link: String,
    /// Joints of the arm, the torso among them if the map is one with it.
    pub joints: u8,
    /// Number that any change of the joints, their limits and the hand frame changes.
    pub fingerprint: u64,
}

/// What a map is of and how it was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct About {
    /// Which arm.
    pub arm: MappedArm,
    /// How.
    pub method: ReachMethod,
}

impl About {
    /// The arm as it is now.
    pub(super) fn arm(robot: &Robot, arm_index: usize) -> Result<MappedArm, ReachError> {
        let arms = robot.arms.len();
        let arm = robot.arms.get(arm_index).ok_or(ReachError::NoSuchArm { found: arm_index, arms })?;
        let chain = Chain::between(robot, arm.base_link, arm.hand.tcp_link)?;
        Ok(MappedArm {
            robot: robot.name.clone(),
            arm: arm.name.clone(),
            base_link: robot.links[arm.base_link].name.clone(),
            joints: chain.dofs().len().min(255) as u8,
            fingerprint: fingerprint(&chain),
        })
    }
}

impl std::fmt::Display for MappedArm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { robot, arm, base_link, joints, fingerprint } = self;
        write!(f, "{robot}, arm {arm}, {joints} joints from {base_link}, fingerprint {fingerprint:016x}")
    }
}

impl std::fmt::Display for ReachMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Inverse { torso_positions: 1 } => write!(f, "inverse"),
            Self::Inverse { torso_positions } => write!(f, "inverse, torso at {torso_positions} positions"),
            Self::Forward { samples, seed } => write!(f, "forward, {samples} samples, seed {seed}"),
        }
    }
}

/// FNV-1a of the names and limits of the joints and of where the tip stands when all are in the middle of their limits,
/// and when one of them is at its lower or upper one, to a tenth of a micrometre: that fixes every axis.
fn fingerprint(chain: &Chain) -> u64 {
    let mut hash = Fnv::default();
    let mut length = |x: f64| hash.add(&((x * 1e7).round() as i64).to_le_bytes());
    let limits = chain.limits();
    limits.iter().for_each(|limit| [limit.lower, limit.upper].into_iter().for_each(&mut length));
    let middle: Vec<f64> = limits.iter().map(|limit| 0.5 * (limit.lower + limit.upper)).collect();
    let moved = |joint: usize, position: f64| {
        let mut q = middle.clone();
        q[joint] = position;
        q
    };
    let ends = limits.iter().enumerate().flat_map(|(joint, limit)| [(joint, limit.lower), (joint, limit.upper)]);
    let postures = ends.map(|(joint, position)| moved(joint, position));
    for q in std::iter::once(middle.clone()).chain(postures) {
        let X_BH = chain.tip(&q);
        X_BH.translation.vector.iter().copied().for_each(&mut length);
        // Two axes rather than the quaternion, whose sign is not fixed.
        [Vector3::x(), Vector3::z()]
            .iter()
            .for_each(|axis| (X_BH.rotation * axis).iter().copied().for_each(&mut length));
    }
    chain.joint_names().iter().for_each(|name| hash.add(name.as_bytes()));
    hash.0
}

/// FNV-1a, 64 bits.
pub(super) struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    pub(super) fn of(bytes: &[u8]) -> u64 {
        let mut hash = Self::default();
        hash.add(bytes);
        hash.0
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::samples;

    #[test]
    fn every_arm_has_a_fingerprint_of_its_own_and_any_change_changes_it() {
        let (crichton, alita) = (samples::crichton(), samples::alita());
        let with_torso = crichton.with_torso(0);
        let print = |robot: &Robot, arm: usize| About::arm(robot, arm).unwrap().fingerprint;
        let mut prints =
            vec![print(&crichton, 0), print(&crichton, 1), print(&alita, 0), print(&alita, 1), print(&with_torso, 0)];
        let joint = crichton.joints.iter().position(|joint| joint.name == "left_joint_4").unwrap();
        let changed = |change: &dyn Fn(&mut crate::robot::Joint)| {
            let mut robot = crichton.clone();
            change(&mut robot.joints[joint]);
            print(&robot, 0)
        };
        prints.push(changed(&|joint| joint.limit.upper -= 1e-3));
        prints.push(changed(&|joint| joint.X_PJ.translation.z += 1e-6));
        prints.push(changed(&|joint| joint.axis = nalgebra::Vector3::x_axis()));
        let count = prints.len();
        prints.sort_unstable();
        prints.dedup();
        assert_eq!(prints.len(), count);
        assert_eq!(print(&samples::crichton(), 0), print(&crichton, 0));
        assert!(matches!(About::arm(&alita, 2), Err(ReachError::NoSuchArm { found: 2, arms: 2 })));
    }
}
