//! What stands in the scene, moved, added and taken away by hand: objects, boxes in the way, the camera.

use std::sync::Arc;

use endcomfort_core::scene::{MAX_THINGS, Obstacle, PlacedObject, Scene, Task};
use nalgebra::{Isometry3, Translation3, Vector3};

use endcomfort_core::job::Stage;

use super::goal_drag::FARTHEST_M;
use super::state::Step;
use super::{Effect, ViewerState};
use crate::assets;

/// Edges of a new box, metres.
const NEW_BOX_M: [f64; 3] = [0.10, 0.10, 0.15];
/// Shortest and longest edge of a box, metres.
pub(super) const EDGE_M: [f64; 2] = [0.005, 3.0];
/// How far from other things a new one stands, metres.
const APART_M: f64 = 0.17;
/// What stands on the table hovers this far above it, metres: rests are no collisions.
const ABOVE_M: f64 = 0.001;

/// Something that stands in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thing {
    /// An object on the table, by its index.
    Object(usize),
    /// A box in the way, by its index.
    Obstacle(usize),
    /// The depth camera.
    Camera,
}

/// What a person does with the things of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceCommand {
    /// Selects a thing.
    Select(Option<Thing>),
    /// Selects what the points of a cluster were measured on.
    SelectCluster(usize),
    /// Moves a thing while it is dragged.
    Drag(Thing, Isometry3<f64>),
    /// It has been let go.
    EndDrag,
    /// Puts a thing somewhere.
    Put(Thing, Isometry3<f64>),
    /// Gives a box other edges, metres.
    Resize(usize, Vector3<f64>),
    /// Adds an object of this name.
    AddObject(String),
    /// Adds a box.
    AddBox,
    /// Adds another one beside it.
    Duplicate(Thing),
    /// Takes it away.
    Remove(Thing),
    /// The task is about this object from now on.
    Grasp(usize),
}

impl Thing {
    /// Its pose in a scene.
    pub(super) fn pose(self, scene: &Scene) -> Option<Isometry3<f64>> {
        match self {
            Self::Object(index) => scene.objects.get(index).map(|placed| placed.X_WO),
            Self::Obstacle(index) => scene.obstacles.get(index).map(|obstacle| obstacle.X_WB),
            Self::Camera => Some(scene.X_WC),
        }
    }

    fn put(self, scene: &mut Scene, X_WT: Isometry3<f64>) {
        let place = match self {
            Self::Object(index) => scene.objects.get_mut(index).map(|placed| &mut placed.X_WO),
            Self::Obstacle(index) => scene.obstacles.get_mut(index).map(|obstacle| &mut obstacle.X_WB),
            Self::Camera => Some(&mut scene.X_WC),
        };
        if let Some(place) = place {
            *place = X_WT;
        }
    }
}

impl ViewerState {
    /// The selected thing, while the inspector shows the scene.
    pub fn selected_thing(&self) -> Option<Thing> {
        let thing = self.placing?;
        let is_shown = self.selection.step == Step::Stage(Stage::Scene);
        (is_shown && self.has_thing(thing)).then_some(thing)
    }

    /// Whether a click on an object selects it to be moved, and not to be examined.
    pub(super) fn selects_things(&self) -> bool {
        self.selection.step == Step::Stage(Stage::Scene) && self.document.cloud.is_none() && self.outputs.fit.is_some()
    }

    /// Whether a thing is in the scene: of a dropped cloud, objects and camera are not ours to move.
    fn has_thing(&self, thing: Thing) -> bool {
        let is_simulated = self.document.cloud.is_none() || matches!(thing, Thing::Obstacle(_));
        is_simulated && thing.pose(&self.document.scene).is_some()
    }

    /// The object that a cluster was measured on.
    fn object_of(&self, cluster: usize) -> Option<usize> {
        let fits = self.outputs.fit.as_ref()?;
        let fit = fits.fits.get(cluster)?.as_ref().ok()?;
        let placed = self.document.scene.object_at(&fit.superquadric.X_FS)?;
        self.document.scene.objects.iter().position(|other| std::ptr::eq(other, placed))
    }

