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
    /// sieve that looks at eight at a time.
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

    /// Up to [`LANES`] configurations without travel; what is no configuration is unknown (a position that is not finite
    /// is beyond the limits that the sieve looks at).
    fn sift_list<Q: AsRef<[f64]>>(&self, scratch: &mut Scratch, qs: &[Q]) -> [Sifted; LANES] {
        let mut sifted = [Sifted::Unknown; LANES];
        if self.constant_hit.is_some() || !qs.iter().all(|q| q.as_ref().len() == self.dofs.len()) {
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
    use nalgebra::{Isometry3, Point3, Vector3};

    use super::*;
    use crate::collision::testing::{brick, random_q, scene, two_arm_robot};
    use crate::collision::{CollisionError, CollisionModel, Exhaustive, MOST_TRIANGLES, MayTouch, State, World};
    use crate::mesh::Mesh;
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

    /// A bowl of points and a bent sheet of triangles within reach of both arms.
    fn rough_scene() -> World {
        let mut world = scene();
        let mut rng = Rng::new(8, 0);
        let around = Vector3::new(0.5, 0.2, 0.9);
        let shell = (0..4000).map(|_| Point3::from(around + rng.direction() * 0.2)).filter(|p| p.z < 0.9);
        world.add_cloud("bowl", &shell.collect::<Vec<_>>(), 0.02).unwrap();
        let mut sheet = Mesh::default();
        for k in 0..=20_u32 {
            let (sin, cos) = crate::math::sin_cos(0.15 * f64::from(k));
            sheet.positions.extend([-0.2, 0.2].map(|z| Point3::new(0.25 * cos, 0.25 * sin, z)));
            if k > 0 {
                sheet.triangles.extend([[2 * k - 2, 2 * k - 1, 2 * k], [2 * k - 1, 2 * k + 1, 2 * k]]);
            }
        }
        world.add_mesh("sheet", &sheet, &Isometry3::translation(0.6, -0.3, 1.1)).unwrap();
        world
    }

    #[test]
    fn many_obstacles_in_a_tree_are_met_as_in_the_loop_over_all_and_as_the_judge_says() {
        let robot = two_arm_robot();
        let model = CollisionModel::new(&robot).unwrap();
        let (world, carried) = (rough_scene(), brick(&robot, 0));
        let may = [MayTouch::carried("bowl", 0.01)];
        let checker = Checker::whole(&model, &world, Some(&carried), &may).unwrap().with_margin(0.0);
        assert!(checker.tree.is_some(), "{} obstacles", world.names().count());
        let looped = Checker { tree: None, ..checker.clone() };
        let judge = Exhaustive::new(&model, &world, Some(&carried), &may).unwrap();
        let mut rng = Rng::new(9, 0);
        let configurations: Vec<Vec<f64>> = (0..3_000).map(|_| random_q(&robot, &mut rng)).collect();
        let answers = crate::parallel::map(&configurations, |q| {
            let mut scratch = Scratch::default();
            let answer = checker.is_free(&mut scratch, q);
            assert_eq!(answer, looped.is_free(&mut scratch, q));
            let judged = judge.first_hit_with_balls(q).is_none();
            // Only a touch within the judge's own numerical tolerance may be judged differently.
            assert!(answer == judged || judge.distance_m(q).abs() < 1e-6, "{:?}", judge.first_hit(q));
            checker
                .all_hits(&mut scratch, q)
                .into_iter()
                .map(|hit| hit.b)
                .filter(|b| b == "bowl" || b == "sheet")
                .count()
        });
        assert!(answers.iter().filter(|met| **met > 0).count() > 100, "the new obstacles must be met");
        let (free, passed) = sifted(&robot, &checker.with_margin(1e-3), 20_000);
        println!("{passed} of {free} free ones pass");
        assert!(passed as f64 > 0.8 * free as f64, "{passed} of {free} free ones pass");
    }

    #[test]
    fn a_mesh_is_its_triangles_and_what_is_missing_is_named() {
        let mut world = World::new();
        let mut mesh = Mesh { positions: vec![Point3::origin(); 3], ..Mesh::default() };
        mesh.triangles.push([0, 1, 3]);
        let refused = world.add_mesh("leaf", &mesh, &Isometry3::identity()).unwrap_err();
        assert_eq!(refused.to_string(), "leaf: triangle 0 names corner 3 of 3");
        mesh.triangles = vec![[0, 1, 2]; MOST_TRIANGLES + 1];
        assert!(matches!(
            world.add_mesh("leaf", &mesh, &Isometry3::identity()),
            Err(CollisionError::TooMany { found, .. }) if found == MOST_TRIANGLES + 1
        ));
    }
}
