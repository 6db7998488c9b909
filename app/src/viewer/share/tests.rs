//! Links and sessions of the real demos, there and back.

use std::sync::Arc;

use endcomfort_core::job::{DroppedCloud, SetShape};
use endcomfort_core::scene::{ArmChoice, Scene};
use endcomfort_core::superquadric::Superquadric;
use serde_json::{Value, json};

use super::packing::{MAX_UNPACKED_BYTES, pack, unpack};
use super::*;
use crate::assets;
use crate::host::{Entry, Store};
use crate::render::{Camera, Cut};
use crate::viewer::state::Step;
use crate::viewer::{BringCommand, CloudLook, Command, Demo, Document, Layer, LookCommand, ViewCommand, ViewerState};

/// What any chat program, mail and issue tracker takes, characters.
const SHORT: usize = 2000;

fn demos() -> Vec<Demo> {
    let demo =
        |name: &&str| Demo { name: (*name).to_owned(), scene: Arc::new(assets::demo(name).unwrap()), thumbnail: None };
    assets::DEMOS.iter().map(demo).collect()
}

fn with_demo(name: &str) -> ViewerState {
    let demos = demos();
    let scene = demos.iter().find(|demo| demo.name == name).unwrap().scene.clone();
    let mut state = ViewerState::new(Document::new(scene), demos, Vec::new());
    state.demo = Some(name.to_owned());
    state
}

fn moved_camera() -> Camera {
    Camera { yaw_rad: 1.234_567_89, pitch_rad: -0.412_345_6, distance_m: 3.240_713_65, ..Camera::default() }
}

/// Everything that an address can hold, away from where it was at first.
fn look_around(state: &mut ViewerState) {
    state.selection.step = Step::Play;
    state.selection.grasp = Some(1234);
    state.selection.cluster = Some(2);
    state.playback.time_s = 7.654_321;
    for layer in [Layer::Rejected, Layer::Ghosts, Layer::Robot] {
        let view = state.layers.get_mut(layer);
        view.visible = !view.visible;
        view.opacity = 0.35;
    }
}

fn edit(state: &mut ViewerState, change: impl FnOnce(&mut Scene)) {
    change(Arc::make_mut(&mut state.document.scene));
}

fn link_of(content: &Value) -> String {
    format!("#s={}", pack(&content.to_string()))
}

fn error_of(content: &Value) -> String {
    read_link(&link_of(content), &demos()).unwrap_err().to_string()
}

#[test]
fn the_link_to_any_demo_is_short_and_holds_it_by_its_name() {
    let mut longest = (0, "");
    for name in assets::DEMOS {
        let mut state = with_demo(name);
        look_around(&mut state);
        let link = link_text(&state, Some(moved_camera())).unwrap();
        let content: Value = serde_json::from_str(&unpack(link.strip_prefix("#s=").unwrap()).unwrap()).unwrap();
        assert_eq!((&content["demo"], content.get("changes"), content.get("scene")), (&json!(name), None, None));
        longest = longest.max((link.len(), name));
    }
    println!("the longest link to a demo: {longest:?}");
    assert!(longest.0 <= SHORT, "{longest:?}");
}

#[test]
fn a_link_to_an_edited_demo_holds_what_differs_and_opens_as_the_same_document_to_the_last_digit() {
    let mut longest = (0, "");
    for name in assets::DEMOS {
        let mut state = with_demo(name);
        look_around(&mut state);
        edit(&mut state, |scene| {
            // Digits as a drag leaves them.
            scene.objects[0].X_WO.translation.vector.x += 1.0 / 3.0;
            scene.X_WC.rotation =
                nalgebra::UnitQuaternion::from_euler_angles(0.1, 2.0 / 3.0, 1.0) * scene.X_WC.rotation;
            scene.seed = u64::MAX;
            scene.arm = ArmChoice::Left;
            scene.grasp.friction = 0.1 + 0.2;
            scene.task.steps.clear();
        });
        let X_WS = nalgebra::Isometry3::translation(0.5, 0.1, 0.8);
        let superquadric = Superquadric::new(0.031, 0.042, 0.1 / 3.0, 0.7, 1.1, X_WS).unwrap();
        state.document.shape = Some(SetShape { cluster: 1, superquadric });
        (state.document.cluster, state.document.grasp) = (Some(1), Some(17));
        let link = link_text(&state, Some(moved_camera())).unwrap();
        let opened = read_link(&link, &state.demos).unwrap();
        assert_eq!(opened.document, state.document, "{name}");
        assert_eq!(opened.demo.as_deref(), Some(name));
        assert_eq!(opened.view.layers(), state.layers);
        assert_eq!((opened.view.step(), opened.view.grasp), (Some(Step::Play), Some(1234)));
        assert!((opened.view.time_s - state.playback.time_s).abs() < 1e-4);
        let camera = opened.view.camera.unwrap();
        assert!((camera.eye() - moved_camera().eye()).norm() < 1e-5, "rounded to a millionth: {camera:?}");
        longest = longest.max((link.len(), name));
    }
    println!("the longest link to an edited demo: {longest:?}");
    assert!(longest.0 <= SHORT, "{longest:?}");
}

