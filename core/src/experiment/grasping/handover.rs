//! Handovers on random cases (thesis Table 6.1): success, planning time, and what there was to choose from.
//!
//! Every case of a scene with another receiver is planned twice: with the receiver first (6.2), and without, the place
//! then being the one nearest to the object's way (6.1). Cases from hand to hand have a start that only one arm can grasp
//! at and a goal that only the other one can. Every plan is walked again with the exhaustive judge, both arms, both hands
//! and the object included.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::handover_cases::{across, around};
use super::known::KnownObject;
use super::{GraspExperiment, GraspExperimentSettings};
use crate::experiment::ExperimentRefusal;
use crate::experiment::record::{Cell, Record};
use crate::experiment::summary::Summary;
use crate::fit::FitSettings;
use crate::grasp::Touched;
use crate::handover::Handover;
use crate::job::Refusal;
use crate::pipeline::{HandoverInput, acting, grasp_candidates, workcell};
use crate::rng::Rng;
use crate::scene::Scene;
use crate::task::{Partners, Plan};
use crate::watch::Watch;

/// Cases per scene, and per robot from hand to hand, unless told.
const USUAL_TRIALS: usize = 100;
/// Object that goes from hand to hand.
const PASSED: &str = "mustard_bottle";
/// Draws until a start and a goal are found that only opposite arms serve.
const MOST_DRAWS: usize = 400;
/// Configurations per sample when a plan is walked again.
const DENSITY: usize = 4;
/// Two sides of a normal distribution that leave 5 % outside, standard deviations.
const TWO_SIDED_95: f64 = 1.959_963_984_540_054;

/// What one planning of a case gave.
#[derive(Clone, Debug)]
pub struct HandoverCase {
    /// Scene, or `self_ROBOT`.
    pub scenario: String,
    /// Whether the receiver came first.
    pub receiver_first: bool,
    /// Number of the draw.
    pub case: usize,
    /// The plan's measures, or why there is none.
    pub planned: Result<Handed, String>,
    /// Synthesis of both hands' candidate grasps, and from there to the timed plan, milliseconds; `None` when cases ran
    /// side by side.
    pub times_ms: Option<[f64; 2]>,
}

/// Measures of a planned handover.
#[derive(Clone, Debug)]
pub struct Handed {
    /// Grasps that serve the start, and the goal.
    pub grasps: [usize; 2],
    /// Places found.
    pub places: usize,
    /// Manipulability of giver and receiver when the receiver has closed its hand.
    pub manipulability: [f64; 2],
    /// Discomfort of a person there.
    pub discomfort: Option<f64>,
    /// Motions that touch something when walked again, of all motions.
    pub blocked: [usize; 2],
    /// Duration, seconds.
    pub duration_s: f64,
}

/// One scenario and order, all cases together.
#[derive(Clone, Debug)]
pub struct HandoverRow {
    /// Scene, or `self_ROBOT`.
    pub scenario: String,
    /// Whether the receiver came first.
    pub receiver_first: bool,
    /// Cases.
    pub trials: usize,
    /// Cases with a plan.
    pub success: usize,
    /// From candidate grasps to the timed plan, milliseconds, successful or not.
    pub plan_ms: Option<Summary>,
    /// Synthesis of the candidate grasps of both hands, milliseconds.
    pub synthesis_ms: Option<Summary>,
    /// Grasps of the giver that serve the start.
    pub giver_grasps: Option<Summary>,
    /// Grasps of the receiver that serve the goal.
    pub receiver_grasps: Option<Summary>,
    /// Places found.
    pub places: Option<Summary>,
    /// The receiver's manipulability at the handover: mean and half of its 95 % confidence interval.
    pub receiver_manipulability: Option<[f64; 2]>,
    /// What the receiver gains by coming first, case by case: mean and half of the 95 % confidence interval; only where
    /// it does.
    pub gain: Option<[f64; 2]>,
    /// Discomfort of a person.
    pub discomfort: Option<Summary>,
    /// Motions that touch something, of all motions.
    pub blocked: [usize; 2],
    /// Durations, seconds.
    pub duration_s: Option<Summary>,
}

