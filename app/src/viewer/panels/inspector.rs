//! The answer to the question of the selected step.

use egui::Ui;
use endcomfort_core::job::Stage;

use super::{Out, fit, grasps, plan, play, posing, reach, scene, segment};
use crate::viewer::ViewerState;
use crate::viewer::state::{StageState, Step};
use crate::viewer::theme::{SECONDARY, Tokens};
use crate::viewer::widgets::{paragraph, title};

/// Room for the scroll bar, points.
const SCROLL_BAR: f32 = 11.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    ui.spacing_mut().item_spacing.y = 2.0;
    if state.reaching.is_open {
        return scrolled(ui, ("Inspector", "Reachability"), |ui| reach::draw(ui, state, out));
    }
    if state.posing.is_open {
        return scrolled(ui, ("Inspector", "Pose"), |ui| posing::draw(ui, state, out));
    }
    match state.selection.step {
        // The two with a table share out the height themselves.
        Step::Stage(stage @ (Stage::Grasps | Stage::Rank)) if !is_refused(state, stage) => {
            grasps::draw(ui, state, stage, out);
        }
        step => scrolled(ui, ("Inspector", step.title()), |ui| match step {
            Step::Stage(stage) if is_refused(state, stage) && stage != Stage::Plan => refused(ui, state, stage, out),
            Step::Stage(Stage::Scene) => scene::draw(ui, state, out),
            Step::Stage(Stage::Segment) => segment::draw(ui, state, out),
            Step::Stage(Stage::Fit) => fit::draw(ui, state, out),
            Step::Stage(Stage::Plan) => plan::draw(ui, state, out),
            Step::Stage(Stage::Grasps | Stage::Rank) => {}
            Step::Play => play::draw(ui, state, out),
        }),
    }
}

/// Draws a page that scrolls; the bar stands in the panel's margin, beside the numbers and not over them.
fn scrolled(ui: &mut Ui, id: (&str, &str), draw: impl FnOnce(&mut Ui)) {
    let (inside, width) = (ui.available_rect_before_wrap(), ui.available_width());
    let beside = inside.with_max_x(inside.right() + SCROLL_BAR);
    let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(beside));
    let area = egui::ScrollArea::vertical().id_salt(id).auto_shrink(false);
    area.show(&mut ui, |ui| {
        ui.set_max_width(width);
        draw(ui);
        ui.add_space(8.0);
    });
}

fn is_refused(state: &ViewerState, stage: Stage) -> bool {
    matches!(state.stage(stage), StageState::Refused(_))
}

/// The heading of a stage with one sentence under it, which says when the numbers are out of date.
pub(super) fn heading(ui: &mut Ui, state: &ViewerState, stage: Stage, text: &str, sentence: &str) {
    let tokens = Tokens::of(ui);
    title(ui, text);
    match state.stage(stage) {
        StageState::Running { note, fraction } => {
            let note = if note.is_empty() { "computing" } else { note };
            let _text = paragraph(ui, &format!("{:.0} % · {note}", 100.0 * fraction), SECONDARY, tokens.teal_text);
        }
        _ if state.is_stale(stage) => {
            let text = "These numbers belong to the scene as it was before the last change.";
            let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
        }
        _ if !sentence.is_empty() => {
            let _text = paragraph(ui, sentence, SECONDARY, tokens.secondary);
        }
        _ => {}
    }
    ui.add_space(6.0);
}

/// A stage that has not run yet.
pub(super) fn nothing_yet(ui: &mut Ui, state: &ViewerState, stage: Stage) {
    let sentence = match state.refusal() {
        Some((before, _)) if before < stage => format!("It waits: {} was refused.", before.title()),
        _ if state.running => "It waits for the steps before it.".to_owned(),
        _ => "It has not run.".to_owned(),
    };
    heading(ui, state, stage, stage.title(), &sentence);
}

/// Why a stage was refused: the sentence, then what was tried.
fn refused(ui: &mut Ui, state: &ViewerState, stage: Stage, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let StageState::Refused(refusal) = state.stage(stage) else { return };
    title(ui, &format!("{} was refused", stage.title()));
    ui.add_space(2.0);
    let _text = paragraph(ui, &refusal.message, super::super::theme::BODY, tokens.coral);
    if !refusal.details.is_empty() {
        crate::viewer::widgets::section(ui, "What was tried");
        for detail in &refusal.details {
            let _text = paragraph(ui, detail, SECONDARY, tokens.secondary);
        }
    }
    ui.add_space(12.0);
    ui.horizontal(|ui| {
        if state.can_undo() && crate::viewer::widgets::secondary_button(ui, "Undo the last change", true).clicked() {
            out.push(crate::viewer::Command::Undo);
        }
    });
}
