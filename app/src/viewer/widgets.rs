//! The few widgets that the panels are made of.

use egui::text::{LayoutJob, TextFormat, TextWrapping};
use egui::{
    Align, Color32, CornerRadius, FontId, Label, Layout, Rect, Response, RichText, Role, Sense, Stroke, StrokeKind, Ui,
    UiBuilder, Vec2, WidgetInfo, pos2, vec2,
};

use super::icons::{self, Icon};
use super::theme::{BODY, RADIUS, SECONDARY, SMALL, SMALL_RADIUS, Tokens, font, strong};

/// A floating panel: its contents are laid out from top to bottom inside `padding`.
pub(super) fn panel<R>(ui: &mut Ui, name: &str, rect: Rect, padding: Vec2, add: impl FnOnce(&mut Ui) -> R) -> R {
    let tokens = Tokens::of(ui);
    // The panel takes the pointer, so that the view behind it does not turn.
    let _body = ui.interact(rect, ui.scope_id().with(name), Sense::click_and_drag());
    ui.painter().add(tokens.shadow.as_shape(rect, CornerRadius::same(RADIUS)));
    ui.painter().rect(rect, RADIUS, tokens.panel, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    let mut inside = ui
        .new_child(UiBuilder::new().id_salt(name).max_rect(rect.shrink2(padding)).layout(Layout::top_down(Align::Min)));
    inside.shrink_clip_rect(rect);
    add(&mut inside)
}

/// The frame of a window that lies over the page, with so much room inside, points.
pub(super) fn overlay_frame(tokens: &Tokens, margin: i8) -> egui::Frame {
    egui::Frame::new()
        .fill(tokens.overlay)
        .stroke(Stroke::new(1.0, tokens.line))
        .corner_radius(RADIUS + 2)
        .inner_margin(margin)
        .shadow(tokens.shadow)
}

/// A line of text in a rectangle, cut with `…` if it is too long; the whole of it is in the tooltip then.
pub(super) fn text_in(ui: &mut Ui, rect: Rect, align: Align, text: &str, font: FontId, color: Color32) -> Response {
    let layout = match align {
        Align::Min => Layout::left_to_right(Align::Center),
        Align::Center => Layout::centered_and_justified(egui::Direction::LeftToRight),
        Align::Max => Layout::right_to_left(Align::Center),
    };
    let mut inside = ui.new_child(UiBuilder::new().max_rect(rect).layout(layout));
    inside.add(Label::new(RichText::new(text).font(font).color(color)).truncate())
}

/// A paragraph.
pub(super) fn paragraph(ui: &mut Ui, text: &str, size: f32, color: Color32) -> Response {
    ui.add(Label::new(RichText::new(text).font(font(size)).color(color).line_height(Some((size * 1.4).round()))).wrap())
}

/// A small heading.
pub(super) fn section(ui: &mut Ui, text: &str) {
    let tokens = Tokens::of(ui);
    ui.add_space(10.0);
    let title = text.to_uppercase();
    ui.add(Label::new(RichText::new(title).font(strong(SMALL)).color(tokens.secondary).extra_letter_spacing(0.6)));
    ui.add_space(2.0);
}

/// The heading of a panel.
pub(super) fn title(ui: &mut Ui, text: &str) {
    let tokens = Tokens::of(ui);
    ui.add(Label::new(RichText::new(text).font(strong(super::theme::TITLE)).color(tokens.text)).wrap());
}

/// `m_g` and its kin: a letter with a smaller one set low, then more text.
pub(super) fn subscripted(base: &str, low: &str, rest: &str, size: f32, color: Color32) -> LayoutJob {
    let mut job = LayoutJob::default();
    let format = |size: f32| TextFormat { font_id: font(size), color, valign: Align::BOTTOM, ..TextFormat::default() };
    job.append(base, 0.0, format(size));
    job.append(low, 0.5, format((0.72 * size).round()));
    if !rest.is_empty() {
        job.append(rest, 3.0, format(size));
    }
    job
}

/// A row `key … value`; the value may be long, then it wraps below the key's line.
pub(super) fn key_value(ui: &mut Ui, key: &str, value: &str) -> Response {
    let color = Tokens::of(ui).secondary;
    key_value_colored(ui, key, value, color)
}

/// As [`key_value`], the value in a colour of its own.
pub(super) fn key_value_colored(ui: &mut Ui, key: &str, value: &str, color: Color32) -> Response {
    let tokens = Tokens::of(ui);
    let width = ui.available_width();
    let key_galley = ui.painter().layout_no_wrap(key.to_owned(), font(BODY), tokens.text);
    let key_width = key_galley.size().x;
    let value_width = (width - key_width - 16.0).max(0.4 * width);
    let mut job = LayoutJob::simple(value.to_owned(), font(SECONDARY), color, value_width);
    job.halign = Align::Max;
    let value_galley = ui.painter().layout_job(job);
    let height = (value_galley.size().y + 8.0).max(24.0);
    let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::hover());
    let first_line = rect.top() + 4.0;
    ui.painter().galley(pos2(rect.left(), first_line), key_galley, tokens.text);
    ui.painter().galley(pos2(rect.right(), first_line), value_galley, color);
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{key}: {value}")));
    response
}

