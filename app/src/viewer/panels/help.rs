//! The list of keys.

use egui::{Align, Id, Modal, Rect, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

use super::Out;
use crate::viewer::keys;
use crate::viewer::theme::{BODY, RADIUS, SECONDARY, Tokens, font};
use crate::viewer::widgets::{text_in, title};
use crate::viewer::{Command, Overlay};

pub(super) fn draw(ui: &mut Ui, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let frame = egui::Frame::new()
        .fill(tokens.overlay)
        .stroke(Stroke::new(1.0, tokens.line))
        .corner_radius(RADIUS + 2)
        .inner_margin(22)
        .shadow(tokens.shadow);
    let width = (ui.max_rect().width() - 80.0).min(460.0);
    let modal = Modal::new(Id::unique("Help")).frame(frame).backdrop_color(tokens.scrim).show(ui.ctx(), |ui| {
        ui.set_width(width);
        ui.spacing_mut().item_spacing.y = 1.0;
        title(ui, "Keys and gestures");
        ui.add_space(8.0);
        for (keys, what) in keys::LIST {
            row(ui, keys, what);
        }
    });
    if modal.should_close() {
        out.push(Command::Show(Overlay::None));
    }
}

fn row(ui: &mut Ui, keys: &str, what: &str) {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 28.0), Sense::hover());
    let text = Rect::from_min_max(pos2(rect.left() + 186.0, rect.top()), rect.max);
    let _text = text_in(ui, text, Align::Min, what, font(BODY), tokens.text);
    // Keys that are pressed one after the other, or instead of each other, are two spaces apart.
    let mut left = rect.left();
    for key in keys.split("  ") {
        let galley = ui.painter().layout_no_wrap(key.to_owned(), font(SECONDARY), tokens.secondary);
        let size = vec2(galley.size().x + 14.0, 22.0);
        let cap = Rect::from_min_size(pos2(left, rect.center().y - 11.0), size);
        ui.painter().rect(cap, 5.0, tokens.well, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
        ui.painter().galley(cap.center() - 0.5 * galley.size(), galley, tokens.secondary);
        left = cap.right() + 5.0;
    }
}
