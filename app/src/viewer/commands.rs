//! What a person can do, and what each deed does to the state.

use std::sync::Arc;

use endcomfort_core::grasp::ExportFormat;
use endcomfort_core::job::{DroppedCloud, Request, Stage};
use endcomfort_core::robot::HandDescription;
use endcomfort_core::scene::{ArmChoice, SCENE_VERSION, Scene};
use endcomfort_core::task::Plan;

use super::bringing::usable_arm;
use super::goal_drag::GoalDrag;
use super::state::{IkChoice, Presentation, Side, StageState, Step, ThemeChoice};
use super::{
    BringCommand, Document, Edge, Followed, GraspCommand, HandoverCommand, LabCommand, Layer, LookCommand, Opened,
    Overlay, PanelSizes, PictureCommand, PictureEffect, PlaceCommand, PlanCommand, Playback, PoseCommand, ReachCommand,
    Saved, TourCommand, ViewCommand, ViewEffect, ViewerState, playback, share,
};
use crate::export::MotionFormat;
use crate::render::Camera;

/// Something a person does.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Opens the demo of this name.
    OpenDemo(String),
    /// Opens a file: a scene or a hand description (`.json`), or a cloud.
    OpenFile { name: String, bytes: Vec<u8> },
    /// Brings files that belong together, or answers what they leave open.
    Bring(BringCommand),
    /// Reports a file that could not be read.
    FileFailed { name: String, reason: String },
    /// Hands the scene to another robot.
    SetRobot(String),
    /// Lets another arm act.
    SetArm(ArmChoice),
    /// Sets the seed of everything random.
    SetSeed(u64),
    /// Examines a fit, or asks for another one.
    Lab(LabCommand),
    /// Examines grasps, or asks for others.
    Grasping(GraspCommand),
    /// Examines plans, or asks for others.
    Planning(PlanCommand),
    /// Shows reachability maps, or asks for others.
    Reach(ReachCommand),
    /// Grasps another cluster.
    GraspCluster(usize),
    /// Examines a handover, or asks for another one.
    Handover(HandoverCommand),
    /// Plans with this grasp, `None` with the first that works.
    PlanWithGrasp(Option<u32>),
    /// Stops the computation.
    Cancel,
    /// Runs the pipeline again.
    Run,
    /// Takes back the last edit.
    Undo,
    /// Does an edit again that was taken back.
    Redo,
    /// Shows a step in the inspector.
    SelectStep(Step),
    /// Selects a grasp.
    SelectGrasp(u32),
    /// Selects the row so many rows further down the table.
    MoveSelection(isize),
    /// Selects a cluster.
    SelectCluster(usize),
    /// Points at a grasp.
    HoverGrasp(Option<u32>),
    /// Points at a cluster.
    HoverCluster(Option<usize>),
    /// Shows a solution of the selected grasp's IK set; `None` goes back to the plan.
    ShowIk(Option<IkChoice>),
    /// Starts or stops the playing.
    SetPlaying(bool),
    /// Goes to a time, seconds.
    Seek(f64),
    /// Goes forth or back by so many seconds.
    Nudge(f64),
    /// Goes to the next sample of the plan, or to the one before.
    StepSample { forth: bool },
    /// The next of the offered speeds.
    NextSpeed,
    /// Whether the end leads back to the start.
    ToggleLoop,
    /// What the camera keeps in the middle; following it already, it lets go.
    Follow(Followed),
    /// The camera stays where it is, or follows the object.
    ToggleFollow,
    /// Shows the view alone with captions, or the panels again.
    Present(bool),
    /// Shows or hides a layer.
    ToggleLayer(Layer),
    /// Sets the opacity of a layer, [0, 1].
    SetOpacity(Layer, f32),
    /// Changes the theme.
    SetTheme(ThemeChoice),
    /// Covers the page, or uncovers it.
    Show(Overlay),
    /// Opens or closes a side panel of a narrow window.
    ToggleDrawer(Side),
    /// Closes a message.
    Dismiss(u64),
    /// Closes whatever is uppermost: overlay, drawer, messages, IK preview.
    Escape,
    /// Moves, adds or takes away what stands in the scene.
    Place(PlaceCommand),
    /// Poses the robot by hand.
    Pose(PoseCommand),
    /// Shows a newcomer around.
    Tour(TourCommand),
    /// Gives a panel another size, points; `None` its usual one.
    ResizePanel(Edge, Option<f32>),
    /// Gives every panel its usual size.
    ResetLayout,
    /// Looks closely: points, cut, measures.
    Look(LookCommand),
    /// Moves the camera.
    View(ViewCommand),
    /// Saves what the view shows.
    Picture(PictureCommand),
    /// Saves a table or a plot.
    Save(Saved),
    /// Copies a link to this view.
    Share,
    /// Opens what a link or a session holds.
    OpenShared(Box<Opened>),
    /// Opens what was left at the last visit.
    Restore,
    /// Asks for a file to open.
    PickFile,
    /// Saves everything that is needed to open this view again, a dropped cloud included.
    SaveSession,
    /// Saves the scene alone.
    SaveScene,
    /// Opens this view on a page of its own.
    OpenPage,
}

