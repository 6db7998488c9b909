//! Which chains of a robot are arms, found from its tree.
//!
//! A *run* is a row of moving joints, each body between them carrying the next one only. A run of at least
//! [`LEAST_JOINTS`] joints that ends in nothing or in fingers is an arm, unless its names say that it is a leg, a neck
//! or a wheel.

use super::body::{moving_below, rest};
use super::names::{no_arm, side, tip_rank};
use crate::robot::{JointKind, Robot};

/// A chain of fewer joints cannot turn a hand about freely.
pub const LEAST_JOINTS: usize = 5;
/// Most arms of a robot that are used.
const MOST_ARMS: usize = 2;

/// A chain that looks like an arm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundArm {
    /// `left` or `right`; a single arm is `left`.
    pub name: &'static str,
    /// Link that carries its first joint.
    pub base_link: usize,
    /// Link at its end whose frame is meant as such, or the last one that a joint of it moves.
    pub tip_link: usize,
}

/// The one or two arms of a robot, the left one first, and sentences about chains that were passed over.
pub fn find_arms(robot: &Robot) -> (Vec<FoundArm>, Vec<String>) {
    let mut notes = Vec::new();
    let mut found: Vec<Run> = Vec::new();
    for run in runs(robot) {
        let named = run.joints.iter().map(|&joint| robot.joints[joint].name.as_str());
        let telling = named.clone().find_map(|name| Some((name, no_arm(name)?)));
        let words = run.in_words(robot);
        match telling {
            _ if run.joints.len() < LEAST_JOINTS => {
                notes.push(format!("{words}: {} joints, fewer than the {LEAST_JOINTS} of an arm", run.joints.len()));
            }
            Some((name, word)) => notes.push(format!("{words}: no arm, since joint {name:?} speaks of a {word}")),
            None => found.push(run),
        }
    }
    // Those with fingers first, then the longer ones; equal ones in the order of the file.
    found.sort_by_key(|run| (!run.has_fingers, std::cmp::Reverse(run.joints.len())));
    for run in found.iter().skip(MOST_ARMS) {
        notes.push(format!("{}: left out, two arms are used", run.in_words(robot)));
    }
    found.truncate(MOST_ARMS);
    // A second chain that has no hand beside one that has is a tail, a mast, a cable guide.
    if let [first, second] = found.as_slice()
        && first.has_fingers
        && !second.has_fingers
    {
        notes.push(format!("{}: left out, it has no fingers and the other chain has", second.in_words(robot)));
        found.truncate(1);
    }
    let chains: Vec<(usize, usize)> = found.iter().map(|run| (run.base_link(robot), run.tip_link(robot))).collect();
    (named(robot, &chains), notes)
}

/// Names for one or two chains: what their links are called, else which is further to the left at rest.
pub(super) fn named(robot: &Robot, chains: &[(usize, usize)]) -> Vec<FoundArm> {
    let arm = |name, &(base_link, tip_link): &(usize, usize)| FoundArm { name, base_link, tip_link };
    let [a, b] = chains else { return chains.iter().take(1).map(|chain| arm("left", chain)).collect() };
    let said = |(base, tip): &(usize, usize)| {
        let links = robot.chain(*base, *tip).unwrap_or_default();
        links.iter().map(|&joint| side(&robot.joints[joint].name) + side(&robot.links[joint + 1].name)).sum::<i32>()
    };
    let X_RL = robot.link_poses(&rest(robot));
    let leftness =
        |chain: &(usize, usize)| (said(chain).signum(), X_RL[chain.0].translation.y, X_RL[chain.1].translation.y);
    let (of_a, of_b) = (leftness(a), leftness(b));
    let order = of_a.0.cmp(&of_b.0).then(of_a.1.total_cmp(&of_b.1)).then(of_a.2.total_cmp(&of_b.2));
    if order.is_lt() { vec![arm("left", b), arm("right", a)] } else { vec![arm("left", a), arm("right", b)] }
}

/// Moving joints in a row.
struct Run {
    joints: Vec<usize>,
    has_fingers: bool,
}

impl Run {
    fn base_link(&self, robot: &Robot) -> usize {
        self.joints.first().map_or(0, |&joint| robot.joints[joint].parent)
    }

    /// The frame at its end that is named as such, the deepest of equals; else the link that its last joint moves.
    fn tip_link(&self, robot: &Robot) -> usize {
        let last = self.joints.last().map_or(0, |&joint| robot.joints[joint].child);
        let welded = (last..robot.links.len()).filter(|&link| robot.body_root(link) == last);
        // Behind the fingers' own links nothing is the end of the arm: fingers are looked for below it.
        let rank = |link: &usize| if self.has_fingers { 0 } else { tip_rank(&robot.links[*link].name) };
        welded.filter(|link| rank(link) > 0).max_by_key(|link| (rank(link), *link)).unwrap_or(last)
    }

