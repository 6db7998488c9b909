//! What people bring to the page: robots, meshes, depth images; with the real pipeline.

use egui::Theme;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::guest::GuestRobot;
use endcomfort_core::job::Stage;
use endcomfort_core::scene::ArmChoice;

use super::bench::{Bench, picture, window};
use super::page;
use crate::viewer::state::Step;
use crate::viewer::{BringCommand, Bringing, Command, Effect};

const SIX_ARM: &str = include_str!("../../../../robots/examples/six_arm.urdf");

#[test]
fn hands_that_an_arm_may_be_given_are_called_so() {
    for (file, name) in crate::viewer::bringing::HANDS {
        assert_eq!(crate::assets::library().hand(file).expect(file).name, name);
    }
}

fn bring(bench: &mut Bench, files: &[(&str, &[u8])]) {
    let files = files.iter().map(|(path, bytes)| ((*path).to_owned(), bytes.to_vec())).collect();
    bench.apply(Command::Bring(BringCommand::Files(files)));
}

fn said(bench: &Bench) -> String {
    bench.page.state.messages.last().map_or_else(String::new, |message| message.text.clone())
}

/// A robot whose upper arm has a mesh that is not there.
fn with_missing_mesh() -> String {
    let mesh = "<visual><geometry><mesh filename='package://six/upper.stl'/></geometry></visual>";
    SIX_ARM.replacen("<link name=\"upper_link\">", &format!("<link name=\"upper_link\">{mesh}"), 1)
}

#[test]
fn a_robot_that_is_dropped_acts_at_once_and_undo_brings_the_old_one_back() {
    let mut bench = Bench::until("mustard", Stage::Plan);
    let before = bench.page.state.document.clone();
    bring(&mut bench, &[("six/six_arm.urdf", SIX_ARM.as_bytes())]);
    let state = &bench.page.state;
    assert_eq!(GuestRobot::title_of(&state.document.scene.robot), "six_arm");
    assert_eq!((state.document.scene.arm, state.document.scene.posture.as_str()), (ArmChoice::Left, "ready"));
    assert!(state.refusal().is_none() && state.outputs.plan.is_some(), "{:?}", state.refusal());
    assert!(said(&bench).starts_with("six_arm acts now"), "{}", said(&bench));
    assert!(bench.asked.last().is_some_and(|request| request.robot.is_some()), "its files go along with the request");
    assert!(!state.has_arm(ArmChoice::Right) && state.robots.iter().any(|robot| robot.title == "six_arm"));
    bench.apply(Command::Undo);
    assert_eq!(bench.page.state.document, before);
    // The switch knows it from now on.
    let name = bench.page.state.robots.last().expect("it is listed").name.clone();
    bench.apply(Command::SetRobot(name));
    assert_eq!(bench.page.state.document.scene.arm, ArmChoice::Left);
    assert!(bench.page.state.outputs.plan.is_some());
}

#[test]
fn the_scene_panel_lists_missing_meshes_and_opens_the_window_of_arms_and_hands() {
    let mut bench = Bench::until("mustard", Stage::Rank);
    bring(&mut bench, &[("six_arm.urdf", with_missing_mesh().as_bytes())]);
    bench.apply(Command::SelectStep(Step::Stage(Stage::Scene)));
    let mut harness = page(bench.page.state, [1440.0, 1400.0], Theme::Dark);
    harness.run();
    harness.get_by_label_contains("A marked box is drawn in place of a body");
    // In the list, and in the message that told of it.
    assert!(harness.query_all_by_label_contains("package://six/upper.stl").count() >= 1);
    assert!(harness.query_by_label("Right arm").is_none(), "it has one arm");
    harness.get_by_label("Arms and hands…").click();
    harness.run();
    harness.get_by_label("Arms and hands of six_arm");
    harness.run_steps(30);
    harness.get_by_label("Use this robot").click();
    harness.run_steps(30);
    let page = harness.state();
    assert!(page.state.bringing.is_none(), "{:?}, {:?}", page.commands, page.state.bringing);
}

