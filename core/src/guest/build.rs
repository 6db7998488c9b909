//! From a guest's files to a robot that acts: its URDF with a stand and hand frames, and an SRDF of our kind.

use std::fmt::Write as _;

use super::boxes::add_boxes;
use super::fingers::Fingers;
use super::stand::column;
use super::{ArmDescription, GuestError, GuestRobot, LEAST_JOINTS, READY};
use crate::loaded::Loaded;
use crate::robot::{
    JointKind, MissingMesh, Placement, Resolve, Robot, RobotError, apply_srdf, read_urdf, read_urdf_and_missing,
    srdf_hints,
};

/// Link below the robot's root, in the world.
const STAND: &str = "stand";
/// Group of an SRDF that holds every state.
const EVERYTHING: &str = "endcomfort_everything";

/// A robot that was made from a guest's files.
#[derive(Clone, Debug)]
pub struct BuiltGuest {
    /// The robot, named as scenes name it.
    pub robot: Robot,
    /// What was left out or repaired.
    pub notes: Vec<String>,
    /// Bodies for which marked boxes stand.
    pub missing: Vec<MissingMesh>,
}

impl GuestRobot {
    /// Makes the robot.
    ///
    /// * `own`: gives meshes that travel inside the program, for the hand that an arm was given.
    ///
    /// # Errors
    /// [`GuestError`] when the files are wrong or do not fit the description.
    pub fn build(&self, own: &Resolve<'_>) -> Result<BuiltGuest, GuestError> {
        let file = &self.description.urdf;
        let of_urdf = |source: RobotError| GuestError::Robot { file: file.clone(), source };
        let resolve = |uri: &str| self.mesh(uri, own);
        let bare = read_urdf(&self.urdf, &resolve).map_err(of_urdf)?.value;
        let mut text = Text::of(self, &bare)?;
        for arm in &self.description.arms {
            text.add_arm(arm)?;
        }
        let (urdf, srdf) = text.finished();
        let (Loaded { value: mut robot, notes }, missing) = read_urdf_and_missing(&urdf, &resolve).map_err(of_urdf)?;
        add_boxes(&mut robot, &missing);
        let boxed = |note: String| note.replace(" is left out: ", " is drawn as a marked box: ");
        let mut notes: Vec<String> = notes.into_iter().map(boxed).collect();
        apply_srdf(&mut robot, &srdf, &mut notes).map_err(of_urdf)?;
        robot.name = self.name();
        for arm in &self.description.arms {
            if let Some(hand) = &arm.hand {
                let place = || format!("hand of the {} arm", arm.name);
                let with = robot.with_hand(&arm.name, hand, own);
                let with = with.map_err(|source| GuestError::Hand { place: place(), source })?;
                robot = with.value;
                notes.extend(with.notes);
            }
        }
        Ok(BuiltGuest { robot, notes, missing })
    }
}

/// The link of a name, or the error that lists what there is.
pub(super) fn link_named(robot: &Robot, place: &str, name: &str) -> Result<usize, GuestError> {
    robot.link_index(name).ok_or_else(|| GuestError::UnknownLink {
        place: place.to_owned(),
        name: name.to_owned(),
        known: robot.links.iter().map(|link| link.name.clone()).collect(),
    })
}

/// Base and tip of an arm, checked: a chain with enough joints.
pub(super) fn chain_of(robot: &Robot, place: &str, base: &str, tip: &str) -> Result<(usize, usize), GuestError> {
    let ends = (link_named(robot, place, base)?, link_named(robot, place, tip)?);
    let (place, base, tip) = (place.to_owned(), base.to_owned(), tip.to_owned());
    let Some(chain) = robot.chain(ends.0, ends.1) else { return Err(GuestError::NotAChain { place, base, tip }) };
    let found = chain.iter().filter(|&&joint| robot.joints[joint].dof.is_some()).count();
    if found < LEAST_JOINTS {
        return Err(GuestError::ShortArm { place, base, tip, found, wanted: LEAST_JOINTS });
    }
    Ok(ends)
}

/// URDF and SRDF while they are written.
struct Text<'a> {
    guest: &'a GuestRobot,
    bare: &'a Robot,
    /// What is put before the end of the URDF.
    added: String,
    /// Names of links that joints move in place of those that the file says: joint, link.
    moved: Vec<(String, String)>,
    srdf: String,
    /// Positions of open fingers, which are part of every posture that does not say otherwise.
    open: Vec<(String, f64)>,
}

