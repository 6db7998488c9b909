//! The window that asks what the files of a robot leave open: arms, hands, place, start posture.

use egui::{Id, Modal, ScrollArea, Ui};
use endcomfort_core::guest::ArmDescription;
use endcomfort_core::robot::Placement;

use super::{Out, bringing_files};
use crate::viewer::bringing::{HANDS, RobotDraft, RobotWindow, given_hand, joint_count};
use crate::viewer::fields::dropdown;
use crate::viewer::number::{Number, Touch, number};
use crate::viewer::theme::{BODY, SECONDARY, Tokens};
use crate::viewer::widgets::{
    overlay_frame, paragraph, primary_button, secondary_button, section, segmented, segmented_wide, switch, title,
};
use crate::viewer::{BringCommand, Bringing, Command, ViewerState};

const WIDTH: f32 = 460.0;
/// Titles of [`HANDS`], after the arm's own fingers.
const HAND_TITLES: [&str; 4] = ["Its own fingers", "Parallel gripper", "Three-finger hand", "Adaptive gripper"];
/// Names of frames as they are turned against a link: its z points out of the arm along this axis of the link.
const AXES: [&str; 6] = ["+z", "-z", "+x", "-x", "+y", "-y"];

/// Fields of one arm; every name is told apart for assistive technology.
struct Names {
    arm: &'static str,
    base: &'static str,
    tip: &'static str,
    hand: &'static str,
    axis: &'static str,
    fields: [Number; 6],
}

const fn metres(name: &'static str) -> Number {
    Number { name, unit: "m", decimals: 3, per_point: 0.001, tip: "Place of the frame in the link" }
}

const fn degrees(name: &'static str) -> Number {
    Number { name, unit: "°", decimals: 1, per_point: 0.5, tip: "Turn about fixed axes: x, then y, then z" }
}

const ARMS: [Names; 2] = [
    Names {
        arm: "Left arm",
        base: "Base link of the left arm",
        tip: "Tip link of the left arm",
        hand: "Hand of the left arm",
        axis: "Left hand points along",
        fields: [
            metres("left frame x, m"),
            metres("left frame y, m"),
            metres("left frame z, m"),
            degrees("left frame roll, °"),
            degrees("left frame pitch, °"),
            degrees("left frame yaw, °"),
        ],
    },
    Names {
        arm: "Right arm",
        base: "Base link of the right arm",
        tip: "Tip link of the right arm",
        hand: "Hand of the right arm",
        axis: "Right hand points along",
        fields: [
            metres("right frame x, m"),
            metres("right frame y, m"),
            metres("right frame z, m"),
            degrees("right frame roll, °"),
            degrees("right frame pitch, °"),
            degrees("right frame yaw, °"),
        ],
    },
];

const STAND: [Number; 4] = [
    Number { name: "stands at x, m", unit: "m", decimals: 3, per_point: 0.005, tip: "Towards the table" },
    Number { name: "stands at y, m", unit: "m", decimals: 3, per_point: 0.005, tip: "To the left" },
    Number { name: "stands at z, m", unit: "m", decimals: 3, per_point: 0.005, tip: "Above the floor" },
    Number { name: "turned by, °", unit: "°", decimals: 1, per_point: 0.5, tip: "About the vertical" },
];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    match &state.bringing {
        None => {}
        Some(Bringing::Robot(window)) => robot(ui, window, out),
        Some(Bringing::Depth(window)) => bringing_files::depth(ui, window, out),
        Some(Bringing::Mesh(window)) => bringing_files::mesh(ui, window, out),
    }
}

