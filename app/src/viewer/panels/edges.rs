//! The inner edges of the panels, which can be dragged; a double click gives a panel its usual size back.

use egui::{CursorIcon, Key, Rect, Sense, Stroke, Ui, WidgetInfo, pos2};

use super::Out;
use crate::viewer::Command;
use crate::viewer::layout::{Edge, Layout};
use crate::viewer::theme::{MARGIN, Tokens};

/// How far an arrow key moves an edge, points.
const KEY_STEP: f32 = 16.0;

pub(super) fn draw(ui: &mut Ui, layout: &Layout, out: &mut Out) {
    if layout.is_narrow {
        return;
    }
    for edge in Edge::ALL {
        let Some((strip, size)) = place(edge, layout) else { continue };
        let response = ui.interact(strip, ui.scope_id().with(("edge", edge as usize)), Sense::click_and_drag());
        let name = format!("Size of the {}", edge.words());
        response.widget_info(|| WidgetInfo::slider(true, f64::from(size), &name));
        let is_upright = edge != Edge::Timeline;
        let mut grown = match edge {
            Edge::Left => response.drag_delta().x,
            Edge::Right => -response.drag_delta().x,
            Edge::Timeline => -response.drag_delta().y,
        };
        if response.has_focus() {
            let presses = |key: Key| ui.input(|input| input.num_presses(key)) as f32;
            grown += match edge {
                Edge::Left => KEY_STEP * (presses(Key::ArrowRight) - presses(Key::ArrowLeft)),
                Edge::Right => KEY_STEP * (presses(Key::ArrowLeft) - presses(Key::ArrowRight)),
                Edge::Timeline => KEY_STEP * (presses(Key::ArrowUp) - presses(Key::ArrowDown)),
            };
            let arrows = egui::EventFilter {
                horizontal_arrows: is_upright,
                vertical_arrows: !is_upright,
                ..egui::EventFilter::default()
            };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
        }
        if response.double_clicked() {
            out.push(Command::ResizePanel(edge, None));
        } else if grown != 0.0 {
            out.push(Command::ResizePanel(edge, Some(size + grown)));
        }
        if response.hovered() || response.dragged() || response.has_focus() {
            let stroke = Stroke::new(2.0, Tokens::of(ui).teal);
            let middle = strip.center();
            let (from, to) = match is_upright {
                true => (pos2(middle.x, strip.top() + MARGIN), pos2(middle.x, strip.bottom() - MARGIN)),
                false => (pos2(strip.left() + MARGIN, middle.y), pos2(strip.right() - MARGIN, middle.y)),
            };
            ui.painter().line_segment([from, to], stroke);
        }
        let cursor = if is_upright { CursorIcon::ResizeHorizontal } else { CursorIcon::ResizeVertical };
        let _cursor = response.on_hover_cursor(cursor);
    }
}

/// The strip beside a panel that is taken hold of, and the panel's size.
fn place(edge: Edge, layout: &Layout) -> Option<(Rect, f32)> {
    let half = 0.5 * MARGIN;
    Some(match edge {
        Edge::Left => {
            let panel = layout.left?;
            let x = panel.right() + half;
            (Rect::from_x_y_ranges(x - half..=x + half, panel.y_range()), panel.width())
        }
        Edge::Right => {
            let panel = layout.right?;
            let x = panel.left() - half;
            (Rect::from_x_y_ranges(x - half..=x + half, panel.y_range()), panel.width())
        }
        Edge::Timeline => {
            let panel = layout.timeline;
            let y = panel.top() - half;
            (Rect::from_x_y_ranges(layout.free.x_range(), y - half..=y + half), panel.height())
        }
    })
}
