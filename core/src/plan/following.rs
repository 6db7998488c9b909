//! Following a way of the hand with the whole null space of the arm: deterministic, and complete up to its steps
//! (thesis 8.2; Huamán Quispe and Stilman 2012).
//!
//! Every pose of the way becomes a layer of configurations: all branches of the inverse kinematics at many arm angles.
//! Neighbouring layers are linked where no joint moves far, and within a layer the arm may turn its elbow while the
//! hand waits. [`follow_hand`] finds the shortest free way through the layers, from given start configurations to given
//! goals, or the first pose that nothing passes and what is in the way there. No random numbers are drawn.
//!
//! [`super::follow_poses`] asks less and finds less: it keeps to one configuration per pose.

use nalgebra::Isometry3;

use super::hand_edge::{EdgeFault, HandEdges, Sag, gap};
use super::layers::{HitCounts, Layers};
use super::queue::Queue;
use super::space::{ArmSpace, ConfigurationFault, Path};
use crate::collision::{Hit, Scratch};
use crate::robot::ik::{ArmIk, IkReject};
use crate::watch::Watch;

/// A given configuration whose hand is this near to its pose is there, metres and radians.
const THERE: Sag = Sag { m: 1e-4, rad: 1e-3 };

/// How finely the null space is searched, and how well the hand keeps its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowSettings {
    /// Arm angles per pose over the whole turn; starts per pose where the arm has no closed form.
    pub arm_angles: usize,
    /// Largest motion of any joint from one configuration to the next, rad.
    pub max_joint_step_rad: f64,
    /// How far the hand may be beside the line between two poses in the middle of a motion, metres.
    pub max_sag_m: f64,
    /// How far it may be turned there, rad.
    pub max_sag_rad: f64,
}

impl Default for FollowSettings {
    fn default() -> Self {
        Self { arm_angles: 36, max_joint_step_rad: 0.35, max_sag_m: 0.002, max_sag_rad: 0.02 }
    }
}

/// The arm that follows a way of its hand, and with which configurations it begins and ends.
#[derive(Clone, Copy)]
pub struct FollowingArm<'a> {
    /// Inverse kinematics of the arm whose joints the space has.
    pub ik: &'a ArmIk,
    /// Pose of the arm's base link in the world.
    pub X_WB: Isometry3<f64>,
    /// Configurations at the first pose; the arm may begin at any of them.
    pub starts: &'a [Vec<f64>],
    /// Configurations at the last pose, of which one is to be reached; `None` leaves the choice to the search.
    pub goals: Option<&'a [Vec<f64>]>,
}

/// A way of the arm whose hand follows the poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// From a start to a goal, every motion proven free.
    pub path: Path,
    /// Index of the start.
    pub start: usize,
    /// Index of the goal, where goals were given.
    pub goal: Option<usize>,
}

/// Where following ended, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowStop {
    /// Index of the first pose that no configuration passes.
    pub pose: usize,
    /// Number of poses.
    pub poses: usize,
    /// Why.
    pub reason: FollowReason,
}

/// Why no configuration passes a pose.
#[derive(Clone, Debug, PartialEq)]
pub enum FollowReason {
    /// No start at the first pose or no goal at the last, or one that is no configuration (the first such one's fault).
    Invalid(Option<ConfigurationFault>),
    /// The hand of every given configuration is elsewhere; the nearest one's distance, metres, and angle, rad.
    Elsewhere { gap_m: f64, gap_rad: f64 },
    /// The inverse kinematics has no answer: of all branches the most frequent reason.
    NoIk(IkReject),
    /// Every configuration, or every motion to one, touches something; this most often.
    Blocked(Hit),
    /// Free configurations lie beyond a jump: the joint that would have to turn farthest, and how far at least.
    Jump { joint: String, step_rad: f64 },
    /// It was cancelled.
    Stopped,
}

