//! From files to a robot that can act: what is not said is found, and what is not found is said.

use std::cell::RefCell;
use std::collections::BTreeMap;

use nalgebra::{Unit, Vector3};

use super::arms::{find_arms, named};
use super::body::rest;
use super::build::chain_of;
use super::files::ends_in;
use super::fingers::{Fingers, placement};
use super::names::tip_rank;
use super::stand::behind_table;
use super::{ArmDescription, Blob, BuiltGuest, Files, GuestError, GuestRobot, LEAST_JOINTS, RobotDescription, ready};
use crate::robot::{HandDescription, Placement, Resolve, Robot, load_robot, read_urdf, srdf_hints};
use crate::scene::TableTop;

/// What a person wants of a robot beyond what its files say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wishes {
    /// Its arms; none leaves them to be found.
    pub arms: Vec<ArmWish>,
    /// Where its root stands in the world.
    pub stand: Option<Placement>,
}

/// An arm that a person points out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArmWish {
    /// Link that carries its first joint; without one the root.
    pub base_link: Option<String>,
    /// Link at its end.
    pub tip_link: String,
    /// Frame in the tip link ([`ArmDescription::tcp`]); without one it is found.
    pub tcp: Option<Placement>,
}

/// A robot that was found among files.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// The robot, with everything that was found.
    pub guest: GuestRobot,
    /// What was found and taken for what.
    pub notes: Vec<String>,
    /// Why it cannot act, if it cannot: it has no arms yet.
    pub problem: Option<String>,
}

/// Finds the robot among files, its arms, its hands, its place, and a posture to start from.
///
/// What the description beside it or the wishes say is taken as it is; the rest is looked for. A robot without an arm
/// that could be found is still an answer, with the problem in words.
///
/// * `hand`: what an arm without fingers is given.
/// * `own`: gives the meshes of that hand.
///
/// # Errors
/// [`GuestError`] when there is no robot, its files are wrong, or a wish names what is not there.
pub fn propose(
    files: &Files,
    wishes: &Wishes,
    table: &TableTop,
    hand: &HandDescription,
    own: &Resolve<'_>,
) -> Result<Proposal, GuestError> {
    let described = files.description()?.map(|(_, description)| description);
    let path = files.urdf(described.as_ref().map(|description| description.urdf.as_str()))?;
    let text = |path: &str| String::from_utf8_lossy(files.get(path).unwrap_or_default()).into_owned();
    let file = super::files::file_name(path);
    let of_file = |source| GuestError::Robot { file: file.to_owned(), source };
    let urdf = text(path);
    let meshes = RefCell::new(BTreeMap::new());
    let resolve = |uri: &str| {
        let bytes = files.resolve(path, uri)?;
        // What is in no format that is read would only make sessions larger.
        let is_read = [".obj", ".stl", ".glb"].into_iter().any(|ending| ends_in(uri, ending));
        let kept = if is_read { bytes.to_vec() } else { Vec::new() };
        meshes.borrow_mut().insert(uri.to_owned(), Blob(kept));
        Some(bytes.to_vec())
    };
    let robot = read_urdf(&urdf, &resolve).map_err(of_file)?.value;
    let srdf = files.srdf_beside(path).map(text);
    let mut description = described.unwrap_or_else(|| RobotDescription::of(file));
    file.clone_into(&mut description.urdf);
    if wishes.stand.is_some() {
        description.stand = wishes.stand;
    }
    let mut notes = Vec::new();
    let mut problem = None;
    if !wishes.arms.is_empty() {
        description.posture.clear();
        description.arms = wished(&robot, wishes, hand, &mut notes)?;
    } else if description.arms.is_empty() {
        let named_so = srdf.as_deref().filter(|srdf| names_arms_our_way(&urdf, srdf));
        if named_so.is_none() {
            let chains = chains_of(&robot, srdf.as_deref(), &mut notes).map_err(of_file)?;
            let arms = named(&robot, &chains);
            let name = |link: usize| robot.links[link].name.clone();
            description.arms = arms
                .iter()
                .map(|arm| {
                    let ends = (name(arm.base_link), name(arm.tip_link));
                    describe(&robot, arm.name, &ends, None, hand, &mut notes)
                })
                .collect::<Result<_, _>>()?;
            if description.arms.is_empty() {
                problem = Some(format!(
                    "{file} names no arm, and none was found: say which link carries the first joint of the arm, and \
                     which is its end"
                ));
            }
        }
    }
    description.check()?;
    let guest = GuestRobot { description, urdf, srdf, meshes: meshes.into_inner() };
    if problem.is_some() {
        return Ok(Proposal { guest, notes, problem });
    }
    let (guest, more) = guest.settled(table, own)?;
    notes.extend(more);
    Ok(Proposal { guest, notes, problem })
}

