//! SRDF: which joints are arms and hands, what the postures are called, which links may touch.
//!
//! Conventions (see `robots/README.md`): an `<end_effector group="left_hand" parent_group="left"/>` makes the group
//! `left` an arm and `left_hand` its hand; the hand group contains the link `left_tcp`, whose frame is the hand frame
//! H; the states `open` and `closed` of the hand group say how it closes. All other states of one name are merged,
//! over all groups, into one posture.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::urdf::{Resolve, read_urdf, remember};
use super::{Arm, Hand, JointKind, Robot, RobotError, xml};
use crate::collision::AllowedCollisions;
use crate::loaded::Loaded;

/// Reads a robot from its URDF and SRDF.
///
/// # Errors
/// [`RobotError`] for whatever makes one of the files unusable.
pub fn load_robot(urdf: &str, srdf: &str, resolve: &Resolve<'_>) -> Result<Loaded<Robot>, RobotError> {
    let mut loaded = read_urdf(urdf, resolve)?;
    apply_srdf(&mut loaded.value, srdf, &mut loaded.notes)?;
    Ok(loaded)
}

/// Fills the robot's arms, hands, postures and allowed collisions: those that [`AllowedCollisions`] computes, and those
/// that the SRDF adds. Bodies that collisions cannot be computed for become a note.
///
/// # Errors
/// [`RobotError`] when a name is unknown, a group is no chain, or a hand has no hand frame.
pub fn apply_srdf(robot: &mut Robot, srdf: &str, notes: &mut Vec<String>) -> Result<(), RobotError> {
    let document = xml::parse("SRDF", srdf)?;
    let root = document.root_element();
    let groups = Groups::read(robot, root)?;
    let mut arms = Vec::new();
    for node in xml::children(root, "end_effector") {
        arms.push(read_arm(robot, &groups, node)?);
    }
    robot.arms = arms;
    read_states(robot, &groups, root, notes)?;
    robot.allowed_collisions = allowed_collisions(robot, root, notes)?;
    Ok(())
}

/// What any SRDF says of a robot, whether it keeps to our conventions or not.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SrdfHints {
    /// Base link and tip link of each chain that carries an end effector; without end effectors, of each long chain.
    pub(crate) arms: Vec<(usize, usize)>,
    /// States: name, and joints with their positions.
    pub(crate) states: Vec<(String, BTreeMap<String, f64>)>,
    /// Names of links that need not be looked at together.
    pub(crate) disabled: Vec<(String, String)>,
}

/// Reads the hints of an SRDF; chains shorter than `least_joints` are no arms.
///
/// # Errors
/// [`RobotError`] when a name is unknown or a group is no chain.
pub(crate) fn srdf_hints(robot: &Robot, srdf: &str, least_joints: usize) -> Result<SrdfHints, RobotError> {
    let document = xml::parse("SRDF", srdf)?;
    let root = document.root_element();
    let groups = Groups::read(robot, root)?;
    let mut hints = SrdfHints::default();
    let ends_of = |group: &Group| {
        let dofs = dofs_of(robot, group);
        let (&first, &last) = dofs.first().zip(dofs.last())?;
        let of_joints = (robot.joints[robot.dof_joints[first]].parent, robot.joints[robot.dof_joints[last]].child);
        let (base, tip) = group.chain.unwrap_or(of_joints);
        (dofs.len() >= least_joints && robot.chain(base, tip).is_some()).then_some((base, tip))
    };
    for node in xml::children(root, "end_effector") {
        let Some(name) = node.attribute("parent_group") else { continue };
        let Some((base, tip)) = groups.read.get(name).and_then(ends_of) else { continue };
        let stated = node.attribute("parent_link").and_then(|name| robot.link_index(name));
        let tip = stated.filter(|&link| robot.chain(tip, link).is_some()).unwrap_or(tip);
        hints.arms.push((base, tip));
    }
    if hints.arms.is_empty() {
        hints.arms.extend(groups.read.values().filter(|group| group.chain.is_some()).filter_map(ends_of));
        hints.arms.sort_unstable();
    }
    hints.arms.dedup();
    for node in xml::children(root, "group_state") {
        let mut joints = BTreeMap::new();
        for joint in xml::children(node, "joint") {
            let index = joint_named(robot, joint, "group_state")?;
            if let Some(value) = xml::number(joint, "value", "group_state")? {
                joints.insert(robot.joints[index].name.clone(), value);
            }
        }
        hints.states.push((xml::text(node, "name", "group_state")?.to_owned(), joints));
    }
    for node in xml::children(root, "disable_collisions") {
        let name = |attribute| {
            link_named(robot, node, attribute, "disable_collisions").map(|link| robot.links[link].name.clone())
        };
        hints.disabled.push((name("link1")?, name("link2")?));
    }
    Ok(hints)
}

