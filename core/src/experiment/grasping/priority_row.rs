//! What became of the cases of Table 5.1, one by one and by order.

use super::cases::Case;
use super::{Condition, GraspExperiment, ThesisPriority, thesis_priority};
use crate::experiment::record::{Cell, Record};
use crate::experiment::summary::{Summary, wilson_percent};
use crate::grasp::{Grasp, RankBy};
use crate::job::Refusal;

/// Why a case was set aside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excluded {
    /// The hand alone can take none of the grasps where the object stands.
    Hand,
    /// No grasp can be reached at the start.
    Start,
    /// No grasp can be used at both poses.
    Goal,
    /// Grasps can be used at both poses, but with none of them all paths are found.
    Path,
}

impl Excluded {
    /// All reasons.
    const ALL: [Self; 4] = [Self::Hand, Self::Start, Self::Goal, Self::Path];

    /// The reason in a few words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hand => "hand cannot hold it",
            Self::Start => "no grasp at the start",
            Self::Goal => "no grasp for both poses",
            Self::Path => "no path with any grasp",
        }
    }
}

/// How many cases were set aside, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExcludedCounts {
    /// [`Excluded::Hand`].
    pub hand: usize,
    /// [`Excluded::Start`].
    pub start: usize,
    /// [`Excluded::Goal`].
    pub goal: usize,
    /// [`Excluded::Path`].
    pub path: usize,
}

impl ExcludedCounts {
    fn of(cases: &[PriorityCase]) -> Self {
        let [hand, start, goal, path] =
            Excluded::ALL.map(|reason| cases.iter().filter(|case| case.excluded == Some(reason)).count());
        Self { hand, start, goal, path }
    }

    /// All of them.
    pub fn total(self) -> usize {
        self.hand + self.start + self.goal + self.path
    }
}

/// Where a plan with a grasp failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Setback {
    /// Name of the phase.
    pub(super) phase: String,
    /// Why.
    pub(super) reason: String,
}

impl Setback {
    /// What a refusal says of its only grasp.
    pub(super) fn of(refusal: &Refusal) -> Self {
        let tried = refusal.tries.first();
        let phase = tried.and_then(|tried| tried.phase).map_or_else(String::new, |phase| phase.name().to_owned());
        let reason = tried.map_or(&refusal.message, |tried| &tried.reason).clone();
        Self { phase, reason }
    }
}

/// A case under one order, or a case that was set aside.
#[derive(Clone, Debug)]
pub struct PriorityCase {
    /// Robot.
    pub robot: String,
    /// What changes from start to goal.
    pub condition: Condition,
    /// Number of the draw.
    pub case: usize,
    /// Arm that acts.
    pub arm: &'static str,
    /// Object.
    pub object: String,
    /// Place and heading at the start: x, y in metres, yaw in radians.
    pub start: [f64; 3],
    /// Place and heading at the goal.
    pub goal: [f64; 3],
    /// Candidates.
    pub candidates: usize,
    /// Grasps that can be used at both poses.
    pub accepted: usize,
    /// Why it was set aside, if it was; then there is no order.
    pub excluded: Option<Excluded>,
    /// The order.
    pub metric: Option<RankBy>,
    /// The grasp that the order puts first.
    pub grasp: Option<u32>,
    /// Its m_g at the start.
    pub m_g_start: Option<f64>,
    /// Its m_g at the goal.
    pub m_g_goal: Option<f64>,
    /// Where it failed, if it did; for a case without a path, where the first grasp of the first order failed.
    pub(super) setback: Option<Setback>,
    /// Grasps tried until one worked, that one included, or until there was none left.
    pub tried: usize,
    /// Planning time of all of them, seconds; `None` when cases ran side by side.
    pub planning_time_s: Option<f64>,
}

impl PriorityCase {
    /// What is known before an order is chosen.
    pub(super) fn blank(
        robot: &str,
        condition: Condition,
        number: usize,
        case: &Case,
        object: &str,
        grasps: &[Grasp],
    ) -> Self {
        Self {
            robot: robot.to_owned(),
            condition,
            case: number,
            arm: case.scene.arm.name(),
            object: object.to_owned(),
            start: case.start,
            goal: case.goal,
            candidates: grasps.len(),
            accepted: grasps.iter().filter(|grasp| grasp.is_accepted()).count(),
            excluded: None,
            metric: None,
            grasp: None,
            m_g_start: None,
            m_g_goal: None,
            setback: None,
            tried: 0,
            planning_time_s: None,
        }
    }

    /// Whether the grasp that the order puts first yields both paths.
    pub fn is_one_shot(&self) -> bool {
        self.excluded.is_none() && self.setback.is_none()
    }
}