/// Whether an SRDF follows the conventions of the program's own robots.
fn names_arms_our_way(urdf: &str, srdf: &str) -> bool {
    let loaded = load_robot(urdf, srdf, &|_| None);
    let is_ours = |robot: &Robot| robot.arms.iter().all(|arm| ["left", "right"].contains(&arm.name.as_str()));
    loaded.is_ok_and(|loaded| !loaded.value.arms.is_empty() && is_ours(&loaded.value))
}

/// Base and tip of the arms: as the SRDF has them, else from the tree.
fn chains_of(
    robot: &Robot,
    srdf: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<Vec<(usize, usize)>, crate::robot::RobotError> {
    if let Some(srdf) = srdf {
        let hints = srdf_hints(robot, srdf, LEAST_JOINTS)?;
        if (1..=2).contains(&hints.arms.len()) {
            notes.push("arms as the SRDF has them".to_owned());
            return Ok(hints.arms);
        }
        notes.push(format!("the SRDF names {} chains with end effectors, wanted 1 or 2", hints.arms.len()));
    }
    let (found, passed_over) = find_arms(robot);
    notes.extend(passed_over);
    Ok(found.iter().map(|arm| (arm.base_link, arm.tip_link)).collect())
}

fn wished(
    robot: &Robot,
    wishes: &Wishes,
    hand: &HandDescription,
    notes: &mut Vec<String>,
) -> Result<Vec<ArmDescription>, GuestError> {
    let ends = |(index, wish): (usize, &ArmWish)| {
        let base = wish.base_link.clone().unwrap_or_else(|| robot.links[0].name.clone());
        let (from, to) = chain_of(robot, &format!("arm {}", index + 1), &base, &wish.tip_link)?;
        // The link that carries the first moving joint is the base, however far above it somebody pointed.
        let chain = robot.chain(from, to).unwrap_or_default();
        let first = chain.iter().find(|&&joint| robot.joints[joint].dof.is_some());
        Ok((first.map_or(from, |&joint| robot.joints[joint].parent), to))
    };
    let chains: Vec<(usize, usize)> = wishes.arms.iter().enumerate().map(ends).collect::<Result<_, GuestError>>()?;
    let arms = named(robot, &chains);
    let name = |link: usize| robot.links[link].name.clone();
    arms.iter()
        .map(|arm| {
            let wish = wishes.arms.iter().find(|wish| wish.tip_link == robot.links[arm.tip_link].name);
            let ends = (name(arm.base_link), name(arm.tip_link));
            describe(robot, arm.name, &ends, wish.and_then(|wish| wish.tcp), hand, notes)
        })
        .collect()
}

/// An arm between two links: its own fingers, or the hand that it is given.
fn describe(
    robot: &Robot,
    name: &str,
    (base, tip): &(String, String),
    tcp: Option<Placement>,
    hand: &HandDescription,
    notes: &mut Vec<String>,
) -> Result<ArmDescription, GuestError> {
    let (_, tip_link) = chain_of(robot, &format!("{name} arm"), base, tip)?;
    let arm = |tip_link: &str, tcp, hand| ArmDescription {
        name: name.to_owned(),
        base_link: base.clone(),
        tip_link: tip_link.to_owned(),
        tcp,
        hand,
    };
    if let Some(fingers) = Fingers::below(robot, tip_link) {
        let palm = robot.links[fingers.palm].name.clone();
        // The hand frame hangs on the palm.
        let is_on_palm = robot.chain(fingers.palm, tip_link).is_some();
        let given = tcp.filter(|_| is_on_palm).map(|tcp| (tip.clone(), tcp));
        let found = || fingers.frame(robot, fingers.palm).map(|frame| (palm.clone(), frame));
        if let Some((link, tcp)) = given.or_else(found) {
            let count = fingers.ends.len();
            notes.push(format!("{name} arm: {base} to {tip}, its own hand {palm} with {count} finger joints"));
            return Ok(arm(&link, tcp, None));
        }
        notes.push(format!("{name} arm: what moves below {tip} has no closing direction, so it is no hand"));
    }
    let (tcp, from) = match tcp {
        Some(tcp) => (tcp, "as it was given".to_owned()),
        None => mounting(robot, tip_link),
    };
    notes.push(format!("{name} arm: {base} to {tip}, no fingers found: {} is mounted at {tip}, {from}", hand.name));
    Ok(arm(tip, tcp, Some(hand.clone())))
}

/// Where a hand is mounted on a link: along its z where it is named as a frame for tools, else along the axis of the
/// last joint, away from the arm.
fn mounting(robot: &Robot, tip: usize) -> (Placement, String) {
    let body = robot.body_root(tip);
    let as_named = || (Placement::default(), "along its z".to_owned());
    if tip_rank(&robot.links[tip].name) > 0 {
        return as_named();
    }
    let Some(joint) = robot.moving_joint(body) else { return as_named() };
    let X_RL = robot.link_poses(&rest(robot));
    let X_TR = X_RL[tip].inverse();
    let axis = (X_TR * X_RL[body]).rotation * joint.axis.into_inner();
    // Away from the joint before: the axis points out of the arm.
    let before = (X_TR * X_RL[joint.parent]).translation.vector - (X_TR * X_RL[body]).translation.vector;
    let z = if axis.dot(&before) > 1e-6 { -axis } else { axis };
    let across = if z.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let x = Unit::try_new(across - z * z.dot(&across), 1e-9);
    let (Some(x), Some(z)) = (x, Unit::try_new(z, 1e-9)) else { return as_named() };
    (placement(&Vector3::zeros(), &x, &z), format!("along the axis of {}", joint.name))
}

impl GuestRobot {
    /// The robot with a place behind the table and a posture to start from, where it has none; and what was done.
    ///
    /// # Errors
    /// [`GuestError`] when its files do not fit its description.
    pub fn settled(mut self, table: &TableTop, own: &Resolve<'_>) -> Result<(Self, Vec<String>), GuestError> {
        let mut notes = Vec::new();
        if self.description.stand.is_none() {
            // Built without a stand, its root is the world's origin.
            let BuiltGuest { robot, .. } = self.build(own)?;
            let chains: Vec<_> = robot.arms.iter().map(|arm| (arm.base_link, arm.hand.tcp_link)).collect();
            let stand = behind_table(&robot, &chains, table);
            let [x, y, z] = stand.xyz;
            notes.push(format!("it stands behind the table, its root at {x:.3}, {y:.3}, {z:.3} m"));
            self.description.stand = Some(stand);
        }
        if self.description.posture.is_empty() {
            let BuiltGuest { robot, .. } = self.build(own)?;
            let (q, lost) = ready::over_table(&robot, table);
            for arm in lost {
                notes.push(format!(
                    "the hand of the {arm} arm finds no place over the table: it starts as all joints at 0 leave it"
                ));
            }
            let of_own = |dof: usize| robot.joints[robot.dof_joints[dof]].name.clone();
            let arms = robot.arms.iter().flat_map(|arm| arm.dofs.iter().copied());
            if let Some(q) = q {
                self.description.posture = arms.map(|dof| (of_own(dof), rounded(q[dof]))).collect();
            }
        }
        Ok((self, notes))
    }
}

/// A joint position that a person can read; a tenth of a milliradian brings no hand into a table.
fn rounded(position: f64) -> f64 {
    (1e4 * position).round() / 1e4
}
