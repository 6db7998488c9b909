//! One route of the hand: a line of places, and the rotations on the way.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};

use super::following::{FollowReason, FollowSettings, FollowStop, Followed, FollowingArm, follow_hand};
use super::hand_grid::FreeSpace;
use super::routes::RouteSettings;
use super::space::ArmSpace;
use super::turning::Turnings;
use crate::watch::Watch;

/// Distance between the poses of a route, metres, and radians.
const STEP_M: f64 = 0.02;
const STEP_RAD: f64 = 0.1;
/// Distance between the places of a route at which its clearance is told, metres.
const CLEARANCE_STEP_M: f64 = 0.005;
/// Ways of turning that are tried.
const TURNINGS: usize = 12;
/// Rounds of moving corners inwards, and the steps of each.
const TIGHTENINGS: usize = 3;
const TIGHTENING_STEPS: usize = 8;
/// Pieces of a rounded corner.
const CORNER_PIECES: usize = 6;

/// A route of the hand from one pose to another.
#[derive(Clone, Debug, PartialEq)]
pub struct HandRoute {
    /// Places of the ball's centre, metres; straight in between.
    points: Vec<Point3<f64>>,
    /// Length of the line, metres.
    pub length_m: f64,
    /// Smallest distance between the ball and an obstacle, straight ways out and in left out, metres.
    pub clearance_m: f64,
    /// Length of the straight ways out and in, on which the hand does not turn, metres.
    pub retreats_m: [f64; 2],
    /// First and last hand pose X_WH.
    ends: [Isometry3<f64>; 2],
    center_H: Point3<f64>,
}

impl HandRoute {
    /// A route out to a middle and back in to the goal, as the cells say, made straight where that is free.
    pub(super) fn through(
        space: &FreeSpace<'_>,
        halves: [&[Point3<f64>]; 2],
        [from, to]: [&Isometry3<f64>; 2],
        settings: &RouteSettings,
    ) -> Self {
        // The middle stays where it is: without it, the second route would be pulled back to the first one's side.
        let mut line = straightened(space, halves[0]);
        line.extend(straightened(space, halves[1]).into_iter().skip(1));
        line.dedup();
        tighten(space, &mut line);
        let line = rounded(space, &line, settings.corner_m);
        let clearance_m = stations(&line, CLEARANCE_STEP_M).map(|p| space.room_m(&p)).fold(f64::INFINITY, f64::min);
        let mut points = line;
        let mut retreats_m = [0.0; 2];
        let ends = [from * settings.center_H, to * settings.center_H];
        for (end, retreat_m) in ends.iter().zip(&mut retreats_m) {
            let out = points.first().map_or(0.0, |first| (first - end).norm());
            if out > 1e-9 {
                *retreat_m = out;
                points.insert(0, *end);
            }
            points.reverse();
        }
        if points.len() == 1 {
            points.push(ends[1]);
        }
        let length_m = length(&points);
        Self { points, length_m, clearance_m, retreats_m, ends: [*from, *to], center_H: settings.center_H }
    }

    /// Places of the ball's centre, metres; straight in between.
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// First and last hand pose X_WH.
    pub(super) fn ends(&self) -> [Isometry3<f64>; 2] {
        self.ends
    }

    /// Centre of the ball in the hand frame.
    pub(super) fn center_H(&self) -> &Point3<f64> {
        &self.center_H
    }

    /// Hand poses X_WH along the route, at most 2 cm and 0.1 rad apart, both ends included.
    ///
    /// The ball's centre moves along the line; between the straight ways out and in the hand turns about it by slerp.
    pub fn poses(&self) -> Vec<Isometry3<f64>> {
        let places = self.turning_places(f64::INFINITY);
        let [from, to] = self.ends.map(|X_WH| X_WH.rotation);
        let free_m = length(&places);
        let mut passed_m = 0.0;
        let mut corners = Vec::with_capacity(places.len());
        for (k, place) in places.iter().enumerate() {
            passed_m += if k > 0 { (place - places[k - 1]).norm() } else { 0.0 };
            let share = match k + 1 == places.len() {
                true => 1.0,
                false if k == 0 => 0.0,
                false => passed_m / free_m,
            };
            corners.push((*place, slerp(&from, &to, share)));
        }
        self.poses_through(&corners).0
    }

    /// Places of the line between the straight ways out and in, its corners included, at most so far apart.
    pub(super) fn turning_places(&self, step_m: f64) -> Vec<Point3<f64>> {
        let [out, back] = self.retreats_m.map(|retreat_m| usize::from(retreat_m > 0.0));
        let mut places: Vec<Point3<f64>> = stations(&self.points[out..self.points.len() - back], step_m).collect();
        if places.len() == 1 {
            places.push(places[0]);
        }
        places
    }

