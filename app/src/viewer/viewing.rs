//! How the view is looked at: projection, how a drag turns it, and the views that a person kept.

use super::{Effect, ViewerState};
use crate::render::{Camera, Named, Projection};

/// Views that are kept at most.
pub(super) const MOST_KEPT: usize = 20;

/// How a drag turns the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turning {
    /// As on a turntable: the horizon stays level.
    #[default]
    Turntable,
    /// About the picture's own axes, over the poles and beyond.
    Free,
}

impl Turning {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Turntable, Self::Free];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Turntable => "Turntable",
            Self::Free => "Free",
        }
    }
}

/// A view that was kept.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptView {
    /// Its number; never used twice.
    pub id: u32,
    /// Where the camera stood.
    pub camera: Camera,
}

impl KeptView {
    /// What a person reads.
    pub fn title(&self) -> String {
        format!("View {}", self.id)
    }
}

/// How the view is looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Viewing {
    /// Perspective or orthographic.
    pub projection: Projection,
    /// How a drag turns the camera.
    pub turning: Turning,
    /// Views that were kept, oldest first.
    pub kept: Vec<KeptView>,
    newest: u32,
}

/// Something a person does to the view.
#[derive(Clone, Debug, PartialEq)]
pub enum ViewCommand {
    /// Brings everything into the view.
    FrameAll,
    /// Brings the object that is grasped to the middle, and nearer.
    FrameObject,
    /// Looks from a named side.
    Look(Named),
    /// Far things are smaller, or parallels stay parallel.
    Project(Projection),
    /// How a drag turns the camera.
    Turn(Turning),
    /// Keeps the present view.
    Keep,
    /// Keeps where the camera stands: what [`ViewCommand::Keep`] leads to.
    KeepCamera(Camera),
    /// Goes back to a kept view.
    Recall(u32),
    /// Forgets a kept view.
    Forget(u32),
}

/// What the view has to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewEffect {
    /// Move the camera so that everything is seen.
    FrameAll,
    /// Bring the object to the middle.
    FrameObject,
    /// Look from a named side.
    Look(Named),
    /// Turn the camera until the horizon is level.
    Level,
    /// Travel to where a camera stood.
    GoTo(Camera),
    /// Say where the camera stands.
    Keep,
}

impl Viewing {
    /// Keeps these views instead of those that were kept.
    pub(super) fn keep(&mut self, cameras: &[Camera]) {
        self.kept = (1..).zip(cameras).map(|(id, &camera)| KeptView { id, camera }).collect();
        self.newest = self.newest.max(cameras.len() as u32);
    }
}

impl ViewerState {
    /// Projection and turning become those that a camera needs.
    pub(super) fn look_with(&mut self, camera: &Camera) {
        self.viewing.projection = camera.projection;
        if camera.roll_rad != 0.0 {
            self.viewing.turning = Turning::Free;
        }
    }

    pub(super) fn apply_view(&mut self, command: ViewCommand) -> Vec<Effect> {
        let effect = match command {
            ViewCommand::FrameAll => ViewEffect::FrameAll,
            ViewCommand::FrameObject => ViewEffect::FrameObject,
            ViewCommand::Look(named) => ViewEffect::Look(named),
            ViewCommand::Project(projection) => {
                self.viewing.projection = projection;
                return Vec::new();
            }
            ViewCommand::Turn(turning) => {
                self.viewing.turning = turning;
                if turning == Turning::Free {
                    return Vec::new();
                }
                ViewEffect::Level
            }
            ViewCommand::Keep => ViewEffect::Keep,
            ViewCommand::KeepCamera(camera) => {
                let viewing = &mut self.viewing;
                viewing.newest += 1;
                viewing.kept.push(KeptView { id: viewing.newest, camera });
                if viewing.kept.len() > MOST_KEPT {
                    viewing.kept.remove(0);
                }
                self.say(
                    false,
                    format!("View {} is kept; the view menu leads back to it.", self.viewing.newest),
                    vec![],
                );
                return Vec::new();
            }
            ViewCommand::Recall(id) => match self.viewing.kept.iter().find(|kept| kept.id == id) {
                Some(&KeptView { camera, .. }) => {
                    self.look_with(&camera);
                    ViewEffect::GoTo(camera)
                }
                None => return Vec::new(),
            },
            ViewCommand::Forget(id) => {
                self.viewing.kept.retain(|kept| kept.id != id);
                return Vec::new();
            }
        };
        vec![Effect::View(effect)]
    }
}
