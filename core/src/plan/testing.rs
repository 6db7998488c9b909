//! Scenes for tests: an S-R-S arm of one capsule per segment before a shelf, a plate, in a box.

use nalgebra::{Isometry3, Unit, Vector3};

use super::space::ArmSpace;
use crate::collision::{Checker, CollisionModel, World};
use crate::robot::{Arm, CollisionBody, Geometry, Hand, Joint, JointKind, JointLimit, Link, Robot};

/// An arm in a world.
pub(crate) struct Bench {
    pub(crate) model: CollisionModel,
    pub(crate) world: World,
}

impl Bench {
    pub(crate) fn new(boxes: &[(&str, [f64; 3], [f64; 3])]) -> Self {
        let mut world = World::new();
        for (name, center, size) in boxes {
            let X_WB = Isometry3::translation(center[0], center[1], center[2]);
            world.add_box(name, Vector3::from(*size), &X_WB).unwrap();
        }
        Self { model: CollisionModel::new(&srs_arm()).unwrap(), world }
    }

    /// A cabinet of two levels, open to the front, the lower level divided.
    pub(crate) fn shelf() -> Self {
        Self::new(&[
            ("table", [0.8, 0.0, 0.025], [1.0, 1.6, 0.05]),
            ("board_right", [0.65, -0.41, 0.45], [0.4, 0.02, 0.8]),
            ("board_left", [0.65, 0.41, 0.45], [0.4, 0.02, 0.8]),
            ("board_back", [0.86, 0.0, 0.45], [0.02, 0.84, 0.8]),
            ("board_middle", [0.65, 0.0, 0.46], [0.4, 0.8, 0.02]),
            ("board_top", [0.65, 0.0, 0.84], [0.4, 0.8, 0.02]),
            ("board_divider", [0.65, 0.0, 0.25], [0.4, 0.02, 0.4]),
        ])
    }

    pub(crate) fn space(&self) -> ArmSpace {
        let checker = Checker::for_arm(&self.model, &self.world, None, &[], 0, &self.rest()).unwrap();
        ArmSpace::new(self.model.robot(), 0, checker).unwrap()
    }

    pub(crate) fn dofs(&self) -> Vec<usize> {
        (0..7).collect()
    }

    pub(crate) fn rest(&self) -> Vec<f64> {
        vec![0.0; 7]
    }
}

/// An S-R-S arm of 0.300 / 0.328 / 0.323 / 0.2024 m, one capsule per segment, standing at the origin.
fn srs_arm() -> Robot {
    let chain = [(0.0, 2.967), (0.3, 2.147), (0.0, 2.967), (0.328, 2.147), (0.0, 2.967), (0.323, 2.147), (0.0, 2.967)];
    let bodies =
        [Some((0.07, 0.3)), None, None, Some((0.06, 0.328)), None, Some((0.05, 0.323)), None, Some((0.045, 0.2024))];
    let link = |index: usize, body: &Option<(f64, f64)>| Link {
        name: if index == 0 { "base".to_owned() } else { format!("l{index}") },
        visuals: Vec::new(),
        collisions: body
            .iter()
            .map(|&(radius_m, length_m)| CollisionBody {
                X_LC: Isometry3::translation(0.0, 0.0, 0.5 * length_m),
                geometry: Geometry::Capsule { radius_m, length_m },
            })
            .collect(),
    };
    let joint = |index: usize, &(z, bound): &(f64, f64)| Joint {
        name: format!("j{}", index + 1),
        kind: JointKind::Revolute,
        parent: index,
        child: index + 1,
        X_PJ: Isometry3::translation(0.0, 0.0, z),
        axis: Unit::new_unchecked(if index.is_multiple_of(2) { Vector3::z() } else { Vector3::y() }),
        limit: JointLimit {
            lower: -bound,
            upper: bound,
            velocity: 1.0 + 0.1 * index as f64,
            acceleration: 1.5,
            jerk: 15.0,
        },
        mimic: None,
        dof: Some(index),
    };
    let hand = Hand {
        name: "hand".to_owned(),
        links: vec![7],
        palm_link: 7,
        tcp_link: 7,
        fingers: Vec::new(),
        open: Vec::new(),
        closed: Vec::new(),
    };
    Robot {
        name: "srs".to_owned(),
        links: bodies.iter().enumerate().map(|(index, body)| link(index, body)).collect(),
        joints: chain.iter().enumerate().map(|(index, step)| joint(index, step)).collect(),
        dof_joints: (0..7).collect(),
        arms: vec![Arm { name: "arm".to_owned(), dofs: (0..7).collect(), base_link: 0, flange_link: 7, hand }],
        postures: Vec::new(),
        allowed_collisions: vec![(0, 3), (3, 5), (5, 7)],
    }
}

/// Configurations with the hand in different cells of [`Bench::shelf`], found by drawing seeded ones until free.
pub(crate) fn shelf_configurations() -> Vec<Vec<f64>> {
    let bench = Bench::shelf();
    let space = bench.space();
    let mut scratch = crate::collision::Scratch::default();
    let mut rng = crate::rng::Rng::new(21, 0);
    let cells: [[f64; 2]; 6] = [[0.2, 0.25], [-0.2, 0.25], [0.2, 0.65], [-0.2, 0.65], [0.2, 0.25], [-0.2, 0.65]];
    let mut found = Vec::new();
    for [y, z] in cells {
        for _ in 0..2_000_000 {
            let q: Vec<f64> = space.lower.iter().zip(&space.upper).map(|(l, u)| rng.uniform(*l, *u)).collect();
            let X_W7 = bench.model.robot().link_poses(&q)[7];
            let tip = X_W7 * nalgebra::Point3::new(0.0, 0.0, 0.2024);
            let inside = tip.x > 0.55 && tip.x < 0.8 && (tip.y - y).abs() < 0.15 && (tip.z - z).abs() < 0.12;
            if inside && space.checker.is_free(&mut scratch, &q) {
                found.push(q);
                break;
            }
        }
    }
    assert_eq!(found.len(), cells.len(), "a cell that cannot be reached tests nothing");
    found
}
