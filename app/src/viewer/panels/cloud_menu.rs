//! How the points of the cloud are drawn: what colours them, and how large they are.

use egui::{Popup, PopupCloseBehavior, Response};

use super::Out;
use crate::viewer::fields::menu_row;
use crate::viewer::looking::POINT_MM;
use crate::viewer::slider::slider;
use crate::viewer::widgets::section;
use crate::viewer::{CloudColor, Command, LookCommand, ViewerState};

const WIDTH: f32 = 240.0;

/// The menu that a button folds out.
pub(super) fn draw(button: &Response, state: &ViewerState, out: &mut Out) {
    let close = PopupCloseBehavior::CloseOnClickOutside;
    Popup::menu(button).gap(6.0).width(WIDTH).close_behavior(close).show(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        section(ui, "Points are coloured by");
        let has = |by: CloudColor| {
            let Some(scene) = &state.outputs.scene else { return by == CloudColor::Fate };
            match by {
                CloudColor::Fate | CloudColor::Height => true,
                CloudColor::Own => !scene.cloud.colors.is_empty(),
                CloudColor::Distance => scene.cloud.X_FC.is_some(),
            }
        };
        for by in CloudColor::ALL.into_iter().filter(|&by| has(by)) {
            if menu_row(ui, by.title(), state.looking.cloud.by == by) {
                out.push(Command::Look(LookCommand::Color(by)));
            }
        }
        section(ui, "Diameter of a point");
        let mm = 1e3 * f64::from(state.looking.cloud.diameter_m);
        let words = format!("{mm:.1} mm");
        if let Some(mm) = slider(ui, "Diameter of a point", &words, mm, [POINT_MM[0], POINT_MM[1]]) {
            out.push(Command::Look(LookCommand::PointSize(mm)));
        }
    });
}