#[test]
fn a_robot_without_an_arm_that_can_be_found_asks_for_it() {
    // A neck by its name, of six joints: whoever brought it knows better.
    let urdf = SIX_ARM.replace("\"elbow\"", "\"neck_joint\"");
    let mut bench = Bench::until("mustard", Stage::Rank);
    let before = bench.page.state.document.clone();
    bring(&mut bench, &[("odd.urdf", urdf.as_bytes())]);
    assert_eq!(bench.page.state.document, before, "nothing changes before it is asked");
    let Some(Bringing::Robot(window)) = &bench.page.state.bringing else { panic!("a window") };
    assert!(window.problem.as_ref().is_some_and(|problem| problem.contains("names no arm")));
    assert!(window.notes.iter().any(|note| note.contains("speaks of a neck")), "{:?}", window.notes);
    assert_eq!((window.draft.arms[0].base_link.as_str(), window.links.len()), ("base_link", 8));
    let mut draft = window.draft.clone();
    draft.arms[0].tip_link = "fore_link".to_owned();
    bench.apply(Command::Bring(BringCommand::Draft(draft.clone())));
    bench.apply(Command::Bring(BringCommand::Accept { is_grasped: false }));
    let Some(Bringing::Robot(window)) = &bench.page.state.bringing else { panic!("it stays open") };
    let problem = window.problem.clone().expect("what is wrong");
    assert!(problem.contains("found 3 moving joints"), "{problem}");
    draft.arms[0].tip_link = "tool0".to_owned();
    bench.apply(Command::Bring(BringCommand::Draft(draft)));
    bench.apply(Command::Bring(BringCommand::SaveChoice));
    bench.apply(Command::Bring(BringCommand::Accept { is_grasped: false }));
    assert!(bench.page.state.bringing.is_none());
    assert_eq!(bench.page.state.robot_title(), "odd");
    assert!(bench.page.state.outputs.rank.is_some(), "{:?}", bench.page.state.refusal());
}

#[test]
fn a_robot_whose_srdf_names_its_arms_keeps_them() {
    let [urdf, srdf] = ["urdf", "srdf"].map(|ending| crate::assets::read(&format!("robots/alita/alita.{ending}")));
    let (urdf, srdf) = (urdf.expect("its URDF"), srdf.expect("its SRDF"));
    let mut bench = Bench::until("mustard", Stage::Scene);
    bring(&mut bench, &[("a/mine.urdf", urdf), ("a/mine.srdf", srdf)]);
    let acting = bench.page.state.document.scene.robot.clone();
    assert_eq!(GuestRobot::title_of(&acting), "mine");
    assert!(bench.page.state.has_arm(ArmChoice::Left) && bench.page.state.has_arm(ArmChoice::Right));
    bench.apply(Command::Bring(BringCommand::OpenRobot));
    let Some(Bringing::Robot(window)) = &bench.page.state.bringing else { panic!("a window") };
    assert!(window.draft.arms.is_empty() && window.draft.posture.is_some());
    bench.apply(Command::Bring(BringCommand::Accept { is_grasped: false }));
    assert_eq!(bench.page.state.document.scene.robot, acting, "nothing was changed");
}

#[test]
fn a_choice_is_saved_and_dropped_again() {
    let mut bench = Bench::until("mustard", Stage::Scene);
    bring(&mut bench, &[("six_arm.urdf", SIX_ARM.as_bytes())]);
    let acting = bench.page.state.document.scene.robot.clone();
    let effects = bench.page.state.apply(Command::Bring(BringCommand::SaveChoice));
    let [Effect::Save { name, bytes }] = effects.as_slice() else { panic!("{effects:?}") };
    assert_eq!(name, "six_arm.robot.json");
    let mut choice: serde_json::Value = serde_json::from_slice(bytes).expect("JSON");
    choice["posture"]["elbow"] = 0.7.into();
    let moved = choice.to_string();
    bring(&mut bench, &[(name, moved.as_bytes())]);
    let other = bench.page.state.document.scene.robot.clone();
    assert_ne!(other, acting, "another posture is another robot: {}", said(&bench));
    assert_eq!(GuestRobot::title_of(&other), "six_arm");
    bench.apply(Command::SetRobot("alita".into()));
    bring(&mut bench, &[(name, moved.as_bytes())]);
    assert!(said(&bench).contains("which does not act here"), "{}", said(&bench));
    assert_eq!(bench.page.state.document.scene.robot, "alita");
}

#[test]
fn what_cannot_be_used_is_refused_and_the_scene_stays() {
    let mut bench = Bench::until("mustard", Stage::Scene);
    let before = bench.page.state.document.clone();
    for (files, wanted) in [
        (vec![("a.urdf.xacro", &b"<robot/>"[..])], "expand it first"),
        (vec![("a.urdf", &b"<robot name='r'><link name='a'/><link name='a'/></robot>"[..])], "defined a second time"),
        (vec![("a.zip", &b"PK\x03\x04 and no more"[..])], "end of the directory"),
        (vec![("x.urdf", SIX_ARM.as_bytes()), ("y.urdf", SIX_ARM.as_bytes())], "found 2 URDF files"),
        (vec![("a.stl", &b"solid nothing"[..])], "no faces"),
        (vec![("photo.png", &b"\x89PNG\r\n\x1a\n broken"[..])], "photo.png"),
    ] {
        bring(&mut bench, &files);
        assert!(said(&bench).contains(wanted), "{wanted:?} is not in {:?}", said(&bench));
        assert_eq!(bench.page.state.document, before);
        assert!(bench.page.state.bringing.is_none());
    }
}

