//! Straight joint motions, proven free of collisions rather than sampled.

use super::space::ArmSpace;
use super::upright::Tilt;
use crate::collision::{Hit, Pair, Scratch, State};

/// Where a straight motion is blocked.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeHit {
    /// Fraction of the motion at which the cause was found, 0 at its start; not necessarily the first such place.
    pub fraction: f64,
    /// Why it is blocked.
    pub cause: EdgeCause,
}

/// Why a motion is blocked.
#[derive(Clone, Debug, PartialEq)]
pub enum EdgeCause {
    /// Two things touch.
    Contact(Hit),
    /// What must stay upright is tilted.
    Tilted(Tilt),
}

impl std::fmt::Display for EdgeCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Contact(hit) => hit.fmt(f),
            Self::Tilted(tilt) => tilt.fmt(f),
        }
    }
}

/// Above this displacement a proof is not tried, only touching is looked for, metres: no scene is that empty.
const COARSE_M: f64 = 0.3;

/// The finest displacement at which a proof is asked for, metres, where the checker's margin is smaller.
const FINEST_M: f64 = 1e-4;

impl ArmSpace {
    /// Where the straight motion from `from` to `to` is blocked; `None` proves that it is free all along.
    ///
    /// Along half of an interval no point of a body travels farther than the lever-arm bound
    /// ([`crate::collision::Checker::displacement_m`]) allows. If at the middle everything is farther apart than that,
    /// nothing can touch anywhere in the interval, however thin it is; otherwise both halves are looked at in turn.
    /// Halving ends where the travel is below the checker's margin (0.1 mm), because being free already means being
    /// farther apart than that: no wall is stepped over.
    ///
    /// Both ends must be configurations of the arm; other lists count as blocked.
    pub fn edge_hit(&self, scratch: &mut Scratch, from: &[f64], to: &[f64]) -> Option<EdgeHit> {
        for (end, fraction) in [(from, 0.0), (to, 1.0)] {
            if !self.checker.is_configuration(end) {
                let hit = self.checker.first_hit(scratch, end);
                return hit.map(|hit| EdgeHit { fraction, cause: EdgeCause::Contact(hit) });
            }
        }
        if let Some((fraction, tilt)) = self.tilted(from, to) {
            return Some(EdgeHit { fraction, cause: EdgeCause::Tilted(tilt) });
        }
        let (fraction, pair) = self.blocked(scratch, from, to)?;
        Some(EdgeHit { fraction, cause: EdgeCause::Contact(self.checker.name(pair)) })
    }

    /// Whether the straight motion is free; the ends must be configurations.
    pub(crate) fn edge_is_free(&self, scratch: &mut Scratch, from: &[f64], to: &[f64]) -> bool {
        self.tilted(from, to).is_none() && self.blocked(scratch, from, to).is_none()
    }

    fn tilted(&self, from: &[f64], to: &[f64]) -> Option<(f64, Tilt)> {
        self.upright.as_ref().and_then(|upright| upright.tilted(from, to))
    }

