//! Straight joint motions, proven free of collisions rather than sampled.

use super::space::ArmSpace;
use super::upright::Tilt;
use crate::collision::{Hit, LANES, Pair, Scratch, Sifted, State};

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

/// Above this displacement a proof is not tried by the exact checker, metres: no scene is that empty.
const COARSE_M: f64 = 0.3;

/// The finest displacement at which a proof is asked for, metres, where the checker's margin is smaller.
const FINEST_M: f64 = 1e-4;

/// Motions along which nothing travels farther than this to either side of their middle, metres, are looked at one place
/// after the other: that is rarely more than one.
const SHORT_M: f64 = 0.004;

impl ArmSpace {
    /// Where the straight motion from `from` to `to` is blocked; `None` proves that it is free all along.
    ///
    /// Along half of an interval no point of a body travels farther than the lever-arm bound
    /// ([`crate::collision::Checker::displacement_m`]) allows. If at the middle everything is farther apart than that,
    /// nothing can touch anywhere in the interval, however thin it is; otherwise it is divided and its parts are looked
    /// at in turn. Dividing ends where the travel is below the checker's margin (0.1 mm), because being free already means
    /// being farther apart than that: no wall is stepped over.
    ///
    /// A sieve looks at sixteen intervals at once, with a travel of each body's ends of its own; the exact checker looks
    /// at those that the sieve cannot tell.
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
        let mut work = Work {
            margins: std::mem::take(&mut scratch.margins),
            now: std::mem::take(&mut scratch.intervals),
            next: std::mem::take(&mut scratch.later),
            q: std::mem::take(&mut scratch.q),
        };
        self.checker.half_travel(from, to, &mut work.margins);
        let found = self.search(scratch, &mut work, from, to);
        scratch.margins = work.margins;
        scratch.intervals = work.now;
        scratch.later = work.next;
        scratch.q = work.q;
        found
    }

    /// Looks at intervals of equal order of size together, so that the places looked at are spread over the motion and a
    /// blocked one is found early.
    fn search(&self, scratch: &mut Scratch, work: &mut Work, from: &[f64], to: &[f64]) -> Option<(f64, Pair)> {
        let farthest_m = work.margins.iter().copied().fold(0.0, f64::max);
        self.checker.prepare_travel(scratch, from, to);
        work.now.clear();
        work.next.clear();
        divide(&[(0.0, 1.0)], if farthest_m < SHORT_M { 1 } else { LANES }, &mut work.now);
        while !work.now.is_empty() {
            for chunk in work.now.chunks(LANES) {
                let middles = |k: usize| {
                    let (begin, end) = chunk[k.min(chunk.len() - 1)];
                    0.5 * (begin + end)
                };
                let mut sifted = [Sifted::Unknown; LANES];
                if chunk.len() > FEW {
                    work.q.clear();
                    for k in 0..LANES {
                        let middle = middles(k);
                        work.q.extend(from.iter().zip(to).map(|(a, b)| a + (b - a) * middle));
                    }
                    let shares = std::array::from_fn(|k| {
                        let (begin, end) = chunk[k.min(chunk.len() - 1)];
                        ((end - begin) * SHARE_ROUND_UP) as f32
                    });
                    sifted = self.checker.sift(scratch, &work.q, shares);
                }
                for (k, &(begin, end)) in chunk.iter().enumerate() {
                    let width = end - begin;
                    let travel = farthest_m * width;
                    match sifted[k] {
                        Sifted::Proven => {}
                        Sifted::Free if travel <= FINEST_M => {}
                        Sifted::Free => work.next.push((begin, end)),
                        Sifted::Unknown => {
                            let middle = middles(k);
                            work.q.clear();
                            work.q.extend(from.iter().zip(to).map(|(a, b)| a + (b - a) * middle));
                            let proof = travel > FINEST_M && travel < COARSE_M;
                            let margins = proof.then_some((work.margins.as_slice(), width));
                            match self.checker.state(scratch, &work.q, margins) {
                                State::Hit(pair) => return Some((middle, pair)),
                                State::Free if proof || travel <= FINEST_M => {}
                                _ => work.next.push((begin, end)),
                            }
                        }
                    }
                }
            }
            // Few intervals are divided into as many parts as are looked at together.
            let parts = (LANES / work.next.len().max(1)).max(2);
            divide(&work.next, parts, &mut work.now);
            work.next.clear();
        }
        None
    }
}

/// So few intervals are not worth a chunk of the sieve.
const FEW: usize = 2;

/// Makes shares of the travel a little larger than they are, by more than their round-off.
const SHARE_ROUND_UP: f64 = 1.0 + 1e-6;

/// Lists that are reused from motion to motion.
struct Work {
    margins: Vec<f64>,
    now: Vec<(f64, f64)>,
    next: Vec<(f64, f64)>,
    q: Vec<f64>,
}

/// Divides intervals into equal parts.
fn divide(intervals: &[(f64, f64)], parts: usize, into: &mut Vec<(f64, f64)>) {
    into.clear();
    for &(begin, end) in intervals {
        let cut = |k: usize| if k == parts { end } else { begin + (end - begin) * (k as f64 / parts as f64) };
        into.extend((0..parts).map(|k| (cut(k), cut(k + 1))));
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
