//! The menu of the view: where to look from, how, and the views that were kept.

use egui::{Popup, Ui};

use super::Out;
use crate::render::{Cut, Named, Projection};
use crate::viewer::fields::menu_row;
use crate::viewer::icons::Icon;
use crate::viewer::slider::slider;
use crate::viewer::widgets::{hairline, icon_button, segmented_wide, switch};
use crate::viewer::{Command, Followed, LookCommand, Turning, ViewCommand, ViewerState};

/// Along each axis, from where to where a cut can be moved, and where it is at first, metres: the workspace.
const CUT_M: [[f64; 3]; 3] = [[-0.8, 1.6, 0.5], [-1.4, 1.4, 0.0], [0.0, 2.0, 0.8]];
/// Widths of the menu, points.
const WIDTH: f32 = 304.0;

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
            let follows = state.playback.follows;
            if menu_row(ui, "Follow the object  (O)", follows == Some(Followed::Object)) {
                asked = Some(Command::Follow(Followed::Object));
            }
            for (hand, title) in state.hands_to_follow() {
                if menu_row(ui, &title, follows == Some(hand)) {
                    asked = Some(Command::Follow(hand));
                }
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
            if menu_row(ui, "Measure  (M)", state.looking.measured.is_some()) {
                asked = Some(Command::Look(LookCommand::Measure(state.looking.measured.is_none())));
            }
            cut(ui, state, out);
            hairline(ui);
            for pair in Named::ALL.chunks(2) {
                ui.columns(2, |columns| {
                    for (column, named) in columns.iter_mut().zip(pair) {
                        if menu_row(column, named.title(), false) {
                            asked = Some(Command::View(ViewCommand::Look(*named)));
                        }
                    }
                });
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

/// Where the view is cut open.
fn cut(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    ui.add_space(4.0);
    let now = state.looking.cut;
    let chosen = now.map_or(0, |cut| cut.axis + 1);
    if let Some(index) = segmented_wide(ui, "Cut", &["No cut", "x", "y", "z"], Some(chosen)) {
        let cut = index.checked_sub(1).map(|axis| Cut { axis, at_m: CUT_M[axis][2], keeps_above: false });
        out.push(Command::Look(LookCommand::Cut(cut)));
    }
    let Some(cut) = now else { return };
    let [least, most, _] = CUT_M[cut.axis];
    let words = format!("{:.2} m", cut.at_m).replace('-', "–");
    if let Some(at_m) = slider(ui, "Place of the cut", &words, cut.at_m, [least, most]) {
        out.push(Command::Look(LookCommand::Cut(Some(Cut { at_m, ..cut }))));
    }
    if switch(ui, "Take away the other side", cut.keeps_above) {
        out.push(Command::Look(LookCommand::Cut(Some(Cut { keeps_above: !cut.keeps_above, ..cut }))));
    }
    ui.add_space(4.0);
}
