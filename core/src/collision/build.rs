//! Setting up a checker: what moves with which joint, what can ever meet, and how far a joint throws a body.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::checker::{CONTACT_M, Checker, Cluster, ConstantPair, Fixed, MovingPair, Obstacles, Owner};
use super::frames::{MovingFrame, Rigid};
use super::model::{CollisionError, CollisionModel};
use super::setup::{CarriedObject, MayTouch, Party};
use super::sieve::Sieve;
use super::solid::Solid;
use super::world::World;
use crate::math;
use crate::robot::{Joint, JointKind};

/// From this many obstacles on they are looked up in a tree instead of one after the other.
const MANY: usize = 32;

pub(crate) fn build(
    model: &CollisionModel,
    world: &World,
    carried: Option<&CarriedObject>,
    may_touch: &[MayTouch],
    dofs: Vec<usize>,
    q_rest: &[f64],
) -> Result<Checker, CollisionError> {
    let robot = &*model.robot;
    if q_rest.len() != robot.dof_joints.len() {
        return Err(CollisionError::WrongLength { found: q_rest.len(), wanted: robot.dof_joints.len() });
    }
    let (frames, link_frames) = moving_frames(model, &dofs, q_rest);
    let mut fixed: Vec<Fixed> = Vec::new();
    let mut clusters: Vec<Cluster> = Vec::new();
    fixed.extend(world.obstacles.iter().enumerate().map(|(index, obstacle)| {
        let (solid, lower, upper) = (obstacle.solid_W.clone(), obstacle.lower, obstacle.upper);
        Fixed { owner: Owner::Obstacle(index), solid, lower, upper }
    }));
    let mut add = |owner: Owner, frame: usize, solids: Vec<Solid>| {
        if frame == 0 {
            fixed.extend(solids.into_iter().map(|solid| {
                let (lower, upper) = solid.aabb();
                Fixed { owner, solid, lower, upper }
            }));
        } else if !solids.is_empty() {
            clusters.push(cluster(owner, frame, solids));
        }
    };
    if let Some(carried) = carried {
        let (frame, X_FL) = link_frames
            .get(carried.tcp_link)
            .ok_or(CollisionError::NoSuchArm { found: carried.tcp_link, arms: robot.arms.len() })?;
        add(Owner::Carried, *frame, carried.solids_H.iter().map(|solid| solid.carried_by(X_FL)).collect());
    }
    // Links from the hand back to the shoulder: the hand meets things first.
    for (link, (frame, X_FL)) in link_frames.iter().enumerate().rev() {
        add(Owner::Link(link), *frame, model.solids_L[link].iter().map(|solid| solid.carried_by(X_FL)).collect());
    }

    let allowed = Allowed { model, world, carried, may_touch };
    // A cloud is thousands of obstacles of one name: what holds for one holds for the next.
    let is_same: Vec<bool> = fixed
        .windows(2)
        .map(|pair| match (pair[0].owner, pair[1].owner) {
            (Owner::Obstacle(a), Owner::Obstacle(b)) => world.obstacles[a].name == world.obstacles[b].name,
            _ => false,
        })
        .collect();
    for cluster in &mut clusters {
        let reach = reach(&frames, cluster);
        let mut depth_m = None;
        for (index, thing) in fixed.iter().enumerate() {
            if !(index > 0 && is_same[index - 1]) {
                depth_m = allowed.depth_m(cluster.owner, thing.owner);
            }
            let Some(depth_m) = depth_m else { continue };
            let out_of_reach = reach.is_some_and(|(origin_W, radius)| {
                squared_distance_to_box(&origin_W, &thing.lower, &thing.upper) > radius * radius
            });
            let list = if out_of_reach { &mut cluster.out_of_reach } else { &mut cluster.against };
            list.push((index, depth_m));
        }
    }
    let mut pairs = Vec::new();
    let mut constant = Vec::new();
    for a in 0..clusters.len() {
        for b in 0..a {
            let Some(depth_m) = allowed.depth_m(clusters[a].owner, clusters[b].owner) else { continue };
            // Clusters stand from the hand back to the shoulder, so `b` is the outer one of a chain.
            let (frame_a, frame_b) = (clusters[a].frame, clusters[b].frame);
            if frame_a == frame_b {
                constant.push((ConstantPair::Welded(b, a), depth_m));
            } else if hangs_on(&frames, frame_a, frame_b) {
                pairs.push(MovingPair { a: b, b: a, depth_m, b_hangs_on_a: true });
            } else {
                pairs.push(MovingPair { a, b, depth_m, b_hangs_on_a: hangs_on(&frames, frame_b, frame_a) });
            }
        }
    }
    // Obstacles stand first, and are not compared with each other.
    for a in world.obstacles.len()..fixed.len() {
        let mut depth_m = None;
        for b in 0..a {
            if !(b > 0 && is_same[b - 1]) {
                depth_m = allowed.depth_m(fixed[a].owner, fixed[b].owner);
            }
            if let Some(depth_m) = depth_m {
                constant.push((ConstantPair::Fixed(a, b), depth_m));
            }
        }
    }
    let levers = levers(&frames, &clusters, dofs.len());
    let mut checker = Checker {
        dofs,
        frames,
        clusters,
        fixed,
        pairs,
        constant,
        constant_hit: None,
        levers,
        margin_m: CONTACT_M,
        link_names: robot.links.iter().map(|link| link.name.clone()).collect(),
        obstacle_names: world.obstacles.iter().map(|obstacle| obstacle.name.clone()).collect(),
        carried_name: carried.map(|carried| carried.name.clone()).unwrap_or_default(),
        sieve: Sieve::default(),
        tree: (world.obstacles.len() >= MANY)
            .then(|| Obstacles { tree: world.tree().clone(), count: world.obstacles.len() }),
    };
    checker.sieve = Sieve::new(&checker);
    checker.constant_hit = checker.find_constant_hit();
    Ok(checker)
}

