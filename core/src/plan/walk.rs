//! Walking a finished motion once more, step by step, with the slow judge.

use super::space::Path;
use super::trajectory::Trajectory;
use crate::collision::{Exhaustive, Hit};
use crate::parallel;

/// The first collision met on a walk.
#[derive(Clone, Debug, PartialEq)]
pub struct WalkHit {
    /// Time of the trajectory, seconds; for a path, the index of the motion plus the fraction of it.
    pub at: f64,
    /// Positions of the joints that move.
    pub q: Vec<f64>,
    /// Who touches.
    pub hit: Hit,
}

/// Walks a trajectory at `density` steps per sample (4 is the house's measure) and tells the first collision.
///
/// * `dofs`: degree of freedom of each column of the trajectory.
/// * `q_rest`: one value per degree of freedom of the robot; columns of the trajectory replace theirs.
pub fn walk(
    judge: &Exhaustive,
    dofs: &[usize],
    q_rest: &[f64],
    trajectory: &Trajectory,
    density: usize,
) -> Option<WalkHit> {
    let mut stations = Vec::new();
    let density = density.max(1);
    for (k, pair) in trajectory.times_s.windows(2).enumerate() {
        let (Some(from), Some(to)) = (trajectory.positions.get(k), trajectory.positions.get(k + 1)) else { break };
        for step in 0..density {
            let u = step as f64 / density as f64;
            stations.push((pair[0] + (pair[1] - pair[0]) * u, between(from, to, u)));
        }
    }
    if let (Some(&time), Some(q)) = (trajectory.times_s.last(), trajectory.positions.last()) {
        stations.push((time, q.clone()));
    }
    first_collision(judge, dofs, q_rest, &stations)
}

/// Walks a path in steps of at most `step_rad` (Euclidean) and tells the first collision; see [`walk`].
pub fn walk_path(judge: &Exhaustive, dofs: &[usize], q_rest: &[f64], path: &Path, step_rad: f64) -> Option<WalkHit> {
    let mut stations = Vec::new();
    for (k, pair) in path.points.windows(2).enumerate() {
        let length = pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let steps = (length / step_rad.max(1e-5)).ceil().max(1.0) as usize;
        for step in 0..steps {
            let u = step as f64 / steps as f64;
            stations.push((k as f64 + u, between(&pair[0], &pair[1], u)));
        }
    }
    if let Some(q) = path.points.last() {
        stations.push((path.points.len() as f64 - 1.0, q.clone()));
    }
    first_collision(judge, dofs, q_rest, &stations)
}

fn between(from: &[f64], to: &[f64], u: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a * (1.0 - u) + b * u).collect()
}

fn first_collision(
    judge: &Exhaustive,
    dofs: &[usize],
    q_rest: &[f64],
    stations: &[(f64, Vec<f64>)],
) -> Option<WalkHit> {
    let hits = parallel::map(stations, |(at, q_moving)| {
        let mut q = q_rest.to_vec();
        for (&dof, &position) in dofs.iter().zip(q_moving) {
            if let Some(slot) = q.get_mut(dof) {
                *slot = position;
            }
        }
        if q_moving.len() != dofs.len() {
            q.clear();
        }
        judge.first_hit_with_balls(&q).map(|hit| WalkHit { at: *at, q: q_moving.clone(), hit })
    });
    hits.into_iter().flatten().next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::testing::Bench;

    #[test]
    fn a_collision_planted_between_two_samples_is_found_by_the_denser_walk_only() {
        // A thin plate stands where the hand passes between two samples.
        let bench = Bench::new(&[("plate", [0.8, 0.1, 0.3], [0.15, 0.005, 1.0])]);
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let at = |first: f64| vec![first, 1.2, 0.0, 0.5, 0.0, 0.0, 0.0];
        let positions: Vec<_> = (0..=4).map(|k| at(-0.6 + 0.3 * f64::from(k))).collect();
        let trajectory = Trajectory { times_s: vec![0.0, 0.01, 0.02, 0.03, 0.04], positions };
        let walk_at = |density| walk(&judge, &bench.dofs(), &bench.rest(), &trajectory, density);
        assert_eq!(walk_at(1), None, "the samples themselves stand beside the plate");
        let hit = walk_at(16).expect("sixteen steps per sample are 2 cm: less than the hand is wide");
        assert_eq!((hit.hit.a.as_str(), hit.hit.b.as_str()), ("plate", "l7"));
        assert!(hit.at > 0.01 && hit.at < 0.03, "{hit:?}");
        let path = Path { points: trajectory.positions.clone() };
        assert!(walk_path(&judge, &bench.dofs(), &bench.rest(), &path, 0.01).is_some());
        let clear = Bench::new(&[]);
        let judge = Exhaustive::new(&clear.model, &clear.world, None, &[]).unwrap();
        assert_eq!(walk(&judge, &bench.dofs(), &bench.rest(), &trajectory, 16), None);
    }

    #[test]
    fn a_trajectory_of_other_joints_is_not_waved_through() {
        let bench = Bench::new(&[]);
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let trajectory = Trajectory { times_s: vec![0.0, 0.01], positions: vec![vec![0.0; 3]; 2] };
        assert!(walk(&judge, &bench.dofs(), &bench.rest(), &trajectory, 4).is_some());
    }
}