    /// Hand poses from one place and rotation to the next, with the straight ways out and in before and behind them, and
    /// for each pose the index of the corner that it comes from; `None` on the straight ways.
    pub(super) fn poses_through(
        &self,
        corners: &[(Point3<f64>, UnitQuaternion<f64>)],
    ) -> (Vec<Isometry3<f64>>, Vec<Option<usize>>) {
        let [from, to] = self.ends;
        let (mut poses, mut legs) = (vec![from], vec![None]);
        let place_of = |X_WH: &Isometry3<f64>| (X_WH * self.center_H, X_WH.rotation);
        let all: Vec<_> =
            std::iter::once(place_of(&from)).chain(corners.iter().copied()).chain([place_of(&to)]).collect();
        for (k, pair) in all.windows(2).enumerate() {
            let [(p, R), (p_next, R_next)] = [pair[0], pair[1]];
            let steps = ((p_next - p).norm() / STEP_M).max(R.angle_to(&R_next) / STEP_RAD - 1e-9).ceil().min(1e5);
            // A corner at the end of the line is where the line ends, to round-off.
            let steps =
                if (p_next - p).norm() < 1e-9 && R.angle_to(&R_next) < 1e-9 { 0 } else { steps.max(1.0) as usize };
            for step in 1..=steps {
                let share = step as f64 / steps as f64;
                poses.push(posed(&(p + (p_next - p) * share), slerp(&R, &R_next, share), &self.center_H));
                legs.push((k > 0 && k + 2 < all.len()).then(|| k - 1));
            }
        }
        // The last pose is the goal itself, not one that round-off has moved.
        if let Some(last) = poses.last_mut().filter(|_| legs.len() > 1) {
            *last = to;
        }
        (poses, legs)
    }
}

/// The hand pose X_WH with the ball's centre at a place.
pub(super) fn posed(place: &Point3<f64>, rotation: UnitQuaternion<f64>, center_H: &Point3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(place - rotation * center_H), rotation)
}

/// The shortest way of turning; half a turn has none: stay, then turn at the end.
fn slerp(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    from.try_slerp(to, share, 1e-9).unwrap_or(if share < 1.0 { *from } else { *to })
}

/// A way of the arm along a route.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowedRoute {
    /// The way.
    pub followed: Followed,
    /// The hand poses X_WH that it follows.
    pub poses: Vec<Isometry3<f64>>,
}

/// Follows a route: turning evenly all the way if the arm can, otherwise by rotations that it can have.
///
/// These come from a search over places times rotations (the quarter turns from the start's rotation, and the shortest
/// way to the goal's) for the cheapest way of turning with a free posture everywhere; where the arm cannot follow that
/// one either, the step of it that nothing passes is taken out, and the search asked again.
///
/// # Errors
/// [`FollowStop`] of the way of turning that came farthest.
pub fn follow_route(
    space: &ArmSpace,
    arm: &FollowingArm<'_>,
    route: &HandRoute,
    settings: &FollowSettings,
    watch: &Watch<'_>,
) -> Result<FollowedRoute, FollowStop> {
    let share = |stop: &FollowStop| stop.pose as f64 / stop.poses.max(1) as f64;
    let poses = route.poses();
    let mut farthest = match follow_hand(space, arm, &poses, settings, watch) {
        Ok(followed) => return Ok(FollowedRoute { followed, poses }),
        Err(stop) => stop,
    };
    let is_about_ends =
        matches!(farthest.reason, FollowReason::Invalid(_) | FollowReason::Elsewhere { .. } | FollowReason::Stopped);
    if is_about_ends || farthest.pose == 0 {
        return Err(farthest);
    }
    let mut turnings = Turnings::new(space, arm, route);
    for _ in 0..TURNINGS {
        let Some(turned) = turnings.cheapest() else { break };
        match follow_hand(space, arm, &turned.poses, settings, watch) {
            Ok(followed) => return Ok(FollowedRoute { followed, poses: turned.poses }),
            Err(stop) => {
                let is_new = turnings.forbid(&turned, stop.pose);
                if share(&stop) > share(&farthest) {
                    farthest = stop;
                }
                if !is_new || watch.should_stop() {
                    break;
                }
            }
        }
    }
    Err(farthest)
}

/// Joins every place with the farthest later one that it sees.
fn straightened(space: &FreeSpace<'_>, points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let Some(&first) = points.first() else { return Vec::new() };
    let mut kept = vec![first];
    let mut at = 0;
    while at + 1 < points.len() {
        at = (at + 2..points.len()).rev().find(|&later| space.sees(&points[at], &points[later])).unwrap_or(at + 1);
        kept.push(points[at]);
    }
    kept
}

