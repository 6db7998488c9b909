//! What the page says while a file hovers over it.

use egui::{Align2, Id, LayerId, Order, Stroke, StrokeKind, Ui, vec2};

use crate::viewer::icons::{self, Icon};
use crate::viewer::theme::{BODY, RADIUS, Tokens, font, strong};

pub(super) fn draw(ui: &Ui) {
    if ui.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let tokens = Tokens::of(ui);
    let window = ui.max_rect();
    let painter = ui.ctx().layer_painter(LayerId::new(Order::Foreground, Id::unique("Drop")));
    painter.rect_filled(window, 0.0, tokens.scrim);
    let zone = window.shrink(24.0);
    painter.rect(zone, RADIUS + 4, tokens.teal.gamma_multiply(0.10), Stroke::new(2.0, tokens.teal), StrokeKind::Inside);
    let middle = zone.center();
    let words = egui::Rect::from_center_size(middle + vec2(0.0, 8.0), vec2(440.0, 132.0));
    painter.rect(words, RADIUS, tokens.overlay, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    icons::paint(&painter, Icon::File, middle - vec2(0.0, 26.0), 30.0, tokens.teal);
    let text = "Drop a cloud, a scene, a session, or a robot with its meshes";
    let _rect = painter.text(middle + vec2(0.0, 14.0), Align2::CENTER_CENTER, text, strong(16.0), tokens.text);
    let text = "The pipeline runs on it at once. Undo brings this scene back.";
    let _rect = painter.text(middle + vec2(0.0, 40.0), Align2::CENTER_CENTER, text, font(BODY), tokens.secondary);
}
