//! A number that is dragged sideways or typed.

use egui::{DragValue, Response, Ui, WidgetInfo, vec2};

use super::theme::{BODY, Tokens, font};
use super::widgets::focus_ring;

/// What a number is and how it is shown.
pub(super) struct Number {
    /// What assistive technology reads: `Semi-axis a, mm`.
    pub(super) name: &'static str,
    /// What stands behind it.
    pub(super) unit: &'static str,
    /// Digits behind the point.
    pub(super) decimals: usize,
    /// Change per point of dragging, in its unit.
    pub(super) per_point: f64,
    /// What it means.
    pub(super) tip: &'static str,
}

/// What a person did to a number; all values in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Touch {
    /// Nothing.
    None,
    /// Dragged it to this value, still holding it.
    Dragged(f64),
    /// Let it go there.
    Released(f64),
    /// Typed it, or stepped to it with a key.
    Set(f64),
}

/// A field of a width; `value` is what it shows unless a drag holds another one.
pub(super) fn number(ui: &mut Ui, field: &Number, value: f64, width: f32) -> Touch {
    let tokens = Tokens::of(ui);
    let id = ui.scope_id().with(("number", field.name));
    let held: Option<f64> = ui.data(|data| data.get_temp(id));
    // Half of the last digit: what is smaller cannot be read. It also keeps a tiny negative number from being “-0.0”.
    let least = 0.5 * 10_f64.powi(-(field.decimals as i32));
    let mut shown = held.unwrap_or(value);
    if shown.abs() < least {
        shown = 0.0;
    }
    let before = shown;
    let response: Response = ui
        .scope(|ui| {
            ui.visuals_mut().widgets.inactive.weak_bg_fill = tokens.well;
            ui.visuals_mut().widgets.hovered.weak_bg_fill = tokens.hover;
            ui.visuals_mut().widgets.active.weak_bg_fill = tokens.hover;
            ui.spacing_mut().interact_size = vec2(width, 26.0);
            ui.style_mut().drag_value_text_style = egui::TextStyle::Body;
            let suffix = if field.unit.is_empty() || field.unit == "°" {
                field.unit.to_owned()
            } else {
                format!("\u{2009}{}", field.unit)
            };
            ui.style_mut().override_font_id = Some(font(BODY));
            ui.add_sized(
                vec2(width, 26.0),
                DragValue::new(&mut shown)
                    .speed(field.per_point)
                    .fixed_decimals(field.decimals)
                    .update_while_editing(false)
                    .suffix(suffix),
            )
        })
        .inner;
    response.widget_info(|| WidgetInfo { label: Some(field.name.to_owned()), ..WidgetInfo::drag_value(true, shown) });
    focus_ring(ui, &response, response.rect);
    // Leaving a field writes its rounded text back: only a difference that can be read is a change.
    let is_changed = (shown - before).abs() > if response.dragged() { 0.0 } else { 1.02 * least };
    let touch = if response.drag_stopped() {
        ui.data_mut(|data| data.remove::<f64>(id));
        Touch::Released(shown)
    } else if response.dragged() {
        if is_changed {
            ui.data_mut(|data| data.insert_temp(id, shown));
            Touch::Dragged(shown)
        } else {
            Touch::None
        }
    } else if is_changed {
        Touch::Set(shown)
    } else {
        Touch::None
    };
    let _tip = response.on_hover_text(field.tip);
    touch
}

/// A number with words behind it; its new value once it is let go or typed.
pub(super) fn number_row(ui: &mut Ui, field: &Number, value: f64, words: &str) -> Option<f64> {
    let touch = ui.horizontal(|ui| {
        let touch = number(ui, field, value, 84.0);
        let color = Tokens::of(ui).text;
        let _text = ui.label(egui::RichText::new(words).font(font(BODY)).color(color));
        touch
    });
    ui.add_space(3.0);
    match touch.inner {
        Touch::Released(value) | Touch::Set(value) => Some(value),
        Touch::None | Touch::Dragged(_) => None,
    }
}