    fn in_words(&self, robot: &Robot) -> String {
        let name = |link: usize| robot.links[link].name.as_str();
        let last = self.joints.last().map_or(0, |&joint| robot.joints[joint].child);
        format!("chain from {:?} to {:?}", name(self.base_link(robot)), name(last))
    }
}

/// Every run that ends in nothing or in fingers.
fn runs(robot: &Robot) -> Vec<Run> {
    let mut runs = Vec::new();
    for first in 0..robot.joints.len() {
        let joint = &robot.joints[first];
        let before = robot.body_root(joint.parent);
        let begins = before == 0 || moving_below(robot, before).len() != 1;
        if joint.kind == JointKind::Fixed || joint.mimic.is_some() || !begins {
            continue;
        }
        let mut joints = vec![first];
        let mut end = joint.child;
        let mut below = moving_below(robot, end);
        while let [only] = below[..]
            && robot.joints[only].mimic.is_none()
        {
            joints.push(only);
            end = robot.joints[only].child;
            below = moving_below(robot, end);
        }
        // A hand of one sliding jaw ends the row like another joint.
        let slides = |joint: &usize| robot.joints[*joint].kind == JointKind::Prismatic;
        let mut has_fingers = !below.is_empty();
        if below.is_empty() && joints.len() > LEAST_JOINTS && joints.last().is_some_and(slides) {
            joints.pop();
            has_fingers = true;
        }
        // What branches into further long chains is a torso.
        if below.iter().all(|&joint| depth(robot, robot.joints[joint].child) + 1 < LEAST_JOINTS) {
            runs.push(Run { joints, has_fingers });
        }
    }
    runs
}

/// Most moving joints in a row below a body.
fn depth(robot: &Robot, body: usize) -> usize {
    moving_below(robot, body).iter().map(|&joint| 1 + depth(robot, robot.joints[joint].child)).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::samples;

    fn found(robot: &Robot) -> Vec<(&'static str, &str, &str)> {
        let (arms, _) = find_arms(robot);
        let name = |link: usize| robot.links[link].name.as_str();
        arms.iter().map(|arm| (arm.name, name(arm.base_link), name(arm.tip_link))).collect()
    }

    #[test]
    fn the_arms_of_robots_that_are_known_are_found_without_their_srdf() {
        for robot in [samples::crichton(), samples::alita(), samples::hubo(), samples::human()] {
            let known: Vec<_> = robot.arms.iter().map(|arm| (arm.name.as_str(), arm.dofs.clone())).collect();
            let (arms, notes) = find_arms(&robot);
            let dofs = |arm: &FoundArm| {
                let chain = robot.chain(arm.base_link, arm.tip_link).unwrap();
                (arm.name, chain.iter().filter_map(|&joint| robot.joints[joint].dof).collect::<Vec<_>>())
            };
            assert_eq!(arms.iter().map(dofs).collect::<Vec<_>>(), known, "{}: {notes:?}", robot.name);
        }
    }

    #[test]
    fn legs_and_short_chains_are_passed_over_with_a_reason() {
        let joint = |n: usize, name: &str| {
            format!(
                "<link name='l{n}'/><joint name='{name}' type='continuous'><parent link='l{}'/><child link='l{n}'/></joint>",
                n - 1
            )
        };
        let names = ["left_hip_yaw", "left_hip_roll", "left_hip_pitch", "left_knee", "left_ankle", "left_foot_roll"];
        let chain: String = names.iter().zip(1..).map(|(name, n)| joint(n, name)).collect();
        let urdf = format!("<robot name='r'><link name='l0'/>{chain}</robot>");
        let robot = crate::robot::read_urdf(&urdf, &|_| None).unwrap().value;
        let (arms, notes) = find_arms(&robot);
        assert!(arms.is_empty());
        assert_eq!(notes, ["chain from \"l0\" to \"l6\": no arm, since joint \"left_hip_yaw\" speaks of a hip"]);
        let urdf = "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='continuous'>\
            <parent link='a'/><child link='b'/></joint></robot>";
        let robot = crate::robot::read_urdf(urdf, &|_| None).unwrap().value;
        assert!(found(&robot).is_empty());
        assert_eq!(find_arms(&robot).1, ["chain from \"a\" to \"b\": 1 joints, fewer than the 5 of an arm"]);
    }
}
