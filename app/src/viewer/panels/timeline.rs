//! Time: phases by colour, manipulability as a curve, one cursor for both.

use egui::{Align, Align2, Color32, FontId, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::job::Stage;
use endcomfort_core::task::Plan;

use super::Out;
use super::plan::color;
use crate::viewer::icons::Icon;
use crate::viewer::state::StageState;
use crate::viewer::theme::{BODY, SECONDARY, SMALL, SMALL_RADIUS, Tokens, font, strong};
use crate::viewer::widgets::{focus_ring, icon_button, text_in};
use crate::viewer::{Command, ViewerState, format, playback};

const BARS: f32 = 11.0;
/// Width of the timeline from which it has room for the buttons that step, points.
const STEPS_FROM: f32 = 440.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    ui.spacing_mut().item_spacing = vec2(8.0, 0.0);
    let all = ui.max_rect();
    let row = Rect::from_min_size(all.min, vec2(all.width(), 28.0));
    let track = Rect::from_min_max(pos2(all.left(), row.bottom() + 4.0), all.max);
    let Some(plan) = &state.outputs.plan else { return empty(ui, state, all) };
    let pointed = scrubbing(ui, state, track, out);
    controls(ui, state, plan, row, pointed, out);
    if state.is_stale(Stage::Plan) {
        ui.multiply_opacity(0.45);
    }
    phases(ui, plan, track, state.duration_s());
    curve(ui, state, plan, track, pointed);
    legs(ui, state, plan, track);
}

/// No plan: the reason, or what is going on.
fn empty(ui: &mut Ui, state: &ViewerState, rect: Rect) {
    let tokens = Tokens::of(ui);
    let text = match state.refusal() {
        Some((stage, _)) => format!("No plan: the step {} was refused; its reason stands beside it.", stage.title()),
        None if state.running => {
            let note = Stage::ALL.into_iter().find_map(|stage| match state.stage(stage) {
                StageState::Running { note, .. } if note.is_empty() => Some(stage.title().to_owned()),
                StageState::Running { note, .. } => Some(format!("{}: {note}", stage.title())),
                _ => None,
            });
            note.unwrap_or_else(|| "The pipeline runs.".to_owned())
        }
        None => "No plan yet.".to_owned(),
    };
    let _text = text_in(ui, rect, Align::Center, &text, font(BODY), tokens.secondary);
}

fn controls(ui: &mut Ui, state: &ViewerState, plan: &Plan, row: Rect, pointed: Option<f64>, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let playback = &state.playback;
    let mut inside =
        ui.new_child(egui::UiBuilder::new().max_rect(row).layout(egui::Layout::left_to_right(Align::Center)));
    let ui = &mut inside;
    let (icon, word) = if playback.playing { (Icon::Pause, "Pause (Space)") } else { (Icon::Play, "Play (Space)") };
    if icon_button(ui, icon, word, true, false).clicked() {
        out.push(Command::SetPlaying(!playback.playing));
    }
    // On a phone the values need the room; the keys step all the same.
    if row.width() > STEPS_FROM {
        for (icon, word, forth) in
            [(Icon::StepBack, "One sample back (,)", false), (Icon::StepForth, "One sample forth (.)", true)]
        {
            if icon_button(ui, icon, word, true, false).clicked() {
                out.push(Command::StepSample { forth });
            }
            ui.add_space(-6.0);
        }
        ui.add_space(6.0);
    }
    // A fixed place for the time, so that nothing after it moves while it runs.
    let (rect, _) = ui.allocate_exact_size(vec2(118.0, 24.0), Sense::hover());
    let now = ui.painter().text(
        rect.left_center(),
        Align2::LEFT_CENTER,
        format::clock(playback.time_s),
        strong(BODY),
        tokens.text,
    );
    let whole = format!("/ {}", format::clock(state.duration_s()));
    let at = pos2(now.right() + 8.0, rect.center().y);
    let _rect = ui.painter().text(at, Align2::LEFT_CENTER, whole, font(BODY), tokens.secondary);
    let speed = format!("{}×", playback.speed);
    if word_button(ui, &speed, "Speed", playback.speed != 1.0).clicked() {
        out.push(Command::NextSpeed);
    }
    let word = if playback.looping { "Play once" } else { "Play in a loop" };
    if icon_button(ui, Icon::Loop, word, true, playback.looping).clicked() {
        out.push(Command::ToggleLoop);
    }
    let shown = pointed.unwrap_or(playback.time_s);
    let left = ui.cursor().left();
    let rest = Rect::from_min_max(pos2(left, row.top()), row.max);
    values(ui, plan, shown, rest);
}

