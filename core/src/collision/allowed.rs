//! Which pairs of links need not be looked at, found out from the robot itself.
//!
//! Every pair of links with bodies is taken in turn, and only what moves them relative to each other matters: the
//! joints on the way from one to the other in the tree.
//!
//! 1. No joint between them: [`AllowedReason::Welded`].
//! 2. Both belong to one hand: [`AllowedReason::Hand`]; what a hand may do with its own fingers is asked for elsewhere.
//! 3. They touch in nearly all of [`SAMPLES`] seeded configurations: their bodies overlap by modelling, and looking at
//!    them would forbid the robot. [`AllowedReason::Adjacent`] where one joint joins them (or several with nothing that
//!    collides between), else [`AllowedReason::Always`].
//! 4. They touch in none: then [`AllowedReason::Never`], if that can be proven. The box of the joints between them,
//!    limit to limit, is bisected. At the middle of a box the bodies are a distance apart, and within the box they come
//!    nearer by no more than their travel. Let the joints be numbered from link A to link B and M be a frame between
//!    joint k and joint k + 1. Turn the joints away from the middle one after the other, those next to M first: then
//!    each turns a body that is as it was at the middle, so no point of it goes farther than the chord of its distance
//!    to the joint's axis *at the middle*. Hence the travel is at most
//!    `Σ_{i ≤ k} 2 sin(h_i / 2) r_i(A) + Σ_{i > k} 2 sin(h_i / 2) r_i(B)`, `h` the half widths of the box, `r_i` the
//!    largest distance of a point of the body's core to axis `i` (the rounding of a capsule turns onto itself); a slide
//!    goes `h_i`. The best `k` is taken. Where the distance is larger, the box is free; else the joint that adds most
//!    to the travel is halved. One middle where the bodies touch, or too many boxes, and the pair is looked at.
//!
//! 5. They are the two sides of an elbow: two turning joints between them whose axes meet in the elbow, and a body there
//!    that overlaps both in nearly all samples. They count as [`AllowedReason::Adjacent`] too: shapes that enclose the
//!    two sides meet at the inside of a bent elbow, and how far it bends is for the joint's limits to say. This is the
//!    one rule that passes over pairs that touch in some configurations only: on Alita and Crichton upper arm and
//!    forearm meet close to the end of the bend.
//!
//! Whatever is left is looked at. A pair that is called never cannot change an answer; the other reasons say what is
//! not asked.

use nalgebra::Vector3;

use super::build::moving_frames;
use super::frames::{MovingFrame, Rigid};
use super::model::{CollisionError, CollisionModel};
use super::narrow::signed_distance;
use super::solid::{Core, Solid};
use crate::math;
use crate::rng::Rng;
use crate::robot::{JointKind, JointLimit, Robot};

/// Configurations that are drawn for each robot.
const SAMPLES: usize = 64;

/// From this many of them on a pair touches nearly always.
const NEARLY_ALL: usize = 61;

/// Boxes after which a proof is given up, halved for each joint between the two: the more joints, the more halvings a
/// proof takes and the seldomer one is found. Measured on Alita and Crichton, where three joints take up to 500.
const MOST_BOXES: usize = 4096;

/// Axes that pass each other nearer than this meet, metres.
const ELBOW_M: f64 = 1e-3;

/// Distances that GJK gives may be too large by a fraction of this, metres.
const SLACK_M: f64 = 1e-4;

/// Why a pair of links is not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AllowedReason {
    /// Fixed joints weld them together.
    Welded,
    /// One moving joint joins them, or several with nothing that collides between, and their bodies overlap there; or
    /// they are the two sides of an elbow.
    Adjacent,
    /// Both belong to one hand.
    Hand,
    /// Their bodies overlap in nearly every configuration.
    Always,
    /// Proven: they touch in no configuration within the limits of the joints.
    Never,
}

impl AllowedReason {
    /// Its name in reports: `adjacent`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Welded => "welded",
            Self::Adjacent => "adjacent",
            Self::Hand => "hand",
            Self::Always => "always",
            Self::Never => "never",
        }
    }
}

/// Two links that need not be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct AllowedPair {
    /// Index of the first link.
    pub a: usize,
    /// Index of the second link, larger than that of the first.
    pub b: usize,
    /// Why.
    pub reason: AllowedReason,
}

/// The allowed matrix of a robot's collisions with itself, computed from its bodies, joints and hands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AllowedCollisions {
    /// Sorted by links.
    pub pairs: Vec<AllowedPair>,
}

