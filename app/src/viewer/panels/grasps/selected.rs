//! The selected grasp: how it holds, how the arm reaches it, and why it stands where it stands.

use egui::{Align, Rect, Sense, Ui, pos2, vec2};
use endcomfort_core::grasp::{Contact, Grasp, Quantity, Term};

use super::{arcs, ik_set};
use crate::viewer::panels::Out;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{
    key_value, key_value_colored, paragraph, primary_button, secondary_button, section, text_in,
};
use crate::viewer::{Command, ViewerState, format, quantities};

/// Height that the short form wants, points.
pub(super) fn brief_height(grasp: &Grasp) -> f32 {
    match (grasp.is_accepted(), &grasp.start) {
        (true, _) => 244.0,
        (false, Some(_)) => 236.0,
        (false, None) => 96.0,
    }
}

/// What stands under the table.
pub(super) fn brief(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let Some(grasp) = state.selected_grasp() else { return };
    let tokens = Tokens::of(ui);
    ui.spacing_mut().item_spacing.y = 0.0;
    section(ui, &name(state, grasp));
    if !grasp.is_accepted() {
        let _row = key_value_colored(ui, "Rejected", &grasp.status.reason(), tokens.coral);
    }
    let _row = key_value(ui, "Contacts", &contacts(grasp)).on_hover_text(links(grasp));
    if let Some(comfort) = format::comfort(grasp) {
        let _row = key_value(ui, "Manipulability at the goal", &comfort);
    }
    configurations(ui, state, grasp, out);
    buttons(ui, state, grasp, out);
}

/// Everything that is known of it.
pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let Some(grasp) = state.selected_grasp() else {
        let text = "No grasp is selected. Click a row of the table or a pin in the view.";
        let _text = paragraph(ui, text, BODY, tokens.secondary);
        return;
    };
    ui.spacing_mut().item_spacing.y = 0.0;
    section(ui, &name(state, grasp));
    if grasp.is_accepted() {
        let _row = key_value(ui, "Approach", &format::why(grasp, state.outputs.X_WO_start()));
    } else {
        let _row = key_value_colored(ui, "Rejected", &grasp.status.reason(), tokens.coral);
    }
    if state.parts() > 1 {
        let _row = key_value(ui, "Part", &format!("{} of {}", grasp.part + 1, state.parts()));
    }
    buttons(ui, state, grasp, out);
    arm(ui, state, grasp, out);
    holding(ui, grasp);
    if !grasp.contacts.is_empty() {
        section(ui, "Contacts");
        for contact in &grasp.contacts {
            let _row = key_value(ui, &contact.link, &depth(contact));
        }
    }
    if let Some(score) = &grasp.score {
        section(ui, &format!("Score {:.2}", score.total));
        let sum: f64 = score.terms.iter().map(|term| term.weight).sum();
        for term in &score.terms {
            share(ui, term, sum);
        }
    }
}

fn arm(ui: &mut Ui, state: &ViewerState, grasp: &Grasp, out: &mut Out) {
    if grasp.start.is_none() && grasp.goal.is_none() {
        return;
    }
    section(ui, "Arm");
    for (key, set) in [("Mean manipulability at the start", &grasp.start), ("At the goal", &grasp.goal)] {
        if let Some(set) = set {
            let text = format!("m_g {} · N {}", format::manipulability(set.m_g), format::count(set.ik_count));
            let _row = key_value(ui, key, &text);
        }
    }
    if let Some(mean) = Quantity::MgMean.of(grasp) {
        let _row = key_value(ui, "Mean of both", &format!("m_g {}", format::manipulability(mean)));
    }
    if let Some(comfort) = format::comfort(grasp) {
        let _row = key_value(ui, "Goal against start", &comfort);
    }
    configurations(ui, state, grasp, out);
    let at = state.selection.ik.map_or(ik_set::usual_situation(grasp), |ik| ik.at);
    if let Some(set) = at.of(grasp) {
        arcs::draw(ui, &set.feasible);
    }
    if let Some(set) = at.of(grasp).filter(|set| set.ik_count > 0 && !set.rejected.is_empty()) {
        section(ui, "Configurations turned away");
        for (reason, count) in &set.rejected {
            let _row = key_value(ui, &reason.to_string(), &format!("{} ×", format::count(*count)));
        }
    }
}

fn configurations(ui: &mut Ui, state: &ViewerState, grasp: &Grasp, out: &mut Out) {
    let at = state.selection.ik.map_or(ik_set::usual_situation(grasp), |ik| ik.at);
    if let Some(set) = at.of(grasp) {
        ik_set::draw(ui, state, grasp, at, set, out);
    }
}