impl Record for PriorityCase {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let is_solved = self.excluded.is_none();
        let setback = self.setback.as_ref();
        vec![
            ("experiment", GraspExperiment::Prioritization.name().into()),
            ("condition", self.condition.name().into()),
            ("robot", self.robot.as_str().into()),
            ("case", self.case.into()),
            ("arm", self.arm.into()),
            ("object", self.object.as_str().into()),
            ("start_x_m", self.start[0].into()),
            ("start_y_m", self.start[1].into()),
            ("start_yaw_rad", self.start[2].into()),
            ("goal_x_m", self.goal[0].into()),
            ("goal_y_m", self.goal[1].into()),
            ("goal_yaw_rad", self.goal[2].into()),
            ("candidates", self.candidates.into()),
            ("grasps_accepted", self.accepted.into()),
            ("excluded", self.excluded.map(Excluded::name).into()),
            ("metric", self.metric.map(RankBy::name).into()),
            ("grasp", self.grasp.map(|id| id as usize).into()),
            ("m_g_start", self.m_g_start.into()),
            ("m_g_goal", self.m_g_goal.into()),
            ("success", is_solved.then(|| self.is_one_shot()).into()),
            ("failed_phase", setback.map(|setback| setback.phase.as_str()).into()),
            ("reason", setback.map(|setback| setback.reason.as_str()).into()),
            ("tried", (self.tried > 0).then_some(self.tried).into()),
            ("planning_time_s", self.planning_time_s.into()),
        ]
    }
}

/// The cases of one robot and condition under one order.
#[derive(Clone, Debug)]
pub struct PriorityRow {
    /// Robot.
    pub robot: String,
    /// What changes from start to goal.
    pub condition: Condition,
    /// The order.
    pub metric: RankBy,
    /// Cases that can be solved.
    pub trials: usize,
    /// Cases in which the first grasp yields both paths.
    pub success: usize,
    /// Wilson's interval of the success, 95 %, percent.
    pub success_interval_percent: [f64; 2],
    /// Planning time until a grasp worked, seconds; `None` when cases ran side by side.
    pub planning_time_s: Option<Summary>,
    /// Grasps tried until one worked.
    pub tried: Option<Summary>,
    /// Grasps that can be used at both poses.
    pub accepted: Option<Summary>,
    /// Cases that were set aside.
    pub excluded: ExcludedCounts,
    /// The thesis's numbers for the same row.
    pub thesis: Option<ThesisPriority>,
}

impl PriorityRow {
    /// The rows of the cases of one robot and condition.
    pub(super) fn of(cases: &[PriorityCase], is_timed: bool) -> Vec<Self> {
        let excluded = ExcludedCounts::of(cases);
        let row = |metric: RankBy| {
            let chosen: Vec<&PriorityCase> = cases.iter().filter(|case| case.metric == Some(metric)).collect();
            let first = chosen.first()?;
            let success = chosen.iter().filter(|case| case.is_one_shot()).count();
            let summary = |of: fn(&PriorityCase) -> f64| Summary::of(chosen.iter().map(|case| of(case)));
            let time_s = summary(|case| case.planning_time_s.unwrap_or(0.0));
            Some(Self {
                robot: first.robot.clone(),
                condition: first.condition,
                metric,
                trials: chosen.len(),
                success,
                success_interval_percent: wilson_percent(success, chosen.len()),
                planning_time_s: time_s.filter(|_| is_timed),
                tried: summary(|case| case.tried as f64),
                accepted: summary(|case| case.accepted as f64),
                excluded,
                thesis: thesis_priority(first.condition, metric),
            })
        };
        RankBy::ALL.into_iter().filter_map(row).collect()
    }

    /// Share of the cases in which the first grasp yields both paths, percent.
    pub fn success_percent(&self) -> f64 {
        100.0 * self.success as f64 / self.trials.max(1) as f64
    }
}

impl Record for PriorityRow {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        let mut cells: Vec<(&'static str, Cell)> = vec![
            ("experiment", GraspExperiment::Prioritization.name().into()),
            ("condition", self.condition.name().into()),
            ("robot", self.robot.as_str().into()),
            ("metric", self.metric.name().into()),
            ("trials", self.trials.into()),
            ("success", self.success.into()),
            ("success_percent", self.success_percent().into()),
            ("success_low_percent", self.success_interval_percent[0].into()),
            ("success_high_percent", self.success_interval_percent[1].into()),
        ];
        let mut summary = |names: [&'static str; 3], of: &Option<Summary>| {
            let values = [of.map(|s| s.mean), of.map(|s| s.median), of.map(|s| s.p95)];
            cells.extend(names.into_iter().zip(values.map(Cell::from)));
        };
        summary(["planning_time_mean_s", "planning_time_median_s", "planning_time_p95_s"], &self.planning_time_s);
        summary(["tried_mean", "tried_median", "tried_p95"], &self.tried);
        summary(["grasps_accepted_mean", "grasps_accepted_median", "grasps_accepted_p95"], &self.accepted);
        let thesis = self.thesis.as_ref();
        cells.extend([
            ("excluded", Cell::from(self.excluded.total())),
            ("excluded_hand", self.excluded.hand.into()),
            ("excluded_start", self.excluded.start.into()),
            ("excluded_goal", self.excluded.goal.into()),
            ("excluded_path", self.excluded.path.into()),
            ("thesis_trials", thesis.map(|row| row.trials).into()),
            ("thesis_success", thesis.map(|row| row.success).into()),
            ("thesis_planning_time_s", thesis.map(|row| row.planning_time_s).into()),
        ]);
        cells
    }
}