/// A button that is the thing to do next.
pub(super) fn primary_button(ui: &mut Ui, text: &str, enabled: bool) -> Response {
    let tokens = Tokens::of(ui);
    button(ui, text, enabled, Some(tokens.teal), if enabled { tokens.on_teal } else { tokens.secondary })
}

/// Any other button.
pub(super) fn secondary_button(ui: &mut Ui, text: &str, enabled: bool) -> Response {
    let tokens = Tokens::of(ui);
    button(ui, text, enabled, None, if enabled { tokens.text } else { tokens.secondary })
}

fn button(ui: &mut Ui, text: &str, enabled: bool, fill: Option<Color32>, color: Color32) -> Response {
    let tokens = Tokens::of(ui);
    let id = if fill.is_some() { strong(BODY) } else { font(BODY) };
    let galley = ui.painter().layout_no_wrap(text.to_owned(), id, color);
    let size = vec2(galley.size().x + 28.0, 30.0);
    let (rect, response) = ui.allocate_exact_size(size, if enabled { Sense::click() } else { Sense::hover() });
    response.widget_info(|| WidgetInfo::labeled(Role::Button, enabled, text));
    let lit = enabled && response.hovered();
    let fill = match (fill, enabled) {
        (Some(fill), true) if lit => fill.lerp_to_gamma(tokens.text, 0.12),
        (Some(fill), true) => fill,
        _ if lit => tokens.hover,
        _ => Color32::TRANSPARENT,
    };
    let stroke = if fill == Color32::TRANSPARENT || lit { tokens.line } else { fill };
    ui.painter().rect(rect, SMALL_RADIUS, fill, Stroke::new(1.0, stroke), StrokeKind::Inside);
    ui.painter().galley(rect.center() - 0.5 * galley.size(), galley, color);
    focus_ring(ui, &response, rect);
    if enabled { response.on_hover_cursor(egui::CursorIcon::PointingHand) } else { response }
}

/// A square button with an icon; `name` is its tooltip and what assistive technology reads.
pub(super) fn icon_button(ui: &mut Ui, icon: Icon, name: &str, enabled: bool, lit: bool) -> Response {
    let (rect, response) =
        ui.allocate_exact_size(Vec2::splat(28.0), if enabled { Sense::click() } else { Sense::hover() });
    icon_face(ui, rect, &response, icon, name, enabled, lit);
    response.on_hover_text(name)
}

/// As [`icon_button`], at a place.
pub(super) fn icon_button_at(ui: &mut Ui, rect: Rect, icon: Icon, name: &str, enabled: bool) -> Response {
    let sense = if enabled { Sense::click() } else { Sense::hover() };
    let response = ui.interact(rect, ui.scope_id().with(name), sense);
    icon_face(ui, rect, &response, icon, name, enabled, false);
    response.on_hover_text(name)
}

fn icon_face(ui: &Ui, rect: Rect, response: &Response, icon: Icon, name: &str, enabled: bool, lit: bool) {
    let tokens = Tokens::of(ui);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, enabled, name));
    let hovered = enabled && response.hovered();
    if hovered || lit {
        ui.painter().rect_filled(rect, SMALL_RADIUS, tokens.hover);
    }
    let color = match (enabled, hovered, lit) {
        (false, _, _) => tokens.faint.gamma_multiply(0.7),
        (true, _, true) => tokens.teal,
        (true, true, _) => tokens.text,
        (true, false, false) => tokens.secondary,
    };
    icons::paint(ui.painter(), icon, rect.center(), 16.0_f32.min(0.62 * rect.height()), color);
    focus_ring(ui, response, rect);
}

