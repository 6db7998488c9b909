//! What the maps are, and how others are built.

use egui::{Align, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::job::MapMethod;

use super::explain;
use crate::export::TableKind;
use crate::viewer::number::{Number, number_row};
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::reach::ARMS;
use crate::viewer::theme::{SECONDARY, Tokens, font};
use crate::viewer::widgets::{
    key_value, paragraph, primary_button, secondary_button, section, segmented_wide, switch, text_in,
};
use crate::viewer::{Command, MapSource, ReachCommand, ShownMap, Slot, ViewerState, format};

const VOXELS_M: [f64; 2] = [0.05, 0.025];
const ORIENTATIONS: [usize; 2] = [40, 272];
/// Configurations that a forward map draws unless it is told otherwise.
const SAMPLES: usize = 5_000_000;
const MILLION: f64 = 1e6;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let is_needed = |arm: &usize| state.reaching.view.arms.needs(*arm);
    // One table holds the voxels of both arms.
    let saved = (0..ARMS.len()).filter(is_needed).find(|arm| state.reaching.map(*arm).is_some());
    for (arm, name) in ARMS.iter().enumerate().filter(|(arm, _)| is_needed(arm)) {
        let title = format!("{name} arm");
        if saved == Some(arm) {
            saved_section(ui, &title, TableKind::Voxels, None, out);
        } else {
            section(ui, &title);
        }
        match state.reaching.slot(arm) {
            Slot::Here(shown) => facts(ui, arm, shown, out),
            Slot::Missing(reason) => {
                let tokens = Tokens::of(ui);
                let _text = paragraph(ui, &format!("None yet: {reason}. Build it below."), SECONDARY, tokens.coral);
            }
            Slot::Awaited(path) => explain(ui, &format!("{path} is on its way.")),
            Slot::Empty => {}
        }
    }
    build(ui, state, out);
}

fn facts(ui: &mut Ui, arm: usize, shown: &ShownMap, out: &mut Out) {
    let ShownMap { map, bytes, name, source } = shown;
    let source = match source {
        MapSource::Stored => format!("{name}, stored"),
        MapSource::File => format!("{name}, opened"),
        MapSource::Built { elapsed_ms } => format!("built here in {}", format::elapsed(*elapsed_ms)),
    };
    let _row = key_value(ui, "File", &source);
    let voxels = format!("{} of {} cm", format::count(map.voxels().count()), centimetres(map.voxel_m()));
    let _row = key_value(ui, "Voxels", &voxels);
    let poses = format!("{}, {} orientations", format::count(map.reached_poses()), map.orientations().count());
    let _row = key_value(ui, "Poses", &poses);
    let _row = key_value(ui, "Method", &map.about().method.to_string());
    let _row = key_value(ui, "Size", &format!("{} kB", format::count(bytes.len().div_ceil(1000))));
    if matches!(shown.source, MapSource::Built { .. }) {
        ui.add_space(4.0);
        if secondary_button(ui, &format!("Save {name}"), true).clicked() {
            out.push(Command::Reach(ReachCommand::Save { arm }));
        }
    }
}

fn centimetres(metres: f64) -> String {
    format!("{:.1}", 100.0 * metres).trim_end_matches(".0").to_owned()
}

fn build(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let present = &state.reaching.wanted;
    let mut wanted = present.clone();
    section(ui, "Build another");
    let chosen = VOXELS_M.iter().position(|voxel_m| *voxel_m == present.voxel_m);
    if let Some(index) = segmented_wide(ui, "Voxels", &["5 cm voxels", "2.5 cm voxels"], chosen) {
        wanted.voxel_m = VOXELS_M[index];
    }
    ui.add_space(4.0);
    let chosen = ORIENTATIONS.iter().position(|count| *count == present.orientations);
    if let Some(index) = segmented_wide(ui, "Orientations", &["40 orientations", "272 orientations"], chosen) {
        wanted.orientations = ORIENTATIONS[index];
    }
    ui.add_space(4.0);
    let is_forward = present.method != MapMethod::Inverse;
    if let Some(index) = segmented_wide(ui, "Method", &["Inverse", "Forward"], Some(usize::from(is_forward))) {
        wanted.method = if index == 0 { MapMethod::Inverse } else { MapMethod::Forward { samples: SAMPLES } };
    }
    match present.method {
        MapMethod::Inverse => explain(ui, "Every pose is solved for the joints in closed form."),
        MapMethod::Forward { samples } => {
            explain(ui, "Configurations are drawn and sorted into the poses that they reach; for any arm.");
            ui.add_space(4.0);
            let tip = "More samples find more of the poses at the rim; at most 16 million.";
            let field = Number { name: "Samples, million", unit: "M", decimals: 1, per_point: 0.1, tip };
            if let Some(millions) = number_row(ui, &field, samples as f64 / MILLION, "samples") {
                let samples = (MILLION * millions.max(0.1).min(16.0)) as usize;
                wanted.method = MapMethod::Forward { samples };
            }
        }
    }
    if state.has_torso() && switch(ui, "With the torso", present.torso) {
        wanted.torso = !present.torso;
    }
    ui.add_space(8.0);
    if let Some((fraction, note)) = state.map_under_way() {
        progress(ui, fraction, note);
        ui.add_space(6.0);
        if secondary_button(ui, "Cancel the build", true).clicked() {
            out.push(Command::Cancel);
        }
    } else {
        let count = (0..2).filter(|&arm| state.reaching.view.arms.needs(arm)).count();
        let text = if count == 1 { "Build the map" } else { "Build both maps" };
        if primary_button(ui, text, !state.running).clicked() {
            out.push(Command::Reach(ReachCommand::Build));
        }
        if state.running {
            explain(ui, "It waits until the steps on the left are done.");
        }
    }
    if wanted != *present {
        out.push(Command::Reach(ReachCommand::Settings(wanted)));
    }
}

/// How far the maps are.
fn progress(ui: &mut Ui, fraction: f64, note: &str) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::hover());
    let text = format!("{:.0} %", 100.0 * fraction);
    response.widget_info(|| WidgetInfo::labeled(Role::ProgressIndicator, true, format!("Maps built: {text}, {note}")));
    let line = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - 8.0));
    let _text = text_in(ui, line, Align::Min, note, font(SECONDARY), tokens.secondary);
    let _text = text_in(ui, line, Align::Max, &text, font(SECONDARY), tokens.teal_text);
    let track = Rect::from_min_max(pos2(rect.left(), rect.bottom() - 5.0), rect.max);
    ui.painter().rect_filled(track, 2.0, tokens.well);
    let done = track.with_max_x(track.left() + track.width() * fraction as f32);
    ui.painter().rect_filled(done, 2.0, tokens.teal);
}
