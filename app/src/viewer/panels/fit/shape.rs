//! Every parameter by hand, with the error following.

use egui::{Sense, Ui, vec2};
use endcomfort_core::fit::Fit;
use endcomfort_core::job::SetShape;
use endcomfort_core::superquadric::Superquadric;
use nalgebra::UnitQuaternion;

use super::result::{E_G, E_R};
use crate::viewer::number::{Number, Touch, number};
use crate::viewer::panels::Out;
use crate::viewer::theme::{SECONDARY, SMALL, Tokens, font, strong};
use crate::viewer::widgets::{paragraph, secondary_button};
use crate::viewer::{Command, LabCommand, ViewerState, format};

/// Semi-axes, exponents, position, angles, taper and bend.
const COUNT: usize = 13;

const fn field(name: &'static str, unit: &'static str, decimals: usize, per_point: f64, tip: &'static str) -> Number {
    Number { name, unit, decimals, per_point, tip }
}

const AXIS: &str = "Half of the extent along this axis of the superquadric";
const PLACE: &str = "Position of the centre in the world";
const ANGLE: &str = "R = Rz(yaw) Ry(pitch) Rx(roll), from the superquadric's axes to the world";

const FIELDS: [Number; COUNT] = [
    field("Semi-axis a, mm", "mm", 1, 0.1, AXIS),
    field("Semi-axis b, mm", "mm", 1, 0.1, AXIS),
    field("Semi-axis c, mm", "mm", 1, 0.1, AXIS),
    field("Exponent e1", "", 2, 0.005, "Profile along z: 0.1 is a box, 1 is round"),
    field("Exponent e2", "", 2, 0.005, "Section across z: 0.1 is a square, 1 is round"),
    field("Position x, mm", "mm", 1, 0.2, PLACE),
    field("Position y, mm", "mm", 1, 0.2, PLACE),
    field("Position z, mm", "mm", 1, 0.2, PLACE),
    field("Roll, degrees", "°", 1, 0.25, ANGLE),
    field("Pitch, degrees", "°", 1, 0.25, ANGLE),
    field("Yaw, degrees", "°", 1, 0.25, ANGLE),
    field("Taper K", "", 2, 0.005, "Sections across z are scaled by 1 + K z/c"),
    field("Bend, 1/m", "1/m", 2, 0.02, "Curvature of the axis in the y–z plane"),
];

/// What stands over a number, and which numbers share a row.
const ROWS: [&[(&str, usize)]; 5] = [
    &[("semi-axis a", 0), ("semi-axis b", 1), ("semi-axis c", 2)],
    &[("exponent e1", 3), ("exponent e2", 4)],
    &[("position x", 5), ("position y", 6), ("position z", 7)],
    &[("roll", 8), ("pitch", 9), ("yaw", 10)],
    &[("taper K", 11), ("bend κ", 12)],
];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, fit: &Fit, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let Some(cluster) = state.examined_cluster() else { return };
    // While an answer is on its way, the numbers are those that were asked for.
    let by_hand = state.document.shape.filter(|shape| shape.cluster == cluster);
    let shape = by_hand.map_or(fit.superquadric, |shape| shape.superquadric);
    errors(ui, state, fit);

    let values = values(ui, &shape);
    let width = ui.available_width();
    let each = (width - 16.0) / 3.0;
    // The button fits into the free place at the end of the last row, but not on a phone.
    let is_wide = each >= 118.0;
    ui.add_space(10.0);
    for (row, fields) in ROWS.into_iter().enumerate() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            for &(symbol, index) in fields {
                cell(ui, each, symbol, |ui| {
                    let touched = number(ui, &FIELDS[index], values[index], each);
                    let set = |ui: &Ui, value: f64| {
                        let mut values = values;
                        values[index] = value;
                        SetShape { cluster, superquadric: shape_of(ui, &shape, &values, index) }
                    };
                    match touched {
                        Touch::None => {}
                        Touch::Dragged(value) => out.push(Command::Lab(LabCommand::DragShape(set(ui, value)))),
                        Touch::Released(_) => out.push(Command::Lab(LabCommand::EndDrag)),
                        Touch::Set(value) => out.push(Command::Lab(LabCommand::SetShape(set(ui, value)))),
                    }
                });
            }
            if is_wide && row == ROWS.len() - 1 {
                cell(ui, each, "", |ui| back(ui, by_hand.is_some(), out));
            }
        });
        ui.add_space(6.0);
    }
    if !is_wide {
        back(ui, by_hand.is_some(), out);
        ui.add_space(6.0);
    }
    if let Some(reason) = &state.lab.refused {
        let text = format!("Not taken: {reason}.");
        let _text = paragraph(ui, &text, SECONDARY, tokens.coral);
        ui.add_space(4.0);
    }
    let text = "Drag a number sideways, or click it and type. The Fit step answers while you drag; grasps and plan \
                follow when you let go.";
    let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
}

