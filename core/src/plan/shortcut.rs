//! Taking detours out of a path.

use super::space::{ArmSpace, Path, distance_rad, lerp};
use crate::collision::Scratch;
use crate::rng::Rng;
use crate::watch::Watch;

/// How long to look for shortcuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShortcutSettings {
    /// Shortcuts tried between random places of the path.
    pub tries: usize,
}

impl Default for ShortcutSettings {
    fn default() -> Self {
        Self { tries: 100 }
    }
}

/// The path without detours: never longer, with the same ends, and with motions that are proven free.
///
/// First every point is joined with the farthest later point that it reaches straight; then random places on the path,
/// not only its points, are joined while that makes it shorter (Geraerts and Overmars 2007). Equal seeds give equal
/// paths.
pub fn shorten(space: &ArmSpace, path: &Path, settings: &ShortcutSettings, seed: u64, watch: &Watch<'_>) -> Path {
    let mut scratch = Scratch::default();
    let mut points = prune(space, &mut scratch, &path.points);
    let mut rng = Rng::new(seed, 0x7368_6f72_7463);
    for _ in 0..settings.tries {
        if points.len() <= 2 || watch.should_stop() {
            break;
        }
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
        if distance_rad(&q_begin, &q_end) > end - begin - 1e-6 || !space.edge_is_free(&mut scratch, &q_begin, &q_end) {
            continue;
        }
        let mut shorter = points[..first].to_vec();
        shorter.extend([q_begin, q_end]);
        shorter.extend_from_slice(&points[last..]);
        points = shorter;
    }
    let shortened = Path { points: prune(space, &mut scratch, &points) };
    if shortened.length_rad() <= path.length_rad() { shortened } else { path.clone() }
}

/// Joins every point with the farthest later point that it reaches straight.
fn prune(space: &ArmSpace, scratch: &mut Scratch, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let Some(start) = points.first() else { return Vec::new() };
    let mut kept = vec![start.clone()];
    let mut at = 0;
    while at + 1 < points.len() {
        let next = (at + 2..points.len())
            .rev()
            .find(|&later| space.edge_is_free(scratch, &points[at], &points[later]))
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
    fn short_paths_come_back_as_they_are() {
        let space = Bench::shelf().space();
        for points in [vec![], vec![vec![0.0; 7]], vec![vec![0.0; 7], vec![0.1; 7]]] {
            let path = Path { points };
            assert_eq!(shorten(&space, &path, &ShortcutSettings::default(), 1, &Watch::idle()), path);
        }
    }
}
