//! Plans as a person examines them: what is shown of one, what it is asked for, and what it is compared with.

use std::sync::Arc;

use endcomfort_core::handover::{Handover, Receiver};
use endcomfort_core::job::Stage;
use endcomfort_core::scene::{Scene, Step as TaskStep};
use endcomfort_core::task::{MotionSettings, Planner, Try};

use nalgebra::Isometry3;

use super::goal_drag::GoalDrag;
use super::state::{StageState, Step};
use super::{Curve, Effect, Kept, Measures, ViewerState, format, measures};
use crate::assets;
use crate::export::MotionFormat;

/// What a person does with plans.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanCommand {
    /// Opens a page of the inspector at the step Plan.
    Page(PlanPage),
    /// Asks for another motion.
    Settings(MotionSettings),
    /// Takes this route of the hand, by its number; `None` the first that the arm can follow.
    ChooseRoute(Option<usize>),
    /// Points at a route.
    HoverRoute(Option<usize>),
    /// Points at a try.
    HoverTry(Option<usize>),
    /// Shows a try, or the plan again.
    ShowTry(Option<usize>),
    /// Selects a step of the task.
    SelectGoal(usize),
    /// Asks for other steps of the task.
    Steps(Vec<TaskStep>),
    /// Moves the goal of a step while it is dragged.
    DragGoal { step: usize, X_WO_goal: Isometry3<f64> },
    /// The goal has been let go.
    EndDrag,
    /// Draws so many ghosts of the arm.
    Ghosts(usize),
    /// Keeps the present plan to compare others with.
    Keep,
    /// Forgets the kept plan.
    ForgetKept,
    /// Saves the planned motion.
    Export(MotionFormat),
    /// Opens a page of the inspector at the step Play.
    PlayPage(PlayPage),
    /// Plots this of every joint.
    Plot(Curve),
    /// Plots everything of one joint, by its place in the arm; `None` one thing of every joint.
    PlotJoint(Option<usize>),
}

/// A page of the inspector at the step Plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlanPage {
    /// Numbers and phases.
    #[default]
    Plan,
    /// What was tried in vain.
    Tried,
    /// Routes of the hand.
    Routes,
    /// Who gives and takes where, and what else could have been.
    Handover,
    /// What the robot shall do.
    Task,
    /// How the robot moves.
    Settings,
}

impl PlanPage {
    /// The pages while there is a plan.
    pub const ALL: [Self; 5] = [Self::Plan, Self::Tried, Self::Routes, Self::Task, Self::Settings];
    /// The pages when the task was refused.
    pub const REFUSED: [Self; 3] = [Self::Tried, Self::Task, Self::Settings];
    /// The pages while there is no plan yet.
    pub const WITHOUT: [Self; 2] = [Self::Task, Self::Settings];
    /// The pages of a handover to the other hand: with a plan, refused, without.
    const HAND_TO_HAND: [&'static [Self]; 3] = [
        &[Self::Plan, Self::Handover, Self::Tried, Self::Task, Self::Settings],
        &[Self::Tried, Self::Handover, Self::Task, Self::Settings],
        &[Self::Handover, Self::Task, Self::Settings],
    ];
    /// Of one to somebody else, whose goal is the receiver's.
    const TO_AGENT: [&'static [Self]; 3] = [
        &[Self::Plan, Self::Handover, Self::Tried, Self::Settings],
        &[Self::Tried, Self::Handover, Self::Settings],
        &[Self::Handover, Self::Settings],
    ];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Plan => "Plan",
            Self::Tried => "Tried",
            Self::Routes => "Routes",
            Self::Handover => "Handover",
            Self::Task => "Task",
            Self::Settings => "Settings",
        }
    }
}

/// A page of the inspector at the step Play.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlayPage {
    /// What happens now.
    #[default]
    Moment,
    /// Every joint over time.
    Joints,
}

impl PlayPage {
    /// All pages.
    pub const ALL: [Self; 2] = [Self::Moment, Self::Joints];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Moment => "Moment",
            Self::Joints => "Joints",
        }
    }
}

/// Most ghosts that are drawn.
pub(super) const MAX_GHOSTS: usize = 40;

