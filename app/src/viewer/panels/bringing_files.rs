//! The windows that ask for the camera of a depth image, and what a mesh is.

use egui::{Id, Modal, Ui};
use endcomfort_core::mesh_file::MeshUnit;

use super::Out;
use crate::viewer::number::{Number, number_row};
use crate::viewer::theme::{BODY, SECONDARY, Tokens};
use crate::viewer::widgets::{
    key_value, overlay_frame, paragraph, primary_button, secondary_button, segmented_wide, title,
};
use crate::viewer::{BringCommand, Command, DepthWindow, MeshWindow};

const WIDTH: f32 = 420.0;

pub(super) fn depth(ui: &mut Ui, window: &DepthWindow, out: &mut Out) {
    let image = &window.image;
    dialog(ui, "Depth image", &format!("Camera of {}", image.name), &window.problem, out, |ui, out| {
        let text = format!(
            "{} × {} pixels came without the intrinsics of the camera, so their scale across is not known. Drop the image \
             together with a JSON file (fx, fy, cx, cy, or ROS camera_info), or give the horizontal field of view; the \
             axis is taken to be in the middle, depth in millimetres.",
            image.width, image.height
        );
        let _text = paragraph(ui, &text, SECONDARY, Tokens::of(ui).secondary);
        ui.add_space(6.0);
        let tip = "Angle between the left and the right edge of the image";
        let field = Number { name: "Field of view, °", unit: "°", decimals: 1, per_point: 0.2, tip };
        if let Some(degrees) = number_row(ui, &field, window.view_deg, "horizontal field of view") {
            out.push(Command::Bring(BringCommand::SetView(degrees)));
        }
        ui.add_space(10.0);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            if primary_button(ui, "Open the cloud", true).clicked() {
                out.push(Command::Bring(BringCommand::Accept { is_grasped: false }));
            }
            cancel(ui, out);
        });
    });
}

pub(super) fn mesh(ui: &mut Ui, window: &MeshWindow, out: &mut Out) {
    let mesh = &window.mesh;
    dialog(ui, "Mesh", &format!("What is {}?", mesh.name), &window.problem, out, |ui, out| {
        let text = format!("{} triangles; {}.", crate::viewer::count(mesh.mesh.triangles.len()), mesh.reason);
        let _text = paragraph(ui, &text, SECONDARY, Tokens::of(ui).secondary);
        ui.add_space(6.0);
        let units = MeshUnit::ALL.map(MeshUnit::symbol);
        let chosen = MeshUnit::ALL.iter().position(|unit| *unit == window.unit);
        if let Some(index) = segmented_wide(ui, "Unit", &units, chosen) {
            out.push(Command::Bring(BringCommand::SetUnit(MeshUnit::ALL[index])));
        }
        ui.add_space(4.0);
        let mm = 1e3 * mesh.edges_m(window.unit);
        let _row = key_value(ui, "Then it measures", &format!("{:.0} × {:.0} × {:.0} mm", mm.x, mm.y, mm.z));
        ui.add_space(10.0);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            if primary_button(ui, "Grasp it", true).clicked() {
                out.push(Command::Bring(BringCommand::Accept { is_grasped: true }));
            }
            if secondary_button(ui, "It stands in the way", true).clicked() {
                out.push(Command::Bring(BringCommand::Accept { is_grasped: false }));
            }
            cancel(ui, out);
        });
    });
}

fn cancel(ui: &mut Ui, out: &mut Out) {
    if secondary_button(ui, "Cancel", true).clicked() {
        out.push(Command::Bring(BringCommand::Cancel));
    }
}

/// A window with a heading and what is wrong.
fn dialog(
    ui: &mut Ui,
    id: &'static str,
    heading: &str,
    problem: &Option<String>,
    out: &mut Out,
    content: impl FnOnce(&mut Ui, &mut Out),
) {
    let tokens = Tokens::of(ui);
    let frame = overlay_frame(tokens, 22);
    let width = WIDTH.min(ui.max_rect().width() - 60.0);
    let modal = Modal::new(Id::unique(id)).frame(frame).backdrop_color(tokens.scrim).show(ui.ctx(), |ui| {
        ui.set_width(width);
        title(ui, heading);
        ui.add_space(6.0);
        if let Some(problem) = problem {
            let _text = paragraph(ui, problem, BODY, tokens.coral);
            ui.add_space(4.0);
        }
        content(ui, out);
    });
    if modal.should_close() {
        out.push(Command::Bring(BringCommand::Cancel));
    }
}
