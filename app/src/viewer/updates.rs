//! What comes back from the pipeline, put in its place.

use endcomfort_core::job::{Output, Refusal, Stage, Update};

use super::state::{StageState, Step};
use super::{Effect, Overlay, ViewerState};

impl ViewerState {
    /// Takes an update; one that belongs to another revision is dropped.
    pub fn receive(&mut self, update: Update) -> Vec<Effect> {
        let effects = self.take(update);
        self.look_around();
        effects
    }

    fn take(&mut self, update: Update) -> Vec<Effect> {
        let update = match self.receive_in_lab(update) {
            Ok(effects) => return effects,
            Err(update) => update,
        };
        let revision = match &update {
            Update::Progress { revision, .. }
            | Update::Mapping { revision, .. }
            | Update::Done { revision, .. }
            | Update::Refused { revision, .. }
            | Update::Finished { revision } => *revision,
        };
        let is_answer = match &update {
            Update::Done { output, .. } => matches!(**output, Output::Plan(_)),
            Update::Refused { .. } | Update::Finished { .. } => true,
            Update::Progress { .. } | Update::Mapping { .. } => false,
        };
        let mut effects = if revision == self.revision {
            self.receive_present(revision, update)
        } else {
            self.receive_while_dragging(revision, update);
            Vec::new()
        };
        if is_answer {
            effects.extend(self.goal_answered(revision));
            if revision == self.revision {
                effects.extend(self.restore_view());
            }
        }
        effects
    }

    /// Takes an update for the present document.
    fn receive_present(&mut self, revision: u64, update: Update) -> Vec<Effect> {
        match update {
            Update::Progress { stage, fraction, note, .. } => {
                *self.stage_mut(stage) = StageState::Running { fraction: fraction.max(0.0).min(1.0), note };
                Vec::new()
            }
            Update::Mapping { fraction, note, .. } => {
                self.map_progress(fraction, note);
                Vec::new()
            }
            Update::Done { elapsed_ms, output, .. } => {
                let output = match *output {
                    Output::Map(built) => return self.map_built(elapsed_ms, *built),
                    output => output,
                };
                let stage = self.outputs.put(revision, output);
                self.outputs_version += 1;
                let Some(stage) = stage else { return Vec::new() };
                *self.stage_mut(stage) = StageState::Done { elapsed_ms };
                self.stage_stands(stage)
            }
            Update::Refused { stage, refusal, .. } => self.refused(stage, refusal),
            Update::Finished { .. } => {
                self.running = false;
                for stage in Stage::ALL {
                    if matches!(self.stage(stage), StageState::Running { .. }) {
                        *self.stage_mut(stage) = StageState::Waiting;
                    }
                }
                Vec::new()
            }
        }
    }

    /// A new result stands: selections that pointed into the old one follow.
    fn stage_stands(&mut self, stage: Stage) -> Vec<Effect> {
        match stage {
            Stage::Scene => {
                self.fallback = None;
                Vec::new()
            }
            Stage::Segment => {
                self.selection.cluster = self.outputs.segment.as_ref().map(|segment| segment.target);
                Vec::new()
            }
            Stage::Fit | Stage::Grasps => Vec::new(),
            Stage::Rank => {
                let kept = self.selection.grasp.filter(|&id| self.outputs.rank_of(id).is_some());
                let first = self.outputs.rank.as_ref().and_then(|rank| rank.grasps.first()).map(|grasp| grasp.id);
                self.selection.grasp = self.document.grasp.or(kept).or(first);
                self.selection.ik = None;
                Vec::new()
            }
            Stage::Plan => {
                self.plan_stands();
                if self.is_dragging_goal() {
                    // Answers come many times a second: none is announced, and the robot stays where it is.
                    self.playback.time_s = self.playback.time_s.min(self.duration_s());
                    return Vec::new();
                }
                self.playback.time_s = 0.0;
                self.selection.grasp = self.outputs.plan.as_ref().map(|plan| plan.grasp().id);
                self.selection.ik = None;
                // Behind the gallery something shall move.
                self.playback.playing = self.overlay == Overlay::Gallery || self.presentation.is_some();
                self.playback.looping |= self.playback.playing;
                vec![Effect::Announce(format!("{}: the plan is ready.", self.document.scene.title))]
            }
        }
    }

    fn refused(&mut self, stage: Stage, refusal: Refusal) -> Vec<Effect> {
        self.running = false;
        let sentence = refusal.message.clone();
        if stage == Stage::Scene
            && let Some(standing) = self.fallback.take()
        {
            // The file cannot be read: what stood before it stands again, results included.
            let _unreadable = self.history.forget();
            self.document = standing.document;
            self.revision = standing.revision;
            self.stages = standing.stages;
            self.outputs = standing.outputs;
            self.demo = standing.demo;
            self.restoring = None;
            self.outputs_version += 1;
            self.say(true, refusal.message, refusal.details);
            return vec![Effect::Announce(sentence)];
        }
        self.outputs.drop_from(stage);
        self.outputs_version += 1;
        for later in Stage::ALL.into_iter().filter(|&later| later > stage) {
            *self.stage_mut(later) = StageState::Waiting;
        }
        *self.stage_mut(stage) = StageState::Refused(refusal);
        self.playback.playing = false;
        self.selection.ik = None;
        self.planning.selected_try = None;
        // Whoever works on the fit or on the grasps stays there: the stepper says what became of the later stages.
        let works = match self.selection.step {
            Step::Stage(step) if step < stage => step == Stage::Fit || self.edits_grasps(),
            _ => self.edits_task(),
        };
        if !works {
            self.selection.step = Step::Stage(stage);
        }
        if self.is_dragging_goal() {
            return Vec::new();
        }
        vec![Effect::Announce(format!("{} refused: {sentence}", stage.title()))]
    }
}
