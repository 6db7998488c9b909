//! How well the fit explains the cluster, and which points count.

use egui::{Align, Rect, Sense, Ui, pos2, vec2};
use endcomfort_core::fit::Fit;
use endcomfort_core::job::Stage;

use super::histogram;
use crate::compose::Palette;
use crate::export::{PlotKind, TableKind};
use crate::render::Theme;
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{key_value, key_value_colored, paragraph, secondary_button, section, text_in};
use crate::viewer::{Command, LabCommand, StageState, ViewerState, format};

pub(super) const E_R: &str = "E_r (3.10): mean over the input points of the radial distance |p| · |1 – f^(–e1/2)|, \
                              measured along the ray from the centre.";
pub(super) const E_G: &str = "E_g (3.9) as it is printed: mean over the input points of (f^e1 – 1)². It has no unit.";
const E_G_ABS: &str = "The thesis's tables 3.2 and 3.3 were made with mean |f – 1|. It has no unit.";
const VOLUME: &str = "Volume (3.11) of all parts, deformations included.";

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, fit: &Fit, out: &mut Out) {
    saved_section(ui, "Errors", TableKind::Fits, None, out);
    let automatic = state.automatic_fit();
    let of_fit = |value: String, of: Option<String>| match of {
        Some(of) => format!("{value}, the fit has {of}"),
        None => value,
    };
    let radial = of_fit(format::length(fit.radial_m), automatic.map(|fit| format::length(fit.radial_m)));
    let _row = key_value(ui, "E_r, mean radial distance", &radial).on_hover_text(E_R);
    let _row =
        key_value(ui, "E_g (3.9), mean (f^e1 – 1)²", &format::significant(fit.goodness_of_fit)).on_hover_text(E_G);
    let _row = key_value(ui, "E_g of the tables, mean |f – 1|", &format::significant(fit.goodness_of_fit_abs))
        .on_hover_text(E_G_ABS);
    let _row = key_value(ui, "Volume", &format::volume(fit.volume_m3)).on_hover_text(VOLUME);
    if let StageState::Done { elapsed_ms } = state.stage(Stage::Fit) {
        let tip = "Computing time of the Fit step for all clusters; near zero when it was answered from memory.";
        let _row = key_value(ui, "Time, all clusters", &format::elapsed(*elapsed_ms)).on_hover_text(tip);
    }
    let points = format!("{} of {}", format::count(fit.used_points), format::count(fit.points));
    let tip = "Voxel centroids that were fitted, mirrored ones included, of the cluster's input points.";
    let _row = key_value(ui, "Points used, after thinning", &points).on_hover_text(tip);

    let distances = state.outputs.fit.as_ref().zip(state.examined_cluster());
    if let Some(distances_m) = distances.and_then(|(output, cluster)| output.distances_m.get(cluster)) {
        let plot = Some(PlotKind::Residuals);
        saved_section(ui, "Signed radial distance of the points", TableKind::Residuals, plot, out);
        histogram::draw(ui, distances_m);
    }
    if fit.others.is_empty() {
        parameters(ui, fit);
    } else {
        parts(ui, fit);
    }
    section(ui, "Mirrored points");
    let tokens = Tokens::of(ui);
    let _text = paragraph(ui, &sentence(&fit.mirror_note), SECONDARY, tokens.secondary);
    rejected(ui, state, fit, out);
}

fn parameters(ui: &mut Ui, fit: &Fit) {
    let shape = &fit.superquadric;
    section(ui, "Parameters");
    let mm = |metres: f64| format::significant(metres * 1e3);
    let axes = format!("{} × {} × {} mm", mm(shape.a), mm(shape.b), mm(shape.c));
    let tip = "Half of the extents along x, y and z of its own axes; z is the axis of e1.";
    let _row = key_value(ui, "Semi-axes a, b, c", &axes).on_hover_text(tip);
    let exponents = format!("{:.2}, {:.2}", shape.e1, shape.e2);
    let tip = "e1 shapes the profile along z, e2 the section across it: 0.1 is a box, 1 is round, 2 a double wedge.";
    let _row = key_value(ui, "Shape exponents e1, e2", &exponents).on_hover_text(tip);
    let _row = key_value(ui, "Centre", &super::super::scene::at(&shape.X_FS.translation.vector.into()));
    if shape.is_deformed() {
        let tip = "K: sections across z are scaled by 1 + K z/c.";
        let _row = key_value(ui, "Taper K", &format!("{:+.2}", shape.taper)).on_hover_text(tip);
        let tip = "Curvature of its axis in the y–z plane; 1/κ is the radius.";
        let _row = key_value(ui, "Bend κ", &format!("{:+.2} 1/m", shape.bend_per_m)).on_hover_text(tip);
    }
}

