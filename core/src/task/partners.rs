//! Both sides of a handover: who moves in which phase, and where the other one is meanwhile.

use super::{Plan, TARGET, Workcell};
use crate::collision::{MayTouch, Party};

/// Both sides of a handover, on one robot that has both arms.
#[derive(Clone)]
pub struct Partners {
    /// The arm that gives: the object at its start, obstacles that only it has to keep away from included.
    pub giver: Workcell,
    /// The arm that receives.
    pub receiver: Workcell,
}

/// An arm with its hand at one time: the columns of a plan that are its own.
#[derive(Clone)]
pub(super) struct Posed {
    pub(super) arm: Vec<f64>,
    pub(super) fingers: Vec<f64>,
}

impl Posed {
    pub(super) fn columns(&self) -> impl Iterator<Item = f64> + '_ {
        self.arm.iter().chain(&self.fingers).copied()
    }
}

/// Which leg a phase belongs to.
pub(super) const GIVE: usize = 0;
pub(super) const TAKE: usize = 1;

impl Partners {
    /// The workcell in which a phase of a plan happens: of the arm that moves, the other one being where it is then.
    pub fn during(&self, plan: &Plan, phase: usize) -> Workcell {
        let q = plan.state_at(plan.phases[phase].start_s).q;
        let [mover, other] =
            if plan.phases[phase].leg == GIVE { [&self.giver, &self.receiver] } else { [&self.receiver, &self.giver] };
        beside(mover, other, q)
    }

    /// All joints at the beginning: both hands open.
    pub(super) fn q_start(&self) -> Vec<f64> {
        let mut q = self.giver.q_with_fingers(&self.giver.hand.open);
        set_fingers(&mut q, &self.receiver, &self.receiver.hand.open);
        q
    }

    pub(super) fn dofs(&self) -> Vec<usize> {
        [&self.giver, &self.receiver].into_iter().flat_map(dofs_of).collect()
    }
}

/// A side's workcell while the other arm is where `q` says, and may hold the object.
pub(super) fn beside(mover: &Workcell, other: &Workcell, q: Vec<f64>) -> Workcell {
    let held = |b: fn() -> Party| {
        let links = &other.arm().hand.links;
        links.iter().map(move |&link| MayTouch { a: Party::Link(link), b: b(), depth_m: f64::INFINITY })
    };
    let object = || Party::Obstacle(TARGET.to_owned());
    let may_touch = mover.may_touch.iter().cloned().chain(held(object)).chain(held(|| Party::Carried)).collect();
    Workcell { q_start: q, may_touch, ..mover.clone() }
}

fn dofs_of(cell: &Workcell) -> Vec<usize> {
    cell.arm().dofs.iter().chain(cell.arm().hand.fingers.iter().flatten()).copied().collect()
}

fn set_fingers(q: &mut [f64], cell: &Workcell, fingers: &[f64]) {
    for (&dof, &position) in cell.arm().hand.fingers.iter().flatten().zip(fingers) {
        q[dof] = position;
    }
}

pub(super) fn posed(q: &[f64], cell: &Workcell, fingers: &[f64]) -> Posed {
    Posed { arm: cell.arm().dofs.iter().map(|&dof| q[dof]).collect(), fingers: fingers.to_vec() }
}

/// Puts an arm and its hand into all joints.
pub(super) fn put(q: &mut [f64], cell: &Workcell, posed: &Posed) {
    for (dof, position) in dofs_of(cell).into_iter().zip(posed.columns()) {
        q[dof] = position;
    }
}
