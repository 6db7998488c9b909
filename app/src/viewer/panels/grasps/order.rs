//! What counts in the order of the grasps.

use egui::Ui;
use endcomfort_core::grasp::{RankBy, RankSettings, Weights};
use endcomfort_core::scene::{MAX_ARM_ANGLES, MAX_WEIGHT};

use super::explain;
use crate::viewer::number::{Number, number_row};
use crate::viewer::panels::Out;
use crate::viewer::widgets::{secondary_button, section, segmented_wide};
use crate::viewer::{Command, GraspCommand, ViewerState};

/// What a person calls a term of the score.
pub(super) fn weight_title(name: &str) -> &str {
    match name {
        "m_g_goal" => "m_g at the goal",
        "m_g_start" => "m_g at the start",
        "ik_count" => "N",
        "epsilon" => "Quality ε",
        "success" => "Success",
        "clearance" => "Clearance",
        other => other,
    }
}

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let present = &state.document.scene.rank;
    let mut wanted = present.clone();
    section(ui, "Ranked by");
    let words = ["m_g goal", "Start", "Mean", "Score", "ε", "Random"];
    let chosen = RankBy::ALL.iter().position(|&by| by == present.by);
    if let Some(index) = segmented_wide(ui, "Ranked by", &words, chosen) {
        wanted.by = RankBy::ALL[index];
    }
    explain(
        ui,
        match present.by {
            RankBy::Goal => {
                "Mean manipulability where the object is put down: the end-comfort effect. Without a goal, at the start."
            }
            RankBy::Start => "Mean manipulability where the object stands.",
            RankBy::Mean => "The mean of both.",
            RankBy::Score => "A weighted sum; each term is compared with the best of all accepted grasps.",
            RankBy::Epsilon => "The largest-ball quality alone: a control that knows nothing of the arm.",
            RankBy::Random => "In the order of chance, by the seed: the control that everything has to beat.",
        },
    );
    if present.by == RankBy::Score {
        section(ui, "Weights");
        for (name, weight) in fields(&mut wanted.weights) {
            let field = Number { name, unit: "", decimals: 2, per_point: 0.01, tip: "0 leaves the term out" };
            if let Some(value) = number_row(ui, &field, *weight, weight_title(name)) {
                *weight = value.max(0.0).min(MAX_WEIGHT);
            }
        }
        explain(ui, "The page Grasp shows what each term adds to the score of the selected grasp.");
    }
    section(ui, "IK sets");
    let tip = "Arm angles over a full turn at which every branch is solved";
    let field = Number { name: "Arm angles", unit: "", decimals: 0, per_point: 0.1, tip };
    if let Some(angles) = number_row(ui, &field, present.arm_angles as f64, "arm angles over a full turn") {
        wanted.arm_angles = angles.max(1.0).min(MAX_ARM_ANGLES).round() as usize;
    }
    ui.add_space(10.0);
    if secondary_button(ui, "Usual order", *present != RankSettings::default()).clicked() {
        wanted = RankSettings::default();
    }
    if wanted != *present {
        out.push(Command::Grasping(GraspCommand::Rank(wanted)));
    }
}

/// The weights with the names of their terms.
fn fields(weights: &mut Weights) -> [(&'static str, &mut f64); 6] {
    [
        ("m_g_goal", &mut weights.m_g_goal),
        ("m_g_start", &mut weights.m_g_start),
        ("ik_count", &mut weights.ik_count),
        ("epsilon", &mut weights.epsilon),
        ("success", &mut weights.success),
        ("clearance", &mut weights.clearance),
    ]
}
