//! Reachability maps of the left arms: time by either method, bytes of the file, and how right the maps are.
//!
//! `cargo bench -p endcomfort-core --bench reach`. Voxels of 5 cm; forward maps are of 5 000 000 samples. The judge is
//! not the map's own code: reachable poses are those of configurations that a checker of the whole robot calls free
//! (other arm stretched out sideways, hand open); a position is unreachable when no one of 272 orientations, and a pose
//! when it itself, has a solution within the limits and free at 72 arm angles. A map of which less than 99 % of the
//! reachable poses are in reached voxels, or with more than 1 % of the unreachable positions in voxels of a fraction of
//! at least 0.5, fails the bench, and so does one that a file changes. Where the orientation counts as well ("pose"),
//! shares are only told: a pose of the map stands for rotations up to 61° (40) or 41° (272) away from it.
#![allow(non_snake_case, reason = "frame letters")]

#[path = "common/report.rs"]
mod report;

use std::error::Error;
use std::path::Path;

use endcomfort_core::collision::{Checker, CollisionModel, Scratch, World};
use endcomfort_core::library::Library;
use endcomfort_core::parallel::{self, on_one_thread};
use endcomfort_core::reach::{
    ForwardSettings, InverseSettings, Orientations, ReachError, ReachMap, build_forward, build_inverse,
};
use endcomfort_core::rng::Rng;
use endcomfort_core::robot::ik::SrsArm;
use endcomfort_core::robot::{Chain, Robot};
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Point3, Vector3};
use report::{Report, now_ms};

const SEED: u64 = 1;
/// Poses and positions of each kind that a map is judged by.
const JUDGED: usize = 10_000;
const ARM: usize = 0;
const ARM_ANGLES: usize = 72;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let library =
        Library::new(Box::new(move |path: &str| std::fs::read(root.join(path)).ok().map(|bytes| &*bytes.leak())));
    let mut report = Report::new("reach", SEED);
    let mut faults = Vec::new();
    for name in ["crichton", "alita"] {
        let robot = library.robot(name)?;
        let judge = Judge::new(&robot)?;
        for orientations in [1, 40] {
            let settings = ForwardSettings { orientations, seed: SEED, ..ForwardSettings::default() };
            let what = format!("{name}, forward, {orientations} orientations");
            let build = || build_forward(&robot, ARM, &settings, Watch::idle());
            faults.extend(judge.measure(&mut report, &what, 7, &build)?);
        }
        for (orientations, runs) in [(40, 5), (272, 2)] {
            let settings = InverseSettings { orientations, ..InverseSettings::default() };
            let what = format!("{name}, inverse, {orientations} orientations");
            let build = || build_inverse(&robot, ARM, &settings, Watch::idle());
            faults.extend(judge.measure(&mut report, &what, runs, &build)?);
        }
    }
    report.print();
    if faults.is_empty() { Ok(()) } else { Err(faults.join("\n").into()) }
}

/// Poses and positions of which it is known whether the arm reaches them.
struct Judge<'a> {
    robot: &'a Robot,
    reachable: Vec<Isometry3<f64>>,
    unreachable: Vec<Isometry3<f64>>,
    positions: Vec<Point3<f64>>,
}

impl<'a> Judge<'a> {
    fn new(robot: &'a Robot) -> Result<Self, Box<dyn Error>> {
        let arm = &robot.arms[ARM];
        let chain = Chain::between(robot, arm.base_link, arm.hand.tcp_link)?;
        let srs = SrsArm::of(robot, arm)?;
        let mut q_rest = vec![0.0; robot.dof_count()];
        arm.hand.fingers.iter().flatten().zip(&arm.hand.open).for_each(|(&dof, open)| q_rest[dof] = *open);
        let model = CollisionModel::new(robot)?;
        let checker = Checker::for_arm(&model, &World::new(), None, &[], ARM, &q_rest)?;
        let all = Orientations::new(272).ok_or("no such set")?;

        let has_solution = |scratch: &mut Scratch, X_BH: &Isometry3<f64>| {
            let found = srs.sweep(X_BH, ARM_ANGLES);
            found.solutions.iter().any(|solution| checker.is_free(scratch, &solution.q))
        };
        let reach_m = srs.lengths_m().0 + srs.lengths_m().1 + srs.wrist().coords.norm();
        let around = |rng: &mut Rng| {
            let offset = Vector3::from_fn(|_, _| rng.uniform(-reach_m, reach_m));
            srs.shoulder() + offset
        };
        let streams: Vec<u64> = (0..64).collect();
        let share = JUDGED.div_ceil(streams.len());
        let found = parallel::map(&streams, |&stream| {
            let (mut rng, mut scratch) = (Rng::new(SEED, stream), Scratch::default());
            let (mut reachable, mut unreachable, mut positions) = (Vec::new(), Vec::new(), Vec::new());
            while reachable.len() < share {
                let q: Vec<f64> = chain.limits().iter().map(|limit| rng.uniform(limit.lower, limit.upper)).collect();
                if checker.is_free(&mut scratch, &q) {
                    reachable.push(chain.tip(&q));
                }
            }
            while unreachable.len() < share {
                let X_BH = Isometry3::from_parts(around(&mut rng).into(), rng.rotation());
                if !has_solution(&mut scratch, &X_BH) {
                    unreachable.push(X_BH);
                }
            }
            while positions.len() < share {
                let p = around(&mut rng);
                let at = |rotation| Isometry3::from_parts(p.into(), rotation);
                let is_far = (p - srs.shoulder()).norm() > reach_m;
                if is_far || !all.rotations().iter().any(|rotation| has_solution(&mut scratch, &at(*rotation))) {
                    positions.push(p);
                }
            }
            (reachable, unreachable, positions)
        });
        let mut judge = Self { robot, reachable: Vec::new(), unreachable: Vec::new(), positions: Vec::new() };
        for (reachable, unreachable, positions) in found {
            judge.reachable.extend(reachable);
            judge.unreachable.extend(unreachable);
            judge.positions.extend(positions);
        }
        judge.reachable.truncate(JUDGED);
        judge.unreachable.truncate(JUDGED);
        judge.positions.truncate(JUDGED);
        Ok(judge)
    }

