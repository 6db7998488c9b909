//! The robots, objects and demos that travel inside the program.

use std::sync::{Arc, OnceLock};

use endcomfort_core::library::Library;
use endcomfort_core::scene::Scene;
use include_dir::{Dir, include_dir};

/// The folders of `robots/`. The page fetches maps when they are first shown.
static ROBOTS: &[(&str, Dir<'_>)] = &[
    ("alita", include_dir!("$CARGO_MANIFEST_DIR/../robots/alita")),
    ("crichton", include_dir!("$CARGO_MANIFEST_DIR/../robots/crichton")),
    ("hands", include_dir!("$CARGO_MANIFEST_DIR/../robots/hands")),
    ("hubo", include_dir!("$CARGO_MANIFEST_DIR/../robots/hubo")),
    ("human", include_dir!("$CARGO_MANIFEST_DIR/../robots/human")),
    #[cfg(not(target_arch = "wasm32"))]
    ("maps", include_dir!("$CARGO_MANIFEST_DIR/../robots/maps")),
    ("meshes", include_dir!("$CARGO_MANIFEST_DIR/../robots/meshes")),
];
static OBJECTS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../objects");

/// The demos in the order of the gallery; each is `objects/scenes/NAME.json`.
pub const DEMOS: [&str; 13] = [
    "mustard",
    "jar",
    "glass",
    "box-in",
    "box-on",
    "across",
    "pour",
    "regrasp",
    "self-handover",
    "butler",
    "kneeling",
    "stool",
    "human",
];

/// The robots that a scene may name.
pub const ROBOT_NAMES: [&str; 2] = ["crichton", "alita"];

/// Those to whom a robot hands things over.
pub const RECEIVERS: [&str; 2] = ["hubo", "human"];

/// Content of a file by its path in the repository: `robots/alita/alita.urdf`, `objects/mug_body.json`.
pub fn read(path: &str) -> Option<&'static [u8]> {
    let (folder, rest) = path.split_once('/')?;
    let (dir, rest) = match folder {
        "robots" => {
            let (folder, rest) = rest.split_once('/')?;
            (&ROBOTS.iter().find(|(name, _)| *name == folder)?.1, rest)
        }
        "objects" => (&OBJECTS, rest),
        _ => return None,
    };
    dir.get_file(rest).map(include_dir::File::contents)
}

/// The library over the files inside the program, shared by everyone.
pub fn library() -> Arc<Library> {
    static LIBRARY: OnceLock<Arc<Library>> = OnceLock::new();
    LIBRARY.get_or_init(|| Arc::new(Library::new(Box::new(read)))).clone()
}

/// The scene of a demo; `None` when there is no demo of this name.
pub fn demo(name: &str) -> Option<Scene> {
    let json = std::str::from_utf8(read(&format!("objects/scenes/{name}.json"))?).ok()?;
    match Scene::parse(json) {
        Ok(scene) => Some(scene),
        Err(error) => {
            log::error!("demo {name}: {error}");
            None
        }
    }
}

/// The picture of a demo for its card, a JPEG that `render` made (`cargo xtask figures`).
pub fn thumbnail(name: &str) -> Option<&'static [u8]> {
    read(&format!("objects/scenes/{name}.jpg"))
}

/// Names of all household objects, sorted.
pub fn object_names() -> Vec<&'static str> {
    let mut names: Vec<&str> =
        OBJECTS.files().filter_map(|file| file.path().file_name()?.to_str()?.strip_suffix(".json")).collect();
    names.sort_unstable();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_demo_names_a_known_robot_posture_arm_and_objects() {
        let library = library();
        for name in DEMOS {
            let scene = demo(name).expect(name);
            let robot = library.robot(&scene.robot).expect("robot");
            assert!(robot.posture(&scene.posture).is_some(), "{name}: posture {:?}", scene.posture);
            assert!(robot.arm(scene.arm.name()).is_some(), "{name}: arm");
            for placed in &scene.objects {
                library.object(&placed.object).expect("object");
            }
        }
    }

    #[test]
    fn every_receiver_has_two_arms_and_stands_and_kneels() {
        for name in RECEIVERS {
            let robot = library().robot(name).expect(name);
            assert!(["left", "right"].iter().all(|arm| robot.arm(arm).is_some()), "{name}");
            assert!(["standing", "kneeling"].iter().all(|posture| robot.posture(posture).is_some()), "{name}");
        }
    }

    #[test]
    fn every_object_file_can_be_read() {
        assert!(object_names().len() >= 8);
        for name in object_names() {
            library().object(name).expect(name);
        }
    }
}
