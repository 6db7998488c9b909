//! A whole task: leg after leg, each with its own grasp, and put down in between where no single grasp serves.

use std::borrow::Cow;

use nalgebra::Isometry3;

use super::rank::{grasp_candidates, ranked};
use super::regrasp::between;
use crate::fit::Fit;
use crate::grasp::{Grasp, Touched};
use crate::job::Refusal;
use crate::scene::Scene;
use crate::task::{LegPlan, LegTask, Plan, Stop, Workcell, assemble, certify, plan_leg};
use crate::watch::Watch;

/// Most places that are tried for putting the object down in between.
const MAX_BETWEEN: usize = 4;

/// What a task is planned from.
pub(crate) struct TaskInput<'a> {
    pub(crate) cell: &'a Workcell,
    /// Candidates, ranked for the first leg.
    pub(crate) ranked: &'a [Grasp],
    /// The only grasp to try in the first leg, if somebody chose one.
    pub(crate) chosen: Option<u32>,
    pub(crate) target: &'a Fit,
    /// What fingers close on.
    pub(crate) touched: &'a dyn Fn() -> Result<Touched, Refusal>,
    pub(crate) scene: &'a Scene,
    pub(crate) watch: Watch<'a>,
}

impl TaskInput<'_> {
    /// Plans all legs of the task.
    ///
    /// # Errors
    /// The [`Refusal`] of the leg that cannot be done.
    pub(crate) fn plan(&self) -> Result<Plan, Refusal> {
        let cell = self.cell;
        let first = LegTask { cell, ranked: self.ranked, chosen: self.chosen, seed: self.scene.seed };
        let mut legs = match plan_leg(&first, &self.scene.motion, self.watch) {
            Ok(leg) => vec![leg],
            Err(refusal) => self.regrasped(refusal)?,
        };
        let mut rest = &cell.stops[cell.leg().len()..];
        while let (false, Some(last)) = (rest.is_empty(), legs.last()) {
            let cell = cell.later(last.leg.X_WO_end, rest, last.q_end.clone());
            legs.push(self.later_leg(&cell)?);
            rest = &rest[cell.leg().len()..];
        }
        let mut plan = assemble(cell, legs);
        certify(&mut plan, &|_, _| Cow::Borrowed(cell))?;
        Ok(plan)
    }

    /// A leg that starts where an earlier one ended: grasps are looked for anew.
    fn later_leg(&self, cell: &Workcell) -> Result<LegPlan, Refusal> {
        let grasps = grasp_candidates(cell, self.target, (self.touched)()?, &self.scene.grasp)?;
        let ranked = ranked(cell, &grasps, self.target, self.scene, self.watch)?;
        let task = LegTask { cell, ranked: &ranked, chosen: None, seed: self.scene.seed };
        plan_leg(&task, &self.scene.motion, self.watch)
    }

    /// The first leg as two: to a place in between, and on from there with another grasp.
    fn regrasped(&self, refusal: Refusal) -> Result<Vec<LegPlan>, Refusal> {
        let cell = self.cell;
        let puts_it_down = cell.leg().last().is_some_and(Stop::lets_go);
        if !self.scene.motion.regrasp || self.chosen.is_some() || !puts_it_down || self.watch.should_stop() {
            return Err(refusal);
        }
        let mut details = refusal.details.clone();
        let mut tries = refusal.tries.clone();
        for X_WO in between(cell, self.target, self.ranked, self.scene)?.into_iter().take(MAX_BETWEEN) {
            if self.watch.should_stop() {
                return Err(Refusal::new("stopped"));
            }
            match self.over(X_WO) {
                Ok(mut legs) => {
                    legs[0].tries.splice(0..0, tries);
                    return Ok(legs);
                }
                Err(Refusal { message, tries: more, .. }) => {
                    let p = X_WO.translation.vector;
                    details.push(format!("put down in between at {:.2}, {:.2} m: {message}", p.x, p.y));
                    tries.extend(more);
                }
            }
        }
        details.push("putting it down in between and grasping it anew does not help".to_owned());
        Err(Refusal { message: refusal.message, details, tries })
    }

    /// Two legs over a place in between.
    fn over(&self, X_WO: Isometry3<f64>) -> Result<Vec<LegPlan>, Refusal> {
        let cell = self.cell;
        let stop = Stop { poses_WO: vec![X_WO], ..Stop::put() };
        let there = cell.later(cell.X_WO_start, &[stop], cell.q_start.clone());
        let ranked = ranked(&there, &untried(self.ranked), self.target, self.scene, self.watch)?;
        let task = LegTask { cell: &there, ranked: &ranked, chosen: None, seed: self.scene.seed };
        let first = plan_leg(&task, &self.scene.motion, self.watch)?;
        let on = self.later_leg(&cell.later(X_WO, cell.leg(), first.q_end.clone()))?;
        Ok(vec![first, on])
    }
}

/// Candidates as they were before they were situated.
fn untried(ranked: &[Grasp]) -> Vec<Grasp> {
    let mut grasps: Vec<Grasp> = ranked.to_vec();
    grasps.iter_mut().for_each(Grasp::forget_places);
    grasps.sort_by_key(|grasp| grasp.id);
    grasps
}
