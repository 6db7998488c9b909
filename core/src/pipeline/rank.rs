//! From candidates to ranked grasps: each one situated at the start and at the goal.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};

use crate::collision::{CollisionError, ConvexHull, HandChecker, Scratch, World};
use crate::fit::Fit;
use crate::grasp::{
    Grasp, GraspSettings, GraspStatus, HandHit, HandModel, Obstruction, Reach, Situated, candidates, rank,
};
use crate::job::{FitOutput, Refusal};
use crate::library::Library;
use crate::parallel;
use crate::robot::ik::ArmIk;
use crate::scene::Scene;
use crate::superquadric::Superquadric;
use crate::task::{Situation, TARGET, Workcell, WorkcellError};
use crate::watch::Watch;

/// Resolution of the meshes whose corners make collision hulls: 32 columns, 16 rows.
const HULL_HALF: u32 = 4;

/// Robot, obstacles and the object of a request.
pub(super) fn workcell(
    scene: &Scene,
    fits: &FitOutput,
    clusters: &[Vec<Point3<f64>>],
    is_dropped: bool,
    library: &Library,
) -> Result<Workcell, Refusal> {
    let robot = library.robot(&scene.robot).map_err(|error| refusal(&error))?;
    let arm_name = scene.arm.name();
    let arm_index = robot
        .arms
        .iter()
        .position(|arm| arm.name == arm_name)
        .ok_or_else(|| refusal(&WorkcellError::NoArm { robot: robot.name.clone(), arm: arm_name.into() }))?;
    let q_start = robot
        .posture(&scene.posture)
        .ok_or_else(|| {
            refusal(&WorkcellError::NoPosture { robot: robot.name.clone(), posture: scene.posture.clone() })
        })?
        .to_vec();
    let robot = if scene.torso { Arc::new(robot.with_torso(arm_index)) } else { robot };
    let arm = &robot.arms[arm_index];
    let build = || -> Result<_, WorkcellError> {
        let ik = ArmIk::of(&robot, arm)?;
        let model = crate::collision::CollisionModel::new(&robot)?;
        Ok((ik, model, obstacles(scene, fits, clusters, is_dropped)?))
    };
    let (ik, model, world) = build().map_err(|error| refusal(&error))?;
    let Some(Ok(target)) = fits.fits.get(fits.target) else {
        return Err(Refusal { message: "the object to grasp has no fit".into(), details: Vec::new() });
    };
    let hand = HandModel::new(&robot, arm);
    let bodies_O = bodies_in_object(target);
    let hulls = bodies_O.iter().flat_map(pieces).map(|piece_O| ConvexHull::new(TARGET, &piece_O));
    let target_O = hulls.collect::<Result<_, _>>().map_err(|error| refusal(&error))?;
    Ok(Workcell {
        model,
        arm_index,
        ik,
        hand,
        q_start,
        world,
        target_O,
        X_WO_start: target.superquadric.X_FS,
        X_WO_goal: super::goal::goal_pose(scene, target, is_dropped),
        robot,
    })
}

fn refusal(error: &dyn std::error::Error) -> Refusal {
    Refusal { message: error.to_string(), details: Vec::new() }
}

/// The bodies of a fit in its object frame O: the axes of its main superquadric.
fn bodies_in_object(fit: &Fit) -> Vec<Superquadric> {
    let X_OW = fit.superquadric.X_FS.inverse();
    let main = Superquadric { X_FS: Isometry3::identity(), ..fit.superquadric };
    std::iter::once(main).chain(fit.others.iter().map(|part| part.superquadric.transformed(&X_OW))).collect()
}

/// Corners of the convex pieces of a body, in the frame that it stands in.
fn pieces(body: &Superquadric) -> Vec<Vec<Point3<f64>>> {
    let mut pieces = body.convex_pieces_in_axes(HULL_HALF);
    pieces.iter_mut().flatten().for_each(|p| *p = body.X_FS * *p);
    pieces
}

