//! The small file beside a robot that remembers what was chosen for it: `NAME.robot.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::GuestError;
use crate::robot::{HandDescription, Placement};

/// Version of the format that this program reads and writes.
pub const ROBOT_FILE_VERSION: u32 = 1;
/// Names of arms, in the order in which they are written.
const ARM_NAMES: [&str; 2] = ["left", "right"];
/// A robot stands and a frame sits no farther away than this, metres.
const MAX_SHIFT_M: f64 = 5.0;
/// Two full turns: more is degrees.
const MAX_TURN_RAD: f64 = 12.6;

/// What a URDF does not say: which chains are arms, where their hands are, where the robot stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotDescription {
    /// Format version, [`ROBOT_FILE_VERSION`].
    #[serde(rename = "endcomfort_robot")]
    pub version: u32,
    /// File name of the URDF that it belongs to.
    pub urdf: String,
    /// One or two arms; none where the SRDF beside the URDF names them in our way.
    #[serde(default)]
    pub arms: Vec<ArmDescription>,
    /// Pose of the robot's root in the world; without one a place behind the table is looked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand: Option<Placement>,
    /// Joint positions from which it starts, rad or m; without any a posture with the hands over the table is looked
    /// for. Joints that are not named are at 0.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub posture: BTreeMap<String, f64>,
}

/// An arm, and the hand that it carries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmDescription {
    /// `left` or `right`.
    pub name: String,
    /// Link that carries the first joint of the arm.
    pub base_link: String,
    /// Link that the last joint of the arm moves, or one that is fixed to it.
    pub tip_link: String,
    /// A frame in the tip link, z out of the arm, x along the closing direction: the hand frame H of the arm's own fingers,
    /// or where a described hand is mounted.
    pub tcp: Placement,
    /// The hand that is mounted there; without one the arm closes its own fingers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hand: Option<HandDescription>,
}

impl RobotDescription {
    /// A description that says nothing yet.
    pub fn of(urdf: &str) -> Self {
        let urdf = urdf.to_owned();
        Self { version: ROBOT_FILE_VERSION, urdf, arms: Vec::new(), stand: None, posture: BTreeMap::new() }
    }

    /// Reads a description and checks every number; links are checked when it meets its robot.
    ///
    /// * `file`: its name, for what is said when it is wrong.
    ///
    /// # Errors
    /// [`GuestError`] naming the place, what was found and what was wanted.
    pub fn parse(file: &str, json: &str) -> Result<Self, GuestError> {
        let read: Self = serde_json::from_str(json)
            .map_err(|error| GuestError::Format { file: file.to_owned(), reason: error.to_string() })?;
        read.check()?;
        Ok(read)
    }

    /// Whether JSON is meant as such a description, however wrong it may be.
    pub fn is_meant_by(json: &serde_json::Value) -> bool {
        json.get("endcomfort_robot").is_some()
    }

    /// Checks every number and the names of the arms.
    ///
    /// # Errors
    /// As [`RobotDescription::parse`].
    pub fn check(&self) -> Result<(), GuestError> {
        let check = |holds: bool, place: String, found: String, wanted: &str| {
            if holds { Ok(()) } else { Err(GuestError::Value { place, found, wanted: wanted.to_owned() }) }
        };
        let version = self.version;
        check(version == ROBOT_FILE_VERSION, "endcomfort_robot".into(), version.to_string(), "version 1")?;
        check(self.arms.len() <= ARM_NAMES.len(), "arms".into(), self.arms.len().to_string(), "at most 2")?;
        let placement = |place: &str, Placement { xyz, rpy }: &Placement| {
            let near = xyz.iter().all(|x| x.abs() <= MAX_SHIFT_M);
            check(near, format!("{place}.xyz"), format!("{xyz:?}"), "within 5 m")?;
            let turned = rpy.iter().all(|a| a.abs() <= MAX_TURN_RAD);
            check(turned, format!("{place}.rpy"), format!("{rpy:?}"), "radians within two full turns")
        };
        for (index, arm) in self.arms.iter().enumerate() {
            let place = format!("arms[{index}]");
            let (name, is_known) = (arm.name.clone(), ARM_NAMES.contains(&arm.name.as_str()));
            check(is_known, format!("{place}.name"), name.clone(), "left or right")?;
            let is_new = self.arms[..index].iter().all(|other| other.name != name);
            check(is_new, format!("{place}.name"), name, "another name than the arm before")?;
            placement(&format!("{place}.tcp"), &arm.tcp)?;
            if let Some(hand) = &arm.hand {
                hand.check().map_err(|source| GuestError::Hand { place: format!("{place}.hand"), source })?;
            }
        }
        if let Some(stand) = &self.stand {
            placement("stand", stand)?;
        }
        match self.posture.iter().find(|(_, position)| !position.is_finite()) {
            Some((joint, position)) => {
                check(false, format!("posture.{joint}"), position.to_string(), "a finite number")
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"{"endcomfort_robot": 1, "urdf": "a.urdf", "arms": [{"name": "left", "base_link": "b",
        "tip_link": "t", "tcp": {"xyz": [0, 0, 0.1]}}], "stand": {"xyz": [0, 0, 0.7]}, "posture": {"j1": 0.5}}"#;

    #[test]
    fn a_description_is_written_and_read_again() {
        let read = RobotDescription::parse("a.robot.json", GOOD).unwrap();
        let json = serde_json::to_string(&read).unwrap();
        assert_eq!(RobotDescription::parse("a.robot.json", &json).unwrap(), read);
        assert!(RobotDescription::is_meant_by(&serde_json::from_str(GOOD).unwrap()));
        assert!(!RobotDescription::is_meant_by(&serde_json::json!({"version": 1})));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        for (from, to, wanted) in [
            ("\"left\"", "\"third\"", "arms[0].name: found third, wanted left or right"),
            ("0.1]", "9]", "arms[0].tcp.xyz: found [0.0, 0.0, 9.0], wanted within 5 m"),
            ("robot\": 1", "robot\": 2", "endcomfort_robot: found 2, wanted version 1"),
            ("\"tip_link\"", "\"tip\"", "a.robot.json: not a robot description: unknown field `tip`"),
            ("0.7]}", "0.7], \"rpy\": [90, 0, 0]}", "stand.rpy: found [90.0, 0.0, 0.0]"),
        ] {
            let text = GOOD.replace(from, to);
            assert_ne!(text, GOOD);
            let error = RobotDescription::parse("a.robot.json", &text).unwrap_err().to_string();
            assert!(error.starts_with(wanted), "{error}");
        }
    }
}