#[test]
fn a_mesh_asks_for_its_unit_and_is_grasped_or_stands_in_the_way() {
    let mut obj = String::new();
    for k in 0..8 {
        let side = |bit: usize, size: f64| if k >> bit & 1 == 1 { size } else { 0.0 };
        obj += &format!("v {} {} {}\n", side(0, 60.0), side(1, 40.0), side(2, 110.0));
    }
    obj += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    let mut bench = Bench::until("mustard", Stage::Plan);
    let objects = bench.page.state.document.scene.objects.len();
    bring(&mut bench, &[("part.obj", obj.as_bytes())]);
    let mut harness = page(bench.page.state, [1440.0, 900.0], Theme::Dark);
    harness.run();
    harness.get_by_label("What is part.obj?");
    harness.get_by_label_contains("60 × 40 × 110 mm");
    harness.get_by_label("m").click();
    harness.run();
    harness.get_by_label("Grasp it").click();
    harness.run();
    harness.get_by_label_contains("wanted edges of 5 mm to 2 m");
    harness.get_by_label("mm").click();
    harness.run();
    harness.get_by_label("Grasp it").click();
    harness.run();
    let scene = harness.state().state.document.scene.clone();
    assert_eq!((scene.objects.len(), scene.task.object), (objects + 1, objects));
    assert!(scene.objects[objects].object.starts_with("part@"));
    harness.get_by_label_contains("Part · to grasp");
    let request = harness.state().state.document.request(1);
    assert_eq!(request.objects.len(), 1, "its shape goes along with the request");
}

#[test]
fn a_depth_image_comes_with_its_camera_or_asks_for_the_field_of_view() {
    let image = image::ImageBuffer::<image::Luma<u16>, _>::from_fn(320, 240, |u, v| {
        image::Luma([if (130..190).contains(&u) && (100..140).contains(&v) { 800 } else { 1000_u16 }])
    });
    let mut png = std::io::Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).expect("it can be written");
    let png = png.into_inner();
    let camera = br#"{"fx": 262, "fy": 262, "cx": 159.5, "cy": 119.5}"#;
    let mut bench = Bench::until("mustard", Stage::Fit);
    bring(&mut bench, &[("depth.png", &png), ("camera.json", camera)]);
    let points = |bench: &Bench| bench.page.state.outputs.scene.as_ref().map(|scene| scene.cloud.points.len());
    assert_eq!(points(&bench), Some(320 * 240), "{}", said(&bench));
    bench.apply(Command::Undo);
    bring(&mut bench, &[("depth.png", &png)]);
    assert!(bench.page.state.document.cloud.is_none() && bench.page.state.bringing.is_some());
    bench.apply(Command::Bring(BringCommand::SetView(200.0)));
    bench.apply(Command::Bring(BringCommand::Accept { is_grasped: false }));
    let Some(Bringing::Depth(window)) = &bench.page.state.bringing else { panic!("it stays open") };
    assert!(window.problem.as_ref().is_some_and(|problem| problem.contains("field of view: found 200")));
    bench.apply(Command::Bring(BringCommand::SetView(62.8)));
    bench.apply(Command::Bring(BringCommand::Accept { is_grasped: false }));
    assert_eq!(points(&bench), Some(320 * 240), "{}", said(&bench));
}

#[test]
fn the_windows_and_a_robot_with_marked_boxes_as_pictures() {
    let mut bench = Bench::until("mustard", Stage::Plan);
    bring(&mut bench, &[("six_arm.urdf", with_missing_mesh().as_bytes())]);
    bench.apply(Command::SelectStep(Step::Stage(Stage::Scene)));
    let size = [1440.0, 900.0];
    let mut harness = window(bench, size, true);
    let shown = picture(&mut harness, "own-robot");
    // The box of the upper arm is orange, which nothing else in this scene is so much.
    let is_marked =
        |pixel: &&image::Rgba<u8>| pixel[0] > 150 && pixel[2] < 110 && pixel[0] > pixel[2].saturating_mul(2);
    let count = shown.pixels().filter(is_marked).count();
    assert!(count > 600, "{count} pixels of marked boxes");
    harness.state_mut().bench.apply(Command::Bring(BringCommand::OpenRobot));
    let _picture = picture(&mut harness, "own-robot-window");
    harness.state_mut().bench.apply(Command::Bring(BringCommand::Cancel));
    let stl =
        b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 90 0 0\nvertex 0 70 30\nendloop\nendfacet\n";
    bring(&mut harness.state_mut().bench, &[("part.stl", stl)]);
    let _picture = picture(&mut harness, "own-mesh-window");
}