    pub(super) fn apply_place(&mut self, command: PlaceCommand) -> Vec<Effect> {
        match command {
            PlaceCommand::Select(thing) => {
                self.placing = thing;
                Vec::new()
            }
            PlaceCommand::SelectCluster(cluster) => {
                self.placing = self.object_of(cluster).map(Thing::Object);
                self.selection.cluster = Some(cluster);
                Vec::new()
            }
            PlaceCommand::Drag(thing, X_WT)
                if self.has_thing(thing) && X_WT.translation.vector.amax() <= FARTHEST_M =>
            {
                self.drag_what_is_seen(|scene| thing.put(scene, X_WT))
            }
            PlaceCommand::Drag(..) => Vec::new(),
            PlaceCommand::EndDrag => self.end_goal_drag(),
            PlaceCommand::Put(thing, X_WT) => self.rearrange(|scene| thing.put(scene, X_WT)),
            PlaceCommand::Resize(index, size_m) => self.rearrange(|scene| {
                if let Some(obstacle) = scene.obstacles.get_mut(index) {
                    // It goes on standing on what it stands on.
                    let rise = 0.5 * (size_m.z - obstacle.size_m.z);
                    obstacle.X_WB.translation.vector.z += rise;
                    obstacle.size_m = size_m;
                }
            }),
            PlaceCommand::AddObject(name) => self.add_object(name),
            PlaceCommand::AddBox => self.add_box(),
            PlaceCommand::Duplicate(thing) => self.duplicate(thing),
            PlaceCommand::Remove(thing) => self.remove(thing),
            PlaceCommand::Grasp(object) => self.rearrange(|scene| scene.task = Task { object, ..scene.task.clone() }),
        }
    }

    /// Changes what stands in the scene, as one step of undo.
    fn rearrange(&mut self, change: impl FnOnce(&mut Scene)) -> Vec<Effect> {
        let mut scene = (*self.document.scene).clone();
        change(&mut scene);
        match scene.checked() {
            Ok(scene) => self.edit(|document| {
                document.scene = Arc::new(scene);
                // Other points, other clusters, other candidates.
                (document.cluster, document.grasp, document.shape) = (None, None, None);
            }),
            Err(error) => {
                let sentence = format!("That cannot be: {error}. The scene is as it was.");
                self.say(true, sentence.clone(), Vec::new());
                vec![Effect::Announce(sentence)]
            }
        }
    }

    fn add_object(&mut self, name: String) -> Vec<Effect> {
        let object = match assets::library().object(&name) {
            Ok(object) => object,
            Err(error) => {
                self.say(true, format!("{error}."), Vec::new());
                return Vec::new();
            }
        };
        let place = Translation3::from(self.free_place(object.half_extents().z + ABOVE_M));
        let placed = PlacedObject { object: name, X_WO: Isometry3::from_parts(place, nalgebra::one()) };
        let index = self.document.scene.objects.len();
        self.add(Thing::Object(index), |scene| scene.objects.push(placed))
    }

    fn add_box(&mut self) -> Vec<Effect> {
        let size_m = Vector3::from(NEW_BOX_M);
        let X_WB = Isometry3::from_parts(self.free_place(0.5 * size_m.z + ABOVE_M).into(), nalgebra::one());
        let index = self.document.scene.obstacles.len();
        let name = self.new_name("box");
        self.add(Thing::Obstacle(index), |scene| scene.obstacles.push(Obstacle { name, size_m, X_WB }))
    }

