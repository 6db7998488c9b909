//! What people bring: files that come together are sorted, and what they leave open is asked in a window.

use std::sync::Arc;

use endcomfort_core::guest::{
    ArmDescription, Files, GuestRobot, LEAST_JOINTS, Proposal, READY, RobotDescription, Wishes,
};
use endcomfort_core::job::MapMethod;
use endcomfort_core::mesh_file::MeshUnit;
use endcomfort_core::reach::ForwardSettings;
use endcomfort_core::robot::ik::ArmIk;
use endcomfort_core::robot::{HandDescription, JointKind, Placement, Robot, read_urdf};
use endcomfort_core::scene::ArmChoice;

use super::{Command, DepthWindow, Effect, MeshWindow, RobotChoice, ViewEffect, ViewerState};
use crate::brought::{is_mesh, is_png};
use crate::{assets, brought};

/// Hands of `robots/hands/` that an arm may be given: file, and the name in it.
pub(super) const HANDS: [(&str, &str); 3] =
    [("pg70", "PG 70 with flat fingers"), ("sdh", "SDH"), ("adaptive", "Two adaptive fingers")];

/// Endings of files that are opened one at a time.
const OPENED: [&str; 7] = [".pcd", ".ply", ".xyz", ".json", ".reach", ".txt", ".asc"];

/// What a person does with what they bring.
#[derive(Clone, Debug, PartialEq)]
pub enum BringCommand {
    /// Files that came together: path and content.
    Files(Vec<(String, Vec<u8>)>),
    /// Opens the window of the robot that acts, if somebody brought it.
    OpenRobot,
    /// Changes what is asked for in the window.
    Draft(RobotDraft),
    /// Sets the field of view of a depth image, degrees.
    SetView(f64),
    /// Sets the unit of a mesh.
    SetUnit(MeshUnit),
    /// Takes what stands in the window; of a mesh whether it is grasped, or stands in the way.
    Accept { is_grasped: bool },
    /// Closes the window; nothing changes.
    Cancel,
    /// Saves what was chosen for the robot as a small file.
    SaveChoice,
}

/// The window that is open.
#[derive(Clone, Debug)]
pub enum Bringing {
    /// About a robot.
    Robot(RobotWindow),
    /// About a depth image without its camera.
    Depth(DepthWindow),
    /// About a mesh.
    Mesh(MeshWindow),
}

/// The window that asks what the files of a robot leave open.
#[derive(Clone, Debug)]
pub struct RobotWindow {
    /// The robot as it came or as it acts.
    pub guest: Arc<GuestRobot>,
    /// Its tree of links, without meshes.
    pub tree: Option<Arc<Robot>>,
    /// Its links, in the order of the tree.
    pub links: Vec<String>,
    /// Its moving joints: name, and whether it slides.
    pub joints: Vec<(String, bool)>,
    /// What was found, and what was passed over.
    pub notes: Vec<String>,
    /// What is wrong with what stands here, or why the window opened.
    pub problem: Option<String>,
    /// What is asked for.
    pub draft: RobotDraft,
}

/// What a person fills in.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotDraft {
    /// One or two arms, the left one first.
    pub arms: Vec<ArmDescription>,
    /// Pose of the root in the world; `None` looks for one.
    pub stand: Option<Placement>,
    /// Positions of joints at the start, rad or m, in the order of the window's list; `None` looks for them.
    pub posture: Option<Vec<f64>>,
}

impl RobotWindow {
    fn of(guest: Arc<GuestRobot>, notes: Vec<String>, problem: Option<String>) -> Self {
        let bare = read_urdf(&guest.urdf, &|_| None).map(|loaded| Arc::new(loaded.value)).ok();
        let links = bare.iter().flat_map(|robot| robot.links.iter().map(|link| link.name.clone())).collect();
        let moving = |robot: &Robot| -> Vec<(String, bool)> {
            let joints = robot.dof_joints.iter().map(|&joint| &robot.joints[joint]);
            joints.map(|joint| (joint.name.clone(), joint.kind == JointKind::Prismatic)).collect()
        };
        let joints: Vec<(String, bool)> = bare.as_deref().map(moving).unwrap_or_default();
        let RobotDescription { arms, stand, posture, .. } = &guest.description;
        let positions = || joints.iter().map(|(name, _)| posture.get(name).copied().unwrap_or(0.0)).collect();
        let mut arms = arms.clone();
        // Without a problem its SRDF names them.
        if let (true, Some(_), Some(robot)) = (arms.is_empty(), &problem, &bare) {
            arms.push(deepest_chain(robot));
        }
        let posture = (!posture.is_empty()).then(positions);
        let draft = RobotDraft { arms, stand: *stand, posture };
        Self { guest, tree: bare, links, joints, notes, problem, draft }
    }

