//! Two plans side by side: the one that was kept, and the present one.

use egui::{Align, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use crate::viewer::panels::Out;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::{paragraph, secondary_button, section, text_in};
use crate::viewer::{Command, Measures, PlanCommand, ViewerState, format};

const ROW: f32 = 24.0;
/// Width of a column of numbers, points.
const COLUMN: f32 = 92.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    section(ui, "Compared");
    let now = state.planning.measures.as_ref();
    let Some(kept) = &state.planning.kept else {
        ui.horizontal(|ui| {
            if secondary_button(ui, "Keep as A", now.is_some()).clicked() {
                out.push(Command::Planning(PlanCommand::Keep));
            }
            let text = "then plan anew and see both.";
            let _text = ui.label(egui::RichText::new(text).font(font(SECONDARY)).color(tokens.secondary));
        });
        return;
    };
    let _text =
        paragraph(ui, &format!("A: {}. Its trail is the thin dashed one.", kept.title), SECONDARY, tokens.secondary);
    row(ui, ["", "A", "now"], None);
    for (name, a, b, better) in rows(&kept.measures, now) {
        row(ui, [name, &a, &b], better);
    }
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        if secondary_button(ui, "Keep this as A", now.is_some()).clicked() {
            out.push(Command::Planning(PlanCommand::Keep));
        }
        if secondary_button(ui, "Clear A", true).clicked() {
            out.push(Command::Planning(PlanCommand::ForgetKept));
        }
    });
}

/// Name, the kept plan's value, the present one's, and whether the present one is the better.
type Row = (&'static str, String, String, Option<bool>);

fn rows(a: &Measures, now: Option<&Measures>) -> Vec<Row> {
    let number = |name, of: fn(&Measures) -> Option<f64>, says: fn(f64) -> String, more_is_better: bool| -> Row {
        let (x, y) = (of(a), now.and_then(of));
        let text = |value: Option<f64>| value.filter(|v| v.is_finite()).map_or("–".to_owned(), says);
        let better = match (x, y) {
            // Numbers that read the same are no difference.
            (Some(x), Some(y)) if says(x) != says(y) => Some((y > x) == more_is_better),
            _ => None,
        };
        (name, text(x), text(y), better)
    };
    let whole = |value: f64| format::count(value.round() as usize);
    vec![
        number("Duration", |m| Some(m.duration_s), format::clock, false),
        number("Way of the arm", |m| Some(m.arm_rad), |rad| format!("{} rad", format::significant(rad)), false),
        number("Way of the hand", |m| Some(m.hand_m), format::length, false),
        number("Smallest clearance", |m| m.clearance_m, format::length, true),
        number("Mean m(q)", |m| m.manipulability, format::manipulability, true),
        number("Phases", |m| Some(m.phases as f64), whole, false),
        number("Tries before", |m| Some(m.tries as f64), whole, false),
    ]
}

/// A name and two numbers; the better one of now has a mark.
fn row(ui: &mut Ui, [name, a, b]: [&str; 3], better: Option<bool>) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::hover());
    ui.painter().hline(rect.x_range(), rect.bottom() - 0.5, Stroke::new(1.0, tokens.line));
    let cell = |k: f32| {
        let right = rect.right() - k * COLUMN;
        Rect::from_min_max(pos2(right - COLUMN, rect.top()), pos2(right, rect.bottom()))
    };
    let is_head = name.is_empty();
    let _name = text_in(ui, rect.with_max_x(cell(1.0).left()), Align::Min, name, font(BODY), tokens.text);
    let ink = if is_head { tokens.secondary } else { tokens.text };
    let _a = text_in(ui, cell(1.0), Align::Max, a, font(SECONDARY), tokens.secondary);
    let (mark, ink) = match better {
        Some(true) => (" ▲", tokens.teal_text),
        Some(false) => (" ▼", tokens.coral),
        None => ("", ink),
    };
    let text = if mark.is_empty() { b.to_owned() } else { format!("{b}{mark}") };
    let id = if is_head { font(SECONDARY) } else { strong(SECONDARY) };
    let _b = text_in(ui, cell(0.0), Align::Max, &text, id, ink);
    let said = match better {
        Some(true) => ", better",
        Some(false) => ", worse",
        None => "",
    };
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{name}: A {a}, now {b}{said}")));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_better_plan_is_the_shorter_and_the_clearer_one_and_equal_words_are_no_difference() {
        let a = Measures {
            duration_s: 8.0,
            arm_rad: 5.0,
            hand_m: 1.2,
            clearance_m: Some(0.02),
            manipulability: Some(0.05),
            phases: 7,
            tries: 0,
        };
        let b = Measures {
            duration_s: 7.0,
            arm_rad: 5.0001,
            hand_m: 1.4,
            clearance_m: Some(0.03),
            manipulability: None,
            ..a.clone()
        };
        let better: Vec<Option<bool>> = rows(&a, Some(&b)).into_iter().map(|row| row.3).collect();
        assert_eq!(better, [Some(true), None, Some(false), Some(true), None, None, None]);
        assert!(rows(&a, None).iter().all(|row| row.2 == "–"));
    }
}
