//! Where a robot that nobody placed stands: behind the table, high enough to work on it.

use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::body::{link_points, rest};
use crate::robot::{Chain, Placement, Robot};
use crate::scene::TableTop;

/// Share of an arm's length at which it works best: neither folded nor stretched.
const WORKING_SHARE: f64 = 0.6;
/// Nearest that a shoulder comes to what it works on, as a share of the arm's length.
const NEAREST_SHARE: f64 = 0.25;
/// Where objects stand, metres behind the edge of the table, and how high a hand works above it.
const WORK_DEPTH_M: f64 = 0.22;
const WORK_HEIGHT_M: f64 = 0.12;
/// Room between the robot's base and the table, metres.
const GAP_M: f64 = 0.03;
/// Shoulders that are at most this far below the table's top still work on it, metres.
const LOW_SHOULDER_M: f64 = 0.10;
/// A robot this far above the floor is given something to stand on, metres.
const AFLOAT_M: f64 = 0.02;
/// A column is at least this thick, metres.
const LEAST_COLUMN_M: f64 = 0.12;

/// The pose of a robot's root in the world: x towards the table, y to the left.
///
/// One whose shoulders are above the table stands on the floor; any other stands as high as the table. The middle of
/// the shoulders is so far behind the objects that an arm reaches them half stretched, and nothing of the base is over
/// the table.
///
/// * `chains`: base and tip link of each arm.
pub(super) fn behind_table(robot: &Robot, chains: &[(usize, usize)], table: &TableTop) -> Placement {
    let X_RL = robot.link_poses(&rest(robot));
    let mut shoulder = Vector3::zeros();
    let mut reach_m = 0.0_f64;
    for &(base, tip) in chains {
        shoulder += X_RL[base].translation.vector / chains.len() as f64;
        reach_m = reach_m.max(Chain::between(robot, base, tip).map_or(0.0, |chain| chain.reach_m()));
    }
    let lowest = -robot.standing_height_m(&rest(robot));
    let has_high_shoulders = shoulder.z - lowest >= table.height_m - LOW_SHOULDER_M;
    let z = if has_high_shoulders { -lowest } else { table.height_m - lowest };
    let edge = table.center_m[0] - 0.5 * table.size_m[0];
    let rise = z + shoulder.z - (table.height_m + WORK_HEIGHT_M);
    let wanted = WORKING_SHARE * reach_m;
    let away = (wanted * wanted - rise * rise).max(0.0).sqrt().max(NEAREST_SHARE * reach_m);
    let front = base_points(robot, &X_RL).iter().map(|p| p.x).fold(shoulder.x, f64::max);
    let x = (edge + WORK_DEPTH_M - away - shoulder.x).min(edge - GAP_M - front);
    Placement { xyz: [x, table.center_m[1] - shoulder.y, z].map(millimetres), rpy: [0.0; 3] }
}

/// A number that a person can read.
fn millimetres(x: f64) -> f64 {
    (1e3 * x).round() / 1e3
}

/// The column under a robot that hangs in the air: its size and the pose of its centre in the world.
pub(super) fn column(robot: &Robot, X_WR: &Isometry3<f64>) -> Option<(Vector3<f64>, Isometry3<f64>)> {
    let q = rest(robot);
    let X_RL = robot.link_poses(&q);
    let base: Vec<Point3<f64>> = base_points(robot, &X_RL).iter().map(|p| X_WR * p).collect();
    let lowest = base.iter().map(|p| p.z).fold(f64::INFINITY, f64::min).min(X_WR.translation.z);
    if lowest < AFLOAT_M {
        return None;
    }
    let root = X_WR.translation.vector;
    let (least, most) = base.iter().fold((root, root), |(least, most), p| (least.inf(&p.coords), most.sup(&p.coords)));
    let edge = |axis: usize| (most[axis] - least[axis]).max(LEAST_COLUMN_M);
    let middle = 0.5 * (least + most);
    let size_m = Vector3::new(edge(0), edge(1), lowest);
    Some((size_m, Isometry3::from_parts(Translation3::new(middle.x, middle.y, 0.5 * lowest), nalgebra::one())))
}

/// Points of everything that no joint moves, in the root's frame.
fn base_points(robot: &Robot, X_RL: &[Isometry3<f64>]) -> Vec<Point3<f64>> {
    let still = (0..robot.links.len()).filter(|&link| robot.body_root(link) == 0);
    still.flat_map(|link| link_points(&robot.links[link]).into_iter().map(move |p| X_RL[link] * p)).collect()
}
