//! The robots and objects that the program knows, read once from the files that travel inside it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::object::{HouseholdObject, ObjectError};
use crate::robot::{HandDescription, HandError, Robot, RobotError, load_robot};
use crate::scene::Scene;

/// Gives the content of a file by its path inside the repository: `robots/alita/alita.urdf`.
pub type ReadFile = dyn Fn(&str) -> Option<&'static [u8]> + Send + Sync;

/// Robots and objects by name; each is read when it is first asked for and kept.
pub struct Library {
    read: Box<ReadFile>,
    robots: Mutex<BTreeMap<String, Arc<Robot>>>,
    objects: Mutex<BTreeMap<String, Arc<HouseholdObject>>>,
    /// The robot with another hand that was asked for last: robot, arm, hand.
    handed: Mutex<Option<Handed>>,
}

type Handed = (String, &'static str, HandDescription, Arc<Robot>);

/// Why the library cannot give something.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// No such robot or object.
    #[error("there is no {kind} named {name:?}")]
    Unknown { kind: &'static str, name: String },
    /// A robot's files are wrong.
    #[error("robot {name:?}: {source}")]
    Robot { name: String, source: RobotError },
    /// An object's file is wrong.
    #[error("object {name:?}: {source}")]
    Object { name: String, source: ObjectError },
    /// A hand of the user's own cannot be attached.
    #[error("hand {name:?}: {source}")]
    Hand { name: String, source: HandError },
}

impl Library {
    /// A library over files.
    pub fn new(read: Box<ReadFile>) -> Self {
        Self { read, robots: Mutex::default(), objects: Mutex::default(), handed: Mutex::default() }
    }

    fn text(&self, kind: &'static str, name: &str, path: &str) -> Result<String, LibraryError> {
        let bytes = (self.read)(path).ok_or_else(|| LibraryError::Unknown { kind, name: name.to_owned() })?;
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    /// The robot of this name.
    ///
    /// # Errors
    /// [`LibraryError`] when there is none, or its files are wrong.
    pub fn robot(&self, name: &str) -> Result<Arc<Robot>, LibraryError> {
        if let Some(robot) = lock(&self.robots).get(name) {
            return Ok(robot.clone());
        }
        let urdf = self.text("robot", name, &format!("robots/{name}/{name}.urdf"))?;
        let srdf = self.text("robot", name, &format!("robots/{name}/{name}.srdf"))?;
        let loaded = load_robot(&urdf, &srdf, &|uri: &str| self.mesh(uri))
            .map_err(|source| LibraryError::Robot { name: name.to_owned(), source })?;
        let robot = Arc::new(loaded.value);
        lock(&self.robots).insert(name.to_owned(), robot.clone());
        Ok(robot)
    }

    /// The robot of a scene: with the scene's own hand at the acting arm, if it has one.
    ///
    /// # Errors
    /// [`LibraryError`] when there is no such robot, its files are wrong, or the hand cannot be attached.
    pub fn robot_of(&self, scene: &Scene) -> Result<Arc<Robot>, LibraryError> {
        let robot = self.robot(&scene.robot)?;
        let Some(hand) = &scene.hand else { return Ok(robot) };
        let arm = scene.arm.name();
        let mut handed = lock(&self.handed);
        match &*handed {
            Some((of, at, known, robot)) if *of == scene.robot && *at == arm && known == hand => Ok(robot.clone()),
            _ => {
                let loaded = robot
                    .with_hand(arm, hand, &|uri: &str| self.mesh(uri))
                    .map_err(|source| LibraryError::Hand { name: hand.name.clone(), source })?;
                let robot = Arc::new(loaded.value);
                *handed = Some((scene.robot.clone(), arm, hand.clone(), robot.clone()));
                Ok(robot)
            }
        }
    }

    /// Bytes of a mesh that travels inside the program.
    fn mesh(&self, uri: &str) -> Option<Vec<u8>> {
        let path = uri.strip_prefix("package://endcomfort/").unwrap_or(uri);
        (self.read)(path).map(<[u8]>::to_vec)
    }

    /// The household object of this name.
    ///
    /// # Errors
    /// [`LibraryError`] when there is none, or its file is wrong.
    pub fn object(&self, name: &str) -> Result<Arc<HouseholdObject>, LibraryError> {
        if let Some(object) = lock(&self.objects).get(name) {
            return Ok(object.clone());
        }
        let json = self.text("object", name, &format!("objects/{name}.json"))?;
        let object =
            HouseholdObject::parse(&json).map_err(|source| LibraryError::Object { name: name.to_owned(), source })?;
        let object = Arc::new(object);
        lock(&self.objects).insert(name.to_owned(), object.clone());
        Ok(object)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
