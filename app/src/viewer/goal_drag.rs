//! A goal or a receiver on its way: while it is dragged the scene changes live, and the pipeline plans again and again.
//!
//! A new plan is asked for once the last request has been answered, so that the worker is never flooded; answers for
//! where the goal was a moment ago are shown, as out of date, until the next one. The drag is one step of undo.

use std::sync::Arc;

use endcomfort_core::job::{Output, Stage, Update};
use endcomfort_core::scene::Scene;
use nalgebra::Isometry3;

use super::state::{StageState, Step};
use super::{Document, Effect, PlanPage, ViewerState};

/// A goal farther from the robot than this is a slip of the hand, metres.
pub(super) const FARTHEST_M: f64 = 3.0;

/// The drag of a goal.
#[derive(Clone, Debug, Default)]
pub(super) struct GoalDrag {
    /// The document before, once something moved.
    before: Option<Document>,
    /// Revision of the request that has not been answered yet.
    asked: Option<u64>,
    /// Whether something moved since then.
    is_owed: bool,
    /// Whether the camera sees what is moved, so that everything changes with it.
    is_seen: bool,
}

impl ViewerState {
    /// Whether a goal is being dragged.
    pub fn is_dragging_goal(&self) -> bool {
        self.planning.drag.before.is_some()
    }

    /// The step of the task whose goal can be moved in the view; `None` while the view shows something else.
    pub fn goal_step(&self) -> Option<usize> {
        let last = self.document.scene.task.steps.len().checked_sub(1)?;
        // Of somebody else's goal the task knows nothing.
        (self.has_gizmo() && self.receiver().is_none()).then_some(self.planning.step.min(last))
    }

    /// Whether goals and receivers can be moved in the view.
    pub(super) fn has_gizmo(&self) -> bool {
        let is_open = match self.selection.step {
            Step::Stage(Stage::Scene) => true,
            // Over routes and tries it would lie in the way.
            Step::Stage(Stage::Plan) => {
                matches!(self.plan_page(), PlanPage::Plan | PlanPage::Task | PlanPage::Handover)
            }
            _ => false,
        };
        let is_free =
            !self.playback.playing && !self.reaching.is_open && !self.posing.is_open && self.shown_try().is_none();
        is_open && is_free && self.presentation.is_none()
    }

    /// Whether somebody works on the task.
    pub(super) fn edits_task(&self) -> bool {
        let edits = || matches!(self.plan_page(), PlanPage::Task | PlanPage::Handover);
        self.is_dragging_goal() || self.selection.step == Step::Stage(Stage::Plan) && edits()
    }

    /// Moves the goal of a step.
    pub(super) fn drag_goal(&mut self, step: usize, X_WO_goal: Isometry3<f64>) -> Vec<Effect> {
        if X_WO_goal.translation.vector.amax() > FARTHEST_M {
            return Vec::new();
        }
        self.drag(|scene| {
            if let Some(step) = scene.task.steps.get_mut(step) {
                step.X_WO_goal = X_WO_goal;
            }
        })
    }

    /// As [`ViewerState::drag`] for what the camera sees, or for the camera itself.
    pub(super) fn drag_what_is_seen(&mut self, change: impl FnOnce(&mut Scene)) -> Vec<Effect> {
        self.planning.drag.is_seen = true;
        self.drag_document(|document| {
            change(Arc::make_mut(&mut document.scene));
            // Other points, other clusters, other candidates.
            (document.cluster, document.grasp, document.shape) = (None, None, None);
        })
    }

    /// Changes the scene while something is dragged; the first change of a drag is a step of undo.
    pub(super) fn drag(&mut self, change: impl FnOnce(&mut Scene)) -> Vec<Effect> {
        self.drag_document(|document| change(Arc::make_mut(&mut document.scene)))
    }

    fn drag_document(&mut self, change: impl FnOnce(&mut Document)) -> Vec<Effect> {
        let mut document = self.document.clone();
        change(&mut document);
        if document == self.document {
            return Vec::new();
        }
        if self.planning.drag.before.is_none() {
            self.fallback = None;
            self.playback.playing = false;
            self.history.record(self.document.clone());
            self.planning.drag.before = Some(self.document.clone());
        }
        self.set_document(document);
        self.ask_for_goal()
    }

    /// The goal has been let go: the plan for where it is now is asked for at once.
    pub(super) fn end_goal_drag(&mut self) -> Vec<Effect> {
        let drag = std::mem::take(&mut self.planning.drag);
        let Some(before) = drag.before else { return Vec::new() };
        if before == self.document {
            // Let go where it was taken up: there is nothing to undo.
            let _the_same = self.history.forget();
        }
        let is_answered = drag.asked.is_none() && !self.is_stale(Stage::Plan) && !self.running;
        if drag.asked == Some(self.revision) || is_answered { Vec::new() } else { self.run() }
    }

    /// Puts the goal back where it was taken up.
    pub(super) fn cancel_goal_drag(&mut self) -> Vec<Effect> {
        let Some(before) = std::mem::take(&mut self.planning.drag).before else { return Vec::new() };
        let _undone = self.history.forget();
        self.posing.recall_all();
        self.set_document(before);
        self.run()
    }

    fn ask_for_goal(&mut self) -> Vec<Effect> {
        if self.planning.drag.asked.is_some() {
            self.planning.drag.is_owed = true;
            return Vec::new();
        }
        self.planning.drag.asked = Some(self.revision);
        self.run()
    }

    /// Takes an update for where the goal was a moment ago.
    pub(super) fn receive_while_dragging(&mut self, revision: u64, update: Update) {
        let Update::Done { elapsed_ms, output, .. } = update else { return };
        if self.planning.drag.asked != Some(revision) {
            return;
        }
        // A drag of the goal or the receiver leaves what comes before the grasps as it is for any later moment too.
        let is_lasting =
            !self.planning.drag.is_seen && matches!(*output, Output::Scene(_) | Output::Segment(_) | Output::Fit(_));
        let dated = if is_lasting { self.revision } else { revision };
        let stage = self.outputs.put(dated, *output);
        self.outputs_version += 1;
        if let Some(stage) = stage.filter(|_| is_lasting) {
            *self.stage_mut(stage) = StageState::Done { elapsed_ms };
        }
        if stage == Some(Stage::Plan) {
            self.plan_stands();
            self.playback.time_s = self.playback.time_s.min(self.duration_s());
        }
    }

    /// The request of this revision is answered: the next one follows if the goal has moved on.
    pub(super) fn goal_answered(&mut self, revision: u64) -> Vec<Effect> {
        if self.planning.drag.asked != Some(revision) {
            return Vec::new();
        }
        self.planning.drag.asked = None;
        if std::mem::take(&mut self.planning.drag.is_owed) { self.ask_for_goal() } else { Vec::new() }
    }
}
