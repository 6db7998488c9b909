//! The whole interface as pictures. `ENDCOMFORT_LOOK=<folder>` keeps them for looking at.

use endcomfort_core::grasp::{ApproachCone, GraspFilter, GraspSettings, RankBy, RankSettings, Region};
use endcomfort_core::job::{Output, Refusal, Stage, Update};
use endcomfort_core::scene::{Action, Step as TaskStep};
use endcomfort_core::task::Phase;
use nalgebra::{Isometry3, Point3, Vector3};

use super::{Page, invented, page};
use crate::viewer::state::{IkChoice, Side, Situation, Step};
use crate::viewer::{
    ColumnSet, Command, GraspCommand, GraspPage, LabCommand, LabPage, Overlay, PictureCommand, PicturePage,
    PictureSettings, PlanCommand, PlanPage, PlayPage, SizePreset, Tokens, ViewerState,
};

const LARGE: [f32; 2] = [1440.0, 900.0];
const SMALL: [f32; 2] = [1280.0, 720.0];
const NARROW: [f32; 2] = [700.0, 900.0];
const PHONE: [f32; 2] = [390.0, 844.0];

fn at(step: Step) -> ViewerState {
    let mut state = invented::planned();
    let _none = state.apply(Command::SelectStep(step));
    let _none = state.apply(Command::Seek(4.62));
    state
}

fn with(mut state: ViewerState, commands: impl IntoIterator<Item = Command>) -> ViewerState {
    for command in commands {
        let _effects = state.apply(command);
    }
    state
}

/// The fit lab, open on a page.
fn lab(page: LabPage) -> ViewerState {
    with(invented::planned(), [Command::SelectStep(Step::Stage(Stage::Fit)), Command::Lab(LabCommand::Page(page))])
}

/// A page of the inspector at a step with grasps.
fn grasps(stage: Stage, page: GraspPage) -> ViewerState {
    with(invented::planned(), [Command::SelectStep(Step::Stage(stage)), Command::Grasping(GraspCommand::Page(page))])
}

/// Everything that a filter can ask for, its results already there.
fn filtered() -> ViewerState {
    let mut state = grasps(Stage::Grasps, GraspPage::Filter);
    let region = Region { center_W: Point3::new(0.6, -0.2, 0.84), half_m: Vector3::new(0.04, 0.05, 0.03) };
    let approach = Some(ApproachCone { axis_W: -Vector3::z(), half_angle_rad: 0.5 });
    let filter = GraspFilter { approach, region: Some(region), part: None, min_clearance_m: 0.01 };
    let settings = GraspSettings { filter, ..GraspSettings::default() };
    let _run = state.apply(Command::Grasping(GraspCommand::Settings(settings)));
    for (elapsed_ms, output) in invented::outputs().into_iter().skip(3) {
        invented::done(&mut state, elapsed_ms, output);
    }
    state
}

/// Ranked by the score.
fn scored() -> ViewerState {
    let mut state = grasps(Stage::Rank, GraspPage::Order);
    let settings = RankSettings { by: RankBy::Score, ..RankSettings::default() };
    let _run = state.apply(Command::Grasping(GraspCommand::Rank(settings)));
    for (elapsed_ms, output) in invented::outputs().into_iter().skip(4) {
        invented::done(&mut state, elapsed_ms, output);
    }
    state
}

/// The five objectives, side by side.
fn compared() -> ViewerState {
    let mut state = with(lab(LabPage::Search), [Command::Lab(LabCommand::Compare)]);
    for update in invented::objectives(state.revision) {
        let _none = state.receive(update);
    }
    state
}

fn refused() -> ViewerState {
    let mut state = invented::planned();
    let _run = state.apply(Command::SetSeed(8));
    for (elapsed_ms, output) in invented::outputs().into_iter().take(5) {
        invented::done(&mut state, elapsed_ms, output);
    }
    let refusal = Refusal::new(
        "None of the 37 grasps can be carried to the goal: the glass meets the shelf board on every path. Move the \
         board or choose a lower goal.",
    )
    .with_details(vec!["375 of 412 candidates were rejected before: 96 of them hit the table.".to_owned()]);
    let refusal = Refusal { tries: invented::tries(&[0.3; 7]), ..refusal };
    let _announced = state.receive(Update::Refused { revision: state.revision, stage: Stage::Plan, refusal });
    state
}

fn running() -> ViewerState {
    let mut state = invented::planned();
    let _run = state.apply(Command::SetSeed(9));
    for (elapsed_ms, output) in invented::outputs().into_iter().take(2) {
        invented::done(&mut state, elapsed_ms, output);
    }
    let progress = Update::Progress {
        revision: state.revision,
        stage: Stage::Fit,
        fraction: 0.4,
        note: "cluster 2 of 3".to_owned(),
    };
    let _none = state.receive(progress);
    state
}

/// A page of the inspector at the step Plan.
fn plan(page: PlanPage) -> ViewerState {
    let show = Command::Planning(PlanCommand::ShowTry((page == PlanPage::Tried).then_some(1)));
    with(at(Step::Stage(Stage::Plan)), [show, Command::Planning(PlanCommand::Page(page))])
}

