//! The story of the pipeline: each step with its state, its outcome and its time.

use egui::{Align, Color32, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::grasp::GraspStatus;
use endcomfort_core::job::Stage;

use super::Out;
use crate::viewer::format;
use crate::viewer::icons::{self, Icon};
use crate::viewer::state::{StageState, Step};
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::{focus_ring, icon_button_at, paragraph, secondary_button, text_in};
use crate::viewer::{Command, ViewerState};

const ROW: f32 = 32.0;
const PADDING: f32 = 14.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    ui.spacing_mut().item_spacing.y = 0.0;
    for (index, step) in Step::ALL.into_iter().enumerate() {
        row(ui, state, index, step, out);
        if let Step::Stage(stage) = step {
            reason(ui, state.stage(stage));
        }
    }
    if !state.running
        && state.refusal().is_none()
        && Stage::ALL.into_iter().any(|stage| !matches!(state.stage(stage), StageState::Done { .. }))
    {
        ui.add_space(6.0);
        if secondary_button(ui, "Run", true).clicked() {
            out.push(Command::Run);
        }
    }
}

fn row(ui: &mut Ui, state: &ViewerState, index: usize, step: Step, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let full = rect.expand2(vec2(PADDING - 1.0, 0.0));
    let is_selected = state.selection.step == step && !state.reaching.is_open && !state.posing.is_open;
    if is_selected {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    badge(ui, state, index, step, pos2(rect.left() + 10.0, rect.center().y));
    let id = if is_selected { strong(BODY) } else { font(BODY) };
    let galley = ui.painter().layout_no_wrap(step.title().to_owned(), id, tokens.text);
    let title_right = rect.left() + 30.0 + galley.size().x;
    ui.painter().galley(pos2(rect.left() + 30.0, rect.center().y - 0.5 * galley.size().y), galley, tokens.text);
    let (outcome, color) = outcome(state, step, tokens);
    // The step that is computed, or that comes next, carries the way out.
    let next = Stage::ALL.into_iter().find(|&stage| !matches!(state.stage(stage), StageState::Done { .. }));
    let is_next = state.running && next.is_some_and(|stage| step == Step::Stage(stage));
    let right = if is_next { rect.right() - 24.0 } else { rect.right() };
    let rest = Rect::from_min_max(pos2(title_right + 10.0, rect.top()), pos2(right, rect.bottom()));
    if !outcome.is_empty() {
        let _text = text_in(ui, rest, Align::Max, &outcome, font(SECONDARY), color);
    }
    if let Step::Stage(stage) = step {
        progress(ui, state.stage(stage), rect);
    }
    focus_ring(ui, &response, full);
    if is_next {
        let cross = Rect::from_center_size(pos2(rect.right() - 8.0, rect.center().y), vec2(22.0, 22.0));
        if icon_button_at(ui, cross, Icon::Cross, "Cancel", true).clicked() {
            out.push(Command::Cancel);
        }
    }
    response.widget_info(|| {
        let word = match step {
            Step::Stage(stage) => word(state.stage(stage)),
            Step::Play => "",
        };
        WidgetInfo::selected(Role::Button, true, is_selected, format!("{} {word} {outcome}", step.title()))
    });
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        out.push(Command::SelectStep(step));
    }
}

/// How far a running stage is, along the foot of its row.
fn progress(ui: &Ui, stage: &StageState, row: Rect) {
    let StageState::Running { fraction, .. } = stage else { return };
    let tokens = Tokens::of(ui);
    let track = Rect::from_min_max(pos2(row.left() + 30.0, row.bottom() - 4.0), pos2(row.right(), row.bottom() - 1.0));
    ui.painter().rect_filled(track, 1.5, tokens.well);
    let mut done = track;
    done.set_width(track.width() * *fraction as f32);
    ui.painter().rect_filled(done, 1.5, tokens.teal);
}

/// The reason of a refused stage, under its row.
fn reason(ui: &mut Ui, stage: &StageState) {
    let StageState::Refused(refusal) = stage else { return };
    let tokens = Tokens::of(ui);
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.add_space(30.0);
        let _text = paragraph(ui, &refusal.message, SECONDARY, tokens.coral);
    });
    ui.add_space(6.0);
}

