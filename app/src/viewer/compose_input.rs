//! What the 3D picture is made from, and what it consists of.

use endcomfort_core::fit::Fit;
use endcomfort_core::grasp::Quantity;
use endcomfort_core::scene::Scene;
use endcomfort_core::task::Try;
use nalgebra::Point3;

use super::{
    CloudLook, Document, Followed, GraspingKey, Hover, Kept, LabKey, Layers, Outputs, PlanningKey, PosingKey, ReachKey,
    Reaching, Selection, Situation, VoxelChoice,
};
use crate::render::{Bounds, Frame, Scale};

/// Everything that the picture depends on; two equal inputs (see [`ViewKey`]) give the same picture.
#[derive(Clone)]
pub struct ComposeInput<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The document around it: the dropped cloud, the asked-for cluster and grasp.
    pub document: &'a Document,
    /// Revision of the document; an output of another revision is stale.
    pub revision: u64,
    /// Results so far. A stale one is still to be drawn, dimmed.
    pub outputs: &'a Outputs,
    /// What is selected: step, cluster, grasp.
    pub selection: &'a Selection,
    /// What is under the pointer in a panel or in the view.
    pub hover: &'a Hover,
    /// Opacity of each layer; [`Layers::opacity`] is 0 for a hidden one.
    pub layers: &'a Layers,
    /// How the robot stands.
    pub posture: Posture,
    /// How grasps are examined.
    pub grasping: GraspingKey,
    /// How plans are examined.
    pub planning: PlanningKey,
    /// How points are drawn.
    pub cloud_look: CloudLook,
    /// How the robot is posed by hand.
    pub posing: PosingKey,
    /// What was tried in vain.
    pub tries: &'a [Try],
    /// The plan that others are compared with.
    pub kept: Option<&'a Kept>,
    /// Reachability maps and how they are shown.
    pub reaching: &'a Reaching,
    /// The fit under examination; `None` while the robot is at work.
    pub lab: Option<LabKey>,
    /// A fit of another objective, to be drawn over the examined one.
    pub trial: Option<&'a Fit>,
    /// Whether it is shown to an audience: the plan alone.
    pub is_presented: bool,
    /// Whether the theme is dark.
    pub dark: bool,
}

impl ComposeInput<'_> {
    /// What the grasps' colours mean.
    pub fn colored_by(&self, has_goal: bool) -> Quantity {
        let ranking = || self.scene.rank.by.quantity(has_goal);
        self.grasping.colored_by.or_else(ranking).unwrap_or(Quantity::MgStart)
    }
}

/// How the robot stands in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Posture {
    /// In the scene's start posture, the object where it was seen.
    Start,
    /// As the plan has it at this time, seconds from its start.
    Plan {
        /// Seconds.
        time_s: f64,
    },
    /// Where a try failed.
    Try {
        /// Index into [`ComposeInput::tries`].
        index: usize,
    },
    /// In the configuration of a reachability map for one of its poses, the object where it was seen.
    Reach(VoxelChoice),
    /// In one configuration of a grasp's IK set, the object at the start or at the goal.
    Ik {
        /// Number of the grasp.
        grasp: u32,
        /// Start or goal.
        at: Situation,
        /// Index into [`endcomfort_core::grasp::Situated::solutions`].
        index: usize,
    },
}

/// What the picture depends on, small enough to compare on every frame: no change, no new picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewKey {
    pub(super) revision: u64,
    pub(super) outputs_version: u64,
    pub(super) selection: Selection,
    pub(super) hover: Hover,
    pub(super) layers: Layers,
    pub(super) posture: Posture,
    pub(super) grasping: GraspingKey,
    pub(super) planning: PlanningKey,
    pub(super) cloud_look: CloudLook,
    pub(super) posing: PosingKey,
    pub(super) reach: ReachKey,
    pub(super) lab: Option<LabKey>,
    pub(super) is_presented: bool,
    pub(super) dark: bool,
}

/// The picture: what the renderer draws, and what is written over it.
#[derive(Clone, Default)]
pub struct Picture {
    /// The draw list.
    pub frame: Frame,
    /// Words at places in the world.
    pub labels: Vec<Label>,
    /// The meaning of the colours, if data colours are shown.
    pub scale: Option<ScaleBar>,
    /// What the marks mean, if that is not plain.
    pub legend: Option<Legend>,
    /// The box that `F` frames; `None` frames whatever is drawn.
    pub bounds: Option<Bounds>,
    /// Points that `F` brings into the view as near as they allow; without any, the box as a whole.
    pub outline: Vec<Point3<f64>>,
    /// Where the object is that the task is about, in the world, metres.
    pub object_W: Option<Point3<f64>>,
    /// Where the hands are, arm by arm, in the world, metres.
    pub hands_W: Vec<Point3<f64>>,
}

impl Picture {
    /// Where that is now.
    pub fn place_of(&self, followed: Followed) -> Option<Point3<f64>> {
        match followed {
            Followed::Object => self.object_W,
            Followed::Hand(arm) => self.hands_W.get(arm).copied(),
        }
    }
}

/// A word at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Where, in the world, metres; the word stands above it.
    pub p_W: Point3<f64>,
    /// What.
    pub text: String,
    /// Its colour.
    pub tone: Tone,
}

/// What a label speaks of; the theme knows its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// An object, a link.
    Plain,
    /// The object that is grasped, the fit.
    Fit,
    /// A goal.
    Goal,
    /// A grasp.
    Grasp,
    /// A collision, a rejection.
    Rejected,
}

/// The meaning of data colours.
#[derive(Clone, Debug)]
pub struct ScaleBar {
    /// Quantity and unit: `m_g at the goal`.
    pub title: String,
    /// Unit of the numbers at the bar; empty for none.
    pub unit: &'static str,
    /// Colours and range.
    pub scale: Scale,
}

/// The meaning of marks in the view.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// What is looked at.
    pub title: String,
    /// One row per kind of mark.
    pub rows: Vec<LegendRow>,
}

/// One kind of mark.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendRow {
    /// Its form.
    pub mark: Mark,
    /// Its colour, sRGB and opacity.
    pub color: [f32; 4],
    /// What it stands for, with its number.
    pub text: String,
}

/// The form of a mark: no two kinds are told apart by colour alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A point.
    Dot,
    /// Points in the colours of signed data.
    Signed,
    /// A large point.
    Disc,
    /// A body.
    Body,
    /// A line.
    Line,
}
