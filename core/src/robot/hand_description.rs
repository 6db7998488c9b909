//! A hand of the user's own: a URDF of the hand alone, and what grasping needs to know of it.
//!
//! [`HandDescription`] is a JSON file (`robots/README.md` describes it, `robots/hands/` has examples). It is attached to
//! an arm with [`super::Robot::with_hand`]. Links and joints keep their names in the description and are prefixed with
//! the arm's name on the robot.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3};
use serde::{Deserialize, Deserializer, Serialize};

use super::{Joint, JointKind, JointLimit, Link, Resolve, Robot, RobotError, read_urdf, xml};
use crate::loaded::Loaded;

/// Version of the format that this program reads.
pub const HAND_VERSION: u32 = 1;
/// Positions, friction and fingers beyond these are taken for a mistake.
const MAX_SHIFT_M: f64 = 1.0;
const FRICTION: [f64; 2] = [0.01, 5.0];
const MAX_FINGERS: usize = 10;
/// Name of the hand frame's link where the description gives the frame as a pose.
const FRAME_LINK: &str = "tcp";

/// A hand that can take the place of a robot's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandDescription {
    /// Format version, [`HAND_VERSION`].
    pub version: u32,
    /// What a person calls it.
    pub name: String,
    /// URDF of the hand alone: its text, or its lines in a list.
    #[serde(deserialize_with = "text_or_lines")]
    pub urdf: String,
    /// The palm: the root of the URDF, or fixed to it.
    pub palm_link: String,
    /// Pose of the URDF's root in the arm's flange E.
    #[serde(default)]
    pub mount: Placement,
    /// The hand frame H (thesis 4.1): x along the closing direction, z the approach out of the palm.
    pub frame: HandFrame,
    /// Joints that close the hand, finger by finger, proximal before distal.
    pub fingers: Vec<Vec<String>>,
    /// Position of each of these joints when the hand is open, rad or m.
    pub open: BTreeMap<String, f64>,
    /// Position of each of them where closing ends when nothing is met, rad or m.
    pub closed: BTreeMap<String, f64>,
    /// Coulomb friction coefficient of its contacts, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// Where H is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum HandFrame {
    /// A link of the URDF that does not move in the palm.
    Link { tcp_link: String },
    /// A pose in the palm.
    Pose(Placement),
}

/// A pose as URDF writes it: metres, and roll, pitch, yaw about fixed axes in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Position, metres.
    pub xyz: [f64; 3],
    /// Roll, pitch, yaw, radians.
    #[serde(default)]
    pub rpy: [f64; 3],
}

impl Placement {
    /// A pose, its rotation as the three angles with the pitch within a quarter turn.
    pub fn of(X: &Isometry3<f64>) -> Self {
        let R = X.rotation.to_rotation_matrix();
        let across = (R[(0, 0)] * R[(0, 0)] + R[(1, 0)] * R[(1, 0)]).sqrt();
        let pitch = crate::math::atan2(-R[(2, 0)], across);
        // Where x points up or down, roll and yaw turn about one axis: the yaw is left at 0.
        let (roll, yaw) = if across > 1e-9 {
            (crate::math::atan2(R[(2, 1)], R[(2, 2)]), crate::math::atan2(R[(1, 0)], R[(0, 0)]))
        } else {
            (crate::math::atan2(-R[(1, 2)], R[(1, 1)]), 0.0)
        };
        Self { xyz: X.translation.vector.into(), rpy: [roll, pitch, yaw] }
    }

    /// The pose.
    pub fn isometry(&self) -> Isometry3<f64> {
        let [x, y, z] = self.xyz;
        Isometry3::from_parts(Translation3::new(x, y, z), xml::from_rpy(self.rpy))
    }
}