/// What the world outside the state has to do.
#[derive(Clone, Debug)]
pub enum Effect {
    /// Hand this request to the worker.
    Run(Box<Request>),
    /// Stop the worker.
    Cancel,
    /// Move the camera.
    View(ViewEffect),
    /// Take a picture of the view, or many.
    Picture(PictureEffect),
    /// Bring a file of a reachability map: `maps/alita_left.reach`.
    FetchMap(String),
    /// Hand a file to the person.
    Save { name: String, bytes: Arc<Vec<u8>> },
    /// Save the ranked grasps.
    Export(ExportFormat),
    /// Save the planned motion.
    ExportMotion(MotionFormat),
    /// Change the theme.
    Theme(ThemeChoice),
    /// Say this to assistive technology.
    Announce(String),
    /// Put the camera there, and frame nothing.
    PlaceCamera(Camera),
    /// Copy a link to this view.
    Share,
    /// Ask the person for a file.
    PickFile,
    /// Hand a session to the person as a file.
    SaveSession,
    /// Open this view on a page of its own.
    OpenPage,
}

impl ViewerState {
    /// Does what the person asked for.
    pub fn apply(&mut self, command: Command) -> Vec<Effect> {
        self.make_way(&command);
        let mut effects = self.obey(command);
        effects.extend(self.ask_for_maps());
        self.look_around();
        effects
    }

