//! Diverse routes of the hand through free space, without random numbers (thesis 8.2; Huamán Quispe, Kunz and Stilman
//! 2013).
//!
//! [`diverse_routes`] measures free voxels from the start and from the goal. The first route is the shortest one. Further
//! ones lead through midpoints: cells about as far from the start as from the goal, by less than twice the shortest way,
//! that no midpoint before sees in a straight line, so that something stands between any two routes. Each route is
//! straightened where the straight line is proven free, and its corners are rounded.
//!
//! A route is one for a ball around the hand, whatever its rotation: [`super::follow_route`] asks whether the arm can
//! follow it.

use nalgebra::{Isometry3, Point3, Translation3};

use super::hand_grid::{FAR, FreeSpace};
use super::hand_route::HandRoute;
use crate::watch::Watch;

/// Midpoints are this near to equally far from start and goal, in tenths of a cell.
const MIDDLE: u32 = 20;
/// Straight ways back from a pose are tried in such steps, metres.
const RETREAT_STEP_M: f64 = 0.02;
/// No arm is longer than this, metres.
const LONGEST_RETREAT_M: f64 = 10.0;

/// How many routes, and how they leave and arrive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteSettings {
    /// Centre of the ball around the hand in the hand frame H, metres; its radius is in the room of the free space.
    pub center_H: Point3<f64>,
    /// Routes wanted.
    pub max_routes: usize,
    /// The hand leaves its start, and arrives at its goal, straight along the approach direction for at least this
    /// distance, metres, without turning.
    pub least_retreat_m: f64,
    /// It does so for at most this distance, until the ball around it has room, metres.
    pub most_retreat_m: f64,
    /// Corners are rounded from this distance before them to this distance behind them, metres.
    pub corner_m: f64,
}

impl Default for RouteSettings {
    fn default() -> Self {
        Self { center_H: Point3::origin(), max_routes: 5, least_retreat_m: 0.0, most_retreat_m: 0.2, corner_m: 0.06 }
    }
}

/// Why there is no route.
#[derive(Clone, Debug, PartialEq)]
pub enum RouteRefusal {
    /// The ball has no room at the start, nor straight back from it; the most room found, metres.
    StartBlocked { room_m: f64 },
    /// The ball has no room at the goal, nor straight back from it; the most room found, metres.
    GoalBlocked { room_m: f64 },
    /// Start and goal are in separate pockets; how many free cells the one of the start has.
    Separate { cells: usize },
    /// It was cancelled.
    Stopped,
}

/// Up to [`RouteSettings::max_routes`] routes between two hand poses X_WH, the shortest first, each out of sight of the
/// others; the same question always has the same answer.
///
/// # Errors
/// [`RouteRefusal`] when there is none.
pub fn diverse_routes(
    space: &FreeSpace<'_>,
    from: &Isometry3<f64>,
    to: &Isometry3<f64>,
    settings: &RouteSettings,
    watch: &Watch<'_>,
) -> Result<Vec<HandRoute>, RouteRefusal> {
    let (start, start_cell) = leave(space, from, settings).map_err(|room_m| RouteRefusal::StartBlocked { room_m })?;
    let (goal, goal_cell) = leave(space, to, settings).map_err(|room_m| RouteRefusal::GoalBlocked { room_m })?;
    let from_start = space.costs_from(start_cell, goal_cell);
    let shortest = from_start[goal_cell];
    if shortest == FAR {
        return Err(RouteRefusal::Separate { cells: from_start.iter().filter(|&&cost| cost != FAR).count() });
    }
    let from_goal = space.costs_from(goal_cell, start_cell);
    let through = |cell: usize| from_start[cell].saturating_add(from_goal[cell]);
    let is_middle =
        |cell: &usize| through(*cell) < 2 * shortest && from_start[*cell].abs_diff(from_goal[*cell]) <= MIDDLE;
    let mut midpoints: Vec<usize> = (0..from_start.len()).filter(is_middle).collect();
    // The cheapest first, in the order of the cells: the first of them is on a shortest route.
    midpoints.sort_by_key(|&cell| (through(cell), from_start[cell].abs_diff(from_goal[cell])));

    let mut middle = midpoints.first().copied().unwrap_or(start_cell);
    let mut routes = Vec::new();
    while routes.len() < settings.max_routes {
        if watch.should_stop() {
            return Err(RouteRefusal::Stopped);
        }
        let mut out: Vec<Point3<f64>> =
            space.descend(&from_start, middle).into_iter().rev().map(|cell| space.center(cell)).collect();
        let mut back: Vec<Point3<f64>> =
            space.descend(&from_goal, middle).into_iter().map(|cell| space.center(cell)).collect();
        out.insert(0, start);
        back.push(goal);
        routes.push(HandRoute::through(space, [&out, &back], [from, to], settings));
        midpoints.retain(|&cell| !space.cells_see(middle, cell));
        let Some(&next) = midpoints.get(midpoints.len() / 2) else { break };
        middle = next;
    }
    Ok(routes)
}