/// A few words side by side, one of them chosen; gives the index of the one that was clicked.
pub(super) fn segmented(ui: &mut Ui, name: &str, words: &[&str], chosen: Option<usize>) -> Option<usize> {
    let tokens = Tokens::of(ui);
    let galleys: Vec<_> =
        words.iter().map(|word| ui.painter().layout_no_wrap((*word).to_owned(), font(BODY), tokens.text)).collect();
    let widths: Vec<f32> = galleys.iter().map(|galley| galley.size().x + 24.0).collect();
    let (rect, _) = ui.allocate_exact_size(vec2(widths.iter().sum::<f32>() + 4.0, 30.0), Sense::hover());
    ui.painter().rect_filled(rect, SMALL_RADIUS + 1, tokens.well);
    let mut left = rect.left() + 2.0;
    let mut clicked = None;
    for (index, (word, (galley, width))) in words.iter().zip(galleys.into_iter().zip(widths)).enumerate() {
        let cell = Rect::from_min_size(pos2(left, rect.top() + 2.0), vec2(width, rect.height() - 4.0));
        left += width;
        if segment(ui, (name, index), cell, word, galley, chosen == Some(index)) {
            clicked = Some(index);
        }
    }
    clicked
}

/// As [`segmented`] over the whole width; the words share it by their length.
pub(super) fn segmented_wide(ui: &mut Ui, name: &str, words: &[&str], chosen: Option<usize>) -> Option<usize> {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 30.0), Sense::hover());
    ui.painter().rect_filled(rect, SMALL_RADIUS + 1, tokens.well);
    let galleys: Vec<_> =
        words.iter().map(|word| ui.painter().layout_no_wrap((*word).to_owned(), font(BODY), tokens.text)).collect();
    let taken: f32 = galleys.iter().map(|galley| galley.size().x).sum();
    let padding = (rect.width() - 4.0 - taken) / words.len().max(1) as f32;
    let mut left = rect.left() + 2.0;
    let mut clicked = None;
    for (index, (word, galley)) in words.iter().zip(galleys).enumerate() {
        let width = galley.size().x + padding;
        let cell = Rect::from_min_size(pos2(left, rect.top() + 2.0), vec2(width, rect.height() - 4.0));
        left += width;
        if segment(ui, (name, index), cell, word, galley, chosen == Some(index)) {
            clicked = Some(index);
        }
    }
    clicked
}

/// One word of a segmented control; says whether it was clicked.
fn segment(
    ui: &Ui,
    id: (&str, usize),
    cell: Rect,
    word: &str,
    galley: std::sync::Arc<egui::Galley>,
    is_chosen: bool,
) -> bool {
    let tokens = Tokens::of(ui);
    let response = ui.interact(cell, ui.scope_id().with(id), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_chosen, word));
    if is_chosen {
        let fill = if ui.visuals().dark_mode { tokens.view_edge } else { tokens.overlay };
        ui.painter().rect(cell, SMALL_RADIUS - 1, fill, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    }
    let color = if is_chosen || response.hovered() { tokens.text } else { tokens.secondary };
    ui.painter().galley_with_override_text_color(cell.center() - 0.5 * galley.size(), galley, color);
    focus_ring(ui, &response, cell);
    response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked()
}

/// A row with a switch at its end; says whether it was turned.
pub(super) fn switch(ui: &mut Ui, text: &str, is_on: bool) -> bool {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 28.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Switch, true, is_on, text));
    let line = Rect::from_min_max(rect.min, rect.max - vec2(44.0, 0.0));
    let _text = text_in(ui, line, Align::Min, text, font(BODY), tokens.text);
    let track = Rect::from_center_size(pos2(rect.right() - 16.0, rect.center().y), vec2(30.0, 17.0));
    let fill = if is_on { tokens.teal } else { tokens.well };
    let line = if is_on { tokens.teal } else { tokens.faint };
    ui.painter().rect(track, 8.5, fill, Stroke::new(1.0, line), StrokeKind::Inside);
    let x = if is_on { track.right() - 8.5 } else { track.left() + 8.5 };
    let knob = if is_on { tokens.on_teal } else { tokens.secondary };
    ui.painter().circle_filled(pos2(x, track.center().y), 5.5, knob);
    focus_ring(ui, &response, rect.expand(2.0));
    response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked()
}

/// A thin hairline over the whole width.
pub(super) fn hairline(ui: &mut Ui) {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 9.0), Sense::hover());
    ui.painter().hline(rect.x_range(), rect.center().y, Stroke::new(1.0, tokens.line));
}

/// Shows where the keyboard is.
pub(super) fn focus_ring(ui: &Ui, response: &Response, rect: Rect) {
    if response.has_focus() {
        let tokens = Tokens::of(ui);
        ui.painter().rect_stroke(rect, SMALL_RADIUS, Stroke::new(1.5, tokens.teal), StrokeKind::Inside);
    }
}

/// A single line of text cut to a width.
pub(super) fn elided(ui: &Ui, text: &str, id: FontId, color: Color32, width: f32) -> std::sync::Arc<egui::Galley> {
    let mut job = LayoutJob::simple_singleline(text.to_owned(), id, color);
    job.wrap = TextWrapping { max_width: width, max_rows: 1, break_anywhere: true, ..TextWrapping::default() };
    ui.painter().layout_job(job)
}
