//! The handover: who gives and takes, the place, what it costs a receiver, and the places that were not taken.

use egui::text::LayoutJob;
use egui::{Align, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::handover::{Comfort, HandoverReport, Place};

use super::receiver;
use crate::export::TableKind;
use crate::viewer::handing::Partner;
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::panels::scene::at;
use crate::viewer::theme::{BODY, SECONDARY, SMALL, Tokens, font, strong};
use crate::viewer::widgets::{focus_ring, key_value, paragraph, section, text_in};
use crate::viewer::{Command, HandoverCommand, ViewerState, format};

const ROW: f32 = 26.0;
/// How far a row reaches into the panel's margin, points.
const OUTSIDE: f32 = 13.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let (Some(handover), Some(partners)) = (&state.document.scene.handover, state.partners()) else { return };
    if let Some(report) = state.handover_report() {
        who(ui, &partners, report);
        let shown = state.shown_place().unwrap_or(report.chosen);
        if let Some(place) = report.places.get(shown) {
            about(ui, &partners, place, shown, shown == report.chosen);
        }
        list(ui, state, report, &partners, out);
    }
    receiver::draw(ui, handover, out);
}

fn who(ui: &mut Ui, partners: &[Partner; 2], report: &HandoverReport) {
    for ((deed, partner), (arm, grasps)) in
        ["Gives", "Takes"].into_iter().zip(partners).zip(report.arms.iter().zip(report.grasps))
    {
        // The receiver's arms bear its name before their own.
        let arm = arm.rsplit('_').next().unwrap_or(arm);
        let who = if partner.title.to_lowercase().starts_with(arm) {
            partner.title.clone()
        } else {
            format!("{}, {arm} arm", partner.title)
        };
        let _row = key_value(ui, deed, &format!("{who} · {}", format::plural(grasps, "grasp")));
    }
}

/// One place in numbers.
fn about(ui: &mut Ui, partners: &[Partner; 2], place: &Place, index: usize, is_chosen: bool) {
    let tokens = Tokens::of(ui);
    let which = if is_chosen { "the one that is used" } else { "not used" };
    section(ui, &format!("Place {}, {which}", index + 1));
    let _row = key_value(ui, "Where", &at(&place.X_WO.translation.vector.into()));
    for (partner, m_g) in partners.iter().zip(place.m_g) {
        let _row = key_value(ui, &format!("Manipulability, {}", partner.words), &format::manipulability(m_g));
    }
    let _row = key_value(ui, "Off the line of the shoulders", &degrees(place.off_line_rad));
    let _row = key_value(ui, "Off the straight way", &format::length(place.off_way_m));
    if place.by_handle {
        let _row = key_value(ui, "Presented", "handle first");
    }
    if let Some(reason) = &place.refused {
        let _text = paragraph(ui, reason, SECONDARY, tokens.coral);
    }
    if let Some(comfort) = &place.comfort {
        bars(ui, comfort);
    }
}

/// What the posture costs the receiver, term by term: a bar from comfortable to the limit.
fn bars(ui: &mut Ui, comfort: &Comfort) {
    let tokens = Tokens::of(ui);
    section(ui, "What it costs the receiver");
    let terms = comfort.terms();
    for (name, cost, share) in terms {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 20.0), Sense::hover());
        let label = rect.with_max_x(rect.left() + 76.0);
        let _text = text_in(ui, label, Align::Min, &format::title_of(name), font(BODY), tokens.text);
        let track = Rect::from_min_max(
            pos2(label.right() + 4.0, rect.center().y - 4.0),
            pos2(rect.right() - 104.0, rect.center().y + 4.0),
        );
        ui.painter().rect_filled(track, 4.0, tokens.well);
        let width = track.width() * cost.max(0.0).min(1.0) as f32;
        if width > 0.5 {
            let ink = tokens.teal.lerp_to_gamma(tokens.coral, cost as f32);
            ui.painter().rect_filled(track.with_max_x(track.left() + width.max(4.0)), 4.0, ink);
        }
        let text = rect.with_min_x(track.right() + 8.0);
        let said = format!("{cost:.2} × {:.0} %", 100.0 * share);
        let _text = text_in(ui, text, Align::Max, &said, font(SECONDARY), tokens.secondary);
        response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{name} costs {said}")));
        let _tip = response.on_hover_text("0 is comfortable, 1 is at the limit; then its share of the whole");
    }
    let _row = key_value(ui, "Together", &format!("{:.2}", comfort.total));
}