    fn duplicate(&mut self, thing: Thing) -> Vec<Effect> {
        let scene = &self.document.scene;
        let Some(X_WT) = thing.pose(scene) else { return Vec::new() };
        let place = self.free_place(X_WT.translation.z - scene.table.height_m);
        let X_WT = Isometry3::from_parts(place.into(), X_WT.rotation);
        match thing {
            Thing::Object(index) => {
                let copy = PlacedObject { X_WO: X_WT, ..scene.objects[index].clone() };
                self.add(Thing::Object(scene.objects.len()), |scene| scene.objects.push(copy))
            }
            Thing::Obstacle(index) => {
                let name = self.new_name(&scene.obstacles[index].name);
                let copy = Obstacle { name, X_WB: X_WT, ..scene.obstacles[index].clone() };
                self.add(Thing::Obstacle(scene.obstacles.len()), |scene| scene.obstacles.push(copy))
            }
            Thing::Camera => Vec::new(),
        }
    }

    fn add(&mut self, thing: Thing, change: impl FnOnce(&mut Scene)) -> Vec<Effect> {
        let effects = self.rearrange(change);
        self.placing = Some(thing);
        effects
    }

    fn remove(&mut self, thing: Thing) -> Vec<Effect> {
        let scene = &self.document.scene;
        match thing {
            Thing::Object(_) if scene.objects.len() == 1 => {
                self.say(true, "The last object stays: without one there is nothing to grasp.", Vec::new());
                return Vec::new();
            }
            Thing::Object(index) if index >= scene.objects.len() => return Vec::new(),
            Thing::Obstacle(index) if index >= scene.obstacles.len() => return Vec::new(),
            Thing::Camera => return Vec::new(),
            Thing::Object(_) | Thing::Obstacle(_) => {}
        }
        self.placing = None;
        self.rearrange(|scene| match thing {
            Thing::Object(index) => {
                scene.objects.remove(index);
                let object = &mut scene.task.object;
                // What was about the removed object is about the first one then.
                *object = if *object == index { 0 } else { *object - usize::from(*object > index) };
            }
            Thing::Obstacle(index) => {
                scene.obstacles.remove(index);
            }
            Thing::Camera => {}
        })
    }

    /// A place on the table with room around it, nearest to the table's middle, so high above it; the middle if the table
    /// is full.
    fn free_place(&self, above_m: f64) -> Vector3<f64> {
        let scene = &self.document.scene;
        let table = &scene.table;
        let objects = scene.objects.iter().map(|placed| placed.X_WO.translation.vector.xy());
        let boxes = scene.obstacles.iter().map(|obstacle| obstacle.X_WB.translation.vector.xy());
        let taken: Vec<_> = objects.chain(boxes).collect();
        let center = nalgebra::Vector2::from(table.center_m);
        let step = 0.5 * APART_M;
        let [columns, rows] = table.size_m.map(|size| ((0.5 * size - 0.08).max(0.0) / step) as i32);
        let grid = (-columns..=columns).flat_map(|i| (-rows..=rows).map(move |j| (i, j)));
        let mut places: Vec<_> =
            grid.map(|(i, j)| center + step * nalgebra::Vector2::new(f64::from(i), f64::from(j))).collect();
        places.sort_by(|l, r| (l - center).norm().total_cmp(&(r - center).norm()));
        let has_room = |place: &nalgebra::Vector2<f64>| taken.iter().all(|other| (other - place).norm() >= APART_M);
        let place = places.iter().copied().find(has_room).unwrap_or(center);
        Vector3::new(place.x, place.y, table.height_m + above_m)
    }

    /// `box`, `box 2`, …: what no other box is called.
    fn new_name(&self, like: &str) -> String {
        let stem = like.trim_end_matches(|letter: char| letter.is_ascii_digit()).trim_end();
        let is_free = |name: &String| self.document.scene.obstacles.iter().all(|other| other.name != *name);
        let numbered = |number: usize| if number == 1 { stem.to_owned() } else { format!("{stem} {number}") };
        (1..=MAX_THINGS + 1).map(numbered).find(is_free).unwrap_or_else(|| stem.to_owned())
    }
}