impl AllowedCollisions {
    /// Seed of the matrix that a robot is loaded with.
    pub const SEED: u64 = 1;

    /// Finds the pairs of links with bodies that need not be looked at, as the head of the file tells.
    ///
    /// * `seed`: of the configurations that are drawn; equal seed, equal matrix.
    ///
    /// # Errors
    /// [`CollisionError`] naming the link whose shape has no volume or no finite size.
    pub fn compute(robot: &Robot, seed: u64) -> Result<Self, CollisionError> {
        let model = CollisionModel::new(robot)?;
        let tree = Tree::new(&model);
        let mut rng = Rng::new(seed, 0);
        let samples: Vec<Vec<Rigid>> = (0..SAMPLES).map(|_| tree.poses(&tree.random_q(&mut rng))).collect();
        let mut pairs = Vec::new();
        for (index, b) in tree.bodies.iter().enumerate() {
            for a in &tree.bodies[..index] {
                if let Some(reason) = tree.reason(robot, &samples, a, b) {
                    pairs.push(AllowedPair { a: a.link, b: b.link, reason });
                }
            }
        }
        pairs.sort_unstable();
        Ok(Self { pairs })
    }

    /// Why two links are not looked at; `None` if they are, or have no bodies.
    pub fn reason(&self, a: usize, b: usize) -> Option<AllowedReason> {
        let wanted = (a.min(b), a.max(b));
        let found = self.pairs.binary_search_by(|pair| (pair.a, pair.b).cmp(&wanted));
        found.ok().map(|index| self.pairs[index].reason)
    }

    /// Number of pairs for a reason.
    pub fn count(&self, reason: AllowedReason) -> usize {
        self.pairs.iter().filter(|pair| pair.reason == reason).count()
    }
}

/// What collides of one link, in the moving frame F that carries it.
struct Body {
    link: usize,
    frame: usize,
    solids: Vec<Solid>,
    /// Points whose hull holds the cores of all solids.
    corners: Vec<Vector3<f64>>,
}

/// All moving frames of the robot and the bodies on them.
struct Tree {
    frames: Vec<MovingFrame>,
    bodies: Vec<Body>,
    limits: Vec<JointLimit>,
}

impl Tree {
    fn new(model: &CollisionModel) -> Self {
        let robot = model.robot();
        let dofs: Vec<usize> = (0..robot.dof_count()).collect();
        let (frames, links) = moving_frames(model, &dofs, &vec![0.0; dofs.len()]);
        let mut bodies = Vec::new();
        for (link, (frame, X_FL)) in links.iter().enumerate() {
            let solids: Vec<Solid> = model.solids_L[link].iter().map(|solid| solid.carried_by(X_FL)).collect();
            if !solids.is_empty() {
                let corners = solids.iter().flat_map(corners).collect();
                bodies.push(Body { link, frame: *frame, solids, corners });
            }
        }
        let limits = robot.dof_joints.iter().map(|&joint| robot.joints[joint].limit).collect();
        Self { frames, bodies, limits }
    }

    fn random_q(&self, rng: &mut Rng) -> Vec<f64> {
        self.limits.iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect()
    }

    /// Pose of every moving frame in the world.
    fn poses(&self, q: &[f64]) -> Vec<Rigid> {
        let mut X_WF = vec![Rigid::identity()];
        for frame in &self.frames[1..] {
            X_WF.push(frame.placed(&X_WF[frame.parent], q));
        }
        X_WF
    }

    fn reason(&self, robot: &Robot, samples: &[Vec<Rigid>], a: &Body, b: &Body) -> Option<AllowedReason> {
        if a.frame == b.frame {
            return Some(AllowedReason::Welded);
        }
        if robot.arms.iter().any(|arm| arm.hand.links.contains(&a.link) && arm.hand.links.contains(&b.link)) {
            return Some(AllowedReason::Hand);
        }
        let touches = |X_WF: &&Vec<Rigid>| distance(a, &X_WF[a.frame], b, &X_WF[b.frame], 0.0) <= 0.0;
        match samples.iter().filter(touches).count() {
            0 if self.is_proven_apart(a, b) => Some(AllowedReason::Never),
            NEARLY_ALL.. if self.are_joined(a, b) => Some(AllowedReason::Adjacent),
            _ if self.is_elbow(samples, a, b) => Some(AllowedReason::Adjacent),
            NEARLY_ALL.. => Some(AllowedReason::Always),
            _ => None,
        }
    }

