//! What the grasp synthesis is asked.

use egui::Ui;
use endcomfort_core::grasp::{ContactSurface, GraspFilter, GraspSettings};
use endcomfort_core::scene::{ArmChoice, MAX_DENSITY, MAX_DEPTHS, MAX_NOISE_TRIALS, MAX_ROLLS};

use super::explain;
use crate::viewer::number::{Number, number_row};
use crate::viewer::panels::Out;
use crate::viewer::widgets::{secondary_button, section, segmented_wide, switch};
use crate::viewer::{Command, GraspCommand, ViewerState};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let scene = &state.document.scene;
    let present = &scene.grasp;
    let mut wanted = present.clone();

    section(ui, "Arm");
    let chosen = usize::from(scene.arm == ArmChoice::Right);
    if let Some(index) = segmented_wide(ui, "Arm", &["Left", "Right"], Some(chosen)) {
        out.push(Command::SetArm([ArmChoice::Left, ArmChoice::Right][index]));
    }
    if state.has_torso() && switch(ui, "The torso moves with the arm", scene.torso) {
        out.push(Command::Grasping(GraspCommand::SetTorso(!scene.torso)));
    }

    section(ui, "Candidates");
    let whole = |name, unit, tip| Number { name, unit, decimals: 0, per_point: 0.1, tip };
    let field = whole("Density N", "", "Surface samples of each body; their number grows with the square");
    if let Some(density) = number_row(ui, &field, f64::from(present.density), "density of the surface samples") {
        wanted.density = density.max(1.0).min(MAX_DENSITY).round() as u32;
    }
    let field = whole("Rolls", "", "Turns of the hand about its approach, evenly over half a turn");
    if let Some(rolls) = number_row(ui, &field, f64::from(present.rolls), "rolls about the approach") {
        wanted.rolls = rolls.max(1.0).min(MAX_ROLLS).round() as u32;
    }
    let field = whole("Depths", "", "Stand-offs from the palm at the surface to the fingertips");
    if let Some(depths) = number_row(ui, &field, f64::from(present.depths), "depths from palm to fingertips") {
        wanted.depths = depths.max(1.0).min(MAX_DEPTHS).round() as u32;
    }
    let field = whole("Contacts at least", "", "Grasps with fewer contacts are dropped");
    if let Some(contacts) = number_row(ui, &field, present.min_contacts as f64, "contacts at least") {
        wanted.min_contacts = contacts.max(1.0).min(20.0).round() as usize;
    }

    section(ui, "Fingers close on");
    let chosen = ContactSurface::ALL.iter().position(|&surface| surface == present.surface);
    if let Some(index) = segmented_wide(ui, "Contact surface", &["Superquadric", "Cloud", "Mesh"], chosen) {
        wanted.surface = ContactSurface::ALL[index];
    }
    explain(
        ui,
        match present.surface {
            ContactSurface::Superquadric => "The fit itself: exact positions and normals.",
            ContactSurface::Cloud => "The points as they were measured, normals from their neighbours.",
            ContactSurface::Mesh => "Triangles of the fit, or of the object where its mesh is known.",
        },
    );
    ui.add_space(4.0);
    let field = Number { name: "Friction", unit: "", decimals: 2, per_point: 0.01, tip: "Coulomb, at every contact" };
    if let Some(friction) = number_row(ui, &field, present.friction, "friction coefficient") {
        wanted.friction = friction.max(0.01).min(5.0);
    }

    section(ui, "Pose noise");
    let field = whole("Noise trials", "", "0 leaves the success probability out");
    if let Some(trials) = number_row(ui, &field, f64::from(present.noise.trials), "poses tried per grasp") {
        wanted.noise.trials = trials.max(0.0).min(MAX_NOISE_TRIALS).round() as u32;
    }
    let field = Number { name: "Position σ, mm", unit: "mm", decimals: 1, per_point: 0.1, tip: "Along each axis" };
    if let Some(mm) = number_row(ui, &field, 1e3 * present.noise.position_m, "standard deviation of the position") {
        wanted.noise.position_m = 1e-3 * mm.max(0.0).min(100.0);
    }
    let field = Number { name: "Rotation σ, °", unit: "°", decimals: 1, per_point: 0.1, tip: "About each axis" };
    if let Some(deg) =
        number_row(ui, &field, present.noise.rotation_rad.to_degrees(), "standard deviation of the rotation")
    {
        wanted.noise.rotation_rad = deg.max(0.0).min(57.0).to_radians();
    }
    explain(ui, "How often a grasp still holds when the object is not quite where it was seen.");

    ui.add_space(10.0);
    // The filter has a button of its own.
    let usual = GraspSettings { filter: present.filter.clone(), ..GraspSettings::default() };
    if secondary_button(ui, "Usual settings", *present != usual).clicked() {
        wanted = usual;
    }
    if wanted != *present {
        out.push(Command::Grasping(GraspCommand::Settings(wanted)));
    }
}

/// Whether a filter lets everything pass.
pub(super) fn is_open(filter: &GraspFilter) -> bool {
    *filter == GraspFilter::default()
}
