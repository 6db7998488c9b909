//! A posture to start from: the hands over the near part of the table, touching nothing.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::body::rest;
use crate::collision::{Checker, CollisionModel, Scratch, World};
use crate::robot::Robot;
use crate::robot::ik::ArmIk;
use crate::scene::TableTop;

/// Places of a hand: metres behind the table's edge, and above its top; the first that can be taken is.
const PLACES_M: [[f64; 2]; 6] = [[0.10, 0.40], [0.05, 0.30], [0.15, 0.30], [0.0, 0.45], [0.20, 0.25], [-0.05, 0.60]];
/// How far to its side the hand of one arm of two is, metres.
const ASIDE_M: f64 = 0.24;
/// Directions of the approach: down, forward and down, forward (forward, down).
const APPROACHES: [[f64; 2]; 3] = [[0.0, 1.0], [0.707, 0.707], [1.0, 0.0]];
/// Starts or arm angles of the inverse kinematics.
const STARTS: usize = 12;

/// Joints of the whole robot with each arm over the table; `None` when no arm finds such a posture, and the names of
/// those that do not.
pub(super) fn over_table(robot: &Robot, table: &TableTop) -> (Option<Vec<f64>>, Vec<String>) {
    let mut q = rest(robot);
    for arm in &robot.arms {
        let open = arm.hand.fingers.iter().flatten().zip(&arm.hand.open);
        open.for_each(|(&dof, &position)| q[dof] = position);
    }
    let mut world = World::new();
    let names = || robot.arms.iter().map(|arm| arm.name.clone()).collect::<Vec<_>>();
    let (Ok(model), Ok(())) = (CollisionModel::new(robot), world.add_table(table)) else { return (None, names()) };
    let edge = table.center_m[0] - 0.5 * table.size_m[0];
    let mut lost = Vec::new();
    for (index, arm) in robot.arms.iter().enumerate() {
        let Ok(ik) = ArmIk::of(robot, arm) else {
            lost.push(arm.name.clone());
            continue;
        };
        let Ok(checker) = Checker::for_arm(&model, &world, None, &[], index, &q) else {
            lost.push(arm.name.clone());
            continue;
        };
        let X_BW = robot.link_poses(&q)[arm.base_link].inverse();
        let y = match (robot.arms.len(), arm.name.as_str()) {
            (1, _) => 0.0,
            (_, "left") => ASIDE_M,
            _ => -ASIDE_M,
        };
        let places = APPROACHES.iter().flat_map(|approach| PLACES_M.iter().map(move |place| (approach, place)));
        let poses = places.flat_map(|([forward, down], [x, z])| {
            let p = Vector3::new(edge + x, table.center_m[1] + y, table.height_m + z);
            let approach = Vector3::new(*forward, 0.0, -down);
            [Vector3::y(), -Vector3::y()].into_iter().filter_map(move |closing| pose(&p, &closing, &approach))
        });
        let q_now: Vec<f64> = arm.dofs.iter().map(|&dof| q[dof]).collect();
        let mut scratch = Scratch::default();
        let mut best: Option<(f64, Vec<f64>)> = None;
        for X_WH in poses {
            for found in ik.set(&(X_BW * X_WH), &q_now, STARTS).iter() {
                if !checker.is_free(&mut scratch, found) {
                    continue;
                }
                let mut all = q.clone();
                arm.dofs.iter().zip(found).for_each(|(&dof, &position)| all[dof] = position);
                let m = robot.manipulability(arm, &robot.link_poses(&all));
                if best.as_ref().is_none_or(|(most, _)| m > *most) {
                    best = Some((m, found.to_vec()));
                }
            }
            if best.is_some() {
                break;
            }
        }
        match best {
            Some((_, found)) => arm.dofs.iter().zip(&found).for_each(|(&dof, &position)| q[dof] = position),
            None => lost.push(arm.name.clone()),
        }
    }
    ((lost.len() < robot.arms.len()).then_some(q), lost)
}

/// The pose of a hand by its place, its closing direction and its approach.
fn pose(p: &Vector3<f64>, closing: &Vector3<f64>, approach: &Vector3<f64>) -> Option<Isometry3<f64>> {
    let (x, z) = (Unit::try_new(*closing, 1e-9)?, Unit::try_new(*approach, 1e-9)?);
    let R = Matrix3::from_columns(&[x.into_inner(), z.cross(&x), z.into_inner()]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R));
    Some(Isometry3::from_parts(Translation3::from(*p), rotation))
}
