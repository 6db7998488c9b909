//! From candidates to ranked grasps: each one situated at the start and at the goal.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};

use super::goal::{SOFT_POSES, stops};
use super::situate::situate_all;
use crate::collision::{ConvexHull, HandChecker, TriangleSurface, World};
use crate::fit::Fit;
use crate::grasp::{
    ContactSurface, Grasp, GraspSettings, HandHit, HandModel, Quality, RankBy, Surfels, Touched, Trials, candidates,
    rank,
};
use crate::guest::GuestRobot;
use crate::job::{FitOutput, Refusal};
use crate::library::Library;
use crate::parallel;
use crate::robot::ik::ArmIk;
use crate::scene::Scene;
use crate::superquadric::Superquadric;
use crate::task::{TARGET, Workcell, WorkcellError};
use crate::watch::Watch;

/// Resolution of the meshes whose corners make collision hulls: 32 columns, 16 rows.
const HULL_HALF: u32 = 4;
/// Edge of the cells that a cluster without a fit fills: half as wide as a finger, so that no finger fits between points
/// of one surface that the camera sees a centimetre apart.
const CELL_M: f64 = 0.01;

/// Robot, obstacles and the object of a request.
pub(crate) fn workcell(
    scene: &Scene,
    fits: &FitOutput,
    clusters: &[Vec<Point3<f64>>],
    is_dropped: bool,
    library: &Library,
) -> Result<Workcell, Refusal> {
    let robot = library.robot_of(scene).map_err(|error| refusal(&error))?;
    let arm_name = scene.arm.name();
    let arm_index = robot
        .arms
        .iter()
        .position(|arm| arm.name == arm_name)
        .ok_or_else(|| refusal(&WorkcellError::NoArm { robot: robot.name.clone(), arm: arm_name.into() }))?;
    let q_start = scene.q_start(&robot).map_err(|error| refusal(&WorkcellError::from(error)))?;
    let robot = if scene.torso { Arc::new(robot.with_torso(arm_index)) } else { robot };
    let arm = &robot.arms[arm_index];
    let build = || -> Result<_, WorkcellError> {
        let ik = ArmIk::of(&robot, arm)?;
        let model = crate::collision::CollisionModel::new(&robot)?;
        Ok((ik, model, obstacles(scene, fits, clusters, is_dropped)?))
    };
    let (ik, model, mut world) = build().map_err(|error| refusal(&error))?;
    super::handover::add_surroundings(&mut world, scene)?;
    let Some(Ok(target)) = fits.fits.get(fits.target) else {
        return Err(no_fit());
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
        // The goal of a handover is the receiver's.
        stops: if scene.handover.is_some() { Vec::new() } else { stops(scene, target, is_dropped, SOFT_POSES) },
        may_touch: Vec::new(),
        robot,
    })
}

/// The wanted pose of the object at the end of the task.
pub(super) fn X_WO_goal(scene: &Scene, fits: &FitOutput, is_dropped: bool) -> Option<Isometry3<f64>> {
    let target = fits.fits.get(fits.target)?.as_ref().ok()?;
    stops(scene, target, is_dropped, SOFT_POSES).last()?.poses_WO.first().copied()
}

/// There is nothing to grasp.
pub(super) fn no_fit() -> Refusal {
    Refusal::new("the object to grasp has no fit")
}

