//! Table 5.1: for random pick-and-place cases, whether the grasp that an order puts first yields both paths.
//!
//! As in the thesis only cases count that can be solved at all: a case in which no grasp works, however many are tried,
//! is set aside, counted with its reason, and another one is drawn. What a grasp leads to depends on the case alone, so
//! each is planned once and shared by all orders.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::cases::{Case, Condition, draw};
use super::known::{KnownObject, known_objects};
use super::priority_row::{Excluded, PriorityCase, PriorityRow, Setback};
use super::{GraspExperiment, GraspExperimentSettings};
use crate::experiment::ExperimentRefusal;
use crate::grasp::{Grasp, GraspStatus, RankBy, RankSettings, Touched, rank};
use crate::job::Refusal;
use crate::pipeline::{grasp_candidates, ranked, workcell};
use crate::scene::Scene;
use crate::task::{LegTask, MotionSettings, Workcell, plan_leg};
use crate::watch::Watch;

/// Draws per wanted case before the experiment is refused: far more than the robots' tables need.
const MOST_DRAWS: usize = 20;

/// What the experiment gave.
#[derive(Clone, Debug)]
pub struct PrioritizationOutcome {
    /// One row per robot, condition and order.
    pub rows: Vec<PriorityRow>,
    /// Every case under every order, and the cases that were set aside.
    pub cases: Vec<PriorityCase>,
}

/// Runs the experiment; the outcome depends on the settings alone, but for the times.
///
/// # Errors
/// [`ExperimentRefusal`] when there is nothing to do, an object or a robot cannot be used, too few cases can be
/// solved, or the caller stopped it.
pub fn run_prioritization(
    settings: &GraspExperimentSettings,
    watch: Watch<'_>,
) -> Result<PrioritizationOutcome, ExperimentRefusal> {
    settings.check(GraspExperiment::Prioritization)?;
    let work = || {
        let objects = known_objects(settings)?;
        let trials = |condition: Condition| settings.trials.unwrap_or(condition.thesis_trials());
        let wanted = Condition::ALL.map(trials).iter().sum::<usize>() * settings.robots.len();
        let progress = Progress { done: AtomicUsize::new(0), wanted, watch };
        let mut outcome = PrioritizationOutcome { rows: Vec::new(), cases: Vec::new() };
        for (number, robot) in settings.robots.iter().enumerate() {
            for condition in Condition::ALL {
                // Streams of one robot and condition lie together, others far away.
                let first_stream = ((2 * number + condition as usize) as u64) << 32;
                let series =
                    Series { settings, objects: &objects, robot, condition, first_stream, progress: &progress };
                let cases = series.run(trials(condition))?;
                outcome.rows.extend(PriorityRow::of(&cases, settings.pace.has_times()));
                outcome.cases.extend(cases);
            }
        }
        Ok(outcome)
    };
    settings.pace.run(work)
}

struct Progress<'a> {
    done: AtomicUsize,
    wanted: usize,
    watch: Watch<'a>,
}

impl Progress<'_> {
    fn one_more(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        // A batch may solve a case more than is wanted of it; the last of them are not counted.
        let done = done.min(self.wanted);
        self.watch.progress(done as f64 / self.wanted as f64, &format!("{done} of {}", self.wanted));
    }
}

/// The cases of one robot and condition.
struct Series<'a> {
    settings: &'a GraspExperimentSettings,
    objects: &'a [KnownObject],
    robot: &'a str,
    condition: Condition,
    first_stream: u64,
    progress: &'a Progress<'a>,
}

