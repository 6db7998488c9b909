//! How the maps are shown.

use egui::{Align, Sense, Ui, vec2};

use super::explain;
use crate::compose::reach_scale;
use crate::viewer::fields::dropdown;
use crate::viewer::panels::Out;
use crate::viewer::slider::slider;
use crate::viewer::theme::{BODY, Tokens, font};
use crate::viewer::widgets::{secondary_button, section, segmented_wide, switch, text_in};
use crate::viewer::{Command, Keep, ReachArms, ReachCommand, ReachQuantity, ReachView, ViewerState, format};

/// Axes of the world with what they mean to the robot, and where planes across them may stand, metres.
const AXES: [(&str, [f64; 2]); 3] = [("x, forward", [-1.0, 1.4]), ("y, left", [-1.6, 1.6]), ("z, up", [0.0, 2.6])];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let present = state.reaching.view;
    let mut wanted = present;

    section(ui, "Voxels of");
    let chosen = ReachArms::ALL.iter().position(|arms| *arms == present.arms);
    if let Some(index) = segmented_wide(ui, "Voxels of", &ReachArms::ALL.map(ReachArms::title), chosen) {
        wanted.arms = ReachArms::ALL[index];
    }
    explain(
        ui,
        match present.arms {
            ReachArms::Left => "What the left arm reaches.",
            ReachArms::Right => "What the right arm reaches.",
            ReachArms::Both => "What either arm reaches; where both do, the greater value.",
            ReachArms::Overlap => "What both arms reach, with the smaller value: where one can hand to the other.",
        },
    );

    section(ui, "Colour");
    let chosen = ReachQuantity::ALL.iter().position(|quantity| *quantity == present.quantity);
    if let Some(index) = segmented_wide(ui, "Colour", &["Orientations reached", "Manipulability"], chosen) {
        wanted.quantity = ReachQuantity::ALL[index];
    }
    ui.add_space(4.0);
    if let Some(index) = segmented_wide(ui, "Scale", &["Linear", "Logarithmic"], Some(usize::from(present.is_log))) {
        wanted.is_log = index == 1;
    }
    explain(
        ui,
        match present.quantity {
            ReachQuantity::Fraction => "Share of the hand's orientations that the arm reaches in a voxel.",
            ReachQuantity::Manipulability => "Mean manipulability (5.1) of the reached orientations.",
        },
    );

    section(ui, "At least");
    let maps = (0..2).filter(|&arm| present.arms.needs(arm)).filter_map(|arm| state.reaching.map(arm));
    let most = reach_scale(maps, &ReachView { is_log: false, ..present }).max;
    if let Some(least) = slider(ui, "At least", &value(present.quantity, present.least), present.least, [0.0, most]) {
        wanted.least = least;
    }
    if switch(ui, "Opacity by value", present.fades) {
        wanted.fades = !present.fades;
    }

    section(ui, "Cut across");
    for (axis, (name, range)) in AXES.into_iter().enumerate() {
        let slice = &mut wanted.slices[axis];
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            let label = format!("Cut across {name}");
            let (place, _) = ui.allocate_exact_size(vec2(62.0, 28.0), Sense::hover());
            let ink = Tokens::of(ui).text;
            let _name = text_in(ui, place, Align::Min, name, font(BODY), ink);
            let rows = ["Nothing", "Keep what is before", "Keep what is beyond", "Keep one layer"];
            let shown = ["whole", "before", "beyond", "layer"];
            let chosen = Keep::ALL.iter().position(|keep| *keep == slice.keep);
            let word = chosen.map_or("", |index| shown[index]);
            if let Some(index) = dropdown(ui, &label, word, 84.0, &rows, chosen) {
                slice.keep = Keep::ALL[index];
            }
            if slice.keep != Keep::All {
                let label = format!("Plane across {name}");
                let words = format!("{:.2} m", slice.at_m);
                if let Some(at_m) = slider(ui, &label, &words, slice.at_m, range) {
                    slice.at_m = (200.0 * at_m).round() / 200.0;
                }
            }
        });
        ui.add_space(3.0);
    }

    ui.add_space(8.0);
    if secondary_button(ui, "As it was first", present != ReachView::default()).clicked() {
        wanted = ReachView::default();
    }
    if wanted != present {
        out.push(Command::Reach(ReachCommand::View(wanted)));
    }
}

/// A value of a quantity with its unit.
fn value(quantity: ReachQuantity, value: f64) -> String {
    match quantity {
        ReachQuantity::Fraction => format!("{:.0} %", 100.0 * value),
        ReachQuantity::Manipulability => format::manipulability(value),
    }
}