/// How plans are examined.
#[derive(Clone, Debug)]
pub struct Planning {
    /// The open page at the step Plan.
    pub page: PlanPage,
    /// The open page at the step Play.
    pub play_page: PlayPage,
    /// What is plotted of every joint.
    pub curve: Curve,
    /// The joint of which everything is plotted, by its place in the arm.
    pub joint: Option<usize>,
    /// How many ghosts of the arm are drawn along the plan.
    pub ghosts: usize,
    /// The try whose row is under the pointer.
    pub hovered_try: Option<usize>,
    /// The try that is shown while no other one is pointed at.
    pub selected_try: Option<usize>,
    /// The route whose row is under the pointer.
    pub hovered_route: Option<usize>,
    /// The place of the handover that is pointed at, and the one that stays shown while none is.
    pub hovered_place: Option<usize>,
    /// See [`Planning::hovered_place`].
    pub selected_place: Option<usize>,
    /// The step of the task that is edited.
    pub step: usize,
    /// The plan that others are compared with.
    pub kept: Option<Kept>,
    /// Numbers of the present plan.
    pub measures: Option<Measures>,
    kept_so_far: u64,
    pub(super) drag: GoalDrag,
}

impl Default for Planning {
    fn default() -> Self {
        Self {
            page: PlanPage::default(),
            play_page: PlayPage::default(),
            curve: Curve::default(),
            joint: None,
            ghosts: 10,
            hovered_try: None,
            selected_try: None,
            hovered_route: None,
            hovered_place: None,
            selected_place: None,
            step: 0,
            kept: None,
            measures: None,
            kept_so_far: 0,
            drag: GoalDrag::default(),
        }
    }
}

/// What examining plans adds to the picture; equal values give equal pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanningKey {
    /// How many ghosts are drawn.
    pub ghosts: usize,
    /// The try that is shown, into [`ViewerState::tries`].
    pub shown_try: Option<usize>,
    /// The route that is pointed at.
    pub hovered_route: Option<usize>,
    /// The place of the handover that is looked at instead of the chosen one.
    pub shown_place: Option<usize>,
    /// Number of the kept plan.
    pub kept: Option<u64>,
    /// The step of the task whose goal can be moved.
    pub goal_step: Option<usize>,
}

impl ViewerState {
    /// What was tried in vain: before the present plan, or before the task was refused.
    pub fn tries(&self) -> &[Try] {
        match (self.stage(Stage::Plan), &self.outputs.plan) {
            (StageState::Refused(refusal), _) => &refusal.tries,
            (_, Some(plan)) => &plan.tries,
            _ => &[],
        }
    }

    /// The try that the view shows.
    pub fn shown_try(&self) -> Option<usize> {
        let is_open = self.selection.step == Step::Stage(Stage::Plan) && !self.playback.playing;
        let selected = self.planning.selected_try.filter(|_| self.plan_page() == PlanPage::Tried);
        self.planning.hovered_try.or(selected).filter(|&index| is_open && index < self.tries().len())
    }

    /// The open page at the step Plan: one of those that there are.
    pub fn plan_page(&self) -> PlanPage {
        let pages = self.plan_pages();
        Some(self.planning.page).filter(|page| pages.contains(page)).unwrap_or(pages[0])
    }

