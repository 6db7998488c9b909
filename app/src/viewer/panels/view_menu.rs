//! The menu of the view: where to look from, how, and the views that were kept.

use egui::{Popup, Ui};

use super::Out;
use crate::render::{Named, Projection};
use crate::viewer::fields::menu_row;
use crate::viewer::icons::Icon;
use crate::viewer::widgets::{hairline, icon_button, segmented_wide};
use crate::viewer::{Command, Turning, ViewCommand, ViewerState};

/// Widths of the menu, points.
const WIDTH: f32 = 236.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let response = icon_button(ui, Icon::Frame, "View", true, false);
    Popup::menu(&response).gap(6.0).width(WIDTH).close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside).show(
        |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let mut asked = None;
            if menu_row(ui, "Frame everything  (F)", false) {
                asked = Some(Command::View(ViewCommand::FrameAll));
            }
            if menu_row(ui, "Look at the object  (C)", false) {
                asked = Some(Command::View(ViewCommand::FrameObject));
            }
            if menu_row(ui, "Follow the object  (O)", state.playback.follows) {
                asked = Some(Command::ToggleFollow);
            }
            hairline(ui);
            let projections = [Projection::Perspective, Projection::Orthographic];
            let chosen = projections.iter().position(|one| *one == state.viewing.projection);
            if let Some(index) = segmented_wide(ui, "Projection", &["Perspective", "Orthographic"], chosen) {
                out.push(Command::View(ViewCommand::Project(projections[index])));
            }
            ui.add_space(4.0);
            let chosen = Turning::ALL.iter().position(|one| *one == state.viewing.turning);
            if let Some(index) = segmented_wide(ui, "Turning", &Turning::ALL.map(Turning::title), chosen) {
                out.push(Command::View(ViewCommand::Turn(Turning::ALL[index])));
            }
            hairline(ui);
            for named in Named::ALL {
                if menu_row(ui, named.title(), false) {
                    asked = Some(Command::View(ViewCommand::Look(named)));
                }
            }
            hairline(ui);
            if menu_row(ui, "Keep this view  (K)", false) {
                asked = Some(Command::View(ViewCommand::Keep));
            }
            for kept in &state.viewing.kept {
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 0.0;
                    let room = egui::vec2(ui.available_width() - 30.0, 30.0);
                    ui.allocate_ui(room, |ui| {
                        if menu_row(ui, &kept.title(), false) {
                            asked = Some(Command::View(ViewCommand::Recall(kept.id)));
                        }
                    });
                    if icon_button(ui, Icon::Cross, &format!("Forget {}", kept.title()), true, false).clicked() {
                        out.push(Command::View(ViewCommand::Forget(kept.id)));
                    }
                });
            }
            if let Some(command) = asked {
                out.push(command);
                ui.close();
            }
        },
    );
}