fn badge(ui: &Ui, state: &ViewerState, index: usize, step: Step, centre: egui::Pos2) {
    let tokens = Tokens::of(ui);
    let painter = ui.painter();
    let disc = |fill: Color32, icon: Icon, ink: Color32| {
        painter.circle_filled(centre, 10.0, fill);
        icons::paint(painter, icon, centre, 13.0, ink);
    };
    let ring = |color: Color32, ink: Color32| {
        painter.circle_stroke(centre, 9.25, Stroke::new(1.5, color));
        let number = (index + 1).to_string();
        let _rect = painter.text(centre, egui::Align2::CENTER_CENTER, number, font(11.0), ink);
    };
    match step {
        Step::Play if state.playback.playing => disc(tokens.teal, Icon::Pause, tokens.on_teal),
        Step::Play if state.duration_s() > 0.0 => ring(tokens.teal, tokens.teal_text),
        Step::Play => ring(tokens.faint, tokens.secondary),
        Step::Stage(stage) => match state.stage(stage) {
            StageState::Done { .. } => disc(tokens.teal, Icon::Check, tokens.on_teal),
            StageState::Refused(_) => disc(tokens.coral, Icon::Cross, tokens.view_edge),
            StageState::Running { fraction, .. } => {
                ring(tokens.line, tokens.teal_text);
                let sweep = 360.0 * (*fraction as f32).max(0.04);
                icons::arc(painter, centre, 9.25, -90.0, -90.0 + sweep, Stroke::new(2.0, tokens.teal));
            }
            StageState::Stale => {
                painter.circle_stroke(centre, 9.25, Stroke::new(1.5, tokens.faint));
                icons::paint(painter, Icon::Check, centre, 12.0, tokens.secondary);
            }
            StageState::Waiting => ring(tokens.faint, tokens.secondary),
        },
    }
}

fn word(stage: &StageState) -> &'static str {
    match stage {
        StageState::Waiting => "waiting",
        StageState::Running { .. } => "running",
        StageState::Done { .. } => "done",
        StageState::Refused(_) => "refused",
        StageState::Stale => "out of date",
    }
}

fn outcome(state: &ViewerState, step: Step, tokens: &Tokens) -> (String, Color32) {
    let Step::Stage(stage) = step else {
        let duration_s = state.duration_s();
        let text = if duration_s > 0.0 { format!("{} s", format::significant(duration_s)) } else { String::new() };
        return (text, tokens.secondary);
    };
    match state.stage(stage) {
        StageState::Waiting => (String::new(), tokens.secondary),
        StageState::Running { note, fraction } if note.is_empty() => {
            (format!("{:.0} %", fraction * 100.0), tokens.secondary)
        }
        StageState::Running { note, .. } => (note.clone(), tokens.secondary),
        StageState::Refused(_) => ("refused".to_owned(), tokens.coral),
        StageState::Stale => ("out of date".to_owned(), tokens.secondary),
        StageState::Done { elapsed_ms } => {
            let time = format::elapsed(*elapsed_ms);
            (result(state, stage).map_or(time.clone(), |result| format!("{result} · {time}")), tokens.secondary)
        }
    }
}

/// The outcome of a stage in a few words.
fn result(state: &ViewerState, stage: Stage) -> Option<String> {
    let outputs = &state.outputs;
    match stage {
        Stage::Scene => outputs.scene.as_ref().map(|scene| format::plural(scene.cloud.points.len(), "point")),
        Stage::Segment => outputs.segment.as_ref().map(|segment| format::plural(segment.clusters.len(), "cluster")),
        Stage::Fit => {
            let fit = outputs.fit.as_ref()?;
            let target = fit.fits.get(fit.target)?.as_ref().ok()?;
            Some(format!("error {}", format::length(target.radial_m)))
        }
        Stage::Grasps => outputs.grasps.as_ref().map(|grasps| {
            let kept = grasps.grasps.iter().filter(|grasp| grasp.status == GraspStatus::Accepted).count();
            format!("{} → {}", format::count(grasps.grasps.len()), format::count(kept))
        }),
        Stage::Rank => {
            let rank = outputs.rank.as_ref()?;
            let before = outputs
                .grasps
                .as_ref()
                .map(|grasps| grasps.grasps.iter().filter(|grasp| grasp.status == GraspStatus::Accepted).count());
            Some(match before {
                Some(before) => format!("{} → {}", format::count(before), format::count(rank.accepted)),
                None => format::count(rank.accepted),
            })
        }
        Stage::Plan => outputs.plan.as_ref().map(|plan| format!("{} try", format::ordinal(plan.tries.len() + 1))),
    }
}
