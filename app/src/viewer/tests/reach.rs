//! Reachability maps on the program's own robots: shown, cut, clicked, built and refused.

use egui::Role;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::{MapMethod, MapRequest, Stage};
use endcomfort_core::reach::Voxel;
use image::RgbaImage;

use super::bench::{Bench, picture, window};
use super::page;
use crate::assets;
use crate::viewer::{
    Command, Effect, Keep, Layer, MapSource, Posture, ReachArms, ReachCommand, ReachPage, ReachQuantity, ReachView,
    Slice, Slot, ViewCommand,
};

impl Bench {
    fn reach(&mut self, command: ReachCommand) {
        self.apply(Command::Reach(command));
    }

    fn view(&self) -> ReachView {
        self.page.state.reaching.view
    }

    /// The freest voxel of an arm.
    fn freest(&self, arm: usize) -> u32 {
        let map = self.page.state.reaching.map(arm).expect("the map is here");
        map.voxels().max_by(|a, b| map.fraction(*a).total_cmp(&map.fraction(*b))).expect("it has voxels").0
    }
}

fn open(demo: &str) -> Bench {
    let mut bench = Bench::until(demo, Stage::Scene);
    bench.reach(ReachCommand::Open);
    bench
}

#[test]
fn stored_maps_are_fetched_when_they_are_first_shown_and_those_of_another_robot_follow_it() {
    let mut bench = Bench::until("mustard", Stage::Scene);
    assert!(matches!(bench.page.state.reaching.slot(0), Slot::Empty), "nobody asked");
    let effects = bench.page.state.apply(Command::ToggleLayer(Layer::Reach));
    let asked: Vec<&str> = effects
        .iter()
        .filter_map(|effect| match effect {
            Effect::FetchMap(path) => Some(path.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(asked, ["maps/alita_left.reach", "maps/alita_right.reach"]);
    let again = bench.page.state.apply(Command::View(ViewCommand::FrameAll));
    assert!(!again.iter().any(|effect| matches!(effect, Effect::FetchMap(_))), "one question is enough");
    bench.carry_out(effects);
    let maps = &bench.page.state.reaching;
    assert_eq!(maps.map(1).map(|map| map.about().arm.arm.as_str()), Some("right"));
    assert!((0..2).all(|arm| maps.shown(arm).is_some_and(|shown| shown.source == MapSource::Stored)));
    bench.apply(Command::SetRobot("crichton".to_owned()));
    let robots = [0, 1].map(|arm| bench.page.state.reaching.map(arm).map(|map| map.about().arm.robot.clone()));
    assert_eq!(robots, [Some("crichton".to_owned()), Some("crichton".to_owned())]);
}

#[test]
fn a_map_that_cannot_be_fetched_or_read_is_told_and_one_can_be_built_instead() {
    let mut bench = Bench::until("mustard", Stage::Scene);
    let effects = bench.page.state.apply(Command::Reach(ReachCommand::Open));
    let left = assets::read("robots/maps/alita_left.reach").expect("it is stored").to_vec();
    let mut broken = left.clone();
    broken.truncate(left.len() / 2);
    for effect in effects {
        let Effect::FetchMap(path) = effect else { continue };
        let file = if path.contains("left") { Ok(broken.clone()) } else { Err("the server answers 404".to_owned()) };
        bench.reach(ReachCommand::Arrived { path, file });
    }
    let state = &bench.page.state;
    assert!((0..2).all(|arm| matches!(state.reaching.slot(arm), Slot::Missing(_))));
    assert_eq!(state.messages.iter().filter(|message| message.is_error).count(), 2);
    assert!(state.messages.iter().any(|message| message.text.contains("404")));
    let wanted = MapRequest { voxel_m: 0.1, ..state.reaching.wanted.clone() };
    bench.reach(ReachCommand::Settings(wanted));
    bench.reach(ReachCommand::Build);
    let state = &bench.page.state;
    let is_built = |arm: usize| {
        let shown = state.reaching.shown(arm);
        shown.is_some_and(|shown| matches!(shown.source, MapSource::Built { .. }) && shown.map.voxel_m() == 0.1)
    };
    assert!(is_built(0) && is_built(1) && !state.running);
    let asked = bench.asked.last().and_then(|request| request.map.clone()).expect("maps were asked for");
    assert_eq!((asked.arms, asked.method), (vec!["left".to_owned(), "right".to_owned()], MapMethod::Inverse));
}

#[test]
fn maps_with_the_torso_are_built_and_take_the_place_of_the_stored_ones() {
    let mut bench = open("jar");
    let wanted = MapRequest {
        torso: true,
        voxel_m: 0.1,
        method: MapMethod::Forward { samples: 200_000 },
        ..bench.page.state.reaching.wanted.clone()
    };
    bench.reach(ReachCommand::Settings(wanted));
    assert!((0..2).all(|arm| matches!(bench.page.state.reaching.slot(arm), Slot::Missing(_))));
    assert!(bench.page.state.messages.is_empty(), "nobody expects a file");
    bench.reach(ReachCommand::Build);
    let state = &bench.page.state;
    let map = state.reaching.map(0).expect("it is built");
    assert_eq!(map.about().arm.joints, 8);
    let voxel = bench.freest(0);
    bench.reach(ReachCommand::Select { arm: 0, voxel });
    assert!(matches!(bench.page.state.posture(), Posture::Reach(_)));
    let bytes = bench.page.state.reaching.shown(1).expect("it is built").bytes.to_vec();
    let stored = MapRequest { torso: false, ..bench.page.state.reaching.wanted.clone() };
    bench.reach(ReachCommand::Settings(stored));
    assert_eq!(bench.page.state.reaching.map(1).map(|map| map.about().arm.joints), Some(7));
    bench.apply(Command::OpenFile { name: "mine.reach".to_owned(), bytes });
    assert_eq!(bench.page.state.reaching.map(1).map(|map| map.about().arm.joints), Some(8));
    assert_eq!(bench.page.state.reaching.shown(1).map(|shown| shown.source), Some(MapSource::File));
}

#[test]
fn a_build_can_be_stopped_and_an_edit_overtakes_it() {
    let mut bench = open("mustard");
    let before = bench.page.state.reaching.version();
    let effects = bench.page.state.apply(Command::Reach(ReachCommand::Build));
    assert!(matches!(effects.as_slice(), [Effect::Run(_)]) && bench.page.state.map_under_way().is_some());
    let effects = bench.page.state.apply(Command::Cancel);
    assert!(matches!(effects.as_slice(), [Effect::Cancel]) && bench.page.state.map_under_way().is_none());
    let _run = bench.page.state.apply(Command::Reach(ReachCommand::Build));
    let _run = bench.page.state.apply(Command::SetSeed(5));
    assert!(bench.page.state.map_under_way().is_none(), "the pipeline runs instead");
    assert_eq!(bench.page.state.reaching.version(), before, "the stored maps stay");
}

#[test]
fn the_robot_stands_in_the_configuration_of_the_chosen_voxel_and_steps_through_the_others() {
    for (demo, arm) in [("mustard", 0), ("jar", 1)] {
        let mut bench = open(demo);
        let voxel = bench.freest(arm);
        bench.reach(ReachCommand::Select { arm, voxel });
        let chosen = bench.page.state.shown_voxel().expect("it is chosen");
        assert_eq!(bench.page.state.posture(), Posture::Reach(chosen));
        // The independent way: the robot's own kinematics put the hand where the map says.
        let state = &bench.page.state;
        let robot = assets::library().robot_of(state.scene()).unwrap();
        let map = state.reaching.map(arm).unwrap();
        let reached = state.reaching.orientations(arm, chosen.voxel);
        let values: Vec<f64> = reached.iter().map(|&o| map.manipulability(chosen.voxel, o).unwrap()).collect();
        assert!(values.is_sorted_by(|a, b| a >= b) && reached[0] == chosen.orientation);
        let body = robot.arm(&map.about().arm.arm).unwrap();
        for &orientation in &reached {
            let mut q = robot.posture(&state.scene().posture).unwrap().to_vec();
            for (&dof, position) in body.dofs.iter().zip(map.configuration(chosen.voxel, orientation).unwrap()) {
                q[dof] = position;
            }
            let X_WH = robot.link_poses(&q)[body.hand.tcp_link];
            let wanted = state.map_base(arm).unwrap() * map.pose(chosen.voxel, orientation).unwrap();
            assert!((X_WH.translation.vector - wanted.translation.vector).norm() < 1e-6, "{demo}: {orientation}");
            assert!(X_WH.rotation.angle_to(&wanted.rotation) < 1e-6, "{demo}: {orientation}");
        }
        let count = reached.len();
        for step in 1..=count {
            bench.reach(ReachCommand::NextOrientation { forth: true });
            let shown = bench.page.state.shown_voxel().unwrap().orientation;
            assert_eq!(shown, reached[step % count]);
        }
        bench.reach(ReachCommand::NextOrientation { forth: false });
        assert_eq!(bench.page.state.shown_voxel().unwrap().orientation, reached[count - 1]);
        bench.apply(Command::Escape);
        assert!(bench.page.state.shown_voxel().is_none());
    }
}

#[test]
fn the_voxel_across_is_the_other_arms_at_the_same_place() {
    let mut bench = open("jar");
    bench.reach(ReachCommand::View(ReachView { arms: ReachArms::Overlap, ..bench.view() }));
    let voxels: Vec<_> = bench.page.state.reaching.map(0).unwrap().voxels().collect();
    let mut compared = 0;
    for voxel in voxels.into_iter().step_by(101) {
        bench.reach(ReachCommand::Select { arm: 0, voxel: voxel.0 });
        let here = bench.page.state.voxel_place(0, voxel).unwrap();
        if let Some((arm, across)) = bench.page.state.voxel_across() {
            let there = bench.page.state.voxel_place(arm, across).unwrap();
            assert!(arm == 1 && (there - here).norm() < 0.05 * 3_f64.sqrt() / 2.0 + 1e-9);
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn whoever_turns_to_a_step_leaves_the_page_and_r_opens_it() {
    let mut harness = page(Bench::until("mustard", Stage::Segment).page.state, [1440.0, 900.0], egui::Theme::Dark);
    harness.run_steps(2);
    harness.key_press(egui::Key::R);
    harness.run_steps(2);
    assert!(harness.query_by_label("View page").is_some());
    harness.get_by_label_contains("Segment done").click();
    harness.run_steps(2);
    assert!(harness.query_by_label("View page").is_none() && !harness.state().state.reaching.is_open);
    harness.get_by_label("Reachability settings").click();
    harness.run_steps(2);
    assert!(harness.query_by_label("View page").is_some());
    harness.get_by_label("Close Reachability").click();
    harness.run_steps(2);
    assert!(harness.query_by_label("View page").is_none());
}

#[test]
fn every_control_of_the_view_does_what_it_says() {
    let mut harness = page(open("mustard").page.state, [1440.0, 1100.0], egui::Theme::Light);
    harness.run_steps(2);
    for (control, role, holds) in [
        ("Left", Role::RadioButton, (|view| view.arms == ReachArms::Left) as fn(&ReachView) -> bool),
        ("Overlap", Role::RadioButton, |view| view.arms == ReachArms::Overlap),
        ("Manipulability", Role::RadioButton, |view| view.quantity == ReachQuantity::Manipulability),
        ("Logarithmic", Role::RadioButton, |view| view.is_log),
        ("Opacity by value", Role::Switch, |view| view.fades),
    ] {
        harness.get_by_role_and_label(role, control).click();
        harness.run_steps(2);
        assert!(holds(&harness.state().state.reaching.view), "{control}");
    }
    harness.get_by_label_contains("At least: ").focus();
    harness.run_steps(1);
    for _ in 0..3 {
        harness.key_press(egui::Key::ArrowRight);
        harness.run_steps(1);
    }
    let least = harness.state().state.reaching.view.least;
    let most = harness.state().state.reaching.map(0).unwrap().most_manipulable();
    assert!(least > 0.02 * 0.3 * most && least < most, "three hundredths of the range: {least} of {most}");
    harness.get_by_label("Cut across z, up: whole").click();
    harness.run_steps(2);
    harness.get_by_label("Keep one layer").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.reaching.view.slices[2].keep, Keep::Slice);
    harness.get_by_label_contains("Plane across z, up").click();
    harness.run_steps(2);
    let at_m = harness.state().state.reaching.view.slices[2].at_m;
    assert!((1.3..2.2).contains(&at_m), "right of the track's middle: {at_m}");
    harness.get_by_label("As it was first").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.reaching.view, ReachView::default());
}

#[test]
fn the_page_of_the_map_tells_its_numbers_and_builds_another() {
    let mut harness = window(open("mustard"), [1440.0, 1300.0], true);
    harness.state_mut().bench.reach(ReachCommand::View(ReachView {
        arms: ReachArms::Left,
        least: 0.6,
        ..ReachView::default()
    }));
    harness.run_steps(2);
    harness.get_by_label("Map page").click();
    harness.run_steps(2);
    for words in ["File: alita_left.reach, stored", "Voxels: ", "Poses: ", "Method: inverse", "Size: "] {
        assert_eq!(harness.query_all_by_label_contains(words).count(), 1, "{words}");
    }
    harness.get_by_role_and_label(Role::RadioButton, "Forward").click();
    harness.run_steps(2);
    let wanted = MapMethod::Forward { samples: 5_000_000 };
    assert_eq!(harness.state().bench.page.state.reaching.wanted.method, wanted);
    let quick = MapRequest {
        method: MapMethod::Forward { samples: 50_000 },
        ..harness.state().bench.page.state.reaching.wanted.clone()
    };
    harness.state_mut().bench.reach(ReachCommand::Settings(quick));
    harness.run_steps(2);
    harness.get_by_label("Build the map").click();
    harness.run_steps(3);
    assert_eq!(harness.query_all_by_label_contains("Method: forward, 50000 samples").count(), 1);
    assert!(harness.query_by_label("Save alita_left.reach").is_some());
}

/// How many pixels of a part of the picture have a strong colour, as data has.
fn coloured(picture: &RgbaImage, [x0, y0, x1, y1]: [u32; 4]) -> usize {
    let is_strong = |x: u32, y: u32| {
        let channels = picture.get_pixel(x, y).0;
        let (low, high) = channels[..3].iter().fold((255, 0), |(low, high), &c| (c.min(low), c.max(high)));
        // A hue without much grey in it.
        high - low > high / 2
    };
    (x0..x1).flat_map(|x| (y0..y1).map(move |y| (x, y))).filter(|&(x, y)| is_strong(x, y)).count()
}

#[test]
fn voxels_are_in_the_picture_and_fewer_with_a_threshold() {
    let free = [280, 160, 1000, 640];
    let whole = ReachView { slices: [Slice { keep: Keep::All, at_m: 0.0 }; 3], ..ReachView::default() };
    let mut harness = window(open("mustard"), [1440.0, 900.0], true);
    let cut = coloured(&picture(&mut harness, "reach-cut"), free);
    harness.state_mut().bench.reach(ReachCommand::View(ReachView { least: 0.6, ..whole }));
    let few = coloured(&picture(&mut harness, "reach-threshold"), free);
    harness.state_mut().bench.apply(Command::ToggleLayer(Layer::Reach));
    let none = coloured(&picture(&mut harness, "reach-hidden"), free);
    assert!(cut > 2 * few && few > none + 1000, "{cut}, {few}, {none} coloured pixels");
}

#[test]
fn the_chosen_voxel_is_shown_with_its_hands_and_numbers() {
    let mut harness = window(open("jar"), [1440.0, 900.0], false);
    let slices = [Slice { keep: Keep::All, at_m: 0.0 }; 3];
    let quantity = ReachQuantity::Manipulability;
    let view = ReachView { fades: true, quantity, slices, ..ReachView::default() };
    harness.state_mut().bench.reach(ReachCommand::View(view));
    let before = picture(&mut harness, "reach-fades");
    let voxel = harness.state().bench.freest(0);
    harness.state_mut().bench.reach(ReachCommand::Select { arm: 0, voxel });
    assert!(picture(&mut harness, "reach-voxel") != before);
    for words in ["Orientations reached: ", "Mean manipulability: ", "orientations that reach the voxel"] {
        assert_eq!(harness.query_all_by_label_contains(words).count(), 1, "{words}");
    }
    harness.get_by_label("Next orientation").click();
    harness.run_steps(2);
    let reached = harness.state().bench.page.state.reaching.map(0).expect("it is here").reached(Voxel(voxel)).count();
    assert!(harness.query_by_label(&format!("2 of {reached}, best first")).is_some());
}

#[test]
fn on_a_phone_the_page_is_a_sheet() {
    let mut harness = window(open("jar"), [390.0, 844.0], true);
    let _picture = picture(&mut harness, "reach-sheet");
    assert!(harness.query_by_label("View page").is_some());
    harness.state_mut().bench.reach(ReachCommand::Page(ReachPage::Map));
    harness.run_steps(3);
    assert!(harness.query_by_label("Build both maps").is_some());
}

#[test]
fn a_click_on_a_voxel_in_the_view_chooses_it() {
    let mut harness = window(open("mustard"), [1440.0, 900.0], true);
    harness.run_steps(40);
    let at = egui::pos2(640.0, 400.0);
    harness.hover_at(at);
    harness.run_steps(1);
    harness.drag_at(at);
    harness.run_steps(1);
    harness.drop_at(at);
    harness.run_steps(2);
    let state = &harness.state().bench.page.state;
    let chosen = state.shown_voxel().expect("a voxel stands under the pointer");
    assert!(state.reaching.map(chosen.arm).unwrap().fraction(chosen.voxel) > 0.0);
    assert_eq!(state.reaching.page, ReachPage::Voxel);
}
