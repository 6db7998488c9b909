//! What the robot shall do: the steps of the task, where each one ends, and how exactly.

use egui::{Align, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::scene::{Action, MAX_STEPS, Step};
use nalgebra::{Isometry3, UnitQuaternion};

use crate::viewer::icons::Icon;
use crate::viewer::number::{Number, Touch, number, number_row};
use crate::viewer::panels::Out;
use crate::viewer::panels::scene::at;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::{
    focus_ring, icon_button_at, paragraph, secondary_button, section, segmented_wide, switch, text_in,
};
use crate::viewer::{Command, PlanCommand, ViewerState};

const ROW: f32 = 32.0;
/// How far a row reaches into the panel's margin, points.
const OUTSIDE: f32 = 13.0;
/// How far beside the last goal a new one stands, metres.
const BESIDE_M: f64 = 0.12;
/// How long something is held unless somebody says otherwise, seconds.
const HOLD_S: f64 = 2.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let scene = &state.document.scene;
    let task = &scene.task;
    let object = scene.objects.get(task.object).map_or("object", |placed| placed.object.as_str());
    let text = match task.steps.len() {
        0 => format!("Grasp the {} and lift it. A step says where it goes.", object.replace('_', " ")),
        _ => format!("What happens to the {}, one step after the other.", object.replace('_', " ")),
    };
    let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
    ui.add_space(4.0);
    let selected = state.planning.step.min(task.steps.len().saturating_sub(1));
    for (index, step) in task.steps.iter().enumerate() {
        row(ui, &task.steps, index, step, index == selected, out);
    }
    ui.add_space(6.0);
    if secondary_button(ui, "Add a step", task.steps.len() < MAX_STEPS).clicked() {
        let mut steps = task.steps.clone();
        let before = steps.last().map(|step| step.X_WO_goal);
        let from = before.or_else(|| scene.objects.get(task.object).map(|placed| placed.X_WO)).unwrap_or_default();
        steps.push(Step::put(Isometry3::translation(0.0, BESIDE_M, 0.0) * from));
        out.push(Command::Planning(PlanCommand::SelectGoal(steps.len() - 1)));
        out.push(Command::Planning(PlanCommand::Steps(steps)));
    }
    if let Some(step) = task.steps.get(selected) {
        edit(ui, &task.steps, selected, step, out);
    }
}

/// A step in a line, with the buttons that move or remove it.
fn row(ui: &mut Ui, steps: &[Step], index: usize, step: &Step, is_selected: bool, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let full = rect.expand2(vec2(OUTSIDE, 0.0));
    if is_selected {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let text = said(step);
    let number = Rect::from_min_max(rect.min, pos2(rect.left() + 18.0, rect.bottom()));
    let id = if is_selected { strong(BODY) } else { font(BODY) };
    let _number = text_in(ui, number, Align::Min, &(index + 1).to_string(), id.clone(), tokens.secondary);
    let words = Rect::from_min_max(pos2(number.right(), rect.top()), pos2(rect.right() - 78.0, rect.bottom()));
    let _text = text_in(ui, words, Align::Min, &text, id, tokens.text);
    focus_ring(ui, &response, full);
    response
        .widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, format!("Step {}: {text}", index + 1)));
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        out.push(Command::Planning(PlanCommand::SelectGoal(index)));
    }
    let last = steps.len() - 1;
    for (place, icon, name, enabled, to) in [
        (2.0, Icon::Up, "Earlier", index > 0, Some(index.wrapping_sub(1))),
        (1.0, Icon::Down, "Later", index < last, Some(index + 1)),
        (0.0, Icon::Cross, "Remove", true, None),
    ] {
        let middle = pos2(rect.right() - 12.0 - 25.0 * place, rect.center().y);
        let place = Rect::from_center_size(middle, vec2(24.0, 24.0));
        if icon_button_at(ui, place, icon, &format!("{name}: step {}", index + 1), enabled).clicked() {
            let mut steps = steps.to_vec();
            let step = steps.remove(index);
            if let Some(to) = to {
                steps.insert(to, step);
                out.push(Command::Planning(PlanCommand::SelectGoal(to)));
            }
            out.push(Command::Planning(PlanCommand::Steps(steps)));
        }
    }
}

