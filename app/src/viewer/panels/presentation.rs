//! The presentation: the view alone, a caption of what happens, and a thin line of time.

use egui::text::LayoutJob;
use egui::{Align, Color32, CornerRadius, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::task::Plan;

use super::Out;
use super::plan::color;
use super::timeline::{empty, scrubbing, x_of};
use crate::viewer::icons::Icon;
use crate::viewer::layout::Layout;
use crate::viewer::theme::{BODY, RADIUS, Tokens, font, strong};
use crate::viewer::widgets::{elided, icon_button_at};
use crate::viewer::{Command, ViewerState};

/// Size of the caption, and on a phone, points.
const CAPTION: [f32; 2] = [27.0, 20.0];
/// Widest caption, points.
const WIDEST: f32 = 980.0;
/// Thickness of the line of time, points.
const LINE: f32 = 5.0;
/// What a part of somebody else's page offers instead of leaving.
const OPEN: &str = "Open in Endcomfort";
/// Width of those words with the ground below them, points.
const OPEN_WIDTH: f32 = 152.0;
/// Edge of a button, points.
const BUTTON: f32 = 32.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, layout: &Layout, out: &mut Out) {
    head(ui, state, layout, out);
    let all = layout.timeline;
    let track = Rect::from_min_max(pos2(all.left() + 8.0, all.bottom() - 18.0), all.max - vec2(8.0, 0.0));
    let words = Rect::from_min_max(all.min, pos2(all.right(), track.top() - 4.0));
    let Some(plan) = &state.outputs.plan else { return empty(ui, state, words) };
    caption(ui, layout, &state.caption(plan, plan.phase_at(state.playback.time_s)), words);
    let _pointed = scrubbing(ui, state, track, out);
    line(ui, state, plan, track);
}

/// What is shown, and the buttons that play and leave.
fn head(ui: &mut Ui, state: &ViewerState, layout: &Layout, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let playing = state.playback.playing;
    let dark = ui.visuals().dark_mode;
    let theme = if dark { crate::viewer::ThemeChoice::Light } else { crate::viewer::ThemeChoice::Dark };
    let leave = match (state.is_embedded, layout.is_phone) {
        (false, _) => Some((Icon::Cross, "Leave the presentation (Esc)", Command::Present(false))),
        (true, true) => Some((Icon::Link, OPEN, Command::OpenPage)),
        // There is room for the words.
        (true, false) => None,
    };
    let others = [
        (
            if dark { Icon::Sun } else { Icon::Moon },
            if dark { "Light theme" } else { "Dark theme" },
            Command::SetTheme(theme),
        ),
        (
            Icon::Follow,
            if state.playback.follows.is_some() { "Leave the camera where it is (O)" } else { "Follow the object (O)" },
            Command::ToggleFollow,
        ),
        (
            if playing { Icon::Pause } else { Icon::Play },
            if playing { "Pause (Space)" } else { "Play (Space)" },
            Command::SetPlaying(!playing),
        ),
    ];
    let buttons: Vec<_> = leave.into_iter().chain(others).collect();
    let width = BUTTON * buttons.len() as f32;
    let back = Rect::from_min_size(pos2(layout.top.right() - width - 8.0, layout.top.top()), vec2(width + 8.0, 40.0));
    ui.painter().rect(back, RADIUS, tokens.panel, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    let mut right = back.right() - 4.0;
    let mut inside = ui.new_child(egui::UiBuilder::new().max_rect(back));
    for (icon, name, command) in buttons {
        let rect = Rect::from_min_size(pos2(right - BUTTON, back.top() + 4.0), vec2(BUTTON, BUTTON));
        if icon_button_at(&mut inside, rect, icon, name, true).clicked() {
            out.push(command);
        }
        right -= BUTTON;
    }
    let mut left = back.left();
    if state.is_embedded && !layout.is_phone {
        left -= OPEN_WIDTH + 8.0;
        let rect = Rect::from_min_size(pos2(left, back.top()), vec2(OPEN_WIDTH, back.height()));
        ui.painter().rect(rect, RADIUS, tokens.panel, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
        let middle = egui::Layout::centered_and_justified(egui::Direction::LeftToRight);
        let mut inside = ui.new_child(egui::UiBuilder::new().max_rect(rect.shrink(4.0)).layout(middle));
        if inside.link(egui::RichText::new(OPEN).font(font(BODY)).color(tokens.teal_text)).clicked() {
            out.push(Command::OpenPage);
        }
    }
    let width = (left - layout.top.left() - 40.0).max(0.0);
    let title = elided(ui, &state.document.scene.title, strong(BODY), tokens.text, width);
    let at = pos2(layout.top.left() + 12.0, back.center().y);
    let pill = Rect::from_min_size(pos2(at.x - 12.0, back.top()), vec2(title.size().x + 24.0, back.height()));
    ui.painter().rect(pill, RADIUS, tokens.panel, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    ui.painter().galley(pos2(at.x, at.y - 0.5 * title.size().y), title, tokens.text);
}

/// The sentence in the middle of a rectangle, on a ground of its own.
fn caption(ui: &Ui, layout: &Layout, text: &str, rect: Rect) {
    let tokens = Tokens::of(ui);
    let size = CAPTION[usize::from(layout.is_phone)];
    let width = (rect.width() - 48.0).min(WIDEST);
    let mut job = LayoutJob::simple(text.to_owned(), strong(size), tokens.text, width);
    job.halign = Align::Center;
    let galley = ui.painter().layout_job(job);
    let back = Rect::from_center_size(rect.center(), galley.size() + vec2(44.0, 18.0));
    ui.painter().add(tokens.shadow.as_shape(back, CornerRadius::same(RADIUS + 4)));
    ui.painter().rect(back, RADIUS + 4, tokens.panel, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
    let top = pos2(back.center().x, back.center().y - 0.5 * galley.size().y);
    ui.painter().galley(top, galley, tokens.text);
    let response = ui.interact(back, ui.scope_id().with("Caption"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("Caption: {text}")));
}

/// Time in the colours of the phases: what is past is bright.
fn line(ui: &Ui, state: &ViewerState, plan: &Plan, track: Rect) {
    let tokens = Tokens::of(ui);
    let duration_s = state.duration_s();
    let now = x_of(track, state.playback.time_s, duration_s);
    let bar = Rect::from_center_size(track.center(), vec2(track.width(), LINE));
    ui.painter().rect_filled(bar.expand(3.0), LINE, tokens.panel);
    let part = |from: f32, to: f32, color: Color32| {
        if to > from {
            ui.painter().rect_filled(bar.with_min_x(from).with_max_x(to), 2.0, color);
        }
    };
    for phase in &plan.phases {
        let from = x_of(track, phase.start_s, duration_s);
        let to = x_of(track, phase.start_s + phase.trajectory.duration_s(), duration_s) - 1.0;
        let ink = color(phase.kind, tokens);
        part(from, to, ink.gamma_multiply(0.35));
        part(from, to.min(now), ink);
    }
    ui.painter().circle(pos2(now, bar.center().y), 6.0, tokens.text, Stroke::new(2.0, tokens.view_edge));
}
