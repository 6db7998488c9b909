//! The labels and the scale that stand over the view, for pictures without a window.

use endcomfort_core::job::{DroppedCloud, Output, Update};
use endcomfort_core::scene::Scene;
use std::sync::Arc;

use crate::render::{Camera, Target, Theme};
use crate::studio::BuiltInStudio;
use crate::viewer::{Document, Posture, Studio as _, ViewerState, Words, say_over};

/// Puts words over pictures of one scene.
pub(super) struct Labeller {
    state: ViewerState,
    studio: BuiltInStudio,
    words: Option<Words>,
}

impl Labeller {
    /// What the interface would say of these results.
    pub(super) fn new(scene: &Scene, cloud: Option<&DroppedCloud>, outputs: &[Output]) -> Self {
        let mut document = Document::new(Arc::new(scene.clone()));
        document.cloud = cloud.cloned().map(Arc::new);
        let mut state = ViewerState::new(document, Vec::new(), Vec::new());
        for output in outputs {
            let output = Box::new(output.clone());
            let _announced = state.receive(Update::Done { revision: state.revision, elapsed_ms: 0.0, output });
        }
        Self { state, studio: BuiltInStudio::default(), words: None }
    }

    /// Writes over a finished picture of a moment.
    pub(super) fn write(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        target: &Target,
        camera: &Camera,
        time_s: Option<f64>,
        (theme, scale): (Theme, f32),
    ) {
        let dark = theme == Theme::Dark;
        let mut input = self.state.compose_input(dark);
        input.posture = time_s.map_or(Posture::Start, |time_s| Posture::Plan { time_s });
        let picture = self.studio.compose(&input);
        let words = self.words.get_or_insert_with(|| Words::new(device));
        words.paint((device, queue), target, (dark, scale), |ui| say_over(ui, &picture, camera));
    }
}