pub(super) fn refusal(error: &dyn std::error::Error) -> Refusal {
    Refusal::new(error.to_string())
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
pub(super) fn obstacles(
    scene: &Scene,
    fits: &FitOutput,
    clusters: &[Vec<Point3<f64>>],
    is_dropped: bool,
) -> Result<World, WorkcellError> {
    let mut world = furniture(scene, is_dropped)?;
    for (index, fit) in fits.fits.iter().enumerate().filter(|(index, _)| *index != fits.target) {
        match fit {
            Ok(fit) => {
                let name = neighbour_name(scene, &fit.superquadric.X_FS, index, is_dropped);
                add_fit(&mut world, &name, fit)?;
            }
            // Its hull would close what is hollow or between two things; its cells do not.
            Err(_) => {
                world.add_cloud(&format!("cluster {index}"), &clusters[index], CELL_M)?;
            }
        }
    }
    Ok(world)
}

/// The table, and the known boxes unless the cloud was dropped.
pub(super) fn furniture(scene: &Scene, is_dropped: bool) -> Result<World, WorkcellError> {
    let mut world = World::new();
    world.add_table(&scene.table)?;
    if !is_dropped {
        for obstacle in &scene.obstacles {
            world.add_obstacle(obstacle)?;
        }
    }
    Ok(world)
}

/// Adds the bodies of a fit where it stands.
pub(super) fn add_fit(world: &mut World, name: &str, fit: &Fit) -> Result<(), WorkcellError> {
    for piece_O in bodies_in_object(fit).iter().flat_map(pieces) {
        world.add_points(name, &piece_O, &fit.superquadric.X_FS)?;
    }
    Ok(())
}

/// The described object that stands there, or the number of the cluster.
fn neighbour_name(scene: &Scene, X_WS: &Isometry3<f64>, index: usize, is_dropped: bool) -> String {
    let described = scene.object_at(X_WS).filter(|_| !is_dropped);
    described
        .map_or_else(|| format!("cluster {index}"), |placed| GuestRobot::title_of(&placed.object).replace('_', " "))
}

/// What fingers close on, as the scene asks.
pub(super) fn touched(
    scene: &Scene,
    target: &Fit,
    points: &[Point3<f64>],
    is_dropped: bool,
    library: &Library,
) -> Result<Touched, Refusal> {
    let X_OW = target.superquadric.X_FS.inverse();
    Ok(match scene.grasp.surface {
        ContactSurface::Superquadric => Touched::Bodies,
        ContactSurface::Cloud => {
            let points_O: Vec<Point3<f64>> = points.iter().map(|p| X_OW * p).collect();
            let surfels = Surfels::new(&points_O, &Point3::origin());
            Touched::Points(surfels.ok_or_else(|| {
                Refusal::new(format!("{} points are too few to close fingers on", points.len()))
                    .with_details(vec!["Let the fingers close on the superquadric.".into()])
            })?)
        }
        ContactSurface::Mesh => {
            let described = scene.object_at(&target.superquadric.X_FS).filter(|_| !is_dropped);
            let placed = described.ok_or_else(|| {
                Refusal::new("no mesh is known of the object")
                    .with_details(vec!["Let the fingers close on the superquadric or on the cloud.".into()])
            })?;
            let object = library.object(&placed.object).map_err(|error| refusal(&error))?;
            let mesh_O = object.mesh().transformed(&(X_OW * placed.X_WO));
            Touched::Mesh(TriangleSurface::new(&placed.object, &mesh_O).map_err(|error| refusal(&error))?)
        }
    })
}

/// Candidates that the hand alone could take where the object stands.
pub(crate) fn grasp_candidates(
    cell: &Workcell,
    target: &Fit,
    touched: Touched,
    settings: &GraspSettings,
) -> Result<Vec<Grasp>, Refusal> {
    let hand_checker = |fingers: &[f64]| HandChecker::new(&cell.model, &cell.world, &[], cell.arm_index, fingers);
    let open = hand_checker(&cell.hand.open).map_err(|error| refusal(&error))?;
    let hand_hit = |X_OH: &Isometry3<f64>, fingers: &[f64]| {
        let X_WH = cell.X_WO_start * X_OH;
        let hit = if fingers == cell.hand.open {
            open.first_hit(&X_WH)
        } else {
            hand_checker(fingers).ok()?.first_hit(&X_WH)
        };
        hit.map(|hit| HandHit { link: hit.a, other: hit.b })
    };
    Ok(candidates(&cell.hand, &bodies_in_object(target), touched, settings, &cell.X_WO_start, &hand_hit))
}

/// Grasps with their IK sets at start and goal: accepted ones first, best first, then the rest in order of generation.
///
/// Qualities are filled in when the order depends on them; else [`qualities`] gives them afterwards.
pub(crate) fn ranked(
    cell: &Workcell,
    grasps: &[Grasp],
    target: &Fit,
    scene: &Scene,
    watch: Watch<'_>,
) -> Result<Vec<Grasp>, Refusal> {
    let situated = situate_all(cell, grasps, scene, &|| watch.should_stop());
    let mut judged = situated.map_err(|error| refusal(&error))?;
    if scene.rank.by == RankBy::Score {
        let qualities = qualities(cell, &judged, target, scene, watch);
        Quality::put_all(&qualities, &mut judged);
    }
    if watch.should_stop() {
        return Err(Refusal::new("stopped"));
    }
    rank(&mut judged, &scene.rank, scene.seed);
    Ok(judged)
}

/// What takes longer to tell of the accepted grasps: how often they hold, and the volume of their wrench space.
pub(super) fn qualities(
    cell: &Workcell,
    grasps: &[Grasp],
    target: &Fit,
    scene: &Scene,
    watch: Watch<'_>,
) -> Vec<Quality> {
    let bodies_O = bodies_in_object(target);
    let trials = Trials::new(&cell.hand, &bodies_O, &scene.grasp, scene.seed);
    let accepted: Vec<&Grasp> = grasps.iter().filter(|grasp| grasp.is_accepted()).collect();
    let found = parallel::map(&accepted, |grasp| (!watch.should_stop()).then(|| trials.quality(grasp)));
    found.into_iter().flatten().collect()
}
