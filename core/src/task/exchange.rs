//! The motions of a handover: the giver takes the object and presents it, the receiver grasps it, and only then the giver
//! lets go and draws back; the receiver brings the object to its goal (thesis chapter 6: two pick-and-place problems).
//!
//! One arm moves at a time. What the other one does meanwhile, where it is and whether it holds the object, is part of
//! the workcell in which each act is planned, walked again and drawn.

use nalgebra::{Isometry3, Vector3};

use super::motion::{Draft, Mover, joined};
use super::partners::{GIVE, Partners, Posed, TAKE, beside, posed, put};
use super::phases::LegWith;
use super::setback::{Blocked, Setback};
use super::ways::Ways;
use super::ways_between::RoadmapOnce;
use super::{Leg, MotionSettings, Phase, PhaseKind, Plan, Stop, Try, Workcell};
use crate::grasp::{Grasp, Situated};
use crate::plan::{ArmSpace, Path, Trajectory};
use crate::watch::Watch;

/// Times that a motion is timed anew until the hand is slow enough.
const MOST_ROUNDS: usize = 4;

/// A handover to plan.
pub struct Exchange<'a> {
    /// Who.
    pub partners: &'a Partners,
    /// The giver's grasp, situated at the object's start.
    pub give: &'a Grasp,
    /// The receiver's grasp; its `goal` is its set there, if there is a goal.
    pub take: &'a Grasp,
    /// Pose of the object in the world at the handover.
    pub X_WO: Isometry3<f64>,
    /// Configurations of the giver's arm that present it there, best first.
    pub q_give: &'a [Vec<f64>],
    /// Configuration of the receiver's arm that takes it there.
    pub q_take: &'a [f64],
    /// The object is put down at the receiver's goal and let go; otherwise held there.
    pub lets_go: bool,
    /// Top speed of the giver's hand while it presents the object, m/s.
    pub hand_speed_m_s: f64,
    /// Seed of the searches.
    pub seed: u64,
}

/// What the acts have made so far.
struct Timeline {
    phases: Vec<Phase>,
    /// Giver, receiver.
    now: [Posed; 2],
    end_s: f64,
}

impl Timeline {
    /// Appends an act of one side; the other stands still.
    fn push(&mut self, leg: usize, drafts: Vec<Draft>) {
        let arm_joints = self.now[leg].arm.len();
        for Draft { kind, mut trajectory, carries, manipulability, clearance_m, closest } in drafts {
            if let Some(last) = trajectory.positions.last() {
                let (arm, fingers) = last.split_at(arm_joints);
                self.now[leg] = Posed { arm: arm.to_vec(), fingers: fingers.to_vec() };
            }
            let still: Vec<f64> = self.now[1 - leg].columns().collect();
            for q in &mut trajectory.positions {
                let at = if leg == GIVE { q.len() } else { 0 };
                q.splice(at..at, still.iter().copied());
            }
            let phase =
                Phase { kind, leg, start_s: self.end_s, trajectory, carries, manipulability, clearance_m, closest };
            self.end_s += phase.trajectory.duration_s();
            self.phases.push(phase);
        }
    }
}

/// The phase of a leg that could not be done.
pub struct Failure {
    /// Leg of the handover: 0 gives, 1 takes.
    pub leg: usize,
    /// What was tried.
    pub tried: Try,
}

