//! The candidates as a list: what became of them, which are listed, and the table.

use egui::{Align, Color32, Rect, Role, Sense, Ui, UiBuilder, WidgetInfo, pos2, vec2};
use endcomfort_core::grasp::Quantity;

use super::{selected, table};
use crate::render::ColorMap;
use crate::viewer::fields::{dropdown, search};
use crate::viewer::panels::Out;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{focus_ring, section, segmented_wide, text_in};
use crate::viewer::{ColumnSet, Command, GraspCommand, Listed, ViewerState, format, quantities};

/// Height of the table that the details leave it at least: four rows and a half with the head.
const LEAST_TABLE: f32 = 141.0;
/// Width of the strip of colours with the gap behind it, points.
const RAMP: f32 = 12.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    choices(ui, state, out);
    ui.add_space(2.0);
    let rest = ui.available_rect_before_wrap();
    let wanted = state.selected_grasp().map_or(0.0, selected::brief_height);
    let details = if rest.height() - LEAST_TABLE < wanted { 0.0 } else { wanted };
    let split = rest.bottom() - details;
    let upper = Rect::from_min_max(rest.min, pos2(rest.right(), split - if details > 0.0 { 6.0 } else { 0.0 }));
    let mut inside = ui.new_child(UiBuilder::new().id_salt("table").max_rect(upper));
    inside.shrink_clip_rect(upper.expand2(vec2(14.0, 0.0)));
    table::draw(&mut inside, state, out);
    if details > 0.0 {
        let lower = Rect::from_min_max(pos2(rest.left(), split), rest.max);
        let mut inside = ui.new_child(UiBuilder::new().id_salt("details").max_rect(lower));
        selected::brief(&mut inside, state, out);
    }
}

/// Which candidates, which columns, which colours.
fn choices(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let mut push = |command: GraspCommand| out.push(Command::Grasping(command));
    let grasps = state.outputs.candidates();
    let accepted = grasps.iter().filter(|grasp| grasp.is_accepted()).count();
    let words = [
        format!("Accepted {}", format::count(accepted)),
        format!("All {}", format::count(grasps.len())),
        format!("Rejected {}", format::count(grasps.len() - accepted)),
    ];
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    if let Some(index) = segmented_wide(ui, "Listed", &words, Some(state.table.listed as usize)) {
        push(GraspCommand::List(Listed::ALL[index]));
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        let width = ui.available_width() - 12.0;
        let words = &state.table.search;
        if let Some(words) = search(ui, "Words in the table", "filter reasons…", words, 0.34 * width) {
            push(GraspCommand::Search(words));
        }
        let sets = ColumnSet::ALL.map(ColumnSet::title);
        let shown = state.table.columns;
        if let Some(index) = dropdown(ui, "Columns", shown.title(), 0.26 * width, &sets, Some(shown as usize)) {
            push(GraspCommand::Columns(ColumnSet::ALL[index]));
        }
        colors(ui, state, 0.40 * width, &mut push);
    });
}

/// What colours the grasps in the view.
fn colors(ui: &mut Ui, state: &ViewerState, width: f32, push: &mut impl FnMut(GraspCommand)) {
    let mut rows = vec!["What ranks them"];
    rows.extend(Quantity::ALL.map(quantities::short));
    let chosen = state.grasping.colored_by;
    let index = chosen.and_then(|chosen| Quantity::ALL.iter().position(|&quantity| quantity == chosen));
    let shown = quantities::short(state.shown_quantity());
    let row = index.map_or(0, |index| index + 1);
    ramp(ui);
    if let Some(index) = dropdown(ui, "Colour by", shown, width - RAMP, &rows, Some(row)) {
        push(GraspCommand::ColorBy(index.checked_sub(1).map(|index| Quantity::ALL[index])));
    }
}

/// A strip of the colours that the next field chooses the meaning of.
fn ramp(ui: &mut Ui) {
    const STEPS: usize = 12;
    let (rect, _) = ui.allocate_exact_size(vec2(RAMP - 6.0, 28.0), Sense::hover());
    let step = rect.height() / STEPS as f32;
    for k in 0..STEPS {
        let [r, g, b, _] = ColorMap::Viridis.at(1.0 - k as f64 / (STEPS - 1) as f64).map(|c| (255.0 * c).round() as u8);
        let cell = Rect::from_min_size(rect.min + vec2(0.0, step * k as f32), vec2(rect.width(), step + 0.5));
        ui.painter().rect_filled(cell, 0.0, Color32::from_rgb(r, g, b));
    }
}

/// How many candidates met each fate, most frequent first; a click lists them.
pub(super) fn fates(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let grasps = state.outputs.candidates();
    let mut counts: Vec<(&'static str, bool, usize)> = Vec::new();
    for grasp in grasps {
        let words = format::status_words(&grasp.status);
        match counts.iter_mut().find(|(known, ..)| *known == words) {
            Some((_, _, count)) => *count += 1,
            None => counts.push((words, grasp.is_accepted(), 1)),
        }
    }
    counts.sort_by_key(|&(words, _, count)| (std::cmp::Reverse(count), words));
    let most = counts.iter().map(|&(.., count)| count).max().unwrap_or(1);
    section(ui, "What became of them");
    for (name, is_accepted, count) in counts {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::click());
        let full = rect.expand2(vec2(13.0, 0.0));
        if response.hovered() {
            ui.painter().rect_filled(full, 0.0, tokens.hover);
        }
        let text = Rect::from_min_max(rect.min, pos2(rect.left() + 0.46 * rect.width(), rect.bottom()));
        let _text = text_in(ui, text, Align::Min, name, font(BODY), tokens.text);
        let number = Rect::from_min_max(pos2(rect.right() - 44.0, rect.top()), rect.max);
        let _text = text_in(ui, number, Align::Max, &format::count(count), font(SECONDARY), tokens.secondary);
        let track = Rect::from_min_max(
            pos2(text.right() + 8.0, rect.center().y - 2.5),
            pos2(number.left() - 6.0, rect.center().y + 2.5),
        );
        let mut bar = track;
        bar.set_width((track.width() * count as f32 / most as f32).max(2.0));
        ui.painter().rect_filled(bar, 2.5, if is_accepted { tokens.teal } else { tokens.coral });
        focus_ring(ui, &response, full);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("List {count}: {name}")));
        let response = response.on_hover_cursor(egui::CursorIcon::PointingHand).on_hover_text("List them in the table");
        if response.clicked() {
            out.push(Command::Grasping(GraspCommand::ListFate(name)));
        }
    }
}
