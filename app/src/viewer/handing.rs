//! A handover as a person examines and changes it: who takes part, where the receiver stands, which place is looked at.

use std::f64::consts::{PI, TAU};

use endcomfort_core::handover::{Agent, Handover, HandoverReport, PERSON, Receiver};
use endcomfort_core::scene::Scene;

use super::goal_drag::FARTHEST_M;
use super::{Effect, ViewerState, format};

/// What a person does with a handover.
#[derive(Clone, Debug, PartialEq)]
pub enum HandoverCommand {
    /// Asks for another handover: another receiver, or another choice of the place.
    Set(Box<Handover>),
    /// Moves the receiver while it is dragged.
    DragReceiver(Box<Agent>),
    /// The receiver has been let go.
    EndDrag,
    /// Points at a place.
    HoverPlace(Option<usize>),
    /// Goes on showing a place when it is no longer pointed at; `None` the one that is used.
    ShowPlace(Option<usize>),
}

/// One of the two who take part in a handover.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Partner {
    /// At the head of a row: `Hubo`, `Person`, `Left hand`.
    pub(super) title: String,
    /// Within a sentence: `Hubo`, `the person`, `the left hand`.
    pub(super) words: String,
}

impl Partner {
    fn named(title: String) -> Self {
        Self { words: title.clone(), title }
    }

    fn hand(side: &str) -> Self {
        Self { title: format!("{} hand", format::title_of(side)), words: format!("the {side} hand") }
    }

    fn agent(agent: &Agent) -> Self {
        match agent.model.as_str() {
            PERSON => Self { title: "Person".to_owned(), words: "the person".to_owned() },
            model => Self::named(format::title_of(model)),
        }
    }

    /// At the beginning of a sentence.
    pub(super) fn subject(&self) -> String {
        format::title_of(&self.words)
    }
}

/// Everybody in a scene whose robot has this title: `Alita and Hubo`.
pub(super) fn everybody(scene: &Scene, robot_title: String) -> String {
    match scene.handover.as_ref().and_then(Handover::agent) {
        None => robot_title,
        Some(agent) if agent.model == PERSON => format!("{robot_title} and a person"),
        Some(agent) => format!("{robot_title} and {}", format::title_of(&agent.model)),
    }
}

impl ViewerState {
    /// Everybody in the scene, short: `Alita, Hubo`.
    pub fn who_is_there(&self) -> String {
        match self.receiver() {
            None => self.robot_title(),
            Some(agent) => format!("{}, {}", self.robot_title(), format::title_of(&agent.model)),
        }
    }

    /// Who receives the object, if it is not the robot itself.
    pub fn receiver(&self) -> Option<&Agent> {
        self.document.scene.handover.as_ref()?.agent()
    }

    /// The receiver, while it can be moved in the view.
    pub(super) fn movable_receiver(&self) -> Option<&Agent> {
        self.receiver().filter(|_| self.has_gizmo())
    }

    /// How the place of the present plan's handover was chosen.
    pub fn handover_report(&self) -> Option<&HandoverReport> {
        self.outputs.plan.as_ref()?.handover.as_deref()
    }

    /// Giver and receiver of a handover.
    pub(super) fn partners(&self) -> Option<[Partner; 2]> {
        let handover = self.document.scene.handover.as_ref()?;
        Some(match &handover.receiver {
            Receiver::Agent(agent) => [Partner::named(self.robot_title()), Partner::agent(agent)],
            Receiver::OtherHand => match self.handover_report() {
                Some(report) => report.arms.each_ref().map(|arm| Partner::hand(arm)),
                None => ["giving", "taking"].map(Partner::hand),
            },
        })
    }

    /// The place of the handover that the view shows instead of the one that is used.
    pub fn shown_place(&self) -> Option<usize> {
        let count = self.handover_report().map_or(0, |report| report.places.len());
        self.planning.hovered_place.or(self.planning.selected_place).filter(|&index| index < count)
    }

    pub(super) fn apply_handover(&mut self, command: HandoverCommand) -> Vec<Effect> {
        match command {
            HandoverCommand::Set(handover) => return self.edit_task(|scene| scene.handover = Some(*handover)),
            HandoverCommand::DragReceiver(agent) => return self.drag_receiver(*agent),
            HandoverCommand::EndDrag => return self.end_goal_drag(),
            HandoverCommand::HoverPlace(index) => self.planning.hovered_place = index,
            HandoverCommand::ShowPlace(index) => self.planning.selected_place = index,
        }
        Vec::new()
    }

    /// Lets the receiver stand somewhere else, as one step of undo with the rest of the drag.
    fn drag_receiver(&mut self, mut to: Agent) -> Vec<Effect> {
        if to.position_m.iter().any(|m| m.abs() > FARTHEST_M) {
            return Vec::new();
        }
        to.yaw_rad = (to.yaw_rad + PI).rem_euclid(TAU) - PI;
        self.drag(|scene| {
            if let Some(Handover { receiver: Receiver::Agent(agent), .. }) = &mut scene.handover {
                **agent = to;
            }
        })
    }
}
