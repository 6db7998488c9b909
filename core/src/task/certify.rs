//! Every plan is walked once more before it is given out.

use std::borrow::Cow;

use super::{Certificate, Plan, Try, Workcell};
use crate::collision::{CollisionError, Scratch};
use crate::job::Refusal;
use crate::parallel;

/// Configurations per sample of the trajectories.
const DENSITY: usize = 4;

/// The workcell in which a phase of a plan happens.
pub type CellOf<'a> = dyn Fn(&Plan, usize) -> Cow<'a, Workcell> + Sync + 'a;

/// Walks all motions of a plan at four configurations per sample and writes down how many there were.
///
/// Every motion was proven free when it was planned; this looks at what came out in the end, phase by phase with the
/// bodies of that phase, so that a slip in between cannot pass unnoticed.
///
/// # Errors
/// A [`Refusal`] that shows where something touches.
pub fn certify(plan: &mut Plan, cell_of: &CellOf<'_>) -> Result<(), Refusal> {
    let numbers: Vec<usize> = (0..plan.phases.len()).collect();
    let walked = parallel::map(&numbers, |&number| -> Result<Result<usize, Try>, CollisionError> {
        let phase = &plan.phases[number];
        if phase.kind.is_of_fingers() {
            return Ok(Ok(0));
        }
        let cell = cell_of(plan, number);
        let column = |dof: &usize| plan.dofs.iter().position(|column| column == dof);
        let columns: Vec<usize> = cell.arm().dofs.iter().filter_map(column).collect();
        let leg = &plan.legs[phase.leg];
        let checker = cell.checker(&cell.situation(phase.kind, leg)?)?;
        let positions = &phase.trajectory.positions;
        let mut walk: Vec<Vec<f64>> = Vec::with_capacity(DENSITY * positions.len());
        for (index, from) in positions.iter().enumerate() {
            let to = positions.get(index + 1).unwrap_or(from);
            for step in 0..DENSITY {
                let u = step as f64 / DENSITY as f64;
                walk.push(columns.iter().map(|&k| from[k] + (to[k] - from[k]) * u).collect());
            }
        }
        if let Some((index, hit)) = checker.first_hit_of_all(&mut Scratch::default(), &walk) {
            let fingers = cell.arm().hand.fingers.iter().flatten().filter_map(column);
            let fingers = fingers.map(|k| positions[index / DENSITY][k]);
            return Ok(Err(Try {
                grasp: Some(leg.grasp.id),
                phase: Some(phase.kind),
                reason: format!("{hit} when the finished motion is walked again"),
                culprits: vec![hit.a, hit.b],
                q: walk[index].iter().copied().chain(fingers).collect(),
                carries: phase.carries,
                arm: Some(leg.arm.clone()),
                X_WO: None,
            }));
        }
        Ok(Ok(walk.len()))
    });
    let mut states = 0;
    for phase in walked {
        match phase.map_err(|error| Refusal::new(error.to_string()))? {
            Ok(count) => states += count,
            Err(found) => {
                let refusal = Refusal::new("a planned motion touches something when it is walked again");
                return Err(Refusal { details: vec![found.to_string()], tries: vec![found], ..refusal });
            }
        }
    }
    plan.certificate = Certificate { states, density: DENSITY };
    Ok(())
}
