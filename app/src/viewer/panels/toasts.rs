//! Sentences for the person, under the top bar.

use egui::{Align2, Area, Id, Order, Stroke, Ui, vec2};

use super::Out;
use crate::viewer::icons::{self, Icon};
use crate::viewer::layout::Layout;
use crate::viewer::state::Message;
use crate::viewer::theme::{BODY, MARGIN, RADIUS, SECONDARY, Tokens};
use crate::viewer::widgets::{icon_button, paragraph};
use crate::viewer::{Command, ViewerState};

/// How long a message that is no failure stays, seconds.
const STAYS_S: f64 = 7.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, layout: &Layout, out: &mut Out) {
    if state.messages.is_empty() {
        return;
    }
    let width = (layout.free.width() - 4.0 * MARGIN).min(460.0).max(260.0);
    let at = egui::pos2(layout.free.center().x, layout.top.bottom() + MARGIN);
    Area::new(Id::unique("Messages")).order(Order::Foreground).pivot(Align2::CENTER_TOP).fixed_pos(at).show(
        ui.ctx(),
        |ui| {
            ui.set_width(width);
            ui.spacing_mut().item_spacing.y = 8.0;
            for message in &state.messages {
                show(ui, message, width, out);
            }
        },
    );
}

fn show(ui: &mut Ui, message: &Message, width: f32, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (icon, color) = if message.is_error { (Icon::Warning, tokens.coral) } else { (Icon::Note, tokens.teal_text) };
    egui::Frame::new()
        .fill(tokens.overlay)
        .stroke(Stroke::new(1.0, if message.is_error { tokens.coral } else { tokens.line }))
        .corner_radius(RADIUS)
        .inner_margin(12)
        .shadow(tokens.shadow)
        .show(ui, |ui| {
            ui.set_width(width - 26.0);
            ui.horizontal_top(|ui| {
                let (rect, _) = ui.allocate_exact_size(vec2(20.0, 20.0), egui::Sense::hover());
                icons::paint(ui.painter(), icon, icons::leading(rect, 16.0), 16.0, color);
                ui.vertical(|ui| {
                    ui.set_width(width - 26.0 - 20.0 - 8.0 - 36.0);
                    let _text = paragraph(ui, &message.text, BODY, tokens.text);
                    for detail in message.details.iter().take(4) {
                        let _text = paragraph(ui, detail, SECONDARY, tokens.secondary);
                    }
                });
                if icon_button(ui, Icon::Cross, "Close this message", true, false).clicked() {
                    out.push(Command::Dismiss(message.id));
                }
            });
        });
    if !message.is_error {
        let now = ui.input(|input| input.time);
        let born = ui.data_mut(|data| *data.get_temp_mut_or(Id::unique(("message", message.id)), now));
        let left = STAYS_S - (now - born);
        if left <= 0.0 {
            out.push(Command::Dismiss(message.id));
        } else {
            ui.ctx().request_repaint_after_secs(left as f32);
        }
    }
}
