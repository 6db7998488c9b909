//! The robots and objects that the program knows, read once from the files that travel inside it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use nalgebra::{Isometry3, Translation3};

use crate::guest::{BuiltGuest, GuestError, GuestRobot};
use crate::handover::{Agent, Handover, PERSON, guarded};
use crate::object::{HouseholdObject, ObjectError};
use crate::reach::{ForwardSettings, ReachError, ReachMap, build_forward};
use crate::robot::{HandDescription, HandError, MissingMesh, Robot, RobotError, load_robot};
use crate::scene::Scene;
use crate::watch::Watch;

/// Gives the content of a file by its path inside the repository: `robots/alita/alita.urdf`.
pub type ReadFile = dyn Fn(&str) -> Option<&'static [u8]> + Send + Sync;

/// Samples of a map for handovers: enough for where hands can meet.
const MAP_SAMPLES: usize = 500_000;
/// Between what somebody stands on and its feet, metres: they do not count as touching.
const STANDING_GAP_M: f64 = 0.002;

/// Robots and objects by name; each is read when it is first asked for and kept.
pub struct Library {
    read: Box<ReadFile>,
    robots: Mutex<BTreeMap<String, Arc<Robot>>>,
    /// Robots that people brought, by their names in scenes; each is among `robots` as well.
    guests: Mutex<BTreeMap<String, Arc<Guest>>>,
    objects: Mutex<BTreeMap<String, Arc<HouseholdObject>>>,
    /// The robot with another hand that was asked for last: robot, arm, hand.
    handed: Mutex<Option<Handed>>,
    /// Reachability maps by robot and arm.
    maps: Mutex<BTreeMap<(String, String), ReachMap>>,
    /// Giver and receiver as one robot, as they were asked for last.
    together: Mutex<Option<(Together, Arc<Robot>)>>,
}

/// A robot that somebody brought, and what there is to say of it.
#[derive(Clone, Debug)]
pub struct Guest {
    /// Its files and what was chosen for it.
    pub robot: Arc<GuestRobot>,
    /// What was left out or repaired.
    pub notes: Vec<String>,
    /// Bodies for which marked boxes stand.
    pub missing: Vec<MissingMesh>,
}

