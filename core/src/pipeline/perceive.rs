//! From a scene or a dropped file to the cloud that the robot sees, its segments and their fits.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::cloud::{PointCloud, RgbdCamera, SeenBody, read_cloud};
use crate::fit::{FitInput, fit};
use crate::job::{DroppedCloud, FitOutput, Refusal, SceneOutput, SegmentOutput};
use crate::library::Library;
use crate::mesh::Mesh;
use crate::parallel;
use crate::scene::Scene;
use crate::segment::{TableSpot, segment, table_to_robot};
use crate::watch::Watch;

/// Points this close to a known obstacle belong to it, metres: camera noise and the tilt of its faces.
const OBSTACLE_MARGIN_M: f64 = 0.012;
/// Where the centre of a dropped cloud's largest cluster is put on the robot's table, metres from the torso axis.
const DROPPED_AT_M: [f64; 2] = [0.52, 0.24];
const TABLE_COLOR: [u8; 3] = [126, 112, 98];
const OBSTACLE_COLOR: [u8; 3] = [170, 140, 110];

fn refused(message: impl Into<String>) -> Refusal {
    Refusal { message: message.into(), details: Vec::new() }
}

/// The cloud that the scene's camera sees, in W.
///
/// # Errors
/// A [`Refusal`] when the scene names an object that does not exist.
pub fn synthetic_cloud(scene: &Scene, library: &Library, seed: u64) -> Result<PointCloud, Refusal> {
    let table = &scene.table;
    let center =
        Translation3::new(table.center_m[0], table.center_m[1], table.height_m - 0.5 * table.thickness_m);
    let mut meshes: Vec<(Mesh, Isometry3<f64>, [u8; 3])> = vec![(
        box_mesh(Vector3::new(table.size_m[0], table.size_m[1], table.thickness_m)),
        Isometry3::from_parts(center, UnitQuaternion::identity()),
        TABLE_COLOR,
    )];
    for obstacle in &scene.obstacles {
        meshes.push((box_mesh(obstacle.size_m), obstacle.X_WB, OBSTACLE_COLOR));
    }
    for placed in &scene.objects {
        let object = library.object(&placed.object).map_err(|error| refused(error.to_string()))?;
        meshes.push((object.mesh(), placed.X_WO, object.color));
    }
    let bodies: Vec<SeenBody<'_>> =
        meshes.iter().map(|(mesh, X_WM, color)| SeenBody { mesh, X_WM: *X_WM, color: *color }).collect();
    Ok(RgbdCamera::default().render(&bodies, &scene.X_WC, seed).cloud)
}

fn box_mesh(size_m: Vector3<f64>) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            let mut u = Vector3::zeros();
            u[(axis + 1) % 3] = sign;
            let v = normal.cross(&u);
            let first = mesh.positions.len() as u32;
            for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let corner: Vector3<f64> = normal + u * s + v * t;
                mesh.positions.push(Point3::from(corner.component_mul(&size_m) * 0.5));
                mesh.normals.push(normal);
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    mesh
}

/// The cloud of a request, in W.
pub(super) fn scene_output(
    scene: &Scene,
    dropped: Option<&DroppedCloud>,
    library: &Library,
    watch: Watch<'_>,
) -> Result<SceneOutput, Refusal> {
    let Some(file) = dropped else {
        return Ok(SceneOutput { cloud: synthetic_cloud(scene, library, scene.seed)?, notes: Vec::new() });
    };
    let loaded =
        read_cloud(&file.name, &file.bytes).map_err(|error| refused(format!("{}: {error}", file.name)))?;
    let found = segment(&loaded.value, &scene.segment, scene.seed, watch)
        .map_err(|refusal| refused(format!("{}: {refusal}", file.name)))?;
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
    let mut found = segment(cloud, &scene.segment, scene.seed, watch).map_err(|error| refused(error.to_string()))?;
    if !is_dropped {
        found.remove_known(cloud, &scene.obstacles, OBSTACLE_MARGIN_M, scene.segment.cluster_min_points);
    }
    if found.clusters.is_empty() {
        return Err(refused("nothing stands on the table but the boxes that the robot knows"));
    }
    let clusters: Vec<Vec<Point3<f64>>> = found
        .clusters
        .iter()
        .map(|indices| indices.iter().map(|&i| cloud.points[i as usize]).collect())
        .collect();
    let target = match cluster {
        Some(index) if index < clusters.len() => index,
        Some(index) => {
            return Err(refused(format!("there is no cluster {index}: the cloud has {}", clusters.len())));
        }
        None if is_dropped => 0,
        None => nearest_cluster(scene, &clusters),
    };
    Ok(SegmentOutput { table: found.table, fates: found.fates, clusters, target })
}

/// The cluster whose centroid is closest to the task's object.
fn nearest_cluster(scene: &Scene, clusters: &[Vec<Point3<f64>>]) -> usize {
    let wanted = scene.objects[scene.task.object()].X_WO.translation.vector;
    let distance = |points: &[Point3<f64>]| {
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        (sum / points.len().max(1) as f64 - wanted).norm()
    };
    let by_distance = clusters.iter().map(|points| distance(points)).enumerate();
    by_distance.min_by(|l, r| l.1.total_cmp(&r.1)).map_or(0, |(index, _)| index)
}

/// One fit per cluster.
pub(super) fn fit_output(
    scene: &Scene,
    seen: &SceneOutput,
    segments: &SegmentOutput,
    watch: Watch<'_>,
) -> Result<FitOutput, Refusal> {
    let fits = parallel::map(&segments.clusters, |points| {
        let input = FitInput { points, X_FC: seen.cloud.X_FC, table: Some(segments.table) };
        fit(input, &scene.fit, watch).map_err(|refusal| refusal.to_string())
    });
    match &fits[segments.target] {
        Err(reason) => Err(refused(format!("the object to grasp cannot be fitted: {reason}"))),
        Ok(_) => Ok(FitOutput { fits, target: segments.target }),
    }
}
