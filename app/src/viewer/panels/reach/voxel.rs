//! The chosen voxel: how freely the hand moves there, and every orientation in which it is reached.

use egui::{Align, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::reach::ReachMap;
use nalgebra::Isometry3;

use crate::viewer::icons::Icon;
use crate::viewer::panels::Out;
use crate::viewer::panels::scene::at;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::{focus_ring, icon_button, key_value, paragraph, section, segmented, text_in};
use crate::viewer::{Command, ReachCommand, ViewerState, VoxelChoice, format};

const ROW: f32 = 26.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let maps = &state.reaching;
    let chosen = maps.chosen();
    let shown = chosen.and_then(|chosen| Some((chosen, maps.map(chosen.arm)?, state.map_base(chosen.arm)?)));
    let Some((chosen, map, X_WB)) = shown else {
        let text = "Click a voxel in the view: the robot shows how it reaches there, and every orientation of the hand \
                    is listed here.";
        let _text = paragraph(ui, text, BODY, tokens.secondary);
        return;
    };
    let across = state.voxel_across();
    ui.horizontal(|ui| {
        if across.is_some() {
            if segmented(ui, "Arm", &["Left arm", "Right arm"], Some(chosen.arm)).is_some_and(|arm| arm != chosen.arm) {
                out.push(Command::Reach(ReachCommand::SwitchArm));
            }
        } else {
            let others = ["Left arm; the right one does not reach it", "Right arm; the left one does not reach it"];
            let arm = if state.reaching.view.arms.needs(1 - chosen.arm) {
                others[chosen.arm]
            } else {
                ["Left arm", "Right arm"][chosen.arm]
            };
            let _text = ui.label(egui::RichText::new(arm).font(font(BODY)).color(tokens.text));
        }
    });
    ui.add_space(4.0);
    let reached = maps.orientations(chosen.arm, chosen.voxel);
    let count = map.orientations().count();
    let _row = key_value(ui, "Position", &at(&(X_WB * map.center(chosen.voxel))));
    let _row = key_value(ui, "Orientations reached", &format!("{} of {count}", reached.len()));
    let _row = key_value(ui, "Fraction", &format!("{:.1} %", 100.0 * map.fraction(chosen.voxel)));
    let mean = format::manipulability(map.mean_manipulability(chosen.voxel));
    let _row = key_value(ui, "Mean manipulability", &mean);
    let best = reached.first().and_then(|&orientation| map.manipulability(chosen.voxel, orientation));
    let _row = key_value(ui, "Best manipulability", &format::manipulability(best.unwrap_or(0.0)));

    section(ui, "The hand comes");
    let here = reached.iter().position(|&orientation| orientation == chosen.orientation);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let several = reached.len() > 1;
        if icon_button(ui, Icon::Left, "Orientation before", several, false).clicked() {
            out.push(Command::Reach(ReachCommand::NextOrientation { forth: false }));
        }
        let text = format!("{} of {}, best first", here.map_or(0, |here| here + 1), reached.len());
        let text = egui::RichText::new(text).font(font(SECONDARY)).color(tokens.secondary);
        let _text = ui.add_sized(vec2(128.0, 28.0), egui::Label::new(text));
        if icon_button(ui, Icon::Right, "Next orientation", several, false).clicked() {
            out.push(Command::Reach(ReachCommand::NextOrientation { forth: true }));
        }
    });
    ui.add_space(2.0);
    for &orientation in &reached {
        row(ui, map, &X_WB, VoxelChoice { orientation, ..chosen }, orientation == chosen.orientation, out);
    }
}

/// From where the hand comes, and its manipulability; a click shows the robot so.
fn row(ui: &mut Ui, map: &ReachMap, X_WB: &Isometry3<f64>, choice: VoxelChoice, is_shown: bool, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let full = rect.expand2(vec2(13.0, 0.0));
    if is_shown {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let pose = map.pose(choice.voxel, choice.orientation).unwrap_or_default();
    let words = format!("{}, {}", format::approach(&(X_WB * pose)), format::closing(&(X_WB * pose)));
    let value = map.manipulability(choice.voxel, choice.orientation).map_or_else(String::new, format::manipulability);
    let name = Rect::from_min_max(rect.min, pos2(rect.right() - 64.0, rect.bottom()));
    let id = if is_shown { strong(BODY) } else { font(BODY) };
    let _text = text_in(ui, name, Align::Min, &words, id, tokens.text);
    let _text = text_in(ui, rect, Align::Max, &value, font(SECONDARY), tokens.secondary);
    let spoken = format!("Orientation {}: hand {words}, manipulability {value}", choice.orientation + 1);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_shown, &spoken));
    focus_ring(ui, &response, full);
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        out.push(Command::Reach(ReachCommand::Orientation(choice.orientation)));
    }
}
