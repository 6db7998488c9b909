//! Routes of the hand: how long, how clear, how fast, and which one is taken.

use egui::{Align, Color32, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::task::{Plan, Planner, Route};

use crate::compose::Palette;
use crate::export::TableKind;
use crate::render::Theme;
use crate::viewer::icons::{self, Icon};
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::{focus_ring, paragraph, secondary_button, text_in};
use crate::viewer::{Command, PlanCommand, ViewerState, format};

const ROW: f32 = 46.0;
/// How far a row reaches into the panel's margin, points.
const OUTSIDE: f32 = 13.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, plan: &Plan, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let motion = &state.document.scene.motion;
    if plan.routes.is_empty() {
        let text = if motion.planner == Planner::Routes {
            "This plan needed no routes."
        } else {
            "The planner Routes looks for clearly different ways of the hand round what stands there; this plan came \
             from another planner."
        };
        let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
        ui.add_space(8.0);
        if motion.planner != Planner::Routes && secondary_button(ui, "Look for routes", true).clicked() {
            out.push(Command::Planning(PlanCommand::ChooseRoute(None)));
        }
        return;
    }
    saved_section(ui, "Routes of the hand", TableKind::Routes, None, out);
    let text = "Point at a route to see it, click to take it. The arm cannot follow the dashed ones.";
    let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
    ui.add_space(4.0);
    for (index, route) in plan.routes.iter().enumerate() {
        row(ui, index, route, out);
    }
    ui.add_space(8.0);
    if motion.route.is_some() && secondary_button(ui, "Take the first that works", true).clicked() {
        out.push(Command::Planning(PlanCommand::ChooseRoute(None)));
    }
}

fn row(ui: &mut Ui, index: usize, route: &Route, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let full = rect.expand2(vec2(OUTSIDE, 0.0));
    if route.chosen {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let theme = if ui.visuals().dark_mode { Theme::Dark } else { Theme::Light };
    let [r, g, b, _] = Palette::of(theme).route(index).map(|c| (255.0 * c).round() as u8);
    let upper =
        Rect::from_min_max(pos2(rect.left() + 26.0, rect.top() + 4.0), pos2(rect.right() - 22.0, rect.center().y));
    let lower = Rect::from_min_max(pos2(upper.left(), rect.center().y), pos2(rect.right(), rect.bottom() - 4.0));
    // The mark is the line as it is drawn in the view.
    let (y, stroke) =
        (upper.center().y, egui::Stroke::new(if route.chosen { 4.0 } else { 2.0 }, Color32::from_rgb(r, g, b)));
    let ends = [pos2(rect.left(), y), pos2(rect.left() + 18.0, y)];
    if route.refused.is_some() {
        ui.painter().extend(egui::Shape::dashed_line(&ends, stroke, 4.0, 3.0));
    } else {
        ui.painter().line_segment(ends, stroke);
    }
    let id = if route.chosen { strong(BODY) } else { font(BODY) };
    let _text = text_in(ui, upper, Align::Min, &format!("Route {}", index + 1), id, tokens.text);
    if route.chosen {
        icons::paint(ui.painter(), Icon::Check, pos2(rect.right() - 9.0, y), 14.0, tokens.teal);
    }
    let numbers = numbers(route);
    let (text, ink) = match &route.refused {
        Some(reason) => (reason.as_str(), tokens.coral),
        None => (numbers.as_str(), tokens.secondary),
    };
    let _text = text_in(ui, lower, Align::Min, text, font(SECONDARY), ink);
    if route.refused.is_some() {
        let _text = text_in(ui, upper, Align::Max, &numbers, font(SECONDARY), tokens.secondary);
    }
    focus_ring(ui, &response, full);
    response.widget_info(|| {
        let refused = route.refused.as_ref().map_or_else(String::new, |reason| format!(", {reason}"));
        let text = format!("Route {}: {numbers}{refused}", index + 1);
        WidgetInfo::selected(Role::RadioButton, true, route.chosen, text)
    });
    if response.hovered() || response.has_focus() {
        out.route = Some(index);
    }
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        out.push(Command::Planning(PlanCommand::ChooseRoute(Some(index))));
    }
}

/// `1.24 m long · clear by 32 mm · 3.90 s`
fn numbers(route: &Route) -> String {
    let mut text = format!("{} long", format::length(route.length_m));
    if route.clearance_m.is_finite() {
        text += &format!(" · clear by {}", format::millimetres(route.clearance_m));
    }
    if let Some(duration_s) = route.duration_s {
        text += &format!(" · {}", format::clock(duration_s));
    }
    text
}
