//! The demos as cards: the first thing that a newcomer sees.

use egui::{
    Align, Color32, ColorImage, Id, Modal, Rect, Role, Sense, Shape, Stroke, StrokeKind, TextureHandle, Ui, WidgetInfo,
    pos2, vec2,
};

use super::Out;
use crate::viewer::handing::everybody;
use crate::viewer::icons::Icon;
use crate::viewer::theme::{BODY, RADIUS, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::{
    focus_ring, icon_button, overlay_frame, paragraph, primary_button, secondary_button, text_in,
};
use crate::viewer::{Command, Demo, Offer, Overlay, TourCommand, ViewerState, format};

const GAP: f32 = 16.0;
/// Height of a heading with the gap below it, points.
const HEADING: f32 = 38.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let window = ui.max_rect();
    let columns = match window.width() {
        width if width >= 1000.0 => 3,
        width if width >= 640.0 => 2,
        _ => 1,
    };
    let width = (window.width() - 96.0).min(316.0 * columns as f32 + GAP * (columns - 1) as f32);
    let card = vec2((width - GAP * (columns - 1) as f32) / columns as f32, 0.0);
    let frame = overlay_frame(tokens, 24);
    let modal = Modal::new(Id::unique("Gallery")).frame(frame).backdrop_color(tokens.scrim).show(ui.ctx(), |ui| {
        ui.set_width(width);
        ui.horizontal(|ui| {
            ui.vertical(|ui| {
                ui.label(egui::RichText::new("From a depth cloud to a comfortable grasp").font(strong(20.0)));
                let text = "Pick a demo, or drop a cloud, a depth image, a mesh, a robot, a scene or a saved session anywhere.";
                let _text = paragraph(ui, text, BODY, tokens.secondary);
            });
            ui.with_layout(egui::Layout::right_to_left(Align::Min), |ui| {
                if icon_button(ui, Icon::Cross, "Close (Esc)", true, false).clicked() {
                    ui.close();
                }
            });
        });
        let most = (window.height() - 250.0).max(180.0);
        let (handovers, alone): (Vec<&Demo>, Vec<&Demo>) =
            state.demos.iter().partition(|demo| demo.scene.handover.is_some());
        let groups = [("One robot at work", alone), ("From hand to hand", handovers)];
        let groups: Vec<_> = groups.into_iter().filter(|(_, demos)| !demos.is_empty()).collect();
        ui.add_space(12.0);
        let mut jump = None;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = vec2(10.0, 8.0);
            if primary_button(ui, "Take the 30-second tour", true).clicked() {
                out.push(Command::Tour(TourCommand::Start));
            }
            if groups.len() > 1 {
                for (index, (title, demos)) in groups.iter().enumerate() {
                    if secondary_button(ui, &format!("{title} · {}", demos.len()), true).clicked() {
                        jump = Some(index);
                    }
                }
            }
            if let Some(offer) = &state.offer {
                restore(ui, offer, out);
            }
        });
        ui.add_space(12.0);
        // One group needs no heading.
        let heading = if groups.len() > 1 { HEADING } else { 0.0 };
        let rows: usize = groups.iter().map(|(_, demos)| demos.len().div_ceil(columns)).sum();
        let wanted = rows as f32 * (card_height(card.x) + GAP) - GAP + heading * groups.len() as f32;
        let wanted = wanted.min(most);
        egui::ScrollArea::vertical().max_height(most).min_scrolled_height(wanted).auto_shrink([false, true]).show(
            ui,
            |ui| {
                ui.spacing_mut().item_spacing.y = GAP;
                for (index, (title, demos)) in groups.iter().enumerate() {
                    if heading > 0.0 {
                        let (rect, _) = ui.allocate_exact_size(vec2(width, HEADING - GAP), Sense::hover());
                        let _text = text_in(ui, rect, Align::Min, title, strong(BODY + 1.0), tokens.secondary);
                        if jump == Some(index) {
                            ui.scroll_to_rect(rect, Some(Align::TOP));
                        }
                    }
                    for row in demos.chunks(columns) {
                        ui.horizontal_top(|ui| {
                            ui.spacing_mut().item_spacing.x = GAP;
                            for demo in row {
                                if show_card(ui, state, demo, card.x) {
                                    out.push(Command::OpenDemo(demo.name.clone()));
                                }
                            }
                        });
                    }
                }
            },
        );
    });
    if modal.should_close() {
        out.push(Command::Show(Overlay::None));
    }
}