/// What is wrong with a hand description, or why its hand cannot be attached.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HandError {
    /// Not JSON, or not our fields.
    #[error("not a hand description: {reason}")]
    Format { reason: String },
    /// Written for a later program.
    #[error("the hand description has version {found}; this program reads version {HAND_VERSION}")]
    Version { found: u32 },
    /// A file name where only the text itself will do.
    #[error("urdf: found {found:?}, wanted the text of the URDF, starting with <")]
    NoText { found: String },
    /// The URDF itself.
    #[error("urdf: {0}")]
    Urdf(#[from] RobotError),
    /// A number outside its range.
    #[error("{place}: found {found}, wanted {wanted}")]
    Value { place: String, found: String, wanted: String },
    /// A name that the URDF does not have.
    #[error("{place}: the URDF has no {kind} {name:?}; it has {}", known.join(", "))]
    UnknownName { place: String, kind: &'static str, name: String, known: Vec<String> },
    /// A palm or a frame that a joint moves.
    #[error("{place}: joint {joint:?} moves {link:?}, wanted a link that is fixed to {to}")]
    Moves { place: &'static str, link: String, joint: String, to: &'static str },
    /// A joint outside the hand's fingers.
    #[error("{place}: joint {joint:?} does not descend from {from:?}")]
    NotBelow { place: String, joint: String, from: String },
    /// A joint that nobody can command.
    #[error("{place}: joint {joint:?} is {found}, wanted a revolute or prismatic joint of its own")]
    NoMotion { place: String, joint: String, found: &'static str },
    /// A joint in two places.
    #[error("{place}: joint {joint:?} is listed already")]
    ListedTwice { place: String, joint: String },
    /// A joint that moves, but that no finger lists.
    #[error("joint {joint:?} moves, but no finger lists it: list it, or make it fixed in the URDF")]
    Unlisted { joint: String },
    /// A finger with nothing to touch with.
    #[error("{place}: its joints move no link with a collision body")]
    NoBody { place: String },
    /// A joint without a position.
    #[error("{place}: found no position of joint {joint:?}")]
    NoPosition { place: &'static str, joint: String },
    /// The robot lacks the arm.
    #[error("{robot} has no {arm} arm")]
    NoArm { robot: String, arm: String },
    /// The robot has something of this name.
    #[error("{robot} has a {kind} {name:?} already: rename it in the hand's URDF")]
    NameTaken { robot: String, kind: &'static str, name: String },
}

/// A description that was found right: the hand as a robot of its own, with the frame H among its links.
#[derive(Clone, Debug)]
pub(super) struct ReadHand {
    /// Links and joints of the hand alone.
    pub(super) tree: Robot,
    pub(super) palm: usize,
    pub(super) tcp: usize,
    /// Degrees of freedom of the tree, finger by finger.
    pub(super) fingers: Vec<Vec<usize>>,
    /// Positions in the order of the fingers.
    pub(super) open: Vec<f64>,
    pub(super) closed: Vec<f64>,
}

impl HandDescription {
    /// Reads a description whose URDF stands in it as text and checks all of it but its meshes.
    ///
    /// # Errors
    /// [`HandError`] naming the place, what was found and what was wanted.
    pub fn parse(json: &str) -> Result<Self, HandError> {
        let hand: Self = serde_json::from_str(json).map_err(|error| HandError::Format { reason: error.to_string() })?;
        hand.check()?;
        Ok(hand)
    }

    /// Checks everything but its meshes.
    ///
    /// # Errors
    /// As [`HandDescription::parse`].
    pub fn check(&self) -> Result<(), HandError> {
        self.read(&|_| None).map(drop)
    }

    /// Whether JSON is meant as a hand description, however wrong it may be: it names a palm.
    pub fn is_meant_by(json: &serde_json::Value) -> bool {
        json.get("palm_link").is_some()
    }

    /// The hand as a tree of links; whether its fingers have bodies is known once its meshes are.
    pub(super) fn read(&self, resolve: &Resolve<'_>) -> Result<Loaded<ReadHand>, HandError> {
        self.check_numbers()?;
        if !self.urdf.trim_start().starts_with('<') {
            return Err(HandError::NoText { found: self.urdf.chars().take(60).collect() });
        }
        let Loaded { value: mut tree, notes } = read_urdf(&self.urdf, resolve)?;
        let palm = link_named(&tree, "palm_link", &self.palm_link)?;
        let root = tree.body_root(palm);
        if root != 0 {
            return Err(moves("palm_link", &tree, palm, root, "the root of the URDF"));
        }
        let tcp = match &self.frame {
            HandFrame::Link { tcp_link } => {
                let tcp = link_named(&tree, "frame.tcp_link", tcp_link)?;
                match tree.body_root(tcp) {
                    0 => tcp,
                    root => return Err(moves("frame.tcp_link", &tree, tcp, root, "the palm")),
                }
            }
            HandFrame::Pose(X_PH) => add_frame(&mut tree, palm, X_PH)?,
        };
        let fingers = self.read_fingers(&tree, palm)?;
        let positions = |place, given: &BTreeMap<String, f64>| self.positions(&tree, &fingers, place, given);
        let (open, closed) = (positions("open", &self.open)?, positions("closed", &self.closed)?);
        Ok(Loaded { value: ReadHand { palm, tcp, fingers, open, closed, tree }, notes })
    }

    fn check_numbers(&self) -> Result<(), HandError> {
        if self.version != HAND_VERSION {
            return Err(HandError::Version { found: self.version });
        }
        let mut placements = vec![("mount", &self.mount)];
        if let HandFrame::Pose(frame) = &self.frame {
            placements.push(("frame", frame));
        }
        for (place, Placement { xyz, rpy }) in placements {
            check(xyz.iter().all(|x| x.abs() <= MAX_SHIFT_M), &format!("{place}.xyz"), xyz, "within 1 m")?;
            // Two full turns: more is degrees.
            check(rpy.iter().all(|a| a.abs() <= 12.6), &format!("{place}.rpy"), rpy, "radians within two full turns")?;
        }
        if let Some(friction) = self.friction {
            check((FRICTION[0]..=FRICTION[1]).contains(&friction), "friction", friction, "from 0.01 to 5")?;
        }
        let fingers = self.fingers.len();
        check((1..=MAX_FINGERS).contains(&fingers), "fingers", fingers, "1 to 10 lists of joints")
    }

    fn read_fingers(&self, tree: &Robot, palm: usize) -> Result<Vec<Vec<usize>>, HandError> {
        let mut listed: Vec<usize> = Vec::new();
        let mut fingers = Vec::new();
        for (number, names) in self.fingers.iter().enumerate() {
            let place = format!("fingers[{number}]");
            check(!names.is_empty(), &place, 0, "at least one joint")?;
            let mut above = palm;
            let mut finger = Vec::new();
            for (index, name) in names.iter().enumerate() {
                let place = format!("{place}[{index}]");
                let joint = joint_named(tree, &place, name)?;
                let no_motion = |found| HandError::NoMotion { place: place.clone(), joint: name.clone(), found };
                let dof =
                    joint.dof.ok_or_else(|| no_motion(if joint.mimic.is_some() { "a mimic" } else { "fixed" }))?;
                if listed.contains(&dof) {
                    return Err(HandError::ListedTwice { place, joint: name.clone() });
                }
                if tree.chain(above, joint.child).is_none() {
                    let from = tree.links[above].name.clone();
                    return Err(HandError::NotBelow { place, joint: name.clone(), from });
                }
                above = joint.child;
                listed.push(dof);
                finger.push(dof);
            }
            fingers.push(finger);
        }
        match (0..tree.dof_count()).find(|dof| !listed.contains(dof)) {
            Some(dof) => Err(HandError::Unlisted { joint: tree.joints[tree.dof_joints[dof]].name.clone() }),
            None => Ok(fingers),
        }
    }

    fn positions(
        &self,
        tree: &Robot,
        fingers: &[Vec<usize>],
        place: &'static str,
        given: &BTreeMap<String, f64>,
    ) -> Result<Vec<f64>, HandError> {
        for name in given.keys() {
            joint_named(tree, place, name)?;
        }
        let position = |&dof: &usize| {
            let Joint { name, limit: JointLimit { lower, upper, .. }, .. } = &tree.joints[tree.dof_joints[dof]];
            let Some(&value) = given.get(name) else {
                return Err(HandError::NoPosition { place, joint: name.clone() });
            };
            let wanted = format!("between the joint's limits {lower} and {upper}");
            check((*lower..=*upper).contains(&value), &format!("{place}.{name}"), value, &wanted)?;
            Ok(value)
        };
        fingers.iter().flatten().map(position).collect()
    }
}

fn check(holds: bool, place: &str, found: impl std::fmt::Debug, wanted: &str) -> Result<(), HandError> {
    let value = || HandError::Value { place: place.into(), found: format!("{found:?}"), wanted: wanted.into() };
    if holds { Ok(()) } else { Err(value()) }
}

fn link_named(tree: &Robot, place: &str, name: &str) -> Result<usize, HandError> {
    tree.link_index(name).ok_or_else(|| HandError::UnknownName {
        place: place.to_owned(),
        kind: "link",
        name: name.to_owned(),
        known: tree.links.iter().map(|link| link.name.clone()).collect(),
    })
}

fn joint_named<'a>(tree: &'a Robot, place: &str, name: &str) -> Result<&'a Joint, HandError> {
    tree.joints.iter().find(|joint| joint.name == name).ok_or_else(|| HandError::UnknownName {
        place: place.to_owned(),
        kind: "joint",
        name: name.to_owned(),
        known: tree.joints.iter().map(|joint| joint.name.clone()).collect(),
    })
}

fn moves(place: &'static str, tree: &Robot, link: usize, root: usize, to: &'static str) -> HandError {
    let joint = tree.moving_joint(root).map_or_else(String::new, |joint| joint.name.clone());
    HandError::Moves { place, link: tree.links[link].name.clone(), joint, to }
}

/// A link for a frame that is given as a pose, the last of the tree.
fn add_frame(tree: &mut Robot, palm: usize, X_PH: &Placement) -> Result<usize, HandError> {
    if tree.link_index(FRAME_LINK).is_some() {
        let wanted = format!("no frame by pose, since the URDF has a link {FRAME_LINK:?}, which should be tcp_link");
        check(false, "frame", X_PH, &wanted)?;
    }
    let child = tree.links.len();
    tree.links.push(Link { name: FRAME_LINK.to_owned(), visuals: Vec::new(), collisions: Vec::new() });
    tree.joints.push(Joint {
        name: format!("{FRAME_LINK}_joint"),
        kind: JointKind::Fixed,
        parent: palm,
        child,
        X_PJ: X_PH.isometry(),
        axis: nalgebra::Vector3::x_axis(),
        limit: JointLimit { lower: 0.0, upper: 0.0, velocity: 1.0, acceleration: 1.0, jerk: 10.0 },
        mimic: None,
        dof: None,
    });
    Ok(child)
}

/// Text, or a list of lines.
fn text_or_lines<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Either {
        Text(String),
        Lines(Vec<String>),
    }
    Ok(match Either::deserialize(deserializer)? {
        Either::Text(text) => text,
        Either::Lines(lines) => lines.join("\n"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::samples::hand;

    #[test]
    fn a_placement_is_the_pose_that_it_was_made_of() {
        let mut rng = crate::rng::Rng::new(4, 0);
        let mut angle = || rng.uniform(-3.0, 3.0);
        for k in 0..200 {
            let pitch = if k % 4 == 0 { std::f64::consts::FRAC_PI_2 } else { angle() };
            let X = Placement { xyz: [angle(), 0.2, -1.0], rpy: [angle(), pitch, angle()] }.isometry();
            let again = Placement::of(&X).isometry();
            assert!((X.to_homogeneous() - again.to_homogeneous()).amax() < 1e-9, "{X}");
        }
    }

    #[test]
    fn a_description_is_written_and_read_again() {
        for file in ["pg70.json", "sdh.json", "adaptive.json"] {
            let hand = hand(file);
            let json = serde_json::to_string(&hand).unwrap();
            assert_eq!(HandDescription::parse(&json).unwrap(), hand);
            assert!(HandDescription::is_meant_by(&serde_json::from_str(&json).unwrap()));
        }
    }

    #[test]
    fn the_frame_may_be_a_link_or_a_pose() {
        let read = hand("adaptive.json").read(&|_| None).unwrap().value;
        let X_RL = read.tree.link_poses(&vec![0.0; read.tree.dof_count()]);
        let X_PH = X_RL[read.palm].inv_mul(&X_RL[read.tcp]);
        assert!((X_PH.translation.vector.z - 0.17).abs() < 1e-15 && X_PH.rotation.angle() < 1e-12);
        let by_link = hand("pg70.json").read(&|_| None).unwrap().value;
        assert_eq!(by_link.tree.links[by_link.tcp].name, "tcp");
    }

    #[test]
    fn every_mistake_is_named_with_its_place() {
        type Change = fn(&mut HandDescription);
        let cases: [(Change, &str); 17] = [
            (|h| h.version = 2, "has version 2; this program reads version 1"),
            (|h| h.urdf = "hands/mine.urdf".into(), "urdf: found \"hands/mine.urdf\", wanted the text of the URDF"),
            (|h| h.urdf.truncate(300), "urdf: URDF is not well-formed XML"),
            (
                |h| h.palm_link = "hand".into(),
                "palm_link: the URDF has no link \"hand\"; it has adapter, palm, left_inner",
            ),
            (
                |h| h.palm_link = "left_pad".into(),
                "palm_link: joint \"left_joint\" moves \"left_pad\", wanted a link that",
            ),
            (
                |h| h.frame = HandFrame::Link { tcp_link: "tool".into() },
                "frame.tcp_link: the URDF has no link \"tool\"",
            ),
            (
                |h| h.frame = HandFrame::Link { tcp_link: "right_pad".into() },
                "frame.tcp_link: joint \"right_joint\" moves \"right_pad\", wanted a link that is fixed to the palm",
            ),
            (|h| h.mount.xyz[2] = 30.0, "mount.xyz: found [0.0, 0.0, 30.0], wanted within 1 m"),
            (|h| h.mount.rpy[2] = 90.0, "mount.rpy: found [0.0, 0.0, 90.0], wanted radians"),
            (|h| h.fingers.clear(), "fingers: found 0, wanted 1 to 10 lists of joints"),
            (
                |h| h.fingers[0][1] = "elbow".into(),
                "fingers[0][1]: the URDF has no joint \"elbow\"; it has palm_joint,",
            ),
            (|h| h.fingers[0].insert(0, "palm_joint".into()), "fingers[0][0]: joint \"palm_joint\" is fixed, wanted a"),
            (|h| h.fingers[0].reverse(), "fingers[0][1]: joint \"left_knuckle\" does not descend from \"left_pad\""),
            (|h| h.fingers[1] = h.fingers[0].clone(), "fingers[1][0]: joint \"left_knuckle\" is listed already"),
            (|h| drop(h.fingers.pop()), "joint \"right_knuckle\" moves, but no finger lists it"),
            (|h| h.closed.retain(|name, _| name != "left_joint"), "closed: found no position of joint \"left_joint\""),
            (
                |h| h.open.extend([("left_knuckle".into(), -2.0)]),
                "open.left_knuckle: found -2.0, wanted between the joint's limits -0.7 and 0.9",
            ),
        ];
        for (change, wanted) in cases {
            let mut wrong = hand("adaptive.json");
            change(&mut wrong);
            let said = wrong.check().unwrap_err().to_string();
            assert!(said.contains(wanted), "{said} should say {wanted}");
        }
        let json = serde_json::to_string(&hand("adaptive.json")).unwrap().replace("palm_link", "plam_link");
        assert!(
            HandDescription::parse(&json).unwrap_err().to_string().contains("not a hand description: unknown field")
        );
    }
}
