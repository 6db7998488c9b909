//! From two arms, their maps and their grasps to a planned handover, or the reasons why there is none.

use std::borrow::Cow;

use nalgebra::{Isometry3, Translation3};

use super::choose::{Choice, Choices, Cost, Look, choose};
use super::effort::Effort;
use super::places::Way;
use super::report::{HandoverReport, Place};
use super::settings::PlaceChoice;
use super::side::{EndKind, Side};
use crate::grasp::{Grasp, Obstruction};
use crate::job::Refusal;
use crate::parallel;
use crate::reach::ReachMap;
use crate::task::{Exchange, Failure, MotionSettings, Partners, Plan, Try, certify, plan_exchange};
use crate::watch::Watch;

/// Configurations of the receiver's arm that are tried at one place.
const TRIED_POSTURES: usize = 2;

/// Shares of the wanted threshold with which places are looked for until there is a plan.
const THRESHOLD_SHARES: [f64; 3] = [1.0, 0.5, 0.1];

/// What is asked for.
pub struct HandoverTask<'a> {
    /// Both arms on one robot; the giver's workcell has the object at its start, the receiver's has its goal as the last
    /// stop, if there is one.
    pub partners: &'a Partners,
    /// Candidate grasps of giver and receiver, situated nowhere.
    pub grasps: [&'a [Grasp]; 2],
    /// Maps of their arms.
    pub maps: [&'a ReachMap; 2],
    /// The receiver lets the object go at its goal.
    pub lets_go: bool,
    /// How the place is chosen.
    pub choice: &'a PlaceChoice,
    /// How the arms move.
    pub motion: &'a MotionSettings,
    /// The part of the object that is its handle, if it has one: the receiver is offered that.
    pub handle: Option<usize>,
    /// What a posture of the receiver's arm costs a person.
    pub cost: &'a Cost<'a>,
    /// Seed of the searches.
    pub seed: u64,
}

/// Plans a handover at the best of the places that allow it.
///
/// # Errors
/// A [`Refusal`] that says which side has no grasp, that there is no place, or at which phase each place failed.
pub fn plan_handover(task: &HandoverTask<'_>, watch: Watch<'_>) -> Result<Plan, Refusal> {
    let Partners { giver, receiver } = task.partners;
    let goal = receiver.X_WO_goal();
    let refuse = |error: &dyn std::error::Error| Refusal::new(error.to_string());
    let start = (EndKind::Start, &[giver.X_WO_start][..]);
    let kind = if task.lets_go { EndKind::Goal } else { EndKind::Held };
    let end = (kind, receiver.stops.last().map_or(&[][..], |stop| &stop.poses_WO));
    let side = |k: usize, cell, end, effort| {
        Side::new(cell, Some(task.maps[k]), task.motion, task.grasps[k], end, effort).map_err(|error| refuse(&error))
    };
    let served = |side: &Side<'_>, k: usize, end: &str| {
        if !side.candidates.is_empty() {
            return Ok(());
        }
        let message =
            format!("none of the {} grasps of the {} arm serves the {end}", task.grasps[k].len(), side.cell.arm().name);
        Err(Refusal::new(message).with_details(counted(&side.rejected)))
    };
    let give = side(0, giver, start, Effort::Quick)?;
    served(&give, 0, "start")?;
    let mut sides = Sides { task, give, take: side(1, receiver, end, Effort::Quick)? };
    // Without a goal the object is drawn to the receiver.
    let towards = || Isometry3::from_parts(Translation3::from(sides.take.shoulder().coords), giver.X_WO_start.rotation);
    let way = Way { X_WO_start: giver.X_WO_start, X_WO_goal: goal.unwrap_or_else(towards) };
    let mut tries: Vec<Try> = Vec::new();
    let mut least: Option<Choices> = None;
    for effort in Effort::ALL {
        if watch.should_stop() {
            return Err(Refusal::new("stopped"));
        }
        if effort == Effort::Thorough {
            sides.take = side(1, receiver, end, effort)?;
        }
        if let Some(handle) = task.handle.filter(|_| task.choice.receiver_first) {
            // A stable sort: among the grasps of the handle and among the others the order stays.
            sides.take.candidates.sort_by_key(|candidate| candidate.grasp.part != handle);
        }
        let look = Look::new(task, [&sides.give, &sides.take], effort);
        // Where the best voxels have no place, less good ones may.
        for share in THRESHOLD_SHARES {
            let choice = PlaceChoice { threshold: share * task.choice.threshold, ..*task.choice };
            let should_stop = || watch.should_stop();
            let found = choose(&look, &way, &choice, &should_stop);
            if let Some(plan) = sides.plan_at(&found, &mut tries, watch)? {
                return Ok(plan);
            }
            least = Some(found);
        }
    }
    served(&sides.take, 1, "goal")?;
    Err(sides.refusal(&least.unwrap_or_default(), tries))
}

/// Both sides and what is asked of them.
struct Sides<'a> {
    task: &'a HandoverTask<'a>,
    give: Side<'a>,
    take: Side<'a>,
}

