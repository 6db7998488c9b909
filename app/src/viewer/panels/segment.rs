//! Where the points went: table, clusters, and everything that was left out and why.

use egui::{Align, Color32, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use endcomfort_core::job::{SegmentOutput, Stage};
use endcomfort_core::segment::PointFate;

use super::Out;
use super::inspector::{heading, nothing_yet};
use super::save_menu::saved_section;
use crate::export::TableKind;
use crate::viewer::theme::{BODY, SECONDARY, Tokens, font};
use crate::viewer::widgets::{focus_ring, key_value, primary_button, section, text_in};
use crate::viewer::{Command, ViewerState, format};

pub(super) fn draw(ui: &mut Ui, state: &ViewerState, out: &mut Out) {
    let Some(segment) = &state.outputs.segment else { return nothing_yet(ui, state, Stage::Segment) };
    let count = segment.clusters.len();
    let text = format!("{} on the table", format::plural(count, "cluster"));
    heading(ui, state, Stage::Segment, &text, "Every point of the cloud is accounted for.");
    saved_section(ui, "Points", TableKind::Fates, None, out);
    fates(ui, segment);

    saved_section(ui, "Clusters, largest first", TableKind::Clusters, None, out);
    for (index, points) in segment.clusters.iter().enumerate() {
        cluster_row(ui, state, segment, index, points.len(), out);
    }
    ui.add_space(6.0);
    if let Some(selected) = state.selection.cluster.filter(|&cluster| cluster < count && cluster != segment.target)
        && primary_button(ui, &format!("Grasp cluster {}", selected + 1), !state.running).clicked()
    {
        out.push(Command::GraspCluster(selected));
    }

    section(ui, "Table plane");
    let tilt_deg = segment.table.normal.z.abs().min(1.0).acos().to_degrees();
    let _row = key_value(ui, "Height", &format::length(segment.table.offset_m));
    let _row = key_value(ui, "Tilt", &format!("{tilt_deg:.1}°"));
    section(ui, "Settings");
    let settings = &state.document.scene.segment;
    let _row = key_value(ui, "Point on the plane within", &format::length(settings.plane_distance_m));
    let _row = key_value(ui, "Hypotheses", &format::count(settings.plane_hypotheses as usize));
    let heights = format!("{} to {}", format::length(settings.min_height_m), format::length(settings.max_height_m));
    let _row = key_value(ui, "Objects above the plane", &heights);
    let _row = key_value(ui, "Gap between clusters", &format::length(settings.cluster_distance_m));
    let _row = key_value(ui, "Smallest cluster", &format::plural(settings.cluster_min_points, "point"));
}

const KINDS: usize = 8;

fn kind(fate: PointFate) -> usize {
    match fate {
        PointFate::Cluster(_) => 0,
        PointFate::Table => 1,
        PointFate::TooLow => 2,
        PointFate::BelowTable => 3,
        PointFate::TooHigh => 4,
        PointFate::OffTable => 5,
        PointFate::SmallCluster => 6,
        PointFate::KnownObstacle => 7,
    }
}

fn words(kind: usize) -> &'static str {
    [
        "In a cluster",
        "On the table",
        "Too low to tell",
        "Below the table",
        "Too high",
        "Beside the table",
        "In too small a cluster",
        "On a known box",
    ][kind]
}

fn color(kind: usize, tokens: &Tokens) -> Color32 {
    let coral = |t: f32| tokens.coral.lerp_to_gamma(tokens.panel.to_opaque(), t);
    [tokens.teal, tokens.slate, tokens.amber, coral(0.0), coral(0.25), coral(0.45), tokens.violet, tokens.blue][kind]
}

/// A bar of all points by what became of them, and the numbers.
fn fates(ui: &mut Ui, segment: &SegmentOutput) {
    let tokens = Tokens::of(ui);
    let mut counts = [0_usize; KINDS];
    for &fate in &segment.fates {
        counts[kind(fate)] += 1;
    }
    let total = segment.fates.len().max(1);
    let (bar, _) = ui.allocate_exact_size(vec2(ui.available_width(), 10.0), Sense::hover());
    let mut left = bar.left();
    for (kind, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let width = (bar.width() - 12.0) * count as f32 / total as f32 + 1.0;
        let rect = Rect::from_min_size(pos2(left, bar.top()), vec2(width, bar.height()));
        ui.painter().rect_filled(rect, 2.0, color(kind, tokens));
        left = rect.right() + 1.0;
    }
    ui.add_space(4.0);
    for (kind, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 24.0), Sense::hover());
        let swatch = Rect::from_center_size(pos2(rect.left() + 4.5, rect.center().y), vec2(9.0, 9.0));
        ui.painter().rect_filled(swatch, 2.5, color(kind, tokens));
        let text = Rect::from_min_max(pos2(rect.left() + 17.0, rect.top()), rect.max);
        let _text = text_in(ui, text, Align::Min, words(kind), font(BODY), tokens.text);
        let share = format!("{} · {:.1} %", format::count(count), 100.0 * count as f64 / total as f64);
        let _text = text_in(ui, text, Align::Max, &share, font(SECONDARY), tokens.secondary);
    }
}

fn cluster_row(ui: &mut Ui, state: &ViewerState, segment: &SegmentOutput, index: usize, points: usize, out: &mut Out) {
    let tokens = Tokens::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::click());
    let full = rect.expand2(vec2(13.0, 0.0));
    let is_selected = state.selection.cluster == Some(index);
    if is_selected {
        ui.painter().rect_filled(full, 0.0, tokens.selected);
    } else if response.hovered() || state.hover.cluster == Some(index) {
        ui.painter().rect_filled(full, 0.0, tokens.hover);
    }
    let name = format!("Cluster {}", index + 1);
    let _text = text_in(ui, rect, Align::Min, &name, font(BODY), tokens.text);
    let what = if segment.target == index { "to be grasped · " } else { "" };
    let text = format!("{what}{}", format::plural(points, "point"));
    let _text = text_in(ui, rect, Align::Max, &text, font(SECONDARY), tokens.secondary);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, &name));
    focus_ring(ui, &response, full);
    if response.contains_pointer() {
        out.cluster = Some(index);
    }
    if response.clicked() {
        out.push(Command::SelectCluster(index));
    }
}
