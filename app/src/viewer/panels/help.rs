//! The list of keys.

use egui::{Align, Id, Modal, Rect, ScrollArea, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

use super::Out;
use crate::viewer::actions::{self, Action, Topic};
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{overlay_frame, section, text_in, title};
use crate::viewer::{Command, Overlay, ViewerState};

/// Width of a column, and of the keys in it, points.
const COLUMN: f32 = 340.0;
const KEYS: f32 = 128.0;
const GAP: f32 = 28.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let frame = overlay_frame(tokens, 22);
    let window = ui.max_rect();
    let widest = window.width() - 80.0;
    let columns = if widest >= 2.0 * COLUMN + GAP { 2 } else { 1 };
    let width = (columns as f32 * COLUMN + (columns - 1) as f32 * GAP).min(widest);
    let modal = Modal::new(Id::unique("Help")).frame(frame).backdrop_color(tokens.scrim).show(ui.ctx(), |ui| {
        ui.set_width(width);
        ui.spacing_mut().item_spacing.y = 1.0;
        title(ui, "Keys and gestures");
        let actions = actions::with_keys(state);
        let height = window.height() - 130.0;
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            let column = (width - (columns - 1) as f32 * GAP) / columns as f32;
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = GAP;
                for topics in Topic::WITH_KEYS.chunks(Topic::WITH_KEYS.len().div_ceil(columns)) {
                    ui.allocate_ui(vec2(column, 0.0), |ui| {
                        ui.vertical(|ui| {
                            ui.set_width(column);
                            topics.concat().into_iter().for_each(|topic| rows(ui, topic, &actions));
                        });
                    });
                }
            });
        });
    });
    if modal.should_close() {
        out.push(Command::Show(Overlay::None));
    }
}

fn rows(ui: &mut Ui, topic: Topic, actions: &[Action]) {
    section(ui, topic.title());
    for action in actions.iter().filter(|action| action.topic == topic) {
        if let Some(shortcut) = action.shortcut {
            row(ui, shortcut.name, &action.title);
        }
    }
    if topic == Topic::View {
        for (gesture, what) in actions::GESTURES {
            row(ui, gesture, what);
        }
    }
}

fn row(ui: &mut Ui, keys: &str, what: &str) {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::hover());
    let galley = ui.painter().layout_no_wrap(keys.to_owned(), font(SECONDARY), tokens.secondary);
    let cap = vec2(galley.size().x + 14.0, 21.0);
    let cap = Rect::from_min_size(pos2(rect.left(), rect.center().y - 10.5), cap);
    ui.painter().rect(cap, 5.0, tokens.well, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    ui.painter().galley(cap.center() - 0.5 * galley.size(), galley, tokens.secondary);
    let left = (rect.left() + KEYS).max(cap.right() + 10.0);
    let text = Rect::from_min_max(pos2(left, rect.top()), rect.max);
    let _text = text_in(ui, text, Align::Min, what, font(BODY), tokens.text);
}
