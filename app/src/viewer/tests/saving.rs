//! The window that saves what the view shows, and the buttons beside tables and plots.

use egui::{Key, Role, Theme};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use endcomfort_core::job::Stage;

use super::bench::Bench;
use super::{Page, invented, page};
use crate::export::{AnimationFormat, TableKind};
use crate::viewer::state::Step;
use crate::viewer::{
    Command, Effect, LabCommand, LabPage, Overlay, PictureCommand, PictureEffect, PicturePage, PlanCommand, PlanPage,
    PlayPage, ReachCommand, ReachPage, Shot, SizePreset, ViewerState,
};

const SIZE: [f32; 2] = [1280.0, 720.0];

fn opened(state: ViewerState) -> Harness<'static, Page> {
    let mut harness = page(state, SIZE, Theme::Dark);
    harness.run_steps(1);
    harness.key_press(Key::I);
    harness.run_steps(3);
    harness
}

fn click(harness: &mut Harness<'static, Page>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

fn pictures(harness: &Harness<'static, Page>) -> Vec<PictureEffect> {
    let effects = harness.state().effects.iter();
    effects.filter_map(|effect| if let Effect::Picture(effect) = effect { Some(*effect) } else { None }).collect()
}

/// The files that were handed to the person: name and text.
fn files(harness: &Harness<'static, Page>) -> Vec<(String, String)> {
    let saved = |effect: &Effect| match effect {
        Effect::Save { name, bytes } => Some((name.clone(), String::from_utf8_lossy(bytes).into_owned())),
        _ => None,
    };
    harness.state().effects.iter().filter_map(saved).collect()
}

#[test]
fn the_key_opens_the_window_and_a_picture_of_the_view_is_saved_at_its_size() {
    let mut harness = opened(invented::planned());
    assert_eq!(harness.state().state.overlay, Overlay::Picture);
    click(&mut harness, "Save the picture");
    let shot = Shot { size_px: [1280, 720], scale: 1.0, transparent: false, words: true, dark: true };
    assert_eq!(pictures(&harness), [PictureEffect::Take(shot)]);
    assert_eq!(harness.state().state.overlay, Overlay::None);
}

#[test]
fn a_preset_without_background_or_words_in_light_colours_reaches_the_shot() {
    let mut harness = opened(invented::planned());
    click(&mut harness, "Size: This view");
    click(&mut harness, "Square, for a paper");
    for name in ["Transparent background", "Labels and legends", "Light colours, for paper"] {
        harness.get_by_role_and_label(Role::Switch, name).click();
        harness.run_steps(3);
    }
    click(&mut harness, "Save the picture");
    let shot = Shot { size_px: [2000, 2000], scale: 2.5, transparent: true, words: false, dark: false };
    assert_eq!(pictures(&harness), [PictureEffect::Take(shot)]);
}

#[test]
fn a_size_that_cannot_be_drawn_is_told_and_not_saved() {
    let mut state = invented::planned();
    let settings = state.picturing.settings.with_preset(SizePreset::Own);
    let settings = crate::viewer::PictureSettings { size_px: [8192, 8192], ..settings };
    let _none = state.apply(Command::Picture(PictureCommand::Settings(settings)));
    let mut harness = opened(state);
    let told = "Picture of 8192 × 8192 pixels: found 67.1 million pixels, wanted at most 33.2 million.";
    assert_eq!(harness.query_all_by_label(told).count(), 1);
    click(&mut harness, "Save the picture");
    assert!(pictures(&harness).is_empty());
}

#[test]
fn an_animation_is_asked_for_frame_by_frame_told_how_far_it_is_and_given_up() {
    let mut state = invented::planned();
    let duration_s = state.duration_s();
    let _none = state.apply(Command::Picture(PictureCommand::Page(PicturePage::Animation)));
    let mut harness = opened(state);
    click(&mut harness, "Animated PNG");
    let frames = format!("{} frames over {duration_s:.2} s", (25.0 * duration_s + 1e-6).floor() as usize + 1);
    assert_eq!(harness.query_all_by_label(&frames).count(), 1, "{frames}");
    click(&mut harness, "Save the animation");
    let asked = pictures(&harness);
    let [PictureEffect::Film(shot, clip)] = asked.as_slice() else { panic!("{asked:?}") };
    assert_eq!((shot.size_px, clip.format, clip.fps), ([1280, 720], AnimationFormat::Apng, 25));
    assert_eq!((clip.from_s, clip.to_s), (0.0, duration_s));

    let tell = |harness: &mut Harness<'static, Page>, progress| {
        let _none = harness.state_mut().state.apply(Command::Picture(PictureCommand::Progress(progress)));
        harness.run_steps(2);
    };
    tell(&mut harness, Some((12, 126)));
    assert_eq!(harness.query_all_by_label("Animation: 12 of 126 pictures").count(), 1);
    assert_eq!(harness.query_all_by_label("Save the animation").count(), 0);
    click(&mut harness, "Cancel the animation");
    assert_eq!(pictures(&harness).last(), Some(&PictureEffect::Stop));
    assert_eq!(harness.state().state.picturing.progress, None);
}

