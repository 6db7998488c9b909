//! The plan: its phases and numbers, what was tried before it, the hand's routes, and what it is asked for.

mod compare;
mod handover;
mod receiver;
mod routes;
mod settings;
mod summary;
mod task;
mod tried;

use egui::{Align, Color32, Layout, Ui, vec2};
use endcomfort_core::job::{Refusal, Stage};
use endcomfort_core::task::PhaseKind;

use super::Out;
use super::inspector::{heading, nothing_yet};
use crate::export::MotionFormat;
use crate::viewer::fields::{menu, tabs};
use crate::viewer::icons::Icon;
use crate::viewer::state::StageState;
use crate::viewer::theme::{BODY, SECONDARY, Tokens};
use crate::viewer::widgets::{icon_button, paragraph, primary_button, secondary_button, title};
use crate::viewer::{Command, PlanCommand, PlanPage, ViewerState, format};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    if let StageState::Refused(refusal) = state.stage(Stage::Plan) {
        return refused(ui, state, refusal, out);
    }
    let Some(plan) = &state.outputs.plan else {
        nothing_yet(ui, state, Stage::Plan);
        // What it is asked for can be changed all the same.
        return match pages(ui, state, out) {
            PlanPage::Settings => settings::draw(ui, state, out),
            PlanPage::Handover => handover::draw(ui, state, out),
            _ => task::draw(ui, state, out),
        };
    };
    let text = match state.partners().filter(|_| plan.handover.is_some()) {
        Some([giver, receiver]) => format!("{} gives, {} takes", giver.subject(), receiver.words),
        None => format!("Planned with {}", state.grasp_title(plan.grasp().id)),
    };
    let sentence = match (state.document.grasp.is_some(), plan.tries.len()) {
        (true, _) => "The grasp that you asked for.".to_owned(),
        (false, 0) if plan.handover.is_some() => "The best place worked at the first try.".to_owned(),
        (false, 0) => "The best-ranked grasp worked at the first try.".to_owned(),
        (false, failed) => format!("{} failed before it.", format::plural(failed, "try").replace("trys", "tries")),
    };
    if state.is_dragging_goal() {
        // Answers come and go many times a second: a sentence about each would flicker.
        title(ui, &text);
        let _text = paragraph(ui, "It is planned anew while you drag.", SECONDARY, Tokens::of(ui).secondary);
        ui.add_space(6.0);
    } else {
        ui.horizontal_top(|ui| {
            let width = ui.available_width() - 36.0;
            ui.allocate_ui_with_layout(vec2(width, 0.0), Layout::top_down(Align::Min), |ui| {
                ui.set_width(width);
                heading(ui, state, Stage::Plan, &text, &sentence);
            });
            let can_save = !state.is_stale(Stage::Plan);
            let button = icon_button(ui, Icon::Save, "Export the plan", can_save, false);
            if can_save && let Some(index) = menu(&button, &MotionFormat::ALL.map(MotionFormat::title), None) {
                out.push(Command::Planning(PlanCommand::Export(MotionFormat::ALL[index])));
            }
        });
    }
    match pages(ui, state, out) {
        PlanPage::Plan => summary::draw(ui, state, plan, out),
        PlanPage::Tried => tried::draw(ui, state, out),
        PlanPage::Routes => routes::draw(ui, state, plan, out),
        PlanPage::Handover => handover::draw(ui, state, out),
        PlanPage::Task => task::draw(ui, state, out),
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
    match pages(ui, state, out) {
        PlanPage::Task => task::draw(ui, state, out),
        PlanPage::Settings => settings::draw(ui, state, out),
        PlanPage::Handover => handover::draw(ui, state, out),
        _ => {
            tried::draw(ui, state, out);
            tried::details(ui, refusal);
        }
    }
}

/// The row of pages; gives the open one.
fn pages(ui: &mut Ui, state: &ViewerState, out: &mut Out) -> PlanPage {
    let pages = state.plan_pages();
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