#[test]
fn a_scene_of_no_demo_travels_as_a_whole() {
    let mut state = with_demo("mustard");
    state.demo = None;
    edit(&mut state, |scene| scene.name = "my own".to_owned());
    let opened = read_link(&link_text(&state, None).unwrap(), &state.demos).unwrap();
    assert_eq!((opened.document, opened.demo), (state.document.clone(), None));
    assert_eq!(opened.view.camera, None);
}

#[test]
fn a_link_is_read_from_a_whole_address_from_its_end_and_with_blanks_about_it() {
    let state = with_demo("jar");
    let link = link_text(&state, None).unwrap();
    for text in [
        link.clone(),
        link.replace("#s=", ""),
        format!("https://example.org/a/?renderer=webgl{link}"),
        format!(" {link}\n"),
    ] {
        assert_eq!(read_link(&text, &state.demos).unwrap().demo.as_deref(), Some("jar"), "{text}");
    }
}

#[test]
fn a_broken_link_names_what_is_wrong() {
    let demos = demos();
    let refused = |text: &str| read_link(text, &demos).unwrap_err().to_string();
    assert!(refused("#s=what is this?").contains("not base64url"));
    assert!(refused("#s=AAAA").contains("not deflate"), "{}", refused("#s=AAAA"));
    assert!(refused(&format!("#s={}", pack("no JSON"))).contains("not ours"));
    assert_eq!(error_of(&json!({"version": 7})), "its version is 7, and this program reads version 1");
    assert_eq!(error_of(&json!({})), "its version is null, and this program reads version 1");
    assert_eq!(error_of(&json!({"version": 1})), "it names no demo and holds no scene");
    let unknown = error_of(&json!({"version": 1, "demo": "spoon"}));
    assert!(unknown.contains("\"spoon\"") && unknown.contains("mustard, jar"), "{unknown}");
    let scene = error_of(&json!({"version": 1, "demo": "jar", "changes": {"table": {"height_m": 99}}}));
    assert!(scene.contains("table.height_m") && scene.contains("99"), "{scene}");
    let format = error_of(&json!({"version": 1, "demo": "jar", "changes": {"objects": 3}}));
    assert!(format.contains("its scene is wrong"), "{format}");
    let huge = format!("#s={}", pack(&" ".repeat(MAX_UNPACKED_BYTES + 1)));
    assert!(refused(&huge).contains(&MAX_UNPACKED_BYTES.to_string()));
    for (view, place) in [
        (json!({"time_s": -1.0}), "view.time_s"),
        (json!({"step": "dance"}), "view.step"),
        (
            json!({"camera": {"target": [0, 0, 1e9], "distance_m": 1, "yaw_rad": 0, "pitch_rad": 0, "fov_y_rad": 1,
                           "projection": "Perspective"}}),
            "view.camera.target[2]",
        ),
        (
            json!({"camera": {"target": [0, 0, 0], "distance_m": 0, "yaw_rad": 0, "pitch_rad": 0, "fov_y_rad": 1,
                           "projection": "Perspective"}}),
            "view.camera.distance_m",
        ),
        (json!({"layers": {"moon": {"visible": true, "opacity": 1}}}), "moon"),
    ] {
        let error = error_of(&json!({"version": 1, "demo": "jar", "view": view}));
        assert!(error.contains(place), "{error}");
    }
}