/// Moves every corner towards the line between its neighbours, little by little and as far as both sides stay free, so
/// that the line keeps to its side of what it goes round.
fn tighten(space: &FreeSpace<'_>, line: &mut Vec<Point3<f64>>) {
    for _ in 0..TIGHTENINGS {
        for at in 1..line.len().saturating_sub(1) {
            let [before, corner, after] = [line[at - 1], line[at], line[at + 1]];
            let chord = after - before;
            let share = (corner - before).dot(&chord) / chord.norm_squared().max(1e-12);
            let foot = before + chord * share.max(0.0).min(1.0);
            for step in 1..=TIGHTENING_STEPS {
                let moved = corner + (foot - corner) * (step as f64 / TIGHTENING_STEPS as f64);
                if !(space.sees(&before, &moved) && space.sees(&moved, &after)) {
                    break;
                }
                line[at] = moved;
            }
        }
    }
    line.dedup_by(|a, b| (*a - *b).norm() < 1e-6);
}

/// Cuts corners by parabolas that touch both sides, where they are free.
fn rounded(space: &FreeSpace<'_>, line: &[Point3<f64>], corner_m: f64) -> Vec<Point3<f64>> {
    let mut round = line.first().copied().into_iter().collect::<Vec<_>>();
    for corner in line.windows(3) {
        let [before, at, after] = [corner[0], corner[1], corner[2]];
        let mut cut_m = corner_m.min(0.5 * (at - before).norm()).min(0.5 * (after - at).norm());
        let mut arc = vec![at];
        while cut_m > CLEARANCE_STEP_M {
            let from = at + (before - at) * (cut_m / (before - at).norm());
            let to = at + (after - at) * (cut_m / (after - at).norm());
            let place = |u: f64| from + (at - from) * (2.0 * u * (1.0 - u)) + (to - from) * (u * u);
            let trial: Vec<_> = (0..=CORNER_PIECES).map(|k| place(k as f64 / CORNER_PIECES as f64)).collect();
            if trial.windows(2).all(|pair| space.sees(&pair[0], &pair[1])) {
                arc = trial;
                break;
            }
            cut_m *= 0.5;
        }
        round.extend(arc);
    }
    round.extend(line.last().filter(|_| line.len() > 1));
    round.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
    round
}

