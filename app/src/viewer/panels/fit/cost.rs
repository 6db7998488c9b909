//! The cost of every run of Levenberg–Marquardt, step by step.

use egui::{Color32, Ui};
use egui_plot::{GridInput, GridMark, HoverPosition, Line, Plot, PlotPoints};
use endcomfort_core::fit::{Fit, ObjectiveKind};

use crate::export::taken_run;
use crate::viewer::format;
use crate::viewer::theme::{SECONDARY, SMALL, Tokens, font};
use crate::viewer::widgets::paragraph;

/// Costs below this are drawn as this: a perfect fit has none, and no logarithm.
const LEAST: f64 = 1e-6;

/// Curves on a logarithmic axis; the one that was taken is teal, the one under the pointer amber and told in words.
pub(super) fn draw(ui: &mut Ui, fit: &Fit, objective: ObjectiveKind) {
    let tokens = Tokens::of(ui);
    if fit.runs.is_empty() {
        let _text = paragraph(ui, "No run is on record.", SECONDARY, tokens.secondary);
        return;
    }
    // The residuals of the radial objective and of Chevalier's are lengths.
    let is_length = matches!(objective, ObjectiveKind::Radial | ObjectiveKind::Chevalier);
    let factor = if is_length { 1e3 } else { 1.0 };
    let taken = taken_run(&fit.runs);
    let id = ui.scope_id().with("Cost");
    let pointed: Option<usize> = ui.data(|data| data.get_temp(id)).filter(|&index| index < fit.runs.len());
    let is_near = std::cell::Cell::new(None);
    let near = |position: &HoverPosition<'_>| {
        if let HoverPosition::NearDataPoint { plot_name, .. } = position {
            is_near.set(plot_name.parse::<usize>().ok());
        }
        None
    };
    let lines = |index: usize, color: Color32, width: f32| {
        let points = fit.runs[index].rms.iter().enumerate();
        let points: Vec<[f64; 2]> =
            points.map(|(step, rms)| [step as f64, (factor * rms).max(LEAST).log10()]).collect();
        Line::new(index.to_string(), PlotPoints::from(points)).color(color).width(width)
    };
    ui.scope(|ui| {
        ui.style_mut().text_styles.insert(egui::TextStyle::Body, font(SMALL));
        ui.visuals_mut().override_text_color = Some(tokens.secondary);
        let response = Plot::new("Cost")
            .height(170.0)
            .show_background(false)
            .show_crosshair(false)
            .allow_zoom(false)
            .allow_drag(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_axis_zoom_drag(false)
            .allow_double_click_reset(false)
            .grid_color(tokens.line)
            .set_margin_fraction(egui::vec2(0.02, 0.06))
            .y_grid_spacer(decades)
            .x_grid_spacer(whole_steps)
            .y_axis_min_width(36.0)
            .y_axis_formatter(|mark, _| tick(10_f64.powf(mark.value)))
            .x_axis_formatter(|mark, _| format!("{:.0}", mark.value))
            .label_formatter(near)
            .show(ui, |plot| {
                for index in (0..fit.runs.len()).filter(|&index| index != taken && Some(index) != pointed) {
                    plot.line(lines(index, tokens.slate.gamma_multiply(0.55), 1.0));
                }
                plot.line(lines(taken, tokens.teal, 2.2));
                if let Some(index) = pointed.filter(|&index| index != taken) {
                    plot.line(lines(index, tokens.amber, 2.0));
                }
            });
        let words = format!("Cost of {} over their steps", format::plural(fit.runs.len(), "run"));
        response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &words));
        let pointed = is_near.get().filter(|_| response.response.contains_pointer());
        ui.data_mut(|data| match pointed {
            Some(index) => {
                data.insert_temp(id, index);
            }
            None => data.remove::<usize>(id),
        });
    });
    let told = pointed.unwrap_or(taken);
    let run = &fit.runs[told];
    let name = match pointed {
        Some(index) if index != taken => run.name.clone(),
        _ => format!("{} (taken)", run.name),
    };
    let color = if pointed.is_some_and(|index| index != taken) { tokens.text } else { tokens.teal_text };
    let _text = paragraph(ui, &name, SECONDARY, color);
    let rms = run.rms.last().copied().unwrap_or(0.0);
    let rms = if is_length { format::length(rms) } else { format::significant(rms) };
    let text = format!(
        "{rms} rms on {} after {} and {}; {}.",
        format::plural(run.points, "point"),
        format::plural(run.rms.len().saturating_sub(1), "step"),
        format::plural(run.iterations as usize, "evaluation"),
        run.stop
    );
    let _text = paragraph(ui, &text, SECONDARY, tokens.secondary);
    let unit = if is_length { ", mm" } else { "" };
    let text = format!("Root mean square of the residuals{unit} after each step that was taken. Point at a curve.");
    let _text = paragraph(ui, &text, SMALL, tokens.secondary);
}

/// A round cost without idle zeros.
fn tick(value: f64) -> String {
    if value < 0.99e-3 {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Lines at 1, 2 and 5 times the powers of ten, on a logarithmic axis; over many decades the powers alone.
fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let digits: &[f64] = if high - low > 2.2 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let decades = low.floor() as i32..=high.ceil() as i32;
    let marks = decades.flat_map(|decade| digits.iter().map(move |digit| f64::from(decade) + digit.log10()));
    // One step size for all of them: they are equally strong, and none is left without its number.
    marks.filter(|value| (low..=high).contains(value)).map(|value| GridMark { value, step_size: 1.0 }).collect()
}

/// Lines at whole steps, at most eight of them.
fn whole_steps(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let wanted = ((high - low) / 8.0).max(1.0);
    let step = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0].into_iter().find(|&step| step >= wanted).unwrap_or(200.0);
    let first = (low / step).ceil().max(0.0) as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|k| GridMark { value: k as f64 * step, step_size: 10.0 * step }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_axis_has_lines_at_round_costs() {
        let values: Vec<f64> = decades(GridInput { bounds: (-0.1, 1.1), base_step_size: 0.1 })
            .into_iter()
            .map(|mark| 10_f64.powf(mark.value))
            .collect();
        for (value, wanted) in values.iter().zip([1.0, 2.0, 5.0, 10.0]) {
            assert!((value - wanted).abs() < 1e-9, "{values:?}");
        }
    }
}
