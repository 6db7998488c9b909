//! Candidates and ranking: a sentence, the table, and the selected grasp.

use egui::{Align, Rect, Sense, Ui, UiBuilder, pos2, vec2};
use endcomfort_core::grasp::{Grasp, GraspStatus};
use endcomfort_core::job::Stage;
use endcomfort_core::scene::Task;

use super::inspector::{heading, nothing_yet};
use super::{Out, grasp, table};
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{segmented, text_in};
use crate::viewer::{Command, ViewerState, format};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, stage: Stage, out: &mut Out) {
    let outputs = &state.outputs;
    let has_result = if stage == Stage::Rank { outputs.rank.is_some() } else { outputs.grasps.is_some() };
    if !has_result {
        return nothing_yet(ui, state, stage);
    }
    let grasps = outputs.candidates();
    let accepted = grasps.iter().filter(|grasp| grasp.status == GraspStatus::Accepted).count();
    if stage == Stage::Rank {
        let has_goal = matches!(state.document.scene.task, Task::PickAndPlace { .. });
        let (places, order) = if has_goal {
            ("both poses", "Ranked by manipulability where the object is put down: the end-comfort effect.")
        } else {
            ("the object", "Ranked by manipulability where the object stands.")
        };
        let reach = if accepted == 1 { "grasp reaches" } else { "grasps reach" };
        heading(ui, state, stage, &format!("{} {reach} {places}", format::count(accepted)), order);
    } else {
        heading(
            ui,
            state,
            stage,
            &format!("{} candidates around the fit", format::count(grasps.len())),
            "Hand poses on the surface, fingers closed; each one that was dropped says why.",
        );
        reasons(ui, grasps);
    }
    filter(ui, state, accepted, grasps.len(), out);
    ui.add_space(4.0);

    // The table takes what the details leave, and never less than four rows and a half.
    let rest = ui.available_rect_before_wrap();
    let wanted = state.selected_grasp().map_or(0.0, grasp::height);
    let left = (rest.height() - 141.0).max(0.0);
    let details = if left < 0.5 * wanted { 0.0 } else { wanted.min(left) };
    let split = rest.bottom() - details;
    let upper = Rect::from_min_max(rest.min, pos2(rest.right(), split - if details > 0.0 { 6.0 } else { 0.0 }));
    let mut inside = ui.new_child(UiBuilder::new().id_salt("table").max_rect(upper));
    inside.shrink_clip_rect(upper.expand2(vec2(14.0, 0.0)));
    table::draw(&mut inside, state, out);
    if details > 0.0 {
        let lower = Rect::from_min_max(pos2(rest.left(), split), rest.max);
        let mut inside = ui.new_child(UiBuilder::new().id_salt("details").max_rect(lower));
        egui::ScrollArea::vertical()
            .id_salt("grasp details")
            .auto_shrink(false)
            .show(&mut inside, |ui| grasp::draw(ui, state, out));
    }
}

fn filter(ui: &mut Ui, state: &ViewerState, accepted: usize, all: usize, out: &mut Out) {
    let words = [format!("Accepted {}", format::count(accepted)), format!("All {}", format::count(all))];
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    if let Some(index) = segmented(ui, "Listed", &words, Some(usize::from(state.table.rejected))) {
        out.push(Command::ShowRejected(index == 1));
    }
}

/// How many candidates each reason dropped, most frequent first.
fn reasons(ui: &mut Ui, grasps: &[Grasp]) {
    let tokens = Tokens::of(ui);
    let mut counts: Vec<(&'static str, usize)> = Vec::new();
    for grasp in grasps {
        let words = words(&grasp.status);
        match counts.iter_mut().find(|(known, _)| *known == words) {
            Some((_, count)) => *count += 1,
            None => counts.push((words, 1)),
        }
    }
    counts.sort_by_key(|&(words, count)| (std::cmp::Reverse(count), words));
    let most = counts.iter().map(|&(_, count)| count).max().unwrap_or(1);
    for (name, count) in counts {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 22.0), Sense::hover());
        let text = Rect::from_min_max(rect.min, pos2(rect.left() + 0.46 * rect.width(), rect.bottom()));
        let _text = text_in(ui, text, Align::Min, name, font(BODY), tokens.text);
        let number = Rect::from_min_max(pos2(rect.right() - 44.0, rect.top()), rect.max);
        let _text = text_in(ui, number, Align::Max, &format::count(count), font(SECONDARY), tokens.secondary);
        let track = Rect::from_min_max(
            pos2(text.right() + 8.0, rect.center().y - 2.5),
            pos2(number.left() - 6.0, rect.center().y + 2.5),
        );
        let mut bar = track;
        bar.set_width((track.width() * count as f32 / most as f32).max(2.0));
        let color = if name == ACCEPTED { tokens.teal } else { tokens.coral };
        ui.painter().rect_filled(bar, 2.5, color);
    }
    ui.add_space(8.0);
}

const ACCEPTED: &str = "Accepted";

fn words(status: &GraspStatus) -> &'static str {
    match status {
        GraspStatus::Accepted => ACCEPTED,
        GraspStatus::TooWide { .. } => "Too wide for the hand",
        GraspStatus::HandInObject { .. } => "Hand inside the object",
        GraspStatus::TooFewContacts { .. } => "Too few contacts",
        GraspStatus::OneSided { .. } => "Touches one side only",
        GraspStatus::HitsTable { .. } => "Hits the table",
        GraspStatus::HitsNeighbour { .. } => "Hits a neighbour",
        GraspStatus::NoIkAtStart { .. } => "Out of reach at start",
        GraspStatus::NoIkAtGoal { .. } => "Out of reach at goal",
        GraspStatus::NoWayAtStart { .. } => "No way in or up at start",
        GraspStatus::NoWayAtGoal { .. } => "No way down or out at goal",
        GraspStatus::Unwanted { .. } => "Not wanted",
    }
}