fn length(points: &[Point3<f64>]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Places on a line at most so far apart, its corners included.
fn stations(points: &[Point3<f64>], step_m: f64) -> impl Iterator<Item = Point3<f64>> {
    let between = points.windows(2).flat_map(move |pair| {
        let steps = ((pair[1] - pair[0]).norm() / step_m).ceil().max(1.0) as usize;
        (0..steps).map(move |k| pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64))
    });
    between.chain(points.last().copied())
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::collision::{BallChecker, Exhaustive, Scratch};
    use crate::plan::testing::Bench;
    use crate::plan::{diverse_routes, walk_path};
    use crate::robot::ik::ArmIk;

    const START: [f64; 7] = [0.6, 0.9, 0.0, 1.2, 0.0, 0.7, 0.0];
    const GOAL: [f64; 7] = [-0.6, 0.9, 0.0, 1.2, 0.0, 0.7, 0.0];

    #[test]
    fn the_arm_follows_routes_on_different_sides_of_a_post_and_its_hand_keeps_to_them() {
        let bench = Bench::new(&[
            ("post", [0.5, 0.0, 0.025], [0.12, 0.04, 0.25]),
            ("floor", [0.5, 0.0, -0.2], [1.2, 1.6, 0.2]),
        ]);
        let (space, robot) = (bench.space(), bench.model.robot());
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let ik = ArmIk::of(robot, &robot.arms[0]).unwrap();
        let [from, to] = [START, GOAL].map(|q| robot.link_poses(&q)[7]);
        // Straight there the hand meets the post.
        assert!(space.edge_hit(&mut Scratch::default(), &START, &GOAL).is_some());
        let settings = RouteSettings { center_H: Point3::new(0.0, 0.0, 0.2024), ..RouteSettings::default() };
        let ball = BallChecker::new(&bench.world, 0.05);
        let room = |p: &Point3<f64>| ball.clearance_m(p);
        let free = FreeSpace::new(&Point3::new(0.0, 0.0, 0.3), [0.2, 0.85], 0.025, &room);
        let routes = diverse_routes(&free, &from, &to, &settings, &Watch::idle()).unwrap();
        assert!(routes.len() >= 3, "{}", routes.len());
        let starts = [START.to_vec()];
        let arm = FollowingArm { ik: &ik, X_WB: Isometry3::identity(), starts: &starts, goals: None };
        let mut sides = std::collections::BTreeSet::new();
        let mut stops = Vec::new();
        for route in &routes {
            let follow = || follow_route(&space, &arm, route, &FollowSettings::default(), &Watch::idle());
            let followed = follow();
            assert_eq!(followed, follow(), "the same answer always");
            let FollowedRoute { followed, poses } = match followed {
                Ok(followed) => followed,
                Err(stop) => {
                    stops.push(stop);
                    continue;
                }
            };
            let points = &followed.path.points;
            assert_eq!(walk_path(&judge, &bench.dofs(), &bench.rest(), &followed.path, 0.01), None);
            assert_eq!(points[0], START);
            let end = robot.link_poses(&points[points.len() - 1])[7];
            assert!((end.translation.vector - to.translation.vector).norm() < 1e-9);
            assert!(end.rotation.angle_to(&to.rotation) < 1e-6);
            // Two poses of a route are 2 cm apart at most, so its nearest pose is at most 1 cm from the hand, beside the
            // sag of 2 mm.
            for pair in points.windows(2) {
                let q: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| 0.5 * (a + b)).collect();
                let X_WH = robot.link_poses(&q)[7];
                let place = |X: &Isometry3<f64>| X * settings.center_H;
                let off = poses.iter().map(|pose| (place(pose) - place(&X_WH)).norm()).fold(f64::INFINITY, f64::min);
                assert!(off < 0.0125, "{off}");
            }
            let at = poses.iter().map(|pose| pose * settings.center_H).find(|p| p.y <= 0.0).unwrap();
            // The post reaches from x = 0.44 m to 0.56 m.
            sides.insert(if at.x < 0.4 {
                "inside"
            } else if at.x > 0.6 {
                "outside"
            } else {
                "over"
            });
        }
        assert!(sides.len() >= 2, "{sides:?}, {stops:?}");
    }

    #[test]
    fn poses_turn_evenly_between_the_straight_ways_and_never_by_more_than_the_steps() {
        let room = |p: &Point3<f64>| 0.3 - (p - Point3::new(0.0, 0.0, 0.3)).norm().min(0.2);
        let free = FreeSpace::new(&Point3::origin(), [0.0, 0.8], 0.05, &room);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 1.2, 0.9));
        let from = Isometry3::translation(0.3, 0.0, 0.0);
        let to = Isometry3::from_parts(Translation3::new(0.0, 0.3, 0.1), turn);
        let settings =
            RouteSettings { center_H: Point3::new(0.0, 0.0, 0.1), least_retreat_m: 0.06, ..RouteSettings::default() };
        let routes = diverse_routes(&free, &from, &to, &settings, &Watch::idle()).unwrap();
        let poses = routes[0].poses();
        assert_eq!((poses[0], poses[poses.len() - 1]), (from, to));
        for pair in poses.windows(2) {
            let moved = (pair[1] * settings.center_H - pair[0] * settings.center_H).norm();
            assert!(moved < 0.02 + 1e-9 && pair[0].rotation.angle_to(&pair[1].rotation) < 0.1 + 1e-6, "{moved}");
            assert!(moved > 1e-6, "it turns as it goes");
        }
        // Straight back along z, unturned, for 6 cm at either end.
        for (end, X_WH) in [(&poses[..4], &from), (&poses[poses.len() - 4..], &to)] {
            for pose in end {
                let back = X_WH.inv_mul(pose);
                assert!(back.rotation.angle() < 1e-6 && back.translation.vector.xy().norm() < 1e-9);
                assert!((-0.0600001..=1e-9).contains(&back.translation.z), "{}", back.translation.z);
            }
        }
    }

    #[test]
    fn a_corner_is_cut_only_where_that_is_free() {
        let corner = [Point3::new(0.1, 0.3, 0.0), Point3::new(0.3, 0.3, 0.0), Point3::new(0.3, 0.1, 0.0)];
        let open = |_: &Point3<f64>| f64::INFINITY;
        let free = FreeSpace::new(&Point3::origin(), [0.0, 0.5], 0.1, &open);
        let round = rounded(&free, &corner, 0.06);
        assert!(round.len() == CORNER_PIECES + 3 && length(&round) < 0.38, "{}", length(&round));
        let turns = round.windows(3).map(|p| (p[1] - p[0]).angle(&(p[2] - p[1]))).fold(0.0, f64::max);
        // A quarter turn in seven corners, the sharpest in the middle.
        assert!(turns < 0.35, "{turns}");
        // An obstacle where the widest arc would pass, so that half of it is left.
        let tight = |p: &Point3<f64>| (p - Point3::new(0.285, 0.285, 0.0)).norm() - 0.008;
        let free = FreeSpace::new(&Point3::origin(), [0.0, 0.5], 0.1, &tight);
        let round = rounded(&free, &corner, 0.06);
        assert!(
            length(&round) > 0.38
                && length(&round) < 0.395
                && round.windows(2).all(|pair| free.sees(&pair[0], &pair[1]))
        );
    }
}
