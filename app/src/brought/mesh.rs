//! Meshes that people bring: something to grasp, or something that stands in the way.

use std::sync::Arc;

use endcomfort_core::mesh::Mesh;
use endcomfort_core::mesh_file::{ENDINGS, MeshUnit, guess_unit, read_mesh};
use endcomfort_core::object::HouseholdObject;
use endcomfort_core::scene::{PlacedObject, Scene, Task};
use nalgebra::{Isometry3, Vector3};

use crate::assets;

/// What stands on the table hovers this far above it, metres: rests are no collisions.
const ABOVE_M: f64 = 0.001;
/// Where a brought object stands, metres behind the table's edge, and to the side of the acting arm.
const BEHIND_EDGE_M: f64 = 0.25;
const ASIDE_M: f64 = 0.15;
/// How far it is moved to the side where nobody says where to, metres.
const MOVED_M: f64 = 0.20;

/// Whether a file is a mesh, by its ending.
pub fn is_mesh(name: &str) -> bool {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    ENDINGS.contains(&ending.as_str())
}

/// A mesh as it stands in its file, with the unit that it seems to be in.
#[derive(Clone, Debug)]
pub struct BroughtMesh {
    /// File name.
    pub name: String,
    /// Its surface, in the unit of the file.
    pub mesh: Arc<Mesh>,
    /// The unit that it seems to be in.
    pub unit: MeshUnit,
    /// Why.
    pub reason: String,
}

impl BroughtMesh {
    /// Reads a mesh file.
    ///
    /// # Errors
    /// A sentence that says what is wrong with it.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let mesh = read_mesh(name, bytes).map_err(|error| format!("{name}: {error}"))?;
        let (unit, reason) = guess_unit(name, &mesh);
        Ok(Self { name: name.to_owned(), mesh: Arc::new(mesh), unit, reason })
    }

    /// The object, in a unit.
    ///
    /// # Errors
    /// A sentence when it would not fit on a table.
    pub fn object(&self, unit: MeshUnit) -> Result<Arc<HouseholdObject>, String> {
        let source = format!("{}, in {}", self.name, unit.symbol());
        let object = HouseholdObject::of_mesh(&self.name, &self.mesh, unit.metres(), &source);
        object.map(Arc::new).map_err(|error| error.to_string())
    }

    /// Edges of its bounding box in a unit, metres.
    pub fn edges_m(&self, unit: MeshUnit) -> Vector3<f64> {
        let positions = &self.mesh.positions;
        let first = positions.first().map_or_else(Vector3::zeros, |p| p.coords);
        let (least, most) =
            positions.iter().fold((first, first), |(least, most), p| (least.inf(&p.coords), most.sup(&p.coords)));
        (most - least) * unit.metres()
    }
}

/// A scene with one object alone on its table, in front of the acting arm, to be moved 20 cm outwards.
pub fn alone(scene: &Scene, object: &Arc<HouseholdObject>) -> Scene {
    assets::library().bring(object);
    let side = if scene.arm.name() == "left" { 1.0 } else { -1.0 };
    let table = &scene.table;
    let edge = table.center_m[0] - 0.5 * table.size_m[0];
    let height = table.height_m + object.half_extents().z + ABOVE_M;
    let X_WO = Isometry3::translation(edge + BEHIND_EDGE_M, side * ASIDE_M, height);
    let X_WO_goal = Isometry3::translation(edge + BEHIND_EDGE_M, side * (ASIDE_M + MOVED_M), height);
    Scene {
        name: object.name.clone(),
        title: object.title.clone(),
        summary: object.source.clone(),
        objects: vec![PlacedObject { object: object.name.clone(), X_WO }],
        obstacles: Vec::new(),
        task: Task::place(0, X_WO_goal),
        handover: None,
        ..scene.clone()
    }
}