    fn obey(&mut self, command: Command) -> Vec<Effect> {
        match command {
            Command::OpenDemo(name) => return self.open_demo(&name),
            Command::OpenFile { name, bytes } => return self.open_file(name, bytes),
            Command::Bring(command) => return self.apply_bring(command),
            Command::FileFailed { name, reason } => {
                let sentence = format!("{name} could not be read: {reason}. The scene is as it was.");
                self.say(true, sentence.clone(), Vec::new());
                return vec![Effect::Announce(sentence)];
            }
            Command::SetRobot(name) => {
                let posture = self.robots.iter().find(|robot| robot.name == name).map(|robot| robot.posture.clone());
                let arm = usable_arm(&name, self.document.scene.arm);
                return self.edit_scene(|scene| {
                    (scene.robot, scene.arm) = (name, arm);
                    scene.joints.clear();
                    if let Some(posture) = posture {
                        scene.posture = posture;
                    }
                });
            }
            Command::SetArm(arm) => return self.edit_scene(|scene| scene.arm = arm),
            Command::SetSeed(seed) => return self.edit_scene(|scene| scene.seed = seed),
            Command::Lab(command) => return self.apply_lab(command),
            Command::Grasping(command) => return self.apply_grasping(command),
            Command::Planning(command) => return self.apply_planning(command),
            Command::Handover(command) => return self.apply_handover(command),
            Command::Reach(command) => return self.apply_reach(command),
            Command::GraspCluster(cluster) => {
                return self.edit(|document| {
                    document.cluster = Some(cluster);
                    document.grasp = None;
                });
            }
            Command::PlanWithGrasp(grasp) => {
                self.selection.step = Step::Stage(Stage::Plan);
                return self.edit(|document| document.grasp = grasp);
            }
            Command::Cancel => return self.cancel(),
            Command::Run => {
                let document = self.document.clone();
                self.set_document(document);
                return self.run();
            }
            Command::Undo => {
                if let Some(document) = self.history.undo(&self.document) {
                    return self.replace(document);
                }
            }
            Command::Redo => {
                if let Some(document) = self.history.redo(&self.document) {
                    return self.replace(document);
                }
            }
            Command::SelectStep(step) => {
                self.selection.step = step;
                self.grasping.draws_region = false;
                self.lab.is_open = step == Step::Stage(Stage::Fit);
                self.lab.points_out_rejected = false;
                if self.lab.is_open {
                    self.playback.playing = false;
                }
                if step == Step::Play {
                    self.selection.ik = None;
                }
            }
            Command::SelectGrasp(id) => self.select_grasp(id),
            Command::MoveSelection(rows) => self.move_selection(rows),
            Command::SelectCluster(cluster) => {
                self.selection.cluster = Some(cluster);
                self.lab.points_out_rejected = false;
                self.lab.refused = None;
                if !matches!(self.selection.step, Step::Stage(Stage::Segment | Stage::Fit)) {
                    self.selection.step = Step::Stage(Stage::Segment);
                }
            }
            Command::HoverGrasp(grasp) => self.hover.grasp = grasp,
            Command::HoverCluster(cluster) => self.hover.cluster = cluster,
            Command::ShowIk(ik) => {
                self.selection.ik = ik;
                self.playback.playing &= ik.is_none();
            }
            Command::SetPlaying(true) => {
                let duration_s = self.duration_s();
                self.playback.play(duration_s);
                self.lab.is_open = false;
                self.selection.ik = None;
                self.planning.selected_try = None;
            }
            Command::SetPlaying(false) => self.playback.playing = false,
            Command::Seek(time_s) => self.seek(time_s),
            Command::Nudge(step_s) => {
                self.playback.playing = false;
                self.seek(self.playback.time_s + step_s);
            }
            Command::StepSample { forth } => {
                self.playback.playing = false;
                let beside = |plan: &Plan| playback::sample_beside(plan, self.playback.time_s, forth);
                if let Some(time_s) = self.outputs.plan.as_deref().and_then(beside) {
                    self.seek(time_s);
                }
            }
            Command::NextSpeed => {
                let next = Playback::SPEEDS.into_iter().find(|&speed| speed > self.playback.speed);
                self.playback.speed = next.unwrap_or(Playback::SPEEDS[0]);
            }
            Command::Follow(followed) => {
                self.playback.follows = Some(followed).filter(|_| self.playback.follows != Some(followed));
            }
            Command::ToggleFollow => {
                self.playback.follows = Some(Followed::Object).filter(|_| self.playback.follows.is_none());
            }
            Command::Present(wanted) => return self.present(wanted),
            Command::ToggleLoop => self.playback.looping = !self.playback.looping,
            Command::ToggleLayer(layer) => {
                let view = self.layers.get_mut(layer);
                view.visible = !view.visible;
            }
            Command::SetOpacity(layer, opacity) => {
                let view = self.layers.get_mut(layer);
                view.opacity = opacity.max(0.05).min(1.0);
                view.visible = true;
            }
            Command::SetTheme(theme) => {
                self.theme = theme;
                return vec![Effect::Theme(theme)];
            }
            Command::Show(Overlay::Gallery) if self.is_embedded => {}
            Command::Show(overlay) => {
                self.overlay = overlay;
                self.drawer = None;
            }
            Command::ToggleDrawer(side) => self.drawer = (self.drawer != Some(side)).then_some(side),
            Command::Dismiss(id) => self.messages.retain(|message| message.id != id),
            Command::Escape => return self.escape(),
            Command::Place(command) => return self.apply_place(command),
            Command::Pose(command) => return self.apply_pose(command),
            Command::Tour(command) => return self.apply_tour(command),
            Command::ResizePanel(edge, size) => self.sizes.set(edge, size),
            Command::ResetLayout => self.sizes = PanelSizes::default(),
            Command::Look(command) => return self.apply_look(command),
            Command::View(command) => return self.apply_view(command),
            Command::Picture(command) => return self.apply_picture(command),
            Command::Save(saved) => return self.save(saved),
            Command::Share => return vec![Effect::Share],
            Command::OpenShared(opened) => return self.open_shared(*opened),
            Command::Restore => return self.restore(),
            Command::PickFile => return vec![Effect::PickFile],
            Command::SaveSession => return vec![Effect::SaveSession],
            Command::SaveScene => return self.save_scene(),
            Command::OpenPage => return vec![Effect::OpenPage],
        }
        Vec::new()
    }

    /// Lets time pass.
    pub fn advance(&mut self, dt_s: f64) {
        let duration_s = self.duration_s();
        self.playback.advance(dt_s, duration_s);
    }