/// The shortest motion of the arm (sum of Euclidean joint distances) whose hand follows the poses.
///
/// * `poses`: hand poses X_WH, the first one that of the arm's starts, the last one that of its goals.
///
/// The middle of every joint motion keeps the hand within the settings' sag of the line between its poses; where the
/// chord sags more, it is bent. The same question always has the same answer.
///
/// # Errors
/// [`FollowStop`] naming the first pose that no configuration passes, and why.
pub fn follow_hand(
    space: &ArmSpace,
    arm: &FollowingArm<'_>,
    poses: &[Isometry3<f64>],
    settings: &FollowSettings,
    watch: &Watch<'_>,
) -> Result<Followed, FollowStop> {
    let last = poses.len().saturating_sub(1);
    let stop = |pose: usize, reason: FollowReason| FollowStop { pose, poses: poses.len(), reason };
    let poses_BH: Vec<Isometry3<f64>> = poses.iter().map(|X_WH| arm.X_WB.inv_mul(X_WH)).collect();
    let (Some(first_BH), Some(last_BH)) = (poses_BH.first(), poses_BH.last()) else {
        return Err(stop(0, FollowReason::Invalid(None)));
    };
    let at = |pose, given, X_BH| configurations_at(space, arm.ik, given, X_BH).map_err(|reason| stop(pose, reason));
    let (starts, start_of) = at(0, arm.starts, first_BH)?;
    let (goals, goal_of) = match arm.goals {
        Some(goals) => at(last, goals, last_BH)?,
        None => (Vec::new(), Vec::new()),
    };
    let mut search = Search {
        edges: HandEdges { space, ik: arm.ik, sag: Sag { m: settings.max_sag_m, rad: settings.max_sag_rad } },
        layers: Layers::of(arm.ik, &poses_BH, &starts, &goals, settings.arm_angles.max(1)),
        poses_BH: &poses_BH,
        step_rad: settings.max_joint_step_rad,
        from_start: Vec::new(),
        scratch: Scratch::default(),
    };
    search.spread(watch).ok_or_else(|| stop(0, FollowReason::Stopped))?;
    let goal_nodes: Vec<usize> = match arm.goals {
        Some(_) => search.layers.goals.iter().map(|&(node, _)| node).collect(),
        None => search.layers.layer(last).collect(),
    };
    let reached = goal_nodes.iter().copied().filter(|&node| search.from_start[node].is_finite()).collect::<Vec<_>>();
    if reached.is_empty() {
        let (pose, reason) = search.obstacle(&goal_nodes);
        return Err(stop(pose, reason));
    }
    let given = |list: &[(usize, usize)], node| list.iter().find(|(of, _)| *of == node).map(|&(_, index)| index);
    match search.join(&reached, watch) {
        Joined::Found { points, start, goal } => Ok(Followed {
            path: Path { points },
            start: given(&search.layers.starts, start).map_or(0, |index| start_of[index]),
            goal: given(&search.layers.goals, goal).map(|index| goal_of[index]),
        }),
        Joined::Nowhere => {
            let (pose, reason) = search.blocked_motion(watch);
            Err(stop(pose, reason))
        }
        Joined::Stopped => Err(stop(0, FollowReason::Stopped)),
    }
}

/// The given configurations that are within the limits with the hand at a pose, and their indices.
fn configurations_at(
    space: &ArmSpace,
    ik: &ArmIk,
    given: &[Vec<f64>],
    X_BH: &Isometry3<f64>,
) -> Result<(Vec<Vec<f64>>, Vec<usize>), FollowReason> {
    let valid: Vec<usize> = (0..given.len()).filter(|&index| space.fault(&given[index]).is_none()).collect();
    if valid.is_empty() {
        return Err(FollowReason::Invalid(given.first().and_then(|q| space.fault(q))));
    }
    let mut nearest = Sag { m: f64::INFINITY, rad: f64::INFINITY };
    let mut there = Vec::new();
    for index in valid {
        let off = gap(&ik.chain().tip(&given[index]), X_BH);
        if off.within(THERE) {
            there.push(index);
        }
        // One metre counts as much as one radian.
        if off.m + off.rad < nearest.m + nearest.rad {
            nearest = off;
        }
    }
    if there.is_empty() {
        return Err(FollowReason::Elsewhere { gap_m: nearest.m, gap_rad: nearest.rad });
    }
    Ok((there.iter().map(|&index| given[index].clone()).collect(), there))
}

