//! What a subcommand is given: a demo's name, a scene file or a cloud file.

use std::path::Path;

use endcomfort_core::cloud::{PointCloud, read_cloud};
use endcomfort_core::job::Request;
use endcomfort_core::loaded::Loaded;
use endcomfort_core::mesh_file::MeshUnit;
use endcomfort_core::robot::HandDescription;
use endcomfort_core::scene::Scene;

use super::depth_options::DepthOptions;
use super::{Common, Failure, robot_options};
use crate::assets;
use crate::brought::{self, BroughtMesh};

/// Largest file that is read, bytes.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Numbers between commas, exactly so many: `0.5,-0.1,0.8`.
pub(super) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let found: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
    let found = found.map_err(|_| format!("wanted {N} numbers between commas"))?;
    let count = found.len();
    <[f64; N]>::try_from(found).map_err(|_| format!("found {count} numbers, wanted {N} between commas"))
}

/// The content of a file.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, Failure> {
    let shown = path.display();
    let size = std::fs::metadata(path).map_err(|error| Failure::new(format!("{shown}: {error}")))?.len();
    if size > MAX_FILE_BYTES {
        return Err(Failure::new(format!("{shown}: found {size} bytes, wanted at most {MAX_FILE_BYTES}")));
    }
    std::fs::read(path).map_err(|error| Failure::new(format!("{shown}: {error}")))
}

/// A cloud file in its own frame.
pub(super) fn cloud_file(path: &Path) -> Result<Loaded<PointCloud>, Failure> {
    let bytes = read_file(path)?;
    read_cloud(&path.to_string_lossy(), &bytes).map_err(|error| Failure::new(format!("{}: {error}", path.display())))
}

/// Whether a name is a demo or a scene file, as opposed to a cloud.
pub(super) fn is_scene(name: &str) -> bool {
    assets::DEMOS.contains(&name) || Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

/// A demo.
pub(super) fn demo(name: &str) -> Result<Scene, Failure> {
    let known = || assets::DEMOS.join(", ");
    assets::demo(name).ok_or_else(|| Failure::new(format!("there is no demo {name:?}; there are {}", known())))
}

/// A demo or a scene file.
pub(super) fn scene(name: &str) -> Result<Scene, Failure> {
    if let Some(scene) = assets::demo(name) {
        return Ok(scene);
    }
    if !is_scene(name) {
        return Err(Failure::new(format!(
            "{name:?} is neither a demo ({}) nor a scene file (.json)",
            assets::DEMOS.join(", ")
        )));
    }
    let bytes = read_file(Path::new(name))?;
    Scene::parse(&String::from_utf8_lossy(&bytes)).map_err(|error| Failure::new(format!("{name}: {error}")))
}

/// A hand description; its URDF may be a file beside it.
pub(super) fn hand(path: &Path) -> Result<HandDescription, Failure> {
    let shown = path.display();
    let bytes = read_file(path)?;
    let mut hand: HandDescription = serde_json::from_slice(&bytes)
        .map_err(|error| Failure::new(format!("{shown}: not a hand description: {error}")))?;
    if !hand.urdf.trim_start().starts_with('<') {
        let beside = path.parent().unwrap_or(Path::new("")).join(&hand.urdf);
        hand.urdf = String::from_utf8_lossy(&read_file(&beside)?).into_owned();
    }
    hand.check().map_err(|error| Failure::new(format!("{shown}: {error}")))?;
    Ok(hand)
}

/// A request for a demo, a scene file or a cloud file; a cloud is brought onto the table of the first demo.
pub(super) fn request(
    name: &str,
    robot: &robot_options::RobotOptions,
    depth: &DepthOptions,
    common: &Common,
) -> Result<Request, Failure> {
    let (mut scene, cloud) = if is_scene(name) {
        depth.refuse_alone()?;
        (scene(name)?, None)
    } else if brought::is_mesh(name) {
        depth.refuse_alone()?;
        (scene_for_clouds()?, None)
    } else {
        (scene_for_clouds()?, Some(depth.cloud(Path::new(name))?))
    };
    robot.apply(&mut scene)?;
    if brought::is_mesh(name) {
        let mesh = BroughtMesh::read(name, &read_file(Path::new(name))?).map_err(Failure::new)?;
        let unit = robot.unit.map_or(mesh.unit, MeshUnit::from);
        eprintln!("{name}: {}", robot.unit.map_or(mesh.reason.as_str(), |_| "in the unit that was given"));
        scene = brought::alone(&scene, &mesh.object(unit).map_err(Failure::new)?);
    }
    if let Some(seed) = common.seed {
        scene.seed = seed;
    }
    let robot = assets::library().guest(&scene.robot).map(|guest| guest.robot.clone());
    let objects = assets::library().brought(&scene);
    Ok(Request { cloud, robot, objects, ..Request::new(scene) })
}

fn scene_for_clouds() -> Result<Scene, Failure> {
    assets::demo(assets::DEMOS[0]).ok_or_else(|| Failure::new("the first demo is missing"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_counted_and_may_be_negative() {
        assert_eq!(numbers::<3>("-0.5, 0,1e-3"), Ok([-0.5, 0.0, 1e-3]));
        for text in ["1,2", "1,2,3,4", "1,2,x", ""] {
            assert!(numbers::<3>(text).is_err_and(|error| error.contains("wanted 3")), "{text:?}");
        }
    }
}