fn robot(ui: &mut Ui, window: &RobotWindow, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let frame = overlay_frame(tokens, 22);
    let room = ui.max_rect();
    let width = WIDTH.min(room.width() - 60.0);
    let mut draft = window.draft.clone();
    let modal = Modal::new(Id::unique("Bringing")).frame(frame).backdrop_color(tokens.scrim).show(ui.ctx(), |ui| {
        ui.set_width(width);
        title(ui, &format!("Arms and hands of {}", window.guest.title()));
        ui.add_space(6.0);
        if let Some(problem) = &window.problem {
            let _text = paragraph(ui, problem, BODY, tokens.coral);
            ui.add_space(4.0);
        }
        let height = (room.height() - 230.0).max(160.0);
        ScrollArea::vertical().max_height(height).show(ui, |ui| {
            ui.set_width(width - 10.0);
            arms(ui, window, &mut draft);
            stand(ui, &mut draft);
            posture(ui, window, &mut draft);
            if !window.notes.is_empty() {
                section(ui, "What was found");
                for note in &window.notes {
                    let _text = paragraph(ui, note, SECONDARY, tokens.secondary);
                }
            }
        });
        ui.add_space(12.0);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            if primary_button(ui, "Use this robot", true).clicked() {
                out.push(Command::Bring(BringCommand::Accept { is_grasped: false }));
            }
            if secondary_button(ui, "Save the choice", true).clicked() {
                out.push(Command::Bring(BringCommand::SaveChoice));
            }
            if secondary_button(ui, "Cancel", true).clicked() {
                out.push(Command::Bring(BringCommand::Cancel));
            }
        });
    });
    if modal.should_close() {
        out.push(Command::Bring(BringCommand::Cancel));
    } else if draft != window.draft {
        out.commands.insert(0, Command::Bring(BringCommand::Draft(draft)));
    }
}

fn arms(ui: &mut Ui, window: &RobotWindow, draft: &mut RobotDraft) {
    if draft.arms.is_empty() {
        let text = "Its SRDF names its arms and hands.";
        let _text = paragraph(ui, text, SECONDARY, Tokens::of(ui).secondary);
        return;
    }
    let chosen = Some(draft.arms.len() - 1);
    if let Some(index) = segmented_wide(ui, "Arms", &["One arm", "Two arms"], chosen) {
        draft.arms.truncate(index + 1);
        if draft.arms.len() < index + 1 {
            let other = if draft.arms[0].name == "left" { "right" } else { "left" };
            draft.arms.push(ArmDescription { name: other.to_owned(), ..draft.arms[0].clone() });
        }
        draft.posture = None;
    }
    let before = draft.arms.clone();
    for arm in &mut draft.arms {
        let names = &ARMS[usize::from(arm.name == "right")];
        section(ui, names.arm);
        one_arm(ui, window, arm, names);
    }
    if draft.arms != before {
        // Another arm starts from another posture.
        draft.posture = None;
    }
}

fn one_arm(ui: &mut Ui, window: &RobotWindow, arm: &mut ArmDescription, names: &Names) {
    let tokens = Tokens::of(ui);
    let links: Vec<&str> = window.links.iter().map(String::as_str).collect();
    let wide = ui.available_width();
    let link = |ui: &mut Ui, name: &'static str, words: &str, present: &mut String| {
        let chosen = links.iter().position(|link| link == present);
        if let Some(index) = dropdown(ui, name, &format!("{words}: {present}"), wide, &links, chosen) {
            links[index].clone_into(present);
        }
        ui.add_space(4.0);
    };
    link(ui, names.base, "from", &mut arm.base_link);
    link(ui, names.tip, "to", &mut arm.tip_link);
    let said = match joint_count(window, arm) {
        None => Some(format!("{} does not descend from {}.", arm.tip_link, arm.base_link)),
        Some((found, wanted)) if found < wanted => {
            Some(format!("{found} moving joints between them, an arm needs at least {wanted}."))
        }
        Some(_) => None,
    };
    if let Some(said) = said {
        let _text = paragraph(ui, &said, SECONDARY, tokens.coral);
    }
    let present = match &arm.hand {
        None => 0,
        Some(hand) => HANDS.iter().position(|(_, name)| *name == hand.name).map_or(usize::MAX, |index| index + 1),
    };
    let own = arm.hand.as_ref().map_or(HAND_TITLES[0], |hand| hand.name.as_str()).to_owned();
    let shown = HAND_TITLES.get(present).map_or(own.as_str(), |title| title);
    if let Some(index) = dropdown(ui, names.hand, &format!("hand: {shown}"), wide, &HAND_TITLES, Some(present)) {
        arm.hand = index.checked_sub(1).and_then(|index| given_hand(HANDS[index].0));
    }
    ui.add_space(4.0);
    let text = if arm.hand.is_some() {
        "Where the hand is mounted on the tip link: z out of the arm, x along its closing direction."
    } else {
        "The hand frame in the tip link: between the finger tips, z out of the palm, x along the closing direction."
    };
    let _text = paragraph(ui, text, SECONDARY, tokens.secondary);
    ui.add_space(2.0);
    let chosen = (0..AXES.len()).find(|&axis| is_turned(&arm.tcp, axis));
    if let Some(axis) = segmented(ui, names.axis, &AXES, chosen) {
        arm.tcp.rpy = turned(axis);
    }
    ui.add_space(4.0);
    ui.spacing_mut().item_spacing.x = 6.0;
    let width = (wide - 12.0) / 3.0;
    for row in names.fields.chunks(3) {
        ui.horizontal(|ui| {
            for field in row {
                let index = names.fields.iter().position(|other| other.name == field.name).unwrap_or(0);
                let (list, per_si) = if index < 3 { (&mut arm.tcp.xyz, 1.0) } else { (&mut arm.tcp.rpy, DEGREE) };
                let value = &mut list[index % 3];
                if let Some(typed) = changed(number(ui, field, *value * per_si, width)) {
                    *value = typed / per_si;
                }
            }
        });
        ui.add_space(4.0);
    }
}

