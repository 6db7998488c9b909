//! What a link and a session hold, and the way there and back.

use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use endcomfort_core::guest::GuestRobot;
use endcomfort_core::job::{DroppedCloud, SetShape};
use endcomfort_core::object::HouseholdObject;
use endcomfort_core::scene::{Scene, SceneError};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{ShareError, SharedView, packing, patch};
use crate::assets;
use crate::render::Camera;
use crate::viewer::{Demo, Document, ViewerState};

/// Version of links and sessions that this program writes and reads.
const VERSION: u32 = 1;
/// The key that says the version of a link.
const LINK_KEY: &str = "version";
/// The key that says the version of a session, and that a file is one.
const SESSION_KEY: &str = "endcomfort_session";
/// What a link's payload follows in an address.
const MARK: &str = "#s=";
/// Chat programs and mail cut addresses somewhere beyond this, characters.
pub(super) const LONG_LINK: usize = 8000;

/// A link or a session that was read: nothing in it can be wrong any more.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// What is asked for.
    pub document: Document,
    /// The demo that it began as.
    pub demo: Option<String>,
    /// How it is looked at.
    pub view: SharedView,
}

/// What is written. A scene is a demo's name, with what differs from it, or stands there as a whole.
#[derive(Serialize, Deserialize)]
struct Content {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    demo: Option<String>,
    /// Merge patch (RFC 7396) from the demo's scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    changes: Option<Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scene: Option<Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cloud: Option<Cloud>,
    /// The scene's robot, if somebody brought it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    robot: Option<GuestRobot>,
    /// Those of its objects that somebody brought.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    objects: Vec<HouseholdObject>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cluster: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    grasp: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shape: Option<SetShape>,
    #[serde(default)]
    view: SharedView,
}

/// A file that was dropped.
#[derive(Serialize, Deserialize)]
struct Cloud {
    name: String,
    base64: String,
}

/// The text after the page's address, `#s=…`. A dropped cloud is not in it, nor what was chosen in that cloud.
///
/// # Errors
/// [`ShareError::Format`] if the scene cannot be written as JSON.
pub fn link_text(state: &ViewerState, camera: Option<Camera>) -> Result<String, ShareError> {
    let document = &state.document;
    let scene = json(&*document.scene)?;
    let mut content = Content::of(state, camera);
    if document.cloud.is_some() {
        (content.cluster, content.grasp, content.shape) = (None, None, None);
        (content.view.cluster, content.view.grasp) = (None, None);
    }
    // A cloud is dropped onto some demo's table.
    let by_scene = || state.demos.iter().find(|demo| demo.scene.name == document.scene.name);
    let demo = state.demo.as_deref().and_then(|name| state.demo_named(name)).or_else(by_scene);
    let difference = match demo {
        Some(demo) => patch::difference(&json(&*demo.scene)?, &scene).map(|changes| (demo.name.clone(), changes)),
        None => None,
    };
    match difference {
        Some((name, changes)) => {
            let is_untouched = changes.as_object().is_some_and(serde_json::Map::is_empty);
            (content.demo, content.changes) = (Some(name), (!is_untouched).then_some(changes));
        }
        None => content.scene = Some(scene),
    }
    Ok(format!("{MARK}{}", packing::pack(&written(LINK_KEY, &content)?.to_string())))
}

/// A session as JSON: the whole scene, and the bytes of a dropped cloud if they are wanted.
///
/// # Errors
/// [`ShareError::Format`] if the scene cannot be written as JSON.
pub fn session_text(state: &ViewerState, camera: Option<Camera>, with_cloud: bool) -> Result<String, ShareError> {
    Ok(session_json(state, camera, with_cloud)?.to_string())
}

pub(super) fn session_json(state: &ViewerState, camera: Option<Camera>, with_cloud: bool) -> Result<Value, ShareError> {
    let scene = Some(json(&*state.document.scene)?);
    let mut content = Content { demo: state.demo.clone(), scene, ..Content::of(state, camera) };
    if with_cloud {
        let library = assets::library();
        let scene = &state.document.scene;
        content.robot = library.guest(&scene.robot).map(|guest| (*guest.robot).clone());
        content.objects = library.brought(scene).iter().map(|object| (**object).clone()).collect();
    }
    if let Some(cloud) = &state.document.cloud {
        if with_cloud {
            content.cloud = Some(Cloud { name: cloud.name.clone(), base64: STANDARD.encode(&cloud.bytes) });
        } else {
            (content.cluster, content.grasp, content.shape) = (None, None, None);
        }
    }
    written(SESSION_KEY, &content)
}

