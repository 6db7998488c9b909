//! Many configurations at once: the sieve first, the exact checker for what it leaves.

use super::checker::{Checker, Hit, Scratch};
use super::lanes::{Chunk, LANES};
use crate::simd::widest;

/// What the sieve knows of a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sifted {
    /// The exact checker is certain to call it free, and everything may travel as was asked.
    Proven,
    /// The exact checker is certain to call it free.
    Free,
    /// The exact checker has to look.
    Unknown,
}

/// For each configuration of a chunk, which share of the travel given to [`Checker::prepare_travel`] its bodies move.
type Travel = [f32; LANES];

impl Checker {
    /// The first configuration of a list that touches something, and what touches there; `None` where all are free.
    ///
    /// The same answer as [`Checker::first_hit`] for one after the other, several times as fast: most are passed by a
    /// sieve that looks at sixteen at a time.
    pub fn first_hit_of_all<Q: AsRef<[f64]>>(
        &self,
        scratch: &mut Scratch,
        configurations: &[Q],
    ) -> Option<(usize, Hit)> {
        for (chunk, qs) in configurations.chunks(LANES).enumerate() {
            let sifted = self.sift_list(scratch, qs);
            for (k, q) in qs.iter().enumerate() {
                if sifted[k] == Sifted::Unknown
                    && let Some(hit) = self.first_hit(scratch, q.as_ref())
                {
                    return Some((chunk * LANES + k, hit));
                }
            }
        }
        None
    }

    /// For each configuration of a list whether the sieve alone is sure that it is free; `false` says nothing.
    pub fn surely_free<Q: AsRef<[f64]>>(&self, scratch: &mut Scratch, configurations: &[Q]) -> Vec<bool> {
        let mut sure = Vec::with_capacity(configurations.len());
        for qs in configurations.chunks(LANES) {
            let sifted = self.sift_list(scratch, qs);
            sure.extend(sifted.iter().take(qs.len()).map(|&sifted| sifted != Sifted::Unknown));
        }
        sure
    }

    /// Up to [`LANES`] configurations without travel; what is no configuration is unknown.
    fn sift_list<Q: AsRef<[f64]>>(&self, scratch: &mut Scratch, qs: &[Q]) -> [Sifted; LANES] {
        let mut sifted = [Sifted::Unknown; LANES];
        if self.constant_hit.is_some() || !qs.iter().all(|q| self.is_configuration(q.as_ref())) {
            return sifted;
        }
        let mut flat = std::mem::take(&mut scratch.flat);
        flat.clear();
        for k in 0..LANES {
            let last = qs.len().saturating_sub(1);
            flat.extend(qs.get(k.min(last)).map(AsRef::as_ref).unwrap_or_default());
        }
        if flat.len() == LANES * self.dofs.len() {
            widest(self.chunk::<false>(scratch, &flat, [0.0; LANES]));
            for (sifted, free) in sifted.iter_mut().zip(&scratch.lanes.free) {
                *sifted = if *free != 0 { Sifted::Free } else { Sifted::Unknown };
            }
        }
        scratch.flat = flat;
        sifted
    }

    /// Remembers the straight motion whose share [`Checker::sift`] is asked for.
    pub(crate) fn prepare_travel(&self, scratch: &mut Scratch, from: &[f64], to: &[f64]) {
        self.sieve.half_travel(from, to, &mut scratch.travel);
    }

    /// [`LANES`] configurations one after the other, each with its share of the travel that was prepared.
    pub(crate) fn sift(&self, scratch: &mut Scratch, q: &[f64], shares: Travel) -> [Sifted; LANES] {
        if self.constant_hit.is_some() {
            return [Sifted::Unknown; LANES];
        }
        widest(self.chunk::<true>(scratch, q, shares));
        let lanes = &scratch.lanes;
        std::array::from_fn(|k| match (lanes.proven[k] != 0, lanes.free[k] != 0) {
            (true, true) => Sifted::Proven,
            (false, true) => Sifted::Free,
            _ => Sifted::Unknown,
        })
    }

