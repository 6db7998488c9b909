//! What stands in the scene, as a list to select from, and the selected thing's place and size.

use egui::{Rect, Role, Sense, Ui, Vec2, WidgetInfo, pos2, vec2};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::Out;
use super::scene::at;
use crate::assets;
use crate::viewer::fields::dropdown;
use crate::viewer::number::{Number, Touch, number};
use crate::viewer::placing::EDGE_M;
use crate::viewer::theme::{BODY, SECONDARY, SMALL_RADIUS, Tokens, font};
use crate::viewer::widgets::{elided, focus_ring, key_value, secondary_button, section};
use crate::viewer::{Command, PlaceCommand, Thing, ViewerState, format};

const X: Number = Number { name: "x, m", unit: "m", decimals: 3, per_point: 0.002, tip: "Away from the robot" };
const Y: Number = Number { name: "y, m", unit: "m", decimals: 3, per_point: 0.002, tip: "To the robot's left" };
const Z: Number = Number { name: "z, m", unit: "m", decimals: 3, per_point: 0.002, tip: "Height above the floor" };
const YAW: Number = Number { name: "yaw, °", unit: "°", decimals: 1, per_point: 0.5, tip: "Turn about the vertical" };
const EDGES: [Number; 3] = [
    Number { name: "edge along x, mm", unit: "mm", decimals: 0, per_point: 1.0, tip: "Edge along the box's own x" },
    Number { name: "edge along y, mm", unit: "mm", decimals: 0, per_point: 1.0, tip: "Edge along the box's own y" },
    Number { name: "edge along z, mm", unit: "mm", decimals: 0, per_point: 1.0, tip: "Edge along the box's own z" },
];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let scene = &state.document.scene;
    let is_simulated = state.document.cloud.is_none();
    section(ui, if is_simulated { "What stands here" } else { "In the way" });
    if is_simulated {
        for (index, placed) in scene.objects.iter().enumerate() {
            let name = format::title_of(&placed.object);
            let name = if index == scene.task.object { format!("{name} · to grasp") } else { name };
            entry(ui, state, Thing::Object(index), &name, &at(&placed.X_WO.translation.vector.into()), out);
        }
    }
    for (index, obstacle) in scene.obstacles.iter().enumerate() {
        let name = format::title_of(&obstacle.name);
        entry(ui, state, Thing::Obstacle(index), &name, &size(&obstacle.size_m), out);
    }
    for piece in state.receiver().iter().flat_map(|agent| agent.furniture_W()) {
        let _row = key_value(ui, &format::title_of(&piece.name), &size(&piece.size_m));
    }
    if is_simulated {
        entry(ui, state, Thing::Camera, "Camera", &at(&scene.X_WC.translation.vector.into()), out);
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        if is_simulated {
            let names = assets::object_names();
            let titles: Vec<String> = names.iter().map(|name| format::title_of(name)).collect();
            let rows: Vec<&str> = titles.iter().map(String::as_str).collect();
            if let Some(index) = dropdown(ui, "Add an object", "Add an object", 150.0, &rows, None) {
                out.push(Command::Place(PlaceCommand::AddObject(names[index].to_owned())));
            }
        }
        if secondary_button(ui, "Add a box", true).clicked() {
            out.push(Command::Place(PlaceCommand::AddBox));
        }
    });
}

/// The row of a thing, and what can be done with it while it is selected.
fn entry(ui: &mut Ui, state: &ViewerState, thing: Thing, name: &str, detail: &str, out: &mut Out) {
    let is_selected = state.selected_thing() == Some(thing);
    if row(ui, name, detail, is_selected) {
        out.push(Command::Place(PlaceCommand::Select((!is_selected).then_some(thing))));
    }
    if let Some(X_WT) = thing.pose(&state.document.scene).filter(|_| is_selected) {
        place(ui, state, thing, &X_WT, out);
    }
}

fn size(size_m: &Vector3<f64>) -> String {
    let mm = size_m * 1e3;
    format!("{:.0} × {:.0} × {:.0} mm", mm.x, mm.y, mm.z)
}

