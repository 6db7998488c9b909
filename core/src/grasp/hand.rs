//! A hand on its own: where its links are for given finger positions, and the spheres that stand for their surfaces.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::math;
use crate::robot::{Arm, Geometry, JointKind, Robot};

/// Distance between neighbouring spheres on a link, metres: half the thickness of a finger, so that no bump of the
/// object as wide as a finger fits between two of them, and a ball in a flat jaw touches more than one.
const SPHERE_SPACING_M: f64 = 0.006;
/// Edge of the cells in which the spheres of a link are grouped, metres: some twenty each on a flat face.
const PATCH_M: f64 = 0.028;

/// A hand cut off its arm: every link's pose in the hand frame H follows from the finger positions alone.
#[derive(Clone, Debug)]
pub struct HandModel {
    /// Links of the hand, parents first; the palm is at index 0.
    pub links: Vec<HandLink>,
    /// Finger values (indices into a finger position vector) of each finger, proximal before distal.
    pub fingers: Vec<Vec<usize>>,
    /// Open posture.
    pub open: Vec<f64>,
    /// Posture in which closing ends when nothing is met.
    pub closed: Vec<f64>,
    X_HP: Isometry3<f64>,
    /// For each finger value: metres that any point of the hand moves at most per unit of it.
    levers: Vec<f64>,
}

/// One link of a hand.
#[derive(Clone, Debug)]
pub struct HandLink {
    /// Name in the URDF.
    pub name: String,
    /// Spheres that cover its collision bodies, neighbours in patches.
    pub patches: Vec<Patch>,
    /// Ball around all of them: centre in the link frame and radius, metres.
    pub ball: (Point3<f64>, f64),
    /// Finger values that move this link, proximal first.
    pub moved_by: Vec<usize>,
    parent: usize,
    X_PJ: Isometry3<f64>,
    axis: Vector3<f64>,
    motion: Option<(JointKind, FingerValue)>,
}

/// Neighbouring spheres of a link, in the link frame: centre and radius, metres.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The spheres.
    pub spheres: Vec<(Point3<f64>, f64)>,
    /// Ball around all of them.
    pub ball: (Point3<f64>, f64),
}

impl HandLink {
    /// All spheres of the link.
    pub fn spheres(&self) -> impl Iterator<Item = &(Point3<f64>, f64)> {
        self.patches.iter().flat_map(|patch| &patch.spheres)
    }
}

#[derive(Clone, Copy, Debug)]
struct FingerValue {
    index: usize,
    multiplier: f64,
    offset: f64,
}

impl HandModel {
    /// The hand of one arm of a robot.
    pub fn new(robot: &Robot, arm: &Arm) -> Self {
        let hand = &arm.hand;
        let flat: Vec<usize> = hand.fingers.iter().flatten().copied().collect();
        let zero = robot.link_poses(&vec![0.0; robot.dof_count()]);
        let mut members = vec![hand.palm_link];
        let mut links = vec![HandLink {
            name: robot.links[hand.palm_link].name.clone(),
            ball: ball_around(&cover_link(robot, hand.palm_link)),
            patches: patches(cover_link(robot, hand.palm_link)),
            moved_by: Vec::new(),
            parent: 0,
            X_PJ: Isometry3::identity(),
            axis: Vector3::z(),
            motion: None,
        }];
        for joint in &robot.joints {
            let Some(parent) = members.iter().position(|&link| link == joint.parent) else { continue };
            let value = |dof: usize, multiplier, offset| {
                flat.iter().position(|&known| known == dof).map(|index| FingerValue { index, multiplier, offset })
            };
            let motion = match (joint.dof, joint.mimic) {
                (Some(dof), _) => value(dof, 1.0, 0.0),
                (None, Some(mimic)) => value(mimic.dof, mimic.multiplier, mimic.offset),
                (None, None) => None,
            };
            let mut moved_by = links[parent].moved_by.clone();
            moved_by.extend(motion.map(|m| m.index));
            members.push(joint.child);
            let spheres = cover_link(robot, joint.child);
            links.push(HandLink {
                name: robot.links[joint.child].name.clone(),
                ball: ball_around(&spheres),
                patches: patches(spheres),
                moved_by,
                parent,
                X_PJ: joint.X_PJ,
                axis: joint.axis.into_inner(),
                motion: motion.map(|m| (joint.kind, m)),
            });
        }
        let mut next = 0;
        let fingers = hand
            .fingers
            .iter()
            .map(|finger| {
                next += finger.len();
                (next - finger.len()..next).collect()
            })
            .collect();
        let levers = (0..flat.len()).map(|value| lever(&links, value)).collect();
        Self {
            levers,
            links,
            fingers,
            open: hand.open.clone(),
            closed: hand.closed.clone(),
            X_HP: zero[hand.tcp_link].inv_mul(&zero[hand.palm_link]),
        }
    }