/// Plans all motions of a handover.
///
/// # Errors
/// The first phase that cannot be done, and why.
pub fn plan_exchange(
    exchange: &Exchange<'_>,
    settings: &MotionSettings,
    watch: Watch<'_>,
) -> Result<Plan, Box<Failure>> {
    let Partners { giver, receiver } = exchange.partners;
    let failed = |leg: usize, setback: Setback| {
        let (cell, grasp) = if leg == GIVE { (giver, exchange.give) } else { (receiver, exchange.take) };
        let fingers = if setback.carries { &grasp.closed } else { &cell.hand.open };
        Box::new(Failure { leg, tried: setback.told(grasp.id, fingers) })
    };
    let q_start = exchange.partners.q_start();
    let rest = [posed(&q_start, giver, &giver.hand.open), posed(&q_start, receiver, &receiver.hand.open)];
    let mut timeline = Timeline { phases: Vec::new(), now: rest.clone(), end_s: 0.0 };
    let act = Act { exchange, settings, watch };

    // What is told fast comes first: searched ways are for places that have all their straight ones.
    let ways = act.ways_out(&rest).map_err(|setback| failed(GIVE, setback))?;
    let ways = act.with_room_to_come(&rest, ways).map_err(|setback| failed(TAKE, setback))?;
    act.look_at_goal(&rest).map_err(|setback| failed(TAKE, setback))?;
    let (drafts, back) = act.present(&rest, ways).map_err(|setback| failed(GIVE, setback))?;
    timeline.push(GIVE, drafts);
    let drafts = act.take(&timeline.now).map_err(|setback| failed(TAKE, setback))?;
    timeline.push(TAKE, drafts);
    let drafts = act.draw_back(&timeline.now, &back, &rest[GIVE].arm).map_err(|setback| failed(GIVE, setback))?;
    timeline.push(GIVE, drafts);
    let (drafts, X_WO_end) = act.bring(&timeline.now, &rest[TAKE].arm).map_err(|setback| failed(TAKE, setback))?;
    timeline.push(TAKE, drafts);

    let leg = |cell: &Workcell, grasp: &Grasp, X_WO_start, X_WO_end| Leg {
        arm: cell.arm().name.clone(),
        tcp_link: cell.arm().hand.tcp_link,
        grasp: grasp.clone(),
        X_WO_start,
        X_WO_end,
    };
    Ok(Plan {
        legs: vec![
            leg(giver, exchange.give, giver.X_WO_start, exchange.X_WO),
            leg(receiver, exchange.take, exchange.X_WO, X_WO_end),
        ],
        phases: timeline.phases,
        q_start,
        dofs: exchange.partners.dofs(),
        tries: Vec::new(),
        routes: Vec::new(),
        handover: None,
        certificate: super::Certificate::default(),
    })
}

/// What all acts of a handover share.
struct Act<'a> {
    exchange: &'a Exchange<'a>,
    settings: &'a MotionSettings,
    watch: Watch<'a>,
}

impl<'a> Act<'a> {
    fn mover<'c>(&self, cell: &'c Workcell, settings: &'c MotionSettings) -> Mover<'c>
    where
        'a: 'c,
    {
        Mover { cell, settings, seed: self.exchange.seed, roadmap: RoadmapOnce::default(), watch: self.watch }
    }

    /// All joints with both arms somewhere.
    fn q(&self, [giver, receiver]: [&Posed; 2]) -> Vec<f64> {
        let partners = self.exchange.partners;
        let mut q = partners.giver.q_start.clone();
        put(&mut q, &partners.giver, giver);
        put(&mut q, &partners.receiver, receiver);
        q
    }

    /// The receiver with its hand closed about the object at the handover.
    fn taking(&self) -> Posed {
        Posed { arm: self.exchange.q_take.to_vec(), fingers: self.exchange.take.closed.clone() }
    }

    /// The giver's ways out of the handover, which are part of the choice of its posture there.
    fn ways_out(&self, rest: &[Posed; 2]) -> Result<Vec<Ways>, Setback> {
        let Partners { giver, receiver } = self.exchange.partners;
        let grasp = self.exchange.give;
        let X_WH = self.exchange.X_WO * grasp.X_OH;
        let there = beside(giver, receiver, self.q([&rest[GIVE], &self.taking()]));
        let leaving = self.mover(&there, self.settings);
        let out = LegWith::new(&leaving, grasp).empty_handed(PhaseKind::Retreat, &self.exchange.X_WO)?;
        let mut ways = Vec::new();
        let mut first: Option<Blocked> = None;
        for q in self.exchange.q_give {
            match leaving.back_off(&out, q, &X_WH) {
                Ok(back) => ways.push(Ways { held: q.clone(), back, with_object: Path::default() }),
                Err(blocked) => first = first.or(Some(blocked)),
            }
        }
        if ways.is_empty() {
            let none = || Blocked::because("no configuration of the giver's arm at the handover");
            return Err(first.unwrap_or_else(none).in_phase(PhaseKind::Retreat, false));
        }
        Ok(ways)
    }

    /// Those of the giver's postures in which the receiver's hand can come.
    fn with_room_to_come(&self, rest: &[Posed; 2], ways: Vec<Ways>) -> Result<Vec<Ways>, Setback> {
        let (grasp, X_WO) = (self.exchange.take, self.exchange.X_WO);
        let mut with_room = Vec::new();
        let mut first = None;
        for ways in ways {
            let giving = Posed { arm: ways.held.clone(), fingers: self.exchange.give.closed.clone() };
            let cell = self.receiver_beside(&giving, &rest[TAKE]);
            let mover = self.mover(&cell, self.settings);
            let approaching = LegWith::new(&mover, grasp).empty_handed(PhaseKind::Reach, &X_WO)?;
            match mover.back_off(&approaching, self.exchange.q_take, &(X_WO * grasp.X_OH)) {
                Ok(_) => with_room.push(ways),
                Err(blocked) => first = first.or(Some(blocked)),
            }
        }
        match first {
            Some(blocked) if with_room.is_empty() => Err(blocked.in_phase(PhaseKind::Reach, false)),
            _ => Ok(with_room),
        }
    }

