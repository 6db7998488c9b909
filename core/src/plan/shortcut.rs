//! Taking detours out of a path.

use std::slice::from_ref;

use super::space::{ArmSpace, Path, distance_rad, lerp};
use crate::collision::Scratch;
use crate::rng::Rng;
use crate::watch::Watch;

/// How long to look for shortcuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShortcutSettings {
    /// Shortcuts tried between random places of the path.
    pub tries: usize,
    /// Tries in a row without a gain after which no more are made.
    pub patience: usize,
    /// Distance to everything that a shortcut keeps where the stretch that it replaces kept it, metres. Where that
    /// stretch came nearer to something, the shortcut comes no nearer to it.
    pub clearance_m: f64,
}

impl Default for ShortcutSettings {
    fn default() -> Self {
        Self { tries: 100, patience: 25, clearance_m: 0.0 }
    }
}

/// The path without detours: never longer, with the same ends, and with motions that are proven free.
///
/// First every point is joined with the farthest later point that it reaches straight; then random places on the path,
/// not only its points, are joined while that makes it shorter (Geraerts and Overmars 2007). With a wanted clearance the
/// path keeps at least that, or its own before where that was less (to 0.12 mm), and no shortcut comes nearer to
/// anything than the stretch it replaces did, unless it stays beyond the wanted clearance. Equal seeds give equal paths.
pub fn shorten(space: &ArmSpace, path: &Path, settings: &ShortcutSettings, seed: u64, watch: &Watch<'_>) -> Path {
    let mut scratch = Scratch::default();
    let cuts = Cuts::new(space, &mut scratch, path, settings.clearance_m);
    let mut points = prune(&cuts, &mut scratch, &path.points);
    let mut rng = Rng::new(seed, 0x7368_6f72_7463);
    let mut in_vain = 0;
    for _ in 0..settings.tries {
        if points.len() <= 2 || in_vain == settings.patience || watch.should_stop() {
            break;
        }
        in_vain += 1;
        // Arc length up to every point.
        let mut reached = vec![0.0];
        for pair in points.windows(2) {
            reached.push(reached.last().copied().unwrap_or(0.0) + distance_rad(&pair[0], &pair[1]));
        }
        let total = reached.last().copied().unwrap_or(0.0);
        let (a, b) = (rng.uniform(0.0, total), rng.uniform(0.0, total));
        let (begin, end) = (a.min(b), a.max(b));
        let segment = |at: f64| reached.partition_point(|&r| r <= at).max(1).min(points.len() - 1);
        let (first, last) = (segment(begin), segment(end));
        if first == last {
            continue;
        }
        let place = |at: f64, segment: usize| {
            let span = reached[segment] - reached[segment - 1];
            let fraction = if span > 0.0 { (at - reached[segment - 1]) / span } else { 0.0 };
            lerp(&points[segment - 1], &points[segment], fraction)
        };
        let (q_begin, q_end) = (place(begin, first), place(end, last));
        // Less than a microradian is not worth a new corner.
        if distance_rad(&q_begin, &q_end) > end - begin - 1e-6 {
            continue;
        }
        let stretch = || [from_ref(&q_begin), &points[first..last], from_ref(&q_end)].concat();
        let mut cut = vec![q_begin.clone(), q_end.clone()];
        if !cuts.allow(&mut scratch, &q_begin, &q_end, stretch) {
            // What must stay upright may not allow the straight motion, but steps that bend.
            let Some(between) = cuts.clear.as_ref().unwrap_or(space).steered(&mut scratch, &q_begin, &q_end) else {
                continue;
            };
            cut.splice(1..1, between);
            if length_rad(&cut) > end - begin - 1e-6 {
                continue;
            }
        }
        let mut shorter = points[..first].to_vec();
        shorter.append(&mut cut);
        shorter.extend_from_slice(&points[last..]);
        points = shorter;
        in_vain = 0;
    }
    if settings.tries > 0 {
        points = prune(&cuts, &mut scratch, &points);
    }
    let shortened = Path { points };
    if shortened.length_rad() <= path.length_rad() { shortened } else { path.clone() }
}

fn length_rad(points: &[Vec<f64>]) -> f64 {
    points.windows(2).map(|pair| distance_rad(&pair[0], &pair[1])).sum()
}

/// Which shortcuts are allowed.
struct Cuts<'a> {
    space: &'a ArmSpace,
    clearance_m: f64,
    /// The space that keeps the wanted clearance everywhere; none if contact is all that is avoided.
    clear: Option<ArmSpace>,
    /// Clearance of the whole path at the beginning, up to the wanted one, metres.
    least_m: f64,
}

/// Distance between the configurations at which the clearance of a stretch is measured, rad. Measured more coarsely the
/// stretch seems to keep more clearance than it does, and a shortcut is asked for more.
const MEASURE_RAD: f64 = 0.1;

impl<'a> Cuts<'a> {
    fn new(space: &'a ArmSpace, scratch: &mut Scratch, path: &Path, clearance_m: f64) -> Self {
        let clear = (clearance_m > 0.0).then(|| space.keeping_clear(clearance_m, &[]));
        let measured = if clear.is_some() { measured_at(&path.points) } else { Vec::new() };
        let room = measured.iter().map(|q| space.room_m(scratch, q, clearance_m)).fold(clearance_m, f64::min);
        // What the path itself keeps, it must be allowed to keep.
        let least_m = (room - 2.0 * space.checker.margin_m()).max(0.0);
        Self { space, clearance_m, clear, least_m }
    }