    fn blocked(&self, scratch: &mut Scratch, from: &[f64], to: &[f64]) -> Option<(f64, Pair)> {
        // The far end first: while a tree grows, that is the new configuration.
        if let State::Hit(pair) = self.checker.state(scratch, to, None) {
            return Some((1.0, pair));
        }
        let mut margins = std::mem::take(&mut scratch.margins);
        let mut intervals = std::mem::take(&mut scratch.intervals);
        let mut q = std::mem::take(&mut scratch.q);
        self.checker.half_travel(from, to, &mut margins);
        let farthest = margins.iter().copied().fold(0.0, f64::max);
        intervals.clear();
        intervals.push((0.0, 1.0));
        let mut next = 0;
        let mut found = None;
        // Breadth first, so that the places looked at are spread over the motion and a blocked one is found early.
        while let Some(&(begin, end)) = intervals.get(next) {
            next += 1;
            let width = end - begin;
            let middle = 0.5 * (begin + end);
            q.clear();
            q.extend(from.iter().zip(to).map(|(a, b)| a + (b - a) * middle));
            let travel = farthest * width;
            let proof = travel > FINEST_M && travel < COARSE_M;
            match self.checker.state(scratch, &q, proof.then_some((margins.as_slice(), width))) {
                State::Hit(pair) => {
                    found = Some((middle, pair));
                    break;
                }
                State::Free if proof || travel <= FINEST_M => {}
                _ => intervals.extend([(begin, middle), (middle, end)]),
            }
        }
        scratch.margins = margins;
        scratch.intervals = intervals;
        scratch.q = q;
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::Bench;
    use crate::plan::{Path, walk_path};
    use crate::rng::Rng;

    #[test]
    fn a_thin_plate_between_two_free_configurations_is_never_stepped_over() {
        // The hand sweeps 1.1 m through a plate of 5 mm, and of 0.2 mm, wherever it stands.
        let (from, to) = ([-1.0, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0], [1.0, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0]);
        for thickness in [0.005, 0.0002] {
            for k in 0..40 {
                let y = 0.011 * f64::from(k) - 0.2;
                let bench = Bench::new(&[("plate", [0.8, y, 0.3], [0.15, thickness, 1.0])]);
                let space = bench.space();
                let mut scratch = Scratch::default();
                assert!(space.first_hit(&mut scratch, &from).is_none() && space.first_hit(&mut scratch, &to).is_none());
                let blocked = space.edge_hit(&mut scratch, &from, &to).expect("the plate stands in the way");
                assert_eq!(blocked.cause.to_string(), "l7 meets plate");
            }
        }
    }

    #[test]
    fn a_post_that_is_only_grazed_in_passing_is_noticed() {
        let (from, to) = ([-1.0, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0], [1.0, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0]);
        let arm = Bench::new(&[]);
        let tip = arm.model.robot().link_poses(&[0.0, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0])[7]
            * nalgebra::Point3::new(0.0, 0.0, 0.2024);
        // The hand's end, a ball of 45 mm, sweeps a circle of this radius and sinks `depth` into a hair-thin post:
        // touching lasts 2 √(2 · 45 mm · depth), 10 mm or 4 mm of 1.7 m.
        let swept = tip.x + 0.045;
        for (depth, blocked) in [(0.0003, true), (0.00005, true), (-0.0005, false)] {
            for k in 0..40 {
                let (sin, cos) = crate::math::sin_cos(0.03 * f64::from(k) - 0.57);
                let at = swept - depth + 0.00005;
                let bench = Bench::new(&[("post", [at * cos, at * sin, tip.z], [0.0001, 0.0001, 0.5])]);
                let hit = bench.space().edge_hit(&mut Scratch::default(), &from, &to);
                assert_eq!(hit.is_some(), blocked, "depth {depth}, post {k}: {hit:?}");
            }
        }
    }

    #[test]
    fn an_edge_called_free_is_free_on_a_fine_walk_and_a_blocked_one_touches_where_it_says() {
        let bench = Bench::shelf();
        let space = bench.space();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let mut scratch = Scratch::default();
        let mut rng = Rng::new(9, 0);
        let (mut free, mut blocked) = (0, 0);
        while free < 60 || blocked < 60 {
            let from: Vec<f64> = space.lower.iter().zip(&space.upper).map(|(l, u)| rng.uniform(*l, *u)).collect();
            let to: Vec<f64> = from.iter().map(|q| q + rng.uniform(-0.8, 0.8)).collect();
            let points = vec![from.clone(), to.clone()];
            match space.edge_hit(&mut scratch, &from, &to) {
                None => {
                    free += 1;
                    let walked = walk_path(&judge, &bench.dofs(), &bench.rest(), &Path { points }, 0.002);
                    assert_eq!(walked, None);
                }
                Some(hit) => {
                    blocked += 1;
                    let q: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + (b - a) * hit.fraction).collect();
                    // Within the margin of 0.1 mm the judge need not see a touch yet.
                    assert!(judge.distance_m(&q) < 1.5e-4, "{hit:?}");
                }
            }
        }
    }

    #[test]
    fn ends_that_are_no_configurations_block_the_edge() {
        let space = Bench::shelf().space();
        let mut scratch = Scratch::default();
        assert!(space.edge_hit(&mut scratch, &[0.0; 7], &[f64::NAN; 7]).is_some());
        assert!(space.edge_hit(&mut scratch, &[0.0; 6], &[0.0; 7]).is_some());
    }
}
