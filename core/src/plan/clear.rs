//! Ways that keep away from things where there is room.

use super::birrt::{BirrtSettings, Found, PlanOutcome, plan_path};
use super::shortcut::{ShortcutSettings, shorten};
use super::space::ArmSpace;
use crate::collision::Scratch;
use crate::watch::Watch;

/// How to look for a way with clearance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearSettings {
    /// Distance that is wanted to everything, metres.
    pub clearance_m: f64,
    /// The search that avoids contact alone, the last resort.
    pub birrt: BirrtSettings,
    /// Configurations drawn for each larger clearance before a smaller one is tried.
    pub cautious_iterations: usize,
    /// Shortening; its clearance is the one that the search kept.
    pub shortcut: ShortcutSettings,
}

impl Default for ClearSettings {
    fn default() -> Self {
        Self {
            clearance_m: 0.02,
            birrt: BirrtSettings::default(),
            cautious_iterations: 1000,
            shortcut: ShortcutSettings::default(),
        }
    }
}

/// A way, searched and shortened, and how far it keeps from things.
#[derive(Clone, Debug)]
pub struct ClearPath {
    /// The shortened path, and what the search took.
    pub found: Found,
    /// Proven distance to everything that is not nearer at the start or the goal already, metres: the wanted clearance,
    /// half of it, a quarter, or 0 for no contact.
    pub clearance_m: f64,
    /// Smallest distance at the start and at the goal, metres, up to the wanted clearance. The whole path keeps the
    /// smaller one of the two clearances.
    pub ends_m: f64,
    /// The space in which the path was searched and shortened; timing in it keeps the clearance too.
    pub space: ArmSpace,
}

/// Searches and shortens a path from `start` to any of `goals` that keeps the wanted clearance, or half or a quarter of
/// it where there is no such way, and at last one that touches nothing.
///
/// What is nearer at the start must only stay as far away as it is there, and if no goal keeps the clearance, the same
/// holds for the goal that has the most room ([`ArmSpace::keeping_clear`]); so straight ways may end near a table.
/// Equal seeds give equal paths.
///
/// # Errors
/// The outcome of the search that avoids contact alone.
pub fn plan_clear_path(
    space: &ArmSpace,
    start: &[f64],
    goals: &[Vec<f64>],
    settings: &ClearSettings,
    seed: u64,
    watch: &Watch<'_>,
) -> Result<ClearPath, PlanOutcome> {
    let mut scratch = Scratch::default();
    let wanted_m = settings.clearance_m.max(0.0);
    for share in [1.0, 0.5, 0.25, 0.0] {
        let level_m = share * wanted_m;
        let is_last = level_m == 0.0;
        let clear = if is_last { space.clone() } else { clear_space(space, &mut scratch, start, goals, level_m) };
        let cautious = BirrtSettings {
            max_iterations: settings.birrt.max_iterations.min(settings.cautious_iterations),
            ..settings.birrt
        };
        let birrt = if is_last { &settings.birrt } else { &cautious };
        match plan_path(&clear, start, goals, birrt, seed, watch) {
            PlanOutcome::Found(mut found) => {
                let shortcut = ShortcutSettings { clearance_m: 0.0, ..settings.shortcut };
                found.path = shorten(&clear, &found.path, &shortcut, seed, watch);
                let ends = [found.path.points.first(), found.path.points.last()];
                let ends_m = ends.into_iter().flatten().map(|q| space.room_m(&mut scratch, q, wanted_m));
                let ends_m = ends_m.fold(wanted_m, f64::min);
                return Ok(ClearPath { found, clearance_m: level_m, ends_m, space: clear });
            }
            outcome if is_last || outcome == PlanOutcome::Stopped => return Err(outcome),
            _ => {}
        }
    }
    Err(PlanOutcome::Stopped)
}

