//! The superquadric of a cluster, its errors and its history.

use egui::Ui;
use endcomfort_core::fit::{Fit, MirrorMode};
use endcomfort_core::job::Stage;

use super::Out;
use super::inspector::{heading, nothing_yet};
use super::scene::at;
use crate::viewer::icons::Icon;
use crate::viewer::theme::{BODY, SECONDARY, Tokens};
use crate::viewer::widgets::{icon_button, key_value, paragraph, section, segmented};
use crate::viewer::{Command, ViewerState, format};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let Some(output) = &state.outputs.fit else { return nothing_yet(ui, state, Stage::Fit) };
    let count = output.fits.len();
    let shown = state.selection.cluster.filter(|&cluster| cluster < count).unwrap_or(output.target);
    let role = if shown == output.target { "It will be grasped." } else { "An obstacle for the hand and the arm." };
    heading(ui, state, Stage::Fit, &format!("Superquadric of cluster {}", shown + 1), role);
    if count > 1 {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            if icon_button(ui, Icon::Left, "Cluster before", shown > 0, false).clicked() {
                out.push(Command::SelectCluster(shown - 1));
            }
            let _text = ui.label(egui::RichText::new(format!("{} of {count}", shown + 1)).color(tokens.secondary));
            if icon_button(ui, Icon::Right, "Next cluster", shown + 1 < count, false).clicked() {
                out.push(Command::SelectCluster(shown + 1));
            }
        });
    }
    match output.fits.get(shown) {
        Some(Ok(fit)) => parameters(ui, fit),
        Some(Err(reason)) => {
            let _text = paragraph(ui, reason, BODY, tokens.coral);
        }
        None => {}
    }
    section(ui, "Mirror the unseen side");
    ui.add_space(2.0);
    let modes = [MirrorMode::Auto, MirrorMode::On, MirrorMode::Off];
    let chosen = modes.iter().position(|&mode| mode == state.document.scene.fit.mirror);
    if let Some(index) = segmented(ui, "Mirror", &["When sure", "Always", "Never"], chosen) {
        out.push(Command::SetMirror(modes[index]));
    }
    if let Some(Ok(fit)) = output.fits.get(shown) {
        ui.add_space(4.0);
        let _text = paragraph(ui, &fit.mirror_note, SECONDARY, tokens.secondary);
        section(ui, "Starts");
        for run in &fit.runs {
            let rms = run.rms.last().copied().unwrap_or(0.0);
            let text =
                format!("{}: {} rms after {} iterations, {}", run.name, format::length(rms), run.iterations, run.stop);
            let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
        }
    }
}

fn parameters(ui: &mut Ui, fit: &Fit) {
    let superquadric = &fit.superquadric;
    let mm = |metres: f64| format::significant(metres * 1e3);
    let axes = format!("{} × {} × {} mm", mm(superquadric.a), mm(superquadric.b), mm(superquadric.c));
    let _row = key_value(ui, "Semi-axes a, b, c", &axes);
    let exponents = format!("{:.2}, {:.2}", superquadric.e1, superquadric.e2);
    let _row = key_value(ui, "Shape exponents e1, e2", &exponents);
    let _row = key_value(ui, "Centre", &at(&superquadric.X_FS.translation.vector.into()));
    let _row = key_value(ui, "Volume", &format::volume(fit.volume_m3));
    section(ui, "How well it fits");
    let _row = key_value(ui, "E_r, mean radial distance", &format::length(fit.radial_m));
    let _row = key_value(ui, "E_g (3.9), mean (f^e1 – 1)²", &format::significant(fit.goodness_of_fit));
    let _row = key_value(ui, "E_g of the tables, mean |f – 1|", &format::significant(fit.goodness_of_fit_abs));
    let points = format!("{} of {}", format::count(fit.used_points), format::count(fit.points));
    let _row = key_value(ui, "Points used, after thinning", &points);
    if !fit.mirrored.is_empty() {
        let _row = key_value(ui, "Points added by the mirror", &format::count(fit.mirrored.len()));
    }
    let _row = key_value(ui, "Iterations, all starts", &format::count(fit.iterations as usize));
}
