//! Reachability maps as a person sees them: which are here, how they are shown, and the voxel that is looked at.
//!
//! A stored map is fetched when it is first shown; another one is built by the worker. A voxel that was clicked is
//! chosen: the robot stands in the map's configuration for one of its orientations, and the others can be stepped
//! through, the most manipulable first.

use std::sync::Arc;

use endcomfort_core::guest::GuestRobot;
use endcomfort_core::job::{BuiltMap, MapMethod, MapRequest};
use endcomfort_core::reach::{About, ReachMap, Voxel};
use endcomfort_core::robot::{HandDescription, Robot};
use endcomfort_core::scene::{ArmChoice, Scene};
use nalgebra::{Isometry3, Point3};

use super::state::Side;
use super::{Command, Effect, Layer, ReachView, ViewEffect, ViewerState};
use crate::assets;

/// Names of the arms that maps are shown of.
pub(super) const ARMS: [&str; 2] = ["left", "right"];

/// What a person does with reachability maps.
#[derive(Clone, Debug, PartialEq)]
pub enum ReachCommand {
    /// Shows the maps and their page of the inspector.
    Open,
    /// Closes the page; the maps stay shown.
    Close,
    /// Opens a part of the page.
    Page(ReachPage),
    /// Shows the maps another way.
    View(ReachView),
    /// Chooses a voxel of the left arm (0) or of the right one (1).
    Select { arm: usize, voxel: u32 },
    /// Chooses the voxel of the other arm at the same place.
    SwitchArm,
    /// Shows the hand in another orientation.
    Orientation(usize),
    /// Shows the hand in the orientation after the shown one, or before it.
    NextOrientation { forth: bool },
    /// Sets what is built; another torso means other stored maps.
    Settings(MapRequest),
    /// Builds the maps of the shown arms.
    Build,
    /// Takes a file that was fetched, or why it was not.
    Arrived { path: String, file: Result<Vec<u8>, String> },
    /// Saves the map of an arm.
    Save { arm: usize },
}

/// A part of the page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReachPage {
    /// How the maps are shown.
    #[default]
    View,
    /// The chosen voxel.
    Voxel,
    /// What the maps are, and how others are built.
    Map,
}

impl ReachPage {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::View, Self::Voxel, Self::Map];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::View => "View",
            Self::Voxel => "Voxel",
            Self::Map => "Map",
        }
    }
}

/// A voxel with one of its reached orientations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoxelChoice {
    /// Of the left arm (0) or of the right one (1).
    pub arm: usize,
    /// The voxel.
    pub voxel: Voxel,
    /// Number of the orientation.
    pub orientation: usize,
}

/// What reachability maps add to the picture; equal values give equal pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachKey {
    version: u64,
    view: ReachView,
    chosen: Option<VoxelChoice>,
}

/// Where the map of an arm is.
#[derive(Clone, Debug, Default)]
pub enum Slot {
    /// Nobody asked for it yet.
    #[default]
    Empty,
    /// On its way from this path.
    Awaited(String),
    /// It could not be had; why.
    Missing(String),
    /// Here.
    Here(ShownMap),
}

/// A map with its file.
#[derive(Clone, Debug)]
pub struct ShownMap {
    /// The map.
    pub map: ReachMap,
    /// Its file.
    pub bytes: Arc<Vec<u8>>,
    /// Name of its file.
    pub name: String,
    /// Where it comes from.
    pub source: MapSource,
}

/// Where a map comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapSource {
    /// It was stored with the program.
    Stored,
    /// A person opened its file.
    File,
    /// It was built here, in so many milliseconds.
    Built { elapsed_ms: f64 },
}

/// Reachability maps and how they are shown.
#[derive(Debug)]
pub struct Reaching {
    /// Whether the inspector shows their page.
    pub is_open: bool,
    /// The open part of it.
    pub page: ReachPage,
    /// How they are shown.
    pub view: ReachView,
    /// What is built when it is asked for; its arms follow from the view.
    pub wanted: MapRequest,
    chosen: Option<VoxelChoice>,
    slots: [Slot; 2],
    /// Whose maps the slots hold.
    of: Option<Whose>,
    building: Option<Building>,
    version: u64,
}