/// `Put at 0.62, 0.24, 0.83 m`
fn said(step: &Step) -> String {
    let verb = match step.action {
        Action::Put => "Put at",
        Action::Slide => "Slide to",
        Action::Pour { .. } => "Pour at",
    };
    format!("{verb} {}", at(&step.X_WO_goal.translation.vector.into()))
}

fn edit(ui: &mut Ui, steps: &[Step], index: usize, step: &Step, out: &mut Out) {
    let mut wanted = step.clone();
    section(ui, &format!("Step {}", index + 1));
    action(ui, &mut wanted);
    ui.add_space(6.0);
    pose(ui, index, &step.X_WO_goal, out);
    section(ui, "On the way there");
    let upright = step.keep_upright_rad;
    if switch(ui, "Keep it upright", upright.is_some()) {
        wanted.keep_upright_rad = if upright.is_some() { None } else { Some(15.0_f64.to_radians()) };
    }
    if let Some(angle) = upright {
        let field = degrees("Upright within, °", "Its axis may lean by this much: it may be full");
        if let Some(deg) = number_row(ui, &field, angle.to_degrees(), "from the vertical at most") {
            wanted.keep_upright_rad = Some(deg.max(0.0).min(180.0).to_radians());
        }
    }
    freedom(ui, &mut wanted);
    if wanted != *step {
        let mut steps = steps.to_vec();
        steps[index] = wanted;
        out.push(Command::Planning(PlanCommand::Steps(steps)));
    }
}

fn action(ui: &mut Ui, wanted: &mut Step) {
    let chosen = match wanted.action {
        Action::Put => 0,
        Action::Slide => 1,
        Action::Pour { .. } => 2,
    };
    if let Some(index) = segmented_wide(ui, "Action", &["Put", "Slide", "Pour"], Some(chosen)) {
        // The same one again keeps its time.
        if index != chosen {
            wanted.action = [Action::Put, Action::Slide, Action::Pour { hold_s: HOLD_S }][index];
        }
    }
    explain(
        ui,
        match wanted.action {
            Action::Put => "It is put down there, on whatever is below, and let go.",
            Action::Slide => "It is pushed there without being lifted, and let go.",
            Action::Pour { .. } => "It is held there, tilted if the pose is, and stays in the hand.",
        },
    );
    if let Action::Pour { hold_s } = &mut wanted.action {
        ui.add_space(4.0);
        let field = Number { name: "Held for, s", unit: "s", decimals: 1, per_point: 0.05, tip: "Up to a minute" };
        if let Some(seconds) = number_row(ui, &field, *hold_s, "held there") {
            *hold_s = seconds.max(0.0).min(60.0);
        }
    }
}

/// Place and turn of the goal; dragging a number moves the goal live.
fn pose(ui: &mut Ui, index: usize, X_WO: &Isometry3<f64>, out: &mut Out) {
    let p = X_WO.translation.vector;
    let (roll, pitch, yaw) = X_WO.rotation.euler_angles();
    let millimetres = |name| Number { name, unit: "mm", decimals: 0, per_point: 1.0, tip: "In the world" };
    let lengths = [("Goal x, mm", "x", p.x), ("Goal y, mm", "y", p.y), ("Goal z, mm", "z", p.z)];
    let touched = triple(ui, lengths.map(|(name, letter, m)| (millimetres(name), letter, 1e3 * m)));
    if let Some((axis, touch)) = touched {
        let to = |mm: f64| {
            let mut moved = *X_WO;
            moved.translation.vector[axis] = 1e-3 * mm;
            moved
        };
        send(touch, index, to, out);
    }
    let angles = [
        (degrees("Goal yaw, °", "About the vertical"), "yaw", yaw),
        (degrees("Goal roll, °", "About its own x: tilted sideways"), "roll", roll),
        (degrees("Goal pitch, °", "About its own y: tilted forward, within ±90°"), "pitch", pitch),
    ];
    let touched = triple(ui, angles.map(|(field, word, rad)| (field, word, rad.to_degrees())));
    if let Some((axis, touch)) = touched {
        let to = |deg: f64| {
            let mut ypr = [yaw, roll, pitch];
            ypr[axis] = if axis == 2 { deg.max(-90.0).min(90.0) } else { deg }.to_radians();
            let rotation = UnitQuaternion::from_euler_angles(ypr[1], ypr[2], ypr[0]);
            Isometry3::from_parts(X_WO.translation, rotation)
        };
        send(touch, index, to, out);
    }
    explain(ui, "Or drag it in the view: the middle moves it, the ring turns it, the arrow lifts it.");
}