    /// The request for the present document; results that stand already are not asked for again.
    pub fn run(&mut self) -> Vec<Effect> {
        self.running = true;
        self.forget_drag();
        let mut request = self.document.request(self.revision);
        // A run that was overtaken may not have come to tell the qualities: then the ranking is told once more.
        let is_half = |stage: Stage| stage == Stage::Rank && self.outputs.lacks_qualities();
        let missing = |stage: &Stage| self.outputs.revision(*stage) != Some(self.revision) || is_half(*stage);
        request.first = Stage::ALL.into_iter().find(missing).unwrap_or(Stage::Plan);
        vec![Effect::Run(Box::new(request))]
    }

    fn open_demo(&mut self, name: &str) -> Vec<Effect> {
        let Some(demo) = self.demo_named(name) else {
            let known: Vec<&str> = self.demos.iter().map(|demo| demo.name.as_str()).collect();
            let sentence = format!("There is no demo named {name:?}. The demos are {}.", known.join(", "));
            self.say(true, sentence.clone(), Vec::new());
            return vec![Effect::Announce(sentence)];
        };
        let document = Document::new(demo.scene.clone());
        self.overlay = Overlay::None;
        self.drawer = None;
        self.playback.playing = false;
        self.demo = Some(name.to_owned());
        if document == self.document && self.outputs.scene.is_some() {
            return vec![Effect::View(ViewEffect::FrameAll)];
        }
        self.outputs = super::Outputs::default();
        self.outputs_version += 1;
        self.selection = super::Selection { step: self.selection.step, cluster: None, grasp: None, ik: None };
        let mut effects = self.edit(|present| *present = document);
        effects.push(Effect::View(ViewEffect::FrameAll));
        effects
    }

    fn open_file(&mut self, name: String, bytes: Vec<u8>) -> Vec<Effect> {
        self.overlay = Overlay::None;
        if bytes.is_empty() {
            return self.apply(Command::FileFailed { name, reason: "it is empty".to_owned() });
        }
        let standing = self.standing();
        if name.to_ascii_lowercase().ends_with(".reach") {
            return self.open_map(name, bytes);
        }
        let is_json = name.to_ascii_lowercase().ends_with(".json");
        if let Some(json) = is_json.then(|| serde_json::from_slice(&bytes).ok()).flatten() {
            if HandDescription::is_meant_by(&json) {
                return self.open_hand(name, &bytes);
            }
            if share::is_session(&json) {
                return self.open_session(name, json);
            }
        }
        let effects = if is_json {
            match read_scene(&bytes) {
                Ok(scene) => self.edit(|document| *document = Document::new(Arc::new(scene))),
                Err(reason) => return self.apply(Command::FileFailed { name, reason }),
            }
        } else {
            let cloud = Arc::new(DroppedCloud { name, bytes });
            self.edit(|document| {
                document.cloud = Some(cloud);
                document.cluster = None;
                document.grasp = None;
                document.shape = None;
            })
        };
        if !effects.is_empty() {
            self.fallback = standing;
            self.demo = None;
            self.playback.playing = false;
        }
        effects
    }

    /// Gives the acting arm the described hand; the rest of the scene stays.
    fn open_hand(&mut self, file: String, bytes: &[u8]) -> Vec<Effect> {
        let hand = match HandDescription::parse(&String::from_utf8_lossy(bytes)) {
            Ok(hand) => hand,
            Err(error) => return self.apply(Command::FileFailed { name: file, reason: error.to_string() }),
        };
        let arm = self.document.scene.arm.name();
        let sentence = format!("The {arm} arm has the hand {:?} now. Undo gives its own back.", hand.name);
        let mut effects = self.edit_scene(|scene| scene.set_hand(hand));
        if !effects.is_empty() {
            self.playback.playing = false;
            self.say(false, sentence.clone(), Vec::new());
            effects.push(Effect::Announce(sentence));
        }
        effects
    }

    /// Changes the document as one step of undo; nothing happens if nothing changed.
    pub(super) fn edit(&mut self, change: impl FnOnce(&mut Document)) -> Vec<Effect> {
        let mut document = self.document.clone();
        change(&mut document);
        if document == self.document {
            return Vec::new();
        }
        (self.fallback, self.restoring) = (None, None);
        self.planning.drag = GoalDrag::default();
        self.history.record(self.document.clone());
        self.set_document(document);
        self.run()
    }

