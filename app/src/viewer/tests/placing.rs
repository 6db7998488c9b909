//! Things of the scene: selected, moved, added, taken away, on a demo with the real pipeline.

use egui::{Pos2, Rect, Theme};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::Stage;
use endcomfort_core::scene::Scene;
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::bench::{Bench, Window, picture, window};
use super::page;
use crate::assets;
use crate::viewer::layout::Layout;
use crate::viewer::state::Step;
use crate::viewer::{Command, PlaceCommand, Thing};

fn bench() -> Bench {
    let mut bench = Bench::until("mustard", Stage::Fit);
    bench.apply(Command::SelectStep(Step::Stage(Stage::Scene)));
    bench
}

fn place(bench: &mut Bench, command: PlaceCommand) {
    bench.apply(Command::Place(command));
}

#[test]
fn a_thing_that_is_dragged_takes_its_points_along_and_is_one_step_of_undo() {
    let mut bench = bench();
    let before = bench.page.state.document.clone();
    let task = before.scene.task.object;
    let fitted = |bench: &Bench| bench.page.state.target_fit().expect("a fit").superquadric.X_FS.translation.vector;
    let from = fitted(&bench);
    let X_WO = before.scene.objects[task].X_WO;
    for step in 1..=4 {
        let shift = Translation3::new(0.0, -0.01 * f64::from(step), 0.0);
        place(&mut bench, PlaceCommand::Drag(Thing::Object(task), shift * X_WO));
    }
    place(&mut bench, PlaceCommand::EndDrag);
    let moved = fitted(&bench) - from;
    assert!((moved - Vector3::new(0.0, -0.04, 0.0)).norm() < 0.006, "the fit moved by {moved}");
    bench.apply(Command::Undo);
    assert_eq!(bench.page.state.document, before);
    assert!((fitted(&bench) - from).norm() < 1e-12);
    assert!(!bench.page.state.can_undo());
}

#[test]
fn escape_puts_a_dragged_thing_back() {
    let mut bench = bench();
    let before = bench.page.state.document.clone();
    let X_WC = before.scene.X_WC;
    place(&mut bench, PlaceCommand::Drag(Thing::Camera, Translation3::new(0.1, 0.0, 0.1) * X_WC));
    assert_ne!(bench.page.state.document, before);
    bench.apply(Command::Escape);
    assert_eq!((&bench.page.state.document, bench.page.state.can_undo()), (&before, false));
    // Far outside of the room is a slip of the hand.
    place(&mut bench, PlaceCommand::Drag(Thing::Camera, Isometry3::translation(99.0, 0.0, 0.0)));
    assert_eq!(bench.page.state.document, before);
}

#[test]
fn what_is_added_stands_free_on_the_table_and_what_is_removed_takes_its_number_along() {
    let mut bench = bench();
    let count = bench.page.state.document.scene.objects.len();
    for name in ["tomato_soup_can", "cracker_box", "apple"] {
        place(&mut bench, PlaceCommand::AddObject(name.to_owned()));
    }
    place(&mut bench, PlaceCommand::AddBox);
    let newest = bench.page.state.document.scene.obstacles.len() - 1;
    place(&mut bench, PlaceCommand::Duplicate(Thing::Obstacle(newest)));
    let scene = bench.page.state.document.scene.clone();
    assert_eq!(scene.objects.len(), count + 3);
    let table = &scene.table;
    let mut places = Vec::new();
    for placed in &scene.objects {
        let half = assets::library().object(&placed.object).expect("it is there").half_extents();
        let p = placed.X_WO.translation.vector;
        assert!(p.z - half.z >= table.height_m - 2e-3, "{} is in the table", placed.object);
        assert!((p.x - table.center_m[0]).abs() < 0.5 * table.size_m[0]);
        places.push(p.xy());
    }
    places.extend(scene.obstacles.iter().map(|one| one.X_WB.translation.vector.xy()));
    for (i, a) in places.iter().enumerate().skip(count) {
        assert!(places[..i].iter().all(|b| (a - b).norm() > 0.16), "{a} stands on another one");
    }
    let names: Vec<&str> = scene.obstacles.iter().map(|one| one.name.as_str()).collect();
    assert!(names.ends_with(&["box", "box 2"]), "{names:?}");

    place(&mut bench, PlaceCommand::Grasp(count + 1));
    place(&mut bench, PlaceCommand::Remove(Thing::Object(count)));
    let scene = bench.page.state.document.scene.clone();
    assert_eq!(scene.objects[scene.task.object].object, "cracker_box");
    for _ in 1..scene.objects.len() {
        place(&mut bench, PlaceCommand::Remove(Thing::Object(0)));
    }
    place(&mut bench, PlaceCommand::Remove(Thing::Object(0)));
    assert_eq!(bench.page.state.document.scene.objects.len(), 1, "the last one stays");
    place(&mut bench, PlaceCommand::Remove(Thing::Object(77)));
    place(&mut bench, PlaceCommand::Duplicate(Thing::Obstacle(77)));
    assert!(bench.page.state.messages.iter().any(|message| message.text.starts_with("The last object stays")));
}

