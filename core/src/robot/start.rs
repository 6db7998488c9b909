//! Where a robot starts: a posture of its SRDF, with some joints elsewhere.

use std::collections::BTreeMap;

use super::Robot;

/// Positions this far outside a limit count as on it, rad or m: what a decimal number in a file loses.
const LIMIT_SLACK: f64 = 1e-9;

/// Why a robot cannot start like that.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StartError {
    /// No such posture.
    #[error("{robot} has no posture {posture:?}")]
    NoPosture { robot: String, posture: String },
    /// No such joint, or one that does not move by itself.
    #[error("{robot} has no joint {joint:?} that moves by itself")]
    NoJoint { robot: String, joint: String },
    /// A joint would start outside of its limits.
    #[error("joint {joint} cannot start at {value:.4}: its limits are {lower:.4} and {upper:.4}")]
    Outside { joint: String, value: f64, lower: f64, upper: f64 },
}

impl Robot {
    /// One value per degree of freedom: those of a posture, but for the joints that are named.
    ///
    /// * `posture`: name of a posture of the SRDF.
    /// * `joints`: positions by the joints' names in the URDF, radians or metres.
    ///
    /// # Errors
    /// [`StartError`] naming the posture or the joint.
    pub fn start(&self, posture: &str, joints: &BTreeMap<String, f64>) -> Result<Vec<f64>, StartError> {
        let no_posture = || StartError::NoPosture { robot: self.name.clone(), posture: posture.to_owned() };
        let mut q = self.posture(posture).ok_or_else(no_posture)?.to_vec();
        for (name, &value) in joints {
            let known = self.dof_joints.iter().position(|&joint| self.joints[joint].name == *name);
            let dof = known.ok_or_else(|| StartError::NoJoint { robot: self.name.clone(), joint: name.clone() })?;
            let limit = self.joints[self.dof_joints[dof]].limit;
            let is_within = (limit.lower - LIMIT_SLACK..=limit.upper + LIMIT_SLACK).contains(&value);
            if !is_within {
                let (lower, upper) = (limit.lower, limit.upper);
                return Err(StartError::Outside { joint: name.clone(), value, lower, upper });
            }
            q[dof] = value.max(limit.lower).min(limit.upper);
        }
        Ok(q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::samples;

    #[test]
    fn named_joints_start_elsewhere_and_the_others_as_in_the_posture() {
        let robot = samples::alita();
        let (name, resting) = &robot.postures[0];
        let dof = robot.arms[0].dofs[2];
        let joint = &robot.joints[robot.dof_joints[dof]];
        let value = 0.5 * (joint.limit.lower + joint.limit.upper) + 0.1;
        let q = robot.start(name, &BTreeMap::from([(joint.name.clone(), value)])).unwrap();
        for (other, (now, before)) in q.iter().zip(resting).enumerate() {
            assert_eq!(*now, if other == dof { value } else { *before });
        }
    }

    #[test]
    fn what_the_robot_does_not_have_is_named() {
        let robot = samples::alita();
        let posture = robot.postures[0].0.clone();
        let said = |posture: &str, joint: &str, value: f64| {
            robot.start(posture, &BTreeMap::from([(joint.to_owned(), value)])).unwrap_err().to_string()
        };
        assert!(said("flying", "x", 0.0).contains("no posture \"flying\""));
        assert!(said(&posture, "third_knee", 0.0).contains("no joint \"third_knee\""));
        let joint = &robot.joints[robot.dof_joints[robot.arms[0].dofs[0]]].name;
        assert!(said(&posture, joint, 100.0).contains("its limits are"));
        assert!(said(&posture, joint, f64::NAN).contains("cannot start at NaN"));
    }
}