/// What maps belong to: another robot, hand or torso has others.
#[derive(Clone, Debug, PartialEq)]
struct Whose {
    robot: String,
    hand: Option<HandDescription>,
    torso: bool,
}

/// How far a build is.
#[derive(Clone, Debug, PartialEq)]
struct Building {
    revision: u64,
    fraction: f64,
    note: String,
}

impl Default for Reaching {
    fn default() -> Self {
        Self {
            is_open: false,
            page: ReachPage::default(),
            view: ReachView::default(),
            wanted: MapRequest {
                arms: Vec::new(),
                torso: false,
                voxel_m: 0.05,
                orientations: 40,
                method: MapMethod::Inverse,
            },
            chosen: None,
            slots: Default::default(),
            of: None,
            building: None,
            version: 0,
        }
    }
}

impl Reaching {
    /// What they add to the picture.
    pub fn key(&self) -> ReachKey {
        ReachKey { version: self.version, view: self.view, chosen: self.chosen }
    }

    /// Another number, other maps.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Where the map of an arm is.
    pub fn slot(&self, arm: usize) -> &Slot {
        self.slots.get(arm).unwrap_or(&Slot::Empty)
    }

    /// The map of an arm, if it is here.
    pub fn shown(&self, arm: usize) -> Option<&ShownMap> {
        if let Slot::Here(shown) = self.slot(arm) { Some(shown) } else { None }
    }

    /// As [`Reaching::shown`], the map alone.
    pub fn map(&self, arm: usize) -> Option<&ReachMap> {
        self.shown(arm).map(|shown| &shown.map)
    }

    /// The chosen voxel.
    pub fn chosen(&self) -> Option<VoxelChoice> {
        self.chosen
    }

    pub(super) fn let_go(&mut self) {
        self.chosen = None;
    }

    /// The reached orientations of a voxel, the most manipulable first.
    pub fn orientations(&self, arm: usize, voxel: Voxel) -> Vec<usize> {
        let Some(map) = self.map(arm) else { return Vec::new() };
        let mut reached: Vec<usize> = map.reached(voxel).collect();
        let value = |orientation: usize| map.manipulability(voxel, orientation).unwrap_or(0.0);
        reached.sort_by(|&a, &b| value(b).total_cmp(&value(a)));
        reached
    }
}

impl ViewerState {
    /// The chosen voxel, while the view shows the robot there.
    pub fn shown_voxel(&self) -> Option<VoxelChoice> {
        let is_shown = self.layers.opacity(Layer::Reach) > 0.0 && !self.playback.playing && self.lab_key().is_none();
        self.reaching.chosen.filter(|chosen| is_shown && self.reaching.map(chosen.arm).is_some())
    }

    /// How far the maps are that are being built, and a few words.
    pub fn map_under_way(&self) -> Option<(f64, &str)> {
        let building = self.reaching.building.as_ref()?;
        (self.running && building.revision == self.revision).then_some((building.fraction, building.note.as_str()))
    }

    /// Whether a joint before the arm can turn with it.
    pub fn has_torso(&self) -> bool {
        assets::library().robot_of(&self.document.scene).is_ok_and(|robot| has_torso(&robot))
    }

    /// Where the base of an arm's map stands while the robot is in the scene's start posture.
    pub fn map_base(&self, arm: usize) -> Option<Isometry3<f64>> {
        let base = &self.reaching.map(arm)?.about().arm.base_link;
        let scene = &self.document.scene;
        let robot = assets::library().robot_of(scene).ok()?;
        let link = robot.links.iter().position(|link| link.name == *base)?;
        let q = scene.q_start(&robot).unwrap_or_else(|_| vec![0.0; robot.dof_count()]);
        robot.link_poses(&q).get(link).copied()
    }

    /// The centre of a voxel in the world.
    pub fn voxel_place(&self, arm: usize, voxel: Voxel) -> Option<Point3<f64>> {
        Some(self.map_base(arm)? * self.reaching.map(arm)?.center(voxel))
    }