    /// The robot that stands in the window.
    fn asked(&self) -> GuestRobot {
        let RobotDraft { arms, stand, posture } = &self.draft;
        // What nobody set stays unsaid: fingers start open.
        let is_said = |name: &String, value: f64| value != 0.0 || self.guest.description.posture.contains_key(name);
        let named = |values: &Vec<f64>| {
            let joints = self.joints.iter().zip(values).filter(|((name, _), value)| is_said(name, **value));
            joints.map(|((name, _), value)| (name.clone(), *value)).collect()
        };
        let description = RobotDescription {
            arms: arms.clone(),
            stand: *stand,
            posture: posture.as_ref().map(named).unwrap_or_default(),
            ..self.guest.description.clone()
        };
        GuestRobot { description, ..(*self.guest).clone() }
    }
}

/// The chain from the root to the link that most joints move, as something to begin with.
fn deepest_chain(robot: &Robot) -> ArmDescription {
    let moving = |link: usize| {
        let chain = robot.chain(0, link).unwrap_or_default();
        chain.iter().filter(|&&joint| robot.joints[joint].dof.is_some()).count()
    };
    // The first of equals is the last one that a joint itself moves.
    let tip = (0..robot.links.len()).rev().max_by_key(|&link| moving(link)).unwrap_or(0);
    ArmDescription {
        name: "left".to_owned(),
        base_link: robot.links[0].name.clone(),
        tip_link: robot.links[tip].name.clone(),
        tcp: Placement::default(),
        hand: given_hand(brought::DEFAULT_HAND),
    }
}

/// A hand that an arm may be given.
pub(super) fn given_hand(name: &str) -> Option<HandDescription> {
    assets::library().hand(name).ok()
}

impl ViewerState {
    pub(super) fn apply_bring(&mut self, command: BringCommand) -> Vec<Effect> {
        match command {
            BringCommand::Files(files) => return self.bring(files),
            BringCommand::OpenRobot => {
                if let Some(guest) = assets::library().guest(&self.document.scene.robot) {
                    let window = RobotWindow::of(guest.robot.clone(), Vec::new(), None);
                    self.bringing = Some(Bringing::Robot(window));
                }
            }
            BringCommand::Draft(draft) => {
                if let Some(Bringing::Robot(window)) = &mut self.bringing {
                    window.draft = draft;
                    window.problem = None;
                }
            }
            BringCommand::SetView(degrees) => {
                if let Some(Bringing::Depth(window)) = &mut self.bringing {
                    (window.view_deg, window.problem) = (degrees, None);
                }
            }
            BringCommand::SetUnit(unit) => {
                if let Some(Bringing::Mesh(window)) = &mut self.bringing {
                    (window.unit, window.problem) = (unit, None);
                }
            }
            BringCommand::Accept { is_grasped } => {
                return match self.bringing.take() {
                    Some(Bringing::Robot(window)) => self.accept_robot(window),
                    Some(Bringing::Depth(window)) => self.accept_depth(window),
                    Some(Bringing::Mesh(window)) => self.accept_mesh(window, is_grasped),
                    None => Vec::new(),
                };
            }
            BringCommand::Cancel => self.bringing = None,
            BringCommand::SaveChoice => return self.save_choice(),
        }
        Vec::new()
    }

