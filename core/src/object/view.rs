//! A scene as the robot's camera sees it.

use nalgebra::{Isometry3, Vector3};

use super::{HouseholdObject, ObjectError, box_mesh};
use crate::cloud::{PointCloud, RgbdCamera, SeenBody};
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Colour of the table top, sRGB.
const TABLE_COLOR: [u8; 3] = [206, 196, 182];
/// Colour of known boxes, sRGB.
const OBSTACLE_COLOR: [u8; 3] = [150, 156, 166];

/// Which body a point was measured on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneBody {
    /// The table.
    Table,
    /// The object with this index in the scene.
    Object(usize),
    /// The obstacle with this index in the scene.
    Obstacle(usize),
}

/// The cloud of a scene and the truth behind it.
#[derive(Clone, Debug)]
pub struct SceneView {
    /// Organised cloud in W, with `X_FC = X_WC`.
    pub cloud: PointCloud,
    /// The body of each point; the pipeline never sees it, tests do.
    pub truth: Vec<SceneBody>,
}

/// Renders the table, the objects and the obstacles of a scene through its camera; `scene.seed` decides the noise.
///
/// * `objects`: the known objects, found by name.
///
/// # Errors
/// [`ObjectError::Unknown`] when the scene names an object that is not among them.
pub fn view_scene(scene: &Scene, objects: &[HouseholdObject], camera: &RgbdCamera) -> Result<SceneView, ObjectError> {
    struct Body {
        mesh: Mesh,
        X_WM: Isometry3<f64>,
        color: [u8; 3],
        is: SceneBody,
    }
    let top = &scene.table;
    let mut bodies = vec![Body {
        mesh: box_mesh(&Vector3::new(top.size_m[0], top.size_m[1], top.thickness_m)),
        X_WM: Isometry3::translation(top.center_m[0], top.center_m[1], top.height_m - top.thickness_m / 2.0),
        color: TABLE_COLOR,
        is: SceneBody::Table,
    }];
    for (index, placed) in scene.objects.iter().enumerate() {
        let Some(object) = objects.iter().find(|object| object.name == placed.object) else {
            return Err(ObjectError::Unknown { index, name: placed.object.clone() });
        };
        bodies.push(Body { mesh: object.mesh(), X_WM: placed.X_WO, color: object.color, is: SceneBody::Object(index) });
    }
    for (index, obstacle) in scene.obstacles.iter().enumerate() {
        bodies.push(Body {
            mesh: box_mesh(&obstacle.size_m),
            X_WM: obstacle.X_WB,
            color: OBSTACLE_COLOR,
            is: SceneBody::Obstacle(index),
        });
    }
    let seen: Vec<SeenBody<'_>> =
        bodies.iter().map(|body| SeenBody { mesh: &body.mesh, X_WM: body.X_WM, color: body.color }).collect();
    let view = camera.render(&seen, &scene.X_WC, scene.seed);
    let truth = view.bodies.iter().filter_map(|index| bodies.get(*index as usize)).map(|body| body.is).collect();
    Ok(SceneView { cloud: view.cloud, truth })
}