impl Series<'_> {
    /// Draws cases until `trials` of them can be solved.
    fn run(&self, trials: usize) -> Result<Vec<PriorityCase>, ExperimentRefusal> {
        let mut cases = Vec::new();
        let (mut found, mut draws) = (0, 0);
        while found < trials {
            if draws >= MOST_DRAWS * trials {
                return Err(ExperimentRefusal::TooFewCases {
                    robot: self.robot.to_owned(),
                    condition: self.condition.name(),
                    found,
                    wanted: trials,
                    draws,
                });
            }
            // As many as are missing, so no case is drawn that may not be needed.
            let batch: Vec<usize> = (draws..draws + trials - found).collect();
            draws += batch.len();
            for judged in self.settings.pace.map(&batch, |&draw| self.judge(draw)) {
                let judged = judged?;
                found += usize::from(judged.iter().all(|case| case.excluded.is_none()));
                cases.extend(judged);
            }
        }
        Ok(cases)
    }

    /// One draw under every order, or why it is set aside.
    fn judge(&self, number: usize) -> Result<Vec<PriorityCase>, ExperimentRefusal> {
        let watch = self.progress.watch;
        let (stop, now) = (|| watch.should_stop(), || watch.now_ms());
        let silent = Watch::new(&stop, &|_, _| (), &now);
        let stream = self.first_stream + number as u64;
        let mut case =
            draw(self.robot, self.condition, self.objects, self.settings.clutter, self.settings.seed, stream);
        case.scene.rank.straight_ways = !self.settings.any_way;
        let refused = |refusal: Refusal| match watch.should_stop() {
            true => ExperimentRefusal::Stopped,
            false => ExperimentRefusal::Setup { reason: refusal.message },
        };
        let object = &self.objects[case.object];
        let fits = object.fits(&case.scene.objects[0].X_WO);
        let cell = workcell(&case.scene, &fits, &[], false, &self.settings.library).map_err(refused)?;
        let target = object.fit(&case.scene.objects[0].X_WO);
        let candidates = grasp_candidates(&cell, &target, Touched::Bodies, &case.scene.grasp).map_err(refused)?;
        // Ranked by score once, so that all that a score is made of is known to every order.
        let rank = RankSettings { by: RankBy::Score, ..case.scene.rank.clone() };
        let scored = Scene { rank, ..case.scene.clone() };
        let mut grasps = ranked(&cell, &candidates, &target, &scored, silent).map_err(refused)?;
        let blank = PriorityCase::blank(self.robot, self.condition, number, &case, &object.name, &grasps);
        if blank.accepted == 0 {
            return Ok(vec![PriorityCase { excluded: Some(why(&grasps)), ..blank }]);
        }
        self.orders(&case, &cell, &mut grasps, &blank, silent)
    }

    /// The case under every order, or set aside when none of the grasps works.
    fn orders(
        &self,
        case: &Case,
        cell: &Workcell,
        grasps: &mut [Grasp],
        blank: &PriorityCase,
        watch: Watch<'_>,
    ) -> Result<Vec<PriorityCase>, ExperimentRefusal> {
        let mut attempts: BTreeMap<u32, (f64, Option<Setback>)> = BTreeMap::new();
        let mut orders = Vec::new();
        for metric in RankBy::ALL {
            rank(grasps, &RankSettings { by: metric, ..case.scene.rank.clone() }, case.scene.seed);
            let (mut time_s, mut tried, mut first) = (0.0, 0, None);
            for grasp in grasps.iter().filter(|grasp| grasp.is_accepted()) {
                if watch.should_stop() {
                    return Err(ExperimentRefusal::Stopped);
                }
                let plan = || attempt(cell, grasp, case.scene.seed, watch);
                let (spent_s, setback) = attempts.entry(grasp.id).or_insert_with(plan);
                time_s += *spent_s;
                tried += 1;
                first.get_or_insert((grasp, setback.clone()));
                if setback.is_none() {
                    break;
                }
            }
            let Some((grasp, setback)) = first else { continue };
            if attempts.values().all(|(_, setback)| setback.is_some()) {
                // The first order has tried them all; what stopped its first grasp stands for the others.
                return Ok(vec![PriorityCase { excluded: Some(Excluded::Path), setback, tried, ..blank.clone() }]);
            }
            orders.push(PriorityCase {
                metric: Some(metric),
                grasp: Some(grasp.id),
                m_g_start: grasp.start.as_ref().map(|set| set.m_g),
                m_g_goal: grasp.goal.as_ref().map(|set| set.m_g),
                setback,
                tried,
                planning_time_s: self.settings.pace.has_times().then_some(time_s),
                ..blank.clone()
            });
        }
        self.progress.one_more();
        Ok(orders)
    }
}

/// Plans with one grasp: seconds, and where it failed if it did.
fn attempt(cell: &Workcell, grasp: &Grasp, seed: u64, watch: Watch<'_>) -> (f64, Option<Setback>) {
    let task = LegTask { cell, ranked: std::slice::from_ref(grasp), chosen: Some(grasp.id), seed };
    let begin_ms = watch.now_ms();
    let planned = plan_leg(&task, &MotionSettings::default(), watch);
    let time_s = (watch.now_ms() - begin_ms) * 1e-3;
    (time_s, planned.err().map(|refusal| Setback::of(&refusal)))
}

