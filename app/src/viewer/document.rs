//! What a plan is asked for, and the history of edits to it.

use std::sync::Arc;

use endcomfort_core::job::{DroppedCloud, Request, SetShape, Stage};
use endcomfort_core::scene::Scene;

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
            cluster: self.cluster,
            grasp: self.grasp,
            shape: self.shape,
            ..Request::new((*self.scene).clone())
        }
    }

    /// The first stage whose answer may differ between two documents.
    pub(super) fn first_difference(&self, other: &Self) -> Stage {
        let (mut mine, mut others) = (self.clone(), other.clone());
        for document in [&mut mine, &mut others] {
            document.shape = None;
            document.grasp = None;
        }
        if mine.scene.fit != others.scene.fit {
            Arc::make_mut(&mut mine.scene).fit = others.scene.fit.clone();
        }
        if mine == others { Stage::Fit } else { Stage::Scene }
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
