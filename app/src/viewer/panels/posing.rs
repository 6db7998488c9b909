//! The robot posed by hand: where its hands are, its joints with their limits, and what the pose meets.

use egui::{Align, Layout, Ui, vec2};
use endcomfort_core::robot::{Arm, Robot};
use nalgebra::{Isometry3, UnitQuaternion};

use super::Out;
use crate::viewer::fields::dropdown;
use crate::viewer::hand_gizmo::AXES;
use crate::viewer::icons::Icon;
use crate::viewer::number::{Number, Touch, number};
use crate::viewer::posing::{STEP_WORDS, unit_of_joint};
use crate::viewer::slider::slider;
use crate::viewer::theme::{BODY, SECONDARY, SMALL, SMALL_RADIUS, Tokens, font};
use crate::viewer::widgets::{
    focus_ring, icon_button, key_value, key_value_colored, paragraph, secondary_button, section, segmented_wide, title,
};
use crate::viewer::{Command, Jog, LedHand, PoseCommand, ViewerState, format};

const PLACE: [Number; 3] = [
    Number { name: "hand x, m", unit: "m", decimals: 3, per_point: 0.002, tip: "Away from the robot" },
    Number { name: "hand y, m", unit: "m", decimals: 3, per_point: 0.002, tip: "To the robot's left" },
    Number { name: "hand z, m", unit: "m", decimals: 3, per_point: 0.002, tip: "Height above the floor" },
];
const TURN: [Number; 3] = [
    Number { name: "hand roll, °", unit: "°", decimals: 1, per_point: 0.5, tip: "Turn about the world's x" },
    Number { name: "hand pitch, °", unit: "°", decimals: 1, per_point: 0.5, tip: "Turn about the world's y" },
    Number { name: "hand yaw, °", unit: "°", decimals: 1, per_point: 0.5, tip: "Turn about the vertical" },
];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    head(ui, out);
    let hands = state.led_hands();
    let posed = state.posed_robot().and_then(|(robot, _)| Some((state.q_posed(&robot)?, robot)));
    let (Some((q, robot)), Some(hand)) = (posed, hands.get(state.posing.arm).or(hands.first())) else {
        let text = "This robot cannot stand as the scene says. Choose a posture of its own to go on.";
        let _text = paragraph(ui, text, BODY, Tokens::of(ui).coral);
        return postures(ui, state, out);
    };
    let arm = &robot.arms[hand.arm];
    if hands.len() > 1 {
        let titles: Vec<String> = hands.iter().map(|hand| format!("{} arm", format::title_of(&hand.name))).collect();
        let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
        if let Some(index) = segmented_wide(ui, "Arm", &titles, Some(hand.arm)) {
            out.push(Command::Pose(PoseCommand::Arm(index)));
        }
        ui.add_space(6.0);
    }
    verdict(ui, state, &robot, arm, hand, &q, out);
    section(ui, "Hand");
    place(ui, hand, out);
    jogs(ui, state, out);
    if let Some(share) = state.opening(&robot, &q) {
        ui.add_space(4.0);
        let words = format!("{:.0}\u{2009}% open", 100.0 * share);
        if let Some(share) = slider(ui, "Opening of the hand", &words, share, [0.0, 1.0]) {
            out.push(Command::Pose(PoseCommand::DragFingers(share)));
        }
    }
    section(ui, "Joints");
    for &dof in &arm.dofs {
        joint(ui, &robot, dof, q[dof], out);
    }
    postures(ui, state, out);
    // Whatever was held has been let go: what it changed is one step of undo.
    if state.is_dragging_goal() && !ui.input(|input| input.pointer.any_down()) {
        out.push(Command::Pose(PoseCommand::EndDrag));
    }
}

fn head(ui: &mut Ui, out: &mut Out) {
    let tokens = Tokens::of(ui);
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = ui.available_width() - 32.0;
        ui.allocate_ui_with_layout(vec2(width, 0.0), Layout::top_down(Align::Min), |ui| {
            ui.set_width(width);
            title(ui, "Pose");
            let sentence = "Drag a hand in the view, or move joint by joint. The plan starts from here and follows.";
            let _text = paragraph(ui, sentence, SECONDARY, tokens.secondary);
        });
        if icon_button(ui, Icon::Cross, "Close Pose", true, false).clicked() {
            out.push(Command::Pose(PoseCommand::Close));
        }
    });
    ui.add_space(6.0);
}