/// The parts of a composite object in the colours of the view.
fn parts(ui: &mut Ui, fit: &Fit) {
    let tokens = Tokens::of(ui);
    let palette = Palette::of(if ui.visuals().dark_mode { Theme::Dark } else { Theme::Light });
    section(ui, &format::plural(fit.bodies().count(), "part"));
    for (index, body) in fit.bodies().enumerate() {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 40.0), Sense::hover());
        let [r, g, b, _] = palette.parts[index % palette.parts.len()].map(|c| (255.0 * c).round() as u8);
        let swatch = Rect::from_center_size(pos2(rect.left() + 5.0, rect.top() + 12.0), vec2(10.0, 10.0));
        ui.painter().rect_filled(swatch, 3.0, egui::Color32::from_rgb(r, g, b));
        let line = |n: f32| {
            let top = rect.top() + 2.0 + 18.0 * n;
            Rect::from_min_max(pos2(rect.left() + 20.0, top), pos2(rect.right(), top + 20.0))
        };
        let mm = |metres: f64| format::significant(metres * 1e3);
        let axes = format!("{} × {} × {} mm", mm(body.a), mm(body.b), mm(body.c));
        let _text = text_in(ui, line(0.0), Align::Min, &format!("Part {}", index + 1), font(BODY), tokens.text);
        let _text = text_in(ui, line(0.0), Align::Max, &axes, font(SECONDARY), tokens.secondary);
        let mut words = format!("e1 {:.2}, e2 {:.2}", body.e1, body.e2);
        if body.is_deformed() {
            words += &format!(", K {:+.2}, κ {:+.2} 1/m", body.taper, body.bend_per_m);
        }
        let _text = text_in(ui, line(1.0), Align::Min, &words, font(SECONDARY), tokens.secondary);
        if let Some(part) = index.checked_sub(1).and_then(|index| fit.others.get(index)) {
            let words = format!("{}, E_r {}", format::plural(part.points, "point"), format::length(part.radial_m));
            let _text = text_in(ui, line(1.0), Align::Max, &words, font(SECONDARY), tokens.secondary);
        }
    }
}

/// What was left out and why, with a way to look at it.
fn rejected(ui: &mut Ui, state: &ViewerState, fit: &Fit, out: &mut Out) {
    let tokens = Tokens::of(ui);
    section(ui, "Rejected points");
    let Some(farthest) = fit.rejected.iter().max_by(|l, r| l.distance_m.abs().total_cmp(&r.distance_m.abs())) else {
        let text = if state.document.scene.fit.reject_outliers {
            "None: every point lies near enough to the surface that the others agree on."
        } else {
            "None: rejection is off."
        };
        let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
        return;
    };
    let limit = format::length(farthest.limit_m);
    let text = format!(
        "{} left out of the fit: farther than {limit} from the surface that the others agree on.",
        format::plural(fit.rejected.len(), "point")
    );
    let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
    let side = if farthest.distance_m < 0.0 { "inside" } else { "outside" };
    let far = format!("{} {side}", format::length(farthest.distance_m.abs()));
    let _row = key_value_colored(ui, "Farthest", &far, tokens.coral);
    ui.add_space(4.0);
    let points_out = state.lab.points_out_rejected;
    let words = if points_out { "Back to the whole cluster" } else { "Show them in the view" };
    if secondary_button(ui, words, true).clicked() {
        out.push(Command::Lab(LabCommand::PointOutRejected(!points_out)));
    }
}

/// A note as a sentence: it begins with a capital and ends with a stop.
fn sentence(note: &str) -> String {
    let mut letters = note.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    let stop = if note.ends_with('.') { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}
