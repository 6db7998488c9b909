//! The phases of a leg with one grasp.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::motion::{Draft, Mover, joined, reversed};
use super::setback::{Blocked, Setback};
use super::ways::{Ways, picks, pours, slides, upright_again};
use super::ways_between::Found;
use super::{PhaseKind, Planner, Route, Situation, Stop};
use crate::collision::{CollisionError, World};
use crate::grasp::{Grasp, Situated};
use crate::plan::{ArmSpace, Path, Upright};
use crate::scene::Action;

/// The phases of a leg, untimed as a whole.
pub(super) struct Done {
    pub(super) drafts: Vec<Draft>,
    pub(super) X_WO_end: Isometry3<f64>,
    pub(super) routes: Vec<Route>,
}

/// The phases of the leg's stops with a grasp.
pub(super) fn phases_with(mover: &Mover<'_>, grasp: &Grasp) -> Result<Done, Setback> {
    let mut leg = LegWith::new(mover, grasp);
    let stops = mover.cell.leg();
    let sets: Vec<&Situated> = grasp.stops().collect();
    if sets.len() != stops.len() {
        let found = sets.len();
        let reason = format!("the grasp was looked at for {found} stops, the task has {}", stops.len());
        return Err(Blocked::because(reason).in_phase(PhaseKind::Reach, false));
    }
    if let (Some(Action::Slide), Some(set)) = (stops.first().map(|stop| stop.action), sets.first()) {
        leg.slide(set)?;
        return Ok(Done { drafts: leg.drafts, X_WO_end: set.X_WO, routes: leg.routes });
    }
    let grips = leg.grips()?;
    let all: Vec<usize> = (0..grips.ways.len()).collect();
    // A route decides from which posture it can be followed, so it comes before the reach.
    let mut first = None;
    let mut choices = all;
    if let (Planner::Routes, Some((stop, set))) = (mover.settings.planner, stops.iter().zip(&sets).next()) {
        let arrivals = leg.arrivals(stop, set, None)?;
        let entries: Vec<Vec<f64>> = grips.ways.iter().map(|ways| ways.entry().to_vec()).collect();
        let found = leg.transport(stop, &entries, &arrivals.ways)?;
        choices = vec![found.start];
        first = Some((arrivals, found));
    }
    let mut q = leg.take(&grips, &choices)?;
    let mut X_WO_end = Translation3::new(0.0, 0.0, mover.settings.lift_m) * mover.cell.X_WO_start;
    for (stop, set) in stops.iter().zip(sets) {
        let (arrivals, found) = match first.take() {
            Some(known) => known,
            None => {
                let arrivals = leg.arrivals(stop, set, Some(&q))?;
                let found = leg.transport(stop, std::slice::from_ref(&q), &arrivals.ways)?;
                (arrivals, found)
            }
        };
        let transport = leg.draft(PhaseKind::Transport, [&found.space, &found.plain], &found.path, true)?;
        leg.drafts.push(transport);
        let ways = &arrivals.ways[found.goal];
        match stop.action {
            Action::Pour { hold_s } => {
                leg.tilt(&arrivals.holding, ways, hold_s)?;
                X_WO_end = upright_again(&set.X_WO, &mover.cell.X_WO_start);
            }
            Action::Put | Action::Slide => {
                leg.along(PhaseKind::Place, &arrivals.holding, &ways.inwards(), true)?;
                leg.open_and_retreat(&arrivals.leaving, &ways.held, &ways.back)?;
                X_WO_end = set.X_WO;
            }
        }
        q = ways.entry().to_vec();
    }
    Ok(Done { drafts: leg.drafts, X_WO_end, routes: leg.routes })
}

/// Ways to take the object where it stands.
pub(super) struct Grips {
    approaching: ArmSpace,
    lifting: ArmSpace,
    pub(super) ways: Vec<Ways>,
}

/// Ways to bring it to a stop.
pub(super) struct Arrivals {
    /// With the object in the hand, at the stop.
    pub(super) holding: ArmSpace,
    /// With the open hand beside it.
    pub(super) leaving: ArmSpace,
    pub(super) ways: Vec<Ways>,
}

/// What one arm does with one grasp, phase by phase.
pub(super) struct LegWith<'a> {
    mover: &'a Mover<'a>,
    grasp: &'a Grasp,
    pub(super) drafts: Vec<Draft>,
    routes: Vec<Route>,
}

impl<'a> LegWith<'a> {
    /// Nothing done yet.
    pub(super) fn new(mover: &'a Mover<'a>, grasp: &'a Grasp) -> Self {
        Self { mover, grasp, drafts: Vec::new(), routes: Vec::new() }
    }

    fn space(&self, phase: PhaseKind, situation: Result<Situation, CollisionError>) -> Result<ArmSpace, Setback> {
        let cell = self.mover.cell;
        let checker = situation.and_then(|situation| cell.checker(&situation));
        let space = checker.and_then(|checker| ArmSpace::new(&cell.robot, cell.arm_index, checker));
        space.map_err(|error| Setback::of(phase, &error))
    }

