//! The bundled objects and scenes: every object is a centred solid of its stated size, and every scene's cloud falls
//! apart into its objects.

#![allow(non_snake_case, reason = "frame letters: X_WC is the pose of C in W")]
#![allow(clippy::unwrap_used, reason = "a test may stop at what is missing")]

use std::path::PathBuf;

use endcomfort_core::cloud::RgbdCamera;
use endcomfort_core::object::{HouseholdObject, SceneBody, view_scene};
use endcomfort_core::scene::{Action, Scene};
use endcomfort_core::segment::{PointFate, SegmentSettings, segment};
use endcomfort_core::watch::Watch;
use nalgebra::Vector3;

fn files(folder: &str) -> Vec<(String, String)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../objects").join(folder);
    let mut files: Vec<(String, String)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), std::fs::read_to_string(path).unwrap()))
        .collect();
    files.sort();
    files
}

fn objects() -> Vec<HouseholdObject> {
    files("")
        .iter()
        .map(|(name, text)| HouseholdObject::parse(text).unwrap_or_else(|e| panic!("{name}: {e}")))
        .collect()
}

fn scenes() -> Vec<Scene> {
    files("scenes")
        .iter()
        .map(|(name, text)| serde_json::from_str(text).unwrap_or_else(|e| panic!("{name}: {e}")))
        .collect()
}

#[test]
fn objects_have_their_published_sizes_and_carry_the_name_of_their_file() {
    let objects = objects();
    assert!(objects.len() >= 10);
    for ((file, _), object) in files("").iter().zip(&objects) {
        assert_eq!(*file, object.name);
        assert!(!object.title.is_empty() && !object.source.is_empty());
    }
    for (name, millimetres) in [
        ("mustard_bottle", [85.0, 50.0, 175.0]),
        ("cracker_box", [60.0, 158.0, 210.0]),
        ("master_chef_can", [102.0, 102.0, 139.0]),
        ("tomato_soup_can", [66.0, 66.0, 101.0]),
        ("tennis_ball", [64.7, 64.7, 64.7]),
        ("mug_body", [80.0, 80.0, 82.0]),
        ("pudding_box", [35.0, 110.0, 89.0]),
        ("lemon", [68.0, 54.0, 54.0]),
        ("apple", [75.0, 75.0, 71.9]),
        ("bleach_cleanser", [98.0, 65.0, 250.0]),
        ("drinking_glass", [80.0, 80.0, 150.0]),
    ] {
        let object = objects.iter().find(|object| object.name == name).unwrap();
        let half = object.half_extents();
        // Rings of a ball need not pass through its equator: half a millimetre.
        assert!((2e3 * half - Vector3::from(millimetres)).amax() < 0.5, "{name}: {half}");
    }
}

#[test]
fn every_scene_falls_apart_into_its_objects() {
    let objects = objects();
    let scenes = scenes();
    assert!(scenes.len() >= 8);
    for scene in &scenes {
        let view = view_scene(scene, &objects, &RgbdCamera::default()).unwrap();
        assert!(view.cloud.points.len() > 150_000, "{}: {}", scene.name, view.cloud.points.len());
        let settings = SegmentSettings::default();
        let mut segmentation = segment(&view.cloud, &settings, scene.seed, Watch::idle()).unwrap();
        // The pieces of one thing have one name; what stands in a crate is one with it until that is taken out.
        let mut known: Vec<&str> = scene.obstacles.iter().map(|obstacle| obstacle.name.as_str()).collect();
        known.dedup();
        let apart = scene.objects.len() + known.len();
        assert!((apart - known.len()..=apart).contains(&segmentation.clusters.len()), "{}", scene.name);
        segmentation.remove_known(&view.cloud, &scene.obstacles, 0.01, settings.cluster_min_points);
        assert_eq!(segmentation.clusters.len(), scene.objects.len(), "{}", scene.name);
        assert!((segmentation.table.offset_m - scene.table.height_m).abs() < 0.002, "{:?}", segmentation.table);
        assert!(segmentation.table.normal.z > 0.9999, "{:?}", segmentation.table);
        for object in 0..scene.objects.len() {
            let size = view.truth.iter().filter(|body| **body == SceneBody::Object(object)).count();
            let iou = (segmentation.clusters.iter())
                .map(|cluster| {
                    let both = cluster.iter().filter(|i| view.truth[**i as usize] == SceneBody::Object(object)).count();
                    both as f64 / (size + cluster.len() - both) as f64
                })
                .fold(0.0, f64::max);
            println!("{}: {}: {size} points, IoU {iou:.3}", scene.name, scene.objects[object].object);
            // The lowest centimetre goes to the table: of a ball hardly anything, of an oblique box a sixth.
            assert!(iou > 0.8, "{}: {}: {iou}", scene.name, scene.objects[object].object);
        }
        let known = segmentation.fates.iter().filter(|fate| **fate == PointFate::KnownObstacle).count();
        assert_eq!(known > 0, !scene.obstacles.is_empty());
    }
}

