//! The two robots of `robots/`, for tests; meshes come from the files beside them.

use super::{Robot, load_robot};

fn load(urdf: &str, srdf: &str) -> Robot {
    let meshes = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/meshes"));
    let resolve = |name: &str| std::fs::read(meshes.join(name.rsplit('/').next()?)).ok();
    let loaded = load_robot(urdf, srdf, &resolve).unwrap();
    assert!(loaded.notes.is_empty(), "{:#?}", loaded.notes);
    loaded.value
}

/// Crichton: torso, two LWA4D arms, SDH hands.
pub(crate) fn crichton() -> Robot {
    load(include_str!("../../../robots/crichton/crichton.urdf"), include_str!("../../../robots/crichton/crichton.srdf"))
}

/// Alita: two LWA3 arms, parallel grippers.
pub(crate) fn alita() -> Robot {
    load(include_str!("../../../robots/alita/alita.urdf"), include_str!("../../../robots/alita/alita.srdf"))
}
