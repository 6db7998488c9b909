//! A robot for tests, built by hand: two LWA4D-like S-R-S arms with capsules on a torso, each with a two-finger hand.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::{CarriedObject, ConvexHull, World};
use crate::rng::Rng;
use crate::robot::{Arm, CollisionBody, Geometry, Hand, Joint, JointKind, JointLimit, Link, Robot};
use crate::scene::TableTop;

struct Builder {
    links: Vec<Link>,
    joints: Vec<Joint>,
    dof_joints: Vec<usize>,
}

impl Builder {
    /// Adds a link under `parent`; returns its index.
    fn link(
        &mut self,
        parent: usize,
        name: &str,
        kind: JointKind,
        X_PJ: Isometry3<f64>,
        axis: Vector3<f64>,
        limit: JointLimit,
    ) -> usize {
        let child = self.links.len();
        let dof = (kind != JointKind::Fixed).then(|| {
            self.dof_joints.push(self.joints.len());
            self.dof_joints.len() - 1
        });
        self.joints.push(Joint {
            name: format!("{name}_joint"),
            kind,
            parent,
            child,
            X_PJ,
            axis: Unit::new_unchecked(axis),
            limit,
            mimic: None,
            dof,
        });
        self.links.push(Link { name: name.to_owned(), visuals: Vec::new(), collisions: Vec::new() });
        child
    }

    fn capsule(&mut self, link: usize, a: [f64; 3], b: [f64; 3], radius_m: f64) {
        let (a, b) = (Vector3::from(a), Vector3::from(b));
        let along = b - a;
        let rotation = UnitQuaternion::rotation_between(&Vector3::z(), &along).unwrap_or_else(UnitQuaternion::identity);
        let X_LC = Isometry3::from_parts(Translation3::from(0.5 * (a + b)), rotation);
        let geometry = if along.norm() > 0.0 {
            Geometry::Capsule { radius_m, length_m: along.norm() }
        } else {
            Geometry::Sphere { radius_m }
        };
        self.links[link].collisions.push(CollisionBody { X_LC, geometry });
    }

    fn cuboid(&mut self, link: usize, center: [f64; 3], size: [f64; 3]) {
        let X_LC = Isometry3::translation(center[0], center[1], center[2]);
        self.links[link]
            .collisions
            .push(CollisionBody { X_LC, geometry: Geometry::Box { size_m: Vector3::from(size) } });
    }
}

fn limit(bound: f64, velocity: f64) -> JointLimit {
    JointLimit { lower: -bound, upper: bound, velocity, acceleration: velocity, jerk: 10.0 * velocity }
}

