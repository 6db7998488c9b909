//! Pick and place with one arm: reach → close → lift → transport → place → open → retreat (thesis chapter 5).
//!
//! Grasps are tried in the order of their rank. For each one the hand's straight ways are found first, since they
//! allow the least: away from the object before the grasp, up with it afterwards, down at the goal, back when it is
//! let go. Whatever is then left to do between them is searched by the IK-BiRRT, all ends of the straight ways being
//! goals. The first phase that cannot be done is the grasp's reason.

use nalgebra::{Isometry3, Translation3};

use super::motion::{Draft, Mover, joined, reversed};
use super::{Certificate, Leg, MotionSettings, Phase, PhaseKind, Plan, Situation, Try, Workcell};
use crate::collision::CollisionError;
use crate::grasp::{Grasp, Situated};
use crate::job::Refusal;
use crate::plan::{ArmSpace, Path};
use crate::watch::Watch;

/// What is asked for.
pub struct PickAndPlace<'a> {
    /// Robot, obstacles and object.
    pub cell: &'a Workcell,
    /// Grasps in the order in which they are tried.
    pub ranked: &'a [Grasp],
    /// The only grasp to try, if somebody chose one.
    pub chosen: Option<u32>,
    /// Seed of the search.
    pub seed: u64,
}

/// Plans the task with the first grasp that allows it.
///
/// # Errors
/// A [`Refusal`] whose details say of every grasp that was tried in which phase it failed and why.
pub fn plan_pick_and_place(
    task: &PickAndPlace<'_>,
    settings: &MotionSettings,
    watch: Watch<'_>,
) -> Result<Plan, Refusal> {
    let refusal = |message: String, details: Vec<String>| Refusal::new(message).with_details(details);
    let usable: Vec<&Grasp> = match task.chosen {
        None => task.ranked.iter().filter(|grasp| grasp.is_accepted()).take(settings.max_grasps).collect(),
        Some(id) => match task.ranked.iter().find(|grasp| grasp.id == id) {
            None => return Err(refusal(format!("there is no grasp {id}"), Vec::new())),
            Some(grasp) if !grasp.is_accepted() => {
                return Err(refusal(format!("grasp {id} cannot be used: {}", grasp.status.reason()), Vec::new()));
            }
            Some(grasp) => vec![grasp],
        },
    };
    if usable.is_empty() {
        let message = format!("none of the {} grasps can be used at both poses", task.ranked.len());
        return Err(refusal(message, reasons_of_rejected(task.ranked)));
    }
    let mut failed: Vec<Try> = Vec::new();
    for grasp in usable {
        if watch.should_stop() {
            return Err(refusal("stopped".into(), Vec::new()));
        }
        match plan_with(task, grasp, settings, watch) {
            Ok(phases) => return Ok(assemble(task.cell, settings, grasp, phases, failed)),
            Err(Setback { phase, reason }) => failed.push(Try {
                grasp: Some(grasp.id),
                phase: Some(phase),
                reason,
                culprits: Vec::new(),
                q: Vec::new(),
                carries: false,
            }),
        }
    }
    let tried = failed.len();
    let plural = if tried == 1 { "grasp was" } else { "grasps were" };
    let details = failed.iter().map(Try::to_string).collect();
    let refused = refusal(format!("no path: {tried} {plural} tried, none of them worked"), details);
    Err(Refusal { tries: failed, ..refused })
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

/// The phase that could not be done, and why.
struct Setback {
    phase: PhaseKind,
    reason: String,
}

fn plan_with(
    task: &PickAndPlace<'_>,
    grasp: &Grasp,
    settings: &MotionSettings,
    watch: Watch<'_>,
) -> Result<Vec<Draft>, Setback> {
    use PhaseKind::{Close, Lift, Open, Place, Reach, Retreat, Transport};
    let (cell, X_OH) = (task.cell, &grasp.X_OH);
    let mover = Mover { cell, settings, seed: task.seed, watch };
    let space = |phase: PhaseKind, situation: Result<Situation, CollisionError>| {
        let checker = situation.and_then(|situation| cell.checker(&situation));
        let space = checker.and_then(|checker| ArmSpace::new(&cell.robot, cell.arm_index, checker));
        space.map_err(|error| Setback { phase, reason: error.to_string() })
    };
    let approaching = space(Reach, cell.approaching(&cell.X_WO_start))?;
    let lifting = space(Lift, cell.carrying(grasp, &cell.supports(&cell.X_WO_start)))?;
    let X_WH_start = cell.X_WO_start * X_OH;
    let picks = straight_ways(&mover, grasp.start.as_ref(), &X_WH_start, (Reach, &approaching), (Lift, &lifting))?;

    let goals: Vec<Vec<f64>> = picks.iter().filter_map(|ways| ways.back.points.last().cloned()).collect();
    let arm_start: Vec<f64> = cell.arm().dofs.iter().map(|&dof| cell.q_start[dof]).collect();
    let (reach, chosen) = mover.search(&approaching, &arm_start, &goals).map_err(setback(Reach))?;
    let pick = &picks[chosen];
    let reach = joined(&reach, &reversed(&pick.back));
    let (open, closed) = (&cell.hand.open, &grasp.closed);
    let mut drafts = vec![
        mover.along(Reach, &approaching, &reach, open, false).map_err(setback(Reach))?,
        mover.fingers(Close, &lifting, &pick.grasp, open, closed),
        mover.along(Lift, &lifting, &pick.rise, closed, true).map_err(setback(Lift))?,
    ];
    let Some(X_WO_goal) = cell.X_WO_goal else { return Ok(drafts) };

    let leaving = space(Retreat, cell.approaching(&X_WO_goal))?;
    let placing = space(Place, cell.carrying(grasp, &cell.supports(&X_WO_goal)))?;
    let X_WH_goal = X_WO_goal * X_OH;
    let places = straight_ways(&mover, grasp.goal.as_ref(), &X_WH_goal, (Retreat, &leaving), (Place, &placing))?;

    let carrying = space(Transport, cell.carrying(grasp, &[]))?;
    let goals: Vec<Vec<f64>> = places.iter().filter_map(|ways| ways.rise.points.last().cloned()).collect();
    let lifted = pick.rise.points.last().unwrap_or(&pick.grasp);
    let (transport, chosen) = mover.search(&carrying, lifted, &goals).map_err(setback(Transport))?;
    let place = &places[chosen];
    drafts.push(mover.along(Transport, &carrying, &transport, closed, true).map_err(setback(Transport))?);
    drafts.push(mover.along(Place, &placing, &reversed(&place.rise), closed, true).map_err(setback(Place))?);
    drafts.push(mover.fingers(Open, &leaving, &place.grasp, closed, open));
    drafts.push(mover.along(Retreat, &leaving, &place.back, open, false).map_err(setback(Retreat))?);
    Ok(drafts)
}

fn setback(phase: PhaseKind) -> impl Fn(String) -> Setback {
    move |reason| Setback { phase, reason }
}

/// The straight ways from one configuration that grasps the object.
struct Ways {
    /// Where the hand holds the object.
    grasp: Vec<f64>,
    /// Backwards along the approach, with open fingers.
    back: Path,
    /// Upwards, with the object.
    rise: Path,
}

/// Straight ways from the configurations of an IK set that promise them; the first obstacle met is the reason if none
/// has both.
fn straight_ways(
    mover: &Mover<'_>,
    situated: Option<&Situated>,
    X_WH: &Isometry3<f64>,
    (back_phase, open): (PhaseKind, &ArmSpace),
    (rise_phase, carrying): (PhaseKind, &ArmSpace),
) -> Result<Vec<Ways>, Setback> {
    let mut found = Vec::new();
    let mut first = Setback { phase: back_phase, reason: "no configuration of the arm".into() };
    let tried = situated.into_iter().flat_map(|set| set.with_ways.iter().map(|&index| &set.solutions[index]));
    for (index, q) in tried.enumerate() {
        let back = mover.back_off(open, q, X_WH).map_err(setback(back_phase));
        let rise =
            back.and_then(|back| mover.rise(carrying, q, X_WH).map(|rise| (back, rise)).map_err(setback(rise_phase)));
        match rise {
            Ok((back, rise)) => found.push(Ways { grasp: q.to_vec(), back, rise }),
            Err(reason) if index == 0 => first = reason,
            Err(_) => {}
        }
    }
    if found.is_empty() {
        first.reason = format!("no straight way: {}", first.reason);
        return Err(first);
    }
    Ok(found)
}

/// Phases one after the other.
fn assemble(cell: &Workcell, settings: &MotionSettings, grasp: &Grasp, drafts: Vec<Draft>, tries: Vec<Try>) -> Plan {
    let arm = cell.arm();
    let mut start_s = 0.0;
    let phases: Vec<Phase> = drafts
        .into_iter()
        .map(|draft| {
            let Draft { kind, trajectory, carries, manipulability, clearance_m } = draft;
            let phase = Phase { kind, leg: 0, start_s, trajectory, carries, manipulability, clearance_m };
            start_s += phase.trajectory.duration_s();
            phase
        })
        .collect();
    let X_WO_lifted = Translation3::new(0.0, 0.0, settings.lift_m) * cell.X_WO_start;
    Plan {
        arm: arm.name.clone(),
        legs: vec![Leg {
            grasp: grasp.clone(),
            X_WO_start: cell.X_WO_start,
            X_WO_end: cell.X_WO_goal.unwrap_or(X_WO_lifted),
        }],
        phases,
        q_start: cell.q_with_fingers(&cell.hand.open),
        dofs: arm.dofs.iter().chain(arm.hand.fingers.iter().flatten()).copied().collect(),
        tcp_link: arm.hand.tcp_link,
        tries,
        routes: Vec::new(),
        certificate: Certificate::default(),
    }
}