    pub(super) fn carrying(&self, phase: PhaseKind, at: &[Isometry3<f64>]) -> Result<ArmSpace, Setback> {
        let cell = self.mover.cell;
        self.space(phase, cell.carrying(self.grasp, &cell.all_supports(at)))
    }

    pub(super) fn empty_handed(&self, phase: PhaseKind, X_WO: &Isometry3<f64>) -> Result<ArmSpace, Setback> {
        self.space(phase, self.mover.cell.approaching(X_WO))
    }

    fn start(&self) -> Result<&Situated, Setback> {
        let none = || Blocked::because("no configuration of the arm").in_phase(PhaseKind::Reach, false);
        self.grasp.start.as_ref().ok_or_else(none)
    }

    /// Where the arm is before the leg.
    pub(super) fn arm_start(&self) -> Vec<f64> {
        let cell = self.mover.cell;
        cell.arm().dofs.iter().map(|&dof| cell.q_start[dof]).collect()
    }

    /// Moves the arm along a path as one phase.
    pub(super) fn along(
        &mut self,
        kind: PhaseKind,
        space: &ArmSpace,
        path: &Path,
        carries: bool,
    ) -> Result<(), Setback> {
        let draft = self.draft(kind, [space, space], path, carries)?;
        self.drafts.push(draft);
        Ok(())
    }

    pub(super) fn draft(
        &self,
        kind: PhaseKind,
        spaces: [&ArmSpace; 2],
        path: &Path,
        carries: bool,
    ) -> Result<Draft, Setback> {
        let fingers = if carries { &self.grasp.closed } else { &self.mover.cell.hand.open };
        self.mover.along(kind, spaces, path, fingers, carries).map_err(|blocked| blocked.in_phase(kind, carries))
    }

    /// A way to one of the goals by the planner of the settings; routes of the hand are kept, taken or not.
    fn search(
        &mut self,
        kind: PhaseKind,
        space: &ArmSpace,
        among: &World,
        from: &[Vec<f64>],
        goals: &[Vec<f64>],
    ) -> Result<Found, Setback> {
        let carries = kind == PhaseKind::Transport;
        let found = if self.mover.settings.planner == Planner::Routes {
            let duration_s =
                |path: &Path| Some(self.draft(kind, [space, space], path, carries).ok()?.trajectory.duration_s());
            let (routes, found) = self.mover.by_routes(space, among, from, goals, &duration_s);
            self.routes = routes;
            found
        } else {
            self.mover.search(space, from.first().map_or(&[], Vec::as_slice), goals)
        };
        found.map_err(|blocked| blocked.in_phase(kind, carries))
    }

    /// Reach to one of the configurations that have ways, and close; which one it is.
    pub(super) fn reach_and_close(
        &mut self,
        approaching: &ArmSpace,
        holding: &ArmSpace,
        ways: &[&Ways],
    ) -> Result<usize, Setback> {
        let cell = self.mover.cell;
        let goals: Vec<Vec<f64>> = ways.iter().filter_map(|ways| ways.back.points.last().cloned()).collect();
        let arm_start = self.arm_start();
        // Routes are those of the object; a hand that only comes for it has its own.
        let found = if cell.leg().is_empty() {
            let situation = cell.approaching(&cell.X_WO_start);
            let among = situation.map_err(|error| Setback::of(PhaseKind::Reach, &error))?.world;
            self.search(PhaseKind::Reach, approaching, &among, &[arm_start], &goals)?
        } else {
            let found = self.mover.search(approaching, &arm_start, &goals);
            found.map_err(|blocked| blocked.in_phase(PhaseKind::Reach, false))?
        };
        let chosen = found.goal;
        let reach = joined(&found.path, &reversed(&ways[chosen].back));
        self.along(PhaseKind::Reach, approaching, &reach, false)?;
        let (open, closed) = (&cell.hand.open, &self.grasp.closed);
        self.drafts.push(self.mover.fingers(PhaseKind::Close, holding, &ways[chosen].held, open, closed));
        Ok(chosen)
    }

    pub(super) fn open_and_retreat(&mut self, leaving: &ArmSpace, q: &[f64], back: &Path) -> Result<(), Setback> {
        let (open, closed) = (&self.mover.cell.hand.open, &self.grasp.closed);
        self.drafts.push(self.mover.fingers(PhaseKind::Open, leaving, q, closed, open));
        self.along(PhaseKind::Retreat, leaving, back, false)
    }