impl<'a> Text<'a> {
    fn of(guest: &'a GuestRobot, bare: &'a Robot) -> Result<Self, GuestError> {
        let X_WR = guest.description.stand.unwrap_or_default();
        let mut text =
            Self { guest, bare, added: String::new(), moved: Vec::new(), srdf: String::new(), open: Vec::new() };
        let body = column(bare, &X_WR.isometry()).map_or_else(String::new, |(size_m, X_WC)| {
            let p = X_WC.translation;
            let body = format!(
                "<origin xyz=\"{} {} {}\"/><geometry><box size=\"{} {} {}\"/></geometry>",
                p.x, p.y, p.z, size_m.x, size_m.y, size_m.z
            );
            let look = "<material name=\"joint\"><color rgba=\"0.1 0.1 0.12 1\"/></material>";
            format!("<visual>{body}{look}</visual><collision>{body}</collision>")
        });
        text.link(STAND, &body)?;
        let root = bare.links[0].name.clone();
        text.weld(STAND, &root, &X_WR)?;
        Ok(text)
    }

    fn link(&mut self, name: &str, inside: &str) -> Result<(), GuestError> {
        if self.bare.link_index(name).is_some() {
            return Err(GuestError::NameTaken { kind: "link", name: name.to_owned() });
        }
        // Writing into a string cannot fail.
        let _ = writeln!(self.added, "<link name=\"{}\">{inside}</link>", escaped(name));
        Ok(())
    }

    fn weld(&mut self, parent: &str, child: &str, X_PC: &Placement) -> Result<(), GuestError> {
        let name = format!("endcomfort_{parent}_to_{child}");
        if self.bare.joints.iter().any(|joint| joint.name == name) {
            return Err(GuestError::NameTaken { kind: "joint", name });
        }
        let ([x, y, z], [roll, pitch, yaw]) = (X_PC.xyz, X_PC.rpy);
        let _ = writeln!(
            self.added,
            "<joint name=\"{}\" type=\"fixed\"><parent link=\"{}\"/><child link=\"{}\"/>\
             <origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/></joint>",
            escaped(&name),
            escaped(parent),
            escaped(child)
        );
        Ok(())
    }

    /// Frames of an arm and its hand, and their groups.
    fn add_arm(&mut self, arm: &ArmDescription) -> Result<(), GuestError> {
        let place = format!("{} arm", arm.name);
        let (_, tip) = chain_of(self.bare, &place, &arm.base_link, &arm.tip_link)?;
        let (name, tcp) = (&arm.name, format!("{}_tcp", arm.name));
        self.link(&tcp, "")?;
        let flange;
        let mut links = vec![tcp.clone()];
        if arm.hand.is_some() {
            // The described hand takes the place of the mount.
            let mount = format!("{name}_mount");
            flange = format!("{name}_flange");
            self.link(&flange, "")?;
            self.link(&mount, "")?;
            self.weld(&arm.tip_link, &flange, &arm.tcp)?;
            self.weld(&flange, &mount, &Placement::default())?;
            self.weld(&mount, &tcp, &Placement::default())?;
            links.push(mount);
        } else {
            let no_fingers = || GuestError::NoFingers { place: place.clone(), tip: arm.tip_link.clone() };
            let fingers = Fingers::below(self.bare, tip).ok_or_else(no_fingers)?;
            let palm = fingers.palm;
            self.weld(&arm.tip_link, &tcp, &arm.tcp)?;
            let below = (0..self.bare.links.len()).filter(|&link| self.bare.chain(palm, link).is_some());
            links.extend(below.map(|link| self.bare.links[link].name.clone()));
            flange = self.flange_above(palm)?;
            // A hand frame beside the palm hangs on it, for the hand is one tree.
            if self.bare.chain(palm, tip).is_none() {
                return Err(GuestError::Value {
                    place: format!("{place}, tip_link"),
                    found: arm.tip_link.clone(),
                    wanted: format!("{:?}, which carries the fingers, or a link below it", self.bare.links[palm].name),
                });
            }
            for &(dof, open, closed) in &fingers.ends {
                let joint = self.bare.joints[self.bare.dof_joints[dof]].name.clone();
                for (state, position) in [("open", open), ("closed", closed)] {
                    let _ = writeln!(
                        self.srdf,
                        "<group_state name=\"{state}\" group=\"{name}_hand\"><joint name=\"{}\" value=\"{position}\"/>\
                         </group_state>",
                        escaped(&joint)
                    );
                }
                self.open.push((joint, open));
            }
        }
        let group: String = links.iter().map(|link| format!("<link name=\"{}\"/>", escaped(link))).collect();
        let _ = writeln!(
            self.srdf,
            "<group name=\"{name}\"><chain base_link=\"{}\" tip_link=\"{}\"/></group>\n\
             <group name=\"{name}_hand\">{group}</group>\n\
             <end_effector name=\"{name}_hand\" group=\"{name}_hand\" parent_group=\"{name}\"/>",
            escaped(&arm.base_link),
            escaped(&flange)
        );
        Ok(())
    }