    /// Whether the receiver can put the object down at its goal while the giver is where it began.
    fn look_at_goal(&self, rest: &[Posed; 2]) -> Result<(), Setback> {
        let (Some(set), true) = (&self.exchange.take.goal, self.exchange.lets_go) else { return Ok(()) };
        let cell = self.receiver_beside(&rest[GIVE], &self.taking());
        let mover = self.mover(&cell, self.settings);
        let stop = Stop { poses_WO: vec![set.X_WO], ..Stop::put() };
        LegWith::new(&mover, self.exchange.take).arrivals(&stop, set, Some(self.exchange.q_take)).map(|_| ())
    }

    /// The receiver's workcell with the object at the handover.
    fn receiver_beside(&self, giver: &Posed, receiver: &Posed) -> Workcell {
        let partners = self.exchange.partners;
        let q = self.q([giver, receiver]);
        Workcell { X_WO_start: self.exchange.X_WO, ..beside(&partners.receiver, &partners.giver, q) }
    }

    /// Reach, close, lift, and bring the object to where it is handed over; also the giver's way out from there.
    fn present(&self, rest: &[Posed; 2], mut ways: Vec<Ways>) -> Result<(Vec<Draft>, Path), Setback> {
        let Partners { giver, receiver } = self.exchange.partners;
        let grasp = self.exchange.give;
        let cell = beside(giver, receiver, self.q([&rest[GIVE], &rest[TAKE]]));
        let mover = self.mover(&cell, self.settings);
        let mut leg = LegWith::new(&mover, grasp);
        let grips = leg.grips()?;
        let all: Vec<usize> = (0..grips.ways.len()).collect();
        let q = leg.take(&grips, &all)?;
        let stop = Stop { poses_WO: vec![self.exchange.X_WO], ..Stop::put() };
        let found = leg.transport(&stop, std::slice::from_ref(&q), &ways)?;
        let goal = found.goal;
        let draft = self.slowly(&cell, grasp, [&found.space, &found.plain], &found.path)?;
        leg.drafts.push(draft);
        let back = ways.swap_remove(goal).back;
        Ok((leg.drafts, back))
    }

    /// The giver's transport, no faster than its hand may come.
    fn slowly(
        &self,
        cell: &Workcell,
        grasp: &Grasp,
        [space, plain]: [&ArmSpace; 2],
        path: &Path,
    ) -> Result<Draft, Setback> {
        let mover = self.mover(cell, self.settings);
        let wanted = self.exchange.hand_speed_m_s;
        let mut scale = self.settings.velocity_scale;
        let in_phase = |blocked: Blocked| blocked.in_phase(PhaseKind::Transport, true);
        let mut trajectory = mover.timed(space, path, scale).map_err(in_phase)?;
        // Half of the joints' speeds is not exactly half of the hand's: a few rounds meet it.
        for _ in 0..MOST_ROUNDS {
            let speed = top_speed_m_s(cell, &trajectory);
            if speed <= wanted {
                break;
            }
            scale *= 0.97 * wanted / speed;
            trajectory = mover.timed(space, path, scale).map_err(in_phase)?;
        }
        Ok(mover.measured(PhaseKind::Transport, plain, trajectory, &grasp.closed, true))
    }

    /// The receiver comes and closes its hand, the giver standing still.
    fn take(&self, now: &[Posed; 2]) -> Result<Vec<Draft>, Setback> {
        let (grasp, X_WO) = (self.exchange.take, self.exchange.X_WO);
        let cell = self.receiver_beside(&now[GIVE], &now[TAKE]);
        let mover = self.mover(&cell, self.settings);
        let mut leg = LegWith::new(&mover, grasp);
        let approaching = leg.empty_handed(PhaseKind::Reach, &X_WO)?;
        let back = mover.back_off(&approaching, self.exchange.q_take, &(X_WO * grasp.X_OH));
        let back = back.map_err(|blocked| blocked.in_phase(PhaseKind::Reach, false))?;
        let ways = Ways { held: self.exchange.q_take.to_vec(), back, with_object: Path::default() };
        leg.reach_and_close(&approaching, &approaching, &[&ways])?;
        Ok(leg.drafts)
    }