    pub(super) fn grips(&self) -> Result<Grips, Setback> {
        let X_WO = self.mover.cell.X_WO_start;
        let approaching = self.empty_handed(PhaseKind::Reach, &X_WO)?;
        let lifting = self.carrying(PhaseKind::Lift, &[X_WO])?;
        let (X_WH, open, carrying) =
            (X_WO * self.grasp.X_OH, (PhaseKind::Reach, &approaching), (PhaseKind::Lift, &lifting));
        let arm_start = self.arm_start();
        let ways = picks(self.mover, self.start()?, &X_WH, open, carrying, Some(&arm_start))?;
        Ok(Grips { approaching, lifting, ways })
    }

    /// Reach to one of the chosen configurations, close, lift; where the arm is then.
    pub(super) fn take(&mut self, grips: &Grips, choices: &[usize]) -> Result<Vec<f64>, Setback> {
        let Grips { approaching, lifting, ways } = grips;
        let ways: Vec<&Ways> = choices.iter().map(|&index| &ways[index]).collect();
        let chosen = self.reach_and_close(approaching, lifting, &ways)?;
        self.along(PhaseKind::Lift, lifting, &ways[chosen].with_object, true)?;
        Ok(ways[chosen].entry().to_vec())
    }

    pub(super) fn arrivals(&self, stop: &Stop, set: &Situated, near: Option<&[f64]>) -> Result<Arrivals, Setback> {
        let X_WO = set.X_WO;
        let leaving = self.empty_handed(PhaseKind::Retreat, &X_WO)?;
        let is_poured = matches!(stop.action, Action::Pour { .. });
        let (phase, supports) = if is_poured { (PhaseKind::Pour, &[][..]) } else { (PhaseKind::Place, &[X_WO][..]) };
        let holding = self.carrying(phase, supports)?;
        let ways = if is_poured {
            let X_WO_upright = upright_again(&X_WO, &self.mover.cell.X_WO_start);
            pours(self.mover, set, &self.grasp.X_OH, &X_WO_upright, &holding, near)?
        } else {
            let X_WH = X_WO * self.grasp.X_OH;
            picks(self.mover, set, &X_WH, (PhaseKind::Retreat, &leaving), (PhaseKind::Place, &holding), near)?
        };
        Ok(Arrivals { holding, leaving, ways })
    }

    /// Tilt it, wait, turn it back.
    fn tilt(&mut self, holding: &ArmSpace, ways: &Ways, hold_s: f64) -> Result<(), Setback> {
        let tilt = self.draft(PhaseKind::Pour, [holding, holding], &ways.inwards(), true)?;
        let tilt_back = self.draft(PhaseKind::Pour, [holding, holding], &ways.with_object, true)?;
        self.drafts.push(tilt.then(hold_s, &tilt_back));
        Ok(())
    }

    /// The axis of the object that pointed up at its start stays within an angle of the vertical.
    fn upright(&self, max_tilt_rad: f64) -> Result<Upright, Setback> {
        let cell = self.mover.cell;
        let up_O = cell.X_WO_start.rotation.inverse() * Vector3::z();
        let up_H = self.grasp.X_OH.rotation.inverse() * up_O;
        let upright = Upright::new(&cell.robot, cell.arm_index, &cell.q_start, &up_H, max_tilt_rad);
        upright.map_err(|error| Blocked::because(error.to_string()).in_phase(PhaseKind::Transport, true))
    }

    /// A way from one of the places, over one of which it is held, to one where it shall go.
    pub(super) fn transport(&mut self, stop: &Stop, from: &[Vec<f64>], ways: &[Ways]) -> Result<Found, Setback> {
        let mut carrying = self.carrying(PhaseKind::Transport, &[])?;
        if let Some(max_tilt_rad) = stop.keep_upright_rad {
            carrying = carrying.keeping_upright(self.upright(max_tilt_rad)?);
        }
        let goals: Vec<Vec<f64>> = ways.iter().map(|ways| ways.entry().to_vec()).collect();
        let among = &self.mover.cell.world;
        self.search(PhaseKind::Transport, &carrying, among, from, &goals)
    }

    /// Reach, close, push along the table, let go.
    fn slide(&mut self, set: &Situated) -> Result<(), Setback> {
        let (X_WO_start, X_WO_end) = (self.mover.cell.X_WO_start, set.X_WO);
        let approaching = self.empty_handed(PhaseKind::Reach, &X_WO_start)?;
        let sliding = self.carrying(PhaseKind::Slide, &[X_WO_start, X_WO_end])?;
        let leaving = self.empty_handed(PhaseKind::Retreat, &X_WO_end)?;
        let spaces = [&approaching, &sliding, &leaving];
        let found = slides(self.mover, self.start()?, &self.grasp.X_OH, [&X_WO_start, &X_WO_end], spaces)?;
        let ways: Vec<&Ways> = found.iter().map(|(ways, _)| ways).collect();
        let chosen = self.reach_and_close(&approaching, &sliding, &ways)?;
        let (ways, leave) = &found[chosen];
        self.along(PhaseKind::Slide, &sliding, &ways.with_object, true)?;
        self.open_and_retreat(&leaving, ways.entry(), leave)
    }
}