    /// The link above a palm: its parent, or where a joint of the arm moves the palm itself, a new link that the joint
    /// moves in its place.
    fn flange_above(&mut self, palm: usize) -> Result<String, GuestError> {
        let name = self.bare.links[palm].name.clone();
        let Some(joint) = self.bare.moving_joint(palm) else {
            return Err(GuestError::Value {
                place: "tip_link".to_owned(),
                found: name,
                wanted: "a link that the arm moves".to_owned(),
            });
        };
        if joint.kind == JointKind::Fixed {
            return Ok(self.bare.links[joint.parent].name.clone());
        }
        let carrier = format!("{name}_carrier");
        self.link(&carrier, "")?;
        self.weld(&carrier, &name, &Placement::default())?;
        self.moved.push((joint.name.clone(), carrier.clone()));
        Ok(carrier)
    }

    /// The two files.
    fn finished(self) -> (String, String) {
        (self.urdf(), self.whole_srdf())
    }

    fn urdf(&self) -> String {
        let urdf = &self.guest.urdf;
        // It has been read before.
        let Ok(document) = roxmltree::Document::parse(urdf) else { return urdf.clone() };
        let root = document.root_element();
        let end = urdf[..root.range().end].rfind("</").unwrap_or(root.range().end);
        let mut edits = vec![(end..end, self.added.clone())];
        for (joint, link) in &self.moved {
            let is_it = |node: &roxmltree::Node<'_, '_>| {
                node.has_tag_name("joint") && node.attribute("name").is_some_and(|name| name.trim() == joint)
            };
            let child = root.children().find(is_it).and_then(|node| node.children().find(|n| n.has_tag_name("child")));
            if let Some(attribute) = child.and_then(|child| child.attribute_node("link")) {
                edits.push((attribute.range_value(), escaped(link)));
            }
        }
        edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
        let mut text = urdf.clone();
        edits.into_iter().for_each(|(range, new)| text.replace_range(range, &new));
        text
    }

    /// Our groups, with what the robot's own SRDF says; or, where our way of naming arms is its own, that SRDF.
    fn whole_srdf(&self) -> String {
        let root = escaped(&self.bare.links[0].name);
        let mut states = format!("<group name=\"{EVERYTHING}\"><link name=\"{root}\"/></group>\n");
        let mut state = |name: &str, joints: &mut dyn Iterator<Item = (&str, f64)>| {
            let joints: String = joints
                .map(|(joint, value)| format!("<joint name=\"{}\" value=\"{value}\"/>", escaped(joint)))
                .collect();
            let _ = writeln!(
                states,
                "<group_state name=\"{}\" group=\"{EVERYTHING}\">{joints}</group_state>",
                escaped(name)
            );
        };
        let open = || self.open.iter().map(|(joint, position)| (joint.as_str(), *position));
        let posture = &self.guest.description.posture;
        let known = |joint: &&String| self.bare.joints.iter().any(|other| other.name == **joint);
        let chosen = posture.iter().filter(|(joint, _)| known(joint)).map(|(joint, value)| (joint.as_str(), *value));
        state(READY, &mut open().chain(chosen));
        let own = self.guest.srdf.as_deref();
        if self.guest.description.arms.is_empty() {
            let end = own.and_then(|srdf| srdf.rfind("</"));
            let Some((srdf, end)) = own.zip(end) else { return format!("<robot>\n{states}</robot>") };
            return format!("{}{states}{}", &srdf[..end], &srdf[end..]);
        }
        // What it says of links and joints that are there; it has been read before.
        let hints = own.and_then(|srdf| srdf_hints(self.bare, srdf, LEAST_JOINTS).ok()).unwrap_or_default();
        for (name, joints) in hints.states.iter().filter(|(name, _)| name != READY) {
            state(name, &mut open().chain(joints.iter().map(|(joint, value)| (joint.as_str(), *value))));
        }
        for (a, b) in &hints.disabled {
            let _ = writeln!(states, "<disable_collisions link1=\"{}\" link2=\"{}\"/>", escaped(a), escaped(b));
        }
        format!("<robot>\n{}{states}</robot>", self.srdf)
    }
}

/// Text inside an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
