//! Everything that can be done from the keyboard, in one list: the keys, the list of keys and the palette read it.

use std::borrow::Cow;

use egui::{Key, Modifiers};
use endcomfort_core::grasp::ExportFormat;
use endcomfort_core::job::Stage;
use endcomfort_core::scene::ArmChoice;

use super::state::{Step, ThemeChoice};
use super::{
    CloudColor, Command, GraspCommand, LabCommand, Layer, LookCommand, Overlay, PanelSizes, PictureCommand,
    PlaceCommand, PlanCommand, PoseCommand, ReachCommand, Thing, TourCommand, Turning, ViewCommand, ViewerState,
};
use crate::export::MotionFormat;
use crate::render::{Named, Projection};

/// What an action belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topic {
    Time,
    View,
    Select,
    Page,
    Scene,
    Export,
}

impl Topic {
    /// Those with keys, in two columns of nearly the same length.
    pub(super) const WITH_KEYS: [&[Self]; 2] = [&[Self::Time, Self::Select, Self::Page], &[Self::View]];

    /// What a person reads.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Time => "Time",
            Self::View => "View",
            Self::Select => "Select",
            Self::Page => "Page",
            Self::Scene => "Scene",
            Self::Export => "Export",
        }
    }
}

/// The key of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shortcut {
    pub(super) modifiers: Modifiers,
    pub(super) key: Key,
    /// What a person reads on the keys.
    pub(super) name: &'static str,
}

/// Something that can be done.
pub(super) struct Action {
    pub(super) topic: Topic,
    pub(super) title: Cow<'static, str>,
    pub(super) shortcut: Option<Shortcut>,
    pub(super) command: Command,
    /// Whether it can be done now.
    pub(super) is_possible: bool,
}

impl Action {
    fn new(topic: Topic, title: impl Into<Cow<'static, str>>, command: Command) -> Self {
        Self { topic, title: title.into(), shortcut: None, command, is_possible: true }
    }

    fn key(self, name: &'static str, key: Key) -> Self {
        self.keys(name, Modifiers::NONE, key)
    }

    fn keys(self, name: &'static str, modifiers: Modifiers, key: Key) -> Self {
        Self { shortcut: Some(Shortcut { modifiers, key, name }), ..self }
    }

    fn when(self, is_possible: bool) -> Self {
        Self { is_possible, ..self }
    }
}

/// Gestures that no key stands for: what a hand does, and what comes of it.
pub(super) const GESTURES: [(&str, &str); 6] = [
    ("Drag", "Turn about what is under it"),
    ("Right or Shift drag", "Move"),
    ("Wheel, pinch", "Zoom to the pointer"),
    ("Double click", "Look at what is there"),
    ("W A S D Q E", "Fly"),
    ("Ctrl drag of a handle", "Snap to centimetres and 15°"),
];