/// The object is put down in between and grasped anew.
fn two_holds() -> ViewerState {
    let mut state = at(Step::Stage(Stage::Plan));
    for (elapsed_ms, mut output) in invented::outputs() {
        if let Output::Plan(plan) = &mut output {
            let (again, start_s) = (plan.phases.clone(), plan.duration_s());
            let late = |mut phase: Phase| {
                phase.start_s += start_s;
                phase.leg = 1;
                phase
            };
            plan.phases.extend(again.into_iter().map(late));
            let mut leg = plan.legs[0].clone();
            leg.grasp.id = 262;
            plan.legs.push(leg);
        }
        invented::done(&mut state, elapsed_ms, output);
    }
    with(state, [Command::Seek(14.0)])
}

/// A task of three steps, the second one open.
fn task() -> ViewerState {
    let put = |x: f64, y: f64| TaskStep::put(Isometry3::translation(x, y, 0.83));
    let mut pour = TaskStep {
        action: Action::Pour { hold_s: 2.0 },
        keep_upright_rad: Some(0.3),
        ..TaskStep::put(Isometry3::new(Vector3::new(0.6, 0.1, 1.02), Vector3::new(1.2, 0.0, 0.0)))
    };
    pour.freedom.yaw_rad = 0.5;
    let steps = vec![put(0.62, 0.24), pour, put(0.55, -0.1)];
    let mut state = with(plan(PlanPage::Task), [Command::Planning(PlanCommand::Steps(steps))]);
    for (elapsed_ms, output) in invented::outputs().into_iter().skip(3) {
        invented::done(&mut state, elapsed_ms, output);
    }
    with(state, [Command::Planning(PlanCommand::SelectGoal(1)), Command::Seek(4.62)])
}

/// A plan beside another one that was kept.
fn plans_compared() -> ViewerState {
    let mut state = with(plan(PlanPage::Plan), [Command::Planning(PlanCommand::Keep), Command::SetSeed(8)]);
    for (elapsed_ms, mut output) in invented::outputs() {
        if let Output::Plan(plan) = &mut output {
            plan.phases.pop();
            plan.tries.pop();
        }
        invented::done(&mut state, elapsed_ms, output);
    }
    with(state, [Command::Seek(4.62)])
}

/// The window that saves what the view shows, in the light theme's colours at an own size.
fn saving(page: PicturePage, progress: Option<(usize, usize)>) -> ViewerState {
    let state = at(Step::Play);
    let settings = state.picturing.settings.with_preset(SizePreset::Own);
    let commands = [
        PictureCommand::Page(page),
        PictureCommand::Settings(PictureSettings { transparent: true, ..settings }),
        PictureCommand::Progress(progress),
    ];
    with(with(state, commands.map(Command::Picture)), [Command::Show(Overlay::Picture)])
}

/// Joints over time: of all, or of one.
fn joints(joint: Option<usize>) -> ViewerState {
    let commands = [PlanCommand::PlayPage(PlayPage::Joints), PlanCommand::PlotJoint(joint)];
    with(at(Step::Play), commands.map(Command::Planning))
}