    /// Whether two bodies are the two sides of an elbow: one hangs on the other by two turning joints whose axes meet,
    /// and a body between the joints overlaps both nearly always.
    fn is_elbow(&self, samples: &[Vec<Rigid>], a: &Body, b: &Body) -> bool {
        let (inner, outer) = (a.frame.min(b.frame), a.frame.max(b.frame));
        let middle = self.frames[outer].parent;
        let joints = [middle, outer].map(|frame| &self.frames[frame]);
        if middle == 0 || joints[0].parent != inner || joints.iter().any(|joint| joint.kind != JointKind::Revolute) {
            return false;
        }
        // In the middle frame the first axis passes through the origin.
        let (first, second) = (joints[0].axis, joints[1].X_PJ.R * joints[1].axis);
        let across = first.cross(&second);
        let gap_m = joints[1].X_PJ.t.dot(&across).abs();
        if across.norm() < 0.1 || gap_m > ELBOW_M * across.norm() {
            return false;
        }
        let overlaps = |x: &Body, y: &Body| {
            let touches = |X_WF: &&Vec<Rigid>| distance(x, &X_WF[x.frame], y, &X_WF[y.frame], 0.0) <= 0.0;
            samples.iter().filter(touches).count() >= NEARLY_ALL
        };
        self.bodies.iter().any(|body| body.frame == middle && overlaps(body, a) && overlaps(body, b))
    }

    /// Whether nothing that collides stands between two bodies, one of which hangs on the other.
    fn are_joined(&self, a: &Body, b: &Body) -> bool {
        let (inner, outer) = (a.frame.min(b.frame), a.frame.max(b.frame));
        let mut frame = self.frames[outer].parent;
        while frame > inner && !self.bodies.iter().any(|body| body.frame == frame) {
            frame = self.frames[frame].parent;
        }
        frame == inner
    }

    /// The frames that move one body relative to the other: from the last common one down to each.
    fn way(&self, a: usize, b: usize) -> [Vec<usize>; 2] {
        let (mut a, mut b) = (a, b);
        let mut ways = [Vec::new(), Vec::new()];
        // Parents have smaller numbers, so the larger of the two is never above the other.
        while a != b {
            let (way, frame) = if a > b { (&mut ways[0], &mut a) } else { (&mut ways[1], &mut b) };
            way.push(*frame);
            *frame = self.frames[*frame].parent;
        }
        ways.iter_mut().for_each(|way| way.reverse());
        ways
    }

    /// Whether the two touch nowhere within the limits; `false` also where that is not found out.
    fn is_proven_apart(&self, a: &Body, b: &Body) -> bool {
        let mut proof = Proof { tree: self, a, b, ways: self.way(a.frame, b.frame), q: vec![0.0; self.limits.len()] };
        let joints: usize = proof.ways.iter().map(Vec::len).sum();
        let most_boxes = MOST_BOXES.checked_shr(u32::try_from(joints).unwrap_or(u32::MAX)).unwrap_or(0);
        let whole: Vec<(f64, f64)> = self.limits.iter().map(|limit| (limit.lower, limit.upper)).collect();
        let mut left = Vec::new();
        let mut boxes = 1;
        match proof.look_at(&whole) {
            Found::Apart => return true,
            Found::Touching => return false,
            Found::Open { halve, .. } => left.push((whole, halve)),
        }
        while let Some((open, halve)) = left.pop() {
            let (lower, upper) = open[halve];
            let middle = 0.5 * (lower + upper);
            let mut nearest_m = f64::INFINITY;
            for half in [(lower, middle), (middle, upper)] {
                let mut part = open.clone();
                part[halve] = half;
                boxes += 1;
                match proof.look_at(&part) {
                    Found::Apart => {}
                    Found::Open { halve, distance_m } if boxes < most_boxes => {
                        // The nearer half comes off first: if they touch anywhere, it is likely there.
                        let at = if distance_m <= nearest_m { left.len() } else { left.len() - 1 };
                        nearest_m = nearest_m.min(distance_m);
                        left.insert(at, (part, halve));
                    }
                    _ => return false,
                }
            }
        }
        true
    }
}

/// What one box of joint positions says.
enum Found {
    /// The bodies touch nowhere in it.
    Apart,
    /// They touch at its middle.
    Touching,
    /// Neither; the degree of freedom to halve, and the distance at the middle.
    Open { halve: usize, distance_m: f64 },
}