/// What the experiment gave.
#[derive(Clone, Debug)]
pub struct HandoverOutcome {
    /// One row per scenario and order.
    pub rows: Vec<HandoverRow>,
    /// Every case.
    pub cases: Vec<HandoverCase>,
}

/// A row of the thesis's Table 6.1, as printed there.
#[derive(Clone, Copy, Debug)]
pub struct ThesisHandover {
    /// Mean planning time, seconds.
    pub plan_s: f64,
    /// Successful plans of 100.
    pub success: usize,
    /// Mean number of grasps of giver and receiver, and of handover poses.
    pub counts: [usize; 3],
}

/// What the thesis prints of a scenario, for comparison.
pub fn thesis_handover(scenario: &str) -> Option<ThesisHandover> {
    let row = |plan_s, counts| Some(ThesisHandover { plan_s, success: 100, counts });
    match scenario {
        "butler" => row(2.31, [32, 39, 16]),
        "stool" => row(4.62, [56, 143, 89]),
        "kneeling" => row(3.18, [30, 72, 39]),
        _ => None,
    }
}

/// A case before it is planned.
struct Asked<'a> {
    scenario: String,
    receiver_first: bool,
    case: usize,
    base: Option<&'a Scene>,
    object: &'a KnownObject,
    robot: &'a str,
    stream: u64,
}

/// Runs the experiment; the outcome depends on the settings alone, but for the times.
///
/// # Errors
/// [`ExperimentRefusal`] when there is nothing to do, a scene or a robot cannot be used, or the caller stopped it.
pub fn run_handover(
    settings: &GraspExperimentSettings,
    watch: Watch<'_>,
) -> Result<HandoverOutcome, ExperimentRefusal> {
    settings.check(GraspExperiment::Handover)?;
    let trials = settings.trials.unwrap_or(USUAL_TRIALS);
    let library = &settings.library;
    let known = |name: &str, fit: &FitSettings| KnownObject::new(library, name, fit, settings.seed, 0);
    let scenes = settings.scenes.iter().filter(|scene| scene.handover.as_ref().and_then(Handover::agent).is_some());
    let mut bases = Vec::new();
    for scene in scenes {
        bases.push((scene, known(&scene.objects[scene.task.object].object, &scene.fit)?));
    }
    let passed = known(PASSED, &FitSettings::default())?;
    let mut asked = Vec::new();
    for (number, (base, object)) in bases.iter().enumerate() {
        for receiver_first in [true, false] {
            asked.extend((0..trials).map(|case| Asked {
                scenario: base.name.clone(),
                receiver_first,
                case,
                base: Some(base),
                object,
                robot: &base.robot,
                // The same draw for both orders.
                stream: ((number as u64) << 32) + case as u64,
            }));
        }
    }
    for (number, robot) in settings.robots.iter().enumerate() {
        asked.extend((0..trials).map(|case| Asked {
            scenario: format!("self_{robot}"),
            receiver_first: false,
            case,
            base: None,
            object: &passed,
            robot,
            stream: ((1000 + number as u64) << 32) + case as u64,
        }));
    }
    let known: Vec<String> =
        asked.chunk_by(|l, r| l.scenario == r.scenario).map(|same| same[0].scenario.clone()).collect();
    if let Some(name) = settings.scenarios.iter().find(|name| !known.contains(name)) {
        return Err(ExperimentRefusal::Setup {
            reason: format!("no scenario {name:?}; there are {}", known.join(", ")),
        });
    }
    // The draws of a scenario do not depend on which others run.
    asked.retain(|asked| settings.scenarios.is_empty() || settings.scenarios.contains(&asked.scenario));
    let work = || {
        let done = AtomicUsize::new(0);
        let judged = settings.pace.map(&asked, |one| {
            let case = judge(settings, one, watch)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            watch.progress(done as f64 / asked.len() as f64, &format!("{done} cases"));
            Ok(case)
        });
        let cases: Vec<HandoverCase> = judged.into_iter().collect::<Result<_, ExperimentRefusal>>()?;
        let same =
            |l: &HandoverCase, r: &HandoverCase| (&l.scenario, l.receiver_first) == (&r.scenario, r.receiver_first);
        let groups: Vec<&[HandoverCase]> = cases.chunk_by(same).collect();
        let other_order = |group: &[HandoverCase]| {
            let other = groups.iter().find(|g| g[0].scenario == group[0].scenario && !g[0].receiver_first);
            other.copied().filter(|_| group[0].receiver_first).unwrap_or_default()
        };
        let rows = groups.iter().map(|group| HandoverRow::of(group, other_order(group))).collect();
        Ok(HandoverOutcome { rows, cases })
    };
    settings.pace.run(work)
}