    /// The voxel of the other arm at the place of the chosen one, if that arm reaches it.
    pub fn voxel_across(&self) -> Option<(usize, Voxel)> {
        let chosen = self.reaching.chosen?;
        let arm = 1 - chosen.arm.min(1);
        let (p_W, map) = (self.voxel_place(chosen.arm, chosen.voxel)?, self.reaching.map(arm)?);
        let voxel = map.voxel_at(&self.map_base(arm)?.inverse_transform_point(&p_W))?;
        (map.fraction(voxel) > 0.0).then_some((arm, voxel))
    }

    pub(super) fn apply_reach(&mut self, command: ReachCommand) -> Vec<Effect> {
        match command {
            ReachCommand::Open => {
                self.layers.get_mut(Layer::Reach).visible = true;
                self.open_page();
                self.drawer = Some(Side::Right);
                return vec![Effect::View(ViewEffect::FrameAll)];
            }
            ReachCommand::Close => {
                self.reaching.is_open = false;
                self.reaching.let_go();
            }
            ReachCommand::Page(page) => self.reaching.page = page,
            ReachCommand::View(view) => {
                let least = if view.quantity == self.reaching.view.quantity { view.least } else { 0.0 };
                self.reaching.view = ReachView { least, ..view };
                let is_shown = |chosen: &VoxelChoice| view.arms.needs(chosen.arm);
                self.reaching.chosen = self.reaching.chosen.filter(is_shown);
            }
            ReachCommand::Select { arm, voxel } => self.choose(arm, Voxel(voxel)),
            ReachCommand::SwitchArm => {
                if let Some((arm, voxel)) = self.voxel_across() {
                    self.choose(arm, voxel);
                }
            }
            ReachCommand::Orientation(orientation) => {
                let maps = &self.reaching;
                let is_reached = |chosen: &VoxelChoice| {
                    maps.map(chosen.arm).is_some_and(|map| map.is_reached(chosen.voxel, orientation))
                };
                if let Some(chosen) = maps.chosen.filter(is_reached) {
                    self.reaching.chosen = Some(VoxelChoice { orientation, ..chosen });
                }
            }
            ReachCommand::NextOrientation { forth } => {
                if let Some(chosen) = self.reaching.chosen {
                    let reached = self.reaching.orientations(chosen.arm, chosen.voxel);
                    let here = reached.iter().position(|&orientation| orientation == chosen.orientation);
                    let count = reached.len().max(1);
                    let next = here.map_or(0, |here| if forth { here + 1 } else { here + count - 1 } % count);
                    let orientation = reached.get(next).copied().unwrap_or(chosen.orientation);
                    self.reaching.chosen = Some(VoxelChoice { orientation, ..chosen });
                }
            }
            ReachCommand::Settings(wanted) => self.reaching.wanted = wanted,
            ReachCommand::Build => return self.build_maps(),
            ReachCommand::Arrived { path, file } => return self.map_arrived(&path, file),
            ReachCommand::Save { arm } => {
                if let Some(shown) = self.reaching.shown(arm) {
                    return vec![Effect::Save { name: shown.name.clone(), bytes: shown.bytes.clone() }];
                }
            }
        }
        Vec::new()
    }

    /// Whoever turns to something else leaves the page, and the robot goes back to what it did.
    pub(super) fn make_way(&mut self, command: &Command) {
        match command {
            Command::SelectStep(_)
            | Command::SelectGrasp(_)
            | Command::SelectCluster(_)
            | Command::MoveSelection(_)
            | Command::PlanWithGrasp(_) => {
                self.reaching.is_open = false;
                self.reaching.let_go();
                self.posing.is_open = false;
            }
            Command::ShowIk(Some(_))
            | Command::SetPlaying(true)
            | Command::Seek(_)
            | Command::Nudge(_)
            | Command::StepSample { .. } => {
                self.reaching.let_go();
                self.posing.is_open = false;
            }
            _ => {}
        }
    }