#[test]
fn a_session_holds_a_dropped_cloud_and_a_link_says_that_it_does_not() {
    let mut state = with_demo("mustard");
    let cloud = DroppedCloud { name: "desk.pcd".to_owned(), bytes: (0..=255).collect() };
    state.document.cloud = Some(Arc::new(cloud));
    state.document.grasp = Some(3);
    state.demo = None;
    let session: Value = serde_json::from_str(&session_text(&state, None, true).unwrap()).unwrap();
    assert!(is_session(&session) && !is_session(&json!({"version": 2})));
    let opened = read_session(session, &state.demos).unwrap();
    assert_eq!((&opened.document, opened.demo), (&state.document, None));

    let linked = read_link(&link_text(&state, None).unwrap(), &state.demos).unwrap();
    let without = Document { cloud: None, grasp: None, ..state.document.clone() };
    assert_eq!(linked.document, without, "a grasp of the cloud means nothing without it");
    let sentence = state.shared_sentence(300);
    assert!(sentence.contains("desk.pcd is not in the link: save the session instead"), "{sentence}");
}

#[test]
fn a_session_file_opens_as_a_scene_does_and_a_broken_one_changes_nothing() {
    let mut state = with_demo("glass");
    edit(&mut state, |scene| scene.seed = 99);
    look_around(&mut state);
    let text = session_text(&state, Some(moved_camera()), true).unwrap();
    let mut other = with_demo("mustard");
    let effects = other.apply(Command::OpenFile { name: "x.endcomfort.json".to_owned(), bytes: text.into_bytes() });
    assert_eq!((&other.document, other.demo.as_deref()), (&state.document, Some("glass")));
    assert_eq!((other.layers, other.selection.step), (state.layers, Step::Play));
    assert!(effects.iter().any(|effect| matches!(effect, crate::viewer::Effect::PlaceCamera(_))), "{effects:?}");
    assert!(
        !effects
            .iter()
            .any(|effect| matches!(effect, crate::viewer::Effect::View(crate::viewer::ViewEffect::FrameAll))),
        "{effects:?}"
    );

    let before = other.document.clone();
    let broken = json!({"endcomfort_session": 2}).to_string();
    let _said = other.apply(Command::OpenFile { name: "y.json".to_owned(), bytes: broken.into_bytes() });
    assert_eq!(other.document, before);
    let said = &other.messages.last().unwrap().text;
    assert!(said.contains("y.json") && said.contains("version is 2"), "{said}");
}

#[test]
fn what_was_kept_is_offered_while_it_is_young_and_whole() {
    let state = with_demo("pour");
    let session: Value = serde_json::from_str(&session_text(&state, None, true).unwrap()).unwrap();
    let record = json!({"title": "Pouring", "saved_unix_s": 1000.0, "session": session});
    let offer = Offer::parse(&record.to_string(), &state.demos, 1000.0 + 720.0).unwrap();
    assert_eq!((offer.title.as_str(), offer.when().as_str()), ("Pouring", "12 minutes ago"));
    assert_eq!(offer.opened.document, state.document);
    for (record, now_s) in [
        (record.to_string(), 1000.0 + 31.0 * 86_400.0),
        (json!({"title": "Pouring", "saved_unix_s": 1000.0, "session": {"endcomfort_session": 0}}).to_string(), 1000.0),
        (json!({"title": "Pouring"}).to_string(), 1000.0),
        ("{".to_owned(), 1000.0),
        ("null".to_owned(), 1000.0),
    ] {
        assert!(Offer::parse(&record, &state.demos, now_s).is_err(), "{record}");
    }
}

#[test]
fn only_a_settled_edit_is_written_and_not_more_often_than_every_two_seconds() {
    let mut state = with_demo("jar");
    let mut store = Shelf::default();
    let mut autosave = Autosave::new(state.revision);
    assert_eq!(autosave.due_in_s(&state, 10.0), None, "nobody has edited anything");
    let _run = state.apply(Command::SetSeed(5));
    assert_eq!(autosave.due_in_s(&state, 10.0), None, "it runs");
    state.running = false;
    assert_eq!(autosave.due_in_s(&state, 10.0), Some(0.0));
    autosave.write(&state, moved_camera(), 10.0, &mut store);
    assert_eq!(autosave.due_in_s(&state, 11.0), None);
    let _run = state.apply(Command::SetSeed(6));
    state.running = false;
    assert_eq!(autosave.due_in_s(&state, 10.5), Some(1.5));
    let offer = Offer::read(&mut store, &state.demos).unwrap();
    assert_eq!((offer.opened.document.scene.seed, offer.when().as_str()), (5, "just now"));

    // A cloud that does not fit is left out.
    let bytes = vec![7; 4_000_000];
    state.document.cloud = Some(Arc::new(DroppedCloud { name: "huge.pcd".to_owned(), bytes }));
    autosave.write(&state, moved_camera(), 20.0, &mut store);
    assert_eq!(Offer::read(&mut store, &state.demos).unwrap().opened.document.cloud, None);
    store.text = Some("garbage".to_owned());
    assert_eq!(Offer::read(&mut store, &state.demos), None);
    assert_eq!(store.text, None, "what is wrong is not met again");
}