impl Sides<'_> {
    /// A plan at the first of the places that allows one; what fails is added to the tries.
    fn plan_at(&self, found: &Choices, tries: &mut Vec<Try>, watch: Watch<'_>) -> Result<Option<Plan>, Refusal> {
        let Self { task, give, take } = self;
        // A choice is only made of grasps that serve their end.
        let taking = |choice: &Choice| take.serving(&take.candidates[choice.candidates[1]]);
        let choices = found.choices.iter().take(task.motion.max_grasps).map(|choice| (choice, taking(choice)));
        let tasks: Vec<(usize, &Choice, Grasp, &Vec<f64>)> = choices
            .enumerate()
            .filter_map(|(index, (choice, taking))| Some((index, choice, taking?)))
            .flat_map(|(index, choice, taking)| {
                let postures = choice.q[1].iter().take(TRIED_POSTURES);
                postures.map(move |q_take| (index, choice, taking.clone(), q_take))
            })
            .collect();
        let tried = parallel::first(&tasks, |(index, choice, taking, q_take), is_beaten| {
            let should_stop = || is_beaten() || watch.should_stop();
            let exchange = Exchange {
                partners: task.partners,
                give: &give.candidates[choice.candidates[0]].grasp,
                take: taking,
                X_WO: choice.X_WO,
                q_give: &choice.q[0],
                q_take,
                lets_go: task.lets_go,
                hand_speed_m_s: task.choice.hand_speed_m_s,
                seed: task.seed,
            };
            plan_exchange(&exchange, task.motion, watch.stopping_when(&should_stop)).map_err(|failure| {
                let Failure { leg, tried } = *failure;
                let who = [give, take][leg].cell.arm().name.clone();
                Box::new((*index, Try { arm: Some(who), X_WO: Some(choice.X_WO), ..tried }))
            })
        });
        if watch.should_stop() {
            return Err(Refusal::new("stopped"));
        }
        let mut refused: Vec<Option<String>> = vec![None; found.choices.len()];
        for (index, tried) in tried.failed.into_iter().map(|failed| *failed) {
            refused[index].get_or_insert_with(|| format!("{}: {tried}", tried.arm.as_deref().unwrap_or_default()));
            tries.push(tried);
        }
        let Some((number, mut plan)) = tried.worked else { return Ok(None) };
        certify(&mut plan, &|plan, phase| Cow::Owned(task.partners.during(plan, phase)))?;
        plan.tries = std::mem::take(tries);
        plan.handover = Some(Box::new(self.report(found, refused, tasks[number].0)));
        Ok(Some(plan))
    }

    fn report(&self, found: &Choices, refused: Vec<Option<String>>, chosen: usize) -> HandoverReport {
        let sides = [&self.give, &self.take];
        let places = found.choices.iter().zip(refused);
        HandoverReport {
            arms: sides.map(|side| side.cell.arm().name.clone()),
            shoulders: sides.map(Side::shoulder),
            voxel_m: self.task.maps[1].voxel_m(),
            grasps: sides.map(|side| side.candidates.len()),
            voxels: found.voxels,
            places: places.map(|(choice, refused)| place(choice, sides, refused)).collect(),
            chosen,
        }
    }

    fn refusal(&self, found: &Choices, tries: Vec<Try>) -> Refusal {
        if tries.is_empty() {
            return no_place(&self.give, &self.take, found);
        }
        let plural = if tries.len() == 1 { "try" } else { "tries" };
        let message = format!("no handover: {} {plural}, none of them worked", tries.len());
        let told = |tried: &Try| format!("{}: {tried}", tried.arm.as_deref().unwrap_or_default());
        Refusal { message, details: tries.iter().map(told).collect(), tries }
    }
}

fn place(choice: &Choice, sides: [&Side<'_>; 2], refused: Option<String>) -> Place {
    let id = |k: usize| sides[k].candidates[choice.candidates[k]].grasp.id;
    Place {
        voxel: choice.spot.voxel,
        X_WO: choice.X_WO,
        grasps: [id(0), id(1)],
        m_g: choice.m_g,
        off_line_rad: choice.off_line_rad,
        off_way_m: choice.spot.off_way_m,
        by_handle: choice.by_handle,
        comfort: choice.comfort,
        score: choice.score,
        refused,
    }
}

/// Reasons with how often each occurs, most frequent first.
fn counted(reasons: &[Obstruction]) -> Vec<String> {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for reason in reasons.iter().map(ToString::to_string) {
        match counts.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => counts.push((reason, 1)),
        }
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts.into_iter().map(|(reason, count)| format!("{count} × {reason}")).collect()
}

fn no_place(give: &Side<'_>, take: &Side<'_>, found: &Choices) -> Refusal {
    let names = [&give.cell.arm().name, &take.cell.arm().name];
    let apart_m = (give.shoulder() - take.shoulder()).norm();
    if found.voxels == 0 {
        let [giver, receiver] = names;
        return Refusal::new(format!(
            "the {giver} and the {receiver} arm reach no place together: their shoulders are {apart_m:.2} m apart"
        ));
    }
    let message = format!(
        "no place for a handover: {} places in {} voxels that both hands reach were looked at",
        found.looked_at, found.voxels
    );
    let [giver, receiver] = [give, take].map(|side| side.candidates.len());
    let details = vec![format!("{giver} grasps of the {} arm, {receiver} of the {} arm in each", names[0], names[1])];
    Refusal::new(message).with_details(details)
}
