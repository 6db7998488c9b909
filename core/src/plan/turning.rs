//! How the hand turns on its way: rotations that the arm can have at the places of a route.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::following::FollowingArm;
use super::hand_route::{HandRoute, posed};
use super::queue::Queue;
use super::space::ArmSpace;
use crate::collision::Scratch;

/// Distance between the places at which the hand may turn, metres.
const PLACE_STEP_M: f64 = 0.05;
/// Rotations between the first and the last one on the shortest way.
const BETWEEN: usize = 5;
/// From one rotation the hand turns to others at most this far away, rad.
const WIDEST_TURN_RAD: f64 = 1.75;
/// In a turn the arm is asked for a posture every so often, rad.
const LOOK_RAD: f64 = 0.4;
/// What a turn costs beside a way, metres per radian.
const TURN_M_PER_RAD: f64 = 0.15;
/// Arm angles of a posture that is looked for.
const ARM_ANGLES: usize = 12;

/// Places along a route times rotations: which pairs the arm can have, and which turns between them.
pub(super) struct Turnings<'a> {
    space: &'a ArmSpace,
    arm: &'a FollowingArm<'a>,
    route: &'a HandRoute,
    /// Places of the ball's centre, first and last where the hand may begin and end to turn.
    places: Vec<Point3<f64>>,
    /// The first rotation is that of the start, the last one that of the goal.
    rotations: Vec<UnitQuaternion<f64>>,
    /// Angle between any two rotations, rad.
    angles: Vec<f64>,
    /// Whether the arm has a free posture at a place and rotation; unknown until asked.
    postures: Vec<Option<bool>>,
    /// Whether a step from a place and rotation is possible; unknown until asked.
    steps: Vec<Option<bool>>,
    scratch: Scratch,
}

/// Hand poses along a route, each with the step of the turning that it belongs to.
pub(super) struct Turned {
    pub(super) poses: Vec<Isometry3<f64>>,
    steps: Vec<Option<usize>>,
}

impl<'a> Turnings<'a> {
    pub(super) fn new(space: &'a ArmSpace, arm: &'a FollowingArm<'a>, route: &'a HandRoute) -> Self {
        let places = route.turning_places(PLACE_STEP_M);
        let [from, to] = route.ends().map(|X_WH| X_WH.rotation);
        let mut rotations = quarter_turns().into_iter().map(|turn| from * turn).collect::<Vec<_>>();
        for k in 1..=BETWEEN {
            rotations.extend(from.try_slerp(&to, k as f64 / (BETWEEN + 1) as f64, 1e-9));
        }
        rotations.push(to);
        let angles =
            rotations.iter().flat_map(|a| rotations.iter().map(|b| a.angle_to(b)).collect::<Vec<_>>()).collect();
        let (n, m) = (places.len(), rotations.len());
        let scratch = Scratch::default();
        Self {
            space,
            arm,
            route,
            places,
            rotations,
            angles,
            postures: vec![None; n * m],
            steps: vec![None; n * m * 2 * m],
            scratch,
        }
    }

    /// The cheapest way of turning none of whose steps is known to be impossible.
    pub(super) fn cheapest(&mut self) -> Option<Turned> {
        let (n, m) = (self.places.len(), self.rotations.len());
        let mut ahead_m = vec![0.0; n];
        for place in (0..n - 1).rev() {
            ahead_m[place] = ahead_m[place + 1] + (self.places[place + 1] - self.places[place]).norm();
        }
        let least = |node: usize| ahead_m[node / m] + TURN_M_PER_RAD * self.angles[(node % m) * m + m - 1];
        let bounds: Vec<f64> = (0..n * m).map(least).collect();
        let mut costs = vec![f64::INFINITY; n * m];
        let mut before = vec![usize::MAX; n * m];
        let mut queue = Queue::default();
        queue.push(bounds[0], 0, u32::MAX);
        // A node's step is proven when the search wants it: the same nodes wait several times.
        while let Some(waiting) = queue.pop() {
            let node = waiting.node as usize;
            if costs[node].is_finite() {
                continue;
            }
            if waiting.from != u32::MAX {
                let from = waiting.from as usize;
                if !self.is_possible(from, node) {
                    continue;
                }
                before[node] = from;
            }
            costs[node] = (waiting.key - bounds[node]).max(0.0);
            if node == n * m - 1 {
                return Some(self.turned(node, &before));
            }
            let (place, rotation) = (node / m, node % m);
            for next_place in place..(place + 2).min(n) {
                let moved_m = (self.places[next_place] - self.places[place]).norm();
                for next_rotation in 0..m {
                    let angle = self.angles[rotation * m + next_rotation];
                    let next = next_place * m + next_rotation;
                    if next != node && costs[next].is_infinite() && angle <= WIDEST_TURN_RAD {
                        let cost = costs[node] + moved_m + TURN_M_PER_RAD * angle;
                        queue.push(cost + bounds[next], next as u32, node as u32);
                    }
                }
            }
        }
        None
    }

