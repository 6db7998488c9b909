//! How the robot moves: planner, room, speed, straight ways, regrasping.

use egui::Ui;
use endcomfort_core::task::{MotionSettings, Planner};

use crate::viewer::number::{Number, number_row};
use crate::viewer::panels::Out;
use crate::viewer::theme::{SECONDARY, Tokens};
use crate::viewer::widgets::{paragraph, secondary_button, section, segmented_wide, switch};
use crate::viewer::{Command, PlanCommand, ViewerState, planner_title};

const PLANNERS: [Planner; 3] = [Planner::Search, Planner::Roadmap, Planner::Routes];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let present = &state.document.scene.motion;
    let mut wanted = present.clone();

    section(ui, "Planner");
    let chosen = PLANNERS.iter().position(|&planner| planner == present.planner);
    if let Some(index) = segmented_wide(ui, "Planner", &PLANNERS.map(planner_title), chosen) {
        wanted.planner = PLANNERS[index];
    }
    explain(
        ui,
        match present.planner {
            Planner::Search => {
                "The IK-BiRRT: two random trees in joint space, with every IK solution as a goal. The same seed gives \
                 the same plan."
            }
            Planner::Roadmap => "A roadmap of the arm's joint space, made once and searched: no random numbers.",
            Planner::Routes => {
                "Clearly different routes of the hand round what stands there; the arm follows with its null space. \
                 No random numbers."
            }
        },
    );
    ui.add_space(4.0);
    let field = whole("Seed", "", "Of everything random: another seed, another cloud and another search");
    if let Some(seed) = number_row(ui, &field, state.document.scene.seed as f64, "seed of everything random") {
        out.push(Command::SetSeed(seed.max(0.0).round() as u64));
    }
    let tip = "Kept where there is room; narrow places are passed closer";
    if let Some(mm) =
        number_row(ui, &whole("Clearance, mm", "mm", tip), 1e3 * present.clearance_m, "kept from everything")
    {
        wanted.clearance_m = 1e-3 * mm.max(0.0).min(200.0);
    }

    section(ui, "Share of the joints' limits");
    for (name, words, value) in [
        ("Speed, %", "of the speed limits", &mut wanted.velocity_scale),
        ("Acceleration, %", "of the acceleration limits", &mut wanted.acceleration_scale),
        ("Jerk, %", "of the jerk limits", &mut wanted.jerk_scale),
    ] {
        if let Some(percent) = number_row(ui, &whole(name, "%", "1 to 100 %"), 100.0 * *value, words) {
            *value = 0.01 * percent.max(1.0).min(100.0);
        }
    }

    section(ui, "Straight ways");
    let tip = "Of the open hand, before it closes and after it lets go";
    if let Some(mm) =
        number_row(ui, &whole("Approach, mm", "mm", tip), 1e3 * present.approach_m, "to the grasp and back")
    {
        wanted.approach_m = 1e-3 * mm.max(1e3 * present.min_approach_m).min(500.0);
    }
    let tip = "A shorter one does not count";
    let field = whole("Shortest approach, mm", "mm", tip);
    if let Some(mm) = number_row(ui, &field, 1e3 * present.min_approach_m, "at least") {
        wanted.min_approach_m = 1e-3 * mm.max(0.0).min(1e3 * present.approach_m);
    }
    let tip = "After the grasp, and down at the goal";
    if let Some(mm) = number_row(ui, &whole("Lift, mm", "mm", tip), 1e3 * present.lift_m, "up, and down again") {
        wanted.lift_m = 1e-3 * mm.max(1.0).min(500.0);
    }

    section(ui, "Grasps");
    let tip = "Then the task is refused";
    let field = whole("Grasps tried", "", tip);
    if let Some(count) = number_row(ui, &field, present.max_grasps as f64, "grasps tried before it is refused") {
        wanted.max_grasps = count.max(1.0).min(1000.0).round() as usize;
    }
    if switch(ui, "Put it down and grasp it anew if need be", present.regrasp) {
        wanted.regrasp = !present.regrasp;
    }

    ui.add_space(10.0);
    if secondary_button(ui, "Usual motion", *present != MotionSettings::default()).clicked() {
        wanted = MotionSettings::default();
    }
    if wanted != *present {
        out.push(Command::Planning(PlanCommand::Settings(wanted)));
    }
}

fn whole(name: &'static str, unit: &'static str, tip: &'static str) -> Number {
    Number { name, unit, decimals: 0, per_point: 0.2, tip }
}

/// A sentence under a field.
fn explain(ui: &mut Ui, text: &str) {
    ui.add_space(2.0);
    let color = Tokens::of(ui).secondary;
    let _text = paragraph(ui, text, SECONDARY, color);
}