/// Table, known boxes and the other clusters, by their fits or, without one, by their points.
fn obstacles(
    scene: &Scene,
    fits: &FitOutput,
    clusters: &[Vec<Point3<f64>>],
    is_dropped: bool,
) -> Result<World, WorkcellError> {
    let mut world = World::new();
    world.add_table(&scene.table)?;
    if !is_dropped {
        for obstacle in &scene.obstacles {
            world.add_obstacle(obstacle)?;
        }
    }
    for (index, fit) in fits.fits.iter().enumerate().filter(|(index, _)| *index != fits.target) {
        match fit {
            Ok(fit) => {
                let X_WO = &fit.superquadric.X_FS;
                let name = neighbour_name(scene, X_WO, index, is_dropped);
                for piece_O in bodies_in_object(fit).iter().flat_map(pieces) {
                    world.add_points(&name, &piece_O, X_WO)?;
                }
            }
            // Points that span no volume cannot be fitted either: there is nothing to hit.
            Err(_) => {
                let _ = world.add_points(&format!("cluster {index}"), &clusters[index], &Isometry3::identity());
            }
        }
    }
    Ok(world)
}

/// The described object that stands there, or the number of the cluster.
fn neighbour_name(scene: &Scene, X_WS: &Isometry3<f64>, index: usize, is_dropped: bool) -> String {
    let described = scene.object_at(X_WS).filter(|_| !is_dropped);
    described.map_or_else(|| format!("cluster {index}"), |placed| placed.object.replace('_', " "))
}

/// Candidates that the hand alone could take where the object stands.
pub(super) fn grasp_candidates(cell: &Workcell, target: &Fit, settings: &GraspSettings) -> Result<Vec<Grasp>, Refusal> {
    let hand_checker = |fingers: &[f64]| HandChecker::new(&cell.model, &cell.world, &[], cell.arm_index, fingers);
    let open = hand_checker(&cell.hand.open).map_err(|error| refusal(&error))?;
    Ok(candidates(&cell.hand, &bodies_in_object(target), settings, &|X_OH, fingers| {
        let X_WH = cell.X_WO_start * X_OH;
        let hit = if fingers == cell.hand.open {
            open.first_hit(&X_WH)
        } else {
            hand_checker(fingers).ok()?.first_hit(&X_WH)
        };
        hit.map(|hit| HandHit { link: hit.a, other: hit.b })
    }))
}

/// Grasps with their IK sets at start and goal: accepted ones first, best first, then the rest in order of generation.
pub(super) fn ranked(
    cell: &Workcell,
    grasps: &[Grasp],
    scene: &Scene,
    watch: Watch<'_>,
) -> Result<Vec<Grasp>, Refusal> {
    let goal_supports: Option<Vec<String>> = cell.X_WO_goal.map(|X_WO_goal| cell.supports(&X_WO_goal));
    let mut judged = parallel::map(grasps, |grasp| {
        let mut grasp = grasp.clone();
        if grasp.is_accepted() && !watch.should_stop() {
            situate(cell, &mut grasp, goal_supports.as_deref(), scene.rank.arm_angles);
        }
        grasp
    });
    if watch.should_stop() {
        return Err(Refusal { message: "stopped".into(), details: Vec::new() });
    }
    rank(&mut judged, &scene.rank, scene.seed);
    Ok(judged)
}

fn situate(cell: &Workcell, grasp: &mut Grasp, goal_supports: Option<&[String]>, arm_angles: usize) {
    let q_rest = cell.q_with_fingers(&grasp.closed);
    let reach = Reach { robot: &cell.robot, arm: cell.arm(), ik: &cell.ik, q_rest: &q_rest, arm_angles };
    let at = |X_WO: &Isometry3<f64>, situation: Result<Situation, CollisionError>| -> Situated {
        let checker = match situation.and_then(|situation| cell.checker(&situation)) {
            Ok(checker) => checker,
            Err(error) => {
                let reason = Obstruction::Invalid { reason: error.to_string() };
                return Situated { rejected: vec![(reason, 1)], ..Situated::default() };
            }
        };
        let mut scratch = Scratch::default();
        reach.situate(&(X_WO * grasp.X_OH), |q| checker.first_hit(&mut scratch, q).map(Obstruction::from))
    };
    let start = at(&cell.X_WO_start, cell.grasping(&cell.X_WO_start, &grasp.closed));
    let goal = match (start.ik_count > 0, cell.X_WO_goal, goal_supports) {
        (true, Some(X_WO_goal), Some(supports)) => Some(at(&X_WO_goal, cell.carrying(grasp, supports))),
        _ => None,
    };
    if start.ik_count == 0 {
        grasp.status = GraspStatus::NoIkAtStart { reason: start.main_reason() };
    } else if let Some(goal) = goal.as_ref().filter(|goal| goal.ik_count == 0) {
        grasp.status = GraspStatus::NoIkAtGoal { reason: goal.main_reason() };
    }
    (grasp.start, grasp.goal) = (Some(start), goal);
}
