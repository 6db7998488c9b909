//! The tour's card, with a frame about what it speaks of and a line between the two.

use egui::{Area, Id, Order, Pos2, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};

use super::Out;
use crate::viewer::icons::Icon;
use crate::viewer::layout::Layout;
use crate::viewer::theme::{BODY, MARGIN, RADIUS, SECONDARY, TITLE, Tokens, font, strong};
use crate::viewer::tour::{STAYS_S, Stop, Target};
use crate::viewer::widgets::{focus_ring, icon_button, paragraph, primary_button, secondary_button};
use crate::viewer::{Command, Overlay, TourCommand, ViewerState};

const WIDTH: f32 = 348.0;
/// Height that is left for the card, points.
const HEIGHT: f32 = 190.0;
/// Diameter of a stop's dot, points.
const DOT: f32 = 8.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, layout: &Layout, out: &mut Out) {
    let Some((tour, stop)) = state.tour.and_then(|tour| Some((tour, *Stop::ALL.get(tour.stop)?))) else { return };
    if state.overlay != Overlay::None {
        return;
    }
    let tokens = Tokens::of(ui);
    let target = target(stop, layout);
    let width = WIDTH.min(layout.window.width() - 2.0 * MARGIN);
    let at = place(stop, layout, target, width);
    let painter = ui.ctx().layer_painter(egui::LayerId::new(Order::Middle, Id::unique("Tour frame")));
    for (grown, opacity) in [(5.0, 0.25), (2.0, 1.0)] {
        let stroke = Stroke::new(if grown > 3.0 { 5.0 } else { 2.0 }, tokens.teal.gamma_multiply(opacity));
        painter.rect_stroke(target.expand(grown), RADIUS + grown as u8, stroke, StrokeKind::Outside);
    }
    let shown = Area::new(Id::unique("Tour")).order(Order::Foreground).fixed_pos(at).show(ui.ctx(), |ui| {
        let frame = egui::Frame::new()
            .fill(tokens.overlay)
            .stroke(Stroke::new(1.0, tokens.teal))
            .corner_radius(RADIUS + 2)
            .inner_margin(16)
            .shadow(tokens.shadow);
        frame.show(ui, |ui| {
            ui.set_width(width - 34.0);
            ui.spacing_mut().item_spacing.y = 6.0;
            ui.horizontal(|ui| {
                let title = egui::RichText::new(stop.title()).font(strong(TITLE)).color(tokens.text);
                ui.label(title);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if icon_button(ui, Icon::Cross, "End the tour (Esc)", true, false).clicked() {
                        out.push(Command::Tour(TourCommand::End));
                    }
                });
            });
            let _text = paragraph(ui, &stop.words(state), BODY, tokens.text);
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                dots(ui, tour.stop, (tour.shown_s / STAYS_S) as f32, out);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.spacing_mut().item_spacing.x = 8.0;
                    let is_last = tour.stop + 1 == Stop::ALL.len();
                    if primary_button(ui, if is_last { "Done" } else { "Next" }, true).clicked() {
                        out.push(Command::Tour(TourCommand::To(tour.stop + 1)));
                    }
                    if tour.stop > 0 && secondary_button(ui, "Back", true).clicked() {
                        out.push(Command::Tour(TourCommand::To(tour.stop - 1)));
                    }
                });
            });
            let said = format!("Stop {} of {}", tour.stop + 1, Stop::ALL.len());
            ui.label(egui::RichText::new(said).font(font(SECONDARY)).color(tokens.secondary));
        });
    });
    let card = shown.response.rect;
    let (from, to) = (nearest(card, target.center()), nearest(target, card.center()));
    painter.line_segment([from, to], Stroke::new(1.5, tokens.teal));
    painter.circle_filled(to, 3.5, tokens.teal);
    let reads = ui.input(|input| input.pointer.hover_pos()).is_some_and(|pointer| card.contains(pointer));
    if reads != tour.is_held {
        out.push(Command::Tour(TourCommand::Hold(reads)));
    }
}

/// The stops as dots; the present one is a bar that fills up.
fn dots(ui: &mut Ui, stop: usize, share: f32, out: &mut Out) {
    let tokens = Tokens::of(ui);
    ui.spacing_mut().item_spacing.x = 6.0;
    for index in 0..Stop::ALL.len() {
        let is_here = index == stop;
        let width = if is_here { 26.0 } else { DOT };
        let (rect, response) = ui.allocate_exact_size(vec2(width, 24.0), Sense::click());
        response.widget_info(|| {
            WidgetInfo::selected(Role::Tab, true, is_here, format!("Tour: {}", Stop::ALL[index].title()))
        });
        let bar = Rect::from_center_size(rect.center(), vec2(width, DOT));
        let fill = if index < stop { tokens.teal } else { tokens.well };
        ui.painter().rect(bar, DOT / 2.0, fill, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
        if is_here {
            let filled = bar.with_max_x(bar.left() + width * share.max(0.3).min(1.0));
            ui.painter().rect_filled(filled, DOT / 2.0, tokens.teal);
        }
        focus_ring(ui, &response, rect);
        if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
            out.push(Command::Tour(TourCommand::To(index)));
        }
    }
}

/// What a stop speaks of.
fn target(stop: Stop, layout: &Layout) -> Rect {
    let view = Rect::from_center_size(layout.free.center(), 0.62 * layout.free.size());
    match stop.target() {
        Target::View => view,
        Target::Left => layout.left.unwrap_or(view),
        Target::Right => layout.right.unwrap_or(view),
        Target::Timeline => layout.timeline,
    }
}

/// Where the card stands: beside what it speaks of, inside the window.
fn place(stop: Stop, layout: &Layout, target: Rect, width: f32) -> Pos2 {
    let free = layout.free;
    let gap = 3.0 * MARGIN;
    let wanted = match stop.target() {
        Target::View => pos2(free.center().x - 0.5 * width, free.bottom() - HEIGHT - MARGIN),
        Target::Left => pos2(target.right() + gap, target.center().y - 0.5 * HEIGHT),
        Target::Right => pos2(target.left() - gap - width, target.center().y - 0.5 * HEIGHT),
        Target::Timeline => pos2(free.center().x - 0.5 * width, target.top() - gap - HEIGHT),
    };
    let inner = layout.window.shrink(MARGIN);
    let clipped = |value: f32, low: f32, high: f32| value.min(high).max(low);
    let x = clipped(wanted.x, inner.left(), inner.right() - width);
    // Over a drawer that fills a phone the card stands at the foot.
    let covers = Rect::from_min_size(pos2(x, wanted.y), vec2(width, HEIGHT)).intersects(target);
    let y = if covers && stop.target() != Target::View { inner.bottom() - HEIGHT } else { wanted.y };
    pos2(x, clipped(y, inner.top(), inner.bottom() - HEIGHT))
}

/// The point of a rectangle that is nearest to another one's middle.
fn nearest(rect: Rect, to: Pos2) -> Pos2 {
    rect.clamp(to)
}
