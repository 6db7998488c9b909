//! Which grasps a person wants: from where, where on the object, how far from everything else.

use egui::Ui;
use endcomfort_core::grasp::{ApproachCone, GraspFilter, GraspSettings};
use nalgebra::Vector3;

use super::explain;
use super::settings::is_open;
use crate::viewer::number::{Number, Touch, number, number_row};
use crate::viewer::panels::Out;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{primary_button, secondary_button, section, segmented_wide};
use crate::viewer::{Command, GraspCommand, ViewerState, format};

/// Half the opening angle of a new approach cone, radians.
const USUAL_CONE_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// Two directions are one below this angle, radians: a hundredth of a degree.
const SAME_RAD: f64 = 1.7e-4;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let present = &state.document.scene.grasp.filter;
    let mut edit = Edit { wanted: present.clone(), is_dragged: false };
    approach(ui, state, present, &mut edit);
    region(ui, state, present, &mut edit, out);
    part(ui, state, present, &mut edit);

    section(ui, "Clearance");
    let tip = "Of the closed hand, from table and neighbours";
    let field = Number { name: "Clearance, mm", unit: "mm", decimals: 0, per_point: 0.2, tip };
    if let Some(mm) = number_row(ui, &field, 1e3 * present.min_clearance_m, "away from table and neighbours") {
        edit.wanted.min_clearance_m = 1e-3 * mm.max(0.0).min(1000.0);
    }

    ui.add_space(10.0);
    if secondary_button(ui, "All grasps are wanted", !is_open(present)).clicked() {
        edit = Edit { wanted: GraspFilter::default(), is_dragged: false };
    }
    if edit.wanted != *present {
        let command = if edit.is_dragged {
            GraspCommand::Preview(edit.wanted)
        } else {
            let settings = &state.document.scene.grasp;
            GraspCommand::Settings(GraspSettings { filter: edit.wanted, ..settings.clone() })
        };
        out.push(Command::Grasping(command));
    }
}

/// The filter that the fields ask for.
struct Edit {
    wanted: GraspFilter,
    /// A number is still held: the view shows it, the grasps wait.
    is_dragged: bool,
}

impl Edit {
    /// A field's new value, if it has one.
    fn take(&mut self, touch: Touch) -> Option<f64> {
        match touch {
            Touch::None => None,
            Touch::Dragged(value) => {
                self.is_dragged = true;
                Some(value)
            }
            Touch::Released(value) | Touch::Set(value) => Some(value),
        }
    }
}

/// Named directions in which the hand comes, seen by the robot.
fn directions(state: &ViewerState) -> [(&'static str, Vector3<f64>); 5] {
    let optical = state.document.scene.X_WC.rotation * Vector3::z();
    [
        ("Above", -Vector3::z()),
        ("Front", Vector3::x()),
        ("Left", -Vector3::y()),
        ("Right", Vector3::y()),
        ("Sensor", optical),
    ]
}

fn approach(ui: &mut Ui, state: &ViewerState, present: &GraspFilter, edit: &mut Edit) {
    section(ui, "The hand comes from");
    let known = directions(state);
    let mut words = vec!["Anywhere"];
    words.extend(known.iter().map(|(name, _)| *name));
    let chosen = match &present.approach {
        None => Some(0),
        Some(cone) => known.iter().position(|(_, axis)| axis.angle(&cone.axis_W) < SAME_RAD).map(|index| index + 1),
    };
    if let Some(index) = segmented_wide(ui, "Approach", &words, chosen) {
        let half_angle_rad = present.approach.map_or(USUAL_CONE_RAD, |cone| cone.half_angle_rad);
        edit.wanted.approach =
            index.checked_sub(1).map(|index| ApproachCone { axis_W: known[index].1, half_angle_rad });
    }
    let Some(cone) = present.approach else {
        return explain(ui, "Every direction is wanted.");
    };
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        let tip = "Half the opening angle of the cone";
        let field = Number { name: "Half angle, °", unit: "°", decimals: 0, per_point: 0.5, tip };
        if let Some(deg) = edit.take(number(ui, &field, cone.half_angle_rad.to_degrees(), 64.0)) {
            let half_angle_rad = deg.max(1.0).min(180.0).to_radians();
            edit.wanted.approach = Some(ApproachCone { half_angle_rad, ..cone });
        }
        words_after(ui, "around");
        for (axis, name) in ["Approach x", "Approach y", "Approach z"].into_iter().enumerate() {
            let tip = "Direction in the world in which the hand moves; its length does not matter";
            let field = Number { name, unit: "", decimals: 2, per_point: 0.01, tip };
            if let Some(value) = edit.take(number(ui, &field, cone.axis_W[axis], 60.0)) {
                let mut axis_W = cone.axis_W;
                axis_W[axis] = value.max(-1.0).min(1.0);
                // A direction of length 0 is none: the one before it stays.
                if axis_W.norm() > 0.01 {
                    edit.wanted.approach = Some(ApproachCone { axis_W, ..cone });
                }
            }
        }
    });
    explain(ui, "The cone in the view is open where the hand may come from.");
}