/// What was open at the last visit.
fn restore(ui: &mut Ui, offer: &Offer, out: &mut Out) {
    if secondary_button(ui, "Restore what you had open", true).clicked() {
        out.push(Command::Restore);
    }
    let text = format!("{}, {}", offer.title, offer.when());
    ui.label(egui::RichText::new(text).font(font(BODY)).color(Tokens::of(ui).secondary));
}

fn picture_height(card_width: f32) -> f32 {
    (0.6 * card_width).round()
}

/// Picture, title, three lines, foot.
fn card_height(width: f32) -> f32 {
    picture_height(width) + 126.0
}

fn show_card(ui: &mut Ui, state: &ViewerState, demo: &Demo, width: f32) -> bool {
    let tokens = Tokens::of(ui);
    let picture_height = picture_height(width);
    let text_width = width - 28.0;
    let summary = {
        let mut job =
            egui::text::LayoutJob::simple(demo.scene.summary.clone(), font(SECONDARY), tokens.secondary, text_width);
        job.wrap.max_rows = 3;
        ui.painter().layout_job(job)
    };
    let height = card_height(width);
    let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Open {}", demo.scene.title)));
    let lit = response.hovered();
    let stroke = Stroke::new(if lit { 1.5 } else { 1.0 }, if lit { tokens.teal } else { tokens.line });
    ui.painter().rect_filled(rect, RADIUS, if lit { tokens.hover } else { tokens.overlay });
    let picture = Rect::from_min_size(rect.min, vec2(width, picture_height));
    match thumbnail(ui, demo) {
        Some(texture) => paint_thumbnail(ui, &texture, picture),
        None if demo.scene.handover.is_some() => passing(ui, demo, picture),
        None => drawing(ui, demo, picture),
    }
    ui.painter().rect_stroke(rect, RADIUS, stroke, StrokeKind::Inside);
    let mut y = picture.bottom() + 12.0;
    let line = Rect::from_min_size(pos2(rect.left() + 14.0, y), vec2(text_width, 20.0));
    let _text = text_in(ui, line, Align::Min, &demo.scene.title, strong(BODY + 0.5), tokens.text);
    y += 24.0;
    ui.painter().galley(pos2(rect.left() + 14.0, y), summary, tokens.secondary);
    let robot = state.robots.iter().find(|robot| robot.name == demo.scene.robot);
    let robot = robot.map_or_else(|| format::title_of(&demo.scene.robot), |robot| robot.title.clone());
    let foot = Rect::from_min_size(pos2(rect.left() + 14.0, rect.bottom() - 30.0), vec2(text_width, 20.0));
    let everybody = everybody(&demo.scene, robot);
    let _text = text_in(ui, foot, Align::Min, &everybody, font(SECONDARY), tokens.teal_text);
    if state.demo.as_deref() == Some(&demo.name) {
        let _text = text_in(ui, foot, Align::Max, "running behind this", font(SECONDARY), tokens.secondary);
    }
    focus_ring(ui, &response, rect);
    response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked()
}

/// The texture of a demo's picture, decoded once.
fn thumbnail(ui: &Ui, demo: &Demo) -> Option<TextureHandle> {
    let id = Id::unique(("thumbnail", &demo.name));
    if let Some(texture) = ui.data(|data| data.get_temp::<TextureHandle>(id)) {
        return Some(texture);
    }
    let picture = image::load_from_memory(demo.thumbnail.as_deref()?).ok()?.to_rgba8();
    let size = [picture.width() as usize, picture.height() as usize];
    let image = ColorImage::from_rgba_unmultiplied(size, picture.as_raw());
    let texture = ui.ctx().load_texture(&demo.name, image, egui::TextureOptions::LINEAR);
    ui.data_mut(|data| data.insert_temp(id, texture.clone()));
    Some(texture)
}

/// Fills the upper part of a card; what does not fit its proportions is cut off evenly.
fn paint_thumbnail(ui: &Ui, texture: &TextureHandle, rect: Rect) {
    let size = texture.size_vec2();
    let scale = (rect.width() / size.x.max(1.0)).max(rect.height() / size.y.max(1.0));
    let shown = rect.size() / (size * scale);
    let uv = Rect::from_center_size(pos2(0.5, 0.5), shown);
    let radius = egui::CornerRadius { nw: RADIUS, ne: RADIUS, sw: 0, se: 0 };
    ui.painter().add(egui::epaint::RectShape::filled(rect, radius, Color32::WHITE).with_texture(texture.id(), uv));
}

