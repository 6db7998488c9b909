//! Everything the interface knows: the document, its results, and what a person selected.

use std::sync::Arc;

use endcomfort_core::grasp::{Grasp, Quantity, Situated};
use endcomfort_core::job::{Refusal, Stage};

use super::document::History;
use super::{
    Bringing, ComposeInput, Demo, Document, Grasping, Lab, Layers, Looking, Offer, Outputs, PanelSizes, Picturing,
    Planning, Playback, Posing, Posture, Reaching, RobotChoice, SharedView, TableView, Thing, Tour, ViewKey, Viewing,
};

/// Everything the interface knows. Panels read it; [`ViewerState::apply`] and [`ViewerState::receive`] change it.
pub struct ViewerState {
    /// What is asked for.
    pub document: Document,
    /// Revision of the document, new with every edit.
    pub revision: u64,
    /// Where each stage stands, in the order of [`Stage::ALL`].
    pub stages: [StageState; Stage::ALL.len()],
    /// Whether a request is under way.
    pub running: bool,
    /// Results so far.
    pub outputs: Outputs,
    /// What is selected.
    pub selection: Selection,
    /// What is under the pointer.
    pub hover: Hover,
    /// What the view shows.
    pub layers: Layers,
    /// Where the playing stands.
    pub playback: Playback,
    /// How the grasp table is sorted and filtered.
    pub table: TableView,
    /// How grasps are examined.
    pub grasping: Grasping,
    /// How plans are examined.
    pub planning: Planning,
    /// The fit under examination.
    pub lab: Lab,
    /// Reachability maps and how they are shown.
    pub reaching: Reaching,
    /// How the robot is posed by hand.
    pub posing: Posing,
    /// The thing of the scene that is selected.
    pub placing: Option<Thing>,
    /// How the view is looked at.
    pub viewing: Viewing,
    /// Sizes of the panels.
    pub sizes: PanelSizes,
    /// How closely the view is looked at.
    pub looking: Looking,
    /// Pictures and animations of the view.
    pub picturing: Picturing,
    /// What covers the page.
    pub overlay: Overlay,
    /// The tour for newcomers, while it runs.
    pub tour: Option<Tour>,
    /// The presentation without panels, while it runs.
    pub presentation: Option<Presentation>,
    /// In a narrow window, the side panel that is open.
    pub drawer: Option<Side>,
    /// What the person has to be told, oldest first.
    pub messages: Vec<Message>,
    /// The ready demos.
    pub demos: Vec<Demo>,
    /// Name of the demo that is open; `None` for a file.
    pub demo: Option<String>,
    /// What files leave open, while it is asked.
    pub bringing: Option<Bringing>,
    /// The robots.
    pub robots: Vec<RobotChoice>,
    /// Dark, light, or as the system has it.
    pub theme: ThemeChoice,
    /// What was open at the last visit.
    pub offer: Option<Offer>,
    /// Whether this is a part of somebody else's page: the presentation alone, which is not left.
    pub is_embedded: bool,
    pub(super) history: History,
    pub(super) newest_revision: u64,
    pub(super) outputs_version: u64,
    pub(super) next_message: u64,
    /// What stood before a file was opened, until its first stage stands.
    pub(super) fallback: Option<Box<Standing>>,
    /// How a link or a session was looked at, until its answer stands.
    pub(super) restoring: Option<SharedView>,
}

/// A document with its results: what is put back when a dropped file turns out to be unreadable.
pub(super) struct Standing {
    pub(super) document: Document,
    pub(super) revision: u64,
    pub(super) stages: [StageState; Stage::ALL.len()],
    pub(super) outputs: Outputs,
    pub(super) demo: Option<String>,
}

/// Where a stage stands.
#[derive(Clone, Debug, PartialEq)]
pub enum StageState {
    /// Not reached yet.
    Waiting,
    /// Under way: fraction in [0, 1] and a few words.
    Running { fraction: f64, note: String },
    /// Done for the present revision.
    Done { elapsed_ms: f64 },
    /// Cannot be done.
    Refused(Refusal),
    /// The result that is shown belongs to an older revision.
    Stale,
}

/// A row of the stepper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A stage of the pipeline.
    Stage(Stage),
    /// Playing the plan.
    Play,
}

impl Step {
    /// All rows.
    pub const ALL: [Self; 7] = [
        Self::Stage(Stage::Scene),
        Self::Stage(Stage::Segment),
        Self::Stage(Stage::Fit),
        Self::Stage(Stage::Grasps),
        Self::Stage(Stage::Rank),
        Self::Stage(Stage::Plan),
        Self::Play,
    ];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Stage(stage) => stage.title(),
            Self::Play => "Play",
        }
    }

    /// The row of this title, upper and lower case alike.
    pub fn named(title: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|step| step.title().eq_ignore_ascii_case(title))
    }
}

/// What is selected.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// The step whose question the inspector answers.
    pub step: Step,
    /// A cluster.
    pub cluster: Option<usize>,
    /// A grasp, by its number.
    pub grasp: Option<u32>,
    /// The IK solution that the robot shows; `None` while the plan or the start posture is shown.
    pub ik: Option<IkChoice>,
}