    /// The pages that there are at the step Plan.
    pub fn plan_pages(&self) -> &'static [PlanPage] {
        let place = match (self.stage(Stage::Plan), &self.outputs.plan) {
            (StageState::Refused(_), _) => 1,
            (_, Some(_)) => 0,
            (_, None) => 2,
        };
        match &self.document.scene.handover {
            None => [&PlanPage::ALL[..], &PlanPage::REFUSED, &PlanPage::WITHOUT][place],
            Some(Handover { receiver: Receiver::OtherHand, .. }) => PlanPage::HAND_TO_HAND[place],
            Some(Handover { receiver: Receiver::Agent(_), .. }) => PlanPage::TO_AGENT[place],
        }
    }

    /// What examining plans adds to the picture.
    pub fn planning_key(&self) -> PlanningKey {
        PlanningKey {
            ghosts: self.planning.ghosts,
            shown_try: self.shown_try(),
            hovered_route: self.planning.hovered_route,
            shown_place: self.shown_place(),
            kept: self.planning.kept.as_ref().map(|kept| kept.number),
            goal_step: self.goal_step(),
        }
    }

    /// What a person calls a grasp: its rank, or its number where it has none.
    pub fn grasp_title(&self, id: u32) -> String {
        self.outputs.rank_of(id).map_or(format!("candidate {id}"), |rank| format!("grasp {rank}"))
    }

    pub(super) fn apply_planning(&mut self, command: PlanCommand) -> Vec<Effect> {
        let planning = &mut self.planning;
        match command {
            PlanCommand::Page(page) => planning.page = page,
            PlanCommand::Settings(motion) => return self.edit_task(|scene| scene.motion = motion),
            PlanCommand::ChooseRoute(route) => {
                return self.edit_task(|scene| {
                    scene.motion.planner = Planner::Routes;
                    scene.motion.route = route;
                });
            }
            PlanCommand::HoverRoute(index) => planning.hovered_route = index,
            PlanCommand::HoverTry(index) => planning.hovered_try = index,
            PlanCommand::ShowTry(index) => {
                planning.selected_try = index;
                planning.page = PlanPage::Tried;
                self.playback.playing = false;
            }
            PlanCommand::SelectGoal(step) => planning.step = step,
            PlanCommand::Steps(steps) => return self.edit_task(|scene| scene.task.steps = steps),
            PlanCommand::DragGoal { step, X_WO_goal } => return self.drag_goal(step, X_WO_goal),
            PlanCommand::EndDrag => return self.end_goal_drag(),
            PlanCommand::Ghosts(count) => planning.ghosts = count.clamp(1, MAX_GHOSTS),
            PlanCommand::Keep => self.keep_plan(),
            PlanCommand::Export(format) => return vec![Effect::ExportMotion(format)],
            PlanCommand::ForgetKept => planning.kept = None,
            PlanCommand::PlayPage(page) => planning.play_page = page,
            PlanCommand::Plot(curve) => planning.curve = curve,
            PlanCommand::PlotJoint(joint) => planning.joint = joint,
        }
        Vec::new()
    }

    /// Measures the plan that has come to stand.
    pub(super) fn plan_stands(&mut self) {
        (self.planning.selected_try, self.planning.selected_place) = (None, None);
        let robot = assets::library().robot_of(&self.document.scene).ok();
        self.planning.measures = match (&self.outputs.plan, robot) {
            (Some(plan), Some(robot)) if plan.q_start.len() == robot.dof_count() => {
                Some(Measures::of(plan, &robot, self.arm_joint_count()))
            }
            _ => None,
        };
    }

    fn keep_plan(&mut self) {
        let (Some(plan), Some(measures)) = (&self.outputs.plan, &self.planning.measures) else { return };
        let Ok(robot) = assets::library().robot_of(&self.document.scene) else { return };
        if plan.q_start.len() != robot.dof_count() {
            return;
        }
        let planner = planner_title(self.document.scene.motion.planner);
        let title = format!("{}, {planner}", format::title_of(&self.grasp_title(plan.grasp().id)));
        let trail = Arc::new(measures::trail(plan, &robot));
        self.planning.kept_so_far += 1;
        let number = self.planning.kept_so_far;
        self.planning.kept = Some(Kept { number, title, measures: measures.clone(), trail });
    }

    /// Edits task or motion unless a number would leave its range: then the person is told, and nothing changes.
    pub(super) fn edit_task(&mut self, change: impl FnOnce(&mut Scene)) -> Vec<Effect> {
        let grasp = self.document.grasp;
        let mut scene = (*self.document.scene).clone();
        change(&mut scene);
        match scene.clone().checked() {
            // Candidates keep their numbers, so the one that was asked for is still meant.
            Ok(_) => self.edit(|document| {
                document.scene = Arc::new(scene);
                document.grasp = grasp;
            }),
            Err(error) => {
                let sentence = format!("That setting cannot be: {error}.");
                self.say(true, sentence.clone(), Vec::new());
                vec![Effect::Announce(sentence)]
            }
        }
    }
}

/// What a person calls a planner.
pub fn planner_title(planner: Planner) -> &'static str {
    match planner {
        Planner::Search => "Search",
        Planner::Roadmap => "Roadmap",
        Planner::Routes => "Routes",
    }
}
