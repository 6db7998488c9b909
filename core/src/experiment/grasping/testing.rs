//! Settings over the files of the repository, for tests.

use std::sync::Arc;

use super::{GraspExperimentSettings, Pace};
use crate::library::Library;

/// One trial per condition on Alita with these objects.
pub(super) fn settings(objects: &[&str]) -> GraspExperimentSettings {
    let read = |path: &str| {
        let file = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path);
        let bytes: &'static [u8] = std::fs::read(file).ok()?.leak();
        Some(bytes)
    };
    GraspExperimentSettings {
        library: Arc::new(Library::new(Box::new(read))),
        robots: vec!["alita".to_owned()],
        objects: objects.iter().map(|name| (*name).to_owned()).collect(),
        trials: Some(1),
        clutter: 0,
        any_way: false,
        planner: Default::default(),
        scenes: Vec::new(),
        scenarios: Vec::new(),
        seed: 1,
        pace: Pace::SideBySide,
    }
}
