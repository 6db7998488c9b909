//! The plan: its phases, how close it comes to anything, and which grasps failed before.

use egui::{Align, Color32, Rect, Sense, Ui, pos2, vec2};
use endcomfort_core::job::Stage;
use endcomfort_core::task::{Phase, PhaseKind};

use super::Out;
use super::inspector::{heading, nothing_yet};
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{key_value, key_value_colored, secondary_button, section, text_in};
use crate::viewer::{Command, ViewerState, format, playback};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let Some(plan) = &state.outputs.plan else { return nothing_yet(ui, state, Stage::Plan) };
    let failed = plan.tries.len();
    let number = |id: u32| state.outputs.rank_of(id).map_or(format!("candidate {id}"), |rank| format!("grasp {rank}"));
    let text = format!("Planned with {}", number(plan.grasp().id));
    let sentence = match (state.document.grasp.is_some(), failed) {
        (true, _) => "The grasp that you asked for.".to_owned(),
        (false, 0) => "The best-ranked grasp worked at the first try.".to_owned(),
        (false, _) => format!("{} of better rank failed before it.", format::plural(failed, "grasp")),
    };
    heading(ui, state, Stage::Plan, &text, &sentence);
    let _row = key_value(ui, "Arm", &plan.arm);
    let _row = key_value(ui, "Duration", &format::clock(state.duration_s()));
    if let Some((clearance_m, time_s)) = playback::closest(plan) {
        let text = format!("{} at {}", format::length(clearance_m), format::clock(time_s));
        let _row = key_value(ui, "Smallest clearance", &text);
    }

    section(ui, "Phases");
    for phase in &plan.phases {
        phase_row(ui, phase, out);
    }
    if failed > 0 {
        section(ui, "Failed before");
        for tried in &plan.tries {
            let name = tried.grasp.map_or_else(|| "Before".to_owned(), |id| format::title_of(&number(id)));
            let _row = key_value_colored(ui, &name, &tried.reason, tokens.coral);
        }
    }
    if state.document.grasp.is_some() {
        ui.add_space(10.0);
        if secondary_button(ui, "Plan with the best grasp", !state.running).clicked() {
            out.push(Command::PlanWithGrasp(None));
        }
    }
}

/// The colour of a phase on the timeline and in lists.
pub(super) fn color(kind: PhaseKind, tokens: &Tokens) -> Color32 {
    match kind {
        PhaseKind::Reach => tokens.blue,
        PhaseKind::Close | PhaseKind::Open => tokens.teal,
        PhaseKind::Lift | PhaseKind::Place => tokens.amber.lerp_to_gamma(tokens.coral, 0.35),
        PhaseKind::Transport | PhaseKind::Pour | PhaseKind::Slide => tokens.amber,
        PhaseKind::Retreat => tokens.slate,
    }
}

fn phase_row(ui: &mut Ui, phase: &Phase, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 25.0), Sense::click());
    if response.hovered() {
        ui.painter().rect_filled(rect.expand2(vec2(13.0, 0.0)), 0.0, tokens.hover);
    }
    let swatch = Rect::from_center_size(pos2(rect.left() + 4.5, rect.center().y), vec2(9.0, 9.0));
    ui.painter().rect_filled(swatch, 2.5, color(phase.kind, tokens));
    let text = Rect::from_min_max(pos2(rect.left() + 17.0, rect.top()), rect.max);
    let name = format::title_of(phase.kind.name());
    let _text = text_in(ui, text, Align::Min, &name, font(BODY), tokens.text);
    let closest = phase.clearance_m.iter().copied().fold(f64::INFINITY, f64::min);
    let duration = format::clock(phase.trajectory.duration_s());
    let numbers =
        if closest.is_finite() { format!("clear by {} · {duration}", format::millimetres(closest)) } else { duration };
    let _text = text_in(ui, text, Align::Max, &numbers, font(SECONDARY), tokens.secondary);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Go to {name}")));
    if response.on_hover_text("Go to the start of this phase").clicked() {
        out.push(Command::Seek(phase.start_s));
    }
}