/// A group: the links it moves, and the tip of its chain when it is one.
#[derive(Clone, Debug, Default)]
struct Group {
    links: BTreeSet<usize>,
    chain: Option<(usize, usize)>,
}

struct Groups<'a, 'd> {
    nodes: BTreeMap<String, Node<'a, 'd>>,
    read: BTreeMap<String, Group>,
}

impl<'a, 'd> Groups<'a, 'd> {
    fn read(robot: &Robot, root: Node<'a, 'd>) -> Result<Self, RobotError> {
        let mut lines = BTreeMap::new();
        let mut groups = Groups { nodes: BTreeMap::new(), read: BTreeMap::new() };
        for node in xml::children(root, "group") {
            let name = xml::text(node, "name", "group")?;
            remember("group", name, node, &mut lines)?;
            groups.nodes.insert(name.to_owned(), node);
        }
        let names: Vec<String> = groups.nodes.keys().cloned().collect();
        for name in &names {
            groups.expand(robot, name, &mut Vec::new())?;
        }
        Ok(groups)
    }

    /// The group with everything it contains; read once, however often it is contained.
    fn expand(&mut self, robot: &Robot, name: &str, inside: &mut Vec<String>) -> Result<Group, RobotError> {
        if let Some(known) = self.read.get(name) {
            return Ok(known.clone());
        }
        let Some(&node) = self.nodes.get(name) else { return Ok(Group::default()) };
        if inside.iter().any(|outer| outer == name) {
            return Err(RobotError::GroupLoop { line: xml::line(node), group: name.to_owned() });
        }
        inside.push(name.to_owned());
        let thing = format!("group {name:?}");
        let mut group = Group::default();
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "link" => {
                    group.links.insert(link_named(robot, part, "name", &thing)?);
                }
                "joint" => {
                    group.links.insert(robot.joints[joint_named(robot, part, &thing)?].child);
                }
                "chain" => {
                    let base = link_named(robot, part, "base_link", &thing)?;
                    let tip = link_named(robot, part, "tip_link", &thing)?;
                    let chain = robot.chain(base, tip).ok_or_else(|| RobotError::NotAChain {
                        line: xml::line(part),
                        group: name.to_owned(),
                        base: robot.links[base].name.clone(),
                        tip: robot.links[tip].name.clone(),
                    })?;
                    group.links.extend(chain.iter().map(|&joint| robot.joints[joint].child));
                    group.chain = Some((base, tip));
                }
                "group" => {
                    let inner = xml::text(part, "name", &thing)?;
                    if !self.nodes.contains_key(inner) {
                        return Err(unknown(part, &thing, "group", inner));
                    }
                    group.links.extend(self.expand(robot, inner, inside)?.links);
                }
                _ => {}
            }
        }
        inside.pop();
        self.read.insert(name.to_owned(), group.clone());
        Ok(group)
    }

    fn named(&self, node: Node<'_, '_>, attribute: &str, thing: &str) -> Result<(&str, &Group), RobotError> {
        let name = xml::text(node, attribute, thing)?;
        self.read
            .get_key_value(name)
            .map(|(name, group)| (name.as_str(), group))
            .ok_or_else(|| unknown(node, thing, "group", name))
    }
}