type Handed = (String, &'static str, HandDescription, Arc<Robot>);

/// What giver and receiver as one robot are made of: the giver, and who stands where in which posture.
struct Together {
    giver: Arc<Robot>,
    model: String,
    posture: String,
    X_WA: Isometry3<f64>,
    floor_m: f64,
}

/// Why the library cannot give something.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// No such robot or object.
    #[error("there is no {kind} named {name:?}")]
    Unknown { kind: &'static str, name: String },
    /// An object that somebody brought, but not here.
    #[error("the object {title:?} of this scene is not part of the program: bring its mesh")]
    ObjectAway { title: String },
    /// A robot that somebody brought, but not here.
    #[error("the robot {title:?} of this scene is not part of the program: bring its URDF with its meshes")]
    GuestAway { title: String },
    /// The files of a robot that somebody brought are wrong.
    #[error("robot {title:?}: {source}")]
    Guest { title: String, source: Box<GuestError> },
    /// A robot's files are wrong.
    #[error("robot {name:?}: {source}")]
    Robot { name: String, source: RobotError },
    /// An object's file is wrong.
    #[error("object {name:?}: {source}")]
    Object { name: String, source: ObjectError },
    /// A robot has no such posture.
    #[error("{robot} has no posture {posture:?}")]
    NoPosture { robot: String, posture: String },
    /// A robot has no such arm.
    #[error("{robot} has no {arm} arm")]
    NoArm { robot: String, arm: String },
    /// A reachability map cannot be built.
    #[error("map of the {arm} arm of {robot}: {source}")]
    Map { robot: String, arm: String, source: ReachError },
    /// A hand of the user's own cannot be attached.
    #[error("hand {name:?}: {source}")]
    Hand { name: String, source: HandError },
}

impl Library {
    /// A library over files.
    pub fn new(read: Box<ReadFile>) -> Self {
        Self {
            read,
            robots: Mutex::default(),
            guests: Mutex::default(),
            objects: Mutex::default(),
            handed: Mutex::default(),
            maps: Mutex::default(),
            together: Mutex::default(),
        }
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
        if GuestRobot::title_of(name) != name {
            return Err(LibraryError::GuestAway { title: GuestRobot::title_of(name).to_owned() });
        }
        let urdf = self.text("robot", name, &format!("robots/{name}/{name}.urdf"))?;
        let srdf = self.text("robot", name, &format!("robots/{name}/{name}.srdf"))?;
        let loaded = load_robot(&urdf, &srdf, &|uri: &str| self.mesh(uri))
            .map_err(|source| LibraryError::Robot { name: name.to_owned(), source })?;
        let robot = Arc::new(loaded.value);
        lock(&self.robots).insert(name.to_owned(), robot.clone());
        Ok(robot)
    }

    /// Takes in a robot that somebody brought; gives its name in scenes. One that is here already is not made again.
    ///
    /// # Errors
    /// [`LibraryError::Guest`] when its files do not make a robot.
    pub fn welcome(&self, robot: &Arc<GuestRobot>) -> Result<String, LibraryError> {
        let name = robot.name();
        if lock(&self.guests).contains_key(&name) {
            return Ok(name);
        }
        let failed = |source| LibraryError::Guest { title: robot.title().to_owned(), source: Box::new(source) };
        let BuiltGuest { robot: built, notes, missing } = robot.build(&|uri: &str| self.mesh(uri)).map_err(failed)?;
        lock(&self.robots).insert(name.clone(), Arc::new(built));
        lock(&self.guests).insert(name.clone(), Arc::new(Guest { robot: robot.clone(), notes, missing }));
        Ok(name)
    }

    /// The robot of this name that somebody brought; `None` for one of the program's own.
    pub fn guest(&self, name: &str) -> Option<Arc<Guest>> {
        lock(&self.guests).get(name).cloned()
    }

    /// The reachability map by which places for handovers are found: built by forward sampling when it is first asked
    /// for, in a fraction of a second, and so the same wherever the program runs.
    ///
    /// # Errors
    /// [`LibraryError`] when there is no such robot or arm, or its map cannot be built.
    pub fn reach_map(&self, name: &str, arm: &str) -> Result<ReachMap, LibraryError> {
        let key = (name.to_owned(), arm.to_owned());
        if let Some(map) = lock(&self.maps).get(&key) {
            return Ok(map.clone());
        }
        let robot = self.robot(name)?;
        let no_arm = || LibraryError::NoArm { robot: name.to_owned(), arm: arm.to_owned() };
        let index = robot.arms.iter().position(|found| found.name == arm).ok_or_else(no_arm)?;
        let settings = ForwardSettings { samples: MAP_SAMPLES, ..ForwardSettings::default() };
        let map = build_forward(&robot, index, &settings, Watch::idle()).map_err(|source| LibraryError::Map {
            robot: name.to_owned(),
            arm: arm.to_owned(),
            source,
        })?;
        lock(&self.maps).insert(key, map.clone());
        Ok(map)
    }

    /// The robot of a scene: with the scene's own hand at the acting arm, if it has one, and together with the receiver of
    /// a handover, if that is somebody else. The receiver's names begin with its model's: `hubo_left`.
    ///
    /// # Errors
    /// [`LibraryError`] when there is no such robot, its files are wrong, or the hand cannot be attached.
    pub fn robot_of(&self, scene: &Scene) -> Result<Arc<Robot>, LibraryError> {
        let robot = self.giver_of(scene)?;
        let Some(agent) = scene.handover.as_ref().and_then(Handover::agent) else { return Ok(robot) };
        let Agent { model, posture, floor_m, .. } = agent;
        let wanted = Together {
            giver: robot.clone(),
            model: model.clone(),
            posture: posture.clone(),
            X_WA: agent.X_WA(),
            floor_m: *floor_m,
        };
        let mut together = lock(&self.together);
        if let Some((_, robot)) = together.as_ref().filter(|(known, _)| known.is_same(&wanted)) {
            return Ok(robot.clone());
        }
        let other = self.robot(model)?;
        let no_posture = || LibraryError::NoPosture { robot: model.clone(), posture: posture.clone() };
        let q = other.posture(posture).ok_or_else(no_posture)?;
        let height_m = floor_m + other.standing_height_m(q) + STANDING_GAP_M;
        let X_WR = wanted.X_WA * Translation3::new(0.0, 0.0, height_m);
        // A person has a space about head and body that the giver stays out of.
        let guarded_person = (model == PERSON).then(|| guarded(&other));
        let both = Arc::new(robot.beside(guarded_person.as_ref().unwrap_or(&other), q, model, &X_WR));
        *together = Some((wanted, both.clone()));
        Ok(both)
    }

    /// The robot of a scene alone.
    fn giver_of(&self, scene: &Scene) -> Result<Arc<Robot>, LibraryError> {
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

    /// A description of a hand in `robots/hands/`.
    ///
    /// # Errors
    /// [`LibraryError`] when there is none, or it is wrong.
    pub fn hand(&self, name: &str) -> Result<HandDescription, LibraryError> {
        let json = self.text("hand", name, &format!("robots/hands/{name}.json"))?;
        HandDescription::parse(&json).map_err(|source| LibraryError::Hand { name: name.to_owned(), source })
    }

    /// Bytes of a mesh that travels inside the program.
    pub fn mesh(&self, uri: &str) -> Option<Vec<u8>> {
        let path = uri.strip_prefix("package://endcomfort/").unwrap_or(uri);
        (self.read)(path).map(<[u8]>::to_vec)
    }

    /// Takes in an object that somebody brought, under its name in scenes.
    pub fn bring(&self, object: &Arc<HouseholdObject>) {
        lock(&self.objects).insert(object.name.clone(), object.clone());
    }

    /// The objects of a scene that somebody brought, each once.
    pub fn brought(&self, scene: &Scene) -> Vec<Arc<HouseholdObject>> {
        let mut names: Vec<&str> = scene.objects.iter().map(|placed| placed.object.as_str()).collect();
        names.retain(|name| HouseholdObject::is_brought(name));
        names.sort_unstable();
        names.dedup();
        names.iter().filter_map(|name| self.object(name).ok()).collect()
    }

    /// The household object of this name.
    ///
    /// # Errors
    /// [`LibraryError`] when there is none, or its file is wrong.
    pub fn object(&self, name: &str) -> Result<Arc<HouseholdObject>, LibraryError> {
        if let Some(object) = lock(&self.objects).get(name) {
            return Ok(object.clone());
        }
        if HouseholdObject::is_brought(name) {
            return Err(LibraryError::ObjectAway { title: GuestRobot::title_of(name).to_owned() });
        }
        let json = self.text("object", name, &format!("objects/{name}.json"))?;
        let object =
            HouseholdObject::parse(&json).map_err(|source| LibraryError::Object { name: name.to_owned(), source })?;
        let object = Arc::new(object);
        lock(&self.objects).insert(name.to_owned(), object.clone());
        Ok(object)
    }
}

impl Together {
    fn is_same(&self, other: &Self) -> bool {
        let Self { giver, model, posture, X_WA, floor_m } = other;
        Arc::ptr_eq(&self.giver, giver)
            && (&self.model, &self.posture) == (model, posture)
            && self.X_WA == *X_WA
            && self.floor_m == *floor_m
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
