//! The robots and objects that the program knows, read once from the files that travel inside it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::object::{HouseholdObject, ObjectError};
use crate::robot::{Robot, RobotError, load_robot};

/// Gives the content of a file by its path inside the repository: `robots/alita/alita.urdf`.
pub type ReadFile = dyn Fn(&str) -> Option<&'static [u8]> + Send + Sync;

/// Robots and objects by name; each is read when it is first asked for and kept.
pub struct Library {
    read: Box<ReadFile>,
    robots: Mutex<BTreeMap<String, Arc<Robot>>>,
    objects: Mutex<BTreeMap<String, Arc<HouseholdObject>>>,
}

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
}

impl Library {
    /// A library over files.
    pub fn new(read: Box<ReadFile>) -> Self {
        Self { read, robots: Mutex::default(), objects: Mutex::default() }
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
        let resolve = |uri: &str| {
            let path = uri.strip_prefix("package://endcomfort/").unwrap_or(uri);
            (self.read)(path).map(<[u8]>::to_vec)
        };
        let loaded = load_robot(&urdf, &srdf, &resolve)
            .map_err(|source| LibraryError::Robot { name: name.to_owned(), source })?;
        let robot = Arc::new(loaded.value);
        lock(&self.robots).insert(name.to_owned(), robot.clone());
        Ok(robot)
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