    /// Builds a map several times on one thread and on all, and judges it; gives what is wrong with it.
    fn measure(
        &self,
        report: &mut Report,
        what: &str,
        runs: usize,
        build: &(impl Fn() -> Result<ReachMap, ReachError> + Sync),
    ) -> Result<Option<String>, Box<dyn Error>> {
        let timed = |times_ms: &mut Vec<f64>, is_serial: bool| {
            let begin_ms = now_ms();
            let map = if is_serial { on_one_thread(build) } else { build() };
            times_ms.push(now_ms() - begin_ms);
            map
        };
        let (mut one_ms, mut all_ms) = (Vec::new(), Vec::new());
        let map = timed(&mut one_ms, true)?;
        let bytes = map.to_bytes();
        for _ in 1..runs {
            timed(&mut one_ms, true)?;
        }
        for _ in 0..runs {
            if timed(&mut all_ms, false)?.to_bytes() != bytes {
                return Ok(Some(format!("{what}: another map on another number of threads")));
            }
        }
        let begin_ms = now_ms();
        let loaded = ReachMap::from_bytes(&bytes, self.robot, ARM)?;
        let load_ms = now_ms() - begin_ms;
        if loaded.to_bytes() != bytes {
            return Ok(Some(format!("{what}: a file changes the map")));
        }
        let size = format!("{} voxels, {} poses, {} bytes", map.voxels().count(), map.reached_poses(), bytes.len());
        report.add(what, "build, one thread", "ms", one_ms, size);
        report.add(what, "build, all threads", "ms", all_ms, "same bytes");
        report.add(what, "load", "ms", [load_ms], "");

        let fraction = |p: &Point3<f64>| map.voxel_at(p).map_or(0.0, |voxel| map.fraction(voxel));
        let percent = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
        let at_pose = |X: &&Isometry3<f64>| map.nearest(X).is_some_and(|(voxel, o)| map.is_reached(voxel, o));
        let at_point = |X: &Isometry3<f64>| fraction(&X.translation.vector.into());
        let in_voxels = percent(self.reachable.iter().filter(|X| at_point(X) > 0.0).count(), JUDGED);
        let in_poses = percent(self.reachable.iter().filter(at_pose).count(), JUDGED);
        let wrong = percent(self.positions.iter().filter(|p| fraction(p) >= 0.5).count(), JUDGED);
        let wrong_any = percent(self.positions.iter().filter(|p| fraction(p) > 0.0).count(), JUDGED);
        let wrong_half = percent(self.unreachable.iter().filter(|X| at_point(X) >= 0.5).count(), JUDGED);
        let wrong_poses = percent(self.unreachable.iter().filter(at_pose).count(), JUDGED);
        report.add(
            what,
            "reachable poses in reached voxels",
            "%",
            [in_voxels],
            format!("in reached poses {in_poses} %"),
        );
        let note = format!("in reached ones {wrong_any} %");
        report.add(what, "unreachable positions in voxels ≥ 0.5", "%", [wrong], note);
        let note = format!("in reached poses {wrong_poses} %");
        report.add(what, "unreachable poses in voxels ≥ 0.5", "%", [wrong_half], note);
        // A map of positions knows no fractions: each voxel is reached or not.
        let is_wrong = in_voxels < 99.0 || (map.orientations().count() > 1 && wrong > 1.0);
        Ok(is_wrong.then(|| format!("{what}: {in_voxels} % of the reachable, {wrong} % of the unreachable")))
    }
}