/// One solution of the selected grasp's IK set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IkChoice {
    /// Start or goal.
    pub at: Situation,
    /// Index into the set.
    pub index: usize,
}

/// Where the object stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    /// Where it was seen.
    Start,
    /// Where the task wants it.
    Goal,
}

impl Situation {
    /// The grasp's IK set there.
    pub fn of(self, grasp: &Grasp) -> Option<&Situated> {
        match self {
            Self::Start => grasp.start.as_ref(),
            Self::Goal => grasp.goal.as_ref(),
        }
    }
}

/// What is under the pointer, in a panel or in the view.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hover {
    /// A grasp, by its number.
    pub grasp: Option<u32>,
    /// A cluster.
    pub cluster: Option<usize>,
}

/// What covers the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlay {
    /// Nothing.
    None,
    /// The cards of the demos.
    Gallery,
    /// The list of keys.
    Help,
    /// Everything that can be done, to be looked for by its name.
    Palette,
    /// The window that saves what the view shows.
    Picture,
}

/// The view alone, with captions; what it changed is put back at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Presentation {
    /// Whether the plan was played in a loop before.
    pub(super) was_looping: bool,
}

/// A side panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Stepper and layers.
    Left,
    /// Inspector.
    Right,
}

/// A sentence for the person.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Its number.
    pub id: u64,
    /// Whether it reports a failure; a failure stays until it is closed.
    pub is_error: bool,
    /// One sentence: what happened, what still stands, what to do.
    pub text: String,
    /// Details, one per line.
    pub details: Vec<String>,
}

/// Which theme is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThemeChoice {
    /// As the system has it.
    #[default]
    System,
    /// Dark.
    Dark,
    /// Light.
    Light,
}

impl ViewerState {
    /// The state before anything ran.
    pub fn new(document: Document, demos: Vec<Demo>, robots: Vec<RobotChoice>) -> Self {
        Self {
            document,
            revision: 1,
            stages: std::array::from_fn(|_| StageState::Waiting),
            running: false,
            outputs: Outputs::default(),
            selection: Selection { step: Step::Stage(Stage::Scene), cluster: None, grasp: None, ik: None },
            hover: Hover::default(),
            layers: Layers::default(),
            playback: Playback::default(),
            table: TableView::default(),
            grasping: Grasping::default(),
            planning: Planning::default(),
            lab: Lab::default(),
            reaching: Reaching::default(),
            posing: Posing::default(),
            placing: None,
            viewing: Viewing::default(),
            sizes: PanelSizes::default(),
            looking: Looking::default(),
            picturing: Picturing::default(),
            overlay: Overlay::None,
            tour: None,
            presentation: None,
            drawer: None,
            messages: Vec::new(),
            demos,
            demo: None,
            bringing: None,
            robots,
            theme: ThemeChoice::System,
            offer: None,
            is_embedded: false,
            history: History::default(),
            newest_revision: 1,
            outputs_version: 0,
            next_message: 0,
            fallback: None,
            restoring: None,
        }
    }

    /// Where a stage stands.
    pub fn stage(&self, stage: Stage) -> &StageState {
        &self.stages[stage as usize]
    }

    pub(super) fn stage_mut(&mut self, stage: Stage) -> &mut StageState {
        &mut self.stages[stage as usize]
    }

    /// Whether the result that a stage shows belongs to an older revision.
    pub fn is_stale(&self, stage: Stage) -> bool {
        self.outputs.revision(stage).is_some_and(|revision| revision != self.revision)
    }

    /// The refusal that ended the last run, and its stage.
    pub fn refusal(&self) -> Option<(Stage, &Refusal)> {
        Stage::ALL.into_iter().find_map(|stage| match self.stage(stage) {
            StageState::Refused(refusal) => Some((stage, refusal)),
            _ => None,
        })
    }

    /// Length of the present plan, seconds; 0 without one.
    pub fn duration_s(&self) -> f64 {
        self.outputs.plan.as_ref().map_or(0.0, |plan| plan.duration_s())
    }

    /// The selected grasp.
    pub fn selected_grasp(&self) -> Option<&Grasp> {
        self.selection.grasp.and_then(|id| self.outputs.candidate(id))
    }

    /// Whether the task has a goal.
    pub fn has_goal(&self) -> bool {
        !self.document.scene.task.steps.is_empty()
    }

    /// What ranks grasps; `None` for a random order.
    pub fn ranking_quantity(&self) -> Option<Quantity> {
        self.document.scene.rank.by.quantity(self.has_goal())
    }

    /// What the grasps' colours mean.
    pub fn shown_quantity(&self) -> Quantity {
        self.grasping.colored_by.or_else(|| self.ranking_quantity()).unwrap_or(Quantity::MgStart)
    }

    /// How many bodies the object to grasp has.
    pub fn parts(&self) -> usize {
        self.target_fit().map_or(0, |fit| fit.bodies().count())
    }