    /// Asks for the stored maps of the shown arms as soon as they are to be seen; those of another robot go.
    pub(super) fn ask_for_maps(&mut self) -> Vec<Effect> {
        self.follow_robot();
        if !self.layers.get(Layer::Reach).visible {
            return Vec::new();
        }
        let mut effects = Vec::new();
        for arm in (0..2).filter(|&arm| self.reaching.view.arms.needs(arm)) {
            if !matches!(self.reaching.slots[arm], Slot::Empty) {
                continue;
            }
            if GuestRobot::title_of(&self.document.scene.robot) != self.document.scene.robot {
                self.reaching.slots[arm] = Slot::Missing("maps of your own robot are not stored".to_owned());
            } else if self.maps_have_torso() {
                self.reaching.slots[arm] = Slot::Missing("maps with the torso are not stored".to_owned());
            } else {
                let path = format!("maps/{}", self.map_name(arm));
                self.reaching.slots[arm] = Slot::Awaited(path.clone());
                effects.push(Effect::FetchMap(path));
            }
        }
        effects
    }

    fn follow_robot(&mut self) {
        let scene = &self.document.scene;
        let torso = self.reaching.wanted.torso && self.has_torso();
        let whose = Whose { robot: scene.robot.clone(), hand: scene.hand.clone(), torso };
        if self.reaching.of.as_ref() != Some(&whose) {
            self.reaching.of = Some(whose);
            self.reaching.slots = Default::default();
            self.reaching.let_go();
            self.reaching.version += 1;
        }
    }

    /// Whether the maps are those with the torso.
    pub fn maps_have_torso(&self) -> bool {
        self.reaching.of.as_ref().is_some_and(|of| of.torso)
    }

    /// Name of the file of an arm's map.
    fn map_name(&self, arm: usize) -> String {
        let torso = if self.maps_have_torso() { "_torso" } else { "" };
        format!("{}{torso}_{}.reach", self.document.scene.robot, ARMS[arm.min(1)])
    }

    fn open_page(&mut self) {
        self.reaching.is_open = true;
        self.posing.is_open = false;
        self.lab.is_open = false;
        self.playback.playing = false;
        self.selection.ik = None;
    }

    fn choose(&mut self, arm: usize, voxel: Voxel) {
        let best = self.reaching.map(arm).and_then(|map| map.best_orientation(voxel));
        if let Some(orientation) = best {
            self.open_page();
            self.reaching.page = ReachPage::Voxel;
            self.reaching.chosen = Some(VoxelChoice { arm, voxel, orientation });
        }
    }

    fn build_maps(&mut self) -> Vec<Effect> {
        if self.running {
            return Vec::new();
        }
        let there = |arm: &usize| self.has_arm([ArmChoice::Left, ArmChoice::Right][*arm]);
        let arms =
            (0..2).filter(|&arm| self.reaching.view.arms.needs(arm)).filter(there).map(|arm| ARMS[arm].to_owned());
        let torso = self.maps_have_torso();
        let wanted = MapRequest { arms: arms.collect(), torso, ..self.reaching.wanted.clone() };
        let building = Building { revision: self.revision, fraction: 0.0, note: String::new() };
        self.reaching.building = Some(building);
        self.running = true;
        let mut request = self.document.request(self.revision);
        request.map = Some(wanted);
        vec![Effect::Run(Box::new(request))]
    }

    pub(super) fn map_progress(&mut self, fraction: f64, note: String) {
        if let Some(building) = &mut self.reaching.building {
            building.fraction = fraction.max(0.0).min(1.0);
            building.note = note;
        }
    }

    pub(super) fn map_built(&mut self, elapsed_ms: f64, built: BuiltMap) -> Vec<Effect> {
        let Some(arm) = ARMS.iter().position(|arm| *arm == built.arm) else { return Vec::new() };
        if built.torso != self.maps_have_torso() {
            return Vec::new();
        }
        let name = self.map_name(arm);
        let put = built.file.and_then(|bytes| self.put_map(arm, name, bytes, MapSource::Built { elapsed_ms }));
        let sentence = match put {
            Ok(()) => return vec![Effect::Announce(format!("The map of the {} arm is built.", built.arm))],
            Err(reason) => format!("The map of the {} arm could not be built: {reason}.", built.arm),
        };
        self.say(true, sentence.clone(), Vec::new());
        vec![Effect::Announce(sentence)]
    }