fn judge(
    settings: &GraspExperimentSettings,
    asked: &Asked<'_>,
    watch: Watch<'_>,
) -> Result<HandoverCase, ExperimentRefusal> {
    if watch.should_stop() {
        return Err(ExperimentRefusal::Stopped);
    }
    let (stop, now) = (|| watch.should_stop(), || watch.now_ms());
    let silent = Watch::new(&stop, &|_, _| (), &now);
    let refused = |refusal: Refusal| ExperimentRefusal::Setup { reason: refusal.message };
    let mut rng = Rng::new(settings.seed, asked.stream);
    let seed = settings.seed ^ asked.stream;
    let mut drawn = match asked.base {
        Some(base) => Case::new(around(base, &mut rng, seed), asked.object, settings, watch).map_err(refused)?,
        None => {
            let mut draws = 0;
            loop {
                let scene = across(asked.robot, asked.object, &mut rng, seed);
                let case = Case::new(scene, asked.object, settings, watch).map_err(refused)?;
                draws += 1;
                if case.needs_both_arms(asked.object, settings).map_err(refused)? {
                    break case;
                }
                if draws == MOST_DRAWS {
                    let reason = format!("{}: no start and goal of opposite arms in {draws} draws", asked.robot);
                    return Err(ExperimentRefusal::Setup { reason });
                }
            }
        }
    };
    if let Some(handover) = &mut drawn.scene.handover {
        handover.choice.receiver_first = asked.receiver_first;
    }
    let (plan, plan_ms, partners) = drawn.plan(asked.object, settings, silent).map_err(refused)?;
    let planned = match plan {
        Ok(plan) => Ok(Handed::of(&partners, &plan).map_err(refused)?),
        Err(Refusal { message, details, .. }) => {
            Err([message].into_iter().chain(details.into_iter().take(1)).collect::<Vec<_>>().join(": "))
        }
    };
    Ok(HandoverCase {
        scenario: asked.scenario.clone(),
        receiver_first: asked.receiver_first,
        case: asked.case,
        planned,
        times_ms: settings.pace.has_times().then_some([drawn.synthesis_ms, plan_ms]),
    })
}

/// A drawn case with the giver's side of it.
struct Case {
    /// As the giver's arm sees it.
    scene: Scene,
    giver: crate::task::Workcell,
    grasps: Vec<crate::grasp::Grasp>,
    synthesis_ms: f64,
}

impl Case {
    fn new(
        scene: Scene,
        object: &KnownObject,
        settings: &GraspExperimentSettings,
        watch: Watch<'_>,
    ) -> Result<Self, Refusal> {
        let scene = acting(&scene, &settings.library)?.into_owned();
        let X_WO = &scene.objects[scene.task.object].X_WO;
        let giver = workcell(&scene, &object.fits(X_WO), &[], false, &settings.library)?;
        let begin_ms = watch.now_ms();
        let grasps = grasp_candidates(&giver, &object.fit(X_WO), Touched::Bodies, &scene.grasp)?;
        let synthesis_ms = watch.now_ms() - begin_ms;
        Ok(Self { scene, giver, grasps, synthesis_ms })
    }