/// A drawing of a table, an arm and an object in place of a picture.
fn drawing(ui: &Ui, demo: &Demo, rect: Rect) {
    let tokens = Tokens::of(ui);
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let radius = egui::CornerRadius { nw: RADIUS, ne: RADIUS, sw: 0, se: 0 };
    painter.rect_filled(rect, radius, tokens.view_centre.lerp_to_gamma(tokens.view_edge, 0.5));
    let at = |x: f32, y: f32| rect.min + vec2(x * rect.width(), y * rect.height());
    let table = [at(0.10, 0.66), at(0.72, 0.56), at(1.02, 0.78), at(0.40, 0.94)];
    painter.add(Shape::convex_polygon(table.to_vec(), tokens.faint.gamma_multiply(0.28), Stroke::NONE));
    let arm = [at(0.24, 0.62), at(0.20, 0.28), at(0.42, 0.16), at(0.58, 0.36)];
    let thick = 0.052 * rect.width();
    for pair in arm.windows(2) {
        painter.line_segment([pair[0], pair[1]], Stroke::new(thick, tokens.slate.gamma_multiply(0.75)));
    }
    for joint in arm {
        painter.circle_filled(joint, 0.62 * thick, tokens.faint);
        painter.circle_stroke(joint, 0.62 * thick, Stroke::new(1.5, tokens.teal));
    }
    // Every demo has its own proportions, so that the cards differ.
    let tall = 0.16 + 0.05 * (demo.name.len() % 4) as f32;
    let object = |x: f32, color: Color32| {
        let body = Rect::from_min_max(at(x, 0.70 - tall), at(x + 0.10, 0.72));
        painter.rect_filled(body, 6.0, color);
    };
    object(0.56, tokens.teal);
    object(0.80, tokens.amber.gamma_multiply(0.55));
    let path: Vec<_> = (0..=24)
        .map(|i| {
            let u = i as f32 / 24.0;
            at(0.61 + 0.24 * u, 0.70 - tall - 0.9 * tall * (4.0 * u * (1.0 - u)) * 0.5)
        })
        .collect();
    painter.add(Shape::line(path, Stroke::new(2.0, tokens.amber)));
}

/// A drawing of two arms that pass an object, in place of a picture.
fn passing(ui: &Ui, demo: &Demo, rect: Rect) {
    let tokens = Tokens::of(ui);
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let radius = egui::CornerRadius { nw: RADIUS, ne: RADIUS, sw: 0, se: 0 };
    painter.rect_filled(rect, radius, tokens.view_centre.lerp_to_gamma(tokens.view_edge, 0.5));
    let at = |x: f32, y: f32| rect.min + vec2(x * rect.width(), y * rect.height());
    // Every demo has its own height, so that the cards differ.
    let low = 0.50 + 0.04 * (demo.name.len() % 4) as f32;
    let meeting = [at(0.44, low), at(0.56, low - 0.02)];
    let shoulders = [at(0.14, 0.34), at(0.86, 0.30)];
    let hues = [tokens.slate, tokens.slate.lerp_to_gamma(tokens.violet, 0.45)];
    let thick = 0.05 * rect.width();
    painter.add(Shape::dashed_line(&shoulders, Stroke::new(1.5, tokens.faint), 6.0, 5.0));
    let trunks = [at(0.14, 1.05), at(0.86, 1.05)];
    let elbows = [at(0.24, 0.68), at(0.76, 0.66)];
    for side in 0..2 {
        let hue = hues[side].gamma_multiply(0.75);
        painter.line_segment([trunks[side], shoulders[side]], Stroke::new(1.5 * thick, hue.gamma_multiply(0.6)));
        painter.line_segment([shoulders[side], elbows[side]], Stroke::new(thick, hue));
        painter.line_segment([elbows[side], meeting[side]], Stroke::new(0.8 * thick, hue));
        for joint in [shoulders[side], elbows[side], meeting[side]] {
            painter.circle_filled(joint, 0.56 * thick, tokens.faint);
            painter.circle_stroke(joint, 0.56 * thick, Stroke::new(1.5, tokens.teal));
        }
    }
    let object = Rect::from_center_size(at(0.5, low - 0.01), vec2(0.09 * rect.width(), 0.30 * rect.height()));
    painter.rect_filled(object, 6.0, tokens.amber);
}