    pub(super) fn edit_scene(&mut self, change: impl FnOnce(&mut Scene)) -> Vec<Effect> {
        let seed = self.document.scene.seed;
        self.edit(|document| {
            change(Arc::make_mut(&mut document.scene));
            // Another robot, arm or seed makes other candidates, so a number asked for earlier means nothing.
            document.grasp = None;
            if document.scene.seed != seed {
                // Another cloud: its clusters may come in another order.
                document.shape = None;
            }
        })
    }

    fn replace(&mut self, document: Document) -> Vec<Effect> {
        self.fallback = None;
        self.planning.drag = GoalDrag::default();
        self.posing.recall_all();
        let scene = document.scene.clone();
        self.demo = self.demos.iter().find(|demo| demo.scene.name == scene.name).map(|demo| demo.name.clone());
        self.set_document(document);
        self.run()
    }

    fn cancel(&mut self) -> Vec<Effect> {
        if !self.running {
            return Vec::new();
        }
        self.running = false;
        self.forget_drag();
        for stage in Stage::ALL {
            if matches!(self.stage(stage), StageState::Running { .. }) {
                let old = self.outputs.revision(stage).is_some();
                *self.stage_mut(stage) = if old { StageState::Stale } else { StageState::Waiting };
            }
        }
        vec![Effect::Cancel]
    }

    /// Starts the presentation, which plays the plan in a loop, or ends it.
    fn present(&mut self, wanted: bool) -> Vec<Effect> {
        if self.is_embedded && !wanted {
            return Vec::new();
        }
        match (self.presentation.take(), wanted) {
            (presentation @ Some(_), true) => {
                self.presentation = presentation;
                Vec::new()
            }
            (None, false) => Vec::new(),
            (None, true) => {
                self.presentation = Some(Presentation { was_looping: self.playback.looping });
                (self.overlay, self.drawer) = (Overlay::None, None);
                self.playback.looping = true;
                let mut effects = self.apply(Command::SetPlaying(true));
                effects.push(Effect::View(ViewEffect::FrameAll));
                effects
            }
            (Some(Presentation { was_looping }), false) => {
                self.playback.looping = was_looping;
                self.playback.playing = false;
                vec![Effect::View(ViewEffect::FrameAll)]
            }
        }
    }

    fn seek(&mut self, time_s: f64) {
        if time_s.is_finite() {
            self.playback.time_s = time_s.max(0.0).min(self.duration_s());
            self.lab.is_open = false;
            self.selection.ik = None;
            self.planning.selected_try = None;
        }
    }

    pub(super) fn select_grasp(&mut self, id: u32) {
        if self.outputs.candidate(id).is_none() {
            return;
        }
        if self.selection.grasp != Some(id) {
            self.selection.ik = None;
        }
        self.selection.grasp = Some(id);
        if !matches!(self.selection.step, Step::Stage(Stage::Grasps | Stage::Rank)) {
            self.selection.step = Step::Stage(if self.outputs.rank.is_some() { Stage::Rank } else { Stage::Grasps });
        }
    }

    fn escape(&mut self) -> Vec<Effect> {
        if self.is_dragging_goal() {
            return self.cancel_goal_drag();
        }
        if self.presentation.is_some() && self.overlay == Overlay::None {
            return self.present(false);
        }
        if self.grasping.draws_region {
            self.grasping.draws_region = false;
        } else if self.overlay != Overlay::None {
            self.overlay = Overlay::None;
        } else if self.looking.measured.is_some() {
            self.looking.measured = None;
        } else if self.tour.is_some() {
            return self.apply_tour(TourCommand::End);
        } else if self.shown_voxel().is_some() {
            self.reaching.let_go();
        } else if self.posing.is_open {
            self.posing.is_open = false;
        } else if self.drawer.is_some() {
            self.drawer = None;
        } else if self.planning.selected_try.is_some() {
            self.planning.selected_try = None;
        } else if self.selection.ik.is_some() {
            self.selection.ik = None;
        } else {
            self.messages.clear();
        }
        Vec::new()
    }
}

/// Reads a scene file.
fn read_scene(bytes: &[u8]) -> Result<Scene, String> {
    let scene: Scene = serde_json::from_slice(bytes).map_err(|error| format!("it is no scene of ours ({error})"))?;
    if scene.version != SCENE_VERSION {
        return Err(format!("its format has version {}, this program reads version {SCENE_VERSION}", scene.version));
    }
    Ok(scene)
}
