//! The grasp table: every candidate, accepted or not, says why.

use egui::{Align2, FontId, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::grasp::{Grasp, GraspStatus, Situated};

use super::Out;
use crate::viewer::state::Column;
use crate::viewer::theme::{BODY, SECONDARY, SMALL, Tokens, font, strong};
use crate::viewer::widgets::{elided, focus_ring, subscripted};
use crate::viewer::{Command, ViewerState, format};

const ROW: f32 = 26.0;
const GAP: f32 = 10.0;
const BAR: f32 = 34.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    header(ui, state, out);
    let rows = state.table_rows();
    let grasps = state.outputs.candidates();
    let best = grasps
        .iter()
        .flat_map(|grasp| [m_g(&grasp.goal), m_g(&grasp.start)])
        .flatten()
        .fold(f64::MIN_POSITIVE, f64::max);
    let scrolled_to = ui.scope_id().with("scrolled to");
    let last: Option<u32> = ui.data(|data| data.get_temp(scrolled_to));
    ui.spacing_mut().item_spacing.y = 0.0;
    egui::ScrollArea::vertical().id_salt("rows").auto_shrink(false).show_rows(ui, ROW, rows.len(), |ui, visible| {
        // A grasp that was selected in the view or by a key is brought into sight, once.
        if state.selection.grasp != last
            && let Some(position) = rows.iter().position(|&row| Some(grasps[row].id) == state.selection.grasp)
        {
            let first = visible.start as f32;
            let top = ui.max_rect().top() + (position as f32 - first) * ROW;
            let rect = Rect::from_min_size(pos2(ui.max_rect().left(), top), vec2(ui.available_width(), ROW));
            ui.scroll_to_rect(rect, None);
        }
        for index in visible {
            if let Some(grasp) = rows.get(index).and_then(|&row| grasps.get(row)) {
                row(ui, state, grasp, best, out);
            }
        }
    });
    if let Some(selected) = state.selection.grasp {
        ui.data_mut(|data| data.insert_temp(scrolled_to, selected));
    }
}

/// The columns' right or left edges in a row.
struct Columns {
    number: f32,
    start: f32,
    goal: f32,
    solutions: f32,
    epsilon: f32,
    why: Rect,
}

impl Columns {
    fn of(row: Rect) -> Self {
        let number = row.left() + 22.0;
        let start = number + GAP + 40.0;
        let goal = start + GAP + BAR + 40.0;
        let solutions = goal + GAP + 28.0;
        let epsilon = solutions + GAP + 30.0;
        let why = Rect::from_min_max(pos2(epsilon + 14.0, row.top()), row.max);
        Self { number, start, goal, solutions, epsilon, why }
    }
}

fn header(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 24.0), Sense::hover());
    let columns = Columns::of(rect);
    let ranked = state.outputs.rank.is_some();
    let number = if ranked { "Rank" } else { "Number" };
    for (column, left, right, base, low, rest, name) in [
        (Column::Number, rect.left(), columns.number, "#", "", "", number),
        (Column::Start, columns.number + 4.0, columns.start, "m", "g", "start", "Mean manipulability at the start"),
        (Column::Goal, columns.start + 4.0, columns.goal, "m", "g", "goal", "Mean manipulability at the goal"),
        (Column::Solutions, columns.goal + 4.0, columns.solutions, "N", "", "", "IK solutions behind the mean"),
        (Column::Epsilon, columns.solutions + 4.0, columns.epsilon, "ε", "", "", "Largest-ball quality of the grasp"),
        (Column::Why, columns.why.left(), rect.right(), "why", "", "", "The reason"),
    ] {
        let cell = Rect::from_min_max(pos2(left, rect.top()), pos2(right, rect.bottom()));
        let response = ui.interact(cell, ui.scope_id().with(("sort", name)), Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::ColumnHeader, true, format!("Sort by {name}")));
        let is_order = state.table.sort == column;
        let color = if is_order || response.hovered() { tokens.text } else { tokens.secondary };
        let mut job = subscripted(base, low, rest, SMALL, color);
        if rest.is_empty() {
            job = egui::text::LayoutJob::simple_singleline(base.to_owned(), font(SMALL), color);
        }
        let galley = ui.painter().layout_job(job);
        let x = if column == Column::Why { cell.left() } else { cell.right() - galley.size().x };
        let width = galley.size().x;
        ui.painter().galley(pos2(x, cell.center().y - 0.5 * galley.size().y), galley, color);
        if is_order {
            let y = cell.bottom() - 2.0;
            ui.painter().hline(x..=x + width, y, Stroke::new(1.5, tokens.teal));
        }
        focus_ring(ui, &response, cell);
        if response.on_hover_text(name).clicked() {
            out.push(Command::SortBy(column));
        }
    }
    ui.painter().hline(rect.expand2(vec2(13.0, 0.0)).x_range(), rect.bottom(), Stroke::new(1.0, tokens.line));
}

