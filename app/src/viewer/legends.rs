//! What stands over the view and says what its marks and colours mean.

use egui::{Align2, Color32, Mesh, Painter, Pos2, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};

use super::layout::Layout;
use super::theme::{BODY, MARGIN, SECONDARY, SMALL, Tokens, font, strong};
use super::widgets::elided;
use super::{Legend, Mark, ScaleBar, format};
use crate::render::ColorMap;

const ROW: f32 = 20.0;
const PADDING: f32 = 12.0;

/// The meaning of the marks, high in the free part of the view.
pub(super) fn legend(ui: &Ui, layout: &Layout, legend: &Legend) {
    let tokens = Tokens::of(ui);
    let most = layout.free.width() - 2.0 * MARGIN - 2.0 * PADDING;
    if most < 100.0 {
        return;
    }
    let title = elided(ui, &legend.title, strong(BODY), tokens.text, most);
    let rows: Vec<_> =
        legend.rows.iter().map(|row| elided(ui, &row.text, font(SECONDARY), tokens.text, most - 24.0)).collect();
    let widest = rows.iter().map(|galley| galley.size().x + 24.0).fold(title.size().x, f32::max);
    let size = vec2(widest + 2.0 * PADDING, ROW * (rows.len() + 1) as f32 + 2.0 * PADDING - 4.0);
    let rect = Rect::from_min_size(layout.free.left_top() + vec2(MARGIN, MARGIN), size);
    ui.painter().rect(rect, 8.0, tokens.panel, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    let spoken: Vec<&str> = legend.rows.iter().map(|row| row.text.as_str()).collect();
    let spoken = format!("{}: {}", legend.title, spoken.join(", "));
    let response = ui.interact(rect, ui.scope_id().with("Legend"), Sense::empty());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &spoken));
    let mut y = rect.top() + PADDING + 0.5 * ROW - 2.0;
    let left = rect.left() + PADDING;
    ui.painter().galley(pos2(left, y - 0.5 * title.size().y), title, tokens.text);
    for (row, galley) in legend.rows.iter().zip(rows) {
        y += ROW;
        let [r, g, b, _] = row.color.map(|channel| (255.0 * channel).round() as u8);
        mark(ui.painter(), row.mark, pos2(left + 8.0, y), Color32::from_rgb(r, g, b));
        ui.painter().galley(pos2(left + 24.0, y - 0.5 * galley.size().y), galley, tokens.text);
    }
}

fn mark(painter: &Painter, mark: Mark, centre: Pos2, color: Color32) {
    match mark {
        Mark::Dot => {
            for (x, y) in [(-5.0, 2.5), (0.0, -2.5), (5.0, 2.5)] {
                painter.circle_filled(centre + vec2(x, y), 2.0, color);
            }
        }
        Mark::Signed => {
            for (x, t) in [(-5.5, 0.12), (0.0, 0.5), (5.5, 0.88)] {
                let [r, g, b, _] = ColorMap::Diverging.at(t).map(|c| (255.0 * c).round() as u8);
                painter.circle(centre + vec2(x, 0.0), 2.6, Color32::from_rgb(r, g, b), Stroke::new(0.5, Color32::GRAY));
            }
        }
        Mark::Disc => {
            painter.circle_filled(centre, 4.5, color);
        }
        Mark::Body => {
            let rect = Rect::from_center_size(centre, vec2(14.0, 11.0));
            let stroke = Stroke::new(1.2, color);
            painter.rect(rect, 4.0, color.gamma_multiply(0.42), stroke, StrokeKind::Inside);
        }
        Mark::Line => {
            painter.line_segment([centre - vec2(7.0, 0.0), centre + vec2(7.0, 0.0)], Stroke::new(1.8, color));
        }
    }
}

/// The meaning of the data colours, low in the free part of the view. A range with a sign has its zero in the middle.
pub(super) fn scale_bar(ui: &Ui, layout: &Layout, bar: &ScaleBar) {
    const STEPS: usize = 48;
    let tokens = Tokens::of(ui);
    let width = (layout.free.width() - 48.0).min(280.0);
    if width < 80.0 {
        return;
    }
    let (min, max) = (bar.scale.min, bar.scale.max);
    let is_signed = min < 0.0 && max > 0.0;
    let rect = Rect::from_min_size(layout.free.left_bottom() + vec2(24.0, -46.0), vec2(width, 8.0));
    let top = if is_signed { rect.top() - 24.0 } else { rect.top() - 8.0 };
    let back = rect.expand2(vec2(10.0, 0.0)).with_min_y(top).with_max_y(rect.bottom() + 26.0);
    ui.painter().rect_filled(back, 6.0, tokens.panel.gamma_multiply(if is_signed { 1.0 } else { 0.75 }));
    let mut mesh = Mesh::default();
    for step in 0..=STEPS {
        let u = step as f64 / STEPS as f64;
        let [r, g, b, _] = bar.scale.color(bar.scale.value_at(u)).map(|c| (255.0 * c).round() as u8);
        let x = rect.left() + rect.width() * u as f32;
        mesh.colored_vertex(pos2(x, rect.top()), Color32::from_rgb(r, g, b));
        mesh.colored_vertex(pos2(x, rect.bottom()), Color32::from_rgb(r, g, b));
        if step > 0 {
            let i = 2 * step as u32;
            mesh.add_triangle(i - 2, i - 1, i);
            mesh.add_triangle(i - 1, i, i + 1);
        }
    }
    ui.painter().add(mesh);
    let text = |at: Pos2, anchor: Align2, text: String| {
        let _rect = ui.painter().text(at, anchor, text, font(SMALL), tokens.secondary);
    };
    let y = rect.bottom() + 4.0;
    let (low, high) = (pos2(rect.left(), y), pos2(rect.right(), y));
    if is_signed {
        let end = |value: f64| format!("{}{} {}", if value < 0.0 { "–" } else { "+" }, short(value.abs()), bar.unit);
        text(pos2(rect.center().x, rect.top() - 5.0), Align2::CENTER_BOTTOM, bar.title.clone());
        text(low, Align2::LEFT_TOP, format!("{} inside", end(min)));
        text(pos2(rect.center().x, y), Align2::CENTER_TOP, "0".to_owned());
        text(high, Align2::RIGHT_TOP, format!("{} outside", end(max)));
        let (x, stroke) = (rect.center().x, Stroke::new(1.0, tokens.faint));
        ui.painter().vline(x, rect.top() - 2.0..=rect.bottom() + 3.0, stroke);
    } else {
        let end = |value: f64| format!("{} {}", format::significant(value), bar.unit).trim_end().to_owned();
        text(low, Align2::LEFT_TOP, end(min));
        text(pos2(rect.center().x, y), Align2::CENTER_TOP, bar.title.clone());
        text(high, Align2::RIGHT_TOP, end(max));
    }
}

/// A round number without idle zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