#[test]
fn without_a_plan_nothing_can_be_animated_but_the_scene_is_saved() {
    let mut state = invented::fresh();
    let _none = state.apply(Command::Picture(PictureCommand::Page(PicturePage::Animation)));
    let mut harness = opened(state);
    assert_eq!(harness.query_all_by_label("There is no plan that could move.").count(), 1);
    click(&mut harness, "Save the animation");
    assert!(pictures(&harness).is_empty());
    click(&mut harness, "3D scene page");
    click(&mut harness, "Save the scene");
    assert_eq!(pictures(&harness), [PictureEffect::SaveScene]);
}

/// The inspector at a step with commands given before.
fn at(stage: Stage, commands: impl IntoIterator<Item = Command>) -> Harness<'static, Page> {
    let mut state = invented::planned();
    let _none = state.apply(Command::SelectStep(Step::Stage(stage)));
    for command in commands {
        let _none = state.apply(command);
    }
    let mut harness = page(state, [1280.0, 1400.0], Theme::Light);
    harness.run_steps(2);
    harness
}

fn save(harness: &mut Harness<'static, Page>, kind: TableKind, row: &str) -> (String, String) {
    click(harness, &format!("Save: {}", kind.title()));
    click(harness, row);
    files(harness).pop().expect("a file")
}

#[test]
fn every_table_of_the_inspector_has_a_button_that_saves_its_rows() {
    let mut segment = at(Stage::Segment, []);
    let (name, text) = save(&mut segment, TableKind::Clusters, "Save as CSV");
    assert_eq!(name, "endcomfort-glass-clusters.csv");
    let clusters = segment.state().state.outputs.segment.as_ref().map_or(0, |segment| segment.clusters.len());
    assert!(text.starts_with("cluster,points,is_target,center_x_m") && text.lines().count() == clusters + 1, "{text}");

    let mut plan = at(Stage::Plan, []);
    let (name, text) = save(&mut plan, TableKind::Phases, "Save as JSON");
    let rows: Vec<serde_json::Value> = serde_json::from_str(&text).expect("an array");
    let phases = plan.state().state.outputs.plan.as_ref().map_or(0, |plan| plan.phases.len());
    assert_eq!((name.as_str(), rows.len()), ("endcomfort-glass-phases.json", phases));
    assert_eq!(rows[0]["kind"], "reach");

    let mut tried = at(Stage::Plan, [Command::Planning(PlanCommand::Page(PlanPage::Tried))]);
    let (_, text) = save(&mut tried, TableKind::Tried, "Save as CSV");
    assert_eq!(text.lines().count(), tried.state().state.tries().len() + 1, "{text}");

    let mut fit = at(Stage::Fit, []);
    let (_, text) = save(&mut fit, TableKind::Fits, "Save as CSV");
    assert!(text.starts_with("cluster,is_target,a_m,b_m,c_m,e1,e2"), "{text}");
}

#[test]
fn the_voxels_of_both_arms_are_one_table() {
    let mut bench = Bench::until("jar", Stage::Scene);
    bench.apply(Command::Reach(ReachCommand::Open));
    bench.apply(Command::Reach(ReachCommand::Page(ReachPage::Map)));
    let mut harness = page(bench.page.state, [1280.0, 1400.0], Theme::Light);
    harness.run_steps(2);
    let (name, text) = save(&mut harness, TableKind::Voxels, "Save as CSV");
    assert_eq!(name, "endcomfort-jar-voxels.csv");
    let voxels = |arm: usize| harness.state().state.reaching.map(arm).map_or(0, |map| map.voxels().count());
    assert_eq!(text.lines().count(), 1 + voxels(0) + voxels(1));
    assert!(text.contains("\nleft,left_arm_base,") && text.contains("\nright,right_arm_base,"), "{}", &text[..200]);
}

#[test]
fn plots_are_saved_as_svg_beside_them() {
    let mut fit = at(Stage::Fit, [Command::Lab(LabCommand::Page(LabPage::Search))]);
    let (name, text) = save(&mut fit, TableKind::Runs, "Save the plot as SVG");
    assert_eq!(name, "endcomfort-glass-cost.svg");
    let document = roxmltree::Document::parse(&text).expect("XML");
    let lines = document.descendants().filter(|node| node.has_tag_name("polyline")).count();
    let runs = fit.state().state.examined_fit().map_or(0, |fit| fit.runs.len());
    assert!(runs > 1 && lines == runs, "{lines} curves of {runs} runs");

    let page = Command::Planning(PlanCommand::PlayPage(PlayPage::Joints));
    let mut joints = at(Stage::Plan, [page, Command::SelectStep(Step::Play)]);
    let (name, text) = save(&mut joints, TableKind::Joints, "Save the plot as SVG");
    assert_eq!(name, "endcomfort-glass-positions.svg");
    assert!(text.contains("time, s") && roxmltree::Document::parse(&text).is_ok());
}

#[test]
fn a_table_that_is_not_there_is_refused_in_words() {
    let mut state = invented::fresh();
    let saved = crate::viewer::Saved::Table(TableKind::Routes, crate::export::TableFormat::Csv);
    let effects = state.apply(Command::Save(saved));
    assert!(matches!(effects.as_slice(), [Effect::Announce(said)] if said.contains("\"routes\" has no row")));
    assert!(state.messages.last().is_some_and(|message| message.is_error));
}
