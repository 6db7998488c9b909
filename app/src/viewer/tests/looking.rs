//! Looking closely, in the window: points in other colours, the view cut open, distances and angles.

use egui::{Key, Pos2, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::Stage;
use nalgebra::Point3;

use super::bench::{Bench, Window, picture, window};
use crate::render::Cut;
use crate::viewer::layout::Layout;
use crate::viewer::{CloudColor, Command, LookCommand, Measured};

const SIZE: [f32; 2] = [1280.0, 720.0];

fn on_screen(harness: &Harness<'_, Window>, p: &Point3<f64>) -> Pos2 {
    let rect = Layout::new(Rect::from_min_size(Pos2::ZERO, SIZE.into()), None).picture();
    let at = harness.state().view.camera().project(p, [f64::from(rect.width()), f64::from(rect.height())]);
    let at = at.expect("it is before the camera");
    rect.min + vec2(at.x as f32, at.y as f32)
}

#[test]
fn clicks_on_the_table_measure_a_distance_and_then_an_angle() {
    let mut harness = window(Bench::until("mustard", Stage::Fit), SIZE, true);
    let _framed = picture(&mut harness, "look-before");
    harness.key_press(Key::M);
    harness.run_steps(2);
    let table = harness.state().bench.page.state.scene().table;
    let (center, z) = (table.center_m, table.height_m);
    let at = |x: f64, y: f64| Point3::new(center[0] + x, center[1] + y, z);
    let places = [at(0.3, -0.4), at(0.3, 0.4), at(-0.2, 0.5)];
    for place in &places {
        let at = on_screen(&harness, place);
        harness.hover_at(at);
        harness.run_steps(1);
        harness.drag_at(at);
        harness.drop_at(at);
        harness.run_steps(3);
    }
    let state = &harness.state().bench.page.state;
    let points = state.looking.measured.clone().expect("it is measured");
    assert_eq!(points.len(), 3);
    for (found, wanted) in points.iter().zip(&places) {
        // The edge of the table is rounded; its face is not.
        assert!((found - wanted).norm() < 2e-3, "{found} for {wanted}");
    }
    let Some(Measured::Distance(m)) = Measured::of(&points[..2]) else { panic!("no distance") };
    assert!((m - 0.8).abs() < 3e-3, "{m} m");
    assert!(matches!(Measured::of(&points), Some(Measured::Angle(_))));
    let _angle = picture(&mut harness, "look-angle");
    assert!(state_selects_nothing(&harness), "a measured click selects nothing");
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(harness.state().bench.page.state.looking.measured, None);
}

fn state_selects_nothing(harness: &Harness<'_, Window>) -> bool {
    let state = &harness.state().bench.page.state;
    state.placing.is_none() && !state.posing.is_open
}

#[test]
fn a_cut_takes_away_what_is_behind_it_and_the_pointer_goes_through() {
    let mut harness = window(Bench::until("mustard", Stage::Fit), SIZE, true);
    let whole = picture(&mut harness, "look-whole");
    let cut = Cut { axis: 2, at_m: 1.0, keeps_above: false };
    harness.state_mut().bench.apply(Command::Look(LookCommand::Cut(Some(cut))));
    let open = picture(&mut harness, "look-cut");
    let differs = whole.pixels().zip(open.pixels()).filter(|(a, b)| a != b).count();
    assert!(differs > 20_000, "{differs} pixels differ");
    harness.state_mut().bench.apply(Command::Look(LookCommand::Cut(None)));
    let again = picture(&mut harness, "look-again");
    let differs = whole.pixels().zip(again.pixels()).filter(|(a, b)| a != b).count();
    assert_eq!(differs, 0, "without a cut the picture is what it was");
}

#[test]
fn points_take_other_colours_with_a_bar_and_other_sizes_from_their_menu() {
    let mut harness = window(Bench::until("mustard", Stage::Fit), SIZE, false);
    let before = picture(&mut harness, "look-fates");
    harness.get_by_label("How points are drawn").click();
    harness.run_steps(3);
    harness.get_by_label("Distance from the camera").click();
    harness.run_steps(3);
    assert_eq!(harness.state().bench.page.state.looking.cloud.by, CloudColor::Distance);
    harness.state_mut().bench.apply(Command::Look(LookCommand::PointSize(4.0)));
    let after = picture(&mut harness, "look-distance");
    let differs = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
    assert!(differs > 20_000, "{differs} pixels differ");
    harness.get_by_label_contains("Diameter of a point: 4.0 mm");
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    harness.get_by_label("View").click();
    harness.run_steps(3);
    let _menu = picture(&mut harness, "look-menu");
    harness.get_by_label("Measure  (M)").click();
    harness.run_steps(3);
    assert!(harness.state().bench.page.state.looking.measured.is_some());
}