    fn input<'a>(
        &'a self,
        target: &'a crate::fit::Fit,
        handover: &'a Handover,
        settings: &'a GraspExperimentSettings,
    ) -> HandoverInput<'a> {
        HandoverInput {
            giver: &self.giver,
            grasps: &self.grasps,
            target,
            touched: &|| Ok(Touched::Bodies),
            scene: &self.scene,
            handover,
            library: &settings.library,
            is_dropped: false,
        }
    }

    /// Whether only the giver's arm can grasp at the start, and only the receiver's at the goal.
    fn needs_both_arms(&self, object: &KnownObject, settings: &GraspExperimentSettings) -> Result<bool, Refusal> {
        let Some(handover) = &self.scene.handover else { return Ok(false) };
        let target = object.fit(&self.scene.objects[self.scene.task.object].X_WO);
        let input = self.input(&target, handover, settings);
        let (partners, receiver_grasps) = input.partners()?;
        let serving = input.serving(&partners, &receiver_grasps)?;
        Ok(serving.giver.0 > 0 && serving.giver.1 == 0 && serving.receiver.0 == 0 && serving.receiver.1 > 0)
    }

    /// The plan, the milliseconds that it took, and both sides.
    fn plan(
        &mut self,
        object: &KnownObject,
        settings: &GraspExperimentSettings,
        watch: Watch<'_>,
    ) -> Result<(Result<Plan, Refusal>, f64, Partners), Refusal> {
        let none = || Refusal::new("the scene has no handover");
        let handover = self.scene.handover.clone().ok_or_else(none)?;
        let target = object.fit(&self.scene.objects[self.scene.task.object].X_WO);
        let input = self.input(&target, &handover, settings);
        let begin_ms = watch.now_ms();
        let (partners, receiver_grasps) = input.partners()?;
        let synthesised_ms = watch.now_ms();
        let plan = input.plan_between(&partners, &receiver_grasps, watch);
        let end_ms = watch.now_ms();
        self.synthesis_ms += synthesised_ms - begin_ms;
        Ok((plan, end_ms - synthesised_ms, partners))
    }
}

impl Handed {
    fn of(partners: &Partners, plan: &Plan) -> Result<Self, Refusal> {
        let failed = |error: crate::collision::CollisionError| Refusal::new(error.to_string());
        let Some(report) = &plan.handover else { return Err(Refusal::new("a plan without a handover")) };
        let mut blocked = [0, 0];
        for (number, phase) in plan.phases.iter().enumerate().filter(|(_, phase)| !phase.kind.is_of_fingers()) {
            let cell = partners.during(plan, number);
            blocked[0] += usize::from(cell.rewalk_phase(plan, phase, DENSITY).map_err(failed)?.is_some());
            blocked[1] += 1;
        }
        let last = |leg: usize, kind: crate::task::PhaseKind| {
            let phase = plan.phases.iter().find(|phase| phase.leg == leg && phase.kind == kind);
            phase.and_then(|phase| phase.manipulability.last()).copied().unwrap_or(0.0)
        };
        use crate::task::PhaseKind::{Close, Open};
        Ok(Self {
            grasps: report.grasps,
            places: report.places.len(),
            manipulability: [last(0, Open), last(1, Close)],
            discomfort: report.places[report.chosen].comfort.map(|comfort| comfort.total),
            blocked,
            duration_s: plan.duration_s(),
        })
    }
}

/// Mean of values and half of its 95 % confidence interval; `None` for fewer than two.
fn mean_and_half_width(values: &[f64]) -> Option<[f64; 2]> {
    let count = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (count - 1.0);
    Some([mean, TWO_SIDED_95 * (variance / count).sqrt()])
}