#[derive(Default)]
struct Shelf {
    text: Option<String>,
}

impl Store for Shelf {
    fn read(&self, entry: Entry) -> Option<String> {
        self.text.clone().filter(|_| entry == Entry::Session)
    }

    fn write(&mut self, _entry: Entry, text: &str) -> Result<(), String> {
        self.text = Some(text.to_owned());
        Ok(())
    }

    fn forget(&mut self, _entry: Entry) {
        self.text = None;
    }
}

#[test]
fn kept_views_the_cut_and_the_look_of_points_travel_and_wrong_ones_are_named() {
    let mut state = with_demo("jar");
    let camera = moved_camera();
    let _said = state.apply(Command::View(ViewCommand::KeepCamera(camera)));
    let cut = Cut { axis: 0, at_m: 0.45, keeps_above: false };
    let _cut = state.apply(Command::Look(LookCommand::Cut(Some(cut))));
    let _size = state.apply(Command::Look(LookCommand::PointSize(4.0)));
    let link = link_text(&state, Some(camera)).unwrap();
    assert!(link.len() < 2000, "{} characters", link.len());
    let opened = read_link(&link, &state.demos).unwrap();
    let mut other = with_demo("mustard");
    let _effects = other.apply(Command::OpenShared(Box::new(opened.clone())));
    assert_eq!(other.looking, state.looking);
    assert_eq!(other.viewing.kept.len(), 1);
    assert!((other.viewing.kept[0].camera.target - camera.target).norm() < 1e-6);
    for wrong in [
        SharedView { cut: Some(Cut { axis: 7, ..cut }), ..opened.view.clone() },
        SharedView { kept: vec![Camera { distance_m: -1.0, ..camera }], ..opened.view.clone() },
        SharedView { points: Some(CloudLook { diameter_m: 9.0, ..CloudLook::default() }), ..opened.view.clone() },
    ] {
        let error = wrong.checked().unwrap_err().to_string();
        assert!(error.contains("view."), "{error}");
    }
}

#[test]
fn a_session_carries_a_robot_and_an_object_of_ones_own_and_a_link_says_that_it_does_not() {
    let mut state = with_demo("mustard");
    let urdf = include_str!("../../../../robots/examples/six_arm.urdf");
    let robot = vec![("six_arm.urdf".to_owned(), urdf.as_bytes().to_vec())];
    let _run = state.apply(Command::Bring(BringCommand::Files(robot)));
    let obj = b"v 0 0 0\nv 80 0 0\nv 0 80 0\nv 0 0 80\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n".to_vec();
    let _asks = state.apply(Command::Bring(BringCommand::Files(vec![("tetra.obj".to_owned(), obj)])));
    let _run = state.apply(Command::Bring(BringCommand::Accept { is_grasped: true }));
    let document = state.document.clone();
    assert!(document.scene.robot.starts_with("six_arm@"));

    let session: Value = serde_json::from_str(&session_text(&state, None, true).unwrap()).unwrap();
    assert_eq!(session["robot"]["urdf"], urdf);
    assert!(session["objects"][0]["name"].as_str().unwrap().starts_with("tetra@"));
    let opened = read_session(session.clone(), &demos()).unwrap();
    assert_eq!(opened.document, document);
    // What is wrong with a robot that travels is said like what is wrong with a file.
    let mut broken = session;
    broken["robot"]["urdf"] = "<robot name='r'/>".into();
    let error = read_session(broken, &demos()).unwrap_err().to_string();
    assert!(error.contains("no links"), "{error}");

    let link = link_text(&state, None).unwrap();
    let content: Value = serde_json::from_str(&unpack(link.strip_prefix("#s=").unwrap()).unwrap()).unwrap();
    assert!(content.get("robot").is_none() && content.get("objects").is_none());
    let sentence = state.shared_sentence(link.len());
    assert!(sentence.contains("six_arm is yours and not in the link: save the session"), "{sentence}");
}
