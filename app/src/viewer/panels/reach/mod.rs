//! Reachability maps: how they are shown, the chosen voxel, what the maps are and how others are built.

mod map;
mod shown;
mod voxel;

use egui::Ui;

use super::Out;
use crate::viewer::fields::tabs;
use crate::viewer::icons::Icon;
use crate::viewer::reach::ARMS;
use crate::viewer::theme::{BODY, SECONDARY, Tokens};
use crate::viewer::widgets::{icon_button, paragraph, title};
use crate::viewer::{Command, ReachCommand, ReachPage, Slot, ViewerState};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = ui.available_width() - 32.0;
        ui.allocate_ui_with_layout(egui::vec2(width, 0.0), egui::Layout::top_down(egui::Align::Min), |ui| {
            ui.set_width(width);
            title(ui, "Reachability");
            let sentence = format!("Where the hands of {} can be, and how freely.", state.robot_title());
            let _text = paragraph(ui, &sentence, SECONDARY, tokens.secondary);
        });
        if icon_button(ui, Icon::Cross, "Close Reachability", true, false).clicked() {
            out.push(Command::Reach(ReachCommand::Close));
        }
    });
    ui.add_space(6.0);
    for (arm, name) in ARMS.iter().enumerate().filter(|(arm, _)| state.reaching.view.arms.needs(*arm)) {
        match state.reaching.slot(arm) {
            Slot::Awaited(_) => {
                let text = format!("The map of the {name} arm is on its way.");
                let _text = paragraph(ui, &text, BODY, tokens.teal_text);
            }
            Slot::Missing(_) if state.map_under_way().is_none() => {
                let text = format!("No map of the {name} arm is here yet.");
                let _text = paragraph(ui, &text, BODY, tokens.coral);
            }
            Slot::Missing(_) | Slot::Empty | Slot::Here(_) => {}
        }
    }
    let open = ReachPage::ALL.iter().position(|page| *page == state.reaching.page);
    if let Some(index) = tabs(ui, &ReachPage::ALL.map(ReachPage::title), open) {
        out.push(Command::Reach(ReachCommand::Page(ReachPage::ALL[index])));
    }
    match state.reaching.page {
        ReachPage::View => shown::draw(ui, state, out),
        ReachPage::Voxel => voxel::draw(ui, state, out),
        ReachPage::Map => map::draw(ui, state, out),
    }
}

fn explain(ui: &mut Ui, text: &str) {
    let tokens = Tokens::of(ui);
    ui.add_space(3.0);
    let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
}
