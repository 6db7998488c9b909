//! What the interface asks of the rest of the program: demos, robots, and the picture.

use std::sync::Arc;

use endcomfort_core::grasp::ExportFormat;
use endcomfort_core::scene::Scene;

use super::{ComposeInput, Document, Outputs, Picture};
use crate::export::MotionFormat;

/// The room behind the interface.
pub trait Studio {
    /// The ready demos in the order of the gallery.
    fn demos(&self) -> Vec<Demo>;

    /// The robots in the order of the switch.
    fn robots(&self) -> Vec<RobotChoice>;

    /// Writes the ranked grasps of the present state as text of a format.
    ///
    /// # Errors
    /// A sentence when there is nothing to write, or no robot to tell it of.
    fn export(&self, document: &Document, outputs: &Outputs, format: ExportFormat) -> Result<String, String>;

    /// The planned motion as a file.
    ///
    /// # Errors
    /// A sentence when there is nothing to export.
    fn export_motion(&self, document: &Document, outputs: &Outputs, format: MotionFormat) -> Result<Vec<u8>, String>;

    /// Makes the picture of the present state; called only when something changed.
    fn compose(&mut self, input: &ComposeInput<'_>) -> Picture;
}

/// A ready scene.
#[derive(Clone, Debug)]
pub struct Demo {
    /// Name on the command line and in links: `mustard`.
    pub name: String,
    /// The scene; its title and summary stand on the card.
    pub scene: Arc<Scene>,
    /// A PNG that our renderer made, about 3 : 2; without one the card shows a drawing.
    pub thumbnail: Option<Arc<[u8]>>,
}

/// A robot that can act.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotChoice {
    /// Name in scenes: `crichton`.
    pub name: String,
    /// What a person reads: `Crichton`.
    pub title: String,
    /// Posture of its SRDF from which it starts when a scene is handed to it.
    pub posture: String,
}
