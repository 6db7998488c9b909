//! What a person sees and touches: panels that float on the 3D view.
//!
//! The panels read [`ViewerState`] and emit [`Command`]s; [`ViewerState::apply`] alone changes the state and says what
//! the world outside has to do ([`Effect`]). Nothing here computes: results arrive as updates of the pipeline, and the
//! 3D picture is composed by the [`Studio`] from a [`ComposeInput`].

#![allow(non_snake_case, reason = "frame letters: X_WO is the pose of O in W")]

mod actions;
mod app;
mod app_picture;
mod app_share;
mod bringing;
mod bringing_files;
mod captions;
mod commands;
mod compose_input;
mod document;
mod fields;
mod flying;
mod font;
mod format;
mod goal_drag;
mod goal_gizmo;
mod grasping;
mod hand_gizmo;
mod handing;
mod icons;
mod joint_curves;
mod keys;
mod lab;
mod layers;
mod layout;
mod legends;
mod looking;
mod measures;
mod measuring;
mod number;
mod outputs;
mod panels;
mod photographer;
mod pick;
mod picturing;
mod placing;
mod planning;
mod playback;
mod posing;
mod quantities;
mod reach;
mod reach_view;
mod region_drag;
mod regions;
mod saving;
mod share;
mod slider;
mod state;
mod status;
mod studio;
mod table_view;
mod theme;
mod tips;
mod tour;
mod updates;
mod view3d;
mod viewing;
mod widgets;
mod words;

pub use app::{App, StartOptions};
pub use bringing::{BringCommand, Bringing, RobotDraft, RobotWindow};
pub use bringing_files::{DepthWindow, MeshWindow};
pub use commands::{Command, Effect};
pub use compose_input::{ComposeInput, Label, Legend, LegendRow, Mark, Picture, Posture, ScaleBar, Tone, ViewKey};
pub use document::Document;
pub use format::count;
pub use grasping::{GraspCommand, GraspPage, Grasping, GraspingKey};
pub use handing::HandoverCommand;
pub use joint_curves::Curve;
pub(crate) use joint_curves::{ArmJoint, samples as curve_samples};
pub use lab::{Comparison, FitView, Lab, LabCommand, LabKey, LabPage, objective_title};
pub use layers::{Layer, LayerView, Layers};
pub use layout::{Edge, PanelSizes};
pub use looking::{CloudColor, CloudLook, LookCommand, Looking, Measured};
pub use measures::{Kept, Measures};
pub use outputs::{Dated, Outputs};
pub use panels::draw_panels;
pub(crate) use panels::phase_color;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use photographer::say_over;
pub use pick::Pick;
pub use picturing::{PictureCommand, PictureEffect, PicturePage, PictureSettings, Picturing, Shot, SizePreset};
pub use placing::{PlaceCommand, Thing};
pub use planning::{PlanCommand, PlanPage, Planning, PlanningKey, PlayPage, planner_title};
pub use playback::{Followed, Playback};
pub use posing::{HandTarget, Jog, LedHand, PoseCommand, Posing, PosingKey};
pub use quantities::unit as unit_of;
pub use reach::{MapSource, ReachCommand, ReachKey, ReachPage, Reaching, ShownMap, Slot, VoxelChoice};
pub use reach_view::{Keep, ReachArms, ReachQuantity, ReachView, Slice};
pub use saving::Saved;
pub use share::{Offer, Opened, ShareError, SharedView, link_text, read_link, read_session, session_text};
pub use state::{
    Hover, IkChoice, Message, Overlay, Presentation, Selection, Side, Situation, StageState, Step, ThemeChoice,
    ViewerState,
};
pub use studio::{Demo, RobotChoice, Studio};
pub use table_view::{Column, ColumnSet, Listed, TableView};
pub use theme::{Tokens, install as install_theme};
pub use tour::{Tour, TourCommand};
pub use viewing::{KeptView, Turning, ViewCommand, ViewEffect, Viewing};
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use words::Words;

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests;