    /// Pose `X_HL` of every link for the finger positions, in the order of `links`.
    pub fn link_poses(&self, finger_positions: &[f64]) -> Vec<Isometry3<f64>> {
        let mut X_HL = Vec::with_capacity(self.links.len());
        self.link_poses_into(finger_positions, &mut X_HL);
        X_HL
    }

    /// As [`HandModel::link_poses`], into a vector that is reused.
    pub fn link_poses_into(&self, finger_positions: &[f64], X_HL: &mut Vec<Isometry3<f64>>) {
        X_HL.clear();
        X_HL.push(self.X_HP);
        for link in &self.links[1..] {
            let X_HJ = X_HL[link.parent] * link.X_PJ;
            X_HL.push(match link.motion {
                None => X_HJ,
                Some((kind, value)) => {
                    let position = value.multiplier * finger_positions[value.index] + value.offset;
                    if kind == JointKind::Prismatic {
                        X_HJ * Translation3::from(link.axis * position)
                    } else {
                        let (sin, cos) = math::sin_cos(0.5 * position);
                        let v = link.axis * sin;
                        X_HJ * UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cos, v.x, v.y, v.z))
                    }
                }
            });
        }
    }

    /// Metres that any point of the hand moves at most per unit (rad or m) of a finger value.
    pub fn lever(&self, value: usize) -> f64 {
        self.levers[value]
    }

    /// Distance between the finger surfaces along x_H when the hand is open, at the height of the TCP, metres.
    pub fn opening_m(&self) -> f64 {
        let X_HL = self.link_poses(&self.open);
        let (mut below, mut above) = (f64::INFINITY, f64::INFINITY);
        for (link, X) in self.links.iter().zip(&X_HL).filter(|(link, _)| !link.moved_by.is_empty()) {
            for (center, radius) in link.spheres() {
                let p = X * center;
                if p.z.abs() < 0.02 {
                    if p.x > 0.0 {
                        above = above.min(p.x - radius);
                    } else {
                        below = below.min(-p.x - radius);
                    }
                }
            }
        }
        if above.is_finite() && below.is_finite() { above + below } else { 0.0 }
    }

    /// Distance along z_H from the front of the palm to the TCP, metres.
    pub fn palm_depth_m(&self) -> f64 {
        let front = self.links[0].spheres().map(|(c, r)| (self.X_HP * c).z + r);
        -front.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// For each link that a value moves: the joint's multiplier times the length of the chain from the joint outwards.
fn lever(links: &[HandLink], value: usize) -> f64 {
    let mut outwards: Vec<Option<(f64, f64)>> = vec![None; links.len()];
    let mut lever: f64 = 1e-3;
    for (index, link) in links.iter().enumerate() {
        let own = link.motion.filter(|(_, m)| m.index == value);
        outwards[index] = match (own, outwards[link.parent]) {
            (Some((kind, m)), _) => {
                Some(if kind == JointKind::Prismatic { (m.multiplier.abs(), 0.0) } else { (0.0, m.multiplier.abs()) })
            }
            (None, Some((slide, chain))) => Some((slide, chain)),
            (None, None) => None,
        };
        if let Some((slide, turn)) = outwards[index] {
            lever = lever.max(slide + turn * reach_from(links, index, value));
        }
    }
    lever
}

/// Distance from the joint that a value moves to the farthest point of a link, along the chain, metres.
fn reach_from(links: &[HandLink], index: usize, value: usize) -> f64 {
    let (center, radius) = &links[index].ball;
    let mut reach = center.coords.norm() + radius;
    let mut at = index;
    while links[at].motion.is_none_or(|(_, m)| m.index != value) && at != links[at].parent {
        reach += links[at].X_PJ.translation.vector.norm();
        at = links[at].parent;
    }
    reach
}

/// Spheres grouped by the cell of a grid that their centre is in, the cells in a fixed order.
fn patches(spheres: Vec<(Point3<f64>, f64)>) -> Vec<Patch> {
    let cell = |p: &Point3<f64>| p.coords.map(|x| libm::floor(x / PATCH_M) as i64);
    let mut keyed: Vec<_> = spheres.into_iter().map(|sphere| (cell(&sphere.0), sphere)).collect();
    keyed.sort_by_key(|(cell, _)| (cell.x, cell.y, cell.z));
    let run = |run: &[(_, (Point3<f64>, f64))]| run.iter().map(|(_, sphere)| *sphere).collect::<Vec<_>>();
    let groups = keyed.chunk_by(|l, r| l.0 == r.0).map(run);
    groups.map(|spheres| Patch { ball: ball_around(&spheres), spheres }).collect()
}

/// A ball around spheres: their mean centre and what it takes to hold them all.
fn ball_around(spheres: &[(Point3<f64>, f64)]) -> (Point3<f64>, f64) {
    let sum: Vector3<f64> = spheres.iter().map(|(c, _)| c.coords).sum();
    let center = Point3::from(sum / spheres.len().max(1) as f64);
    (center, spheres.iter().map(|(c, r)| (c - center).norm() + r).fold(0.0, f64::max))
}

fn cover_link(robot: &Robot, link: usize) -> Vec<(Point3<f64>, f64)> {
    robot.links[link].collisions.iter().flat_map(|body| cover(&body.geometry, &body.X_LC)).collect()
}

/// Spheres whose union has the body's surface: swept spheres exactly, flat faces by points of radius 0 on them.
fn cover(geometry: &Geometry, X_LC: &Isometry3<f64>) -> Vec<(Point3<f64>, f64)> {
    let on_line = |length: f64, radius: f64| {
        let steps = libm::ceil(length / SPHERE_SPACING_M).max(1.0) as usize;
        (0..=steps)
            .map(|k| (X_LC * Point3::new(0.0, 0.0, length * (k as f64 / steps as f64 - 0.5)), radius))
            .collect::<Vec<_>>()
    };
    match geometry {
        Geometry::Sphere { radius_m } => vec![(X_LC * Point3::origin(), *radius_m)],
        Geometry::Capsule { radius_m, length_m } => on_line(*length_m, *radius_m),
        Geometry::Cylinder { radius_m, length_m } => {
            let around = libm::ceil(std::f64::consts::TAU * radius_m / SPHERE_SPACING_M).max(8.0) as usize;
            let mut points = Vec::new();
            for k in 0..around {
                let (sin, cos) = math::sin_cos(std::f64::consts::TAU * k as f64 / around as f64);
                let rim = Vector3::new(radius_m * cos, radius_m * sin, 0.0);
                points.extend(on_line(*length_m, 0.0).iter().map(|(p, r)| (p + X_LC.rotation * rim, *r)));
            }
            points
        }
        Geometry::Box { size_m } => {
            let steps = size_m.map(|s| libm::ceil(s / SPHERE_SPACING_M).max(1.0) as i64);
            let mut points = Vec::new();
            for i in 0..=steps.x {
                for j in 0..=steps.y {
                    for k in 0..=steps.z {
                        let on_face = i == 0 || i == steps.x || j == 0 || j == steps.y || k == 0 || k == steps.z;
                        if on_face {
                            let u = |n: i64, of: i64, size: f64| size * (n as f64 / of as f64 - 0.5);
                            let p =
                                Point3::new(u(i, steps.x, size_m.x), u(j, steps.y, size_m.y), u(k, steps.z, size_m.z));
                            points.push((X_LC * p, 0.0));
                        }
                    }
                }
            }
            points
        }
        Geometry::Mesh { mesh, .. } => mesh.positions.iter().map(|p| (X_LC * p, 0.0)).collect(),
    }
}
