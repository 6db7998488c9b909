//! What a plan is asked for, and the history of edits to it.

use std::sync::Arc;

use endcomfort_core::job::{DroppedCloud, Request, SetShape, Stage};
use endcomfort_core::scene::Scene;

use crate::assets;

/// Everything that a person can change and that changes the result: one step of undo.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// The scene.
    pub scene: Arc<Scene>,
    /// A cloud that was dropped instead of the scene's own objects.
    pub cloud: Option<Arc<DroppedCloud>>,
    /// The cluster to grasp; `None` leaves it to the pipeline.
    pub cluster: Option<usize>,
    /// The grasp to plan with; `None` tries them in their order of rank.
    pub grasp: Option<u32>,
    /// A shape that a person set in place of a cluster's fit.
    pub shape: Option<SetShape>,
}

impl Document {
    /// A scene as it was opened.
    pub fn new(scene: Arc<Scene>) -> Self {
        Self { scene, cloud: None, cluster: None, grasp: None, shape: None }
    }

    /// The request that runs the pipeline for this document.
    pub fn request(&self, revision: u64) -> Request {
        Request {
            revision,
            cloud: self.cloud.as_deref().cloned(),
            objects: assets::library().brought(&self.scene),
            robot: assets::library().guest(&self.scene.robot).map(|guest| guest.robot.clone()),
            cluster: self.cluster,
            grasp: self.grasp,
            shape: self.shape,
            ..Request::new((*self.scene).clone())
        }
    }

    /// The first stage whose answer may differ between two documents; for equal ones the last stage.
    pub(super) fn first_difference(&self, other: &Self) -> Stage {
        // What a stage takes from the document beyond what the stages before it take, last stage first: with that made
        // equal, the difference is in this stage or later ones.
        let mut theirs = other.clone();
        theirs.grasp = self.grasp;
        if theirs == *self {
            return Stage::Plan;
        }
        let scene = Arc::make_mut(&mut theirs.scene);
        if scene.motion.straight_ways() == self.scene.motion.straight_ways() {
            scene.motion = self.scene.motion.clone();
            if theirs == *self {
                return Stage::Plan;
            }
        }
        let scene = Arc::make_mut(&mut theirs.scene);
        scene.motion = self.scene.motion.clone();
        scene.rank = self.scene.rank.clone();
        if theirs == *self {
            return Stage::Rank;
        }
        let scene = Arc::make_mut(&mut theirs.scene);
        scene.grasp = self.scene.grasp.clone();
        scene.task.steps = self.scene.task.steps.clone();
        scene.handover = self.scene.handover.clone();
        (scene.robot, scene.posture) = (self.scene.robot.clone(), self.scene.posture.clone());
        scene.joints = self.scene.joints.clone();
        (scene.arm, scene.torso, scene.hand) = (self.scene.arm, self.scene.torso, self.scene.hand.clone());
        if theirs == *self {
            return Stage::Grasps;
        }
        theirs.shape = self.shape;
        Arc::make_mut(&mut theirs.scene).fit = self.scene.fit.clone();
        if theirs == *self { Stage::Fit } else { Stage::Scene }
    }
}

/// Documents before and after the present one.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    past: Vec<Document>,
    future: Vec<Document>,
}

impl History {
    /// More steps than anybody undoes; dropped clouds are shared, so a step is small.
    const LONGEST: usize = 200;

    /// Remembers the document that an edit replaces.
    pub(super) fn record(&mut self, replaced: Document) {
        self.future.clear();
        self.past.push(replaced);
        if self.past.len() > Self::LONGEST {
            self.past.remove(0);
        }
    }

    /// The document before the newest edit.
    pub(super) fn newest(&self) -> Option<&Document> {
        self.past.last()
    }

    /// Forgets the newest step: its edit never came to stand.
    pub(super) fn forget(&mut self) -> Option<Document> {
        self.past.pop()
    }

    pub(super) fn undo(&mut self, present: &Document) -> Option<Document> {
        let document = self.past.pop()?;
        self.future.push(present.clone());
        Some(document)
    }

    pub(super) fn redo(&mut self, present: &Document) -> Option<Document> {
        let document = self.future.pop()?;
        self.past.push(present.clone());
        Some(document)
    }

    pub(super) fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub(super) fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use endcomfort_core::grasp::RankBy;
    use endcomfort_core::handover::{Handover, PlaceChoice, Receiver};

    use super::*;

    #[test]
    fn an_edit_reaches_no_stage_before_the_one_that_it_is_about() {
        let document = Document::new(Arc::new(assets::demo("jar").expect("the demo is there")));
        let edited = |edit: &dyn Fn(&mut Scene)| {
            let mut other = document.clone();
            edit(Arc::make_mut(&mut other.scene));
            document.first_difference(&other)
        };
        assert_eq!(edited(&|_| {}), Stage::Plan);
        assert_eq!(edited(&|scene| scene.rank.by = RankBy::Mean), Stage::Rank);
        assert_eq!(edited(&|scene| scene.grasp.friction = 0.9), Stage::Grasps);
        assert_eq!(edited(&|scene| scene.task.steps.clear()), Stage::Grasps);
        assert_eq!(edited(&|scene| scene.torso = true), Stage::Grasps);
        assert_eq!(edited(&|scene| _ = scene.joints.insert("left_arm_1".to_owned(), 0.1)), Stage::Grasps);
        let hand_to_hand = Handover { receiver: Receiver::OtherHand, giver_arm: None, choice: PlaceChoice::default() };
        assert_eq!(edited(&|scene| scene.handover = Some(hand_to_hand.clone())), Stage::Grasps);
        assert_eq!(edited(&|scene| scene.robot = "alita".to_owned()), Stage::Grasps);
        assert_eq!(edited(&|scene| scene.fit.voxel_m = 0.01), Stage::Fit);
        assert_eq!(edited(&|scene| scene.seed += 1), Stage::Scene);
        let both = edited(&|scene| {
            scene.rank.by = RankBy::Mean;
            scene.fit.voxel_m = 0.01;
        });
        assert_eq!(both, Stage::Fit);
    }
}
