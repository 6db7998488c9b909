//! The plan: its phases and numbers, what was tried before it, the hand's routes, and what it is asked for.

mod compare;
mod routes;
mod settings;
mod summary;
mod tried;

use egui::{Color32, Ui};
use endcomfort_core::job::{Refusal, Stage};
use endcomfort_core::task::PhaseKind;

use super::Out;
use super::inspector::{heading, nothing_yet};
use crate::viewer::fields::tabs;
use crate::viewer::state::StageState;
use crate::viewer::theme::{BODY, Tokens};
use crate::viewer::widgets::{paragraph, primary_button, secondary_button, title};
use crate::viewer::{Command, PlanCommand, PlanPage, ViewerState, format};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    if let StageState::Refused(refusal) = state.stage(Stage::Plan) {
        return refused(ui, state, refusal, out);
    }
    let Some(plan) = &state.outputs.plan else {
        nothing_yet(ui, state, Stage::Plan);
        // What it is asked for can be changed all the same.
        return settings::draw(ui, state, out);
    };
    let text = format!("Planned with {}", state.grasp_title(plan.grasp().id));
    let sentence = match (state.document.grasp.is_some(), plan.tries.len()) {
        (true, _) => "The grasp that you asked for.".to_owned(),
        (false, 0) => "The best-ranked grasp worked at the first try.".to_owned(),
        (false, failed) => format!("{} failed before it.", format::plural(failed, "try").replace("trys", "tries")),
    };
    heading(ui, state, Stage::Plan, &text, &sentence);
    let open = pages(ui, state, &PlanPage::ALL, out);
    match open {
        PlanPage::Plan => summary::draw(ui, state, plan, out),
        PlanPage::Tried => tried::draw(ui, state, out),
        PlanPage::Routes => routes::draw(ui, state, plan, out),
        PlanPage::Settings => settings::draw(ui, state, out),
    }
}

/// No plan: why, what was tried, and what could be asked for instead.
fn refused(ui: &mut Ui, state: &ViewerState, refusal: &Refusal, out: &mut Out) {
    let tokens = Tokens::of(ui);
    title(ui, "Plan was refused");
    ui.add_space(2.0);
    let _text = paragraph(ui, &refusal.message, BODY, tokens.coral);
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        if state.document.grasp.is_some() && primary_button(ui, "Try all grasps", true).clicked() {
            out.push(Command::PlanWithGrasp(None));
        }
        if state.can_undo() && secondary_button(ui, "Undo the last change", true).clicked() {
            out.push(Command::Undo);
        }
    });
    ui.add_space(6.0);
    match pages(ui, state, &PlanPage::REFUSED, out) {
        PlanPage::Settings => settings::draw(ui, state, out),
        _ => {
            tried::draw(ui, state, out);
            tried::details(ui, refusal);
        }
    }
}

/// The row of pages; gives the open one.
fn pages(ui: &mut Ui, state: &ViewerState, pages: &[PlanPage], out: &mut Out) -> PlanPage {
    let open = state.plan_page();
    let titles: Vec<&str> = pages.iter().map(|page| page.title()).collect();
    if let Some(index) = tabs(ui, &titles, pages.iter().position(|&page| page == open)) {
        out.push(Command::Planning(PlanCommand::Page(pages[index])));
    }
    open
}

/// The colour of a phase on the timeline and in lists.
pub(super) fn color(kind: PhaseKind, tokens: &Tokens) -> Color32 {
    match kind {
        PhaseKind::Reach => tokens.blue,
        PhaseKind::Close | PhaseKind::Open => tokens.teal,
        PhaseKind::Lift | PhaseKind::Place => tokens.amber.lerp_to_gamma(tokens.coral, 0.35),
        PhaseKind::Transport | PhaseKind::Slide => tokens.amber,
        PhaseKind::Pour => tokens.violet,
        PhaseKind::Retreat => tokens.slate,
    }
}