/// All places, best first.
fn list(ui: &mut Ui, state: &ViewerState, report: &HandoverReport, partners: &[Partner; 2], out: &mut Out) {
    let tokens = Tokens::of(ui);
    saved_section(ui, &format!("Places · {}", report.places.len()), TableKind::Places, None, out);
    let voxels = format::count(report.voxels);
    let edge_mm = format::millimetres(report.voxel_m);
    let text = format!("Both reach {voxels} voxels of {edge_mm} well enough. Point at a place to see it.");
    let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
    ui.add_space(2.0);
    let has_comfort = report.places.iter().any(|place| place.comfort.is_some());
    let columns = columns(partners, has_comfort);
    let heads: Vec<&str> = columns.iter().map(|(head, _)| head.as_str()).collect();
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 18.0), Sense::hover());
    cells(ui, rect, &heads, true);
    for (index, place) in report.places.iter().enumerate() {
        row(ui, state, report, index, place, &columns, out);
    }
}

type Column = (String, fn(&Place) -> String);

fn columns(partners: &[Partner; 2], has_comfort: bool) -> Vec<Column> {
    let short = |partner: &Partner| partner.title.split(' ').next().unwrap_or_default().to_owned();
    let mut columns: Vec<Column> = vec![
        ("score".to_owned(), |place| format!("{:.2}", place.score)),
        (short(&partners[0]), |place| format::manipulability(place.m_g[0])),
        (short(&partners[1]), |place| format::manipulability(place.m_g[1])),
        ("off line".to_owned(), |place| degrees(place.off_line_rad)),
    ];
    if has_comfort {
        columns.push(("cost".to_owned(), |place| {
            place.comfort.map_or("–".to_owned(), |comfort| format!("{:.2}", comfort.total))
        }));
    }
    columns
}

/// Words side by side, right-aligned, after room for a number.
fn cells(ui: &mut Ui, rect: Rect, words: &[&str], is_head: bool) {
    let tokens = Tokens::of(ui);
    let left = rect.left() + 40.0;
    let width = (rect.right() - left) / words.len().max(1) as f32;
    for (place, word) in words.iter().enumerate() {
        let x = left + width * place as f32;
        let cell = Rect::from_min_max(pos2(x, rect.top()), pos2(x + width, rect.bottom()));
        let id = if is_head { font(SMALL) } else { font(SECONDARY) };
        let ink = if is_head { tokens.secondary } else { tokens.text };
        let _text = text_in(ui, cell, Align::Max, word, id, ink);
    }
}

fn row(
    ui: &mut Ui,
    state: &ViewerState,
    report: &HandoverReport,
    index: usize,
    place: &Place,
    columns: &[Column],
    out: &mut Out,
) {
    let tokens = Tokens::of(ui);
    let is_selected = state.planning.selected_place == Some(index);
    let is_chosen = report.chosen == index;
    let width = ui.available_width();
    let reason = place.refused.as_ref().map(|reason| {
        let ink = if is_selected { tokens.text } else { tokens.coral };
        ui.painter().layout_job(LayoutJob::simple(reason.clone(), font(SECONDARY), ink, width - 16.0))
    });
    let below = reason.as_ref().map_or(0.0, |reason| reason.size().y + 4.0);
    let (rect, response) = ui.allocate_exact_size(vec2(width, ROW + below), Sense::click());
    let full = rect.expand2(vec2(OUTSIDE, 0.0));
    if is_selected {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() || state.planning.hovered_place == Some(index) {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let line = rect.with_max_y(rect.top() + ROW);
    let (id, ink) = if is_chosen { (strong(BODY), tokens.teal_text) } else { (font(BODY), tokens.secondary) };
    let number = Rect::from_min_max(line.min, pos2(line.left() + 24.0, line.bottom()));
    let _number = text_in(ui, number, Align::Min, &(index + 1).to_string(), id, ink);
    if is_chosen {
        ui.painter().circle_filled(pos2(line.left() + 30.0, line.center().y), 3.5, tokens.teal);
    }
    let words: Vec<String> = columns.iter().map(|(_, value)| value(place)).collect();
    cells(ui, line, &words.iter().map(String::as_str).collect::<Vec<_>>(), false);
    if let Some(reason) = reason {
        ui.painter().galley(pos2(rect.left() + 16.0, line.bottom() - 2.0), reason, tokens.coral);
    }
    focus_ring(ui, &response, full);
    response.widget_info(|| {
        let told: Vec<String> =
            columns.iter().zip(&words).map(|((head, _), value)| format!("{head} {value}")).collect();
        let fate = match &place.refused {
            _ if is_chosen => "used".to_owned(),
            Some(reason) => format!("refused: {reason}"),
            None => "not tried".to_owned(),
        };
        let text = format!("Place {}: {}, {fate}", index + 1, told.join(", "));
        WidgetInfo::selected(Role::Button, true, is_selected, text)
    });
    if response.hovered() || response.has_focus() {
        out.place = Some(index);
    }
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        out.push(Command::Handover(HandoverCommand::ShowPlace((!is_selected).then_some(index))));
    }
}

fn degrees(angle_rad: f64) -> String {
    format!("{:.0}°", angle_rad.to_degrees())
}
