//! Widgets that choose among many: tabs, a list that folds out, a field of words.

use egui::{Align2, Popup, Rect, Role, Sense, Stroke, TextEdit, Ui, WidgetInfo, pos2, vec2};

use super::icons::{self, Icon};
use super::theme::{BODY, SECONDARY, SMALL_RADIUS, Tokens, font, strong};
use super::widgets::{elided, focus_ring};

/// Pages side by side on a hairline; gives the one that was clicked.
pub(super) fn tabs(ui: &mut Ui, titles: &[&str], open: Option<usize>) -> Option<usize> {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 32.0), Sense::hover());
    ui.painter().hline(rect.x_range(), rect.bottom() - 0.5, Stroke::new(1.0, tokens.line));
    let width = rect.width() / titles.len().max(1) as f32;
    let mut clicked = None;
    for (index, title) in titles.iter().enumerate() {
        let left = rect.left() + width * index as f32;
        let cell = Rect::from_min_size(pos2(left, rect.top()), vec2(width, rect.height()));
        let response = ui.interact(cell, ui.scope_id().with(("Page", index)), Sense::click());
        let is_open = Some(index) == open;
        response.widget_info(|| WidgetInfo::selected(Role::Tab, true, is_open, format!("{title} page")));
        let id = if is_open { strong(BODY) } else { font(BODY) };
        let color = if is_open || response.hovered() { tokens.text } else { tokens.secondary };
        let galley = ui.painter().layout_no_wrap((*title).to_owned(), id, color);
        ui.painter().galley(cell.center() - 0.5 * galley.size(), galley, color);
        if is_open {
            let line = Rect::from_min_max(pos2(cell.left(), cell.bottom() - 2.0), cell.max);
            ui.painter().rect_filled(line, 1.0, tokens.teal);
        }
        focus_ring(ui, &response, cell.shrink(2.0));
        if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
            clicked = Some(index);
        }
    }
    ui.add_space(6.0);
    clicked
}

/// A button that folds out a list; gives the row that was clicked. `name` is what assistive technology reads before
/// `shown`, what the button says.
pub(super) fn dropdown(
    ui: &mut Ui,
    name: &str,
    shown: &str,
    width: f32,
    rows: &[&str],
    chosen: Option<usize>,
) -> Option<usize> {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(width, 28.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, format!("{name}: {shown}")));
    let lit = response.hovered() || Popup::is_id_open(ui.ctx(), Popup::default_response_id(&response));
    ui.painter().rect_filled(rect, SMALL_RADIUS, if lit { tokens.hover } else { tokens.well });
    let color = if lit { tokens.text } else { tokens.secondary };
    let galley = elided(ui, shown, font(SECONDARY), color, width - 28.0);
    ui.painter().galley(pos2(rect.left() + 8.0, rect.center().y - 0.5 * galley.size().y), galley, color);
    icons::paint(ui.painter(), Icon::Down, pos2(rect.right() - 11.0, rect.center().y), 12.0, color);
    focus_ring(ui, &response, rect);
    let response = response.on_hover_text(name).on_hover_cursor(egui::CursorIcon::PointingHand);
    menu(&response, rows, chosen)
}

/// The list that a click on a widget folds out; gives the row that was clicked.
pub(super) fn menu(response: &egui::Response, rows: &[&str], chosen: Option<usize>) -> Option<usize> {
    let mut clicked = None;
    Popup::menu(response).gap(4.0).width(230.0).show(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        for (index, row) in rows.iter().enumerate() {
            if menu_row(ui, row, chosen == Some(index)) {
                clicked = Some(index);
                ui.close();
            }
        }
    });
    clicked
}

/// A row of a list that folded out; says whether it was clicked.
pub(super) fn menu_row(ui: &mut Ui, text: &str, is_chosen: bool) -> bool {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 30.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::MenuItem, true, text));
    if response.hovered() {
        ui.painter().rect_filled(rect, SMALL_RADIUS, tokens.hover);
    }
    let galley = elided(ui, text, font(BODY), tokens.text, rect.width() - 40.0);
    ui.painter().galley(pos2(rect.left() + 10.0, rect.center().y - 0.5 * galley.size().y), galley, tokens.text);
    if is_chosen {
        icons::paint(ui.painter(), Icon::Check, pos2(rect.right() - 16.0, rect.center().y), 14.0, tokens.teal);
    }
    focus_ring(ui, &response, rect);
    response.clicked()
}

/// A field of words that filters something; gives them when they changed.
pub(super) fn search(ui: &mut Ui, name: &str, hint: &str, words: &str, width: f32) -> Option<String> {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(width, 28.0), Sense::hover());
    ui.painter().rect_filled(rect, SMALL_RADIUS, tokens.well);
    let mut text = words.to_owned();
    let clear = Rect::from_center_size(pos2(rect.right() - 12.0, rect.center().y), vec2(20.0, 22.0));
    let room = if words.is_empty() { 16.0 } else { 30.0 };
    let inside = Rect::from_min_max(rect.min + vec2(8.0, 4.0), rect.max - vec2(room - 8.0, 4.0));
    let field = TextEdit::singleline(&mut text)
        .id(ui.scope_id().with(name))
        .font(font(SECONDARY))
        .text_color(tokens.text)
        .frame(egui::Frame::NONE)
        .margin(egui::Margin::ZERO)
        .align(Align2::LEFT_CENTER)
        .hint_text(egui::RichText::new(hint).font(font(SECONDARY)).color(tokens.secondary))
        .char_limit(60)
        .desired_width(inside.width());
    let response = ui.place(inside, field);
    response
        .widget_info(|| WidgetInfo { label: Some(name.to_owned()), ..WidgetInfo::text_edit(true, words, &text, hint) });
    focus_ring(ui, &response, rect);
    if !words.is_empty() && super::widgets::icon_button_at(ui, clear, Icon::Cross, "Clear the words", true).clicked() {
        return Some(String::new());
    }
    (text != words).then_some(text)
}
