//! Where an object can be put down in between, to be grasped anew.

use nalgebra::{Isometry3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::goal::settle;
use crate::collision::HandChecker;
use crate::fit::Fit;
use crate::grasp::{Grasp, GraspStatus};
use crate::job::Refusal;
use crate::parallel;
use crate::scene::Scene;
use crate::task::Workcell;

/// Faces count as flat up to this shape exponent: a superquadric of 1 is round.
const FLAT_EXPONENT: f64 = 0.6;
/// Distance between the places on the table that are looked at, metres, and how many stand in a row.
const GRID_M: f64 = 0.12;
const GRID: i32 = 3;
/// Turns about the vertical at each place.
const TURNS: u32 = 4;
/// Candidates that stand for all of them when places are compared.
const SAMPLES: usize = 60;

/// Poses of the object at rest on the table from which the most grasps lead on, best first.
///
/// The object rests on each of its flat faces at places between start and goal. A place counts as many grasps as have
/// some posture of the arm both here and at the start, or both here and at the goal, whichever is less; collisions of
/// the arm are left to the planner.
pub(super) fn between(
    cell: &Workcell,
    target: &Fit,
    grasps: &[Grasp],
    scene: &Scene,
) -> Result<Vec<Isometry3<f64>>, Refusal> {
    let Some(goal) = cell.leg().last().and_then(|stop| stop.poses_WO.first()) else { return Ok(Vec::new()) };
    let X_BW = cell.robot.link_poses(&cell.q_start)[cell.arm().base_link].inverse();
    let q_now: Vec<f64> = cell.arm().dofs.iter().map(|&dof| cell.q_start[dof]).collect();
    let reaches = |X_WO: &Isometry3<f64>, grasp: &Grasp| {
        let X_WH = X_WO * grasp.X_OH;
        let hand = HandChecker::new(&cell.model, &cell.world, &[], cell.arm_index, &grasp.closed);
        hand.is_ok_and(|hand| hand.first_hit(&X_WH).is_none()) && cell.ik.first(&(X_BW * X_WH), &q_now).is_ok()
    };
    let holding: Vec<&Grasp> = grasps.iter().filter(|grasp| holds(grasp)).collect();
    let stride = holding.len().div_ceil(SAMPLES).max(1);
    let sample: Vec<&Grasp> = holding.into_iter().step_by(stride).collect();
    let ends: Vec<(bool, bool)> =
        parallel::map(&sample, |grasp| (reaches(&cell.X_WO_start, grasp), reaches(goal, grasp)));
    let poses = rests(cell, target, goal, scene);
    let counted = parallel::map(&poses, |X_WO| {
        let here = sample.iter().zip(&ends).filter(|(grasp, ends)| (ends.0 || ends.1) && reaches(X_WO, grasp));
        let (from, on) =
            here.fold((0, 0), |(from, on), (_, ends)| (from + usize::from(ends.0), on + usize::from(ends.1)));
        from.min(on)
    });
    let mut order: Vec<usize> = (0..poses.len()).filter(|&index| counted[index] > 0).collect();
    order.sort_by_key(|&index| (std::cmp::Reverse(counted[index]), index));
    Ok(order.into_iter().map(|index| poses[index]).collect())
}

/// Whether the closed hand holds the object, wherever that is.
fn holds(grasp: &Grasp) -> bool {
    !matches!(
        grasp.status,
        GraspStatus::TooWide { .. }
            | GraspStatus::HandInObject { .. }
            | GraspStatus::TooFewContacts { .. }
            | GraspStatus::OneSided { .. }
            | GraspStatus::Unwanted { .. }
    )
}

/// Poses at rest on each flat face of the object, free of everything, around the middle between start and goal.
fn rests(cell: &Workcell, target: &Fit, goal: &Isometry3<f64>, scene: &Scene) -> Vec<Isometry3<f64>> {
    let [e1, e2] = [target.superquadric.e1, target.superquadric.e2];
    let mut down_O = Vec::new();
    if e1 <= FLAT_EXPONENT {
        down_O.extend([-Vector3::z(), Vector3::z()]);
        if e2 <= FLAT_EXPONENT {
            down_O.extend([-Vector3::x(), Vector3::x(), -Vector3::y(), Vector3::y()]);
        }
    }
    let middle = 0.5 * (cell.X_WO_start.translation.vector + goal.translation.vector);
    let steps = (-(GRID / 2)..=GRID / 2).map(|k| f64::from(k) * GRID_M);
    let mut poses = Vec::new();
    for x in steps.clone() {
        for y in steps.clone() {
            for down in &down_O {
                for turn in 0..TURNS {
                    let yaw = f64::from(turn) * std::f64::consts::TAU / f64::from(TURNS);
                    let lying = laid(down);
                    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw) * lying;
                    let place = Translation3::new(middle.x + x, middle.y + y, scene.table.height_m + 0.5);
                    poses.push(settle(scene, target, &Isometry3::from_parts(place, rotation)));
                }
            }
        }
    }
    poses.retain(|X_WO| on_table(scene, X_WO) && cell.object_hits(X_WO).is_none());
    poses
}

/// The smallest turn that brings a direction of the object down.
fn laid(down_O: &Vector3<f64>) -> UnitQuaternion<f64> {
    let smallest = Rotation3::rotation_between(down_O, &-Vector3::z());
    // Opposite directions have no smallest turn: any horizontal axis does.
    let half_turn = || Rotation3::from_axis_angle(&Unit::new_unchecked(Vector3::x()), std::f64::consts::PI);
    UnitQuaternion::from_rotation_matrix(&smallest.unwrap_or_else(half_turn))
}

fn on_table(scene: &Scene, X_WO: &Isometry3<f64>) -> bool {
    let table = &scene.table;
    let p = [X_WO.translation.x, X_WO.translation.y];
    (0..2).all(|axis| (p[axis] - table.center_m[axis]).abs() < 0.5 * table.size_m[axis] - 0.05)
}