/// Two passes: a spread over free nodes that trusts every motion, and a search back from the goals that trusts none,
/// for which the first one's costs are a lower bound that is exact where nothing is in the way.
struct Search<'a> {
    edges: HandEdges<'a>,
    layers: Layers,
    poses_BH: &'a [Isometry3<f64>],
    step_rad: f64,
    /// Least cost from a start to each node when no motion is blocked, rad; infinite where it cannot be reached.
    from_start: Vec<f64>,
    scratch: Scratch,
}

enum Joined {
    Found { points: Vec<Vec<f64>>, start: usize, goal: usize },
    Nowhere,
    Stopped,
}

const NONE: u32 = u32::MAX;

impl Search<'_> {
    /// Fills `from_start`, layer by layer, turning the elbow within each; `None` when cancelled.
    fn spread(&mut self, watch: &Watch<'_>) -> Option<()> {
        let Self { layers, from_start, scratch, edges, step_rad, .. } = self;
        *from_start = vec![f64::INFINITY; layers.len()];
        for (start, _) in layers.starts.clone() {
            if layers.is_free(edges.space, scratch, start) {
                from_start[start] = 0.0;
            }
        }
        let mut queue = Queue::default();
        let mut links = Vec::new();
        for layer in 0..layers.count() {
            if watch.should_stop() {
                return None;
            }
            let nodes = layers.layer(layer);
            let mut settled = vec![false; nodes.len()];
            queue.clear();
            for node in nodes.clone().filter(|&node| from_start[node].is_finite()) {
                queue.push(from_start[node], node as u32, NONE);
            }
            while let Some(waiting) = queue.pop() {
                let node = waiting.node as usize;
                if std::mem::replace(&mut settled[node - nodes.start], true) {
                    continue;
                }
                links.clear();
                for next in layer..(layer + 2).min(layers.count()) {
                    layers.near(node, next, *step_rad, |other, cost| links.push((other, cost)));
                }
                for &(other, cost) in &links {
                    let total = waiting.key + cost;
                    if total < from_start[other] && layers.is_free(edges.space, scratch, other) {
                        from_start[other] = total;
                        if nodes.contains(&other) {
                            queue.push(total, other as u32, NONE);
                        }
                    }
                }
            }
        }
        Some(())
    }

    /// The shortest way from any start to any of the nodes, every motion proven when the search wants it.
    fn join(&mut self, goals: &[usize], watch: &Watch<'_>) -> Joined {
        let mut to_goal = vec![f64::INFINITY; self.layers.len()];
        let mut next = vec![NONE; self.layers.len()];
        let mut between: Vec<Vec<Vec<f64>>> = vec![Vec::new(); self.layers.len()];
        let mut queue = Queue::default();
        goals.iter().for_each(|&goal| queue.push(self.from_start[goal], goal as u32, NONE));
        let mut count = 0;
        while let Some(waiting) = queue.pop() {
            count += 1;
            if count % 64 == 0 && watch.should_stop() {
                return Joined::Stopped;
            }
            let node = waiting.node as usize;
            if to_goal[node].is_finite() {
                continue;
            }
            if waiting.from != NONE {
                let Ok(bent) = self.bend(node, waiting.from as usize) else { continue };
                between[node] = bent;
            }
            next[node] = waiting.from;
            to_goal[node] = (waiting.key - self.from_start[node]).max(0.0);
            if self.from_start[node] == 0.0 && self.layers.starts.iter().any(|&(start, _)| start == node) {
                let mut points = vec![self.layers.q(node).to_vec()];
                let mut at = node;
                while next[at] != NONE {
                    points.append(&mut between[at]);
                    at = next[at] as usize;
                    points.push(self.layers.q(at).to_vec());
                }
                return Joined::Found { points, start: node, goal: at };
            }
            let layer = self.layers.layer_of(node);
            for before in layer.saturating_sub(1)..=layer {
                self.layers.near(node, before, self.step_rad, |other, cost| {
                    if self.from_start[other].is_finite() && to_goal[other].is_infinite() {
                        queue.push(to_goal[node] + cost + self.from_start[other], other as u32, node as u32);
                    }
                });
            }
        }
        Joined::Nowhere
    }

    /// A motion from a node to one of its own or the next layer.
    fn bend(&mut self, from: usize, to: usize) -> Result<Vec<Vec<f64>>, EdgeFault> {
        let Self { edges, layers, poses_BH, scratch, .. } = self;
        let X_BH_from = &poses_BH[layers.layer_of(from)];
        let X_BH_to = &poses_BH[layers.layer_of(to)];
        edges.bend(scratch, (layers.q(from), X_BH_from), (layers.q(to), X_BH_to))
    }

    /// The first pose that the spread did not reach and why, or why it did not reach the goals.
    fn obstacle(&mut self, goals: &[usize]) -> (usize, FollowReason) {
        let is_reached = |layer: usize| self.layers.layer(layer).any(|node| self.from_start[node].is_finite());
        let last = self.layers.count() - 1;
        let pose = (0..=last).find(|&layer| !is_reached(layer)).unwrap_or(last);
        let nodes: Vec<usize> = match pose {
            0 => self.layers.starts.iter().map(|&(start, _)| start).collect(),
            pose if pose == last => goals.to_vec(),
            pose => self.layers.layer(pose).collect(),
        };
        (pose, self.reason(pose, &nodes))
    }

    /// Why none of the nodes of a layer is reached from the layer before it, or from its own where that is the last.
    fn reason(&mut self, pose: usize, nodes: &[usize]) -> FollowReason {
        if nodes.is_empty() {
            let q = self.layers.q(self.layers.starts[0].0);
            let none = IkReject::Stalled { gap_m: 0.0, gap_rad: 0.0 };
            return FollowReason::NoIk(self.edges.ik.first(&self.poses_BH[pose], q).err().unwrap_or(none));
        }
        if let Some(hit) = self.layers.obstruction(self.edges.space, &mut self.scratch, nodes.iter().copied()) {
            return FollowReason::Blocked(hit);
        }
        let mut least = (0, f64::INFINITY);
        for &to in nodes {
            if !self.layers.is_free(self.edges.space, &mut self.scratch, to) {
                continue;
            }
            let before = self.layers.layer(pose.saturating_sub(1)).chain(self.layers.layer(pose));
            for from in before.filter(|&from| self.from_start[from].is_finite()) {
                let steps = self.layers.q(from).iter().zip(self.layers.q(to)).map(|(a, b)| (a - b).abs());
                if let Some((joint, step)) = steps.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
                    && step < least.1
                {
                    least = (joint, step);
                }
            }
        }
        FollowReason::Jump { joint: self.edges.space.joint_names[least.0].clone(), step_rad: least.1 }
    }

    /// The first pose that no proven motion reaches, or the last one, and what the motions to it touch.
    fn blocked_motion(&mut self, watch: &Watch<'_>) -> (usize, FollowReason) {
        let last = self.layers.count() - 1;
        let mut passed = vec![false; self.layers.len()];
        let mut waiting: Vec<usize> = self.layers.starts.iter().map(|&(start, _)| start).collect();
        waiting.iter().for_each(|&start| passed[start] = true);
        let mut links = Vec::new();
        for layer in 0..=last {
            let next = (layer + 1).min(last);
            let mut hits = HitCounts::default();
            let mut entered = Vec::new();
            while let Some(node) = waiting.pop() {
                links.clear();
                for to in layer..=next {
                    self.layers.near(node, to, self.step_rad, |other, _| links.push((other, to)));
                }
                for &(other, to) in &links {
                    if passed[other] || self.from_start[other].is_infinite() {
                        continue;
                    }
                    match self.bend(node, other) {
                        Ok(_) => {
                            passed[other] = true;
                            if to == layer { waiting.push(other) } else { entered.push(other) }
                        }
                        Err(EdgeFault::Blocked(hit)) => hits.add(hit),
                        Err(EdgeFault::Strays) => {}
                    }
                }
            }
            if entered.is_empty() || watch.should_stop() {
                let nodes: Vec<usize> = self.layers.layer(next).collect();
                return (next, hits.most().map_or_else(|| self.reason(next, &nodes), FollowReason::Blocked));
            }
            waiting = entered;
        }
        (last, FollowReason::Stopped)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, Vector3};

    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::Bench;
    use crate::plan::{CartesianSettings, StopReason, follow_poses, straight_line, walk_path};

    const START: [f64; 7] = [0.3, 0.9, 0.1, 1.2, 0.2, 0.7, 0.0];

    fn ik(bench: &Bench) -> ArmIk {
        let robot = bench.model.robot();
        ArmIk::of(robot, &robot.arms[0]).unwrap()
    }

    fn aside(bench: &Bench, by_m: [f64; 3]) -> Vec<Isometry3<f64>> {
        let from = bench.model.robot().link_poses(&START)[7];
        let mut poses = vec![from];
        poses.extend(straight_line(&from, &(Translation3::from(Vector3::from(by_m)) * from), 0.01, 0.1));
        poses
    }

    fn follow(bench: &Bench, poses: &[Isometry3<f64>], goals: Option<&[Vec<f64>]>) -> Result<Followed, FollowStop> {
        let arm = FollowingArm { ik: &ik(bench), X_WB: Isometry3::identity(), starts: &[START.to_vec()], goals };
        let settings = FollowSettings::default();
        let followed = follow_hand(&bench.space(), &arm, poses, &settings, &Watch::idle());
        assert_eq!(
            followed,
            follow_hand(&bench.space(), &arm, poses, &settings, &Watch::idle()),
            "the same answer always"
        );
        followed
    }

    /// Walks a path by the slow judge, and the hand by forward kinematics.
    fn assert_free_and_on_line(bench: &Bench, path: &Path, poses: &[Isometry3<f64>]) {
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        assert_eq!(walk_path(&judge, &bench.dofs(), &bench.rest(), path, 0.01), None);
        let (from, to) = (poses[0].translation.vector, poses[poses.len() - 1].translation.vector);
        let along = (to - from) / (to - from).norm_squared();
        for pair in path.points.windows(2) {
            for step in 0..=8 {
                let q = crate::plan::space::lerp(&pair[0], &pair[1], f64::from(step) / 8.0);
                let X_WH = bench.model.robot().link_poses(&q)[7];
                let share = (X_WH.translation.vector - from).dot(&along);
                let off = (X_WH.translation.vector - from.lerp(&to, share)).norm();
                // The sag of 2 mm is met in the middle; elsewhere a chord of a curve that turns may be a little more.
                assert!(off < 0.003 && X_WH.rotation.angle_to(&poses[0].rotation) < 0.03, "{off}");
            }
        }
    }

    #[test]
    fn a_post_where_the_elbow_would_be_turns_the_elbow_and_not_the_hand() {
        let free = Bench::new(&[]);
        let poses = aside(&free, [0.0, -0.4, 0.0]);
        let plain = follow(&free, &poses, None).unwrap().path;
        assert_free_and_on_line(&free, &plain, &poses);
        let half = free.model.robot().link_poses(&plain.points[plain.points.len() / 2]);
        let elbow = half[4].translation.vector;
        let post = Bench::new(&[("post", elbow.into(), [0.02, 0.02, 0.3])]);
        let near = |X: &Isometry3<f64>, q: &[f64]| ik(&post).near(X, q);
        let stopped = follow_poses(&post.space(), &START, &poses[1..], &near, &CartesianSettings::default());
        assert!(
            matches!(stopped.unwrap_err().reason, StopReason::Blocked(cause) if cause.to_string().ends_with("post"))
        );
        let path = follow(&post, &poses, None).unwrap().path;
        assert_free_and_on_line(&post, &path, &poses);
        assert!(path.length_rad() > plain.length_rad());
    }

    #[test]
    fn the_given_goal_is_reached_and_the_start_s_and_goal_s_own_elbows_are_kept() {
        let bench = Bench::new(&[]);
        let poses = aside(&bench, [0.0, -0.2, 0.1]);
        let settings = ik(&bench).set(&poses[poses.len() - 1], &START, 12);
        let goals: Vec<Vec<f64>> = settings.iter().map(<[f64]>::to_vec).collect();
        let mut reached = 0;
        for goal in &goals {
            // Another branch cannot be reached with the hand on its line; the arm angle can.
            if let Ok(followed) = follow(&bench, &poses, Some(&[vec![9.0; 7], goal.clone()])) {
                reached += 1;
                assert_eq!(followed.goal, Some(1));
                assert_eq!(followed.path.points.last(), Some(goal));
                assert_eq!(followed.path.points[0], START);
                assert_free_and_on_line(&bench, &followed.path, &poses);
            }
        }
        assert!(reached >= 3, "{reached} of {}", goals.len());
    }

    #[test]
    fn no_way_is_shorter_by_a_slow_loop_over_all_pairs() {
        let free = Bench::new(&[]);
        let poses: Vec<_> = aside(&free, [0.0, -0.3, 0.0]).into_iter().step_by(5).collect();
        let plain = follow(&free, &poses, None).unwrap().path;
        let elbow = free.model.robot().link_poses(&plain.points[plain.points.len() / 2])[4].translation.vector;
        let bench = Bench::new(&[("post", elbow.into(), [0.02, 0.02, 0.3])]);
        let (space, ik) = (bench.space(), ik(&bench));
        let (angles, step) = (12, 0.7);
        let arm = FollowingArm { ik: &ik, X_WB: Isometry3::identity(), starts: &[START.to_vec()], goals: None };
        // So lax a sag that no motion is bent.
        let settings =
            FollowSettings { arm_angles: angles, max_joint_step_rad: step, max_sag_m: 9.0, max_sag_rad: 9.0 };
        let found = follow_hand(&space, &arm, &poses, &settings, &Watch::idle()).unwrap().path;
        let mut nodes: Vec<(usize, Vec<f64>)> = vec![(0, START.to_vec())];
        for (layer, pose) in poses.iter().enumerate() {
            nodes.extend(ik.set(pose, &START, angles).iter().map(|q| (layer, q.to_vec())));
        }
        let mut scratch = Scratch::default();
        let mut cost = vec![f64::INFINITY; nodes.len()];
        cost[0] = 0.0;
        // Bellman and Ford: no queue, no bound, no order.
        let mut changed = true;
        while std::mem::take(&mut changed) {
            for from in 0..nodes.len() {
                for to in 0..nodes.len() {
                    let ((a, q_a), (b, q_b)) = (&nodes[from], &nodes[to]);
                    let total = cost[from] + crate::plan::space::distance_rad(q_a, q_b);
                    let linked = (*b == *a || *b == a + 1) && q_a.iter().zip(q_b).all(|(a, b)| (a - b).abs() <= step);
                    if total < cost[to] && linked && space.edge_is_free(&mut scratch, q_a, q_b) {
                        cost[to] = total;
                        changed = true;
                    }
                }
            }
        }
        let last = poses.len() - 1;
        let best = (0..nodes.len()).filter(|&n| nodes[n].0 == last).map(|n| cost[n]).fold(f64::INFINITY, f64::min);
        assert!((found.length_rad() - best).abs() < 1e-9, "{} against {best}", found.length_rad());
    }

    #[test]
    fn every_stop_names_its_pose_and_what_is_there() {
        let free = Bench::new(&[]);
        // Out of the arm's reach, about 0.65 m from the shoulder to the wrist.
        let stop = follow(&free, &aside(&free, [1.0, 0.0, 0.0]), None).unwrap_err();
        assert!(matches!(stop.reason, FollowReason::NoIk(IkReject::OutOfReach { .. })), "{stop:?}");
        assert!(stop.pose > 5 && stop.poses == 101, "{stop:?}");
        // A floor into which the hand would have to go: whatever the elbow does.
        let tip = free.model.robot().link_poses(&START)[7] * nalgebra::Point3::new(0.0, 0.0, 0.2024);
        let floored = Bench::new(&[("floor", [tip.x, tip.y, tip.z - 0.1], [0.3, 0.3, 0.01])]);
        let stop = follow(&floored, &aside(&free, [0.0, 0.0, -0.1]), None).unwrap_err();
        assert!(matches!(&stop.reason, FollowReason::Blocked(hit) if hit.b == "floor"), "{stop:?}");
        // Its top is 95 mm below, the hand's radius 45 mm: the fifth step touches.
        assert_eq!(stop.pose, 5);
        let poses = aside(&free, [0.0, -0.1, 0.0]);
        let elsewhere = [vec![0.0; 7]];
        let stop = follow(&free, &poses, Some(&elsewhere)).unwrap_err();
        assert!(stop.pose == 10 && matches!(stop.reason, FollowReason::Elsewhere { .. }), "{stop:?}");
        let stop = follow(&free, &poses, Some(&[])).unwrap_err();
        assert_eq!(stop.reason, FollowReason::Invalid(None));
        let stop = follow(&free, &[], None).unwrap_err();
        assert_eq!(stop, FollowStop { pose: 0, poses: 0, reason: FollowReason::Invalid(None) });
        // The same hand pose with the elbow bent the other way.
        let goals: Vec<Vec<f64>> =
            ik(&free).set(&poses[10], &START, 36).iter().filter(|q| q[3] < 0.0).map(<[f64]>::to_vec).collect();
        let stop = follow(&free, &poses, Some(&goals)).unwrap_err();
        assert!(matches!(&stop.reason, FollowReason::Jump { step_rad, .. } if *step_rad > 0.35), "{stop:?}");
    }

    #[test]
    fn an_arm_without_a_closed_form_follows_too() {
        let bench = Bench::new(&[]);
        let mut robot = bench.model.robot().clone();
        // A wrist with an offset of 2 cm has no centre.
        robot.joints[5].X_PJ.translation.vector.x = 0.02;
        let model = crate::collision::CollisionModel::new(&robot).unwrap();
        let bench = Bench { model, world: crate::collision::World::new() };
        assert!(ik(&bench).closed_form().is_none());
        let poses = aside(&bench, [0.0, -0.2, 0.0]);
        let path = follow(&bench, &poses, None).unwrap().path;
        assert_free_and_on_line(&bench, &path, &poses);
    }

    #[test]
    fn a_cancelled_search_says_so() {
        let bench = Bench::new(&[]);
        let poses = aside(&bench, [0.0, -0.1, 0.0]);
        let arm = FollowingArm { ik: &ik(&bench), X_WB: Isometry3::identity(), starts: &[START.to_vec()], goals: None };
        let watch = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        let stop = follow_hand(&bench.space(), &arm, &poses, &FollowSettings::default(), &watch).unwrap_err();
        assert_eq!(stop.reason, FollowReason::Stopped);
    }
}