/// A word that acts, lit while it holds.
fn word_button(ui: &mut Ui, text: &str, name: &str, lit: bool) -> egui::Response {
    let tokens = Tokens::of(ui);
    let galley = ui.painter().layout_no_wrap(text.to_owned(), font(BODY), tokens.secondary);
    let (rect, response) = ui.allocate_exact_size(vec2((galley.size().x + 14.0).max(36.0), 24.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, lit, format!("{name} {text}")));
    if response.hovered() {
        ui.painter().rect_filled(rect, SMALL_RADIUS, tokens.hover);
    }
    let color = match (lit, response.hovered()) {
        (true, _) => tokens.teal_text,
        (false, true) => tokens.text,
        (false, false) => tokens.secondary,
    };
    ui.painter().galley_with_override_text_color(rect.center() - 0.5 * galley.size(), galley, color);
    focus_ring(ui, &response, rect);
    response
}

/// The values under the cursor, right-aligned: `m(q) 0.071 · clearance 38 mm`.
fn values(ui: &Ui, plan: &Plan, time_s: f64, rect: Rect) {
    let tokens = Tokens::of(ui);
    let mut parts: Vec<(String, FontId, Color32)> = Vec::new();
    let mut say = |words: &str, value: String| {
        let joint = if parts.is_empty() || words == "of" { " " } else { "  ·  " };
        parts.push((format!("{joint}{words} "), font(SECONDARY), tokens.secondary));
        parts.push((value, strong(SECONDARY), tokens.text));
    };
    if rect.width() > 330.0
        && let Some(phase) = playback::phase_at(plan, time_s)
    {
        say("", phase.kind.name().to_owned());
    }
    if let Some(m) = playback::manipulability_at(plan, time_s) {
        say("m(q)", format::manipulability(m));
        if rect.width() > 250.0 {
            say("of", format::manipulability(highest(plan)));
        }
    }
    if let Some(clearance_m) = playback::clearance_at(plan, time_s).filter(|_| rect.width() > 220.0) {
        say("clearance", format::length(clearance_m));
    }
    let mut right = rect.right();
    for (text, id, color) in parts.into_iter().rev() {
        let drawn = ui.painter().text(pos2(right, rect.center().y), Align2::RIGHT_CENTER, text, id, color);
        right = drawn.left();
    }
}

/// The largest manipulability of the plan: the top of the curve.
fn highest(plan: &Plan) -> f64 {
    let values = plan.phases.iter().flat_map(|phase| &phase.manipulability);
    values.copied().filter(|m| m.is_finite()).fold(1e-6, f64::max)
}

fn x_of(track: Rect, time_s: f64, duration_s: f64) -> f32 {
    track.left() + track.width() * (time_s / duration_s.max(1e-9)).max(0.0).min(1.0) as f32
}

/// Press and drag anywhere on the track; gives the time under the pointer while it only hovers.
fn scrubbing(ui: &mut Ui, state: &ViewerState, track: Rect, out: &mut Out) -> Option<f64> {
    let response = ui.interact(track.expand2(vec2(4.0, 2.0)), ui.scope_id().with("Scrub"), Sense::click_and_drag());
    let time_s = state.playback.time_s;
    response.widget_info(|| WidgetInfo::slider(true, time_s, "Time"));
    let at = |pointer: Pos2| {
        let u = f64::from((pointer.x - track.left()) / track.width().max(1.0)).max(0.0).min(1.0);
        u * state.duration_s()
    };
    focus_ring(ui, &response, track.expand(3.0));
    if (response.is_pointer_button_down_on() || response.clicked())
        && let Some(pointer) = response.interact_pointer_pos()
    {
        if state.playback.playing {
            out.push(Command::SetPlaying(false));
        }
        out.push(Command::Seek(at(pointer)));
        return None;
    }
    response.hover_pos().map(at)
}

