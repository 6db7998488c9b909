//! The robots of `robots/`, for tests; meshes come from the files beside them.

use super::{Robot, load_robot};

fn mesh(name: &str) -> Option<Vec<u8>> {
    let meshes = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/meshes"));
    std::fs::read(meshes.join(name.rsplit('/').next()?)).ok()
}

fn load(urdf: &str, srdf: &str) -> Robot {
    let loaded = load_robot(urdf, srdf, &mesh).unwrap();
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

/// Hubo: arms of six joints, simple hands, legs that kneel.
pub(crate) fn hubo() -> Robot {
    load(include_str!("../../../robots/hubo/hubo.urdf"), include_str!("../../../robots/hubo/hubo.srdf"))
}

/// A person: S-R-S arms, hands, legs that kneel and sit.
pub(crate) fn human() -> Robot {
    load(include_str!("../../../robots/human/human.urdf"), include_str!("../../../robots/human/human.srdf"))
}

/// A description of `robots/hands/`.
pub(crate) fn hand(name: &str) -> super::HandDescription {
    let file = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/hands")).join(name);
    super::HandDescription::parse(&std::fs::read_to_string(file).unwrap()).unwrap()
}

/// The robot with a described hand at one arm.
pub(crate) fn with_hand(robot: &Robot, arm: &str, hand: &super::HandDescription) -> Robot {
    let loaded = robot.with_hand(arm, hand, &mesh).unwrap();
    assert!(loaded.notes.is_empty(), "{:#?}", loaded.notes);
    loaded.value
}
