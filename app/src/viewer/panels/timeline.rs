//! Time: phases by colour, manipulability as a curve, one cursor for both.

use egui::{Align, Align2, Color32, FontId, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::job::Stage;
use endcomfort_core::task::Plan;

use super::Out;
use super::plan::color;
use crate::viewer::captions::{changes_hands_s, deed};
use crate::viewer::handing::Partner;
use crate::viewer::icons::Icon;
use crate::viewer::state::StageState;
use crate::viewer::theme::{BODY, SECONDARY, SMALL, SMALL_RADIUS, Tokens, font, strong};
use crate::viewer::widgets::{focus_ring, icon_button, text_in};
use crate::viewer::{Command, ViewerState, format, playback};

const BARS: f32 = 11.0;
/// Height of a row of bars where each side of a handover has its own, and the room between the two, points.
const SIDE: [f32; 2] = [9.0, 4.0];
/// Width of the timeline from which it has room for the buttons that step, points.
const STEPS_FROM: f32 = 440.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    ui.spacing_mut().item_spacing = vec2(8.0, 0.0);
    let all = ui.max_rect();
    let row = Rect::from_min_size(all.min, vec2(all.width(), 28.0));
    let Some(plan) = &state.outputs.plan else { return empty(ui, state, all) };
    let partners = state.partners().filter(|_| plan.handover.is_some());
    // Who moves stands before the rows.
    let names = partners.as_ref().map_or(0.0, |partners| names_width(ui, partners));
    let track = Rect::from_min_max(pos2(all.left() + names, row.bottom() + 4.0), all.max);
    let pointed = scrubbing(ui, state, track, out);
    controls(ui, state, plan, row, pointed, out);
    if state.is_stale(Stage::Plan) {
        ui.multiply_opacity(0.45);
    }
    phases(ui, plan, track, state.duration_s());
    curve(ui, state, plan, track, pointed);
    match &partners {
        Some(partners) => sides(ui, state, plan, partners, track),
        None => legs(ui, state, plan, track),
    }
}

/// Room for the names of both sides.
fn names_width(ui: &Ui, partners: &[Partner; 2]) -> f32 {
    let width =
        |partner: &Partner| ui.painter().layout_no_wrap(partner.title.clone(), font(SMALL), Color32::WHITE).size().x;
    partners.iter().map(width).fold(0.0, f32::max).ceil() + 10.0
}

/// Where the bars of a leg are, from the upper end of the track: one row, or one for each side of a handover.
fn bar_y(plan: &Plan, leg: usize) -> [f32; 2] {
    let [height, gap] = SIDE;
    match (&plan.handover, leg) {
        (None, _) => [0.0, BARS],
        (Some(_), 0) => [0.0, height],
        (Some(_), _) => [height + gap, 2.0 * height + gap],
    }
}