/// The moving frames, and for each link its frame and its pose in it.
pub(super) fn moving_frames(
    model: &CollisionModel,
    dofs: &[usize],
    q_rest: &[f64],
) -> (Vec<MovingFrame>, Vec<(usize, Isometry3<f64>)>) {
    let world = MovingFrame {
        parent: 0,
        X_PJ: Rigid::identity(),
        axis: Vector3::z(),
        kind: JointKind::Fixed,
        column: 0,
        multiplier: 0.0,
        offset: 0.0,
        slide_m: 0.0,
    };
    let mut frames = vec![world];
    let mut links = vec![(0, Isometry3::identity())];
    for joint in &model.robot.joints {
        let (parent, X_FP) = links[joint.parent];
        let X_FJ = X_FP * joint.X_PJ;
        let drive = match (joint.kind, joint.dof, joint.mimic) {
            (JointKind::Fixed, _, _) => None,
            (_, Some(dof), _) => Some((dof, 1.0, 0.0)),
            (_, None, Some(mimic)) => Some((mimic.dof, mimic.multiplier, mimic.offset)),
            (_, None, None) => None,
        };
        let column = drive.and_then(|(dof, _, _)| dofs.iter().position(|&moving| moving == dof));
        links.push(match (drive, column) {
            (Some((_, multiplier, offset)), Some(column)) => {
                let slide_m = match joint.kind {
                    JointKind::Prismatic => joint.limit.lower.abs().max(joint.limit.upper.abs()),
                    _ => 0.0,
                };
                frames.push(MovingFrame {
                    parent,
                    X_PJ: Rigid::from_isometry(&X_FJ),
                    axis: joint.axis.into_inner(),
                    kind: joint.kind,
                    column,
                    multiplier,
                    offset,
                    slide_m,
                });
                (frames.len() - 1, Isometry3::identity())
            }
            (Some((dof, multiplier, offset)), None) => {
                (parent, X_FJ * joint_motion(joint, multiplier * q_rest[dof] + offset))
            }
            (None, _) => (parent, X_FJ),
        });
    }
    (frames, links)
}

/// Motion of a joint from position 0, in the joint frame.
fn joint_motion(joint: &Joint, position: f64) -> Isometry3<f64> {
    match joint.kind {
        JointKind::Fixed => Isometry3::identity(),
        JointKind::Prismatic => Isometry3::from(Translation3::from(joint.axis.into_inner() * position)),
        JointKind::Revolute => {
            let (sin, cos) = math::sin_cos(0.5 * position);
            let v = joint.axis.into_inner() * sin;
            let rotation = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cos, v.x, v.y, v.z));
            Isometry3::from_parts(Translation3::identity(), rotation)
        }
    }
}

fn cluster(owner: Owner, frame: usize, solids: Vec<Solid>) -> Cluster {
    let lower = solids.iter().fold(Vector3::repeat(f64::INFINITY), |m, s| m.inf(&s.center));
    let upper = solids.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |m, s| m.sup(&s.center));
    let center = 0.5 * (lower + upper);
    let bound = solids.iter().map(|s| (s.center - center).norm() + s.bound).fold(0.0, f64::max);
    Cluster { owner, frame, center, bound, solids, against: Vec::new(), out_of_reach: Vec::new() }
}