/// Two bodies and the joints between them.
struct Proof<'a> {
    tree: &'a Tree,
    a: &'a Body,
    b: &'a Body,
    /// Frames from the last common one down to each of the two.
    ways: [Vec<usize>; 2],
    /// Where the robot stands; only the joints between the two matter.
    q: Vec<f64>,
}

impl Proof<'_> {
    fn look_at(&mut self, limits: &[(f64, f64)]) -> Found {
        for frame in self.ways.iter().flatten() {
            let column = self.tree.frames[*frame].column;
            self.q[column] = 0.5 * (limits[column].0 + limits[column].1);
        }
        // In the last common frame C: each joint's axis at the middle, numbered from A to B, and the two bodies.
        let mut axes = Vec::new();
        let X_CF = [0, 1].map(|side| {
            let mut X_CF = Rigid::identity();
            for &frame in &self.ways[side] {
                let joint = &self.tree.frames[frame];
                let X_CJ = X_CF.then(&joint.X_PJ);
                axes.push((frame, X_CJ.t, X_CJ.R * joint.axis));
                X_CF = joint.placed(&X_CF, &self.q);
            }
            X_CF
        });
        axes[..self.ways[0].len()].reverse();
        // How far each joint moves A, and B.
        let steps: Vec<[f64; 2]> = axes
            .iter()
            .map(|(frame, origin, axis)| {
                let joint = &self.tree.frames[*frame];
                let (lower, upper) = limits[joint.column];
                let half = 0.5 * (upper - lower) * joint.multiplier.abs();
                if joint.kind == JointKind::Prismatic {
                    return [half; 2];
                }
                let chord = 2.0 * math::sin(0.5 * half.min(core::f64::consts::PI));
                let farthest = |body: &Body, X: &Rigid| {
                    let from_axis = |p: &Vector3<f64>| (X.point(p) - origin).cross(axis).norm_squared();
                    body.corners.iter().map(from_axis).fold(0.0, f64::max).sqrt()
                };
                [farthest(self.a, &X_CF[0]), farthest(self.b, &X_CF[1])].map(|lever| chord * lever)
            })
            .collect();
        // Joints before `split` move A, the others B.
        let travel = |split: usize| -> f64 {
            steps.iter().enumerate().map(|(index, step)| step[usize::from(index >= split)]).sum()
        };
        let best = (0..=steps.len()).map(|split| (travel(split), split)).min_by(|x, y| x.0.total_cmp(&y.0));
        let Some((travel_m, split)) = best else { return Found::Touching };
        let wanted = travel_m + SLACK_M;
        let distance_m = distance(self.a, &X_CF[0], self.b, &X_CF[1], wanted);
        if distance_m > wanted {
            return Found::Apart;
        }
        if distance_m <= SLACK_M {
            return Found::Touching;
        }
        let mut added = vec![0.0; limits.len()];
        for (index, (step, (frame, _, _))) in steps.iter().zip(&axes).enumerate() {
            added[self.tree.frames[*frame].column] += step[usize::from(index >= split)];
        }
        let most = added.iter().enumerate().max_by(|x, y| x.1.total_cmp(y.1));
        Found::Open { halve: most.map_or(0, |(column, _)| column), distance_m }
    }
}

/// Points whose hull holds the core of a solid, in the frame that carries it.
fn corners(solid: &Solid) -> Vec<Vector3<f64>> {
    if let Core::Segment { a, b } = &solid.core {
        return vec![*a, *b];
    }
    let reach = |axis: usize, sign: f64| {
        let mut direction = Vector3::zeros();
        direction[axis] = sign;
        solid.core.support(&direction)[axis]
    };
    let (lower, upper) = (Vector3::from_fn(|i, _| reach(i, -1.0)), Vector3::from_fn(|i, _| reach(i, 1.0)));
    let corner = |k: usize| Vector3::from_fn(|i, _| if k >> i & 1 == 0 { lower[i] } else { upper[i] });
    (0..8).map(|k| solid.X_FB.point(&corner(k))).collect()
}