fn unknown(node: Node<'_, '_>, thing: &str, kind: &'static str, name: &str) -> RobotError {
    RobotError::UnknownName { line: xml::line(node), thing: thing.to_owned(), kind, name: name.to_owned() }
}

fn link_named(robot: &Robot, node: Node<'_, '_>, attribute: &str, thing: &str) -> Result<usize, RobotError> {
    let name = xml::text(node, attribute, thing)?;
    robot.link_index(name).ok_or_else(|| unknown(node, thing, "link", name))
}

fn joint_named(robot: &Robot, node: Node<'_, '_>, thing: &str) -> Result<usize, RobotError> {
    let name = xml::text(node, "name", thing)?;
    robot.joints.iter().position(|joint| joint.name == name).ok_or_else(|| unknown(node, thing, "joint", name))
}

/// Degrees of freedom that move the group's links, in the order of `q`.
fn dofs_of(robot: &Robot, group: &Group) -> Vec<usize> {
    let dofs: BTreeSet<usize> = group.links.iter().filter_map(|&link| robot.moving_joint(link)?.dof).collect();
    dofs.into_iter().collect()
}

fn read_arm(robot: &Robot, groups: &Groups<'_, '_>, node: Node<'_, '_>) -> Result<Arm, RobotError> {
    let thing = "end_effector";
    let (name, arm) = groups.named(node, "parent_group", thing)?;
    let (hand_name, hand) = groups.named(node, "group", thing)?;
    let line = xml::line(node);
    let dofs = dofs_of(robot, arm);
    let (Some(&first), Some(&last)) = (dofs.first(), dofs.last()) else {
        return Err(RobotError::EmptyArm { line, group: name.to_owned() });
    };
    let (base_link, flange_link) =
        arm.chain.unwrap_or((robot.joints[robot.dof_joints[first]].parent, robot.joints[robot.dof_joints[last]].child));
    Ok(Arm {
        name: name.to_owned(),
        dofs,
        base_link,
        flange_link,
        hand: read_hand(robot, name, hand_name, hand, line)?,
    })
}

fn read_hand(robot: &Robot, arm: &str, name: &str, group: &Group, line: u32) -> Result<Hand, RobotError> {
    let wanted = format!("{arm}_tcp");
    let no_frame = || RobotError::NoHandFrame { line, group: name.to_owned(), wanted: wanted.clone() };
    let tcp_link = robot.link_index(&wanted).filter(|link| group.links.contains(link)).ok_or_else(no_frame)?;
    let hangs_outside =
        |link: &usize| link.checked_sub(1).is_none_or(|joint| !group.links.contains(&robot.joints[joint].parent));
    let mut tops = group.links.iter().copied().filter(|link| hangs_outside(link));
    let palm_link = tops.next().ok_or_else(no_frame)?;
    if let Some(second) = tops.next() {
        let link = |link: usize| robot.links[link].name.clone();
        let (first, second) = (link(palm_link), link(second));
        return Err(RobotError::HandInPieces { line, group: name.to_owned(), first, second });
    }
    // A finger starts at each degree of freedom that no other one of the hand moves.
    let mut fingers: Vec<Vec<usize>> = Vec::new();
    for dof in dofs_of(robot, group) {
        let mut top = dof;
        let mut link = robot.joints[robot.dof_joints[dof]].parent;
        while group.links.contains(&link) {
            let Some(joint) = robot.moving_joint(link) else { break };
            top = joint.dof.unwrap_or(top);
            link = joint.parent;
        }
        match fingers.iter_mut().find(|finger| finger.first() == Some(&top)) {
            Some(finger) => finger.push(dof),
            None => fingers.push(vec![dof]),
        }
    }
    let limits = fingers.iter().flatten().map(|&dof| robot.joints[robot.dof_joints[dof]].limit);
    let (open, closed) = limits.map(|limit| (limit.lower, limit.upper)).unzip();
    let links = group.links.iter().copied().collect();
    Ok(Hand { name: name.to_owned(), links, palm_link, tcp_link, fingers, open, closed })
}

