//! The plan in numbers, and its phases.

use egui::{Align, Rect, Sense, Ui, pos2, vec2};
use endcomfort_core::task::{Phase, Plan};

use super::{color, compare};
use crate::export::{PlotKind, TableKind};
use crate::viewer::number::{Number, number_row};
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{focus_ring, key_value, secondary_button, section, switch, text_in};
use crate::viewer::{Command, Layer, PlanCommand, ViewerState, format, playback};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, plan: &Plan, out: &mut Out) {
    let arms: Vec<String> = plan.arms().iter().map(|arm| arm.replace('_', " ")).collect();
    let _row = key_value(ui, "Arm", &arms.join(", then "));
    let _row = key_value(ui, "Duration", &format::clock(state.duration_s()));
    if let Some((clearance_m, time_s)) = playback::closest(plan) {
        let text = format!("{} at {}", format::length(clearance_m), format::clock(time_s));
        let _row = key_value(ui, "Smallest clearance", &text);
    }
    if plan.certificate.states > 0 {
        let _row = key_value(ui, "Certificate", &certificate(plan));
    }
    compare::draw(ui, state, out);

    saved_section(ui, "Phases", TableKind::Phases, Some(PlotKind::Timeline), out);
    for (index, phase) in plan.phases.iter().enumerate() {
        let is_first = index == 0 || plan.phases[index - 1].leg != phase.leg;
        if plan.legs.len() > 1 && is_first {
            match state.partners().filter(|_| plan.handover.is_some()) {
                Some(partners) => {
                    let deed = if phase.leg == 0 { "gives" } else { "takes" };
                    let _row = key_value(ui, &partners[phase.leg.min(1)].title, deed);
                }
                None => {
                    let grasp = state.grasp_title(plan.legs[phase.leg].grasp.id);
                    let text = format!("{} hold", format::title_of(&format::ordinal(phase.leg + 1)));
                    let _row = key_value(ui, &text, &grasp);
                }
            }
        }
        phase_row(ui, phase, out);
    }

    section(ui, "In the view");
    for layer in [Layer::Ghosts, Layer::Swept] {
        if switch(ui, layer.title(), state.layers.get(layer).visible) {
            out.push(Command::ToggleLayer(layer));
        }
    }
    if state.layers.get(Layer::Ghosts).visible {
        let tip = "Evenly apart on the way of the hand";
        let field = Number { name: "Ghosts", unit: "", decimals: 0, per_point: 0.1, tip };
        if let Some(count) = number_row(ui, &field, state.planning.ghosts as f64, "ghosts of the arm along the way") {
            out.push(Command::Planning(PlanCommand::Ghosts(count.round().max(1.0) as usize)));
        }
    }
    if state.document.grasp.is_some() {
        ui.add_space(10.0);
        if secondary_button(ui, "Plan with the best grasp", !state.running).clicked() {
            out.push(Command::PlanWithGrasp(None));
        }
    }
}

/// What the certificate says: `8 240 states checked, 4 per sample`.
fn certificate(plan: &Plan) -> String {
    let states = format::count(plan.certificate.states);
    format!("{states} states checked, {} per sample", plan.certificate.density)
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
    focus_ring(ui, &response, rect.expand2(vec2(6.0, 0.0)));
    if response.on_hover_text("Go to the start of this phase").clicked() {
        out.push(Command::Seek(phase.start_s));
    }
}