impl HandoverRow {
    /// Cases of one scenario and order, at least one; the same cases in the other order.
    fn of(cases: &[HandoverCase], others: &[HandoverCase]) -> Self {
        let done: Vec<&Handed> = cases.iter().filter_map(|case| case.planned.as_ref().ok()).collect();
        let over = |value: fn(&Handed) -> f64| Summary::of(done.iter().map(|handed| value(handed)));
        let times = |index: usize| Summary::of(cases.iter().filter_map(|case| case.times_ms.map(|ms| ms[index])));
        let of_receiver: Vec<f64> = done.iter().map(|handed| handed.manipulability[1]).collect();
        let gains: Vec<f64> = cases
            .iter()
            .zip(others)
            .filter_map(|(l, r)| {
                let m = |case: &HandoverCase| case.planned.as_ref().ok().map(|handed| handed.manipulability[1]);
                Some(m(l)? - m(r)?)
            })
            .collect();
        let sum = |index: usize| done.iter().map(|handed| handed.blocked[index]).sum();
        Self {
            scenario: cases[0].scenario.clone(),
            receiver_first: cases[0].receiver_first,
            trials: cases.len(),
            success: done.len(),
            plan_ms: times(1),
            synthesis_ms: times(0),
            giver_grasps: over(|handed| handed.grasps[0] as f64),
            receiver_grasps: over(|handed| handed.grasps[1] as f64),
            places: over(|handed| handed.places as f64),
            receiver_manipulability: mean_and_half_width(&of_receiver),
            gain: mean_and_half_width(&gains),
            discomfort: Summary::of(done.iter().filter_map(|handed| handed.discomfort)),
            blocked: [sum(0), sum(1)],
            duration_s: over(|handed| handed.duration_s),
        }
    }
}

fn order(receiver_first: bool) -> &'static str {
    if receiver_first { "receiver_first" } else { "nearest_to_the_way" }
}

impl Record for HandoverCase {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let handed = self.planned.as_ref().ok();
        vec![
            ("experiment", GraspExperiment::Handover.name().into()),
            ("scenario", self.scenario.as_str().into()),
            ("order", order(self.receiver_first).into()),
            ("case", self.case.into()),
            ("planned", handed.is_some().into()),
            ("reason", self.planned.as_ref().err().map(String::as_str).into()),
            ("giver_grasps", handed.map(|h| h.grasps[0]).into()),
            ("receiver_grasps", handed.map(|h| h.grasps[1]).into()),
            ("handover_poses", handed.map(|h| h.places).into()),
            ("giver_manipulability", handed.map(|h| h.manipulability[0]).into()),
            ("receiver_manipulability", handed.map(|h| h.manipulability[1]).into()),
            ("discomfort", handed.and_then(|h| h.discomfort).into()),
            ("motions", handed.map(|h| h.blocked[1]).into()),
            ("blocked", handed.map(|h| h.blocked[0]).into()),
            ("duration_s", handed.map(|h| h.duration_s).into()),
            ("synthesis_ms", self.times_ms.map(|ms| ms[0]).into()),
            ("plan_ms", self.times_ms.map(|ms| ms[1]).into()),
        ]
    }
}

impl Record for HandoverRow {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        vec![
            ("experiment", GraspExperiment::Handover.name().into()),
            ("scenario", self.scenario.as_str().into()),
            ("order", order(self.receiver_first).into()),
            ("trials", self.trials.into()),
            ("success", self.success.into()),
            ("plan_ms_mean", self.plan_ms.map(|s| s.mean).into()),
            ("plan_ms_median", self.plan_ms.map(|s| s.median).into()),
            ("plan_ms_p95", self.plan_ms.map(|s| s.p95).into()),
            ("synthesis_ms_mean", self.synthesis_ms.map(|s| s.mean).into()),
            ("giver_grasps_mean", self.giver_grasps.map(|s| s.mean).into()),
            ("receiver_grasps_mean", self.receiver_grasps.map(|s| s.mean).into()),
            ("handover_poses_mean", self.places.map(|s| s.mean).into()),
            ("receiver_manipulability_mean", self.receiver_manipulability.map(|m| m[0]).into()),
            ("receiver_manipulability_ci95", self.receiver_manipulability.map(|m| m[1]).into()),
            ("gain_mean", self.gain.map(|m| m[0]).into()),
            ("gain_ci95", self.gain.map(|m| m[1]).into()),
            ("discomfort_mean", self.discomfort.map(|s| s.mean).into()),
            ("motions", self.blocked[1].into()),
            ("motions_blocked", self.blocked[0].into()),
            ("duration_s_median", self.duration_s.map(|s| s.median).into()),
        ]
    }
}