fn read_states(
    robot: &mut Robot,
    groups: &Groups<'_, '_>,
    root: Node<'_, '_>,
    notes: &mut Vec<String>,
) -> Result<(), RobotError> {
    let mut postures: Vec<(String, Vec<f64>)> = Vec::new();
    for node in xml::children(root, "group_state") {
        let name = xml::text(node, "name", "group_state")?;
        let thing = format!("group_state {name:?}");
        let (group, _) = groups.named(node, "group", &thing)?;
        let mut values = Vec::new();
        for joint_node in xml::children(node, "joint") {
            let joint = &robot.joints[joint_named(robot, joint_node, &thing)?];
            let Some(value) = xml::number(joint_node, "value", &thing)? else {
                let line = xml::line(joint_node);
                return Err(RobotError::Missing { line, thing, wanted: format!("value for joint {:?}", joint.name) });
            };
            let Some(dof) = joint.dof else {
                notes.push(format!(
                    "line {}: {thing} sets {:?}, which does not move",
                    xml::line(joint_node),
                    joint.name
                ));
                continue;
            };
            let within = value.max(joint.limit.lower).min(joint.limit.upper);
            if within != value {
                let line = xml::line(joint_node);
                let name = &joint.name;
                notes.push(format!(
                    "line {line}: {thing} puts {name:?} at {value}, outside its limits: {within} is used"
                ));
            }
            values.push((dof, within));
        }
        if let Some(arm) = robot.arms.iter_mut().find(|arm| arm.hand.name == group)
            && (name == "open" || name == "closed")
        {
            let hand = &mut arm.hand;
            let ends = if name == "open" { &mut hand.open } else { &mut hand.closed };
            for (&dof, end) in hand.fingers.iter().flatten().zip(ends) {
                if let Some((_, value)) = values.iter().find(|(known, _)| *known == dof) {
                    *end = *value;
                }
            }
            continue;
        }
        let at = postures.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
            let rest = robot.dof_joints.iter().map(|&joint| {
                let limit = robot.joints[joint].limit;
                0.0f64.max(limit.lower).min(limit.upper)
            });
            postures.push((name.to_owned(), rest.collect()));
            postures.len() - 1
        });
        for (dof, value) in values {
            postures[at].1[dof] = value;
        }
    }
    robot.postures = postures;
    Ok(())
}

/// The pairs that the robot itself shows to need no look, and those of `<disable_collisions>`.
fn allowed_collisions(
    robot: &Robot,
    root: Node<'_, '_>,
    notes: &mut Vec<String>,
) -> Result<Vec<(usize, usize)>, RobotError> {
    let mut pairs = BTreeSet::new();
    match AllowedCollisions::compute(robot, AllowedCollisions::SEED) {
        Ok(computed) => pairs.extend(computed.pairs.iter().map(|pair| (pair.a, pair.b))),
        Err(error) => notes.push(format!("{error}: no pair of links is known that may touch")),
    }
    for node in xml::children(root, "disable_collisions") {
        let a = link_named(robot, node, "link1", "disable_collisions")?;
        let b = link_named(robot, node, "link2", "disable_collisions")?;
        if a != b {
            pairs.insert((a.min(b), a.max(b)));
        }
    }
    Ok(pairs.into_iter().collect())
}

impl Robot {
    /// Index of the link of this name.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// The joint that moves a link; `None` for the root.
    pub fn moving_joint(&self, link: usize) -> Option<&super::Joint> {
        self.joints.get(link.checked_sub(1)?)
    }

    /// Joint indices from `base` down to `tip`; `None` if `tip` does not descend from `base`.
    pub fn chain(&self, base: usize, tip: usize) -> Option<Vec<usize>> {
        let mut joints = Vec::new();
        let mut link = tip;
        while link != base {
            joints.push(link.checked_sub(1)?);
            link = self.moving_joint(link)?.parent;
        }
        joints.reverse();
        Some(joints)
    }

