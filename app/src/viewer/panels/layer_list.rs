//! What the view shows: one row per layer with its eye and its opacity, and a search among layers and things.

use egui::{Align, Color32, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::grasp::GraspStatus;

use super::{Out, cloud_menu, finder};
use crate::viewer::format;
use crate::viewer::icons::{self, Icon};
use crate::viewer::theme::{BODY, SECONDARY, SMALL_RADIUS, Tokens, font};
use crate::viewer::widgets::{focus_ring, icon_button_at, section, text_in};
use crate::viewer::{Command, Layer, ReachCommand, ViewerState};

/// Height of a row where there is room for it, and where there is little, points.
const ROW: [f32; 2] = [25.0, 17.2];

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    ui.add_space(4.0);
    let heading = ui.scope(|ui| section(ui, "Shown")).response.rect;
    let row_of_heading = Rect::from_x_y_ranges(ui.max_rect().x_range(), heading.bottom() - 17.0..=heading.bottom());
    let words = finder::draw(ui, row_of_heading);
    ui.add_space(2.0);
    // A handover has no routes, and nothing else has places.
    let is_handover = state.scene().handover.is_some();
    let without = if is_handover { Layer::Routes } else { Layer::Handover };
    let layers: Vec<Layer> = Layer::ALL.into_iter().filter(|&layer| layer != without).collect();
    if let Some(words) = words {
        finder::list(ui, state, &layers, &words, out);
        return;
    }
    let height = ui.available_height() / layers.len() as f32;
    let height = height.max(ROW[1]).min(ROW[0]);
    egui::ScrollArea::vertical().id_salt("Shown").auto_shrink([false, true]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for layer in layers {
            row(ui, state, layer, height, out);
        }
    });
}

pub(super) fn row(ui: &mut Ui, state: &ViewerState, layer: Layer, height: f32, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let view = state.layers.get(layer);
    let (rect, row) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    let swatch = Rect::from_center_size(pos2(rect.left() + 4.5, rect.center().y), vec2(9.0, 9.0));
    let color = color(layer, tokens);
    ui.painter().rect_filled(swatch, 2.5, if view.visible { color } else { color.gamma_multiply(0.35) });
    let eye = Rect::from_center_size(pos2(rect.right() - 9.0, rect.center().y), vec2(24.0, height.min(22.0)));
    let settings = eye.translate(vec2(-eye.width(), 0.0));
    let has_settings = matches!(layer, Layer::Reach | Layer::Cloud);
    let right = if has_settings { settings.left() } else { eye.left() };
    let opacity = Rect::from_min_max(pos2(right - 46.0, rect.top()), pos2(right - 2.0, rect.bottom()));
    let text = Rect::from_min_max(pos2(rect.left() + 17.0, rect.top()), pos2(opacity.left() - 2.0, rect.bottom()));
    let label = label(state, layer);
    let ink = if view.visible { tokens.text } else { tokens.secondary };
    let _text = text_in(ui, text, Align::Min, &label, font(BODY), ink);
    if layer == Layer::Reach && icon_button_at(ui, settings, Icon::Sliders, "Reachability settings", true).clicked() {
        let command = if state.reaching.is_open { ReachCommand::Close } else { ReachCommand::Open };
        out.push(Command::Reach(command));
    }
    if layer == Layer::Cloud {
        let button = icon_button_at(ui, settings, Icon::Sliders, "How points are drawn", true);
        cloud_menu::draw(&button, state, out);
    }
    let lit = row.contains_pointer();
    opacity_of(ui, opacity, layer, view.visible && (lit || view.opacity < 0.995), state, out);

    let response = ui.interact(eye, ui.scope_id().with(("eye", layer as usize)), Sense::click());
    let name = format!("{} {}", if view.visible { "Hide" } else { "Show" }, layer.title());
    response.widget_info(|| WidgetInfo::selected(Role::Switch, true, view.visible, &name));
    if response.hovered() {
        ui.painter().rect_filled(eye, SMALL_RADIUS, tokens.hover);
    }
    let icon = if view.visible { Icon::Eye } else { Icon::EyeOff };
    let ink = if view.visible || response.hovered() { tokens.secondary } else { tokens.faint };
    icons::paint(ui.painter(), icon, eye.center(), 14.0, ink);
    focus_ring(ui, &response, eye);
    if response.clicked() {
        out.push(Command::ToggleLayer(layer));
    }
}