/// Three numbers side by side; gives the one that was touched.
pub(super) fn triple(ui: &mut Ui, fields: [(Number, &str, f64); 3]) -> Option<(usize, Touch)> {
    let tokens = Tokens::of(ui);
    let width = (ui.available_width() - 2.0 * 8.0) / 3.0;
    let mut touched = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (place, (field, word, value)) in fields.iter().enumerate() {
            let (rect, _) = ui.allocate_exact_size(vec2(width, 26.0), Sense::hover());
            let name = rect.with_max_x(rect.left() + if word.len() > 1 { 34.0 } else { 14.0 });
            let _text = text_in(ui, name, Align::Min, word, font(SECONDARY), tokens.secondary);
            let mut inside = ui.new_child(egui::UiBuilder::new().max_rect(rect.with_min_x(name.right() + 2.0)));
            match number(&mut inside, field, *value, rect.right() - name.right() - 2.0) {
                Touch::None => {}
                touch => touched = Some((place, touch)),
            }
        }
    });
    ui.add_space(4.0);
    touched
}

/// A number of the goal on its way, or at its place.
fn send(touch: Touch, step: usize, to: impl Fn(f64) -> Isometry3<f64>, out: &mut Out) {
    let drag = |value: f64| Command::Planning(PlanCommand::DragGoal { step, X_WO_goal: to(value) });
    match touch {
        Touch::None => {}
        Touch::Dragged(value) => out.push(drag(value)),
        Touch::Released(value) | Touch::Set(value) => {
            out.push(drag(value));
            out.push(Command::Planning(PlanCommand::EndDrag));
        }
    }
}

/// How far the object may end up from the goal.
fn freedom(ui: &mut Ui, wanted: &mut Step) {
    section(ui, "May differ by");
    let freedom = &mut wanted.freedom;
    let field = degrees("Free yaw, °", "To either side; 180° leaves it free");
    if let Some(deg) = number_row(ui, &field, freedom.yaw_rad.to_degrees(), "about the vertical, 180° for any turn") {
        freedom.yaw_rad = deg.max(0.0).min(180.0).to_radians().min(std::f64::consts::PI);
    }
    let millimetres = |name, tip| Number { name, unit: "mm", decimals: 0, per_point: 1.0, tip };
    for (axis, (name, words)) in
        [("Free area x, mm", "along its x, to either side"), ("Free area y, mm", "along its y, to either side")]
            .into_iter()
            .enumerate()
    {
        let field = millimetres(name, "On the plane that it is put on");
        if let Some(mm) = number_row(ui, &field, 1e3 * freedom.area_m[axis], words) {
            freedom.area_m[axis] = 1e-3 * mm.max(0.0).min(1000.0);
        }
    }
    let field = degrees("Free tilt, °", "Half angle of the cone in which its axis may point");
    if let Some(deg) = number_row(ui, &field, freedom.cone_rad.to_degrees(), "of tilt, to any side") {
        freedom.cone_rad = deg.max(0.0).min(180.0).to_radians();
    }
    if freedom.is_none() {
        explain(ui, "Only the pose itself will do.");
    }
}

fn degrees(name: &'static str, tip: &'static str) -> Number {
    Number { name, unit: "°", decimals: 0, per_point: 0.5, tip }
}

/// A sentence under a field.
pub(super) fn explain(ui: &mut Ui, text: &str) {
    ui.add_space(2.0);
    let color = Tokens::of(ui).secondary;
    let _text = paragraph(ui, text, SECONDARY, color);
}
