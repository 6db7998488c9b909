//! A value between two ends, dragged along a track.

use egui::{Align, Key, Rect, Sense, Ui, WidgetInfo, pos2, vec2};

use super::theme::{SECONDARY, Tokens, font};
use super::widgets::{focus_ring, text_in};

const HEIGHT: f32 = 26.0;
/// Width of the words at the end of the track, points.
const WORDS: f32 = 62.0;
const KNOB: f32 = 6.5;

/// A track over the available width with the value in words at its end; gives the new value when it was moved, by the
/// pointer or by the arrow keys in hundredths. `name` is what assistive technology reads.
pub(super) fn slider(ui: &mut Ui, name: &str, words: &str, value: f64, [min, max]: [f64; 2]) -> Option<f64> {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::slider(true, value, format!("{name}: {words}")));
    let words_rect = Rect::from_min_max(pos2(rect.right() - WORDS, rect.top()), rect.max);
    let _text = text_in(ui, words_rect, Align::Max, words, font(SECONDARY), tokens.secondary);
    let left = rect.left() + KNOB + 1.0;
    let right = words_rect.left() - KNOB - 6.0;
    let span = max - min;
    let share = if span > 0.0 { ((value - min) / span).max(0.0).min(1.0) } else { 0.0 };
    let x = left + (right - left) * share as f32;
    let y = rect.center().y;
    let track = Rect::from_min_max(pos2(left, y - 2.0), pos2(right, y + 2.0));
    ui.painter().rect_filled(track, 2.0, tokens.well);
    ui.painter().rect_stroke(track, 2.0, egui::Stroke::new(1.0, tokens.line), egui::StrokeKind::Outside);
    ui.painter().rect_filled(track.with_max_x(x), 2.0, tokens.teal);
    let lit = response.hovered() || response.dragged();
    ui.painter().circle_filled(pos2(x, y), if lit { KNOB + 1.0 } else { KNOB }, tokens.teal);
    focus_ring(ui, &response, rect);
    let mut wanted = value;
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged() || response.clicked()) {
        wanted = min + span * f64::from((pointer.x - left) / (right - left).max(1.0)).max(0.0).min(1.0);
    }
    if response.has_focus() {
        let presses = |key: Key| ui.input(|input| input.num_presses(key)) as f64;
        wanted += 0.01 * span * (presses(Key::ArrowRight) - presses(Key::ArrowLeft));
        ui.memory_mut(|memory| {
            let horizontal = egui::EventFilter { horizontal_arrows: true, ..egui::EventFilter::default() };
            memory.set_focus_lock_filter(response.id, horizontal);
        });
    }
    let wanted = wanted.max(min).min(max.max(min));
    let _cursor = response.on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
    (wanted != value).then_some(wanted)
}