/// Signed distance of two bodies, metres, or anything above `enough_m` where it is larger than that.
fn distance(a: &Body, X_CA: &Rigid, b: &Body, X_CB: &Rigid, enough_m: f64) -> f64 {
    let mut least = f64::INFINITY;
    for s in &a.solids {
        for t in &b.solids {
            let between_balls = (X_CA.point(&s.center) - X_CB.point(&t.center)).norm() - s.bound - t.bound;
            if between_balls > enough_m {
                least = least.min(between_balls);
            } else {
                least = least.min(signed_distance(s, X_CA, t, X_CB));
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::AllowedReason::{Adjacent, Always, Hand, Never, Welded};
    use super::*;
    use crate::collision::testing::random_q;
    use crate::collision::{Exhaustive, World};
    use crate::robot::{load_robot, samples};

    const BALL: &str = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
    /// From the origin of the link 0.5 m up.
    const BAR: &str =
        "<collision><origin xyz='0 0 0.25'/><geometry><capsule radius='0.05' length='0.5'/></geometry></collision>";
    /// From 0.35 m below the origin of the link to 0.85 m above it.
    const LONG_BAR: &str =
        "<collision><origin xyz='0 0 0.25'/><geometry><capsule radius='0.05' length='1.2'/></geometry></collision>";

    /// A joint about or along y.
    struct Between(&'static str, &'static str, &'static str, f64, f64);

    /// Links with their bodies; joints: parent, child, kind, height above the parent in metres, limit to either side.
    fn robot(links: &[(&str, &str)], joints: &[Between], srdf: &str) -> Robot {
        let links = links.iter().map(|(name, body)| format!("<link name='{name}'>{body}</link>"));
        let joints = joints.iter().map(|Between(parent, child, kind, z, limit)| {
            format!(
                "<joint name='{child}_joint' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
                 <origin xyz='0 0 {z}'/><axis xyz='0 1 0'/><limit lower='-{limit}' upper='{limit}'/></joint>"
            )
        });
        let urdf = format!("<robot name='r'>{}{}</robot>", links.collect::<String>(), joints.collect::<String>());
        load_robot(&urdf, &format!("<robot>{srdf}</robot>"), &|_| None).unwrap().value
    }

    fn reasons(robot: &Robot) -> Vec<(&str, &str, AllowedReason)> {
        let name = |link: usize| robot.links[link].name.as_str();
        let computed = AllowedCollisions::compute(robot, 1).unwrap();
        computed.pairs.iter().map(|pair| (name(pair.a), name(pair.b), pair.reason)).collect()
    }

    #[test]
    fn an_elbow_of_two_joints_is_one_and_what_is_welded_beyond_it_is_not() {
        let elbow = robot(
            &[("base", BAR), ("cross", ""), ("arm", BAR), ("tool", BALL)],
            &[
                Between("base", "cross", "revolute", 0.5, 0.5),
                Between("cross", "arm", "revolute", 0.0, 0.5),
                Between("arm", "tool", "fixed", 0.5, 0.0),
            ],
            "",
        );
        assert_eq!(reasons(&elbow), [("base", "arm", Adjacent), ("base", "tool", Never), ("arm", "tool", Welded)]);
    }

    #[test]
    fn the_two_sides_of_an_elbow_may_bend_until_they_touch_and_axes_that_pass_each_other_make_none() {
        // Both bars stop 0.1 m short of the ball's centre, which is where the axes meet.
        let short =
            "<collision><origin xyz='0 0 0.25'/><geometry><capsule radius='0.05' length='0.2'/></geometry></collision>";
        let bent = |offset_m: f64| {
            let urdf = format!(
                "<robot name='r'><link name='base'>{short}</link><link name='ball'>{BALL}</link><link name='arm'>{short}</link>
                 <joint name='bend' type='revolute'><parent link='base'/><child link='ball'/><origin xyz='0 0 0.45'/>
                 <axis xyz='0 1 0'/><limit lower='-2.9' upper='2.9'/></joint>
                 <joint name='roll' type='revolute'><parent link='ball'/><child link='arm'/>
                 <origin xyz='{offset_m} 0 -0.05'/><axis xyz='0 0 1'/><limit lower='-3' upper='3'/></joint></robot>"
            );
            let robot = load_robot(&urdf, "<robot/>", &|_| None).unwrap().value;
            AllowedCollisions::compute(&robot, 1).unwrap().reason(0, 2)
        };
        assert_eq!(bent(0.0), Some(Adjacent));
        assert_eq!(bent(0.05), None);
    }

    #[test]
    fn bodies_that_overlap_through_another_always_touch() {
        let stack = robot(
            &[("base", BAR), ("ball", BALL), ("arm", LONG_BAR)],
            &[Between("base", "ball", "revolute", 0.5, 0.1), Between("ball", "arm", "revolute", 0.0, 0.05)],
            "",
        );
        assert_eq!(reasons(&stack), [("base", "ball", Adjacent), ("base", "arm", Always), ("ball", "arm", Adjacent)]);
    }

    #[test]
    fn fingers_of_one_hand_are_not_looked_at() {
        let srdf = "<group name='left'><joint name='arm_joint'/></group>
            <group name='h'><link name='palm'/><link name='one'/><link name='two'/><link name='left_tcp'/></group>
            <end_effector group='h' parent_group='left'/>";
        let gripper = robot(
            &[("base", BALL), ("arm", BAR), ("palm", BALL), ("one", BALL), ("two", BALL), ("left_tcp", "")],
            &[
                Between("base", "arm", "revolute", 0.05, 0.5),
                Between("arm", "palm", "fixed", 0.5, 0.0),
                Between("palm", "one", "prismatic", 0.1, 0.2),
                Between("palm", "two", "prismatic", 0.1, 0.2),
                Between("palm", "left_tcp", "fixed", 0.1, 0.0),
            ],
            srdf,
        );
        let found = reasons(&gripper);
        for pair in [("palm", "one", Hand), ("palm", "two", Hand), ("one", "two", Hand), ("base", "palm", Never)] {
            assert!(found.contains(&pair), "{pair:?} in {found:?}");
        }
    }

    #[test]
    fn a_pair_that_touches_in_a_hundredth_of_its_range_is_looked_at() {
        // The tip is cos(q / 2) m from the base, both are 0.1 m thick: they touch from q = 2.739 rad on.
        for (limit_rad, wanted) in [(2.72, Some(Never)), (2.76, None), (3.1, None)] {
            let swing = robot(
                &[("base", BALL), ("arm", ""), ("tip", BALL)],
                &[Between("base", "arm", "revolute", 0.5, limit_rad), Between("arm", "tip", "fixed", 0.5, 0.0)],
                "",
            );
            assert_eq!(AllowedCollisions::compute(&swing, 1).unwrap().reason(0, 2), wanted, "±{limit_rad}");
        }
    }

    #[test]
    fn what_the_srdf_lists_is_added() {
        let srdf = "<disable_collisions link1='tip' link2='base' reason='Mine'/>";
        let swing = |srdf: &str| {
            robot(
                &[("base", BALL), ("arm", ""), ("tip", BALL)],
                &[Between("base", "arm", "revolute", 0.5, 3.1), Between("arm", "tip", "fixed", 0.5, 0.0)],
                srdf,
            )
        };
        assert_eq!(swing("").allowed_collisions, []);
        assert_eq!(swing(srdf).allowed_collisions, [(0, 2)]);
    }

    #[test]
    fn the_judge_finds_no_contact_of_a_pair_that_is_proven_apart() {
        for mut robot in [samples::alita(), samples::crichton()] {
            let computed = AllowedCollisions::compute(&robot, 1).unwrap();
            assert_eq!(computed, AllowedCollisions::compute(&robot, 1).unwrap(), "equal seed, equal matrix");
            assert!(computed.count(Never) > 50, "{}", computed.count(Never));
            // Only the proven pairs are looked at.
            let pairs = (0..robot.links.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
            robot.allowed_collisions = pairs.filter(|&(a, b)| computed.reason(a, b) != Some(Never)).collect();
            robot.allowed_collisions.sort_unstable();
            let model = CollisionModel::new(&robot).unwrap();
            let judge = Exhaustive::new(&model, &World::new(), None, &[]).unwrap();
            let mut rng = Rng::new(8, 0);
            for _ in 0..20_000 {
                let q = random_q(&robot, &mut rng);
                assert_eq!(judge.first_hit_with_balls(&q), None, "{} at {q:?}", robot.name);
            }
        }
    }

    #[test]
    fn both_robots_stand_free_in_their_postures_but_for_one() {
        for robot in [samples::alita(), samples::crichton()] {
            let model = CollisionModel::new(&robot).unwrap();
            let judge = Exhaustive::new(&model, &World::new(), None, &[]).unwrap();
            for (name, q) in &robot.postures {
                // Crichton hugs with one hand in the other.
                let is_hug = robot.name == "crichton" && name == "hug";
                let hit = judge.first_hit(q);
                assert_eq!(hit.is_some(), is_hug, "{} in {name}: {hit:?}", robot.name);
            }
        }
    }
}