    fn chunk<'a, const TRAVEL: bool>(
        &'a self,
        scratch: &'a mut Scratch,
        q: &'a [f64],
        scale: Travel,
    ) -> Chunk<'a, TRAVEL> {
        let slack_m = self.sieve.slack_m(self.margin_m);
        Chunk { lanes: &mut scratch.lanes, sieve: &self.sieve, q, slack_m, travel: &scratch.travel, scale }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::testing::{brick, random_q, scene, two_arm_robot};
    use crate::collision::{CollisionModel, MayTouch, State};
    use crate::plan::testing::Bench;
    use crate::rng::Rng;
    use crate::robot::{Robot, samples};

    /// How many of the seeded configurations are free, and how many of those the sieve passes; whatever it passes must be
    /// free, and stay free within the travel that it proves.
    fn sifted(robot: &Robot, checker: &Checker, count: usize) -> (usize, usize) {
        let limits: Vec<_> = checker.dofs.iter().map(|&dof| robot.joints[robot.dof_joints[dof]].limit).collect();
        let chunks: Vec<u64> = (0..count.div_ceil(LANES) as u64).collect();
        let answers = crate::parallel::map(&chunks, |&stream| {
            let mut rng = Rng::new(77, stream);
            let mut scratch = Scratch::default();
            let draw = |rng: &mut Rng| limits.iter().map(|l| rng.uniform(l.lower, l.upper)).collect::<Vec<f64>>();
            let qs: Vec<Vec<f64>> = (0..LANES).map(|_| draw(&mut rng)).collect();
            let (mut free, mut passed) = (0, 0);
            for (q, sure) in qs.iter().zip(checker.surely_free(&mut scratch, &qs)) {
                let is_free = checker.is_free(&mut scratch, q);
                assert!(is_free || !sure, "passed, but {:?}", checker.first_hit(&mut scratch, q));
                free += usize::from(is_free);
                passed += usize::from(sure);
            }
            // Travel: the exact checker is asked with the margins of its own, larger bound; and at the ends.
            let way: Vec<f64> = limits.iter().map(|_| rng.uniform(-0.1, 0.1)).collect();
            let ends = |q: &[f64], half: f64| q.iter().zip(&way).map(|(q, d)| q + half * d).collect::<Vec<f64>>();
            checker.prepare_travel(&mut scratch, &vec![0.0; way.len()], &way);
            let shares: Travel = std::array::from_fn(|k| 0.05 * k as f32);
            let known = checker.sift(&mut scratch, &qs.concat(), shares);
            for (k, q) in qs.iter().enumerate() {
                if known[k] == Sifted::Unknown {
                    continue;
                }
                assert!(!matches!(checker.state(&mut scratch, q, None), State::Hit(_)));
                for step in -4..=4 {
                    let at = ends(q, f64::from(shares[k]) * f64::from(step) / 8.0);
                    assert!(known[k] == Sifted::Free || checker.is_free(&mut scratch, &at), "travelled into something");
                }
            }
            (free, passed)
        });
        answers.into_iter().fold((0, 0), |sum, answer| (sum.0 + answer.0, sum.1 + answer.1))
    }

    #[test]
    fn whatever_passes_the_sieve_is_accepted_by_the_exact_checker() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let (world, carried) = (scene(), brick(&robot, 0));
        let may = [MayTouch::carried("table", 0.005), MayTouch::carried("box_0", f64::INFINITY)];
        let rest = random_q(&robot, &mut Rng::new(5, 0));
        let arm = Checker::for_arm(&model, &world, Some(&carried), &may, 0, &vec![0.0; rest.len()]).unwrap();
        let whole = Checker::whole(&model, &world, Some(&carried), &may).unwrap();
        let wary = whole.clone().with_margin(0.02);
        for (checker, share) in [(&arm, 0.9), (&whole, 0.8), (&wary, 0.8)] {
            let (free, passed) = sifted(&robot, checker, 20_000);
            println!("{passed} of {free} free ones pass");
            assert!(free > 2_000 && passed as f64 > share * free as f64, "{passed} of {free} free ones pass");
        }
    }

    #[test]
    fn on_an_arm_of_capsules_nearly_all_that_is_free_passes() {
        let bench = Bench::shelf();
        let (free, passed) = sifted(bench.model.robot(), &bench.space().checker, 20_000);
        println!("{passed} of {free} free ones pass");
        assert!(free > 5_000 && passed as f64 > 0.98 * free as f64, "{passed} of {free} free ones pass");
    }

    #[test]
    fn a_list_is_answered_as_its_configurations_are_one_by_one() {
        let robot = samples::alita();
        let model = CollisionModel::new(&robot).unwrap();
        let checker = Checker::whole(&model, &scene(), None, &[]).unwrap();
        let mut scratch = Scratch::default();
        let mut rng = Rng::new(6, 0);
        for length in [0, 1, 15, 16, 17, 40] {
            for _ in 0..40 {
                let mut list: Vec<Vec<f64>> = (0..length).map(|_| random_q(&robot, &mut rng)).collect();
                list.retain(|q| checker.is_free(&mut scratch, q) || rng.uniform(0.0, 1.0) < 0.05);
                let alone =
                    list.iter().enumerate().find_map(|(k, q)| checker.first_hit(&mut scratch, q).map(|hit| (k, hit)));
                assert_eq!(checker.first_hit_of_all(&mut scratch, &list), alone);
            }
        }
        assert!(checker.first_hit_of_all(&mut scratch, &[vec![f64::NAN; robot.dof_joints.len()], vec![]]).is_some());
        assert_eq!(checker.surely_free(&mut scratch, &[vec![1e9; robot.dof_joints.len()]]), [false]);
    }
}
