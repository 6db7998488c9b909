//! Candidates and ranking, page by page.

mod arcs;
mod filter;
mod ik_set;
mod list;
mod order;
mod selected;
mod settings;
mod table;

use egui::{Align, Layout, Ui, vec2};
use endcomfort_core::grasp::{ExportFormat, RankBy};
use endcomfort_core::job::Stage;

use super::Out;
use super::inspector::{heading, nothing_yet};
use crate::viewer::fields::{menu, tabs};
use crate::viewer::icons::Icon;
use crate::viewer::theme::{SECONDARY, Tokens};
use crate::viewer::widgets::{icon_button, paragraph};
use crate::viewer::{Command, GraspCommand, GraspPage, ViewerState, format};

/// Room for the scroll bar, points.
const SCROLL_BAR: f32 = 11.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, stage: Stage, out: &mut Out) {
    let outputs = &state.outputs;
    let has_result = if stage == Stage::Rank { outputs.is_ranked() } else { outputs.grasps.is_some() };
    if !has_result {
        return nothing_yet(ui, state, stage);
    }
    top(ui, state, stage, out);
    let pages = GraspPage::of(stage);
    let open = state.grasp_page(stage);
    let titles: Vec<&str> = pages.iter().map(|page| page.title()).collect();
    if let Some(index) = tabs(ui, &titles, pages.iter().position(|&page| page == open)) {
        out.push(Command::Grasping(GraspCommand::Page(pages[index])));
    }
    match open {
        GraspPage::Table => list::draw(ui, state, out),
        page => scrolled(ui, page, |ui| match page {
            GraspPage::Fates => list::fates(ui, state, out),
            GraspPage::Grasp => selected::draw(ui, state, out),
            GraspPage::Settings => settings::draw(ui, state, out),
            GraspPage::Filter => filter::draw(ui, state, out),
            GraspPage::Order => order::draw(ui, state, out),
            GraspPage::Table => {}
        }),
    }
}

/// A page that scrolls; the bar stands in the panel's margin, beside the numbers and not over them.
fn scrolled(ui: &mut Ui, page: GraspPage, add: impl FnOnce(&mut Ui)) {
    let (inside, width) = (ui.available_rect_before_wrap(), ui.available_width());
    let beside = inside.with_max_x(inside.right() + SCROLL_BAR);
    let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(beside));
    egui::ScrollArea::vertical().id_salt(page.title()).auto_shrink(false).show(&mut ui, |ui| {
        ui.set_max_width(width);
        add(ui);
        ui.add_space(8.0);
    });
}

/// The heading with the way out of the program beside it.
fn top(ui: &mut Ui, state: &ViewerState, stage: Stage, out: &mut Out) {
    let (title, sentence) = said(state, stage);
    ui.horizontal_top(|ui| {
        let width = ui.available_width() - 36.0;
        ui.allocate_ui_with_layout(vec2(width, 0.0), Layout::top_down(Align::Min), |ui| {
            ui.set_width(width);
            heading(ui, state, stage, &title, &sentence);
        });
        let can_save = state.outputs.is_ranked() && !state.is_stale(Stage::Rank);
        let button = icon_button(ui, Icon::Save, "Export the ranked grasps", can_save, false);
        if can_save {
            let rows = ["JSON, everything", "CSV, a table", "YAML, MoveIt messages"];
            if let Some(index) = menu(&button, &rows, None) {
                out.push(Command::Grasping(GraspCommand::Export(ExportFormat::ALL[index])));
            }
        }
    });
}

fn said(state: &ViewerState, stage: Stage) -> (String, String) {
    let grasps = state.outputs.candidates();
    if stage != Stage::Rank {
        let title = format!("{} candidates around the fit", format::count(grasps.len()));
        return (title, "Hand poses on the surface, fingers closed; each one that was dropped says why.".to_owned());
    }
    let accepted = grasps.iter().filter(|grasp| grasp.is_accepted()).count();
    let has_goal = state.has_goal();
    let places = if has_goal { "both poses" } else { "the object" };
    let reach = if accepted == 1 { "grasp reaches" } else { "grasps reach" };
    let order = match (state.scene().rank.by, has_goal) {
        (RankBy::Goal, true) => "manipulability where the object is put down: the end-comfort effect",
        (RankBy::Mean, true) => "manipulability, the mean of start and goal",
        (RankBy::Goal | RankBy::Start | RankBy::Mean, _) => "manipulability where the object stands",
        (RankBy::Score, _) => "the weighted score",
        (RankBy::Epsilon, _) => "the largest-ball quality ε alone, a control",
        (RankBy::Random, _) => "a random order, a control",
    };
    (format!("{} {reach} {places}", format::count(accepted)), format!("Ranked by {order}."))
}

/// A sentence under a field.
fn explain(ui: &mut Ui, text: &str) {
    let tokens = Tokens::of(ui);
    ui.add_space(2.0);
    let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
}