/// Bars in the colours of the phases; a name stands under its bar where it fits, the longer phase first.
fn phases(ui: &Ui, plan: &Plan, track: Rect, duration_s: f64) {
    let tokens = Tokens::of(ui);
    let mut names: Vec<(f64, Rect, &'static str)> = Vec::new();
    for phase in &plan.phases {
        let length_s = phase.trajectory.duration_s();
        let x0 = x_of(track, phase.start_s, duration_s);
        let x1 = x_of(track, phase.start_s + length_s, duration_s);
        // A gap of four points between bars; the first and the last one reach the ends.
        let inset = (0.25 * (x1 - x0)).min(2.0);
        let (left, right) = ((x0 - track.left()).min(inset), (track.right() - x1).min(inset));
        let bar = Rect::from_min_max(pos2(x0 + left, track.top()), pos2(x1 - right, track.top() + BARS));
        ui.painter().rect_filled(bar, 3.0, color(phase.kind, tokens));
        names.push((length_s, bar, phase.kind.name()));
    }
    names.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken: Vec<Rect> = Vec::new();
    for (_, bar, name) in names {
        let galley = ui.painter().layout_no_wrap(name.to_owned(), font(SMALL), tokens.secondary);
        let left = (bar.left() + 3.0).min(track.right() - galley.size().x);
        let rect = Rect::from_min_size(pos2(left, bar.bottom() + 3.0), galley.size());
        if taken.iter().all(|other| !other.expand2(vec2(8.0, 0.0)).intersects(rect)) {
            ui.painter().galley(rect.min, galley, tokens.secondary);
            taken.push(rect);
        }
    }
}

/// Where the object is grasped anew: a line through everything, the number of the hold beside it.
fn legs(ui: &Ui, state: &ViewerState, plan: &Plan, track: Rect) {
    if plan.legs.len() < 2 {
        return;
    }
    let tokens = Tokens::of(ui);
    for (leg, about) in plan.legs.iter().enumerate() {
        let Some(first) = plan.phases.iter().find(|phase| phase.leg == leg) else { continue };
        let x = x_of(track, first.start_s, state.duration_s());
        if leg > 0 {
            ui.painter().vline(x, track.y_range(), Stroke::new(1.5, tokens.faint));
        }
        let text = format!("{} hold, {}", format::ordinal(leg + 1), state.grasp_title(about.grasp.id));
        let galley = ui.painter().layout_no_wrap(text, font(SMALL), tokens.secondary);
        let at = pos2(x + if leg > 0 { 6.0 } else { 0.0 }, track.bottom() - galley.size().y);
        let back = Rect::from_min_size(at, galley.size()).expand2(vec2(3.0, 0.0));
        ui.painter().rect_filled(back, 2.0, tokens.overlay);
        ui.painter().galley(at, galley, tokens.secondary);
    }
}

/// Manipulability over the whole plan, the cursor, and a thin line under the pointer.
fn curve(ui: &Ui, state: &ViewerState, plan: &Plan, track: Rect, pointed: Option<f64>) {
    let tokens = Tokens::of(ui);
    let duration_s = state.duration_s();
    let area = Rect::from_min_max(pos2(track.left(), track.top() + BARS + 20.0), track.max);
    let samples = plan.phases.iter().flat_map(|phase| {
        phase.trajectory.times_s.iter().zip(&phase.manipulability).map(|(&t, &m)| (phase.start_s + t, m))
    });
    let samples: Vec<(f64, f64)> = samples.filter(|(_, m)| m.is_finite()).collect();
    let top = highest(plan);
    let y_of = |m: f64| area.bottom() - area.height() * (m / top).max(0.0) as f32 * 0.94;
    let mut points: Vec<Pos2> = Vec::with_capacity(samples.len());
    for &(t, m) in &samples {
        let point = pos2(x_of(track, t, duration_s), y_of(m));
        // Half a pixel apart is enough.
        if points.last().is_none_or(|last| point.x - last.x >= 0.5) {
            points.push(point);
        }
    }
    if points.len() > 1 {
        ui.painter().add(Shape::line(points, Stroke::new(1.75, tokens.teal)));
    }
    if let Some(time_s) = pointed {
        let x = x_of(track, time_s, duration_s);
        ui.painter().vline(x, track.y_range(), Stroke::new(1.0, tokens.faint));
    }
    let time_s = state.playback.time_s;
    let x = x_of(track, time_s, duration_s);
    ui.painter().vline(x, track.top() - 2.0..=track.bottom(), Stroke::new(1.5, tokens.text));
    if let Some(m) = playback::manipulability_at(plan, time_s) {
        ui.painter().circle_filled(pos2(x, y_of(m)), 3.5, tokens.text);
    }
}