/// Two S-R-S arms (0.240 / 0.328 / 0.323 / 0.0824 m) at a height of 1.23 m, `left` and `right`, seven joints each,
/// one prismatic finger pair each; `q` is left arm, left fingers (2), right arm, right fingers (2).
pub(crate) fn two_arm_robot() -> Robot {
    let root = Link { name: "torso".to_owned(), visuals: Vec::new(), collisions: Vec::new() };
    let mut b = Builder { links: vec![root], joints: Vec::new(), dof_joints: Vec::new() };
    b.cuboid(0, [0.0, 0.0, 0.55], [0.25, 0.25, 1.10]);
    b.cuboid(0, [0.0, 0.0, 1.23], [0.2, 0.0635, 0.2]);
    let mut arms = Vec::new();
    let mut allowed = Vec::new();
    for (side, y, yaw) in [("left", 0.04675, 0.0), ("right", -0.04675, std::f64::consts::PI)] {
        let name = |part: &str| format!("{side}_{part}");
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_euler_angles(-FRAC_PI_2, 0.0, yaw));
        let mount = Isometry3::from_parts(Translation3::new(0.0, y, 1.23), rotation);
        let along = |z: f64| Isometry3::translation(0.0, 0.0, z);
        let (x, y_axis, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let fixed = limit(0.0, 1.0);
        let base = b.link(0, &name("base"), JointKind::Fixed, mount, z, fixed);
        b.capsule(base, [0.001, 0.006, 0.033], [0.0, -0.041, 0.240], 0.0795);
        let chain = [
            (along(0.0), -z, 3.12, 0.436),
            (along(0.240), -y_axis, 2.12, 0.436),
            (along(0.0), -z, 3.12, 0.419),
            (along(0.328), -y_axis, 2.16, 0.419),
            (along(0.0), -z, 3.12, 0.436),
            (along(0.323), y_axis, 2.07, 1.257),
            (along(0.0), z, 2.94, 1.257),
        ];
        let mut links = vec![base];
        for (index, (X_PJ, axis, bound, velocity)) in chain.into_iter().enumerate() {
            let parent = links[index];
            let link = name(&format!("arm_link_{}", index + 1));
            links.push(b.link(parent, &link, JointKind::Revolute, X_PJ, axis, limit(bound, velocity)));
        }
        b.capsule(links[2], [0.0, 0.016, 0.0], [-0.001, 0.001, 0.036], 0.0972);
        b.capsule(links[3], [0.0, 0.004, 0.163], [0.0, -0.038, 0.328], 0.0664);
        b.capsule(links[4], [0.0, 0.011, 0.0], [-0.003, 0.002, 0.035], 0.0860);
        b.capsule(links[5], [0.0, 0.002, 0.152], [0.0, -0.028, 0.324], 0.0582);
        b.capsule(links[6], [0.0; 3], [0.0; 3], 0.0577);
        b.capsule(links[7], [0.0, 0.0, 0.0525], [0.0, 0.0, 0.0525], 0.0437);
        let flange = b.link(links[7], &name("flange"), JointKind::Fixed, along(0.0824), z, fixed);
        let palm = b.link(flange, &name("palm"), JointKind::Fixed, along(0.0672), z, fixed);
        b.cuboid(palm, [0.0, 0.0, 0.04], [0.14, 0.06, 0.08]);
        let stroke = JointLimit { lower: 0.0, upper: 0.05, velocity: 0.1, acceleration: 0.1, jerk: 1.0 };
        let mut fingers = Vec::new();
        for (finger, sign) in [("finger_1", 1.0), ("finger_2", -1.0)] {
            let X_PJ = Isometry3::translation(sign * 0.058, 0.0, 0.08);
            let link = b.link(palm, &name(finger), JointKind::Prismatic, X_PJ, x * -sign, stroke);
            b.cuboid(link, [0.0, 0.0, 0.055], [0.015, 0.02, 0.11]);
            fingers.push(link);
        }
        let tcp = b.link(palm, &name("tcp"), JointKind::Fixed, along(0.17), z, fixed);
        let dof = |link: usize| b.joints[link - 1].dof.unwrap();
        let palm_side = [flange, palm];
        for pair in links.windows(2) {
            allowed.push((pair[0], pair[1]));
        }
        // Link 1 carries no body; its neighbours and the links of the wrist overlap by construction.
        allowed.extend([(0, base), (0, links[2]), (base, links[2]), (links[5], links[7])]);
        allowed.extend(palm_side.iter().map(|&link| (links[6], link)));
        allowed.extend(fingers.iter().map(|&finger| (palm, finger)));
        allowed.push((fingers[0], fingers[1]));
        arms.push(Arm {
            name: side.to_owned(),
            dofs: links[1..].iter().map(|&link| dof(link)).collect(),
            base_link: base,
            flange_link: flange,
            hand: Hand {
                name: name("hand"),
                links: vec![palm, fingers[0], fingers[1]],
                palm_link: palm,
                tcp_link: tcp,
                fingers: fingers.iter().map(|&finger| vec![dof(finger)]).collect(),
                open: vec![0.0; 2],
                closed: vec![0.05; 2],
            },
        });
    }
    allowed.sort_unstable();
    allowed.dedup();
    let count = b.dof_joints.len();
    Robot {
        name: "two_arms".to_owned(),
        links: b.links,
        joints: b.joints,
        dof_joints: b.dof_joints,
        arms,
        postures: vec![("zero".to_owned(), vec![0.0; count])],
        allowed_collisions: allowed,
    }
}

/// A seeded configuration inside the limits of all joints.
pub(crate) fn random_q(robot: &Robot, rng: &mut Rng) -> Vec<f64> {
    let limits = robot.dof_joints.iter().map(|&joint| robot.joints[joint].limit);
    limits.map(|limit| rng.uniform(limit.lower, limit.upper)).collect()
}

/// A table with eight things on it: boxes, cylinders and hulls.
pub(crate) fn scene() -> World {
    let mut world = World::new();
    let top = TableTop { center_m: [0.6, 0.0], size_m: [0.75, 1.5], height_m: 0.69, thickness_m: 0.04 };
    world.add_table(&top).unwrap();
    let mut rng = Rng::new(3, 0);
    for k in 0..7_u32 {
        let place = Translation3::new(rng.uniform(0.3, 0.9), rng.uniform(-0.6, 0.6), 0.8);
        let X_WB = Isometry3::from_parts(place, rng.rotation());
        match k % 3 {
            0 => world.add_box(&format!("box_{k}"), Vector3::new(0.1, 0.2, 0.15), &X_WB).unwrap(),
            1 => world.add_cylinder(&format!("can_{k}"), 0.05, 0.2, &X_WB).unwrap(),
            _ => {
                let points: Vec<_> = (0..60).map(|_| Point3::from(rng.direction() * 0.09)).collect();
                world.add_points(&format!("pear_{k}"), &points, &X_WB).unwrap();
            }
        }
    }
    world
}

/// A brick with a rod through it: two convex pieces.
pub(crate) fn brick(robot: &Robot, arm: usize) -> CarriedObject {
    let cuboid = |x: f64, y: f64, z: f64| -> Vec<_> {
        (0..8)
            .map(|k| Vector3::new(f64::from(k & 1) - 0.5, f64::from(k >> 1 & 1) - 0.5, f64::from(k >> 2) - 0.5))
            .map(|corner| Point3::from(corner.component_mul(&Vector3::new(x, y, z))))
            .collect()
    };
    let pieces = [cuboid(0.1, 0.1, 0.1), cuboid(0.3, 0.01, 0.02)];
    let pieces = pieces.map(|piece| ConvexHull::new("brick", &piece).unwrap());
    CarriedObject::new("brick", &pieces, &Isometry3::translation(0.0, 0.0, 0.05), robot, arm).unwrap()
}
