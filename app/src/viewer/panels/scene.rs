//! The scene: what stands where, who acts, what is asked for.

use egui::Ui;
use endcomfort_core::job::Stage;
use endcomfort_core::scene::ArmChoice;
use nalgebra::{Point3, Vector3};

use super::Out;
use super::inspector::heading;
use super::{own_robot, things};
use crate::viewer::layout::Layout;
use crate::viewer::state::Step;
use crate::viewer::theme::{SECONDARY, Tokens};
use crate::viewer::widgets::{key_value, paragraph, secondary_button, section, segmented};
use crate::viewer::{Command, PlanCommand, PlanPage, PoseCommand, ReachCommand, ViewerState, format};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let scene = &state.document.scene;
    match &state.document.cloud {
        Some(cloud) => {
            let size = format::count(cloud.bytes.len() / 1024);
            heading(
                ui,
                state,
                Stage::Scene,
                &cloud.name,
                &format!("Dropped by you, {size} kB, instead of the scene's objects."),
            );
        }
        None => heading(ui, state, Stage::Scene, &scene.title, &scene.summary),
    }
    if Layout::new(ui.ctx().content_rect(), None).is_phone {
        super::top_bar::robot_switch(ui, state, out);
        ui.add_space(6.0);
    }
    if scene.handover.is_none() && state.has_arm(scene.arm.other()) {
        ui.horizontal(|ui| {
            let chosen = Some(usize::from(scene.arm == ArmChoice::Right));
            if let Some(index) = segmented(ui, "Arm", &["Left arm", "Right arm"], chosen) {
                out.push(Command::SetArm(if index == 0 { ArmChoice::Left } else { ArmChoice::Right }));
            }
        });
        ui.add_space(4.0);
    }
    let _row = key_value(ui, "Robot", &start(state));
    if let Some(agent) = state.receiver() {
        let [x, y] = agent.position_m;
        let text = format!("{}, {}, at {x:.2}, {y:.2} m", format::title_of(&agent.model), agent.posture);
        let _row = key_value(ui, "Receiver", &text);
    }
    let _row = key_value(ui, "Task", &task(state));
    let _row = key_value(ui, "Table", &table(state));
    let _row = key_value(ui, "Seed", &scene.seed.to_string());

    ui.add_space(4.0);
    let (words, page) = match scene.handover {
        None => ("Edit the task", PlanPage::Task),
        Some(_) => ("Edit the handover", PlanPage::Handover),
    };
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.y = 6.0;
        ui.spacing_mut().item_spacing.x = 8.0;
        if secondary_button(ui, words, true).clicked() {
            out.push(Command::SelectStep(Step::Stage(Stage::Plan)));
            out.push(Command::Planning(PlanCommand::Page(page)));
        }
        if secondary_button(ui, "Pose the robot", true).clicked() {
            out.push(Command::Pose(PoseCommand::Open));
        }
        if secondary_button(ui, "What the arms reach", true).clicked() {
            out.push(Command::Reach(ReachCommand::Open));
        }
    });

    own_robot::draw(ui, state, out);
    things::draw(ui, state, out);

    section(ui, "Camera");
    let z = scene.X_WC.rotation * Vector3::z();
    let down_deg = (-z.z).max(-1.0).min(1.0).asin().to_degrees();
    let _row = key_value(ui, "Looks down by", &format!("{down_deg:.0}°"));
    if let Some(output) = &state.outputs.scene {
        let cloud = &output.cloud;
        let _row = key_value(ui, "Points", &format::count(cloud.points.len()));
        if let Some(grid) = &cloud.grid {
            let _row = key_value(ui, "Image", &format!("{} × {}", grid.width, grid.height));
        }
        if !output.notes.is_empty() {
            section(ui, "Notes");
            for note in &output.notes {
                let _text = paragraph(ui, note, SECONDARY, tokens.secondary);
            }
        }
    }
}

/// Which robot starts how.
fn start(state: &ViewerState) -> String {
    let scene = &state.document.scene;
    let posture = scene.posture.replace('_', " ");
    match scene.joints.is_empty() {
        true => format!("{}, from posture {posture}", state.robot_title()),
        false => format!("{}, posed by hand", state.robot_title()),
    }
}

/// A position in the world, metres.
pub(super) fn at(p: &Point3<f64>) -> String {
    format!("{:.2}, {:.2}, {:.2} m", p.x, p.y, p.z)
}

fn task(state: &ViewerState) -> String {
    let scene = &state.document.scene;
    let object =
        scene.objects.get(scene.task.object).map_or("object".to_owned(), |placed| placed.object.replace('_', " "));
    let object = if state.document.cloud.is_some() { "what was found".to_owned() } else { format!("the {object}") };
    if let Some([_, receiver]) = state.partners().filter(|_| state.receiver().is_some()) {
        return format!("hand {object} to {}", receiver.words);
    }
    match scene.task.X_WO_goal() {
        None => format!("lift {object}"),
        Some(X_WO_goal) if scene.task.steps.len() > 1 => {
            let steps = scene.task.steps.len();
            format!("move {object} in {steps} steps, at last to {}", at(&X_WO_goal.translation.vector.into()))
        }
        Some(X_WO_goal) => format!("move {object} to {}", at(&X_WO_goal.translation.vector.into())),
    }
}

fn table(state: &ViewerState) -> String {
    let table = &state.document.scene.table;
    let [x, y] = table.size_m;
    format!("{x:.2} × {y:.2} m, {:.2} m high", table.height_m)
}