    /// Opens files that came together.
    fn bring(&mut self, mut files: Vec<(String, Vec<u8>)>) -> Vec<Effect> {
        let Some(first) = files.first().map(|(path, _)| name_of(path)) else { return Vec::new() };
        let shown = if files.len() == 1 { first.clone() } else { format!("{first} and {} more", files.len() - 1) };
        if let [(path, bytes)] = files.as_mut_slice()
            && !is_part_of_more(path, bytes)
        {
            return self.apply(Command::OpenFile { name: first, bytes: std::mem::take(bytes) });
        }
        let sorted = match Files::new(files) {
            Ok(sorted) => sorted,
            Err(error) => return self.apply(Command::FileFailed { name: shown, reason: error.to_string() }),
        };
        (self.overlay, self.drawer) = (super::Overlay::None, None);
        if sorted.has_robot() {
            return self.bring_robot(&sorted, &shown);
        }
        if let Some(effects) = self.bring_choice(&sorted, &shown) {
            return effects;
        }
        if let Some(effects) = self.bring_depth(&sorted).or_else(|| self.bring_mesh(&sorted)) {
            return effects;
        }
        // Nothing that belongs together: one scene or cloud at a time.
        let is_opened = |path: &&str| OPENED.iter().any(|ending| path.to_ascii_lowercase().ends_with(ending));
        let path = sorted.paths().find(is_opened).or_else(|| sorted.paths().next()).map(str::to_owned);
        let Some((path, bytes)) = path.and_then(|path| Some((path.clone(), sorted.get(&path)?.to_vec()))) else {
            return self.apply(Command::FileFailed { name: shown, reason: "it is empty".to_owned() });
        };
        let count = sorted.paths().count();
        if count > 1 {
            let text = format!("{count} files were brought; only {} was opened.", name_of(&path));
            self.say(false, text, Vec::new());
        }
        self.apply(Command::OpenFile { name: name_of(&path), bytes })
    }

    fn bring_robot(&mut self, files: &Files, shown: &str) -> Vec<Effect> {
        let table = self.document.scene.table;
        match brought::proposed(files, &Wishes::default(), &table, None) {
            Err(reason) => self.apply(Command::FileFailed { name: shown.to_owned(), reason }),
            Ok(Proposal { guest, notes, problem: problem @ Some(_) }) => {
                let window = RobotWindow::of(Arc::new(guest), notes, problem.clone());
                self.bringing = Some(Bringing::Robot(window));
                problem.map(Effect::Announce).into_iter().collect()
            }
            Ok(Proposal { guest, notes, problem: None }) => {
                let result = self.let_guest_act(guest, notes);
                result.unwrap_or_else(|reason| self.apply(Command::FileFailed { name: shown.to_owned(), reason }))
            }
        }
    }

    /// A remembered choice for the robot that acts; `None` if there is none among the files.
    fn bring_choice(&mut self, files: &Files, shown: &str) -> Option<Vec<Effect>> {
        let failed = |state: &mut Self, reason: String| state.apply(Command::FileFailed { name: shown.into(), reason });
        let description = match files.description() {
            Ok(found) => found?.1,
            Err(error) => return Some(failed(self, error.to_string())),
        };
        let present = assets::library().guest(&self.document.scene.robot);
        let Some(present) = present.filter(|guest| guest.robot.description.urdf == description.urdf) else {
            let reason = format!("it is about {}, which does not act here: drop both together", description.urdf);
            return Some(failed(self, reason));
        };
        let guest = GuestRobot { description, ..(*present.robot).clone() };
        let settled = brought::settled(guest, &self.document.scene.table);
        let result = settled.and_then(|(guest, notes)| self.let_guest_act(guest, notes));
        Some(result.unwrap_or_else(|reason| failed(self, reason)))
    }

    fn accept_robot(&mut self, mut window: RobotWindow) -> Vec<Effect> {
        let asked = window.asked();
        let checked = asked.description.check().map_err(|error| error.to_string());
        let settled = checked.and_then(|()| brought::settled(asked, &self.document.scene.table));
        match settled.and_then(|(guest, notes)| self.let_guest_act(guest, notes)) {
            Ok(effects) => effects,
            Err(reason) => {
                window.problem = Some(reason.clone());
                self.bringing = Some(Bringing::Robot(window));
                vec![Effect::Announce(reason)]
            }
        }
    }

