//! Files that come together and are no robot: a depth image with its camera, a mesh.

use std::sync::Arc;

use endcomfort_core::cloud::Intrinsics;
use endcomfort_core::guest::Files;
use endcomfort_core::job::DroppedCloud;
use endcomfort_core::loaded::Loaded;
use endcomfort_core::mesh_file::MeshUnit;

use super::{Bringing, Command, Effect, PlaceCommand, ViewerState};
use crate::assets;
use crate::brought::{BroughtMesh, DepthImage, is_mesh, is_png};

/// Horizontal field of view of the cameras that are most common on robots, degrees.
const USUAL_VIEW_DEG: f64 = 58.0;

/// The window that asks for the field of view of a depth image.
#[derive(Clone, Debug)]
pub struct DepthWindow {
    /// The image.
    pub image: Arc<DepthImage>,
    /// Horizontal field of view, degrees.
    pub view_deg: f64,
    /// What is wrong with it.
    pub problem: Option<String>,
}

/// The window that asks what a mesh is.
#[derive(Clone, Debug)]
pub struct MeshWindow {
    /// The mesh.
    pub mesh: BroughtMesh,
    /// The unit that is taken.
    pub unit: MeshUnit,
    /// What is wrong with it.
    pub problem: Option<String>,
}

impl ViewerState {
    /// A depth image among files, with the intrinsics among them; `None` if there is no picture.
    pub(super) fn bring_depth(&mut self, files: &Files) -> Option<Vec<Effect>> {
        let path = files.paths().find(|path| files.get(path).is_some_and(is_png))?.to_owned();
        let name = path.rsplit('/').next().unwrap_or(&path).to_owned();
        let image = match DepthImage::read(&name, files.get(&path)?) {
            Ok(image) => image,
            Err(reason) => return Some(self.apply(Command::FileFailed { name, reason })),
        };
        let meant = files.paths().find_map(|path| {
            let text = String::from_utf8_lossy(files.get(path)?);
            let json = path.to_ascii_lowercase().ends_with(".json").then(|| serde_json::from_str(&text).ok())??;
            Intrinsics::is_meant_by(&json).then(|| (path.to_owned(), Intrinsics::parse(&text)))
        });
        Some(match meant {
            None => {
                let image = Arc::new(image);
                self.bringing = Some(Bringing::Depth(DepthWindow { image, view_deg: USUAL_VIEW_DEG, problem: None }));
                vec![Effect::Announce(format!("{name} came without the intrinsics of its camera."))]
            }
            Some((path, Err(error))) => self.apply(Command::FileFailed { name: path, reason: error.to_string() }),
            Some((_, Ok(camera))) => match self.open_depth(&image, &camera) {
                Ok(effects) => effects,
                Err(reason) => self.apply(Command::FileFailed { name, reason }),
            },
        })
    }

    fn open_depth(&mut self, image: &DepthImage, camera: &Loaded<Intrinsics>) -> Result<Vec<Effect>, String> {
        let DroppedCloud { name, bytes } = image.cloud(camera)?;
        for note in &camera.notes {
            self.say(false, format!("{}: {note}.", image.name), Vec::new());
        }
        Ok(self.apply(Command::OpenFile { name, bytes }))
    }

    pub(super) fn accept_depth(&mut self, window: DepthWindow) -> Vec<Effect> {
        let camera = window.image.camera_of_view(window.view_deg);
        match camera.and_then(|camera| self.open_depth(&window.image, &camera)) {
            Ok(effects) => effects,
            Err(reason) => {
                self.bringing = Some(Bringing::Depth(DepthWindow { problem: Some(reason.clone()), ..window }));
                vec![Effect::Announce(reason)]
            }
        }
    }

    /// A mesh among files; `None` if there is none.
    pub(super) fn bring_mesh(&mut self, files: &Files) -> Option<Vec<Effect>> {
        let path = files.paths().find(|path| is_mesh(path))?.to_owned();
        let name = path.rsplit('/').next().unwrap_or(&path).to_owned();
        Some(match BroughtMesh::read(&name, files.get(&path)?) {
            Ok(mesh) => {
                let unit = mesh.unit;
                let sentence = format!("{name}: {}.", mesh.reason);
                self.bringing = Some(Bringing::Mesh(MeshWindow { mesh, unit, problem: None }));
                vec![Effect::Announce(sentence)]
            }
            Err(reason) => self.apply(Command::FileFailed { name, reason }),
        })
    }

    /// Puts the mesh of the window onto the table, to be grasped or to stand in the way.
    pub(super) fn accept_mesh(&mut self, window: MeshWindow, is_grasped: bool) -> Vec<Effect> {
        let object = match window.mesh.object(window.unit) {
            Ok(object) => object,
            Err(reason) => {
                self.bringing = Some(Bringing::Mesh(MeshWindow { problem: Some(reason.clone()), ..window }));
                return vec![Effect::Announce(reason)];
            }
        };
        assets::library().bring(&object);
        if self.document.cloud.is_some() {
            let reason = "the scene is a cloud that was brought, to which nothing can be added: open a demo first";
            return self.apply(Command::FileFailed { name: window.mesh.name, reason: reason.to_owned() });
        }
        let index = self.document.scene.objects.len();
        let mut effects = self.apply(Command::Place(PlaceCommand::AddObject(object.name.clone())));
        if is_grasped && self.document.scene.objects.len() > index {
            effects.extend(self.apply(Command::Place(PlaceCommand::Grasp(index))));
        }
        effects
    }
}
