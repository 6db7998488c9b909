//! The fit lab: how well a superquadric explains its cluster, how it was found, and what else it could be.

mod compare;
mod cost;
mod histogram;
mod result;
mod search;
mod settings;
mod shape;

use egui::Ui;
use endcomfort_core::job::Stage;

use super::Out;
use super::inspector::{heading, nothing_yet};
use crate::viewer::fields::tabs;
use crate::viewer::icons::Icon;
use crate::viewer::theme::{BODY, SECONDARY, Tokens};
use crate::viewer::widgets::{icon_button, paragraph, segmented_wide};
use crate::viewer::{Command, FitView, LabCommand, LabPage, ViewerState};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (Some(output), Some(shown)) = (&state.outputs.fit, state.examined_cluster()) else {
        return nothing_yet(ui, state, Stage::Fit);
    };
    let count = output.fits.len();
    let by_hand = state.document.shape.is_some_and(|shape| shape.cluster == shown);
    let role = match (shown == output.target, by_hand) {
        (true, false) => "It will be grasped.",
        (true, true) => "Its shape is set by hand. It will be grasped.",
        (false, false) => "An obstacle for the hand and the arm.",
        (false, true) => "Its shape is set by hand. An obstacle for the hand and the arm.",
    };
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = ui.available_width() - if count > 1 { 112.0 } else { 0.0 };
        ui.allocate_ui_with_layout(egui::vec2(width, 0.0), egui::Layout::top_down(egui::Align::Min), |ui| {
            ui.set_width(width);
            let text = format!("Superquadric of cluster {}", shown + 1);
            if state.is_dragging_shape() {
                // Answers come and go many times a second: a sentence about each would flicker.
                crate::viewer::widgets::title(ui, &text);
                let _text = paragraph(ui, role, SECONDARY, tokens.secondary);
                ui.add_space(6.0);
            } else {
                heading(ui, state, Stage::Fit, &text, role);
            }
        });
        if count > 1 {
            if icon_button(ui, Icon::Left, "Cluster before", shown > 0, false).clicked() {
                out.push(Command::SelectCluster(shown - 1));
            }
            let text = egui::RichText::new(format!("{} of {count}", shown + 1)).color(tokens.secondary);
            let _text = ui.add_sized(egui::vec2(42.0, 28.0), egui::Label::new(text));
            if icon_button(ui, Icon::Right, "Next cluster", shown + 1 < count, false).clicked() {
                out.push(Command::SelectCluster(shown + 1));
            }
        }
    });
    let fit = match output.fits.get(shown) {
        Some(Ok(fit)) => fit,
        Some(Err(reason)) => {
            let _text = paragraph(ui, reason, BODY, tokens.coral);
            ui.add_space(8.0);
            return settings::draw(ui, state, out);
        }
        None => return,
    };
    let words = FitView::ALL.map(FitView::title);
    let chosen = state.lab_key().map(|lab| lab.view as usize);
    if let Some(index) = segmented_wide(ui, "Drawn as", &words, chosen) {
        out.push(Command::Lab(LabCommand::View(FitView::ALL[index])));
    }
    ui.add_space(6.0);
    let open = state.lab.page as usize;
    if let Some(index) = tabs(ui, &LabPage::ALL.map(LabPage::title), Some(open)) {
        out.push(Command::Lab(LabCommand::Page(LabPage::ALL[index])));
    }
    match state.lab.page {
        LabPage::Result => result::draw(ui, state, fit, out),
        LabPage::Shape => shape::draw(ui, state, fit, out),
        LabPage::Search => search::draw(ui, state, fit, out),
        LabPage::Settings => settings::draw(ui, state, out),
    }
}