    /// The topmost link that is welded to this one by fixed joints.
    pub fn body_root(&self, link: usize) -> usize {
        let mut top = link;
        while let Some(joint) = self.moving_joint(top).filter(|joint| joint.kind == JointKind::Fixed) {
            top = joint.parent;
        }
        top
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::samples;

    const URDF: &str = "<robot name='r'><link name='base'/><link name='arm'/><link name='palm'/><link name='left_tcp'/>
        <joint name='swing' type='revolute'><parent link='base'/><child link='arm'/><limit lower='-1' upper='1'/></joint>
        <joint name='weld' type='fixed'><parent link='arm'/><child link='palm'/></joint>
        <joint name='tcp' type='fixed'><parent link='palm'/><child link='left_tcp'/></joint></robot>";

    fn load(srdf: &str) -> Result<Loaded<Robot>, RobotError> {
        load_robot(URDF, &format!("<robot>\n{srdf}\n</robot>"), &|_| None)
    }

    #[test]
    fn faults_are_named_with_their_line() {
        let hand = "<group name='left'><joint name='swing'/></group><group name='h'><link name='palm'/></group>";
        let cases = [
            (
                "<group name='g'><chain base_link='palm' tip_link='base'/></group>".to_owned(),
                "line 2: group \"g\": link \"base\" does not descend from \"palm\"",
            ),
            (
                "<group name='g'><joint name='nope'/></group>".to_owned(),
                "line 2: group \"g\" names joint \"nope\", which does not exist",
            ),
            (
                "<group name='g'><group name='h'/></group>\n<group name='h'><group name='g'/></group>".to_owned(),
                "line 2: group \"g\" contains itself",
            ),
            (
                format!("{hand}\n<end_effector group='h' parent_group='left'/>"),
                "line 3: hand group \"h\" has no link \"left_tcp\", which must be the hand frame H",
            ),
            (
                "<disable_collisions link1='palm' link2='ghost'/>".to_owned(),
                "line 2: disable_collisions names link \"ghost\", which does not exist",
            ),
        ];
        for (body, wanted) in cases {
            assert_eq!(load(&body).map(|_| ()).unwrap_err().to_string(), wanted);
        }
    }

    #[test]
    fn states_outside_the_limits_are_moved_inside_with_a_note() {
        let state = "<group_state name='up' group='g'><joint name='swing' value='3'/></group_state>";
        let loaded = load(&format!("<group name='g'><joint name='swing'/></group>{state}")).unwrap();
        assert_eq!(loaded.value.posture("up").unwrap(), [1.0]);
        assert!(loaded.notes[0].contains("outside its limits"), "{:?}", loaded.notes);
    }

    #[test]
    fn both_robots_have_two_arms_with_the_hands_of_the_thesis() {
        let crichton = samples::crichton();
        let alita = samples::alita();
        for (robot, fingers) in [(&crichton, vec![2, 2, 2]), (&alita, vec![1])] {
            assert_eq!(robot.arms.iter().map(|arm| arm.name.as_str()).collect::<Vec<_>>(), ["left", "right"]);
            for arm in &robot.arms {
                assert_eq!(arm.dofs.len(), 7);
                assert_eq!(arm.hand.fingers.iter().map(Vec::len).collect::<Vec<_>>(), fingers);
                assert_eq!(arm.hand.links[0], arm.hand.palm_link);
                // Proximal before distal: each degree of freedom of a finger moves the next.
                for finger in &arm.hand.fingers {
                    for pair in finger.windows(2) {
                        let links = [0, 1].map(|i| robot.joints[robot.dof_joints[pair[i]]].child);
                        assert!(robot.chain(links[0], links[1]).is_some());
                    }
                }
            }
            assert!(robot.allowed_collisions.is_sorted());
        }
    }
}