/// No plan: the reason, or what is going on.
pub(super) fn empty(ui: &mut Ui, state: &ViewerState, rect: Rect) {
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
    let follows = playback.follows.is_some();
    let word = if follows { "Leave the camera where it is (O)" } else { "The camera follows the object (O)" };
    ui.add_space(-4.0);
    if icon_button(ui, Icon::Follow, word, true, follows).clicked() {
        out.push(Command::ToggleFollow);
    }
    ui.add_space(-4.0);
    if icon_button(ui, Icon::Present, "Presentation without panels (P)", true, false).clicked() {
        out.push(Command::Present(true));
    }
    let shown = pointed.unwrap_or(playback.time_s);
    let left = ui.cursor().left();
    let rest = Rect::from_min_max(pos2(left, row.top()), row.max);
    values(ui, state, plan, shown, rest);
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
fn values(ui: &Ui, state: &ViewerState, plan: &Plan, time_s: f64, rect: Rect) {
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
        match state.partners().filter(|_| plan.handover.is_some()) {
            Some(partners) => say(&partners[phase.leg.min(1)].title, deed(plan, plan.phase_at(time_s)).to_owned()),
            None => say("", phase.kind.name().to_owned()),
        }
    }
    if let Some(m) = playback::manipulability_at(plan, time_s).filter(|_| rect.width() > 90.0) {
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

pub(super) fn x_of(track: Rect, time_s: f64, duration_s: f64) -> f32 {
    track.left() + track.width() * (time_s / duration_s.max(1e-9)).max(0.0).min(1.0) as f32
}

/// Press and drag anywhere on the track; gives the time under the pointer while it only hovers.
pub(super) fn scrubbing(ui: &mut Ui, state: &ViewerState, track: Rect, out: &mut Out) -> Option<f64> {
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
    for leg in 0..if plan.handover.is_some() { 2 } else { 0 } {
        let [y0, y1] = bar_y(plan, leg);
        let middle = track.top() + 0.5 * (y0 + y1);
        ui.painter().hline(track.x_range(), middle, Stroke::new(1.0, tokens.line));
    }
    for (index, phase) in plan.phases.iter().enumerate() {
        let length_s = phase.trajectory.duration_s();
        let x0 = x_of(track, phase.start_s, duration_s);
        let x1 = x_of(track, phase.start_s + length_s, duration_s);
        // A gap of four points between bars; the first and the last one reach the ends.
        let inset = (0.25 * (x1 - x0)).min(2.0);
        let (left, right) = ((x0 - track.left()).min(inset), (track.right() - x1).min(inset));
        let [y0, y1] = bar_y(plan, phase.leg).map(|y| track.top() + y);
        let bar = Rect::from_min_max(pos2(x0 + left, y0), pos2(x1 - right, y1));
        ui.painter().rect_filled(bar, 3.0, color(phase.kind, tokens));
        let name = if plan.handover.is_some() { deed(plan, index) } else { phase.kind.name() };
        names.push((length_s, bar, name));
    }
    names.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken: Vec<Rect> = Vec::new();
    for (_, bar, name) in names {
        let galley = ui.painter().layout_no_wrap(name.to_owned(), font(SMALL), tokens.secondary);
        let left = (bar.left() + 3.0).min(track.right() - galley.size().x);
        let top = track.top() + bars_height(plan) + 3.0;
        let rect = Rect::from_min_size(pos2(left, top), galley.size());
        if taken.iter().all(|other| !other.expand2(vec2(8.0, 0.0)).intersects(rect)) {
            ui.painter().galley(rect.min, galley, tokens.secondary);
            taken.push(rect);
        }
    }
}

/// Height of all rows of bars.
fn bars_height(plan: &Plan) -> f32 {
    bar_y(plan, 1)[1]
}

/// Who moves, before the rows, and where the object changes hands.
fn sides(ui: &Ui, state: &ViewerState, plan: &Plan, partners: &[Partner; 2], track: Rect) {
    let tokens = Tokens::of(ui);
    let now = playback::phase_at(plan, state.playback.time_s).map(|phase| phase.leg.min(1));
    for (leg, partner) in partners.iter().enumerate() {
        let [y0, y1] = bar_y(plan, leg).map(|y| track.top() + y);
        let ink = if now == Some(leg) { tokens.text } else { tokens.secondary };
        let row = Rect::from_min_max(pos2(track.left(), y0), pos2(track.right(), y1));
        let at = pos2(track.left() - 10.0, row.center().y);
        let _rect = ui.painter().text(at, Align2::RIGHT_CENTER, &partner.title, font(SMALL), ink);
    }
    let Some(time_s) = changes_hands_s(plan) else { return };
    let x = x_of(track, time_s, state.duration_s());
    // Not through the words below the rows.
    let below = track.top() + bars_height(plan);
    for (from, to) in [(track.top(), below), (below + 20.0, track.bottom())] {
        ui.painter().vline(x, from..=to, Stroke::new(1.5, tokens.faint));
    }
    let galley = ui.painter().layout_no_wrap("changes hands".to_owned(), font(SMALL), tokens.secondary);
    let at = pos2((x + 6.0).min(track.right() - galley.size().x), track.bottom() - galley.size().y);
    let back = Rect::from_min_size(at, galley.size()).expand2(vec2(3.0, 0.0));
    ui.painter().rect_filled(back, 2.0, tokens.overlay);
    ui.painter().galley(at, galley, tokens.secondary);
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
    let area = Rect::from_min_max(pos2(track.left(), track.top() + bars_height(plan) + 20.0), track.max);
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
