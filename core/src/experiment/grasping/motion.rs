//! Whole pick-and-place plans on random cases: how many succeed, how long they take, and whether they keep their word.
//!
//! Every plan is walked again at four configurations per sample with the exhaustive judge, which shares no code with
//! the planner's checker, and its samples are held against the limits of the joints.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::cases::{Condition, draw};
use super::known::{KnownObject, known_objects};
use super::{GraspExperiment, GraspExperimentSettings};
use crate::collision::CollisionError;
use crate::experiment::ExperimentRefusal;
use crate::experiment::record::{Cell, Record};
use crate::experiment::summary::Summary;
use crate::grasp::Touched;
use crate::job::Refusal;
use crate::pipeline::{TaskInput, grasp_candidates, ranked, workcell};
use crate::plan::{ArmSpace, MotionLimits};
use crate::task::{Phase, Plan, Workcell};
use crate::watch::Watch;

/// Cases per robot and condition unless told.
const USUAL_TRIALS: usize = 75;
/// Configurations per sample when a plan is walked again.
const DENSITY: usize = 4;

/// One random case.
#[derive(Clone, Debug)]
pub struct MotionCase {
    /// Robot.
    pub robot: String,
    /// What changes from start to goal.
    pub condition: Condition,
    /// Number of the draw.
    pub case: usize,
    /// Object.
    pub object: String,
    /// Arm that acts.
    pub arm: &'static str,
    /// Grasps that can be used at both poses.
    pub accepted: usize,
    /// The plan's measures, or why there is none.
    pub planned: Result<Planned, String>,
    /// From the fit to the ranked grasps, and from these to the timed plan, milliseconds; `None` when cases ran side
    /// by side.
    pub times_ms: Option<[f64; 2]>,
}

/// Measures of a plan.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Grasps used, one after the other.
    pub grasps: usize,
    /// Grasps tried in vain.
    pub tries: usize,
    /// Trajectories: phases in which the arm moves.
    pub trajectories: usize,
    /// Samples of all of them.
    pub samples: usize,
    /// Trajectories that touch something when walked again.
    pub blocked: usize,
    /// Trajectories that exceed a limit of a joint.
    pub beyond_limits: usize,
    /// Duration, seconds.
    pub duration_s: f64,
    /// Smallest distance of the arm with what it carries from everything while it reaches or transports, metres.
    pub clearance_m: f64,
}

/// One robot and condition, all cases together.
#[derive(Clone, Debug)]
pub struct MotionRow {
    /// Robot.
    pub robot: String,
    /// What changes from start to goal.
    pub condition: Condition,
    /// Cases.
    pub trials: usize,
    /// Cases with a grasp that can be used at both poses.
    pub solvable: usize,
    /// Of these, cases with a plan.
    pub success: usize,
    /// Further cases with a plan, which puts the object down in between.
    pub regrasped: usize,
    /// Trajectories of all plans, those that touch something, and those that exceed a limit.
    pub trajectories: [usize; 3],
    /// Grasps tried in vain before a plan stood.
    pub tries: Option<Summary>,
    /// From the fit to the timed plan, milliseconds, of the solvable cases.
    pub fit_to_plan_ms: Option<Summary>,
    /// From ranked grasps to the timed plan, milliseconds, of the solvable cases.
    pub plan_ms: Option<Summary>,
    /// Durations, seconds.
    pub duration_s: Option<Summary>,
    /// Smallest clearances, metres.
    pub clearance_m: Option<Summary>,
}

/// What the experiment gave.
#[derive(Clone, Debug)]
pub struct MotionOutcome {
    /// One row per robot and condition.
    pub rows: Vec<MotionRow>,
    /// Every case.
    pub cases: Vec<MotionCase>,
}

/// Runs the experiment; the outcome depends on the settings alone, but for the times.
///
/// # Errors
/// [`ExperimentRefusal`] when there is nothing to do, an object or a robot cannot be used, or the caller stopped it.
pub fn run_motion(settings: &GraspExperimentSettings, watch: Watch<'_>) -> Result<MotionOutcome, ExperimentRefusal> {
    settings.check(GraspExperiment::Motion)?;
    let work = || {
        let objects = known_objects(settings)?;
        let trials = settings.trials.unwrap_or(USUAL_TRIALS);
        let mut asked = Vec::new();
        for (number, robot) in settings.robots.iter().enumerate() {
            for condition in Condition::ALL {
                // Streams of one robot and condition lie together, others far away.
                let first_stream = ((2 * number + condition as usize) as u64) << 32;
                asked.extend((0..trials).map(|case| (robot, condition, case, first_stream + case as u64)));
            }
        }
        let done = AtomicUsize::new(0);
        let judged = settings.pace.map(&asked, |&(robot, condition, case, stream)| {
            let case = judge(settings, &objects, robot, condition, case, stream, watch)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            watch.progress(done as f64 / asked.len() as f64, &format!("{done} of {}", asked.len()));
            Ok(case)
        });
        let cases: Vec<MotionCase> = judged.into_iter().collect::<Result<_, ExperimentRefusal>>()?;
        let rows = cases.chunk_by(|l, r| l.robot == r.robot && l.condition == r.condition).map(MotionRow::of).collect();
        Ok(MotionOutcome { rows, cases })
    };
    settings.pace.run(work)
}

