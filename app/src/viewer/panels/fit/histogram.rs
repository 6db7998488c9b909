//! The signed errors of all points, in the colours of the view.

use egui::{Align2, Color32, Rect, Sense, Stroke, Ui, pos2, vec2};

use crate::export::{HISTOGRAM_BARS, Histogram};
use crate::render::{ColorMap, Scale};
use crate::viewer::format;
use crate::viewer::theme::{SECONDARY, SMALL, Tokens};
use crate::viewer::widgets::paragraph;

/// Bars over the range that holds nearly all errors, and two sentences: the bias, and what 95 % keep within.
pub(super) fn draw(ui: &mut Ui, distances_m: &[f64]) {
    let tokens = Tokens::of(ui);
    let Some(found) = Histogram::of(distances_m) else { return };
    let end_m = found.end_m;
    let scale = Scale { map: ColorMap::Diverging, min: -end_m, max: end_m, is_log: false };
    let most = found.counts.iter().copied().max().unwrap_or(1).max(1);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 92.0), Sense::hover());
    let plot = Rect::from_min_max(rect.min + vec2(0.0, 4.0), rect.max - vec2(0.0, 18.0));
    let width = plot.width() / HISTOGRAM_BARS as f32;
    let line = Stroke::new(1.0, tokens.line);
    ui.painter().hline(plot.x_range(), plot.bottom(), line);
    for (index, &count) in found.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let height = (plot.height() * count as f32 / most as f32).max(1.5);
        let left = plot.left() + width * index as f32;
        let bar =
            Rect::from_min_max(pos2(left + 0.75, plot.bottom() - height), pos2(left + width - 0.75, plot.bottom()));
        let middle_m = 0.5 * (found.edge_m(index) + found.edge_m(index + 1));
        let [r, g, b, _] = scale.color(middle_m).map(|c| (255.0 * c).round() as u8);
        // The middle of the map is nearly white: its outline keeps it apart from a light panel.
        let outline = Stroke::new(0.75, tokens.faint);
        ui.painter().rect(bar, 1.0, Color32::from_rgb(r, g, b), outline, egui::StrokeKind::Inside);
    }
    ui.painter().vline(plot.center().x, plot.y_range(), Stroke::new(1.0, tokens.faint.gamma_multiply(0.6)));
    let caption = |x: f32, anchor: Align2, text: String| {
        let at = pos2(x, plot.bottom() + 4.0);
        let _rect = ui.painter().text(at, anchor, text, crate::viewer::theme::font(SMALL), tokens.secondary);
    };
    caption(plot.left(), Align2::LEFT_TOP, format!("–{} inside", format::length(end_m)));
    caption(plot.center().x, Align2::CENTER_TOP, "0".to_owned());
    caption(plot.right(), Align2::RIGHT_TOP, format!("+{} outside", format::length(end_m)));
    let side = if found.mean_m < 0.0 { "inside" } else { "outside" };
    let text = format!(
        "95 % within {} of the surface; on average {} {side}.",
        format::length(found.within_95_m),
        format::length(found.mean_m.abs())
    );
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Histogram: {text}")));
    let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
}