    /// A map from a file that a person opened.
    pub(super) fn open_map(&mut self, name: String, bytes: Vec<u8>) -> Vec<Effect> {
        let opened = About::of_file(&bytes).map_err(|error| error.to_string()).and_then(|about| {
            let robot = self.mapped_robot()?;
            let (of, scene) = (&about.arm, &self.document.scene);
            if of.robot != scene.robot {
                return Err(format!("it is a map of {}, and {} acts here", of.robot, scene.robot));
            }
            let arm = ARMS.iter().position(|arm| *arm == of.arm).ok_or_else(|| format!("it is of arm {}", of.arm))?;
            let own_base = robot.arm(&of.arm).map(|arm| robot.links[arm.base_link].name.as_str());
            self.reaching.wanted.torso = own_base != Some(of.base_link.as_str());
            self.follow_robot();
            self.put_map(arm, name.clone(), bytes, MapSource::File)
        });
        match opened {
            Ok(()) => {
                self.reaching.page = ReachPage::Map;
                self.apply_reach(ReachCommand::Open)
            }
            Err(reason) => self.apply(Command::FileFailed { name, reason }),
        }
    }

    fn map_arrived(&mut self, path: &str, file: Result<Vec<u8>, String>) -> Vec<Effect> {
        let is_awaited = |slot: &Slot| matches!(slot, Slot::Awaited(awaited) if awaited == path);
        let Some(arm) = self.reaching.slots.iter().position(is_awaited) else { return Vec::new() };
        let name = self.map_name(arm);
        match file.and_then(|bytes| self.put_map(arm, name, bytes, MapSource::Stored)) {
            Ok(()) if self.reaching.is_open => vec![Effect::View(ViewEffect::FrameAll)],
            Ok(()) => Vec::new(),
            Err(reason) => {
                self.reaching.slots[arm] = Slot::Missing(reason.clone());
                let sentence = format!(
                    "There is no stored map of the {} arm to show: {reason}. Build one on the page Map of Reachability.",
                    ARMS[arm]
                );
                self.say(true, sentence.clone(), Vec::new());
                vec![Effect::Announce(sentence)]
            }
        }
    }

    fn put_map(&mut self, arm: usize, name: String, bytes: Vec<u8>, source: MapSource) -> Result<(), String> {
        let robot = self.mapped_robot()?;
        let index = robot.arms.iter().position(|found| found.name == ARMS[arm]);
        let index = index.ok_or_else(|| format!("{} has no {} arm", robot.name, ARMS[arm]))?;
        let with_torso = self.maps_have_torso().then(|| robot.with_torso(index));
        let robot = with_torso.as_ref().unwrap_or(&robot);
        let map = ReachMap::from_bytes(&bytes, robot, index).map_err(|error| error.to_string())?;
        self.reaching.slots[arm] = Slot::Here(ShownMap { map, bytes: Arc::new(bytes), name, source });
        self.reaching.chosen = self.reaching.chosen.filter(|chosen| chosen.arm != arm);
        self.reaching.version += 1;
        Ok(())
    }

    /// The robot whose maps are shown: the one that acts, with the hand that the scene gives it.
    fn mapped_robot(&self) -> Result<Arc<Robot>, String> {
        let alone = Scene { handover: None, ..(*self.document.scene).clone() };
        assets::library().robot_of(&alone).map_err(|error| error.to_string())
    }
}

/// Whether a joint between the robot's base and its first arm can move.
fn has_torso(robot: &Robot) -> bool {
    let mut link = robot.arms.first().map_or(0, |arm| arm.base_link);
    while link > 0 {
        // Joint i moves link i + 1.
        let joint = &robot.joints[link - 1];
        if joint.dof.is_some() {
            return true;
        }
        link = joint.parent;
    }
    false
}
