//! Reachability maps of the scene's robot, one after the other.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::job::{BuiltMap, MapMethod, MapRequest, Output, Update};
use crate::library::Library;
use crate::reach::{ForwardSettings, InverseSettings, ReachError, ReachMap, build_forward, build_inverse};
use crate::robot::Robot;
use crate::scene::Scene;
use crate::watch::Watch;

/// Builds the maps and tells each with its time, and how far they are in steps of one per cent.
pub(super) fn build(
    scene: &Scene,
    request: &MapRequest,
    revision: u64,
    library: &Library,
    watch: Watch<'_>,
    emit: &mut (dyn FnMut(Update) + Send),
) {
    let emit = Mutex::new(emit);
    let tell = |update: Update| {
        if let Ok(mut emit) = emit.lock() {
            emit(update);
        }
    };
    // The maps are those of the robot that acts, whoever else takes part in the scene.
    let alone = Scene { handover: None, ..scene.clone() };
    let robot = library.robot_of(&alone).map_err(|error| error.to_string());
    let count = request.arms.len();
    for (index, arm) in request.arms.iter().enumerate() {
        let told_percent = AtomicU32::new(0);
        let progress = |fraction: f64, note: &str| {
            watch.progress(fraction, note);
            let percent = (100.0 * fraction) as u32;
            if told_percent.fetch_max(percent, Ordering::Relaxed) < percent {
                let fraction = (index as f64 + fraction) / count as f64;
                tell(Update::Mapping { revision, fraction, note: format!("{arm} arm, {note}") });
            }
        };
        tell(Update::Mapping { revision, fraction: index as f64 / count as f64, note: format!("{arm} arm") });
        let started = watch.now_ms();
        let (should_stop, now_ms) = (|| watch.should_stop(), || watch.now_ms());
        let file = robot.as_ref().map_err(String::clone).and_then(|robot| {
            let map = one(robot, arm, request, Watch::new(&should_stop, &progress, &now_ms))?;
            // Packing hundreds of orientations takes a while of its own.
            if watch.should_stop() { Err(String::new()) } else { Ok(map.to_bytes()) }
        });
        if watch.should_stop() {
            return;
        }
        let elapsed_ms = watch.now_ms() - started;
        let built = BuiltMap { arm: arm.clone(), torso: request.torso, file };
        tell(Update::Done { revision, elapsed_ms, output: Box::new(Output::Map(Box::new(built))) });
    }
}

fn one(robot: &Robot, arm: &str, request: &MapRequest, watch: Watch<'_>) -> Result<ReachMap, String> {
    let index = robot.arms.iter().position(|found| found.name == arm);
    let index = index.ok_or_else(|| format!("{} has no {arm} arm", robot.name))?;
    let with_torso = request.torso.then(|| robot.with_torso(index));
    let robot = with_torso.as_ref().unwrap_or(robot);
    let (voxel_m, orientations) = (request.voxel_m, request.orientations);
    let map: Result<ReachMap, ReachError> = match request.method {
        MapMethod::Inverse => build_inverse(robot, index, &InverseSettings { voxel_m, orientations }, watch),
        MapMethod::Forward { samples } => {
            let settings = ForwardSettings { voxel_m, orientations, samples, ..ForwardSettings::default() };
            build_forward(robot, index, &settings, watch)
        }
    };
    map.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicUsize;

    use super::*;
    use crate::job::Request;
    use crate::pipeline::Pipeline;

    fn library() -> Arc<Library> {
        let read = |path: &str| {
            let file = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path);
            let bytes: &'static [u8] = std::fs::read(file).ok()?.leak();
            Some(bytes)
        };
        Arc::new(Library::new(Box::new(read)))
    }

    fn request(arms: &[&str], method: MapMethod) -> Request {
        let arms = arms.iter().map(|arm| (*arm).to_owned()).collect();
        let map = MapRequest { arms, torso: false, voxel_m: 0.2, orientations: 40, method };
        let scene = Scene::parse(include_str!("../../../objects/scenes/mustard.json")).unwrap();
        Request { revision: 7, map: Some(map), ..Request::new(scene) }
    }

    fn run(request: &Request, should_stop: &(dyn Fn() -> bool + Sync)) -> Vec<Update> {
        let mut updates = Vec::new();
        let watch = Watch::new(should_stop, &|_, _| (), &|| 0.0);
        Pipeline::new(library()).run(request, &watch, &mut |update| updates.push(update));
        updates
    }

    #[test]
    fn the_maps_of_both_arms_come_as_files_that_can_be_read_with_progress_that_never_goes_back() {
        let updates = run(&request(&["left", "right"], MapMethod::Inverse), &|| false);
        let robot = library().robot("alita").unwrap();
        let (mut arms, mut last) = (Vec::new(), 0.0);
        for update in &updates {
            match update {
                Update::Mapping { fraction, revision: 7, .. } => {
                    assert!((last..=1.0).contains(fraction), "{fraction} after {last}");
                    last = *fraction;
                }
                Update::Done { output, revision: 7, .. } => {
                    let Output::Map(built) = &**output else { panic!("{output:?}") };
                    let map = ReachMap::from_bytes(built.file.as_ref().unwrap(), &robot, arms.len()).unwrap();
                    assert!(map.voxels().count() > 100);
                    arms.push(built.arm.as_str());
                }
                other => assert!(matches!(other, Update::Finished { revision: 7 }), "{other:?}"),
            }
        }
        assert_eq!(arms, ["left", "right"]);
        assert_eq!(last, 1.0);
        assert!(matches!(updates.last(), Some(Update::Finished { .. })));
    }

    #[test]
    fn a_build_that_is_stopped_gives_no_map_and_one_that_cannot_be_says_why() {
        let asked = AtomicUsize::new(0);
        let stop_soon = || asked.fetch_add(1, Ordering::Relaxed) > 3;
        let updates = run(&request(&["left"], MapMethod::Inverse), &stop_soon);
        assert!(updates.iter().all(|update| !matches!(update, Update::Done { .. })));
        assert!(matches!(updates.last(), Some(Update::Finished { .. })));
        for (arm, samples, word) in [("third", 10, "third arm"), ("left", 0, "0 samples")] {
            let updates = run(&request(&[arm], MapMethod::Forward { samples }), &|| false);
            let reason = updates.iter().find_map(|update| match update {
                Update::Done { output, .. } => match &**output {
                    Output::Map(built) => built.file.clone().err(),
                    _ => None,
                },
                _ => None,
            });
            assert!(reason.as_ref().is_some_and(|reason| reason.contains(word)), "{reason:?}");
        }
    }
}