/// Why none of the grasps of a case can be used at both poses: how far the best of them came.
fn why(grasps: &[Grasp]) -> Excluded {
    let any = |is: fn(&GraspStatus) -> bool| grasps.iter().any(|grasp| is(&grasp.status));
    if any(|status| matches!(status, GraspStatus::NoIkAtGoal { .. } | GraspStatus::NoWayAtGoal { .. })) {
        Excluded::Goal
    } else if any(|status| matches!(status, GraspStatus::NoIkAtStart { .. } | GraspStatus::NoWayAtStart { .. })) {
        Excluded::Start
    } else {
        Excluded::Hand
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::csv;
    use crate::experiment::grasping::testing::settings;

    const OBJECTS: [&str; 2] = ["tomato_soup_can", "pudding_box"];

    #[test]
    fn rows_count_their_cases_and_do_not_depend_on_the_number_of_threads() {
        let settings = GraspExperimentSettings { trials: Some(2), ..settings(&OBJECTS) };
        let run = || run_prioritization(&settings, Watch::idle()).unwrap();
        let outcome = run();
        assert_eq!(outcome.rows.len(), 2 * RankBy::ALL.len());
        for row in &outcome.rows {
            let is_its = |case: &&PriorityCase| case.condition == row.condition;
            let ours: Vec<&PriorityCase> =
                outcome.cases.iter().filter(is_its).filter(|case| case.metric == Some(row.metric)).collect();
            assert_eq!((ours.len(), row.trials), (2, 2));
            assert_eq!(row.success, ours.iter().filter(|case| case.tried == 1).count(), "{row:?}");
            let set_aside = outcome.cases.iter().filter(is_its).filter(|case| case.excluded.is_some()).count();
            assert_eq!(row.excluded.total(), set_aside);
            let is_the_thesis_s = matches!(row.metric, RankBy::Start | RankBy::Goal | RankBy::Mean);
            assert_eq!(row.thesis.is_some(), is_the_thesis_s);
            assert!(row.planning_time_s.is_none(), "cases ran side by side");
        }
        let again = crate::parallel::on_one_thread(run);
        assert_eq!(csv(&outcome.rows), csv(&again.rows));
        assert_eq!(csv(&outcome.cases), csv(&again.cases));
    }

    #[test]
    fn grasps_are_tried_as_the_pipeline_tries_them() {
        let settings = settings(&OBJECTS);
        let outcome = run_prioritization(&settings, Watch::idle()).unwrap();
        let by_goal = outcome.cases.iter().find(|case| case.metric == Some(RankBy::Goal)).unwrap();
        let objects = known_objects(&settings).unwrap();
        let case = draw("alita", by_goal.condition, &objects, 0, settings.seed, by_goal.case as u64);
        let fits = objects[case.object].fits(&case.scene.objects[0].X_WO);
        let cell = workcell(&case.scene, &fits, &[], false, &settings.library).unwrap();
        let target = fits.fits[0].as_ref().unwrap();
        let grasps = grasp_candidates(&cell, target, Touched::Bodies, &case.scene.grasp).unwrap();
        let ranked = ranked(&cell, &grasps, target, &case.scene, Watch::idle()).unwrap();
        let task = LegTask { cell: &cell, ranked: &ranked, chosen: None, seed: case.scene.seed };
        let plan = plan_leg(&task, &MotionSettings::default(), Watch::idle()).unwrap();
        assert_eq!(plan.tries.len() + 1, by_goal.tried);
        assert_eq!(ranked[0].id, by_goal.grasp.unwrap());
        assert_eq!(plan.leg.grasp.id == ranked[0].id, by_goal.is_one_shot());
    }

    #[test]
    fn it_can_be_stopped_and_says_what_is_missing() {
        let settings = settings(&OBJECTS);
        let stopping = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        assert_eq!(run_prioritization(&settings, stopping).unwrap_err(), ExperimentRefusal::Stopped);
        for (settings, wanted) in [
            (GraspExperimentSettings { trials: Some(0), ..settings.clone() }, "found 0 trials"),
            (GraspExperimentSettings { objects: Vec::new(), ..settings.clone() }, "found 0 objects"),
            (GraspExperimentSettings { robots: Vec::new(), ..settings.clone() }, "found 0 robots"),
            (GraspExperimentSettings { robots: vec!["hal".into()], ..settings.clone() }, "no robot named \"hal\""),
        ] {
            let said = run_prioritization(&settings, Watch::idle()).unwrap_err().to_string();
            assert!(said.contains(wanted), "{said}");
        }
    }

    #[test]
    fn times_are_those_of_the_watch_and_given_only_one_after_the_other() {
        let ticks = std::sync::atomic::AtomicU32::new(0);
        let clock = || f64::from(ticks.fetch_add(1, Ordering::Relaxed));
        let watch = Watch::new(&|| false, &|_, _| (), &clock);
        let settings = GraspExperimentSettings { pace: crate::experiment::Pace::OneProcessor, ..settings(&OBJECTS) };
        let outcome = run_prioritization(&settings, watch).unwrap();
        assert!(outcome.rows.iter().all(|row| row.planning_time_s.is_some_and(|time_s| time_s.mean >= 0.001)));
    }
}
