//! One leg of a task with one arm: reach → close → lift → stop after stop → open → retreat (thesis chapter 5).
//!
//! Grasps are tried in the order of their rank. For each one the hand's straight ways are found first, since they
//! allow the least: away from the object before the grasp, up with it afterwards, down at the goal, back when it is
//! let go. Whatever is then left to do between them is searched, all ends of the straight ways being goals. The first
//! phase that cannot be done is the grasp's reason.

use super::motion::{Draft, Mover};
use super::phases::phases_with;
use super::ways_between::RoadmapOnce;
use super::{Certificate, Leg, MotionSettings, Phase, Plan, Route, Try, Workcell};
use crate::grasp::Grasp;
use crate::job::Refusal;
use crate::watch::Watch;

/// What is asked for.
pub struct LegTask<'a> {
    /// Robot, obstacles and object; its stops up to the first that lets go are this leg's.
    pub cell: &'a Workcell,
    /// Grasps in the order in which they are tried.
    pub ranked: &'a [Grasp],
    /// The only grasp to try, if somebody chose one.
    pub chosen: Option<u32>,
    /// Seed of the search.
    pub seed: u64,
}

/// A leg that can be done.
#[derive(Clone, Debug)]
pub struct LegPlan {
    /// The grasp and where the object goes.
    pub leg: Leg,
    /// Grasps tried before this one, and why each failed.
    pub tries: Vec<Try>,
    /// Routes of the hand that were looked at.
    pub routes: Vec<Route>,
    /// All joints at the end.
    pub q_end: Vec<f64>,
    pub(super) drafts: Vec<Draft>,
}

/// Plans a leg with the first grasp that allows it.
///
/// # Errors
/// A [`Refusal`] that says of every grasp that was tried in which phase it failed and why.
pub fn plan_leg(task: &LegTask<'_>, settings: &MotionSettings, watch: Watch<'_>) -> Result<LegPlan, Refusal> {
    let usable: Vec<&Grasp> = match task.chosen {
        None => task.ranked.iter().filter(|grasp| grasp.is_accepted()).take(settings.max_grasps).collect(),
        Some(id) => match task.ranked.iter().find(|grasp| grasp.id == id) {
            None => return Err(Refusal::new(format!("there is no grasp {id}"))),
            Some(grasp) if !grasp.is_accepted() => {
                return Err(Refusal::new(format!("grasp {id} cannot be used: {}", grasp.status.reason())));
            }
            Some(grasp) => vec![grasp],
        },
    };
    if usable.is_empty() {
        let message = format!("none of the {} grasps can be used at all places of the task", task.ranked.len());
        return Err(Refusal::new(message).with_details(reasons_of_rejected(task.ranked)));
    }
    let cell = task.cell;
    let mover = Mover { cell, settings, seed: task.seed, roadmap: RoadmapOnce::default(), watch };
    let mut tries: Vec<Try> = Vec::new();
    for grasp in usable {
        if watch.should_stop() {
            return Err(Refusal::new("stopped"));
        }
        match phases_with(&mover, grasp) {
            Ok(done) => {
                let mut q_end = cell.q_start.clone();
                let end = done.drafts.last().and_then(|draft| draft.trajectory.positions.last());
                for (dof, position) in moving_dofs(cell).zip(end.into_iter().flatten()) {
                    q_end[dof] = *position;
                }
                let leg = Leg {
                    arm: cell.arm().name.clone(),
                    tcp_link: cell.arm().hand.tcp_link,
                    grasp: grasp.clone(),
                    X_WO_start: cell.X_WO_start,
                    X_WO_end: done.X_WO_end,
                };
                return Ok(LegPlan { leg, tries, routes: done.routes, q_end, drafts: done.drafts });
            }
            Err(setback) => {
                let fingers = if setback.carries { &grasp.closed } else { &cell.hand.open };
                tries.push(setback.told(grasp.id, fingers));
            }
        }
    }
    let tried = tries.len();
    let plural = if tried == 1 { "grasp was" } else { "grasps were" };
    let refusal = Refusal::new(format!("no path: {tried} {plural} tried, none of them worked"));
    Err(Refusal { details: tries.iter().map(Try::to_string).collect(), tries, ..refusal })
}

/// Degrees of freedom of the arm, then of the hand.
fn moving_dofs(cell: &Workcell) -> impl Iterator<Item = usize> {
    cell.arm().dofs.iter().chain(cell.arm().hand.fingers.iter().flatten()).copied()
}

/// Why candidates were dropped, most frequent first.
fn reasons_of_rejected(grasps: &[Grasp]) -> Vec<String> {
    let mut counts: Vec<(&'static str, usize, String)> = Vec::new();
    for grasp in grasps {
        let kind = grasp.status.name();
        match counts.iter_mut().find(|(known, ..)| *known == kind) {
            Some((_, count, _)) => *count += 1,
            None => counts.push((kind, 1, grasp.status.reason())),
        }
    }
    counts.sort_by_key(|(_, count, _)| std::cmp::Reverse(*count));
    counts.into_iter().map(|(_, count, example)| format!("{count} × {example}")).collect()
}

/// Legs one after the other, each starting where the one before ends; `cell` is that of the first.
///
/// # Panics
/// If there is no leg.
pub fn assemble(cell: &Workcell, legs: Vec<LegPlan>) -> Plan {
    assert!(!legs.is_empty(), "a plan has a leg");
    let mut plan = Plan {
        legs: Vec::new(),
        phases: Vec::new(),
        q_start: cell.q_with_fingers(&cell.hand.open),
        dofs: moving_dofs(cell).collect(),
        tries: Vec::new(),
        routes: Vec::new(),
        handover: None,
        certificate: Certificate::default(),
    };
    let mut start_s = 0.0;
    for (leg, LegPlan { leg: done, tries, routes, drafts, .. }) in legs.into_iter().enumerate() {
        plan.legs.push(done);
        plan.tries.extend(tries);
        plan.routes.extend(routes);
        for Draft { kind, trajectory, carries, manipulability, clearance_m, closest } in drafts {
            let phase = Phase { kind, leg, start_s, trajectory, carries, manipulability, clearance_m, closest };
            start_s += phase.trajectory.duration_s();
            plan.phases.push(phase);
        }
    }
    plan
}