    /// Notes that the step to which a pose belongs is impossible; `false` if the pose belongs to none.
    pub(super) fn forbid(&mut self, turned: &Turned, pose: usize) -> bool {
        let step = turned.steps.get(pose).copied().flatten();
        if let Some(step) = step {
            self.steps[step] = Some(false);
        }
        step.is_some()
    }

    fn step(&self, from: usize, to: usize) -> usize {
        let m = self.rotations.len();
        (from * 2 + to / m - from / m) * m + to % m
    }

    fn is_possible(&mut self, from: usize, to: usize) -> bool {
        let step = self.step(from, to);
        if let Some(known) = self.steps[step] {
            return known;
        }
        let m = self.rotations.len();
        let known = match self.postures[to] {
            Some(known) => known,
            None => {
                let known = self.has_posture(&self.places[to / m].clone(), self.rotations[to % m]);
                self.postures[to] = Some(known);
                known
            }
        };
        let looks = (self.angles[(from % m) * m + to % m] / LOOK_RAD).ceil() as usize;
        let possible = known
            && (1..looks).all(|k| {
                let share = k as f64 / looks as f64;
                let place = self.places[from / m] + (self.places[to / m] - self.places[from / m]) * share;
                let [a, b] = [from, to].map(|node| self.rotations[node % m]);
                a.try_slerp(&b, share, 1e-9).is_some_and(|rotation| self.has_posture(&place, rotation))
            });
        self.steps[step] = Some(possible);
        possible
    }

    /// Whether the arm has a free posture with the hand's ball at a place and the hand so turned.
    fn has_posture(&mut self, place: &Point3<f64>, rotation: UnitQuaternion<f64>) -> bool {
        let X_BH = self.arm.X_WB.inv_mul(&posed(place, rotation, self.route.center_H()));
        let Some(q_now) = self.arm.starts.first() else { return false };
        let set = self.arm.ik.set(&X_BH, q_now, ARM_ANGLES);
        let mut postures = set.iter();
        let Some(first) = postures.next() else { return false };
        let (checker, scratch) = (&self.space.checker, &mut self.scratch);
        checker.first_hit_of_hand(scratch, first).is_none()
            && std::iter::once(first).chain(postures).any(|q| checker.first_hit_besides_hand(scratch, q).is_none())
    }

    fn turned(&self, last: usize, before: &[usize]) -> Turned {
        let m = self.rotations.len();
        let mut nodes = vec![last];
        while let Some(&from) = nodes.last().and_then(|&node| before.get(node)).filter(|&&from| from != usize::MAX) {
            nodes.push(from);
        }
        nodes.reverse();
        let corners: Vec<(Point3<f64>, UnitQuaternion<f64>)> =
            nodes.iter().map(|&node| (self.places[node / m], self.rotations[node % m])).collect();
        let (poses, legs) = self.route.poses_through(&corners);
        let steps = legs.into_iter().map(|leg| leg.map(|leg| self.step(nodes[leg], nodes[leg + 1]))).collect();
        Turned { poses, steps }
    }
}

/// The 24 rotations that turn a cube into itself, the one that does nothing first.
fn quarter_turns() -> Vec<UnitQuaternion<f64>> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let about = |axis: Vector3<f64>, turns: usize| UnitQuaternion::from_scaled_axis(axis * (quarter * turns as f64));
    let mut all = Vec::with_capacity(24);
    // Where z goes, then how far the rest is turned about it.
    for (axis, turns) in [
        (Vector3::x(), 0),
        (Vector3::x(), 1),
        (Vector3::x(), 2),
        (Vector3::x(), 3),
        (Vector3::y(), 1),
        (Vector3::y(), 3),
    ] {
        for spin in 0..4 {
            all.push(about(axis, turns) * about(Vector3::z(), spin));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quarter_turns_are_24_and_a_quarter_or_more_apart() {
        let all = quarter_turns();
        assert_eq!(all.len(), 24);
        assert!(all[0].angle() < 1e-12);
        for (k, a) in all.iter().enumerate() {
            for b in &all[..k] {
                assert!(a.angle_to(b) > 1.5, "{a} {b}");
            }
        }
    }
}