fn row(ui: &mut Ui, state: &ViewerState, grasp: &Grasp, best: f64, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (_, rect) = ui.allocate_space(vec2(ui.available_width(), ROW));
    let response = ui.interact(rect, ui.scope_id().with(("grasp", grasp.id)), Sense::click());
    let columns = Columns::of(rect);
    let full = rect.expand2(vec2(13.0, 0.0));
    let is_selected = state.selection.grasp == Some(grasp.id);
    if is_selected {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() || state.hover.grasp == Some(grasp.id) {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let accepted = grasp.status == GraspStatus::Accepted;
    let ink = if accepted { tokens.text } else { tokens.secondary };
    let planned = state.outputs.plan.as_ref().is_some_and(|plan| plan.grasp.id == grasp.id);
    let painter = ui.painter();
    let put = |x: f32, text: String, id: FontId| {
        let _rect = painter.text(pos2(x, rect.center().y), Align2::RIGHT_CENTER, text, id, ink);
    };
    let number = match (state.outputs.rank_of(grasp.id), state.outputs.rank.is_some()) {
        (Some(rank), _) => rank.to_string(),
        (None, true) => "–".to_owned(),
        (None, false) => grasp.id.to_string(),
    };
    put(columns.number, number, if planned { strong(BODY) } else { font(BODY) });
    let value = |m_g: Option<f64>| m_g.map_or("–".to_owned(), format::manipulability);
    put(columns.start, value(m_g(&grasp.start)), font(BODY));
    put(columns.goal, value(m_g(&grasp.goal)), font(BODY));
    if let (true, Some(goal)) = (accepted, m_g(&grasp.goal).or(m_g(&grasp.start))) {
        let width = BAR * (goal / best).max(0.0).min(1.0) as f32;
        let right = columns.goal - 44.0;
        let bar = Rect::from_min_max(pos2(right - width, rect.center().y - 2.5), pos2(right, rect.center().y + 2.5));
        painter.rect_filled(bar, 2.5, tokens.teal);
    }
    let solutions = grasp.goal.as_ref().or(grasp.start.as_ref());
    put(columns.solutions, solutions.map_or("–".to_owned(), |set| set.ik_count.to_string()), font(BODY));
    put(
        columns.epsilon,
        if grasp.contacts.is_empty() { "–".to_owned() } else { format!("{:.2}", grasp.epsilon) },
        font(BODY),
    );
    let why = format::why(grasp, state.outputs.X_WO_start());
    let color = if accepted { tokens.text } else { tokens.coral };
    let galley = elided(ui, &why, font(SECONDARY), color, columns.why.width());
    let is_cut = galley.elided;
    ui.painter().galley(pos2(columns.why.left(), rect.center().y - 0.5 * galley.size().y), galley, color);
    focus_ring(ui, &response, full);
    response.widget_info(|| {
        let name = format!("Grasp {}: {why}", grasp.id);
        WidgetInfo::selected(Role::Button, true, is_selected, name)
    });
    if response.contains_pointer() {
        out.grasp = Some(grasp.id);
    }
    let response = if is_cut { response.on_hover_text(&why) } else { response };
    if response.clicked() {
        out.push(Command::SelectGrasp(grasp.id));
    }
    if response.double_clicked() && accepted {
        out.push(Command::PlanWithGrasp(Some(grasp.id)));
    }
}

fn m_g(situated: &Option<Situated>) -> Option<f64> {
    situated.as_ref().filter(|situated| situated.ik_count > 0).map(|situated| situated.m_g)
}