fn region(ui: &mut Ui, state: &ViewerState, present: &GraspFilter, edit: &mut Edit, out: &mut Out) {
    section(ui, "It holds the object inside a box");
    let draws = state.grasping.draws_region;
    ui.horizontal(|ui| {
        if draws {
            if primary_button(ui, "Drag over the object…", true).clicked() {
                out.push(Command::Grasping(GraspCommand::DrawRegion(false)));
            }
        } else if secondary_button(ui, "Draw a box in the view", true).clicked() {
            out.push(Command::Grasping(GraspCommand::DrawRegion(true)));
        }
        if present.region.is_some() {
            if secondary_button(ui, "No box", true).clicked() {
                edit.wanted.region = None;
            }
        } else if secondary_button(ui, "Upper half", true).clicked() {
            out.push(Command::Grasping(GraspCommand::TakeUpperHalf));
        }
    });
    let Some(region) = present.region else {
        return explain(ui, "A drag over the object takes what lies behind it on its surface.");
    };
    ui.add_space(6.0);
    for (words, names, is_size) in [
        ("centre", ["Box centre x, mm", "Box centre y, mm", "Box centre z, mm"], false),
        ("size", ["Box size x, mm", "Box size y, mm", "Box size z, mm"], true),
    ] {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            for (axis, name) in names.into_iter().enumerate() {
                let tip = "In the world: x forward from the robot, y to its left, z up";
                let field = Number { name, unit: "mm", decimals: 0, per_point: 1.0, tip };
                let value_m = if is_size { 2.0 * region.half_m[axis] } else { region.center_W[axis] };
                if let Some(mm) = edit.take(number(ui, &field, 1e3 * value_m, 82.0)) {
                    let mut changed = region;
                    if is_size {
                        changed.half_m[axis] = 0.5e-3 * mm.max(1.0).min(5000.0);
                    } else {
                        changed.center_W[axis] = 1e-3 * mm.max(-5000.0).min(5000.0);
                    }
                    edit.wanted.region = Some(changed);
                }
            }
            words_after(ui, words);
        });
        ui.add_space(3.0);
    }
}

fn part(ui: &mut Ui, state: &ViewerState, present: &GraspFilter, edit: &mut Edit) {
    let parts = state.parts();
    if parts < 2 && present.part.is_none() {
        return;
    }
    section(ui, "It holds the part");
    let names: Vec<String> = (1..=parts.max(1)).map(|part| part.to_string()).collect();
    let words: Vec<&str> = std::iter::once("Any").chain(names.iter().map(String::as_str)).collect();
    let chosen = present.part.map_or(0, |part| part + 1);
    if let Some(index) = segmented_wide(ui, "Part", &words, Some(chosen)) {
        edit.wanted.part = index.checked_sub(1);
    }
    explain(ui, &format!("The object has {}; a click on one in the view chooses it.", format::plural(parts, "part")));
}

fn words_after(ui: &mut Ui, words: &str) {
    let color = Tokens::of(ui).secondary;
    let size = if words == "around" { SECONDARY } else { BODY };
    let _text = ui.label(egui::RichText::new(words).font(font(size)).color(color));
}
