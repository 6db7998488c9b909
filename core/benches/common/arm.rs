//! The arm and the obstacles of the workloads.

use std::error::Error;
use std::path::Path;

use endcomfort_core::collision::World;
use endcomfort_core::robot::{Arm, CollisionBody, Geometry, Hand, Robot, read_urdf};
use nalgebra::{Isometry3, Vector3};
use serde::Deserialize;

/// A file of a workload.
#[derive(Deserialize)]
pub(crate) struct Work {
    pub(crate) tuck: Vec<f64>,
    pub(crate) goals: Vec<Vec<f64>>,
    boxes_centre_half: Vec<[f64; 6]>,
    cylinders_centre_r_halfheight: Vec<[f64; 5]>,
}

/// The arm of the workload, each of its segments (a cylinder and two balls in the file) as the one capsule that it is.
pub(crate) fn robot(folder: &Path) -> Result<Robot, Box<dyn Error>> {
    let mut robot = read_urdf(&std::fs::read_to_string(folder.join("srs7.urdf"))?, &|_| None)?.value;
    for link in &mut robot.links {
        link.collisions = link
            .collisions
            .iter()
            .filter_map(|body| match body.geometry {
                Geometry::Cylinder { radius_m, length_m } => {
                    Some(CollisionBody { geometry: Geometry::Capsule { radius_m, length_m }, ..body.clone() })
                }
                _ => None,
            })
            .collect();
    }
    let link = |name: &str| robot.link_index(name).ok_or_else(|| format!("srs7.urdf: no link {name:?}"));
    let [base, upper, fore, last, tcp] = [link("base")?, link("l3")?, link("l5")?, link("l7")?, link("tcp")?];
    robot.allowed_collisions = vec![(base, upper), (upper, fore), (fore, last)];
    let hand = Hand {
        name: "hand".to_owned(),
        links: vec![last, tcp],
        palm_link: last,
        tcp_link: tcp,
        fingers: Vec::new(),
        open: Vec::new(),
        closed: Vec::new(),
    };
    robot.arms = vec![Arm { name: "arm".to_owned(), dofs: (0..7).collect(), base_link: base, flange_link: last, hand }];
    Ok(robot)
}

/// The obstacles of a workload.
pub(crate) fn world(work: &Work) -> Result<World, Box<dyn Error>> {
    let mut world = World::new();
    for (index, [x, y, z, hx, hy, hz]) in work.boxes_centre_half.iter().enumerate() {
        let size = 2.0 * Vector3::new(*hx, *hy, *hz);
        world.add_box(&format!("box_{index}"), size, &Isometry3::translation(*x, *y, *z))?;
    }
    for (index, [x, y, z, radius, half]) in work.cylinders_centre_r_halfheight.iter().enumerate() {
        world.add_cylinder(&format!("can_{index}"), *radius, 2.0 * half, &Isometry3::translation(*x, *y, *z))?;
    }
    Ok(world)
}