/// How many bytes of files a session of this state holds: a cloud, a robot's meshes, objects.
pub(super) fn brought_bytes(state: &ViewerState) -> usize {
    let (document, library) = (&state.document, assets::library());
    let cloud = document.cloud.as_ref().map_or(0, |cloud| cloud.bytes.len());
    let robot = library.guest(&document.scene.robot).map_or(0, |guest| {
        let meshes: usize = guest.robot.meshes.values().map(|mesh| mesh.0.len()).sum();
        meshes + guest.robot.urdf.len()
    });
    // A corner takes some thirty characters as text, a triangle some twenty.
    let objects = library.brought(&document.scene);
    let objects = objects.iter().map(|object| 50 * object.mesh().triangles.len());
    cloud + robot + objects.sum::<usize>()
}

/// Reads a link: an address with `#s=…` in it, that part alone, or what follows it.
///
/// # Errors
/// [`ShareError`] says what is wrong with it.
pub fn read_link(text: &str, demos: &[Demo]) -> Result<Opened, ShareError> {
    let text = text.trim();
    let packed = text.split_once(MARK).map_or(text, |(_address, packed)| packed);
    let json = serde_json::from_str(&packing::unpack(packed)?).map_err(format_error)?;
    Content::read(json, LINK_KEY)?.opened(demos)
}

/// Reads a session's JSON.
///
/// # Errors
/// [`ShareError`] says what is wrong with it.
pub fn read_session(json: Value, demos: &[Demo]) -> Result<Opened, ShareError> {
    Content::read(json, SESSION_KEY)?.opened(demos)
}

/// Whether JSON is meant as a session, as opposed to a scene.
pub(in crate::viewer) fn is_session(json: &Value) -> bool {
    json.get(SESSION_KEY).is_some()
}

impl Content {
    fn of(state: &ViewerState, camera: Option<Camera>) -> Self {
        let document = &state.document;
        Self {
            demo: None,
            changes: None,
            scene: None,
            cloud: None,
            robot: None,
            objects: Vec::new(),
            cluster: document.cluster,
            grasp: document.grasp,
            shape: document.shape,
            view: SharedView::of(state, camera),
        }
    }

    fn read(json: Value, key: &str) -> Result<Self, ShareError> {
        let version = json.get(key).unwrap_or(&Value::Null);
        if *version != VERSION {
            return Err(ShareError::Version { found: version.to_string(), wanted: VERSION });
        }
        serde_json::from_value(json).map_err(format_error)
    }

    fn opened(mut self, demos: &[Demo]) -> Result<Opened, ShareError> {
        // From here on the program knows them.
        for object in std::mem::take(&mut self.objects) {
            let object = HouseholdObject::parse(&json(&object)?.to_string());
            let object = object.map_err(|error| ShareError::Format { reason: error.to_string() })?;
            assets::library().bring(&Arc::new(object));
        }
        if let Some(robot) = self.robot.take() {
            let welcome = assets::library().welcome(&Arc::new(robot));
            welcome.map_err(|error| ShareError::Format { reason: error.to_string() })?;
        }
        let scene = match (self.scene, &self.demo) {
            (Some(scene), _) => scene_of(scene)?,
            (None, Some(name)) => {
                let known = || demos.iter().map(|demo| demo.name.clone()).collect();
                let demo = demos.iter().find(|demo| demo.name == *name);
                let demo = demo.ok_or_else(|| ShareError::Demo { name: name.clone(), known: known() })?;
                match &self.changes {
                    None => demo.scene.clone(),
                    Some(changes) => scene_of(patch::merged(&json(&*demo.scene)?, changes))?,
                }
            }
            (None, None) => return Err(ShareError::Nothing),
        };
        let cloud = self.cloud.map(|cloud| {
            let bytes = STANDARD.decode(&cloud.base64);
            let bytes = bytes.map_err(|error| ShareError::Format { reason: format!("{}: {error}", cloud.name) })?;
            Ok::<_, ShareError>(Arc::new(DroppedCloud { name: cloud.name, bytes }))
        });
        let document = Document {
            cloud: cloud.transpose()?,
            cluster: self.cluster,
            grasp: self.grasp,
            shape: self.shape,
            ..Document::new(scene)
        };
        // A session may come from a program with demos that this one lacks: its scene is whole, so nothing is missing.
        let demo = self.demo.filter(|name| document.cloud.is_none() && demos.iter().any(|demo| demo.name == *name));
        Ok(Opened { document, demo, view: self.view.checked()? })
    }
}

fn scene_of(json: Value) -> Result<Arc<Scene>, ShareError> {
    let scene: Scene =
        serde_json::from_value(json).map_err(|error| SceneError::Format { reason: error.to_string() })?;
    Ok(Arc::new(scene.checked()?))
}

fn json(value: &impl Serialize) -> Result<Value, ShareError> {
    serde_json::to_value(value).map_err(format_error)
}

/// The content as JSON under its version.
fn written(key: &str, content: &Content) -> Result<Value, ShareError> {
    let mut json = json(content)?;
    if let Some(fields) = json.as_object_mut() {
        fields.insert(key.to_owned(), VERSION.into());
    }
    Ok(json)
}

fn format_error(error: serde_json::Error) -> ShareError {
    ShareError::Format { reason: error.to_string() }
}
