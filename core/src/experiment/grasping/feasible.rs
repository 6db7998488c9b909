//! How many grasps each object offers each robot where it stands on the table.
//!
//! Every object stands at every place of a small grid in front of each arm, in several headings, and its grasps are
//! ranked there for a pick: those that remain can be reached without collision. "Ten or more" can be read off for the
//! best and the median pose, and for an object that has fewer, why.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::known::{KnownObject, known_objects, scene};
use super::{GraspExperiment, GraspExperimentSettings};
use crate::experiment::ExperimentRefusal;
use crate::experiment::record::{Cell, Record};
use crate::experiment::summary::Summary;
use crate::grasp::{Grasp, GraspStatus, Touched};
use crate::parallel;
use crate::pipeline::{grasp_candidates, ranked, workcell};
use crate::scene::ArmChoice;
use crate::watch::Watch;

/// Grid of places, metres in front of the torso's axis and to the side of the acting arm.
const FORWARD_M: [f64; 2] = [0.44, 0.56];
const ASIDE_M: [f64; 2] = [0.12, 0.28];
/// Headings, degrees: the objects look alike from many sides.
const YAWS_DEG: [f64; 2] = [0.0, 45.0];
/// As many grasps are wanted in a pose.
pub const ENOUGH: usize = 10;

