//! The robot that somebody brought: its arms, its hands, and the meshes that are missing.

use egui::Ui;

use super::Out;
use crate::assets;
use crate::viewer::theme::{SECONDARY, Tokens};
use crate::viewer::widgets::{key_value, paragraph, secondary_button, section};
use crate::viewer::{BringCommand, Command, ViewerState};

/// Missing meshes that are listed by name; the rest is counted.
const MOST_LISTED: usize = 8;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let Some(guest) = assets::library().guest(&state.document.scene.robot) else { return };
    let tokens = Tokens::of(ui);
    section(ui, "Your robot");
    for arm in &guest.robot.description.arms {
        let hand = arm.hand.as_ref().map_or("its own fingers", |hand| &hand.name);
        let title = if arm.name == "left" { "Left arm" } else { "Right arm" };
        let _row = key_value(ui, title, &format!("{} to {}, {hand}", arm.base_link, arm.tip_link));
    }
    if guest.robot.description.arms.is_empty() {
        let _row = key_value(ui, "Arms", "as its SRDF names them");
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        if secondary_button(ui, "Arms and hands…", true).clicked() {
            out.push(Command::Bring(BringCommand::OpenRobot));
        }
        if secondary_button(ui, "Save the choice", true).clicked() {
            out.push(Command::Bring(BringCommand::SaveChoice));
        }
    });
    if guest.missing.is_empty() {
        return;
    }
    section(ui, "Missing meshes");
    let count = guest.missing.len();
    let text = match count {
        1 => "A marked box is drawn in place of a body, for want of this file:".to_owned(),
        count => format!("Marked boxes are drawn in place of {count} bodies, for want of these files:"),
    };
    let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
    let mut files: Vec<&str> = guest.missing.iter().map(|missing| missing.file.as_str()).collect();
    files.sort_unstable();
    files.dedup();
    for file in files.iter().take(MOST_LISTED) {
        let _text = paragraph(ui, file, SECONDARY, tokens.coral);
    }
    if files.len() > MOST_LISTED {
        let _text = paragraph(ui, &format!("and {} more", files.len() - MOST_LISTED), SECONDARY, tokens.coral);
    }
}
