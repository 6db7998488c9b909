//! How the fit was found: objectives side by side, models compared, cost of every run.

use egui::{Align, Rect, Sense, Ui, pos2, vec2};
use endcomfort_core::fit::Fit;

use super::{compare, cost};
use crate::export::{PlotKind, TableKind};
use crate::viewer::icons::{self, Icon};
use crate::viewer::panels::Out;
use crate::viewer::panels::save_menu::saved_section;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font, strong};
use crate::viewer::widgets::text_in;
use crate::viewer::{ViewerState, format};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, fit: &Fit, out: &mut Out) {
    compare::draw(ui, state, out);
    models(ui, fit, out);
    saved_section(ui, "Cost of every run", TableKind::Runs, Some(PlotKind::Cost), out);
    cost::draw(ui, fit, state.document.scene.fit.objective);
}

/// The models that were compared: the least criterion wins.
fn models(ui: &mut Ui, fit: &Fit, out: &mut Out) {
    if fit.models.is_empty() {
        return;
    }
    let tokens = Tokens::of(ui);
    saved_section(ui, "Models compared", TableKind::Models, None, out);
    let least = fit.models.iter().map(|model| model.criterion).fold(f64::INFINITY, f64::min);
    for model in &fit.models {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::hover());
        if model.is_chosen {
            ui.painter().rect_filled(rect.expand2(vec2(13.0, 0.0)), 0.0, tokens.selected);
            icons::paint(ui.painter(), Icon::Check, pos2(rect.left() + 6.0, rect.center().y), 13.0, tokens.teal);
        }
        let id = if model.is_chosen { strong(BODY) } else { font(BODY) };
        let name = Rect::from_min_max(pos2(rect.left() + 20.0, rect.top()), rect.max);
        let _text = text_in(ui, name, Align::Min, &model.name, id, tokens.text);
        let above = model.criterion - least;
        let criterion = if above <= 0.0 { "least".to_owned() } else { format!("+{}", format::significant(above)) };
        let text = format!("rms {} · BIC {criterion}", format::length(model.rms_m));
        let _text = text_in(ui, rect, Align::Max, &text, font(SECONDARY), tokens.secondary);
        let tip = format!(
            "Bayesian information criterion {}: what is left of the error, plus a price for every parameter. \
             The least wins.",
            format::significant(model.criterion)
        );
        let _tip = response.on_hover_text(tip);
    }
}