#[test]
fn objects_stand_on_the_table_apart_from_each_other_and_goals_are_free() {
    let objects = objects();
    for scene in scenes() {
        let size = |index: usize| {
            let placed = &scene.objects[index];
            objects.iter().find(|object| object.name == placed.object).unwrap().half_extents()
        };
        // The goal of a handover may be the receiver's.
        let goal = scene.task.X_WO_goal();
        assert!(goal.is_some() || scene.handover.is_some(), "{}", scene.name);
        let target = &scene.task.object;
        for (index, placed) in scene.objects.iter().enumerate() {
            let p = placed.X_WO.translation.vector;
            // A long thing may lie on a box with one end.
            let along = placed.X_WO.rotation * Vector3::x() * (0.8 * size(index).x);
            let below = [p, p + along, p - along].map(|p| under(&scene, &p)).into_iter().fold(0.0, f64::max);
            let height_m = p.z - size(index).z - below;
            assert!(height_m.abs() < 5e-4, "{}: {}: {height_m}", scene.name, placed.object);
            assert!((0.4..=0.65).contains(&p.x) && p.y.abs() <= 0.45, "{}: {}", scene.name, placed.object);
            let far_from = |q: &Vector3<f64>, other: usize| (p.xy() - q.xy()).norm() - size(other).xy().min();
            for other in index + 1..scene.objects.len() {
                let gap = far_from(&scene.objects[other].X_WO.translation.vector, other) - size(index).xy().min();
                assert!(gap > 0.05, "{}: {} and {}: {gap}", scene.name, placed.object, scene.objects[other].object);
            }
            if let Some(X_WO_goal) = goal.filter(|_| index != *target) {
                let gap = far_from(&X_WO_goal.translation.vector, *target) - size(index).xy().max();
                assert!(gap > 0.05, "{}: goal and {}: {gap}", scene.name, placed.object);
            }
        }
        let stands = scene.task.steps.last().is_some_and(|step| step.action != Action::Slide);
        if let Some(X_WO_goal) = goal.filter(|_| stands) {
            let height_m = X_WO_goal.translation.z - size(*target).z - under(&scene, &X_WO_goal.translation.vector);
            assert!(height_m.abs() < 5e-4, "{}: {height_m}", scene.name);
        }
    }
}

/// Height of the table or of the highest known box below a point.
fn under(scene: &Scene, p: &Vector3<f64>) -> f64 {
    let over = scene.obstacles.iter().filter(|obstacle| {
        let from = obstacle.X_WB.rotation.inverse() * (p - obstacle.X_WB.translation.vector);
        from.x.abs() < 0.5 * obstacle.size_m.x && from.y.abs() < 0.5 * obstacle.size_m.y && from.z > 0.0
    });
    over.map(|obstacle| obstacle.X_WB.translation.z + 0.5 * obstacle.size_m.z).fold(scene.table.height_m, f64::max)
}

#[test]
fn the_same_seed_gives_the_same_cloud() {
    let objects = objects();
    let scene = &scenes()[0];
    let [a, b] = [0, 1].map(|_| view_scene(scene, &objects, &RgbdCamera::default()).unwrap().cloud.points);
    assert_eq!(a, b);
}