fn holding(ui: &mut Ui, grasp: &Grasp) {
    section(ui, "Hand");
    let text = |quantity: Quantity| match (quantity.of(grasp), quantities::unit(quantity).0) {
        (None, _) => "not known".to_owned(),
        (value, "") => quantities::cell(quantity, value),
        (value, unit) => format!("{} {unit}", quantities::cell(quantity, value)),
    };
    let epsilon = if grasp.epsilon > 0.0 || grasp.contacts.is_empty() {
        text(Quantity::Epsilon)
    } else {
        "0, no force closure".to_owned()
    };
    let success = match grasp.success {
        Some(success) => format!("{} of {} poses, {}", success.held, success.trials, text(Quantity::Success)),
        None => text(Quantity::Success),
    };
    for (key, value, tip) in [
        ("Quality ε", epsilon, "Largest ball of wrenches that the contacts resist (Ferrari and Canny 1992)."),
        ("Wrench space volume", text(Quantity::Volume), "In six dimensions, forces and scaled torques."),
        ("Holds under pose noise", success, "The object is shifted and turned by the noise of the settings."),
        ("Clearance", text(Quantity::Clearance), "Distance of the closed hand from table and neighbours."),
        ("Width", text(Quantity::Width), "Between the outermost contacts along the closing direction."),
    ] {
        let _row = key_value(ui, key, &value).on_hover_text(tip);
    }
}

/// One term of the score: its bar is as long as its share, its number what it adds.
fn share(ui: &mut Ui, term: &Term, sum: f64) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 24.0), Sense::hover());
    let text = Rect::from_min_max(rect.min, pos2(rect.left() + 0.30 * rect.width(), rect.bottom()));
    let ink = if term.weight > 0.0 { tokens.text } else { tokens.secondary };
    let _text = text_in(ui, text, Align::Min, super::order::weight_title(&term.name), font(SECONDARY), ink);
    let number = Rect::from_min_max(pos2(rect.right() - 104.0, rect.top()), rect.max);
    let said = format!("{} × {:.2}", format::significant(term.weight), term.share);
    let _text = text_in(ui, number, Align::Max, &said, font(SECONDARY), tokens.secondary);
    let (y, left, right) = (rect.center().y, text.right() + 6.0, number.left() - 4.0);
    let track = Rect::from_min_max(pos2(left, y - 2.5), pos2(right, y + 2.5));
    ui.painter().rect_filled(track, 2.5, tokens.well);
    let mut bar = track;
    let part = if sum > 0.0 { term.weight * term.share / sum } else { 0.0 };
    bar.set_width((track.width() * part.max(0.0).min(1.0) as f32).max(if part > 0.0 { 2.0 } else { 0.0 }));
    ui.painter().rect_filled(bar, 2.5, tokens.teal);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Label, true, format!("{}: {said}, adds {part:.2}", term.name))
    });
    let _tip = response.on_hover_text(format!("Weight {said} of the best, adds {part:.2} to the score"));
}

fn name(state: &ViewerState, grasp: &Grasp) -> String {
    match state.outputs.rank_of(grasp.id) {
        Some(rank) => format!("Grasp {rank} · candidate {}", grasp.id),
        None => format!("Candidate {}", grasp.id),
    }
}

fn contacts(grasp: &Grasp) -> String {
    let quality = if grasp.epsilon > 0.0 { format!("ε {:.2}", grasp.epsilon) } else { "no force closure".to_owned() };
    match grasp.contacts.len() {
        0 => "none".to_owned(),
        count => format!("{count}, {} apart · {quality}", format::millimetres(grasp.width_m)),
    }
}

fn links(grasp: &Grasp) -> String {
    let mut links: Vec<&str> = grasp.contacts.iter().map(|contact| contact.link.as_str()).collect();
    links.dedup();
    if links.is_empty() { "The hand touches nothing.".to_owned() } else { links.join(", ") }
}

/// How deep a contact is in the object.
fn depth(contact: &Contact) -> String {
    let mm = contact.penetration_m * 1e3;
    match mm {
        0.05.. => format!("{mm:.1} mm inside"),
        ..-0.05 => format!("gap of {:.1} mm", -mm),
        _ => "touches".to_owned(),
    }
}

fn buttons(ui: &mut Ui, state: &ViewerState, grasp: &Grasp, out: &mut Out) {
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        if grasp.is_accepted() {
            let number = state.outputs.rank_of(grasp.id).map_or(grasp.id as usize, |rank| rank);
            if primary_button(ui, &format!("Plan with grasp {number}"), !state.running).clicked() {
                out.push(Command::PlanWithGrasp(Some(grasp.id)));
            }
        }
        if state.selection.ik.is_some() && secondary_button(ui, "Back to the plan", true).clicked() {
            out.push(Command::ShowIk(None));
        }
    });
}