/// Whether the hand is where it is wanted, how freely it moves, and what the pose meets.
fn verdict(ui: &mut Ui, state: &ViewerState, robot: &Robot, arm: &Arm, hand: &LedHand, q: &[f64], out: &mut Out) {
    let tokens = Tokens::of(ui);
    if let Some(target) = &hand.target {
        let text = format!("The {} hand does not get there: {}.", hand.name, target.reason);
        let _text = paragraph(ui, &text, BODY, tokens.coral);
        ui.add_space(4.0);
        if secondary_button(ui, "Bring the target back", true).clicked() {
            out.push(Command::Pose(PoseCommand::Recall(hand.arm)));
        }
        ui.add_space(4.0);
    }
    let m = robot.manipulability(arm, &robot.link_poses(q));
    let _row = key_value(ui, "Manipulability", &format::manipulability(m));
    let Some(meeting) = state.meeting() else { return };
    let clearance = &meeting.clearance;
    if meeting.hits.is_empty() && clearance.distance_m.is_finite() {
        let between = format!("{} to {}", words(&clearance.a), words(&clearance.b));
        let row = key_value(ui, "Clearance", &format::millimetres(clearance.distance_m));
        let _tip = row.on_hover_text(&between);
        let _text = paragraph(ui, &between, SECONDARY, tokens.secondary);
    }
    for hit in &meeting.hits {
        let _row = key_value_colored(ui, "Touches", &format!("{} · {}", words(&hit.a), words(&hit.b)), tokens.coral);
    }
}

fn words(name: &str) -> String {
    name.replace('_', " ")
}

/// Where the hand is, or is wanted.
fn place(ui: &mut Ui, hand: &LedHand, out: &mut Out) {
    let X_WH = hand.handle();
    ui.spacing_mut().item_spacing.x = 6.0;
    let width = (ui.available_width() - 12.0) / 3.0;
    captions(ui, AXES, width);
    ui.horizontal(|ui| {
        for (axis, field) in PLACE.iter().enumerate() {
            let touch = number(ui, field, X_WH.translation.vector[axis], width);
            led(touch, hand.arm, out, |value| {
                let mut to = X_WH;
                to.translation.vector[axis] = value;
                to
            });
        }
    });
    ui.add_space(4.0);
    captions(ui, ["roll", "pitch", "yaw"], width);
    ui.horizontal(|ui| {
        let (roll, pitch, yaw) = X_WH.rotation.euler_angles();
        let angles = [roll, pitch, yaw];
        for (axis, field) in TURN.iter().enumerate() {
            let touch = number(ui, field, angles[axis].to_degrees(), width);
            led(touch, hand.arm, out, |value| {
                let mut wanted = angles;
                wanted[axis] = value.to_radians();
                let rotation = UnitQuaternion::from_euler_angles(wanted[0], wanted[1], wanted[2]);
                Isometry3::from_parts(X_WH.translation, rotation)
            });
        }
    });
}

/// What stands below, column by column.
fn captions(ui: &mut Ui, names: [&str; 3], width: f32) {
    let ink = Tokens::of(ui).secondary;
    ui.horizontal(|ui| {
        for name in names {
            let (rect, _) = ui.allocate_exact_size(vec2(width, 15.0), egui::Sense::hover());
            let _rect = ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, name, font(SMALL), ink);
        }
    });
}

/// Follows a number that is dragged, or takes one that was typed.
fn led(touch: Touch, arm: usize, out: &mut Out, pose: impl Fn(f64) -> Isometry3<f64>) {
    match touch {
        Touch::None => {}
        Touch::Dragged(value) => out.push(Command::Pose(PoseCommand::Lead(arm, pose(value)))),
        Touch::Released(value) | Touch::Set(value) => {
            out.push(Command::Pose(PoseCommand::Lead(arm, pose(value))));
            out.push(Command::Pose(PoseCommand::EndDrag));
        }
    }
}

