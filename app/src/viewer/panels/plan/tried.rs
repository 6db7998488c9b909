//! What was tried in vain: each grasp with the phase that failed and why; a row shows it in the view.

use std::collections::BTreeMap;

use egui::text::LayoutJob;
use egui::{Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::job::Refusal;
use endcomfort_core::task::Try;

use crate::export::TableKind;
use crate::viewer::icons::{self, Icon};
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::{elided, focus_ring, paragraph, section};
use crate::viewer::{Command, PlanCommand, ViewerState, format};

/// How far a row reaches into the panel's margin, points.
const OUTSIDE: f32 = 13.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let tries = state.tries();
    if tries.is_empty() {
        let text = "Nothing failed before this plan.";
        let text = if state.outputs.plan.is_some() { text } else { "No grasp came as far as a motion." };
        let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
        return;
    }
    saved_section(ui, "Tried in vain", TableKind::Tried, None, out);
    let _text = paragraph(ui, &said(tries), SECONDARY, tokens.secondary);
    ui.add_space(4.0);
    for (index, tried) in tries.iter().enumerate() {
        row(ui, state, index, tried, out);
    }
}

/// What else a refusal says.
pub(super) fn details(ui: &mut Ui, refusal: &Refusal) {
    if refusal.details.is_empty() {
        return;
    }
    let tokens = Tokens::of(ui);
    section(ui, "Details");
    for detail in &refusal.details {
        let _text = paragraph(ui, detail, SECONDARY, tokens.secondary);
    }
}

/// How many were tried and in which phases they failed: `3 tries failed: 2 in transport, 1 in place.`
fn said(tries: &[Try]) -> String {
    let mut phases: BTreeMap<&str, usize> = BTreeMap::new();
    for tried in tries {
        *phases.entry(tried.phase.map_or("before any motion", |phase| phase.name())).or_default() += 1;
    }
    let mut phases: Vec<(&str, usize)> = phases.into_iter().collect();
    phases.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
    let word = |(name, count): &(&str, usize)| match *name {
        "before any motion" => format!("{count} before any motion"),
        name => format!("{count} in {name}"),
    };
    let where_from = phases.iter().map(word).collect::<Vec<_>>().join(", ");
    let noun = if tries.len() == 1 { "try" } else { "tries" };
    let grasps: std::collections::BTreeSet<u32> = tries.iter().filter_map(|tried| tried.grasp).collect();
    let with =
        if grasps.is_empty() { String::new() } else { format!(" with {}", format::plural(grasps.len(), "grasp")) };
    format!("{} {noun}{with} failed: {where_from}. Point at one to see it.", format::count(tries.len()))
}

fn row(ui: &mut Ui, state: &ViewerState, index: usize, tried: &Try, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let is_selected = state.planning.selected_try == Some(index);
    let width = ui.available_width();
    let grasp = tried.grasp.map_or("Before".to_owned(), |id| format::title_of(&state.grasp_title(id)));
    let title = tried.phase.map_or_else(|| grasp.clone(), |phase| format!("{grasp} · {}", phase.name()));
    let head = elided(ui, &title, if is_selected { strong(BODY) } else { font(BODY) }, tokens.text, width - 30.0);
    let job = LayoutJob::simple(tried.reason.clone(), font(SECONDARY), tokens.coral, width - 4.0);
    let reason = ui.painter().layout_job(job);
    let size = vec2(width, head.size().y + reason.size().y + 14.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let full = rect.expand2(vec2(OUTSIDE, 0.0));
    if is_selected {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let top = rect.top() + 6.0;
    let can_be_seen = !tried.q.is_empty() || !tried.culprits.is_empty();
    if can_be_seen {
        let ink = if is_selected || response.hovered() { tokens.teal } else { tokens.faint };
        icons::paint(ui.painter(), Icon::Eye, pos2(rect.right() - 9.0, top + 0.5 * head.size().y), 14.0, ink);
    }
    let below = top + head.size().y + 2.0;
    ui.painter().galley(pos2(rect.left(), top), head, tokens.text);
    // On the selected row's ground coral would be too faint.
    let ink = if is_selected { tokens.text } else { tokens.coral };
    ui.painter().galley_with_override_text_color(pos2(rect.left(), below), reason, ink);
    focus_ring(ui, &response, full);
    response.widget_info(|| {
        let text = format!("Try {}: {title}: {}", index + 1, tried.reason);
        WidgetInfo::selected(Role::Button, true, is_selected, text)
    });
    if response.hovered() || response.has_focus() {
        out.tried = Some(index);
    }
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        out.push(Command::Planning(PlanCommand::ShowTry((!is_selected).then_some(index))));
    }
}

#[cfg(test)]
mod tests {
    use endcomfort_core::task::PhaseKind;

    use super::*;

    #[test]
    fn tries_are_counted_by_the_phase_that_failed_most_first() {
        let tried = |grasp: u32, phase| Try {
            grasp: Some(grasp),
            phase,
            reason: String::new(),
            culprits: Vec::new(),
            q: Vec::new(),
            carries: false,
            arm: None,
            X_WO: None,
        };
        let tries = [
            tried(1, Some(PhaseKind::Place)),
            tried(1, Some(PhaseKind::Transport)),
            tried(2, Some(PhaseKind::Transport)),
            tried(3, None),
        ];
        let wanted =
            "4 tries with 3 grasps failed: 2 in transport, 1 before any motion, 1 in place. Point at one to see it.";
        assert_eq!(said(&tries), wanted);
        assert_eq!(said(&tries[..1]), "1 try with 1 grasp failed: 1 in place. Point at one to see it.");
    }
}