/// The opacity in per cent: drag it sideways, or use the arrow keys when it has the keyboard.
fn opacity_of(ui: &mut Ui, rect: Rect, layer: Layer, shown: bool, state: &ViewerState, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let opacity = state.layers.get(layer).opacity;
    let response = ui.interact(rect, ui.scope_id().with(("opacity", layer as usize)), Sense::click_and_drag());
    let name = format!("Opacity of {}", layer.title());
    response.widget_info(|| WidgetInfo::slider(true, f64::from(opacity), &name));
    if shown || response.has_focus() || response.dragged() {
        let text = format!("{:.0} %", 100.0 * opacity);
        let ink = if response.hovered() || response.dragged() { tokens.text } else { tokens.secondary };
        let at = pos2(rect.right() - 4.0, rect.center().y);
        let _text = ui.painter().text(at, egui::Align2::RIGHT_CENTER, text, font(SECONDARY), ink);
    }
    focus_ring(ui, &response, rect);
    let mut change = if response.dragged() { response.drag_delta().x / 120.0 } else { 0.0 };
    if response.has_focus() {
        let presses = |key: egui::Key| ui.input(|input| input.num_presses(key)) as f32;
        change += 0.1 * (presses(egui::Key::ArrowRight) - presses(egui::Key::ArrowLeft));
    }
    if change != 0.0 {
        out.push(Command::SetOpacity(layer, opacity + change));
    }
    let _tip = response.on_hover_cursor(egui::CursorIcon::ResizeHorizontal).on_hover_text("Opacity: drag sideways");
}

fn color(layer: Layer, tokens: &Tokens) -> Color32 {
    match layer {
        Layer::Robot => tokens.slate,
        Layer::Cloud => tokens.blue,
        Layer::Clusters => tokens.blue.lerp_to_gamma(tokens.teal, 0.6),
        Layer::Fits => tokens.teal,
        Layer::Goal | Layer::Path => tokens.amber,
        Layer::Routes => tokens.violet.lerp_to_gamma(tokens.amber, 0.5),
        Layer::Ghosts => tokens.blue.lerp_to_gamma(tokens.slate, 0.4),
        Layer::Swept => tokens.blue.lerp_to_gamma(tokens.violet, 0.5),
        Layer::Handover => tokens.violet.lerp_to_gamma(tokens.coral, 0.5),
        Layer::Reach => tokens.teal.lerp_to_gamma(tokens.amber, 0.6),
        Layer::Grasps => tokens.violet,
        Layer::Rejected => tokens.coral,
        Layer::Contacts => tokens.slate.lerp_to_gamma(tokens.text, 0.6),
    }
}

pub(super) fn label(state: &ViewerState, layer: Layer) -> String {
    let outputs = &state.outputs;
    let counted = |count: Option<usize>| match count {
        Some(count) => format!("{} · {}", layer.title(), format::count(count)),
        None => layer.title().to_owned(),
    };
    let accepted = |wanted: bool| {
        let grasps = outputs.candidates();
        (!grasps.is_empty())
            .then(|| grasps.iter().filter(|grasp| (grasp.status == GraspStatus::Accepted) == wanted).count())
    };
    match layer {
        Layer::Robot => state.who_is_there(),
        Layer::Cloud => counted(outputs.scene.as_ref().map(|scene| scene.cloud.points.len())),
        Layer::Clusters => counted(outputs.segment.as_ref().map(|segment| segment.clusters.len())),
        Layer::Grasps => counted(accepted(true)),
        Layer::Rejected => counted(accepted(false)),
        Layer::Contacts => counted(state.selected_grasp().map(|grasp| grasp.contacts.len())),
        Layer::Routes => {
            let routes = outputs.plan.as_ref().map(|plan| plan.routes.len());
            counted(routes.filter(|&count| count > 0))
        }
        Layer::Handover => counted(state.handover_report().map(|report| report.places.len())),
        Layer::Ghosts => counted(Some(state.planning.ghosts)),
        Layer::Fits | Layer::Goal | Layer::Path | Layer::Swept | Layer::Reach => layer.title().to_owned(),
    }
}