    /// Hands the scene to a robot that somebody brought.
    fn let_guest_act(&mut self, guest: GuestRobot, mut notes: Vec<String>) -> Result<Vec<Effect>, String> {
        let name = assets::library().welcome(&Arc::new(guest)).map_err(|error| error.to_string())?;
        let arm = usable_arm(&name, self.document.scene.arm);
        let title = GuestRobot::title_of(&name).to_owned();
        if let Some(guest) = assets::library().guest(&name) {
            notes.extend(guest.notes.iter().cloned());
        }
        self.overlay = super::Overlay::None;
        self.playback.playing = false;
        self.know_guest(&name);
        let mut effects = self.edit_scene(|scene| {
            scene.robot.clone_from(&name);
            READY.clone_into(&mut scene.posture);
            (scene.torso, scene.hand, scene.arm) = (false, None, arm);
        });
        let before =
            if effects.is_empty() { "It acted already" } else { "Undo gives the scene back to the robot before" };
        let sentence = format!("{title} acts now. {before}.");
        self.say(false, sentence.clone(), notes);
        effects.push(Effect::Announce(sentence));
        effects.push(Effect::View(ViewEffect::FrameAll));
        Ok(effects)
    }

    /// Lists a robot that somebody brought among those that can act.
    pub(super) fn know_guest(&mut self, name: &str) {
        let is_known = self.robots.iter().any(|robot| robot.name == name);
        if is_known || assets::library().guest(name).is_none() {
            return;
        }
        let title = GuestRobot::title_of(name).to_owned();
        // Another choice for the same robot takes the place of the one before.
        self.robots.retain(|robot| GuestRobot::title_of(&robot.name) != title || robot.name == title);
        if !has_closed_form(name) {
            let samples = ForwardSettings::default().samples;
            self.reaching.wanted.method = MapMethod::Forward { samples };
        }
        self.robots.push(RobotChoice { name: name.to_owned(), title, posture: READY.into() });
    }

    /// Whether the robot that acts has this arm.
    pub fn has_arm(&self, arm: ArmChoice) -> bool {
        let robot = assets::library().robot(&self.document.scene.robot);
        robot.is_ok_and(|robot| robot.arm(arm.name()).is_some())
    }

    fn save_choice(&mut self) -> Vec<Effect> {
        let guest = match &self.bringing {
            Some(Bringing::Robot(window)) => window.asked(),
            _ => match assets::library().guest(&self.document.scene.robot) {
                Some(guest) => (*guest.robot).clone(),
                None => return Vec::new(),
            },
        };
        match serde_json::to_string_pretty(&guest.description) {
            Ok(text) => {
                let name = format!("{}.robot.json", guest.title());
                vec![Effect::Save { name, bytes: Arc::new(text.into_bytes()) }]
            }
            Err(error) => {
                self.say(true, format!("The choice could not be written: {error}."), Vec::new());
                Vec::new()
            }
        }
    }
}

/// The arm that shall act, or the only one that the robot has.
pub(super) fn usable_arm(robot: &str, wanted: ArmChoice) -> ArmChoice {
    let lacks = |robot: Arc<Robot>| robot.arm(wanted.name()).is_none() && robot.arm(wanted.other().name()).is_some();
    if assets::library().robot(robot).is_ok_and(lacks) { wanted.other() } else { wanted }
}

/// Whether every arm's joints are solved in closed form, so that maps can be built by inverse sampling.
fn has_closed_form(robot: &str) -> bool {
    let Ok(robot) = assets::library().robot(robot) else { return false };
    robot.arms.iter().all(|arm| ArmIk::of(&robot, arm).is_ok_and(|ik| ik.closed_form().is_some()))
}

/// Whether a single file is one that others may belong to or that is asked about: a robot, an archive, a remembered
/// choice, a depth image, a mesh.
fn is_part_of_more(path: &str, bytes: &[u8]) -> bool {
    let path = path.to_ascii_lowercase();
    let is_choice = || serde_json::from_slice(bytes).is_ok_and(|json| RobotDescription::is_meant_by(&json));
    let is_asked_about =
        is_png(bytes) || is_mesh(&path) || [".urdf", ".xacro", ".zip"].iter().any(|e| path.ends_with(e));
    is_asked_about || path.ends_with(".json") && is_choice()
}

/// The last part of a path.
fn name_of(path: &str) -> String {
    path.rsplit('/').next().unwrap_or(path).to_owned()
}

/// How many joints an arm in the window has, and how many it needs.
pub(super) fn joint_count(window: &RobotWindow, arm: &ArmDescription) -> Option<(usize, usize)> {
    let robot = window.tree.as_ref()?;
    let chain = robot.chain(robot.link_index(&arm.base_link)?, robot.link_index(&arm.tip_link)?)?;
    Some((chain.iter().filter(|&&joint| robot.joints[joint].dof.is_some()).count(), LEAST_JOINTS))
}
