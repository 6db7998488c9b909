//! The small button beside a table or a plot that saves it.

use egui::{Rect, Response, Ui, pos2, vec2};

use super::Out;
use crate::export::{PlotKind, TableFormat, TableKind};
use crate::viewer::fields::menu;
use crate::viewer::icons::Icon;
use crate::viewer::widgets::{icon_button, icon_button_at, section};
use crate::viewer::{Command, Saved};

/// Side of the button in a heading, points.
const SIDE: f32 = 24.0;
/// From the middle of a heading's words to whatever comes below, points.
const BELOW: f32 = 12.0;

/// A heading with the button at its end; `plot` is what is plotted below it, if anything is.
pub(super) fn saved_section(ui: &mut Ui, text: &str, kind: TableKind, plot: Option<PlotKind>, out: &mut Out) {
    section(ui, text);
    let below = ui.cursor();
    let right = below.left() + ui.available_width();
    let middle = pos2(right - 0.5 * SIDE - 2.0, below.top() - BELOW);
    let rect = Rect::from_center_size(middle, vec2(SIDE, SIDE));
    let button = icon_button_at(ui, rect, Icon::Save, &name(kind), true);
    choose(&button, kind, plot, out);
}

/// The button alone.
pub(super) fn save_button(ui: &mut Ui, kind: TableKind, plot: Option<PlotKind>, out: &mut Out) {
    let button = icon_button(ui, Icon::Save, &name(kind), true, false);
    choose(&button, kind, plot, out);
}

fn name(kind: TableKind) -> String {
    format!("Save: {}", kind.title())
}

/// A click on the button folds out what can be saved.
fn choose(button: &Response, kind: TableKind, plot: Option<PlotKind>, out: &mut Out) {
    let mut choices: Vec<Saved> = TableFormat::ALL.map(|format| Saved::Table(kind, format)).into();
    choices.extend(plot.map(Saved::Plot));
    let rows: Vec<&str> = choices.iter().map(|saved| saved.title()).collect();
    if let Some(index) = menu(button, &rows, None) {
        out.push(Command::Save(choices[index]));
    }
}