    /// The giver opens its hand, backs off and goes to where it came from if there is a way.
    fn draw_back(&self, now: &[Posed; 2], back: &Path, home: &[f64]) -> Result<Vec<Draft>, Setback> {
        let Partners { giver, receiver } = self.exchange.partners;
        let cell = beside(giver, receiver, self.q([&now[GIVE], &now[TAKE]]));
        let mover = self.mover(&cell, self.settings);
        let mut leg = LegWith::new(&mover, self.exchange.give);
        let leaving = leg.empty_handed(PhaseKind::Retreat, &self.exchange.X_WO)?;
        let path = on_home(&mover, &leaving, back, home);
        leg.open_and_retreat(&leaving, &now[GIVE].arm, &path)?;
        Ok(leg.drafts)
    }

    /// The receiver brings the object to its goal; without one it draws it to where its hand came from.
    fn bring(&self, now: &[Posed; 2], home: &[f64]) -> Result<(Vec<Draft>, Isometry3<f64>), Setback> {
        let receiver = &self.exchange.partners.receiver;
        let grasp = self.exchange.take;
        let cell = self.receiver_beside(&now[GIVE], &now[TAKE]);
        let mover = self.mover(&cell, self.settings);
        let mut leg = LegWith::new(&mover, grasp);
        let stop = Stop { poses_WO: receiver.X_WO_goal().into_iter().collect(), ..Stop::put() };
        let from = std::slice::from_ref(&now[TAKE].arm);
        let still = |q: &Vec<f64>| Ways { held: q.clone(), back: Path::default(), with_object: Path::default() };
        match &grasp.goal {
            Some(set) if self.exchange.lets_go => {
                let arrivals = leg.arrivals(&stop, set, from.first().map(Vec::as_slice))?;
                let found = leg.transport(&stop, from, &arrivals.ways)?;
                let draft = leg.draft(PhaseKind::Transport, [&found.space, &found.plain], &found.path, true)?;
                leg.drafts.push(draft);
                let ways = &arrivals.ways[found.goal];
                leg.along(PhaseKind::Place, &arrivals.holding, &ways.inwards(), true)?;
                let path = on_home(&mover, &arrivals.leaving, &ways.back, home);
                leg.open_and_retreat(&arrivals.leaving, &ways.held, &path)?;
                Ok((leg.drafts, set.X_WO))
            }
            goal => {
                let home = vec![home.to_vec()];
                let goals = goal.as_ref().map_or(&home, |set: &Situated| &set.solutions);
                let ways: Vec<Ways> = goals.iter().map(still).collect();
                let found = leg.transport(&stop, from, &ways)?;
                let draft = leg.draft(PhaseKind::Transport, [&found.space, &found.plain], &found.path, true)?;
                leg.drafts.push(draft);
                let X_WO_end = self.held_at(&cell, ways[found.goal].entry());
                Ok((leg.drafts, X_WO_end))
            }
        }
    }

    /// Where the object is while the receiver holds it in a configuration.
    fn held_at(&self, cell: &Workcell, q_arm: &[f64]) -> Isometry3<f64> {
        let mut q = cell.q_start.clone();
        cell.arm().dofs.iter().zip(q_arm).for_each(|(&dof, &position)| q[dof] = position);
        cell.robot.link_poses(&q)[cell.arm().hand.tcp_link] * self.exchange.take.X_OH.inverse()
    }
}

/// The way back, and on to where the arm came from if there is a way.
fn on_home(mover: &Mover<'_>, space: &ArmSpace, back: &Path, home: &[f64]) -> Path {
    let Some(end) = back.points.last() else { return back.clone() };
    match mover.search(space, end, &[home.to_vec()]) {
        Ok(found) => joined(back, &found.path),
        Err(_) => back.clone(),
    }
}

/// The largest speed of the hand frame's origin between the samples of a motion, m/s.
fn top_speed_m_s(cell: &Workcell, trajectory: &Trajectory) -> f64 {
    let chain = cell.ik.chain();
    let places: Vec<Vector3<f64>> = trajectory.positions.iter().map(|q| chain.tip(q).translation.vector).collect();
    let times = &trajectory.times_s;
    let speed = |k: usize| (places[k] - places[k - 1]).norm() / (times[k] - times[k - 1]).max(1e-9);
    (1..places.len()).map(speed).fold(0.0, f64::max)
}