fn judge(
    settings: &GraspExperimentSettings,
    objects: &[KnownObject],
    robot: &str,
    condition: Condition,
    number: usize,
    stream: u64,
    watch: Watch<'_>,
) -> Result<MotionCase, ExperimentRefusal> {
    if watch.should_stop() {
        return Err(ExperimentRefusal::Stopped);
    }
    let (stop, now) = (|| watch.should_stop(), || watch.now_ms());
    let silent = Watch::new(&stop, &|_, _| (), &now);
    let mut drawn = draw(robot, condition, objects, settings.clutter, settings.seed, stream);
    drawn.scene.motion.planner = settings.planner;
    let refused = |refusal: Refusal| ExperimentRefusal::Setup { reason: refusal.message };
    let object = &objects[drawn.object];
    let X_WO = &drawn.scene.objects[0].X_WO;
    let (fits, target) = (object.fits(X_WO), object.fit(X_WO));
    let begin_ms = watch.now_ms();
    let cell = workcell(&drawn.scene, &fits, &[], false, &settings.library).map_err(refused)?;
    let candidates = grasp_candidates(&cell, &target, Touched::Bodies, &drawn.scene.grasp).map_err(refused)?;
    let ranked = ranked(&cell, &candidates, &target, &drawn.scene, silent).map_err(refused)?;
    let ranked_ms = watch.now_ms();
    let touched = || Ok(Touched::Bodies);
    let task = TaskInput {
        cell: &cell,
        ranked: &ranked,
        chosen: None,
        target: &target,
        touched: &touched,
        scene: &drawn.scene,
        watch: silent,
    };
    let plan = task.plan();
    let end_ms = watch.now_ms();
    let planned = match plan {
        Ok(plan) => Ok(Planned::of(&cell, &plan).map_err(refused)?),
        Err(refusal) => Err(refusal.tries.first().map_or(refusal.message, ToString::to_string)),
    };
    Ok(MotionCase {
        robot: robot.to_owned(),
        condition,
        case: number,
        object: object.name.clone(),
        arm: drawn.scene.arm.name(),
        accepted: ranked.iter().filter(|grasp| grasp.is_accepted()).count(),
        planned,
        times_ms: settings.pace.has_times().then_some([ranked_ms - begin_ms, end_ms - ranked_ms]),
    })
}

impl Planned {
    fn of(cell: &Workcell, plan: &Plan) -> Result<Self, Refusal> {
        let failed = |error: CollisionError| Refusal::new(error.to_string());
        let checker = cell.approaching(plan.X_WO_start()).and_then(|situation| cell.checker(&situation));
        let space = checker.and_then(|checker| ArmSpace::new(&cell.robot, cell.arm_index, checker)).map_err(failed)?;
        let limits = MotionLimits::of(&space);
        let moving: Vec<&Phase> = plan.phases.iter().filter(|phase| !phase.kind.is_of_fingers()).collect();
        let (mut blocked, mut beyond_limits) = (0, 0);
        for phase in &moving {
            blocked += usize::from(cell.rewalk_phase(plan, phase, DENSITY).map_err(failed)?.is_some());
            beyond_limits += usize::from(limits.first_violation(&phase.trajectory).is_some());
        }
        let searched = moving.iter().filter(|phase| phase.kind.is_searched()).flat_map(|phase| &phase.clearance_m);
        Ok(Self {
            grasps: plan.legs.len(),
            tries: plan.tries.len(),
            trajectories: moving.len(),
            samples: moving.iter().map(|phase| phase.trajectory.positions.len()).sum(),
            blocked,
            beyond_limits,
            duration_s: plan.duration_s(),
            clearance_m: searched.copied().fold(f64::INFINITY, f64::min),
        })
    }
}

