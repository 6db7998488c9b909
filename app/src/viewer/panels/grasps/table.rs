//! The grasp table: every candidate, accepted or not, says why.

use egui::text::LayoutJob;
use egui::{Align2, FontId, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::grasp::{Grasp, Quantity};

use crate::viewer::panels::Out;
use crate::viewer::quantities;
use crate::viewer::theme::{BODY, SECONDARY, SMALL, Tokens, font, strong};
use crate::viewer::widgets::{elided, focus_ring, subscripted};
use crate::viewer::{Column, Command, GraspCommand, ViewerState, format};

const ROW: f32 = 26.0;
const NUMBER: f32 = 24.0;
const BAR: f32 = 38.0;

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    header(ui, state, out);
    let rows = state.table_rows();
    let grasps = state.outputs.candidates();
    let ranking = state.ranking_quantity();
    let accepted = grasps.iter().filter(|grasp| grasp.is_accepted());
    let best = accepted.filter_map(|grasp| ranking?.of(grasp)).fold(f64::MIN_POSITIVE, f64::max);
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

/// The columns in a row, from left to right.
struct Columns {
    /// Rank or number.
    number: Rect,
    /// Each quantity, its number at the right edge.
    numbers: Vec<(Quantity, Rect)>,
    /// The reason.
    why: Rect,
}

impl Columns {
    fn of(row: Rect, state: &ViewerState) -> Self {
        let shown = state.table.columns.quantities();
        let mut left = row.left();
        let mut cell = |width: f32| {
            left += width;
            Rect::from_min_max(pos2(left - width, row.top()), pos2(left, row.bottom()))
        };
        let number = cell(NUMBER);
        let numbers: Vec<(Quantity, Rect)> =
            shown.iter().map(|&quantity| (quantity, cell(quantities::width(quantity)))).collect();
        let why = Rect::from_min_max(pos2(left + 14.0, row.top()), row.max);
        Self { number, numbers, why }
    }
}

fn header(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 24.0), Sense::hover());
    let columns = Columns::of(rect, state);
    let number = if state.outputs.is_ranked() { "Rank" } else { "Number" };
    let numbers = columns
        .numbers
        .iter()
        .map(|&(quantity, cell)| (Column::Of(quantity), cell, quantities::head(quantity), quantity.title()));
    let heads = std::iter::once((Column::Number, columns.number, ("#", "", ""), number)).chain(numbers).chain([(
        Column::Why,
        columns.why,
        ("why", "", ""),
        "The reason",
    )]);
    for (column, cell, (base, low, rest), name) in heads {
        let response = ui.interact(cell, ui.scope_id().with(("sort", name)), Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::ColumnHeader, true, format!("Sort by {name}")));
        let is_order = state.table.sort == column;
        let color = if is_order || response.hovered() { tokens.text } else { tokens.secondary };
        let job = if low.is_empty() {
            let gap = if rest.is_empty() { "" } else { " " };
            LayoutJob::simple_singleline(format!("{base}{gap}{rest}"), font(SMALL), color)
        } else {
            subscripted(base, low, rest, SMALL, color)
        };
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
            out.push(Command::Grasping(GraspCommand::SortBy(column)));
        }
    }
    ui.painter().hline(rect.expand2(vec2(13.0, 0.0)).x_range(), rect.bottom(), Stroke::new(1.0, tokens.line));
}

fn row(ui: &mut Ui, state: &ViewerState, grasp: &Grasp, best: f64, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (_, rect) = ui.allocate_space(vec2(ui.available_width(), ROW));
    let response = ui.interact(rect, ui.scope_id().with(("grasp", grasp.id)), Sense::click());
    let columns = Columns::of(rect, state);
    let full = rect.expand2(vec2(13.0, 0.0));
    let is_selected = state.selection.grasp == Some(grasp.id);
    if is_selected {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() || state.hover.grasp == Some(grasp.id) {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let accepted = grasp.is_accepted();
    let ink = if accepted { tokens.text } else { tokens.secondary };
    let planned = state.outputs.plan.as_ref().is_some_and(|plan| plan.grasp().id == grasp.id);
    let painter = ui.painter();
    let put = |x: f32, text: String, id: FontId| {
        let _rect = painter.text(pos2(x, rect.center().y), Align2::RIGHT_CENTER, text, id, ink);
    };
    let number = match (state.outputs.rank_of(grasp.id), state.outputs.is_ranked()) {
        (Some(rank), _) => rank.to_string(),
        (None, true) => "–".to_owned(),
        (None, false) => grasp.id.to_string(),
    };
    put(columns.number.right(), number, if planned { strong(BODY) } else { font(BODY) });
    for &(quantity, cell) in &columns.numbers {
        let value = quantity.of(grasp);
        put(cell.right(), quantities::cell(quantity, value), font(BODY));
        if let Some(value) = value.filter(|_| accepted && state.ranking_quantity() == Some(quantity)) {
            // Under the number that ranks, a bar: how it compares with the best.
            let left = cell.right() - BAR;
            let right = left + BAR * (value / best).max(0.0).min(1.0) as f32;
            let bar = Rect::from_min_max(pos2(left, rect.bottom() - 5.0), pos2(right, rect.bottom() - 2.5));
            painter.rect_filled(bar, 1.25, tokens.teal);
        }
    }
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
