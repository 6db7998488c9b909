//! The moment: what happens, how far the arm is from its limits, where the joints stand.

use egui::Ui;
use endcomfort_core::job::Stage;

use super::inspector::nothing_yet;
use super::{Out, joints};
use crate::viewer::fields::tabs;
use crate::viewer::theme::{SECONDARY, Tokens};
use crate::viewer::widgets::{key_value, paragraph, primary_button, section, title};
use crate::viewer::{Command, PlanCommand, PlayPage, ViewerState, format, playback};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let Some(plan) = &state.outputs.plan else { return nothing_yet(ui, state, Stage::Plan) };
    let time_s = state.playback.time_s;
    let Some(phase) = playback::phase_at(plan, time_s) else { return };
    let titles = PlayPage::ALL.map(PlayPage::title);
    if let Some(index) = tabs(ui, &titles, Some(state.planning.play_page as usize)) {
        out.push(Command::Planning(PlanCommand::PlayPage(PlayPage::ALL[index])));
    }
    if state.planning.play_page == PlayPage::Joints {
        return joints::draw(ui, state, plan, out);
    }
    title(ui, &format::title_of(phase.kind.name()));
    let what = if phase.carries { "The hand carries the object." } else { "The hand is free." };
    let _text = paragraph(ui, what, SECONDARY, tokens.secondary);
    ui.add_space(6.0);
    let _row = key_value(ui, "Time", &format!("{} of {}", format::clock(time_s), format::clock(state.duration_s())));
    if let Some(m) = playback::manipulability_at(plan, time_s) {
        let _row = key_value(ui, "Manipulability m(q)", &format::manipulability(m));
    }
    if let Some(clearance_m) = playback::clearance_at(plan, time_s) {
        let _row = key_value(ui, "Clearance", &format::length(clearance_m));
    }
    section(ui, "Joints of the arm, from shoulder to wrist");
    let positions = phase.trajectory.at(time_s - phase.start_s);
    // The trajectory's first columns are the arm's joints, all of them revolute; the hand's follow.
    let arm = state.arm_joint_count().min(positions.len());
    for (index, position) in positions.iter().take(arm).enumerate() {
        let text = format!("{:.1}°  ·  {position:.3} rad", position.to_degrees());
        let _row = key_value(ui, &format!("Joint {}", index + 1), &text);
    }
    ui.add_space(10.0);
    let word = if state.playback.playing { "Pause" } else { "Play" };
    if primary_button(ui, word, true).clicked() {
        out.push(Command::SetPlaying(!state.playback.playing));
    }
}