/// Ball in the world that the cluster never leaves; `None` is never returned for a cluster of a moving frame.
fn reach(frames: &[MovingFrame], cluster: &Cluster) -> Option<(Vector3<f64>, f64)> {
    let mut radius = cluster.center.norm() + cluster.bound;
    let mut frame = frames.get(cluster.frame)?;
    loop {
        radius += frame.slide_m;
        if frame.parent == 0 {
            return Some((frame.X_PJ.t, radius));
        }
        radius += frame.X_PJ.t.norm();
        frame = frames.get(frame.parent)?;
    }
}

/// Whether `outer` is moved by the joint of `inner`.
fn hangs_on(frames: &[MovingFrame], inner: usize, outer: usize) -> bool {
    let mut frame = outer;
    while frame != 0 {
        if frame == inner {
            return true;
        }
        frame = frames[frame].parent;
    }
    false
}

/// For each frame and each column of `q`: the largest distance of a point of the frame's bodies to the joint's axis
/// over all configurations (m/rad), or 1 for a prismatic joint; 0 for joints that do not move the frame.
fn levers(frames: &[MovingFrame], clusters: &[Cluster], columns: usize) -> Vec<Vec<f64>> {
    let mut all = vec![vec![0.0; columns]; frames.len()];
    for (index, levers) in all.iter_mut().enumerate().skip(1) {
        let solids = || clusters.iter().filter(|c| c.frame == index).flat_map(|c| &c.solids);
        if solids().next().is_none() {
            continue;
        }
        let perpendicular = |p: &Vector3<f64>, axis: &Vector3<f64>| (p - axis * p.dot(axis)).norm();
        // The ball about the frame's origin that holds its bodies; grows on the way to the root.
        let mut ball = solids().map(|s| s.center.norm() + s.bound).fold(0.0, f64::max);
        let mut frame = index;
        let mut lever = solids().map(|s| perpendicular(&s.center, &frames[frame].axis) + s.bound).fold(0.0, f64::max);
        loop {
            let joint = &frames[frame];
            let per_unit = if joint.kind == JointKind::Prismatic { 1.0 } else { lever };
            levers[joint.column] += per_unit * joint.multiplier.abs();
            let parent = joint.parent;
            if parent == 0 {
                break;
            }
            ball += joint.slide_m;
            lever = perpendicular(&joint.X_PJ.t, &frames[parent].axis) + ball;
            ball += joint.X_PJ.t.norm();
            frame = parent;
        }
    }
    all
}

pub(crate) fn squared_distance_to_box(p: &Vector3<f64>, lower: &Vector3<f64>, upper: &Vector3<f64>) -> f64 {
    let dx = (lower.x - p.x).max(p.x - upper.x).max(0.0);
    let dy = (lower.y - p.y).max(p.y - upper.y).max(0.0);
    let dz = (lower.z - p.z).max(p.z - upper.z).max(0.0);
    dx * dx + dy * dy + dz * dz
}

/// Which contacts are looked at, and how deep intended ones may be.
struct Allowed<'a> {
    model: &'a CollisionModel,
    world: &'a World,
    carried: Option<&'a CarriedObject>,
    may_touch: &'a [MayTouch],
}

impl Allowed<'_> {
    /// Depth to which two owners may touch, metres; `None` if they are not looked at.
    fn depth_m(&self, a: Owner, b: Owner) -> Option<f64> {
        let looked_at = match (a, b) {
            (Owner::Link(a), Owner::Link(b)) => self.model.looked_at(a, b),
            (Owner::Obstacle(_), Owner::Obstacle(_)) | (Owner::Carried, Owner::Carried) => false,
            (Owner::Link(link), Owner::Carried) | (Owner::Carried, Owner::Link(link)) => {
                self.carried.is_some_and(|carried| !carried.touching.contains(&link))
            }
            _ => true,
        };
        if !looked_at {
            return None;
        }
        let is = |party: &Party, owner: Owner| match (party, owner) {
            (Party::Link(named), Owner::Link(link)) => *named == link,
            (Party::Obstacle(named), Owner::Obstacle(index)) => self.world.obstacles[index].name == *named,
            (Party::Carried, Owner::Carried) => true,
            _ => false,
        };
        let intended = self.may_touch.iter().filter(|m| (is(&m.a, a) && is(&m.b, b)) || (is(&m.a, b) && is(&m.b, a)));
        let depth_m = intended.map(|m| m.depth_m.max(0.0)).fold(0.0, f64::max);
        (depth_m < f64::INFINITY).then_some(depth_m)
    }
}