/// One robot, object and pose.
#[derive(Clone, Debug)]
pub struct FeasibleCase {
    /// Robot.
    pub robot: String,
    /// Object.
    pub object: String,
    /// Arm that acts.
    pub arm: &'static str,
    /// Place and heading: x, y in metres, yaw in radians.
    pub pose: [f64; 3],
    /// Candidates.
    pub candidates: usize,
    /// Candidates that the hand alone can take there.
    pub held: usize,
    /// Grasps that the arm reaches without collision.
    pub accepted: usize,
    /// Why the others are none: the statuses' names and counts, most frequent first.
    pub reasons: Vec<(&'static str, usize)>,
    /// Of the most frequent one, the first example in words.
    pub example: String,
}

/// One robot and object, all poses together.
#[derive(Clone, Debug)]
pub struct FeasibleRow {
    /// Robot.
    pub robot: String,
    /// Object.
    pub object: String,
    /// Poses.
    pub poses: usize,
    /// Poses with at least [`ENOUGH`] grasps.
    pub enough: usize,
    /// Grasps in a pose.
    pub accepted: Option<Summary>,
    /// Grasps in the best pose.
    pub best: FeasibleCase,
}

/// What the experiment gave.
#[derive(Clone, Debug)]
pub struct FeasibleOutcome {
    /// One row per robot and object.
    pub rows: Vec<FeasibleRow>,
    /// Every pose.
    pub cases: Vec<FeasibleCase>,
}

/// Runs the experiment; the outcome depends on the settings alone. Trials, clutter and serial runs mean nothing to it.
///
/// # Errors
/// [`ExperimentRefusal`] when there is nothing to do, an object or a robot cannot be used, or the caller stopped it.
pub fn run_feasible(
    settings: &GraspExperimentSettings,
    watch: Watch<'_>,
) -> Result<FeasibleOutcome, ExperimentRefusal> {
    settings.check(GraspExperiment::Grasps)?;
    let objects = known_objects(settings)?;
    let mut poses = Vec::new();
    for robot in &settings.robots {
        for object in &objects {
            for (arm, side) in [(ArmChoice::Left, 1.0), (ArmChoice::Right, -1.0)] {
                for x in FORWARD_M {
                    for y in ASIDE_M {
                        let pose = |yaw_deg: f64| (robot, object, arm, [x, side * y, yaw_deg.to_radians()]);
                        poses.extend(YAWS_DEG.map(pose));
                    }
                }
            }
        }
    }
    let done = AtomicUsize::new(0);
    let judged = parallel::map(&poses, |&(robot, object, arm, pose)| {
        let case = judge(settings, robot, object, arm, pose, watch)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        watch.progress(done as f64 / poses.len() as f64, &format!("{done} of {}", poses.len()));
        Ok(case)
    });
    let cases: Vec<FeasibleCase> = judged.into_iter().collect::<Result<_, ExperimentRefusal>>()?;
    let mut rows = Vec::new();
    for robot in &settings.robots {
        for object in &objects {
            let of_it: Vec<&FeasibleCase> =
                cases.iter().filter(|case| case.robot == *robot && case.object == object.name).collect();
            // The first of equally good ones.
            let better = |l: &&FeasibleCase, r: &&FeasibleCase| l.accepted.cmp(&r.accepted);
            let Some(best) = of_it.iter().rev().copied().max_by(better) else { continue };
            rows.push(FeasibleRow {
                robot: robot.clone(),
                object: object.name.clone(),
                poses: of_it.len(),
                enough: of_it.iter().filter(|case| case.accepted >= ENOUGH).count(),
                accepted: Summary::of(of_it.iter().map(|case| case.accepted as f64)),
                best: best.clone(),
            });
        }
    }
    Ok(FeasibleOutcome { rows, cases })
}

fn judge(
    settings: &GraspExperimentSettings,
    robot: &str,
    object: &KnownObject,
    arm: ArmChoice,
    pose: [f64; 3],
    watch: Watch<'_>,
) -> Result<FeasibleCase, ExperimentRefusal> {
    if watch.should_stop() {
        return Err(ExperimentRefusal::Stopped);
    }
    let X_WO = object.standing([pose[0], pose[1]], pose[2]);
    let scene = scene(robot, arm, object, X_WO, settings.seed);
    let fits = object.fits(&X_WO);
    let refused = |refusal: crate::job::Refusal| ExperimentRefusal::Setup { reason: refusal.message };
    let cell = workcell(&scene, &fits, &[], false, &settings.library).map_err(refused)?;
    let target = object.fit(&X_WO);
    let candidates = grasp_candidates(&cell, &target, Touched::Bodies, &scene.grasp).map_err(refused)?;
    let grasps = ranked(&cell, &candidates, &target, &scene, Watch::idle()).map_err(refused)?;
    let count = |grasps: &[Grasp]| grasps.iter().filter(|grasp| grasp.is_accepted()).count();
    let reasons = reasons(&grasps);
    let first = reasons.first().map(|(name, _)| *name);
    let example = grasps.iter().find(|grasp| Some(grasp.status.name()) == first);
    Ok(FeasibleCase {
        robot: robot.to_owned(),
        object: object.name.clone(),
        arm: arm.name(),
        pose,
        candidates: candidates.len(),
        held: count(&candidates),
        accepted: count(&grasps),
        example: example.map(|grasp| grasp.status.reason()).unwrap_or_default(),
        reasons,
    })
}

/// Names of the statuses of what was not accepted, most frequent first, equally frequent ones by name.
fn reasons(grasps: &[Grasp]) -> Vec<(&'static str, usize)> {
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    for grasp in grasps.iter().filter(|grasp| grasp.status != GraspStatus::Accepted) {
        *counts.entry(grasp.status.name()).or_default() += 1;
    }
    let mut reasons: Vec<(&'static str, usize)> = counts.into_iter().collect();
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    reasons
}

impl FeasibleCase {
    /// Why there are not more, in one line: `210 hits_table, 14 too_wide`.
    pub fn reasons_text(&self) -> String {
        let each = self.reasons.iter().map(|(name, count)| format!("{count} {name}"));
        each.collect::<Vec<_>>().join(", ")
    }
}

impl Record for FeasibleCase {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        vec![
            ("experiment", GraspExperiment::Grasps.name().into()),
            ("robot", self.robot.as_str().into()),
            ("object", self.object.as_str().into()),
            ("arm", self.arm.into()),
            ("x_m", self.pose[0].into()),
            ("y_m", self.pose[1].into()),
            ("yaw_rad", self.pose[2].into()),
            ("candidates", self.candidates.into()),
            ("held", self.held.into()),
            ("grasps_accepted", self.accepted.into()),
            ("rejected", self.reasons_text().into()),
            ("main_reason", (!self.example.is_empty()).then_some(self.example.as_str()).into()),
        ]
    }
}

impl Record for FeasibleRow {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let best = &self.best;
        vec![
            ("experiment", GraspExperiment::Grasps.name().into()),
            ("robot", self.robot.as_str().into()),
            ("object", self.object.as_str().into()),
            ("poses", self.poses.into()),
            ("poses_with_10", self.enough.into()),
            ("grasps_accepted_best", best.accepted.into()),
            ("grasps_accepted_mean", self.accepted.map(|s| s.mean).into()),
            ("grasps_accepted_median", self.accepted.map(|s| s.median).into()),
            ("best_arm", best.arm.into()),
            ("best_x_m", best.pose[0].into()),
            ("best_y_m", best.pose[1].into()),
            ("best_yaw_rad", best.pose[2].into()),
            ("best_candidates", best.candidates.into()),
            ("best_held", best.held.into()),
            ("best_rejected", best.reasons_text().into()),
            ("best_main_reason", (!best.example.is_empty()).then_some(best.example.as_str()).into()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::grasping::testing::settings;

    #[test]
    fn a_can_offers_ten_grasps_and_every_candidate_is_accounted_for() {
        let outcome = run_feasible(&settings(&["tomato_soup_can"]), Watch::idle()).unwrap();
        assert_eq!((outcome.rows.len(), outcome.cases.len()), (1, 16));
        for case in &outcome.cases {
            let rejected: usize = case.reasons.iter().map(|(_, count)| count).sum();
            assert_eq!(rejected + case.accepted, case.candidates);
            assert!(case.accepted <= case.held && case.held <= case.candidates);
        }
        let row = &outcome.rows[0];
        let most = outcome.cases.iter().map(|case| case.accepted).max().unwrap();
        assert!(row.best.accepted == most && most >= ENOUGH, "{row:?}");
        assert_eq!(row.enough, outcome.cases.iter().filter(|case| case.accepted >= ENOUGH).count());
    }
}
