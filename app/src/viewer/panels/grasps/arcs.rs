//! The arm angles that the joint limits allow, a strip for each branch of the inverse kinematics.

use std::f64::consts::{PI, TAU};

use egui::{Align2, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::robot::ik::Arc;

use super::explain;
use crate::viewer::format;
use crate::viewer::theme::{SMALL, Tokens, font};
use crate::viewer::widgets::section;

/// Branches of a closed-form arm.
const BRANCHES: u8 = 8;
const ROW: f32 = 11.0;

pub(super) fn draw(ui: &mut Ui, feasible: &[Arc]) {
    if feasible.is_empty() {
        return;
    }
    let tokens = Tokens::of(ui);
    section(ui, "Arm angles within the limits");
    ui.add_space(4.0);
    let size = vec2(ui.available_width(), ROW * f32::from(BRANCHES) + 18.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let plot = Rect::from_min_max(rect.min + vec2(18.0, 0.0), rect.max - vec2(0.0, 18.0));
    let x = |angle: f64| plot.left() + plot.width() * ((angle + PI) / TAU) as f32;
    for branch in 0..BRANCHES {
        let y = plot.top() + ROW * (f32::from(branch) + 0.5);
        let number = (branch + 1).to_string();
        let at = pos2(rect.left() + 8.0, y);
        let _rect = ui.painter().text(at, Align2::CENTER_CENTER, number, font(SMALL), tokens.secondary);
        let strip = |from: f64, to: f64| Rect::from_min_max(pos2(x(from), y - 3.0), pos2(x(to), y + 3.0));
        ui.painter().rect_filled(strip(-PI, PI), 3.0, tokens.well);
        for arc in feasible.iter().filter(|arc| arc.branch == branch) {
            ui.painter().rect_filled(strip(arc.from, arc.to.min(PI)), 3.0, tokens.teal);
            // An arc that passes half a turn goes on at the other end.
            if arc.to > PI {
                ui.painter().rect_filled(strip(-PI, arc.to - TAU), 3.0, tokens.teal);
            }
        }
    }
    ui.painter().vline(x(0.0), plot.y_range(), Stroke::new(1.0, tokens.line));
    for (angle, anchor, text) in
        [(-PI, Align2::LEFT_TOP, "–180°"), (0.0, Align2::CENTER_TOP, "0°"), (PI, Align2::RIGHT_TOP, "180°")]
    {
        let at = pos2(x(angle), plot.bottom() + 3.0);
        let _rect = ui.painter().text(at, anchor, text, font(SMALL), tokens.secondary);
    }
    let branches = (0..BRANCHES).filter(|branch| feasible.iter().any(|arc| arc.branch == *branch)).count();
    let said = format!("{} on {branches} of {BRANCHES} branches", format::plural(feasible.len(), "arc"));
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("Arm angles within the limits: {said}")));
    explain(ui, &format!("{said}; collisions are not asked here."));
}
