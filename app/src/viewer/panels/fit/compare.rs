//! The five objectives on the same cloud.

use egui::{Align, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::fit::{FitSettings, ObjectiveKind};
use endcomfort_core::job::ObjectiveFit;

use super::result::{E_G, E_R};
use crate::export::TableKind;
use crate::viewer::icons::{self, Icon};
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::theme::{BODY, SECONDARY, SMALL, Tokens, font, strong};
use crate::viewer::widgets::{focus_ring, paragraph, secondary_button, section, text_in};
use crate::viewer::{Command, LabCommand, ViewerState, format, objective_title};

const ROW: f32 = 42.0;
/// Right edges of the four numbers, as shares of the width.
const COLUMNS: [f32; 4] = [0.46, 0.64, 0.82, 1.0];

/// Its formula.
pub(super) fn formula(objective: ObjectiveKind) -> &'static str {
    match objective {
        ObjectiveKind::Radial => "Radial distance (3.4): |p| (1 – f^(–e1/2))",
        ObjectiveKind::Solina => "Solina and Bajcsy (3.5): √(abc) (f^e1 – 1)",
        ObjectiveKind::Ichim => "Ichim (3.7), as its author computes it: √(abc) |p| (f^e1 – 1)",
        ObjectiveKind::Chevalier => "Chevalier (3.6): |p| (f^(e1/2) – 1)",
        ObjectiveKind::F5 => "f5 (3.8): |p| (f^e1 – 1)",
    }
}

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let comparison = state.comparison();
    let rows = comparison.map_or(0, |comparison| comparison.rows.len());
    match rows {
        0 => section(ui, "Objectives side by side"),
        _ => saved_section(ui, "Objectives side by side", TableKind::Objectives, None, out),
    }
    if let Some(comparison) = comparison {
        header(ui);
        for (elapsed_ms, row) in &comparison.rows {
            show(ui, state, *elapsed_ms, row, out);
        }
        ui.add_space(6.0);
    } else {
        let text = "Fits this cluster five times, each time minimising something else, all other settings as they are.";
        let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
        ui.add_space(6.0);
    }
    ui.horizontal(|ui| {
        if state.is_comparing() {
            if secondary_button(ui, "Stop comparing", true).clicked() {
                out.push(Command::Cancel);
            }
            let text = format!("{rows} of {}", ObjectiveKind::ALL.len());
            let _text = ui.label(egui::RichText::new(text).font(font(SECONDARY)).color(tokens.teal_text));
        } else {
            let words = if rows > 0 { "Compare again" } else { "Compare objectives" };
            if secondary_button(ui, words, !state.running).clicked() {
                out.push(Command::Lab(LabCommand::Compare));
            }
            if rows > 0 {
                let text = "Click a row to fit with it";
                let _text = ui.label(egui::RichText::new(text).font(font(SECONDARY)).color(tokens.secondary));
            }
        }
    });
}

fn cell(row: Rect, column: usize) -> Rect {
    let left = if column == 0 { 0.22 } else { COLUMNS[column - 1] };
    let x = |share: f32| row.left() + share * row.width();
    Rect::from_min_max(pos2(x(left), row.top()), pos2(x(COLUMNS[column]), row.bottom()))
}

fn header(ui: &mut Ui) {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 24.0), Sense::hover());
    let tips = [E_R, E_G, "Volume (3.11).", "Computing time of this cluster's fit."];
    for (column, (name, tip)) in ["E_r", "E_g (3.9)", "volume", "time"].into_iter().zip(tips).enumerate() {
        let text = text_in(ui, cell(rect, column), Align::Max, name, font(SMALL), tokens.secondary);
        let _tip = text.on_hover_text(tip);
    }
}

/// A row; the pointer over it shows its fit in the view, a click takes its objective.
fn show(ui: &mut Ui, state: &ViewerState, elapsed_ms: f64, row: &ObjectiveFit, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let full = rect.expand2(vec2(13.0, 0.0));
    let settings = &state.document.scene.fit;
    let is_taken = settings.objective == row.objective;
    if is_taken {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let line = |n: f32| {
        let top = rect.top() + 2.0 + 18.0 * n;
        Rect::from_min_max(pos2(rect.left(), top), pos2(rect.right(), top + 20.0))
    };
    let name = objective_title(row.objective);
    let id = if is_taken { strong(BODY) } else { font(BODY) };
    let _text = text_in(ui, line(0.0), Align::Min, name, id, tokens.text);
    let mut spoken = format!("Objective {name}");
    match &row.fit {
        Ok(fit) => {
            let numbers = [
                format::length(fit.radial_m),
                format::significant(fit.goodness_of_fit),
                format::volume(fit.volume_m3),
                format::elapsed(elapsed_ms),
            ];
            for (column, text) in numbers.iter().enumerate() {
                let _text = text_in(ui, cell(line(0.0), column), Align::Max, text, font(SECONDARY), tokens.text);
            }
            spoken += &format!(": E_r {}", numbers[0]);
            let stop = fit.runs.last().map_or_else(String::new, |run| format!(", {}", run.stop));
            let text = format!("{}{stop}", format::plural(fit.iterations as usize, "iteration"));
            let _text = text_in(ui, line(1.0), Align::Min, &text, font(SMALL), tokens.secondary);
        }
        Err(reason) => {
            let _text = text_in(ui, line(1.0), Align::Min, reason, font(SMALL), tokens.coral);
        }
    }
    if is_taken {
        let at = pos2(rect.left() + 72.0, line(0.0).center().y);
        icons::paint(ui.painter(), Icon::Check, at, 13.0, tokens.teal);
    }
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_taken, &spoken));
    focus_ring(ui, &response, full);
    if response.contains_pointer() || response.has_focus() {
        out.objective = Some(row.objective);
    }
    if response.on_hover_text(formula(row.objective)).clicked() {
        let settings = FitSettings { objective: row.objective, ..settings.clone() };
        out.push(Command::Lab(LabCommand::Settings(settings)));
    }
}
