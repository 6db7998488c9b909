//! The set of arm configurations behind a mean: stepping through it, its histogram, and what was turned away.

use egui::{Align, Rect, Sense, Stroke, Ui, pos2, vec2};
use endcomfort_core::grasp::{Grasp, Situated};

use crate::viewer::icons::Icon;
use crate::viewer::panels::Out;
use crate::viewer::state::{IkChoice, Situation};
use crate::viewer::theme::{BODY, SECONDARY, SMALL, Tokens, font};
use crate::viewer::widgets::{icon_button_at, paragraph, segmented, text_in};
use crate::viewer::{Command, ViewerState, format};

/// Where the IK set is looked at until somebody chooses.
pub(super) fn usual_situation(grasp: &Grasp) -> Situation {
    if grasp.goal.is_some() { Situation::Goal } else { Situation::Start }
}

/// `48 × joint 6 limit, 12 × elbow hits table`.
fn turned_away(set: &Situated) -> String {
    let reasons: Vec<String> =
        set.rejected.iter().map(|(reason, count)| format!("{} × {reason}", format::count(*count))).collect();
    if reasons.is_empty() { "No configuration.".to_owned() } else { reasons.join(", ") }
}

/// Which IK set, a way through its solutions, and the histogram of their manipulability.
pub(super) fn draw(ui: &mut Ui, state: &ViewerState, grasp: &Grasp, at: Situation, set: &Situated, out: &mut Out) {
    let tokens = Tokens::of(ui);
    ui.add_space(5.0);
    ui.horizontal(|ui| {
        if grasp.start.is_some() && grasp.goal.is_some() {
            let chosen = Some(usize::from(at == Situation::Goal));
            if let Some(index) = segmented(ui, "IK set", &["At start", "At goal"], chosen) {
                let at = if index == 0 { Situation::Start } else { Situation::Goal };
                out.push(Command::ShowIk(Some(IkChoice { at, index: 0 })));
            }
        } else {
            ui.label(egui::RichText::new("IK solutions").font(font(BODY)));
        }
        stepping(ui, state, at, set.solutions.len(), out);
    });
    ui.add_space(8.0);
    if set.manipulability.is_empty() {
        let _text = paragraph(ui, &turned_away(set), SECONDARY, tokens.coral);
        ui.add_space(8.0);
    } else {
        let chosen = state.selection.ik.filter(|ik| ik.at == at).and_then(|ik| set.manipulability.get(ik.index));
        histogram(ui, set, at, chosen.copied());
    }
}

/// `‹ 14 of 108 ›`.
fn stepping(ui: &mut Ui, state: &ViewerState, at: Situation, count: usize, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let rest = ui.available_rect_before_wrap();
    let row = Rect::from_min_max(pos2(rest.left(), rest.top()), pos2(rest.right(), rest.top() + 30.0));
    let button = |x: f32| Rect::from_center_size(pos2(x, row.center().y), vec2(22.0, 26.0));
    let (before, next) = (button(row.right() - 106.0), button(row.right() - 11.0));
    let present = state.selection.ik.filter(|ik| ik.at == at && ik.index < count).map(|ik| ik.index);
    let show = |index: usize| Command::ShowIk(Some(IkChoice { at, index }));
    if icon_button_at(ui, before, Icon::Left, "Solution before", count > 0).clicked() {
        out.push(show(present.map_or(0, |index| (index + count - 1) % count)));
    }
    if icon_button_at(ui, next, Icon::Right, "Next solution", count > 0).clicked() {
        out.push(show(present.map_or(0, |index| (index + 1) % count)));
    }
    let text = match present {
        Some(index) => format!("{} of {count}", index + 1),
        None => format!("{count} IK"),
    };
    let middle = Rect::from_min_max(pos2(before.right(), row.top()), pos2(next.left(), row.bottom()));
    let _text = text_in(ui, middle, Align::Center, &text, font(SECONDARY), tokens.secondary);
}

/// Manipulability over the IK set, in bars; the shown solution is marked.
fn histogram(ui: &mut Ui, set: &Situated, at: Situation, chosen: Option<f64>) {
    const BARS: usize = 14;
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 74.0), Sense::hover());
    let plot = Rect::from_min_max(rect.min, pos2(rect.left() + 0.58 * rect.width(), rect.bottom() - 16.0));
    let top = set.manipulability.iter().copied().filter(|m| m.is_finite()).fold(1e-6, f64::max);
    let bin = |m: f64| ((m / top * BARS as f64) as usize).min(BARS - 1);
    let mut counts = [0_usize; BARS];
    for &m in set.manipulability.iter().filter(|m| m.is_finite()) {
        counts[bin(m.max(0.0))] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(1).max(1);
    let width = plot.width() / BARS as f32;
    let lit = chosen.map(bin);
    for (index, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let height = (plot.height() * count as f32 / most as f32).max(2.0);
        let left = plot.left() + width * index as f32;
        let bar = Rect::from_min_max(pos2(left + 1.0, plot.bottom() - height), pos2(left + width - 1.0, plot.bottom()));
        let color = if lit == Some(index) { tokens.amber } else { tokens.teal };
        ui.painter().rect_filled(bar, 1.5, color);
    }
    ui.painter().hline(plot.x_range(), plot.bottom(), Stroke::new(1.0, tokens.line));
    let caption = |x: f32, anchor: egui::Align2, text: String| {
        let at = pos2(x, plot.bottom() + 3.0);
        let _rect = ui.painter().text(at, anchor, text, font(SMALL), tokens.secondary);
    };
    caption(plot.left(), egui::Align2::LEFT_TOP, "0".to_owned());
    caption(plot.right(), egui::Align2::RIGHT_TOP, format::manipulability(top));
    let words = Rect::from_min_max(pos2(plot.right() + 14.0, plot.top()), pos2(rect.right(), plot.top() + 18.0));
    let place = if at == Situation::Goal { "goal" } else { "start" };
    let _text = text_in(ui, words, Align::Min, &format!("m(q), IK set at {place}"), font(SMALL), tokens.secondary);
    let line = |n: f32| words.translate(vec2(0.0, 18.0 * n));
    let mean = format!("mean {} · N {}", format::manipulability(set.m_g), set.ik_count);
    let _text = text_in(ui, line(1.0), Align::Min, &mean, font(SECONDARY), tokens.text);
    if let Some(m) = chosen {
        let shown = format!("shown {}", format::manipulability(m));
        let _text = text_in(ui, line(2.0), Align::Min, &shown, font(SECONDARY), tokens.text);
    }
}
