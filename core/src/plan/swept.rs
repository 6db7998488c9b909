//! Many short motions in a row, proven free together.

use super::space::ArmSpace;
use crate::collision::{Scratch, State};

/// Above this displacement a proof is not tried, metres: no scene is that empty.
const COARSE_M: f64 = 0.3;

impl ArmSpace {
    /// The first motion of a chain of configurations that is not free; `None` proves that all of them are.
    ///
    /// A stretch of the chain lies in the box between its smallest and largest joint positions. From where the bodies
    /// stand in the middle of the box, no point of them is farther away anywhere in it than the lever-arm bound allows
    /// ([`crate::collision::Checker::displacement_m`]). If everything is farther apart than that in the middle, the
    /// stretch is free; otherwise its halves are looked at in turn, single motions as [`ArmSpace::edge_hit`] does. A
    /// sampled trajectory so takes about as many questions as the path it follows, whatever its sample time.
    ///
    /// The first configuration must be free, the others must be configurations.
    pub(crate) fn blocked_motion(&self, scratch: &mut Scratch, points: &[Vec<f64>]) -> Option<usize> {
        let (mut lower, mut upper) = (vec![0.0; self.dimension()], vec![0.0; self.dimension()]);
        let mut middle = lower.clone();
        let mut margins = Vec::new();
        // Stretches by their first and last point, the earliest on top.
        let mut stretches = vec![(0, points.len().saturating_sub(1))];
        while let Some((first, last)) = stretches.pop() {
            if first == last {
                continue;
            }
            if last == first + 1 {
                if !self.edge_is_free(scratch, &points[first], &points[last]) {
                    return Some(first);
                }
                continue;
            }
            lower.copy_from_slice(&points[first]);
            upper.copy_from_slice(&points[first]);
            for point in &points[first + 1..=last] {
                for ((low, high), &position) in lower.iter_mut().zip(&mut upper).zip(point) {
                    *low = low.min(position);
                    *high = high.max(position);
                }
            }
            self.checker.half_travel(&lower, &upper, &mut margins);
            if margins.iter().copied().fold(0.0, f64::max) < COARSE_M {
                middle.iter_mut().zip(lower.iter().zip(&upper)).for_each(|(m, (low, high))| *m = 0.5 * (low + high));
                if self.checker.state(scratch, &middle, Some((&margins, 1.0))) == State::Free {
                    continue;
                }
            }
            let half = first + (last - first) / 2;
            stretches.extend([(half, last), (first, half)]);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::testing::Bench;
    use crate::rng::Rng;

    #[test]
    fn a_chain_is_blocked_exactly_where_its_first_blocked_motion_is() {
        let bench = Bench::shelf();
        let space = bench.space();
        let mut scratch = Scratch::default();
        let mut rng = Rng::new(3, 0);
        let (mut free, mut blocked) = (0, 0);
        while free < 40 || blocked < 40 {
            let from: Vec<f64> = space.lower.iter().zip(&space.upper).map(|(l, u)| rng.uniform(*l, *u)).collect();
            if space.first_hit(&mut scratch, &from).is_some() {
                continue;
            }
            let (one, two): (Vec<f64>, Vec<f64>) =
                from.iter().map(|_| (rng.uniform(-0.5, 0.5), rng.uniform(-0.4, 0.4))).unzip();
            let points: Vec<Vec<f64>> = (0..=100)
                .map(|k| {
                    let u = f64::from(k) / 100.0;
                    let place = from.iter().zip(one.iter().zip(&two)).map(|(q, (a, b))| q + u * a + u * u * b);
                    place.zip(space.lower.iter().zip(&space.upper)).map(|(q, (l, h))| q.max(*l).min(*h)).collect()
                })
                .collect();
            let single = points.windows(2).position(|pair| !space.edge_is_free(&mut scratch, &pair[0], &pair[1]));
            let found = space.blocked_motion(&mut scratch, &points);
            assert_eq!(found, single, "the chain and its motions one by one disagree");
            *(if found.is_some() { &mut blocked } else { &mut free }) += 1;
        }
    }

    #[test]
    fn chains_without_motions_are_free() {
        let space = Bench::new(&[]).space();
        for points in [vec![], vec![vec![0.0; 7]], vec![vec![0.0; 7]; 3]] {
            assert_eq!(space.blocked_motion(&mut Scratch::default(), &points), None);
        }
    }
}