/// Degrees in a radian.
const DEGREE: f64 = 180.0 / std::f64::consts::PI;

fn changed(touch: Touch) -> Option<f64> {
    match touch {
        Touch::Released(value) | Touch::Set(value) => Some(value),
        Touch::None | Touch::Dragged(_) => None,
    }
}

/// Roll, pitch and yaw of a frame whose z is along an axis of the link.
fn turned(axis: usize) -> [f64; 3] {
    let quarter = std::f64::consts::FRAC_PI_2;
    match axis {
        0 => [0.0; 3],
        1 => [2.0 * quarter, 0.0, 0.0],
        2 => [0.0, quarter, 0.0],
        3 => [0.0, -quarter, 0.0],
        4 => [-quarter, 0.0, 0.0],
        _ => [quarter, 0.0, 0.0],
    }
}

fn is_turned(tcp: &Placement, axis: usize) -> bool {
    turned(axis).iter().zip(&tcp.rpy).all(|(a, b)| (a - b).abs() < 1e-6)
}

fn stand(ui: &mut Ui, draft: &mut RobotDraft) {
    section(ui, "Where it stands");
    if switch(ui, "Find a place behind the table", draft.stand.is_none()) {
        draft.stand = if draft.stand.is_none() { Some(Placement::default()) } else { None };
        draft.posture = None;
    }
    let Some(stand) = &mut draft.stand else { return };
    let width = (ui.available_width() - 18.0) / 4.0;
    let mut is_moved = false;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        for (index, field) in STAND.iter().enumerate() {
            let value = if index < 3 { stand.xyz[index] } else { stand.rpy[2] * DEGREE };
            let Some(typed) = changed(number(ui, field, value, width)) else { continue };
            is_moved = true;
            match index {
                3 => stand.rpy[2] = typed / DEGREE,
                index => stand.xyz[index] = typed,
            }
        }
    });
    if is_moved {
        draft.posture = None;
    }
}

fn posture(ui: &mut Ui, window: &RobotWindow, draft: &mut RobotDraft) {
    section(ui, "Start posture");
    if switch(ui, "Find one with the hands over the table", draft.posture.is_none()) {
        draft.posture = if draft.posture.is_none() { Some(vec![0.0; window.joints.len()]) } else { None };
    }
    let Some(values) = &mut draft.posture else { return };
    let tokens = Tokens::of(ui);
    for (index, ((name, slides), value)) in window.joints.iter().zip(values).enumerate() {
        let (unit, per_si) = if *slides { ("m", 1.0) } else { ("°", DEGREE) };
        ui.horizontal(|ui| {
            let field = Number { name: "position", unit, decimals: 1, per_point: 0.5, tip: "Where this joint starts" };
            ui.push_id(index, |ui| {
                if let Some(typed) = changed(number(ui, &field, *value * per_si, 90.0)) {
                    *value = typed / per_si;
                }
            });
            let _text = paragraph(ui, name, SECONDARY, tokens.secondary);
        });
    }
}
