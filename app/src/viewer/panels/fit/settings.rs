//! What the fit is asked.

use egui::Ui;
use endcomfort_core::fit::{DeformMode, FitSettings, MirrorMode, ObjectiveKind};

use super::compare::formula;
use crate::viewer::number::{Number, Touch, number};
use crate::viewer::panels::Out;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{paragraph, section, segmented_wide, switch};
use crate::viewer::{Command, LabCommand, ViewerState, objective_title};

const MIRRORS: [MirrorMode; 3] = [MirrorMode::Auto, MirrorMode::On, MirrorMode::Off];
const DEFORMATIONS: [DeformMode; 5] =
    [DeformMode::None, DeformMode::Taper, DeformMode::Bend, DeformMode::Both, DeformMode::Auto];
/// Parts that can be asked for.
const PARTS: [&str; 6] = ["1", "2", "3", "4", "5", "6"];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let present = &state.document.scene.fit;
    let mut wanted = present.clone();

    section(ui, "Minimised");
    let words = ObjectiveKind::ALL.map(objective_title);
    let chosen = ObjectiveKind::ALL.iter().position(|&objective| objective == present.objective);
    if let Some(index) = segmented_wide(ui, "Objective", &words, chosen) {
        wanted.objective = ObjectiveKind::ALL[index];
    }
    explain(ui, formula(present.objective));

    section(ui, "Points");
    ui.horizontal(|ui| {
        let field =
            Number { name: "Voxel size, mm", unit: "mm", decimals: 1, per_point: 0.1, tip: "0 takes every point" };
        if let Touch::Released(voxel_mm) | Touch::Set(voxel_mm) = number(ui, &field, 1e3 * present.voxel_m, 96.0) {
            wanted.voxel_m = 1e-3 * voxel_mm.max(0.0).min(100.0);
        }
        let _text = ui.label(egui::RichText::new("voxel size").font(font(BODY)).color(tokens.text));
    });
    ui.add_space(2.0);
    if switch(ui, "Coarse to fine", present.hierarchical) {
        wanted.hierarchical = !present.hierarchical;
    }
    if switch(ui, "Leave out points that nothing explains", present.reject_outliers) {
        wanted.reject_outliers = !present.reject_outliers;
    }
    explain(
        ui,
        if present.hierarchical {
            "From 30 mm voxels down to 5 mm, each level started from the one before; the voxel size above is not used."
        } else {
            "The cloud is thinned to one point per voxel. Small objects get a finer grid on their own."
        },
    );

    section(ui, "Mirror the unseen side");
    let chosen = MIRRORS.iter().position(|&mode| mode == present.mirror);
    if let Some(index) = segmented_wide(ui, "Mirror", &["When sure", "Always", "Never"], chosen) {
        wanted.mirror = MIRRORS[index];
    }
    explain(
        ui,
        match present.mirror {
            MirrorMode::Auto => "Across a plane of symmetry that the camera does not contradict, if there is one.",
            MirrorMode::On => "A cluster without such a plane is refused.",
            MirrorMode::Off => "The measured side speaks alone.",
        },
    );

    section(ui, "Deformation");
    let chosen = DEFORMATIONS.iter().position(|&mode| mode == present.deform);
    if let Some(index) = segmented_wide(ui, "Deformation", &["None", "Taper", "Bend", "Both", "Auto"], chosen) {
        wanted.deform = DEFORMATIONS[index];
    }
    explain(
        ui,
        match present.deform {
            DeformMode::None => "Superquadrics as they are (3.1).",
            DeformMode::Taper => "Sections across z are scaled by 1 + K z/c.",
            DeformMode::Bend => "The axis is bent in the y–z plane.",
            DeformMode::Both => "Tapered, then bent.",
            DeformMode::Auto => "Whatever the information criterion prefers, plain if nothing helps.",
        },
    );

    section(ui, "Parts of one object, at most");
    let chosen = present.max_parts.checked_sub(1).filter(|&index| index < PARTS.len());
    if let Some(index) = segmented_wide(ui, "Parts at most", &PARTS, chosen) {
        wanted.max_parts = index + 1;
    }
    explain(ui, "More than one: a body with a handle becomes two superquadrics if the criterion prefers it.");

    ui.add_space(10.0);
    let is_default = *present == FitSettings::default();
    if crate::viewer::widgets::secondary_button(ui, "Settings of the thesis", !is_default).clicked() {
        wanted = FitSettings::default();
    }
    if wanted != *present {
        out.push(Command::Lab(LabCommand::Settings(wanted)));
    }
}

fn explain(ui: &mut Ui, text: &str) {
    let tokens = Tokens::of(ui);
    ui.add_space(2.0);
    let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
}