fn back(ui: &mut Ui, enabled: bool, out: &mut Out) {
    if secondary_button(ui, "Back to the fit", enabled).clicked() {
        out.push(Command::Lab(LabCommand::BackToFit));
    }
}

/// A caption over something.
fn cell(ui: &mut Ui, width: f32, caption: &str, add: impl FnOnce(&mut Ui)) {
    let color = Tokens::of(ui).secondary;
    ui.allocate_ui_with_layout(vec2(width, 46.0), egui::Layout::top_down(egui::Align::Min), |ui| {
        ui.spacing_mut().item_spacing.y = 3.0;
        ui.set_width(width);
        let _text = ui.label(egui::RichText::new(caption).font(font(SECONDARY)).color(color));
        add(ui);
    });
}

/// The errors in large figures, beside those of the fit that the shape stands in for.
fn errors(ui: &mut Ui, state: &ViewerState, fit: &Fit) {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 60.0), Sense::hover());
    ui.painter().rect_filled(rect, 8.0, tokens.well);
    let automatic = state.automatic_fit();
    let cells = [
        ("E_r", format::length(fit.radial_m), automatic.map(|fit| format::length(fit.radial_m)), E_R),
        (
            "E_g",
            format::significant(fit.goodness_of_fit),
            automatic.map(|fit| format::significant(fit.goodness_of_fit)),
            E_G,
        ),
        ("Volume", format::volume(fit.volume_m3), automatic.map(|fit| format::volume(fit.volume_m3)), "Volume (3.11)."),
    ];
    let width = (rect.width() - 24.0) / cells.len() as f32;
    for (index, (name, value, before, tip)) in cells.into_iter().enumerate() {
        let left = rect.left() + 12.0 + width * index as f32;
        let at = |y: f32| egui::pos2(left, rect.top() + y);
        let caption = before.map_or_else(|| name.to_owned(), |before| format!("{name}, fit {before}"));
        let caption = crate::viewer::widgets::elided(ui, &caption, font(SMALL), tokens.secondary, width - 6.0);
        ui.painter().galley(at(9.0), caption, tokens.secondary);
        let galley = ui.painter().layout_no_wrap(value.clone(), strong(17.0), tokens.text);
        ui.painter().galley(at(27.0), galley, tokens.text);
        let cell = egui::Rect::from_min_size(egui::pos2(left, rect.top()), vec2(width, rect.height()));
        let response = ui.interact(cell, ui.scope_id().with(("error", index)), Sense::hover());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("{name} now {value}")));
        let _tip = response.on_hover_text(tip);
    }
}

/// Roll, pitch and yaw that were set last, degrees, with the rotation that they made: near a pitch of 90° others make
/// the same one, and the numbers would jump.
type Angles = ([f64; 3], UnitQuaternion<f64>);

fn angles_id() -> egui::Id {
    egui::Id::unique("Angles of the shape")
}

/// The parameters in the units of the fields.
fn values(ui: &Ui, shape: &Superquadric) -> [f64; COUNT] {
    let place = shape.X_FS.translation.vector * 1e3;
    let rotation = shape.X_FS.rotation;
    let kept: Option<Angles> = ui.data(|data| data.get_temp(angles_id()));
    let [roll, pitch, yaw] = match kept {
        Some((angles, made)) if made.angle_to(&rotation) < 1e-9 => angles,
        _ => {
            let (roll, pitch, yaw) = rotation.euler_angles();
            [roll, pitch, yaw].map(f64::to_degrees)
        }
    };
    [
        1e3 * shape.a,
        1e3 * shape.b,
        1e3 * shape.c,
        shape.e1,
        shape.e2,
        place.x,
        place.y,
        place.z,
        roll,
        pitch,
        yaw,
        shape.taper,
        shape.bend_per_m,
    ]
}

/// The shape with one parameter changed, not yet checked; the others keep every digit.
fn shape_of(ui: &Ui, shape: &Superquadric, values: &[f64; COUNT], changed: usize) -> Superquadric {
    let mut made = *shape;
    match changed {
        0 => made.a = 1e-3 * values[0],
        1 => made.b = 1e-3 * values[1],
        2 => made.c = 1e-3 * values[2],
        3 => made.e1 = values[3],
        4 => made.e2 = values[4],
        5..=7 => made.X_FS.translation.vector[changed - 5] = 1e-3 * values[changed],
        8..=10 => {
            let angles = [values[8], values[9], values[10]];
            let [roll, pitch, yaw] = angles.map(f64::to_radians);
            made.X_FS.rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            ui.data_mut(|data| data.insert_temp::<Angles>(angles_id(), (angles, made.X_FS.rotation)));
        }
        11 => made.taper = values[11],
        _ => made.bend_per_m = values[12],
    }
    made
}