/// The space that keeps a clearance as far as the start and at least one goal allow.
fn clear_space(space: &ArmSpace, scratch: &mut Scratch, start: &[f64], goals: &[Vec<f64>], level_m: f64) -> ArmSpace {
    let clear = space.keeping_clear(level_m, &[start]);
    let mut roomiest: Option<(f64, &Vec<f64>)> = None;
    for goal in goals.iter().filter(|goal| space.fault(goal).is_none()) {
        if clear.first_hit(scratch, goal).is_none() {
            return clear;
        }
        if space.first_hit(scratch, goal).is_none() {
            let room = space.room_m(scratch, goal, level_m);
            if roomiest.is_none_or(|(most, _)| room > most) {
                roomiest = Some((room, goal));
            }
        }
    }
    match roomiest {
        Some((_, goal)) => space.keeping_clear(level_m, &[start, goal]),
        None => clear,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::{Bench, shelf_configurations};
    use crate::plan::{MotionLimits, Path, TimingSettings, time_path};

    /// The judge's smallest distance along a path, in steps of 0.01 rad.
    fn judged_m(bench: &Bench, judge: &Exhaustive, path: &Path) -> f64 {
        let mut least = f64::INFINITY;
        for pair in path.points.windows(2) {
            let length = crate::plan::space::distance_rad(&pair[0], &pair[1]);
            let steps = (length / 0.01).ceil() as usize;
            for k in 0..=steps {
                let q = crate::plan::space::lerp(&pair[0], &pair[1], k as f64 / steps.max(1) as f64);
                assert_eq!(q.len(), bench.dofs().len());
                least = least.min(judge.distance_m(&q));
            }
        }
        least
    }

    #[test]
    fn ways_keep_the_clearance_they_name_and_so_does_their_timing() {
        let bench = Bench::shelf();
        let space = bench.space();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let settings = ClearSettings::default();
        let cells = shelf_configurations();
        let mut full = 0;
        for (seed, pair) in cells.windows(2).enumerate() {
            let goals = [pair[1].clone()];
            let plan = || plan_clear_path(&space, &pair[0], &goals, &settings, seed as u64, &Watch::idle());
            let way = plan().unwrap();
            assert_eq!(way.found, plan().unwrap().found, "equal seeds give equal paths");
            full += usize::from(way.clearance_m == settings.clearance_m);
            // GJK on the judge's capsules is 5e-5 off, what is near at the ends 0.12 mm.
            let promised = way.clearance_m.min(way.ends_m) - 2e-4;
            let judged = judged_m(&bench, &judge, &way.found.path);
            assert!(judged >= promised, "cell {seed}: {judged}, promised {promised}");
            let limits = MotionLimits::of(&space);
            let trajectory = time_path(&way.space, &way.found.path, &limits, &TimingSettings::default()).unwrap();
            let judged = judged_m(&bench, &judge, &Path { points: trajectory.positions });
            assert!(judged >= promised, "timed, cell {seed}: {judged}, promised {promised}");
        }
        assert!(full >= 2, "a shelf with room leaves room: {full} of 5 with the whole clearance");
    }

    #[test]
    fn a_start_that_stands_near_something_is_no_reason_to_give_up_the_clearance() {
        // A post 3 mm beside the hand at the start.
        let arm = Bench::new(&[]);
        let start = vec![0.0, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0];
        let tip = arm.model.robot().link_poses(&start)[7] * nalgebra::Point3::new(0.0, 0.0, 0.2024);
        let bench = Bench::new(&[("post", [tip.x, tip.y - 0.045 - 0.01 - 0.003, tip.z], [0.02, 0.02, 0.4])]);
        let space = bench.space();
        let goals = [vec![0.9, 1.0, 0.0, 0.5, 0.0, 0.0, 0.0]];
        let way = plan_clear_path(&space, &start, &goals, &ClearSettings::default(), 1, &Watch::idle()).unwrap();
        assert_eq!(way.clearance_m, 0.02);
        assert!((way.ends_m - 0.003).abs() < 1e-3, "{}", way.ends_m);
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        assert!(judged_m(&bench, &judge, &way.found.path) > way.ends_m - 2e-4);
    }

    #[test]
    fn a_door_narrower_than_the_clearance_is_passed_with_less() {
        // Two posts that leave the hand 8 mm on either side where it swings through.
        let tip = Bench::new(&[]).model.robot().link_poses(&[0.0, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0])[7]
            * nalgebra::Point3::new(0.0, 0.0, 0.2024);
        let aside = 0.045 + 0.008 + 0.2;
        let bench = Bench::new(&[
            ("above", [tip.x, 0.0, tip.z + aside + 0.012], [0.1, 3.0, 0.4]),
            ("below", [tip.x, 0.0, tip.z - aside], [0.1, 3.0, 0.4]),
        ]);
        let space = bench.space();
        let (start, goal) = (vec![-0.1, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0], vec![0.1, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0]);
        let way = plan_clear_path(&space, &start, &[goal], &ClearSettings::default(), 1, &Watch::idle()).unwrap();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let judged = judged_m(&bench, &judge, &way.found.path);
        assert!(judged >= way.clearance_m.min(way.ends_m) - 2e-4 && way.ends_m < 0.02, "{judged}");
    }
}
