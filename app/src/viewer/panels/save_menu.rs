//! The small button beside a table or a plot that saves it.

use egui::{Align, Layout, Ui, vec2};

use super::Out;
use crate::export::{PlotKind, TableFormat, TableKind};
use crate::viewer::fields::menu;
use crate::viewer::icons::Icon;
use crate::viewer::widgets::{icon_button, section};
use crate::viewer::{Command, Saved};

/// A heading with the button at its end; `plot` is what is plotted below it, if anything is.
pub(super) fn saved_section(ui: &mut Ui, text: &str, kind: TableKind, plot: Option<PlotKind>, out: &mut Out) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        let width = ui.available_width() - 28.0;
        ui.allocate_ui_with_layout(vec2(width, 0.0), Layout::top_down(Align::Min), |ui| {
            ui.set_width(width);
            section(ui, text);
        });
        ui.with_layout(Layout::bottom_up(Align::Max), |ui| save_button(ui, kind, plot, out));
    });
}

/// The button; a click folds out what can be saved.
pub(super) fn save_button(ui: &mut Ui, kind: TableKind, plot: Option<PlotKind>, out: &mut Out) {
    let mut choices: Vec<Saved> = TableFormat::ALL.map(|format| Saved::Table(kind, format)).into();
    choices.extend(plot.map(Saved::Plot));
    let button = icon_button(ui, Icon::Save, &format!("Save: {}", kind.title()), true, false);
    let rows: Vec<&str> = choices.iter().map(|saved| saved.title()).collect();
    if let Some(index) = menu(&button, &rows, None) {
        out.push(Command::Save(choices[index]));
    }
}