impl MotionRow {
    /// Cases of one robot and condition, at least one.
    fn of(cases: &[MotionCase]) -> Self {
        let solvable: Vec<&MotionCase> = cases.iter().filter(|case| case.accepted > 0).collect();
        let plans: Vec<&Planned> = cases.iter().filter_map(|case| case.planned.as_ref().ok()).collect();
        let sum = |count: fn(&Planned) -> usize| plans.iter().map(|plan| count(plan)).sum();
        let times = |time: fn([f64; 2]) -> f64| Summary::of(solvable.iter().filter_map(|case| case.times_ms.map(time)));
        let success = solvable.iter().filter(|case| case.planned.is_ok()).count();
        Self {
            robot: cases[0].robot.clone(),
            condition: cases[0].condition,
            trials: cases.len(),
            solvable: solvable.len(),
            success,
            regrasped: plans.len() - success,
            trajectories: [sum(|plan| plan.trajectories), sum(|plan| plan.blocked), sum(|plan| plan.beyond_limits)],
            tries: Summary::of(plans.iter().map(|plan| plan.tries as f64)),
            fit_to_plan_ms: times(|[rank_ms, plan_ms]| rank_ms + plan_ms),
            plan_ms: times(|[_, plan_ms]| plan_ms),
            duration_s: Summary::of(plans.iter().map(|plan| plan.duration_s)),
            clearance_m: Summary::of(plans.iter().map(|plan| plan.clearance_m)),
        }
    }
}

impl Record for MotionCase {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let plan = self.planned.as_ref().ok();
        vec![
            ("experiment", GraspExperiment::Motion.name().into()),
            ("robot", self.robot.as_str().into()),
            ("condition", self.condition.name().into()),
            ("case", self.case.into()),
            ("object", self.object.as_str().into()),
            ("arm", self.arm.into()),
            ("grasps_accepted", self.accepted.into()),
            ("planned", plan.is_some().into()),
            ("reason", self.planned.as_ref().err().map(String::as_str).into()),
            ("grasps_used", plan.map(|plan| plan.grasps).into()),
            ("tries", plan.map(|plan| plan.tries).into()),
            ("trajectories", plan.map(|plan| plan.trajectories).into()),
            ("samples", plan.map(|plan| plan.samples).into()),
            ("blocked", plan.map(|plan| plan.blocked).into()),
            ("beyond_limits", plan.map(|plan| plan.beyond_limits).into()),
            ("duration_s", plan.map(|plan| plan.duration_s).into()),
            ("clearance_m", plan.map(|plan| plan.clearance_m).into()),
            ("rank_ms", self.times_ms.map(|[rank_ms, _]| rank_ms).into()),
            ("plan_ms", self.times_ms.map(|[_, plan_ms]| plan_ms).into()),
        ]
    }
}

impl Record for MotionRow {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let [trajectories, blocked, beyond_limits] = self.trajectories;
        vec![
            ("experiment", GraspExperiment::Motion.name().into()),
            ("robot", self.robot.as_str().into()),
            ("condition", self.condition.name().into()),
            ("trials", self.trials.into()),
            ("solvable", self.solvable.into()),
            ("success", self.success.into()),
            ("regrasped", self.regrasped.into()),
            ("trajectories", trajectories.into()),
            ("trajectories_blocked", blocked.into()),
            ("trajectories_beyond_limits", beyond_limits.into()),
            ("tries_mean", self.tries.map(|s| s.mean).into()),
            ("fit_to_plan_ms_median", self.fit_to_plan_ms.map(|s| s.median).into()),
            ("fit_to_plan_ms_p95", self.fit_to_plan_ms.map(|s| s.p95).into()),
            ("plan_ms_median", self.plan_ms.map(|s| s.median).into()),
            ("plan_ms_p95", self.plan_ms.map(|s| s.p95).into()),
            ("duration_s_median", self.duration_s.map(|s| s.median).into()),
            ("clearance_m_median", self.clearance_m.map(|s| s.median).into()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::csv;
    use crate::experiment::grasping::testing::settings;

    #[test]
    fn plans_touch_nothing_keep_their_limits_and_do_not_depend_on_the_number_of_threads() {
        let settings = GraspExperimentSettings { trials: Some(3), ..settings(&["tomato_soup_can", "cracker_box"]) };
        let run = || run_motion(&settings, Watch::idle()).unwrap();
        let outcome = run();
        assert_eq!((outcome.rows.len(), outcome.cases.len()), (2, 6));
        let mut planned = 0;
        for row in &outcome.rows {
            assert!(row.success <= row.solvable && row.solvable <= row.trials);
            assert_eq!(row.trajectories[1..], [0, 0], "{row:?}");
            planned += row.success;
        }
        assert!(planned >= 3, "{:?}", outcome.rows);
        let again = crate::parallel::on_one_thread(run);
        assert_eq!(csv(&outcome.cases), csv(&again.cases));
    }
}