/// The actions that have a key. Of two with the same key and more modifiers the one with more stands first.
pub(super) fn with_keys(state: &ViewerState) -> Vec<Action> {
    use Topic::{Page, Select, Time, View};
    let is_playing = state.playback.playing;
    let has_plan = state.outputs.plan.is_some();
    let is_open = |overlay: Overlay| state.overlay == overlay;
    let toggled = |overlay: Overlay| Command::Show(if is_open(overlay) { Overlay::None } else { overlay });
    let look = |named: Named| Command::View(ViewCommand::Look(named));
    let other_projection = match state.viewing.projection {
        Projection::Perspective => (Projection::Orthographic, "Orthographic view"),
        Projection::Orthographic => (Projection::Perspective, "Perspective view"),
    };
    let (reach, reach_title) = match state.reaching.is_open {
        true => (ReachCommand::Close, "Leave the reachability maps"),
        false => (ReachCommand::Open, "Show what the arms reach"),
    };
    let (pose, pose_title) = match state.posing.is_open {
        true => (PoseCommand::Close, "Leave the robot's pose"),
        false => (PoseCommand::Open, "Pose the robot: hands and joints"),
    };
    let measures = state.looking.measured.is_some();
    let measure_title = if measures { "Stop measuring" } else { "Measure distances and angles" };
    let is_presented = state.presentation.is_some();
    let thing = state.selected_thing();
    let on_thing = |deed: fn(Thing) -> PlaceCommand| Command::Place(thing.map_or(PlaceCommand::Select(None), deed));
    vec![
        Action::new(Time, if is_playing { "Pause" } else { "Play" }, Command::SetPlaying(!is_playing))
            .key("Space", Key::Space)
            .when(has_plan),
        Action::new(Time, "Back by 0.1 s", Command::Nudge(-0.1)).key("Left", Key::ArrowLeft).when(has_plan),
        Action::new(Time, "Forth by 0.1 s", Command::Nudge(0.1)).key("Right", Key::ArrowRight).when(has_plan),
        Action::new(Time, "Back by one sample", Command::StepSample { forth: false })
            .key(",", Key::Comma)
            .when(has_plan),
        Action::new(Time, "Forth by one sample", Command::StepSample { forth: true })
            .key(".", Key::Period)
            .when(has_plan),
        Action::new(Time, "To the start", Command::Seek(0.0)).key("Home", Key::Home).when(has_plan),
        Action::new(Time, "To the end", Command::Seek(f64::MAX)).key("End", Key::End).when(has_plan),
        Action::new(Select, "The grasp above", Command::MoveSelection(-1)).key("Up", Key::ArrowUp),
        Action::new(Select, "The grasp below", Command::MoveSelection(1)).key("Down", Key::ArrowDown),
        Action::new(Select, "Next way to see the fit", Command::Lab(LabCommand::NextView))
            .key("V", Key::V)
            .when(state.selection.step == Step::Stage(Stage::Fit)),
        Action::new(Select, "Delete what is selected", on_thing(PlaceCommand::Remove))
            .key("Delete", Key::Delete)
            .when(thing.is_some()),
        Action::new(Select, "Duplicate what is selected", on_thing(PlaceCommand::Duplicate))
            .keys("Ctrl D", Modifiers::COMMAND, Key::D)
            .when(thing.is_some()),
        Action::new(View, "Frame everything", Command::View(ViewCommand::FrameAll)).key("F", Key::F),
        Action::new(View, "Look at the object", Command::View(ViewCommand::FrameObject)).key("C", Key::C),
        Action::new(View, "Follow the object", Command::ToggleFollow).key("O", Key::O),
        Action::new(View, Named::Front.title(), look(Named::Front)).key("1", Key::Num1),
        Action::new(View, Named::Right.title(), look(Named::Right)).key("3", Key::Num3),
        Action::new(View, Named::Top.title(), look(Named::Top)).key("7", Key::Num7),
        Action::new(View, Named::Corner.title(), look(Named::Corner)).key("9", Key::Num9),
        Action::new(View, other_projection.1, Command::View(ViewCommand::Project(other_projection.0)))
            .key("5", Key::Num5),
        Action::new(View, "Keep this view", Command::View(ViewCommand::Keep)).key("K", Key::K),
        Action::new(Select, pose_title, Command::Pose(pose)).key("J", Key::J),
        Action::new(View, measure_title, Command::Look(LookCommand::Measure(!measures))).key("M", Key::M),
        Action::new(View, reach_title, Command::Reach(reach)).key("R", Key::R),
        Action::new(Page, "Find anything", toggled(Overlay::Palette)).keys("Ctrl K", Modifiers::COMMAND, Key::K),
        Action::new(Page, "Redo", Command::Redo)
            .keys("Ctrl Shift Z", Modifiers::COMMAND | Modifiers::SHIFT, Key::Z)
            .when(state.can_redo()),
        Action::new(Page, "Copy a link to this view", Command::Share).keys(
            "Ctrl Shift S",
            Modifiers::COMMAND | Modifiers::SHIFT,
            Key::S,
        ),
        Action::new(Page, "Undo", Command::Undo).keys("Ctrl Z", Modifiers::COMMAND, Key::Z).when(state.can_undo()),
        Action::new(
            Page,
            if is_presented { "End the presentation" } else { "Presentation without panels" },
            Command::Present(!is_presented),
        )
        .key("P", Key::P),
        Action::new(Page, "Save a picture or an animation…", toggled(Overlay::Picture)).key("I", Key::I),
        Action::new(Page, "All demos", toggled(Overlay::Gallery)).key("G", Key::G),
        Action::new(Page, "The 30-second tour", Command::Tour(TourCommand::Start)).key("T", Key::T),
        Action::new(Page, "Keys and gestures", toggled(Overlay::Help)).key("?", Key::Questionmark),
        Action::new(Page, "Close what is on top", Command::Escape).key("Esc", Key::Escape),
    ]
}

