//! Where the receiver stands and how, and how a place for the handover is chosen.

use egui::Ui;
use endcomfort_core::handover::{Agent, Handover, PlaceChoice, Receiver};
use endcomfort_core::scene::ArmChoice;

use super::task::{explain, triple};
use crate::assets;
use crate::viewer::number::{Number, Touch, number_row};
use crate::viewer::panels::Out;
use crate::viewer::theme::{SECONDARY, Tokens};
use crate::viewer::widgets::{paragraph, secondary_button, section, segmented_wide, switch};
use crate::viewer::{Command, HandoverCommand, format};

/// How somebody can wait for the object, in the order of the buttons.
const POSTURES: [&str; 4] = ["standing", "serving", "sitting", "kneeling"];
/// Which arm acts.
const ARMS: [Option<ArmChoice>; 3] = [None, Some(ArmChoice::Left), Some(ArmChoice::Right)];
/// Highest thing that somebody stands on, metres.
const HIGHEST_M: f64 = 2.0;

pub(super) fn draw(ui: &mut Ui, handover: &Handover, out: &mut Out) {
    let mut wanted = handover.clone();
    if let Receiver::Agent(agent) = &mut wanted.receiver {
        section(ui, "Receiver");
        place(ui, agent, out);
        posture(ui, agent);
        caption(ui, "Takes with");
        arm(ui, "Receiving arm", &mut agent.arm);
    }
    caption(ui, "Gives with");
    arm(ui, "Giving arm", &mut wanted.giver_arm);
    choice(ui, &mut wanted.choice);
    if wanted != *handover {
        out.push(Command::Handover(HandoverCommand::Set(Box::new(wanted))));
    }
}

fn caption(ui: &mut Ui, text: &str) {
    ui.add_space(4.0);
    let color = Tokens::of(ui).secondary;
    let _text = paragraph(ui, text, SECONDARY, color);
}

/// Position, turn and height; dragging a number moves the receiver live.
fn place(ui: &mut Ui, agent: &Agent, out: &mut Out) {
    let [x, y] = agent.position_m;
    let millimetres = |name, tip| Number { name, unit: "mm", decimals: 0, per_point: 2.0, tip };
    let touched = triple(
        ui,
        [
            (millimetres("Receiver x, mm", "In the world, away from the robot"), "x", 1e3 * x),
            (millimetres("Receiver y, mm", "In the world, to the robot's left"), "y", 1e3 * y),
            (millimetres("Receiver height, mm", "Of what it stands on, above the floor"), "z", 1e3 * agent.floor_m),
        ],
    );
    if let Some((axis, touch)) = touched {
        let to = |mm: f64| {
            let mut moved = agent.clone();
            match axis {
                0 | 1 => moved.position_m[axis] = 1e-3 * mm,
                _ => moved.floor_m = (1e-3 * mm).max(0.0).min(HIGHEST_M),
            }
            moved
        };
        send(touch, to, out);
    }
    let tip = "About the vertical; 0° looks away from the robot";
    let field = Number { name: "Receiver turn, °", unit: "°", decimals: 0, per_point: 0.5, tip };
    let touch = ui.horizontal(|ui| {
        let touch = crate::viewer::number::number(ui, &field, agent.yaw_rad.to_degrees(), 84.0);
        let color = Tokens::of(ui).text;
        let words = egui::RichText::new("turned about the vertical");
        let _text = ui.label(words.font(crate::viewer::theme::font(crate::viewer::theme::BODY)).color(color));
        touch
    });
    send(touch.inner, |deg| Agent { yaw_rad: deg.to_radians(), ..agent.clone() }, out);
    explain(ui, "Or drag it in the view: the middle moves it, the ring turns it.");
    ui.add_space(4.0);
}

/// The receiver on its way, or at its place.
fn send(touch: Touch, to: impl Fn(f64) -> Agent, out: &mut Out) {
    let drag = |value: f64| Command::Handover(HandoverCommand::DragReceiver(Box::new(to(value))));
    match touch {
        Touch::None => {}
        Touch::Dragged(value) => out.push(drag(value)),
        Touch::Released(value) | Touch::Set(value) => {
            out.push(drag(value));
            out.push(Command::Handover(HandoverCommand::EndDrag));
        }
    }
}

fn posture(ui: &mut Ui, agent: &mut Agent) {
    let Ok(model) = assets::library().robot(&agent.model) else { return };
    let known: Vec<&str> = POSTURES.into_iter().filter(|posture| model.posture(posture).is_some()).collect();
    let titles: Vec<String> = known.iter().map(|posture| format::title_of(posture)).collect();
    let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
    let chosen = known.iter().position(|posture| *posture == agent.posture);
    if let Some(index) = segmented_wide(ui, "Posture", &titles, chosen) {
        agent.posture = known[index].to_owned();
    }
}

fn arm(ui: &mut Ui, name: &str, arm: &mut Option<ArmChoice>) {
    let chosen = ARMS.iter().position(|known| known == arm);
    if let Some(index) = segmented_wide(ui, name, &["Better arm", "Left arm", "Right arm"], chosen) {
        *arm = ARMS[index];
    }
}

fn choice(ui: &mut Ui, wanted: &mut PlaceChoice) {
    section(ui, "Choice of the place");
    if switch(ui, "The receiver's ease first", wanted.receiver_first) {
        wanted.receiver_first = !wanted.receiver_first;
    }
    explain(
        ui,
        if wanted.receiver_first {
            "Its manipulability counts first, its hand along the line that joins the shoulders; of a person its \
             comfort too."
        } else {
            "The place nearest to the way from start to goal."
        },
    );
    ui.add_space(4.0);
    let field = |name, unit, tip| Number { name, unit, decimals: 0, per_point: 0.2, tip };
    let tip = "Share of an arm's largest mean manipulability that a voxel needs, for both hands";
    let words = "of the best for either hand";
    if let Some(percent) = number_row(ui, &field("Threshold, %", "%", tip), 100.0 * wanted.threshold, words) {
        wanted.threshold = 0.01 * percent.max(0.0).min(100.0);
    }
    let tip = "More places, more chances, more time";
    if let Some(count) =
        number_row(ui, &field("Places", "", tip), wanted.places as f64, "places looked at more closely")
    {
        wanted.places = count.max(1.0).min(500.0).round() as usize;
    }
    let tip = "Top speed of the giver's hand on its way to a person";
    let mm_s = 1e3 * wanted.hand_speed_m_s;
    if let Some(mm_s) = number_row(ui, &field("Hand speed, mm/s", "mm/s", tip), mm_s, "at most, towards a person") {
        wanted.hand_speed_m_s = 1e-3 * mm_s.max(10.0).min(5000.0);
    }
    ui.add_space(8.0);
    if secondary_button(ui, "Usual choice", *wanted != PlaceChoice::default()).clicked() {
        *wanted = PlaceChoice::default();
    }
}