/// Buttons that move the hand step by step.
fn jogs(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    ui.add_space(6.0);
    for turns in [false, true] {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let tokens = Tokens::of(ui);
            let room = 40.0;
            let words = if turns { "Turn" } else { "Move" };
            let (rect, _) = ui.allocate_exact_size(vec2(room, 28.0), egui::Sense::hover());
            let left = rect.left_center();
            let _rect = ui.painter().text(left, egui::Align2::LEFT_CENTER, words, font(SECONDARY), tokens.secondary);
            let width = (ui.available_width() - 5.0 * 4.0) / 6.0;
            for (axis, name) in AXES.iter().enumerate() {
                for back in [true, false] {
                    let sign = if back { "–" } else { "+" };
                    let spoken = match (turns, back) {
                        (false, false) => format!("Move the hand along {name}"),
                        (false, true) => format!("Move the hand back along {name}"),
                        (true, false) => format!("Turn the hand about {name}"),
                        (true, true) => format!("Turn the hand back about {name}"),
                    };
                    if jog_button(ui, &format!("{name}{sign}"), &spoken, width) {
                        out.push(Command::Pose(PoseCommand::Jog(Jog { turns, axis, back })));
                    }
                }
            }
        });
        ui.add_space(3.0);
    }
    ui.add_space(3.0);
    if let Some(index) = segmented_wide(ui, "Step", &STEP_WORDS, Some(state.posing.step)) {
        out.push(Command::Pose(PoseCommand::Step(index)));
    }
    ui.add_space(4.0);
    let axes = ["Along the world's axes", "Along the hand's"];
    if let Some(index) = segmented_wide(ui, "Axes", &axes, Some(usize::from(state.posing.along_hand))) {
        out.push(Command::Pose(PoseCommand::AlongHand(index == 1)));
    }
}

/// A small button; `spoken` is what assistive technology reads.
fn jog_button(ui: &mut Ui, text: &str, spoken: &str, width: f32) -> bool {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(width, 28.0), egui::Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, spoken));
    let fill = if response.hovered() { tokens.hover } else { tokens.well };
    ui.painter().rect_filled(rect, SMALL_RADIUS, fill);
    let _rect = ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, text, font(SECONDARY), tokens.text);
    focus_ring(ui, &response, rect);
    response.on_hover_text(spoken).on_hover_cursor(egui::CursorIcon::PointingHand).clicked()
}

/// A joint: its name and value, and its way from limit to limit.
fn joint(ui: &mut Ui, robot: &Robot, dof: usize, value: f64, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let joint = &robot.joints[robot.dof_joints[dof]];
    let (unit, per_si) = unit_of_joint(joint.kind);
    let (lower, upper) = (joint.limit.lower, joint.limit.upper);
    let apart = if unit == "°" { "" } else { "\u{2009}" };
    let shown = |value: f64| format!("{:.1}{apart}{unit}", per_si * value).replace('-', "–");
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 17.0), egui::Sense::hover());
    let limits = format!("{} … {}", shown(lower), shown(upper));
    let at = rect.left_center();
    let _rect = ui.painter().text(at, egui::Align2::LEFT_CENTER, words(&joint.name), font(SECONDARY), tokens.text);
    let at = rect.right_center();
    let _rect = ui.painter().text(at, egui::Align2::RIGHT_CENTER, limits, font(SECONDARY), tokens.secondary);
    if let Some(value) = slider(ui, &joint.name, &shown(value), value, [lower, upper]) {
        out.push(Command::Pose(PoseCommand::DragJoint(dof, value)));
    }
}

/// The robot's own postures to start from.
fn postures(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let Some((robot, _)) = state.posed_robot() else { return };
    ui.add_space(8.0);
    let scene = &state.document.scene;
    let names: Vec<String> = robot.postures.iter().map(|(name, _)| name.clone()).collect();
    let titles: Vec<String> = names.iter().map(|name| words(name)).collect();
    let rows: Vec<&str> = titles.iter().map(String::as_str).collect();
    let is_own = scene.joints.is_empty();
    let chosen = names.iter().position(|name| *name == scene.posture).filter(|_| is_own);
    let shown = chosen.map_or("A posture of the robot…", |index| rows[index]);
    if let Some(index) = dropdown(ui, "Posture", shown, ui.available_width(), &rows, chosen) {
        out.push(Command::Pose(PoseCommand::Posture(names[index].clone())));
    }
}