#[test]
fn a_box_goes_on_standing_when_it_grows_and_cannot_grow_without_end() {
    let mut bench = bench();
    place(&mut bench, PlaceCommand::AddBox);
    let index = bench.page.state.document.scene.obstacles.len() - 1;
    let foot = |bench: &Bench| {
        let one = &bench.page.state.document.scene.obstacles[index];
        one.X_WB.translation.vector.z - 0.5 * one.size_m.z
    };
    let before = foot(&bench);
    place(&mut bench, PlaceCommand::Resize(index, Vector3::new(0.2, 0.1, 0.4)));
    assert!((foot(&bench) - before).abs() < 1e-12);
    let document = bench.page.state.document.clone();
    place(&mut bench, PlaceCommand::Resize(index, Vector3::new(0.2, 0.1, 11.0)));
    assert_eq!(bench.page.state.document, document);
    assert!(bench.page.state.messages.iter().any(|message| message.is_error && message.text.contains("size_m")));
}

#[test]
fn the_list_selects_and_the_fields_move_what_is_selected() {
    let state = bench().page.state;
    let mut harness = page(state, [1280.0, 1100.0], Theme::Dark);
    harness.run_steps(2);
    harness.get_by_label_contains("Mustard bottle").click();
    harness.run_steps(3);
    let selected = harness.state().state.selected_thing();
    assert!(matches!(selected, Some(Thing::Object(_))), "{selected:?}");
    let objects = harness.state().state.document.scene.objects.len();
    harness.get_by_label("Duplicate").click();
    harness.run_steps(3);
    let state = &harness.state().state;
    assert_eq!(state.document.scene.objects.len(), objects + 1);
    assert_eq!(state.selected_thing(), Some(Thing::Object(objects)), "the copy is selected");
    harness.get_by_label("Grasp this").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state.document.scene.task.object, objects);
    harness.get_by_label("Delete").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state.document.scene.objects.len(), objects);
    assert_eq!(harness.state().state.selected_thing(), None);
}

#[test]
fn a_click_in_the_view_selects_an_object_and_its_gizmo_moves_it_along_the_table() {
    let size = [1280.0, 720.0];
    let mut harness = window(bench(), size, true);
    let _framed = picture(&mut harness, "placing-before");
    // Not the object to grasp: the gizmo of its goal lies over it.
    let apple = |scene: &Scene| scene.objects.iter().position(|placed| placed.object == "apple").expect("it is there");
    let index = apple(&harness.state().bench.page.state.document.scene);
    let X_WO = |harness: &Harness<'_, Window>| harness.state().bench.page.state.document.scene.objects[index].X_WO;
    let before = X_WO(&harness);
    let rect = Layout::new(Rect::from_min_size(Pos2::ZERO, size.into()), None).picture();
    let on_screen = |harness: &Harness<'_, Window>, p: &Point3<f64>| {
        let at = harness.state().view.camera().project(p, [f64::from(rect.width()), f64::from(rect.height())]);
        let at = at.expect("it is before the camera");
        rect.min + egui::vec2(at.x as f32, at.y as f32)
    };
    let middle = on_screen(&harness, &before.translation.vector.into());
    harness.drag_at(middle);
    harness.drop_at(middle);
    harness.run_steps(3);
    assert_eq!(harness.state().bench.page.state.selected_thing(), Some(Thing::Object(index)));
    let _selected = picture(&mut harness, "placing-selected");
    let to = Point3::from(before.translation.vector + Vector3::new(0.05, 0.1, 0.0));
    let (from, to) = (on_screen(&harness, &before.translation.vector.into()), on_screen(&harness, &to));
    harness.hover_at(from);
    harness.run_steps(1);
    harness.drag_at(from);
    harness.run_steps(1);
    for share in [0.3, 0.7, 1.0] {
        harness.hover_at(from + share * (to - from));
        harness.run_steps(2);
    }
    harness.drop_at(to);
    harness.run_steps(2);
    let moved = X_WO(&harness).translation.vector - before.translation.vector;
    assert!((moved - Vector3::new(0.05, 0.1, 0.0)).norm() < 1e-3, "moved by {moved}");
    let _moved = picture(&mut harness, "placing-moved");
}
