//! From a scene or a dropped file to the cloud that the robot sees, its segments and their fits.

use nalgebra::{Point3, Vector3};

use super::lab::signed_distances;
use crate::cloud::{PointCloud, RgbdCamera, read_cloud};
use crate::fit::{Fit, FitInput, FitSettings, fit};
use crate::job::{DroppedCloud, FitOutput, Refusal, SceneOutput, SegmentOutput};
use crate::library::Library;
use crate::object::view_scene;
use crate::parallel;
use crate::scene::Scene;
use crate::segment::{TableSpot, segment, table_to_robot};
use crate::watch::Watch;

/// Points this close to a known obstacle belong to it, metres: camera noise and the tilt of its faces.
const OBSTACLE_MARGIN_M: f64 = 0.012;
/// Where the centre of a dropped cloud's largest cluster is put on the robot's table, metres from the torso axis.
const DROPPED_AT_M: [f64; 2] = [0.52, 0.24];

/// The cloud that the scene's camera sees, in W.
///
/// # Errors
/// A [`Refusal`] when the scene names an object that does not exist.
pub fn synthetic_cloud(scene: &Scene, library: &Library) -> Result<PointCloud, Refusal> {
    let objects = scene
        .objects
        .iter()
        .map(|placed| library.object(&placed.object).map(|object| object.as_ref().clone()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| Refusal::new(error.to_string()))?;
    let view = view_scene(scene, &objects, &RgbdCamera::default()).map_err(|error| Refusal::new(error.to_string()))?;
    Ok(view.cloud)
}

/// The cloud of a request, in W.
pub(super) fn scene_output(
    scene: &Scene,
    dropped: Option<&DroppedCloud>,
    library: &Library,
    watch: Watch<'_>,
) -> Result<SceneOutput, Refusal> {
    let Some(file) = dropped else {
        return Ok(SceneOutput { cloud: synthetic_cloud(scene, library)?, notes: Vec::new() });
    };
    let loaded =
        read_cloud(&file.name, &file.bytes).map_err(|error| Refusal::new(format!("{}: {error}", file.name)))?;
    let found = segment(&loaded.value, &scene.segment, scene.seed, watch)
        .map_err(|refusal| Refusal::new(format!("{}: {refusal}", file.name)))?;
    let spot = TableSpot { height_m: scene.table.height_m, spot_m: DROPPED_AT_M, cluster: 0 };
    let X_WF = table_to_robot(&found, &loaded.value, &spot);
    let mut notes = loaded.notes;
    notes.push("the cloud's table was brought onto the robot's, its nearest large cluster in front of the arm".into());
    Ok(SceneOutput { cloud: loaded.value.transformed(&X_WF), notes })
}

/// Table, clusters and fates; points on known obstacles are set aside first.
pub(super) fn segment_output(
    scene: &Scene,
    seen: &SceneOutput,
    is_dropped: bool,
    cluster: Option<usize>,
    watch: Watch<'_>,
) -> Result<SegmentOutput, Refusal> {
    let cloud = &seen.cloud;
    let mut found =
        segment(cloud, &scene.segment, scene.seed, watch).map_err(|error| Refusal::new(error.to_string()))?;
    if !is_dropped {
        found.remove_known(cloud, &scene.obstacles, OBSTACLE_MARGIN_M, scene.segment.cluster_min_points);
    }
    if found.clusters.is_empty() {
        return Err(Refusal::new("nothing stands on the table but the boxes that the robot knows"));
    }
    let clusters: Vec<Vec<Point3<f64>>> =
        found.clusters.iter().map(|indices| indices.iter().map(|&i| cloud.points[i as usize]).collect()).collect();
    let target = match cluster {
        Some(index) if index < clusters.len() => index,
        Some(index) => {
            return Err(Refusal::new(format!("there is no cluster {index}: the cloud has {}", clusters.len())));
        }
        None if is_dropped => 0,
        None => nearest_cluster(scene, &clusters),
    };
    Ok(SegmentOutput { table: found.table, fates: found.fates, clusters, target })
}

/// The cluster whose centroid is closest to the task's object.
fn nearest_cluster(scene: &Scene, clusters: &[Vec<Point3<f64>>]) -> usize {
    let wanted = scene.objects[scene.task.object].X_WO.translation.vector;
    let distance = |points: &[Point3<f64>]| {
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        (sum / points.len().max(1) as f64 - wanted).norm()
    };
    let by_distance = clusters.iter().map(|points| distance(points)).enumerate();
    by_distance.min_by(|l, r| l.1.total_cmp(&r.1)).map_or(0, |(index, _)| index)
}

/// The fit of one cluster, or the reason why there is none.
pub(super) fn fit_cluster(
    points: &[Point3<f64>],
    settings: &FitSettings,
    seen: &SceneOutput,
    segments: &SegmentOutput,
    watch: Watch<'_>,
) -> Result<Fit, String> {
    let input = FitInput { points, X_FC: seen.cloud.X_FC, table: Some(segments.table) };
    fit(input, settings, watch).map_err(|refusal| refusal.to_string())
}

/// One fit per cluster.
pub(super) fn fit_output(
    scene: &Scene,
    seen: &SceneOutput,
    segments: &SegmentOutput,
    watch: Watch<'_>,
) -> Result<FitOutput, Refusal> {
    let fits = parallel::map(&segments.clusters, |points| fit_cluster(points, &scene.fit, seen, segments, watch));
    if watch.should_stop() {
        // A neighbour's fit may have been stopped while the target's was done: nothing of it is worth remembering.
        return Err(Refusal::new("stopped"));
    }
    match &fits[segments.target] {
        Err(reason) => Err(Refusal::new(format!("the object to grasp cannot be fitted: {reason}"))),
        Ok(_) => {
            let distances = |(fit, points): (&Result<Fit, String>, &Vec<Point3<f64>>)| {
                fit.as_ref().map_or_else(|_| Vec::new(), |fit| signed_distances(fit, points))
            };
            let distances_m = fits.iter().zip(&segments.clusters).map(distances).collect();
            Ok(FitOutput { fits, target: segments.target, distances_m, automatic: None })
        }
    }
}
