//! What happens in a phase, in words: a caption for an audience, and a short one for the timeline.

use endcomfort_core::task::{PhaseKind, Plan};

use super::ViewerState;

impl ViewerState {
    /// What happens in a phase of the plan as a sentence: `Alita presents the mustard bottle to Hubo`.
    pub fn caption(&self, plan: &Plan, phase: usize) -> String {
        let Some(about) = plan.phases.get(phase) else { return String::new() };
        let object = self.object_words();
        let Some([giver, receiver]) = self.partners() else {
            let robot = self.robot_title();
            return match about.kind {
                PhaseKind::Reach => format!("{robot} reaches for {object}"),
                PhaseKind::Close => format!("{robot} takes hold of it"),
                PhaseKind::Lift => format!("{robot} lifts {object}"),
                PhaseKind::Transport => format!("{robot} carries {object}"),
                PhaseKind::Pour => format!("{robot} holds {object} there"),
                PhaseKind::Slide => format!("{robot} slides {object}"),
                PhaseKind::Place => format!("{robot} puts {object} down"),
                PhaseKind::Open => format!("{robot} lets go"),
                PhaseKind::Retreat => format!("{robot} draws back"),
            };
        };
        let gives = about.leg == 0;
        let who = if gives { giver.subject() } else { receiver.subject() };
        match about.kind {
            PhaseKind::Reach => format!("{who} reaches for {object}"),
            PhaseKind::Close if gives => format!("{who} takes hold of it"),
            PhaseKind::Close => format!("{who} takes {object}"),
            PhaseKind::Lift => format!("{who} lifts {object}"),
            PhaseKind::Transport if gives => format!("{who} presents {object} to {}", receiver.words),
            PhaseKind::Transport | PhaseKind::Slide => format!("{who} brings {object} to its goal"),
            PhaseKind::Pour => format!("{who} holds {object} there"),
            PhaseKind::Place => format!("{who} puts {object} down"),
            PhaseKind::Open if gives => format!("{who} lets go: {} has it", receiver.words),
            PhaseKind::Open => format!("{who} lets go"),
            PhaseKind::Retreat => format!("{who} draws back"),
        }
    }

    /// The object of the task within a sentence: `the mustard bottle`.
    fn object_words(&self) -> String {
        let scene = &self.document.scene;
        match scene.objects.get(scene.task.object) {
            Some(placed) if self.document.cloud.is_none() => format!("the {}", placed.object.replace('_', " ")),
            _ => "the object".to_owned(),
        }
    }
}

/// What happens in a phase of a handover, short: who does it stands beside it.
pub(super) fn deed(plan: &Plan, phase: usize) -> &'static str {
    let Some(about) = plan.phases.get(phase) else { return "" };
    match (about.kind, about.leg) {
        (PhaseKind::Reach, _) => "reaches",
        (PhaseKind::Close, 0) => "grasps it",
        (PhaseKind::Close, _) => "takes it",
        (PhaseKind::Lift, _) => "lifts it",
        (PhaseKind::Transport, 0) => "presents it",
        (PhaseKind::Transport, _) => "carries it on",
        (PhaseKind::Slide, _) => "slides it",
        (PhaseKind::Pour, _) => "holds it",
        (PhaseKind::Place, _) => "puts it down",
        (PhaseKind::Open, _) => "lets go",
        (PhaseKind::Retreat, _) => "draws back",
    }
}

/// When the object changes hands, seconds: the giver lets go of what the receiver holds.
pub(super) fn changes_hands_s(plan: &Plan) -> Option<f64> {
    plan.handover.as_ref()?;
    let mut phases = plan.phases.iter().skip_while(|phase| phase.leg == 0);
    phases.find(|phase| phase.leg == 0 && phase.kind == PhaseKind::Open).map(|phase| phase.start_s)
}
