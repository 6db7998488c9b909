//! The panels: one file each.

mod bringing;
mod bringing_files;
mod cloud_menu;
mod drop_zone;
mod edges;
mod finder;
mod fit;
mod gallery;
mod grasps;
mod help;
mod inspector;
mod joints;
mod layer_list;
mod own_robot;
pub(super) mod palette;
mod picture;
mod plan;
mod play;
mod posing;
mod presentation;
mod reach;
mod save_menu;
mod scene;
mod segment;
mod stepper;
mod things;
mod timeline;
mod toasts;
mod top_bar;
mod tour;
mod view_menu;

use egui::{Ui, vec2};
use endcomfort_core::fit::ObjectiveKind;
use endcomfort_core::task::PhaseKind;

use super::layout::Layout;
use super::theme::Tokens;
use super::widgets::panel;
use super::{Command, HandoverCommand, LabCommand, Overlay, PlanCommand, ViewerState, keys};

/// What the panels collect in one pass.
#[derive(Default)]
struct Out {
    commands: Vec<Command>,
    /// The grasp whose row is under the pointer.
    grasp: Option<u32>,
    /// The cluster whose row is under the pointer.
    cluster: Option<usize>,
    /// The objective whose row is under the pointer.
    objective: Option<ObjectiveKind>,
    /// The try whose row is under the pointer.
    tried: Option<usize>,
    /// The route whose row is under the pointer.
    route: Option<usize>,
    /// The place of the handover whose row is under the pointer.
    place: Option<usize>,
}

impl Out {
    fn push(&mut self, command: Command) {
        self.commands.push(command);
    }
}

/// The colour of a phase, in lists, on the timeline and in plots.
pub(crate) fn phase_color(kind: PhaseKind, dark: bool) -> egui::Color32 {
    plan::color(kind, Tokens::for_dark(dark))
}

/// Draws every panel over whatever the `Ui` shows already, and gives what the person did, keyboard included.
pub fn draw_panels(ui: &mut Ui, state: &ViewerState) -> Vec<Command> {
    let mut out = Out { commands: keys::commands(ui.ctx(), state), ..Out::default() };
    let layout = Layout::of(ui.max_rect(), state);
    if state.presentation.is_some() {
        presentation::draw(ui, state, &layout, &mut out);
    } else {
        panel(ui, "Top bar", layout.top, vec2(14.0, 7.0), |ui| top_bar::draw(ui, state, &layout, &mut out));
        if let Some(rect) = layout.left {
            panel(ui, "Pipeline", rect, vec2(14.0, 12.0), |ui| {
                stepper::draw(ui, state, &mut out);
                layer_list::draw(ui, state, &mut out);
            });
        }
        if let Some(rect) = layout.right {
            panel(ui, "Inspector", rect, vec2(14.0, 12.0), |ui| inspector::draw(ui, state, &mut out));
        }
        panel(ui, "Timeline", layout.timeline, vec2(14.0, 8.0), |ui| timeline::draw(ui, state, &mut out));
    }
    if state.presentation.is_none() {
        edges::draw(ui, &layout, &mut out);
    }
    toasts::draw(ui, state, &layout, &mut out);
    match state.overlay {
        Overlay::Gallery => gallery::draw(ui, state, &mut out),
        Overlay::Help => help::draw(ui, state, &mut out),
        Overlay::Palette => palette::draw(ui, state, &mut out),
        Overlay::Picture => picture::draw(ui, state, &mut out),
        Overlay::None => {}
    }
    tour::draw(ui, state, &layout, &mut out);
    bringing::draw(ui, state, &mut out);
    drop_zone::draw(ui);
    if state.presentation.is_none() {
        follow_pointer(ui, state, &layout, &mut out);
    }
    out.commands
}

/// While the pointer is over a panel, the rows decide what is hovered; over the view, the view does.
fn follow_pointer(ui: &Ui, state: &ViewerState, layout: &Layout, out: &mut Out) {
    let over_panel = ui.input(|input| input.pointer.hover_pos()).is_none_or(|pointer| {
        let panels = [Some(layout.top), layout.left, layout.right, Some(layout.timeline)];
        panels.into_iter().flatten().any(|rect| rect.contains(pointer))
    });
    if state.lab.hovered != out.objective {
        out.commands.push(Command::Lab(LabCommand::HoverObjective(out.objective)));
    }
    if state.planning.hovered_try != out.tried {
        out.commands.push(Command::Planning(PlanCommand::HoverTry(out.tried)));
    }
    if state.planning.hovered_route != out.route {
        out.commands.push(Command::Planning(PlanCommand::HoverRoute(out.route)));
    }
    if over_panel {
        if state.planning.hovered_place != out.place {
            out.commands.push(Command::Handover(HandoverCommand::HoverPlace(out.place)));
        }
        if state.hover.grasp != out.grasp {
            out.commands.push(Command::HoverGrasp(out.grasp));
        }
        if state.hover.cluster != out.cluster {
            out.commands.push(Command::HoverCluster(out.cluster));
        }
    }
}