/// Every picture is drawn, has the theme's panel colour where the panels are, and no text falls out of the font
/// (the harness fails on a missing glyph).
#[test]
fn every_screen_is_drawn_in_both_themes() {
    let rank = Step::Stage(Stage::Rank);
    let ik = Command::ShowIk(Some(IkChoice { at: Situation::Goal, index: 13 }));
    let mut screens: Vec<(&str, [f32; 2], ViewerState)> = vec![
        ("rank", LARGE, at(rank)),
        ("rank", SMALL, with(at(rank), [ik])),
        ("narrow", NARROW, at(rank)),
        ("narrow-left", NARROW, with(at(rank), [Command::ToggleDrawer(Side::Left)])),
        ("narrow-right", NARROW, with(at(rank), [Command::ToggleDrawer(Side::Right)])),
        ("refused", SMALL, refused()),
        ("running", SMALL, running()),
        ("gallery", LARGE, with(at(rank), [Command::Show(Overlay::Gallery)])),
        ("gallery", NARROW, with(at(rank), [Command::Show(Overlay::Gallery)])),
        ("help", SMALL, with(at(rank), [Command::Show(Overlay::Help)])),
        ("help", PHONE, with(at(rank), [Command::Show(Overlay::Help)])),
        ("palette", SMALL, with(at(rank), [Command::Show(Overlay::Palette)])),
        ("palette", PHONE, with(at(rank), [Command::Show(Overlay::Palette)])),
        ("save-picture", SMALL, saving(PicturePage::Picture, None)),
        ("save-animation", SMALL, saving(PicturePage::Animation, None)),
        ("save-animation", PHONE, saving(PicturePage::Animation, None)),
        ("save-scene", SMALL, saving(PicturePage::Scene, None)),
        ("save-under-way", SMALL, saving(PicturePage::Animation, Some((47, 135)))),
        ("play", SMALL, at(Step::Play)),
        ("plan-tried", SMALL, plan(PlanPage::Tried)),
        ("plan-routes", SMALL, plan(PlanPage::Routes)),
        ("plan-settings", SMALL, plan(PlanPage::Settings)),
        ("plan-settings", LARGE, plan(PlanPage::Settings)),
        ("plan-compared", SMALL, plans_compared()),
        ("plan-compared", LARGE, plans_compared()),
        ("plan-compared", PHONE, with(plans_compared(), [Command::ToggleDrawer(Side::Right)])),
        ("plan-legs", SMALL, two_holds()),
        ("plan-task", SMALL, task()),
        ("plan-task", LARGE, task()),
        ("plan-task", PHONE, with(task(), [Command::ToggleDrawer(Side::Right)])),
        ("play-joints", SMALL, joints(None)),
        ("play-joints", LARGE, joints(None)),
        ("play-joint", SMALL, joints(Some(3))),
        ("fresh", SMALL, invented::fresh()),
    ];
    for stage in [Stage::Scene, Stage::Segment, Stage::Fit, Stage::Grasps, Stage::Plan] {
        screens.push((stage.title(), SMALL, at(Step::Stage(stage))));
    }
    for page in LabPage::ALL {
        let name = format!("fit-{}", page.title());
        screens.push((Box::leak(name.into_boxed_str()), SMALL, lab(page)));
    }
    screens.push(("fit-search", LARGE, compared()));
    for (stage, size) in [(Stage::Grasps, SMALL), (Stage::Rank, SMALL)] {
        for &page in GraspPage::of(stage) {
            let name = format!("{}-{}", stage.title(), page.title());
            screens.push((Box::leak(name.into_boxed_str()), size, grasps(stage, page)));
        }
    }
    screens.push(("rank-grasp", LARGE, grasps(Stage::Rank, GraspPage::Grasp)));
    screens.push(("grasps-filter", LARGE, filtered()));
    screens.push(("rank-order", LARGE, scored()));
    let listed = GraspCommand::Columns(ColumnSet::Hand);
    let hands = with(grasps(Stage::Rank, GraspPage::Table), [Command::Grasping(listed), Command::SelectGrasp(41)]);
    screens.push(("rank-hand", LARGE, hands));
    let drawer = Command::ToggleDrawer(Side::Right);
    screens.push(("rank-table", PHONE, with(grasps(Stage::Rank, GraspPage::Table), [drawer.clone()])));
    screens.push(("grasps-filter", PHONE, with(filtered(), [drawer.clone()])));
    screens.push(("grasps-settings", PHONE, with(grasps(Stage::Grasps, GraspPage::Settings), [drawer])));
    screens.push(("fit-result", PHONE, with(lab(LabPage::Result), [Command::ToggleDrawer(Side::Right)])));
    screens.push(("fit-shape", PHONE, with(lab(LabPage::Shape), [Command::ToggleDrawer(Side::Right)])));
    let mut told = at(Step::Stage(Stage::Grasps));
    let _none = told.apply(Command::FileFailed {
        name: "bunny.pcd".to_owned(),
        reason: "line 11 says 4 096 points, the file ends after 1 200".to_owned(),
    });
    told.say(false, "The picture was saved as endcomfort-glass-4.62s.png.", Vec::new());
    screens.push(("messages", SMALL, told));
    let folder = std::env::var_os("ENDCOMFORT_LOOK").map(std::path::PathBuf::from);
    let only = std::env::var("ENDCOMFORT_LOOK_ONLY").ok();
    for (name, size, state) in screens {
        if only.as_ref().is_some_and(|only| !name.starts_with(only.as_str())) {
            continue;
        }
        let mut harness = page(state, size, egui::Theme::Dark);
        for theme in [egui::Theme::Dark, egui::Theme::Light] {
            harness.ctx.set_theme(theme);
            harness.run_steps(4);
            let picture = harness.render().expect("the software rasteriser draws");
            let tokens = Tokens::for_dark(theme == egui::Theme::Dark);
            if harness.state().state.overlay == Overlay::None {
                // Beside the wordmark there is nothing but the top bar over the view.
                let found = picture.get_pixel(20, 17).0;
                let view = tokens.view_centre.lerp_to_gamma(tokens.view_edge, 0.5);
                let wanted = view.blend(tokens.panel).to_array();
                for (found, wanted) in found.into_iter().zip(wanted) {
                    assert!(found.abs_diff(wanted) <= 2, "{name}: {found} against {wanted} of the panel's colour");
                }
            }
            if let Some(folder) = &folder {
                let file = format!("{name}-{}x{}-{theme:?}.png", size[0], size[1]).to_lowercase();
                picture.save(folder.join(file)).expect("the folder can be written");
            }
        }
        let Page { commands, .. } = harness.into_state();
        assert!(commands.is_empty(), "{name}: nobody touched anything, yet {commands:?}");
    }
}
