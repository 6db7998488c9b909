//! Panels whose inner edges are dragged.

use egui::{Key, Pos2, Rect, Theme, vec2};
use egui_kittest::kittest::Queryable as _;

use super::{invented, page};
use crate::viewer::layout::Layout;
use crate::viewer::{Command, Edge, PanelSizes};

const SIZE: [f32; 2] = [1280.0, 720.0];

#[test]
fn an_edge_is_dragged_moved_by_keys_and_given_back_its_place() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(2);
    let window = Rect::from_min_size(Pos2::ZERO, SIZE.into());
    let before = Layout::of(window, &harness.state().state);
    let right = before.right.expect("the window is wide");
    let edge = right.left_center() - vec2(6.0, 0.0);
    harness.hover_at(edge);
    harness.run_steps(1);
    harness.drag_at(edge);
    harness.run_steps(1);
    for step in [20.0, 40.0, 60.0] {
        harness.hover_at(edge - vec2(step, 0.0));
        harness.run_steps(1);
    }
    harness.drop_at(edge - vec2(60.0, 0.0));
    harness.run_steps(2);
    let after = Layout::of(window, &harness.state().state);
    let grown = after.right.expect("it is still there").width() - right.width();
    assert!((grown - 60.0).abs() < 2.0, "it grew by {grown} points");
    assert!((before.free.width() - after.free.width() - grown).abs() < 1e-3, "the view makes room");
    harness.get_by_label("Size of the timeline").focus();
    harness.run_steps(1);
    harness.key_press(Key::ArrowUp);
    harness.run_steps(2);
    let taller = Layout::of(window, &harness.state().state).timeline.height() - before.timeline.height();
    assert_eq!(taller, 16.0);
    let _effects = harness.state_mut().state.apply(Command::ResetLayout);
    harness.run_steps(2);
    assert_eq!(Layout::of(window, &harness.state().state), before);
}

#[test]
fn sizes_have_ends_and_travel_as_json() {
    let mut sizes = PanelSizes::default();
    sizes.set(Edge::Left, Some(9e9));
    sizes.set(Edge::Timeline, Some(f32::NAN));
    let text = serde_json::to_string(&sizes).expect("plain data");
    assert_eq!(serde_json::from_str::<PanelSizes>(&text).expect("it was just written"), sizes);
    assert_eq!(sizes, PanelSizes([Some(420.0), None, None]));
}

#[test]
fn the_outliner_finds_layers_and_things_by_their_names() {
    let mut harness = page(invented::planned(), SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.get_by_label("Search what is shown").click();
    harness.run_steps(2);
    harness.event(egui::Event::Text("cluster 1".to_owned()));
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label_contains("Opacity of").count(), 0, "no layer has a number in its name");
    harness.get_by_label_contains("Cluster 1,").hover();
    harness.run_steps(2);
    assert_eq!(harness.state().state.hover.cluster, Some(0), "its points light up");
    harness.get_by_label_contains("Cluster 1,").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.selection.cluster, Some(0));
    harness.get_by_label("Clear the words").click();
    harness.run_steps(2);
    harness.get_by_label("Words to search for").focus();
    harness.run_steps(1);
    harness.event(egui::Event::Text("grasps".to_owned()));
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label("Hide Grasps").count(), 1, "a layer keeps its eye");
    assert_eq!(harness.query_all_by_label("Hide Path").count(), 0);
    harness.event(egui::Event::Text(" of nobody".to_owned()));
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label("Nothing is called so.").count(), 1);
    harness.get_by_label("Close the search").click();
    harness.run_steps(2);
    assert_eq!(harness.query_all_by_label("Hide Path").count(), 1);
}