    /// How many joints the planned arm has: as many as its grasp's IK solutions, seven if those are not there.
    pub(super) fn arm_joint_count(&self) -> usize {
        let grasp = self.outputs.plan.as_ref().map(|plan| plan.grasp());
        let solution = grasp.and_then(|grasp| grasp.start.as_ref()).and_then(|start| start.solutions.first());
        solution.map_or(7, Vec::len)
    }

    /// Whether there is an edit to undo.
    pub fn can_undo(&self) -> bool {
        self.history.can_undo()
    }

    /// Whether there is an edit to do again.
    pub fn can_redo(&self) -> bool {
        self.history.can_redo()
    }

    /// How the robot stands in the picture.
    pub fn posture(&self) -> Posture {
        match (self.selection.ik, self.selection.grasp, &self.outputs.plan) {
            _ if self.lab_key().is_some() || self.posing.is_open => Posture::Start,
            _ if self.shown_try().is_some_and(|index| !self.tries()[index].q.is_empty()) => {
                Posture::Try { index: self.shown_try().unwrap_or(0) }
            }
            _ if self.shown_voxel().is_some() => self.shown_voxel().map_or(Posture::Start, Posture::Reach),
            (Some(ik), Some(grasp), _) if !self.playback.playing => Posture::Ik { grasp, at: ik.at, index: ik.index },
            (_, _, Some(_)) => Posture::Plan { time_s: self.playback.time_s },
            _ => Posture::Start,
        }
    }

    /// What the picture is made from.
    pub fn compose_input(&self, dark: bool) -> ComposeInput<'_> {
        let lab = self.lab_key();
        ComposeInput {
            scene: &self.document.scene,
            document: &self.document,
            revision: self.revision,
            outputs: &self.outputs,
            selection: &self.selection,
            hover: &self.hover,
            layers: &self.layers,
            posture: self.posture(),
            grasping: self.grasping_key(),
            planning: self.planning_key(),
            cloud_look: self.looking.cloud,
            posing: self.posing_key(),
            tries: self.tries(),
            kept: self.planning.kept.as_ref(),
            reaching: &self.reaching,
            lab,
            is_presented: self.presentation.is_some(),
            trial: lab.and_then(|lab| self.comparison()?.fit(lab.objective?)),
            dark,
        }
    }

    /// What the picture depends on.
    pub fn view_key(&self, dark: bool) -> ViewKey {
        ViewKey {
            revision: self.revision,
            outputs_version: self.outputs_version,
            selection: self.selection.clone(),
            hover: self.hover.clone(),
            layers: self.layers,
            posture: self.posture(),
            grasping: self.grasping_key(),
            planning: self.planning_key(),
            cloud_look: self.looking.cloud,
            posing: self.posing_key(),
            reach: self.reaching.key(),
            lab: self.lab_key(),
            is_presented: self.presentation.is_some(),
            dark,
        }
    }

    /// Tells the person something.
    pub fn say(&mut self, is_error: bool, text: impl Into<String>, details: Vec<String>) {
        let text = text.into();
        self.messages.retain(|message| message.text != text);
        self.messages.push(Message { id: self.next_message, is_error, text, details });
        self.next_message += 1;
        // Three sentences are all that anybody reads at once.
        if self.messages.len() > 3 {
            self.messages.remove(0);
        }
    }

    /// What is put back when a file turns out to be unreadable; `None` while nothing stands.
    pub(super) fn standing(&self) -> Option<Box<Standing>> {
        (self.outputs.scene.is_some() && !self.is_stale(Stage::Scene)).then(|| {
            Box::new(Standing {
                document: self.document.clone(),
                revision: self.revision,
                stages: self.stages.clone(),
                outputs: self.outputs.clone(),
                demo: self.demo.clone(),
            })
        })
    }

    /// Shares the demo of this name.
    pub fn demo_named(&self, name: &str) -> Option<&Demo> {
        self.demos.iter().find(|demo| demo.name == name)
    }

    /// The robot that acts, as a person reads it.
    pub fn robot_title(&self) -> String {
        let name = &self.document.scene.robot;
        let known = self.robots.iter().find(|robot| robot.name == *name);
        let title = || super::format::title_of(endcomfort_core::guest::GuestRobot::title_of(name));
        known.map_or_else(title, |robot| robot.title.clone())
    }

    /// Replaces the document: a new revision, the old results stale until new ones stand. What the change does not
    /// reach stays as it is.
    pub(super) fn set_document(&mut self, document: Document) {
        let reach = self.document.first_difference(&document);
        let before = self.revision;
        self.newest_revision += 1;
        self.revision = self.newest_revision;
        self.document = document;
        self.know_guest(&self.document.scene.robot.clone());
        self.running = true;
        let first = self.outputs.keep_before(reach, before, self.revision);
        for stage in Stage::ALL.into_iter().filter(|&stage| stage >= first) {
            *self.stage_mut(stage) =
                if self.outputs.revision(stage).is_some() { StageState::Stale } else { StageState::Waiting };
        }
    }

    /// Shares the scene.
    pub fn scene(&self) -> &Arc<endcomfort_core::scene::Scene> {
        &self.document.scene
    }
}