/// Where the ball stands once the hand has gone straight back from a pose as far as it must, and the free cell there;
/// otherwise the most room found.
fn leave(space: &FreeSpace<'_>, X_WH: &Isometry3<f64>, settings: &RouteSettings) -> Result<(Point3<f64>, usize), f64> {
    let mut most_room_m = f64::NEG_INFINITY;
    let mut back_m = settings.least_retreat_m;
    loop {
        let place = X_WH * Translation3::new(0.0, 0.0, -back_m) * settings.center_H;
        if let Some(cell) = space.free_cell_near(&place) {
            return Ok((place, cell));
        }
        most_room_m = most_room_m.max(space.room_outside_m(&place));
        back_m += RETREAT_STEP_M;
        // A distance that is no number ends the loop as well.
        if back_m.is_nan() || back_m > settings.most_retreat_m.min(LONGEST_RETREAT_M) {
            return Err(most_room_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::collision::{BallChecker, World};

    fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
        Isometry3::translation(x, y, z)
    }

    fn boxes(all: &[([f64; 3], [f64; 3])]) -> World {
        let mut world = World::new();
        for (center, size) in all {
            world.add_box("box", Vector3::from(*size), &at(center[0], center[1], center[2])).unwrap();
        }
        world
    }

    fn routes(world: &World, from: &Isometry3<f64>, to: &Isometry3<f64>) -> Result<Vec<HandRoute>, RouteRefusal> {
        let ball = BallChecker::new(world, 0.05);
        let room = |p: &Point3<f64>| ball.clearance_m(p);
        let space = FreeSpace::new(&Point3::origin(), [0.0, 0.8], 0.025, &room);
        let ask = || diverse_routes(&space, from, to, &RouteSettings::default(), &Watch::idle());
        assert_eq!(ask(), ask(), "the same answer always");
        ask()
    }

    #[test]
    fn a_wall_with_two_ways_round_has_a_route_on_either_side_and_over_it() {
        // A slab across the straight line, its ends and its top open; below is a floor.
        let world = boxes(&[([0.4, 0.05, 0.0], [0.05, 0.5, 0.5]), ([0.4, 0.0, -0.3], [1.0, 1.6, 0.1])]);
        let found = routes(&world, &at(0.2, 0.0, 0.0), &at(0.6, 0.0, 0.0)).unwrap();
        assert!(found.len() >= 3, "{}", found.len());
        let ball = BallChecker::new(&world, 0.05);
        let mut sides = std::collections::BTreeSet::new();
        for route in &found {
            let points = route.points();
            assert!((points[0] - Point3::new(0.2, 0.0, 0.0)).norm() < 1e-9);
            assert!((points[points.len() - 1] - Point3::new(0.6, 0.0, 0.0)).norm() < 1e-9);
            let mut least = f64::INFINITY;
            for pair in points.windows(2) {
                for step in 0..=20 {
                    least = least.min(ball.clearance_m(&(pair[0] + (pair[1] - pair[0]) * (f64::from(step) / 20.0))));
                }
            }
            assert!(least > 0.0 && (route.clearance_m - least).abs() < 0.004, "{least} m, told {}", route.clearance_m);
            let length: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
            assert!((route.length_m - length).abs() < 1e-9);
            // Where it passes the plane of the wall.
            let pair = points.windows(2).find(|pair| (pair[0].x - 0.4) * (pair[1].x - 0.4) <= 0.0).unwrap();
            let p = pair[0] + (pair[1] - pair[0]) * ((0.4 - pair[0].x) / (pair[1].x - pair[0].x));
            sides.insert(if p.z > 0.25 {
                "over"
            } else if p.y > 0.0 {
                "left"
            } else {
                "right"
            });
        }
        assert_eq!(sides.into_iter().collect::<Vec<_>>(), ["left", "over", "right"]);
        // The right end is nearer to the line than the left one: 0.2 m against 0.3 m.
        assert!(found[0].points().iter().any(|p| p.y < -0.2), "the shortest route comes first");
        assert!(found.iter().all(|route| route.length_m >= found[0].length_m - 0.02));
    }

    #[test]
    fn in_the_open_there_is_one_route_and_it_is_straight() {
        let found = routes(&World::new(), &at(0.2, -0.3, 0.0), &at(0.4, 0.3, 0.1)).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].length_m - 0.41_f64.sqrt()).abs() < 2e-3, "{}", found[0].length_m);
        assert_eq!(found[0].clearance_m, f64::INFINITY);
        let nowhere = routes(&World::new(), &at(0.2, -0.3, 0.0), &at(0.2, -0.3, 0.0)).unwrap();
        assert!(nowhere.len() == 1 && nowhere[0].length_m < 0.05);
    }

    #[test]
    fn a_hand_at_a_wall_backs_off_until_its_ball_has_room() {
        // The hand points up at a ceiling 3 cm above it.
        let world = boxes(&[([0.4, 0.0, 0.08], [0.6, 0.6, 0.1])]);
        let found = routes(&world, &at(0.3, 0.0, 0.0), &at(0.5, 0.0, 0.0)).unwrap();
        let [straight_out, straight_in] = found[0].retreats_m;
        assert!(straight_out > 0.019 && straight_out < 0.061 && straight_in > 0.019, "{:?}", found[0].retreats_m);
        assert!(found[0].points()[1].z < -0.019 && found[0].clearance_m > 0.0);
    }

    #[test]
    fn refusals_say_which_end_is_blocked_or_that_the_two_are_separate() {
        let block = boxes(&[([0.4, 0.0, 0.0], [0.3, 0.3, 0.6])]);
        let (inside, outside) = (at(0.4, 0.0, 0.0), at(0.0, 0.0, 0.0));
        assert!(
            matches!(routes(&block, &inside, &outside), Err(RouteRefusal::StartBlocked { room_m }) if room_m < -0.1)
        );
        assert!(matches!(routes(&block, &outside, &inside), Err(RouteRefusal::GoalBlocked { .. })));
        let far = at(2.0, 0.0, 0.0);
        assert!(matches!(routes(&block, &outside, &far), Err(RouteRefusal::GoalBlocked { room_m }) if room_m > 1.0));
        let wall = boxes(&[([0.3, 0.0, 0.0], [0.02, 3.0, 3.0])]);
        let Err(RouteRefusal::Separate { cells }) = routes(&wall, &outside, &at(0.6, 0.0, 0.0)) else { panic!() };
        assert!(cells > 1000);
    }
}