/// A row that can be selected; says whether it was clicked.
fn row(ui: &mut Ui, name: &str, detail: &str, is_selected: bool) -> bool {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 28.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::ListItem, true, is_selected, format!("{name}: {detail}")));
    if is_selected || response.hovered() {
        let back = Rect::from_center_size(rect.center(), rect.size() + Vec2::new(12.0, 0.0));
        ui.painter().rect_filled(back, SMALL_RADIUS, if is_selected { tokens.selected } else { tokens.hover });
    }
    let detail = elided(ui, detail, font(SECONDARY), tokens.secondary, 0.6 * rect.width());
    let room = rect.width() - detail.size().x - 14.0;
    let name = elided(ui, name, font(BODY), tokens.text, room);
    let y = rect.center().y;
    ui.painter().galley(pos2(rect.left(), y - 0.5 * name.size().y), name, tokens.text);
    let left = rect.right() - detail.size().x;
    ui.painter().galley(pos2(left, y - 0.5 * detail.size().y), detail, tokens.secondary);
    focus_ring(ui, &response, rect.expand2(vec2(6.0, 0.0)));
    response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked()
}

/// Place, size, and what else can be done with a thing.
fn place(ui: &mut Ui, state: &ViewerState, thing: Thing, X_WT: &Isometry3<f64>, out: &mut Out) {
    ui.add_space(4.0);
    ui.spacing_mut().item_spacing.x = 6.0;
    let width = (ui.available_width() - 12.0) / 3.0;
    ui.horizontal(|ui| {
        for (axis, field) in [X, Y, Z].iter().enumerate() {
            let mut moved = *X_WT;
            let touch = number(ui, field, X_WT.translation.vector[axis], width);
            touched(touch, thing, out, |value| {
                moved.translation.vector[axis] = value;
                moved
            });
        }
    });
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let yaw_deg = X_WT.rotation.euler_angles().2.to_degrees();
        let touch = number(ui, &YAW, yaw_deg, width);
        touched(touch, thing, out, |value| {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), (value - yaw_deg).to_radians());
            Isometry3::from_parts(X_WT.translation, turn * X_WT.rotation)
        });
        let color = Tokens::of(ui).secondary;
        let _words = ui.label(egui::RichText::new("turn").font(font(SECONDARY)).color(color));
    });
    if let Thing::Obstacle(index) = thing {
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            let size_m = state.document.scene.obstacles[index].size_m;
            for (axis, field) in EDGES.iter().enumerate() {
                if let Touch::Released(value) | Touch::Set(value) = number(ui, field, 1e3 * size_m[axis], width) {
                    let mut wanted = size_m;
                    wanted[axis] = (1e-3 * value).max(EDGE_M[0]).min(EDGE_M[1]);
                    out.push(Command::Place(PlaceCommand::Resize(index, wanted)));
                }
            }
        });
    }
    if thing == Thing::Camera {
        return ui.add_space(8.0);
    }
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        if let Thing::Object(index) = thing
            && index != state.document.scene.task.object
            && secondary_button(ui, "Grasp this", true).clicked()
        {
            out.push(Command::Place(PlaceCommand::Grasp(index)));
        }
        if secondary_button(ui, "Duplicate", true).clicked() {
            out.push(Command::Place(PlaceCommand::Duplicate(thing)));
        }
        if secondary_button(ui, "Delete", true).clicked() {
            out.push(Command::Place(PlaceCommand::Remove(thing)));
        }
    });
    ui.add_space(8.0);
}

/// Follows a number that is dragged, or takes one that was typed.
fn touched(touch: Touch, thing: Thing, out: &mut Out, mut pose: impl FnMut(f64) -> Isometry3<f64>) {
    match touch {
        Touch::None => {}
        Touch::Dragged(value) => out.push(Command::Place(PlaceCommand::Drag(thing, pose(value)))),
        Touch::Released(value) => {
            out.push(Command::Place(PlaceCommand::Drag(thing, pose(value))));
            out.push(Command::Place(PlaceCommand::EndDrag));
        }
        Touch::Set(value) => out.push(Command::Place(PlaceCommand::Put(thing, pose(value)))),
    }
}