/// Everything else that the palette finds.
pub(super) fn without_keys(state: &ViewerState) -> Vec<Action> {
    use Topic::{Export, Page, Scene, Select, View};
    let mut actions = Vec::new();
    for demo in &state.demos {
        let title = format!("Open {}", demo.scene.title);
        actions.push(Action::new(Scene, title, Command::OpenDemo(demo.name.clone())));
    }
    let scene = &state.document.scene;
    for robot in &state.robots {
        let action = Action::new(Scene, format!("Let {} do it", robot.title), Command::SetRobot(robot.name.clone()));
        actions.push(action.when(scene.robot != robot.name));
    }
    for (arm, title) in [(ArmChoice::Left, "Act with the left arm"), (ArmChoice::Right, "Act with the right arm")] {
        actions.push(Action::new(Scene, title, Command::SetArm(arm)).when(scene.arm != arm && state.has_arm(arm)));
    }
    let next_seed = scene.seed.wrapping_add(1);
    actions.push(Action::new(Scene, format!("Another seed: {next_seed}"), Command::SetSeed(next_seed)));
    actions.push(Action::new(Scene, "Add a box", Command::Place(PlaceCommand::AddBox)));
    for name in crate::assets::object_names() {
        let title = format!("Add {}", name.replace('_', " "));
        let action = Action::new(Scene, title, Command::Place(PlaceCommand::AddObject(name.to_owned())));
        actions.push(action.when(state.document.cloud.is_none()));
    }
    actions.push(Action::new(Scene, "Compute again", Command::Run));
    actions.push(Action::new(Scene, "Stop the computation", Command::Cancel).when(state.running));
    for step in Step::ALL {
        actions.push(Action::new(Select, format!("Go to step {}", step.title()), Command::SelectStep(step)));
    }
    for (hand, title) in state.hands_to_follow() {
        actions.push(Action::new(View, title, Command::Follow(hand)));
    }
    for named in [Named::Back, Named::Left, Named::Bottom] {
        actions.push(Action::new(View, named.title(), Command::View(ViewCommand::Look(named))));
    }
    for turning in Turning::ALL {
        let title = match turning {
            Turning::Turntable => "Turn the view as on a turntable",
            Turning::Free => "Turn the view freely",
        };
        let action = Action::new(View, title, Command::View(ViewCommand::Turn(turning)));
        actions.push(action.when(state.viewing.turning != turning));
    }
    for kept in &state.viewing.kept {
        actions.push(Action::new(View, format!("Go to {}", kept.title()), Command::View(ViewCommand::Recall(kept.id))));
    }
    for by in CloudColor::ALL {
        let title = format!("Colour the points by {}", by.title().to_lowercase());
        let action = Action::new(View, title, Command::Look(LookCommand::Color(by)));
        actions.push(action.when(state.looking.cloud.by != by));
    }
    for layer in Layer::ALL {
        let verb = if state.layers.get(layer).visible { "Hide" } else { "Show" };
        let title = format!("{verb} layer {}", layer.title());
        actions.push(Action::new(View, title, Command::ToggleLayer(layer)));
    }
    let themes =
        [(ThemeChoice::System, "as the system has it"), (ThemeChoice::Dark, "dark"), (ThemeChoice::Light, "light")];
    for (theme, name) in themes {
        actions.push(Action::new(Page, format!("Theme {name}"), Command::SetTheme(theme)).when(state.theme != theme));
    }
    let is_usual = state.sizes == PanelSizes::default();
    actions.push(Action::new(Page, "Give every panel its usual size", Command::ResetLayout).when(!is_usual));
    actions.push(Action::new(Scene, "Open a file…", Command::PickFile));
    actions.push(Action::new(Export, "Save the session", Command::SaveSession));
    actions.push(Action::new(Export, "Save the scene", Command::SaveScene));
    actions.push(Action::new(
        Export,
        "Save what the view shows as a 3D scene (GLB)",
        Command::Picture(PictureCommand::SaveScene),
    ));
    for format in ExportFormat::ALL {
        let title = format!("Save the ranked grasps as {}", format.extension().to_uppercase());
        let action = Action::new(Export, title, Command::Grasping(GraspCommand::Export(format)));
        actions.push(action.when(state.outputs.rank.is_some()));
    }
    for format in MotionFormat::ALL {
        let title = format!("Save the motion as {}", format.title());
        let action = Action::new(Export, title, Command::Planning(PlanCommand::Export(format)));
        actions.push(action.when(state.outputs.plan.is_some()));
    }
    actions
}