    fn allow(&self, scratch: &mut Scratch, from: &[f64], to: &[f64], stretch: impl FnOnce() -> Vec<Vec<f64>>) -> bool {
        let Some(clear) = &self.clear else { return self.space.edge_is_free(scratch, from, to) };
        if clear.edge_is_free(scratch, from, to) {
            return true;
        }
        if !self.space.edge_is_free(scratch, from, to) {
            return false;
        }
        let measured = measured_at(&stretch());
        let near: Vec<&[f64]> = measured.iter().map(Vec::as_slice).collect();
        let checker = self.space.checker.keeping_clear(self.clearance_m, self.least_m, &near);
        ArmSpace { checker, ..self.space.clone() }.edge_is_free(scratch, from, to)
    }
}

/// Configurations along straight motions, all points among them.
fn measured_at(points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut measured: Vec<Vec<f64>> = points.first().cloned().into_iter().collect();
    for pair in points.windows(2) {
        let steps = (distance_rad(&pair[0], &pair[1]) / MEASURE_RAD).ceil().max(1.0) as usize;
        measured.extend((1..=steps).map(|k| lerp(&pair[0], &pair[1], k as f64 / steps as f64)));
    }
    measured
}

/// Joins every point with the farthest later point that it reaches straight.
fn prune(cuts: &Cuts<'_>, scratch: &mut Scratch, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let Some(start) = points.first() else { return Vec::new() };
    let mut kept = vec![start.clone()];
    let mut at = 0;
    while at + 1 < points.len() {
        let next = (at + 2..points.len())
            .rev()
            .find(|&later| cuts.allow(scratch, &points[at], &points[later], || points[at..=later].to_vec()))
            .unwrap_or(at + 1);
        kept.push(points[next].clone());
        at = next;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::{Bench, shelf_configurations};
    use crate::plan::{BirrtSettings, PlanOutcome, plan_path, walk_path};

    #[test]
    fn a_shortened_path_is_never_longer_keeps_its_ends_and_stays_free() {
        let bench = Bench::shelf();
        let space = bench.space();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let cells = shelf_configurations();
        let mut gained = 0.0;
        for seed in 0..6 {
            for pair in cells.windows(2) {
                let goals = [pair[1].clone()];
                let settings = BirrtSettings::default();
                let outcome = plan_path(&space, &pair[0], &goals, &settings, seed, &Watch::idle());
                let PlanOutcome::Found(found) = outcome else { panic!("{outcome:?}") };
                let shorten = || shorten(&space, &found.path, &ShortcutSettings::default(), seed, &Watch::idle());
                let short = shorten();
                assert!(short.length_rad() <= found.path.length_rad());
                gained += found.path.length_rad() - short.length_rad();
                assert_eq!(short.points.first(), found.path.points.first());
                assert_eq!(short.points.last(), found.path.points.last());
                assert_eq!(short, shorten(), "equal seeds give equal paths");
                assert_eq!(walk_path(&judge, &bench.dofs(), &bench.rest(), &short, 0.005), None);
            }
        }
        assert!(gained > 10.0, "thirty paths lose more than a third of a radian each: {gained}");
    }

    #[test]
    fn a_shortcut_with_clearance_comes_no_nearer_than_the_path_did_or_the_clearance() {
        let bench = Bench::shelf();
        let space = bench.space();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let judged_m = |path: &Path| {
            let fine = measured_at(&path.points);
            fine.windows(2)
                .flat_map(|pair| (0..10).map(|k| lerp(&pair[0], &pair[1], f64::from(k) / 10.0)))
                .map(|q| judge.distance_m(&q))
                .fold(f64::INFINITY, f64::min)
        };
        let settings = ShortcutSettings { clearance_m: 0.02, ..ShortcutSettings::default() };
        let cells = shelf_configurations();
        let (mut hugging, mut gained) = (0, 0.0);
        for (seed, pair) in cells.windows(2).enumerate() {
            let goals = [pair[1].clone()];
            let birrt = BirrtSettings::default();
            let outcome = plan_path(&space, &pair[0], &goals, &birrt, seed as u64, &Watch::idle());
            let PlanOutcome::Found(found) = outcome else { panic!("{outcome:?}") };
            let short = shorten(&space, &found.path, &settings, 1, &Watch::idle());
            let plain = shorten(&space, &found.path, &ShortcutSettings::default(), 1, &Watch::idle());
            let wanted = judged_m(&found.path).min(0.02);
            // 0.2 mm: the contact margin twice; the judge's GJK is 5e-5 off.
            assert!(judged_m(&short) >= wanted - 3e-4, "{} after {wanted}", judged_m(&short));
            hugging += usize::from(judged_m(&plain) < wanted - 3e-4);
            gained += found.path.length_rad() - short.length_rad();
        }
        assert!(hugging >= 1, "without clearance some shortcut must come nearer");
        assert!(gained > 2.0, "shortcuts with clearance must still shorten: {gained}");
    }

    #[test]
    fn short_paths_come_back_as_they_are() {
        let space = Bench::shelf().space();
        for points in [vec![], vec![vec![0.0; 7]], vec![vec![0.0; 7], vec![0.1; 7]]] {
            let path = Path { points };
            assert_eq!(shorten(&space, &path, &ShortcutSettings::default(), 1, &Watch::idle()), path);
        }
    }
}
