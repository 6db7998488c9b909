//! Measured points over the view: the lines between them, their distance or angle, and what to do next.

use egui::{Align2, Pos2, Rect, Stroke, StrokeKind, Ui, vec2};
use nalgebra::Point3;

use super::goal_gizmo::Shot;
use super::layout::Layout;
use super::looking::Measured;
use super::theme::{BODY, MARGIN, SECONDARY, Tokens, font, strong};
use super::{ViewerState, format};

/// Radius of a measured point, points.
const DOT: f32 = 5.0;

/// Draws what was measured, over the picture.
pub(super) fn paint(ui: &Ui, shot: Shot<'_>, layout: &Layout, state: &ViewerState) {
    let Some(points) = &state.looking.measured else { return };
    let tokens = Tokens::of(ui);
    let painter = ui.painter();
    let seen: Vec<Pos2> = points.iter().filter_map(|p_W| shot.project(p_W)).collect();
    for pair in seen.windows(2) {
        painter.line_segment([pair[0], pair[1]], Stroke::new(4.5, tokens.view_edge.gamma_multiply(0.6)));
        painter.line_segment([pair[0], pair[1]], Stroke::new(2.0, tokens.amber));
    }
    for at in &seen {
        painter.circle(*at, DOT, tokens.amber, Stroke::new(1.5, tokens.view_edge));
    }
    if let (Some(measured), true) = (Measured::of(points), seen.len() == points.len()) {
        let at = if seen.len() == 2 { seen[0] + 0.5 * (seen[1] - seen[0]) } else { seen[1] };
        pill(ui, at - vec2(0.0, 16.0), &measured.words(), &detail(points));
    }
    let hint = match points.len() {
        0 => "Click a point to measure from.",
        1 => "Click a second point: their distance.",
        2 => "Click a third point: the angle at the second one. Esc ends.",
        _ => "Click to measure anew. Esc ends.",
    };
    let galley = painter.layout_no_wrap(hint.to_owned(), font(BODY), tokens.text);
    let middle = Pos2::new(layout.free.center().x, layout.free.top() + MARGIN + 18.0);
    let back = Rect::from_center_size(middle, galley.size() + vec2(24.0, 14.0));
    painter.rect(back, 8.0, tokens.panel, Stroke::new(1.0, tokens.amber), StrokeKind::Inside);
    painter.galley(back.center() - 0.5 * galley.size(), galley, tokens.text);
}

/// The way along the axes, or the legs of an angle.
fn detail(points: &[Point3<f64>]) -> String {
    let mm = |m: f64| format!("{:.1}", 1e3 * m).replace('-', "–");
    match points {
        [a, b] => {
            let way = b - a;
            format!("x {} · y {} · z {} mm", mm(way.x), mm(way.y), mm(way.z))
        }
        [a, b, c] => {
            let legs = [(a - b).norm(), (c - b).norm()].map(format::millimetres_fine);
            format!("between {} and {}", legs[0], legs[1])
        }
        _ => String::new(),
    }
}

fn pill(ui: &Ui, foot: Pos2, value: &str, detail: &str) {
    let tokens = Tokens::of(ui);
    let value = ui.painter().layout_no_wrap(value.to_owned(), strong(BODY), tokens.text);
    let detail = ui.painter().layout_no_wrap(detail.to_owned(), font(SECONDARY), tokens.secondary);
    let size = vec2(value.size().x.max(detail.size().x) + 20.0, value.size().y + detail.size().y + 12.0);
    let back = Align2::CENTER_BOTTOM.anchor_size(foot, size);
    ui.painter().rect(back, 6.0, tokens.panel, Stroke::new(1.0, tokens.amber), StrokeKind::Inside);
    let top = back.top() + 6.0;
    let at = |width: f32, y: f32| Pos2::new(back.center().x - 0.5 * width, y);
    let (first, second) = (at(value.size().x, top), at(detail.size().x, top + value.size().y));
    ui.painter().galley(first, value, tokens.text);
    ui.painter().galley(second, detail, tokens.secondary);
}
