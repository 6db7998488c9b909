//! From place to place by the planner of the settings: a search, a roadmap, or one of several routes of the hand.

use std::cell::OnceCell;

use nalgebra::{Isometry3, Point3};

use super::motion::Mover;
use super::setback::Blocked;
use super::{Planner, Route};
use crate::collision::{BallChecker, Scratch, World};
use crate::plan::{
    ArmSpace, BirrtSettings, ClearPath, ClearSettings, EdgeCause, FollowReason, FollowSettings, FollowStop, Followed,
    FollowingArm, FreeSpace, NoPath, Path, PlanOutcome, Roadmap, RoadmapSettings, RouteRefusal, RouteSettings,
    ShortcutSettings, diverse_routes, follow_route, plan_by_roadmap, plan_clear_path, plan_path, shorten,
};

/// Searches of which the shortest path is taken: an RRT's first path may be a long way round.
const SEARCHES: u64 = 4;
/// Nodes of a roadmap; the last of them are used only in hard cases.
const ROADMAP_NODES: usize = 2048;
/// The ball that stands for the hand while routes are looked for: its radius, and its centre in the hand frame H,
/// metres. It need not hold all of the hand: whether the arm can follow is proven with all bodies.
const BALL_M: f64 = 0.06;
const BALL_CENTER_H: [f64; 3] = [0.0, 0.0, -0.02];
/// Edge of the voxels in which routes are looked for, metres.
const CELL_M: f64 = 0.025;
/// Routes go round the shoulder at this distance at least, metres.
const INNER_M: f64 = 0.2;
/// Two hand poses nearer than this are one, metres and radians.
const SAME_POSE: f64 = 1e-6;

/// A way to one of several goals.
pub(super) struct Found {
    pub(super) path: Path,
    /// Index of the start that it begins at.
    pub(super) start: usize,
    /// Index of the goal that it ends at.
    pub(super) goal: usize,
    /// The space in which it was found: with the clearance that it keeps.
    pub(super) space: ArmSpace,
    /// The same space without a clearance: its distances are those of the bodies as they are.
    pub(super) plain: ArmSpace,
}

/// A hand pose, indices of configurations that have it, and these.
type AtOnePose = (Isometry3<f64>, Vec<usize>, Vec<Vec<f64>>);

/// The roadmap of an arm, made when it is first asked for.
#[derive(Default)]
pub(super) struct RoadmapOnce(OnceCell<Roadmap>);

impl Mover<'_> {
    /// A way to any of the goals that keeps the wanted clearance where there is room; a roadmap's if the settings want
    /// no random numbers.
    pub(super) fn search(&self, space: &ArmSpace, start: &[f64], goals: &[Vec<f64>]) -> Result<Found, Blocked> {
        match self.settings.planner {
            Planner::Search => self.searched(space, start, goals),
            Planner::Roadmap | Planner::Routes => self.on_roadmap(space, start, goals),
        }
    }

    fn searched(&self, space: &ArmSpace, start: &[f64], goals: &[Vec<f64>]) -> Result<Found, Blocked> {
        // Of several ways without their plain detours the shortest is shortened in earnest.
        let pruned = ShortcutSettings { tries: 0, ..ShortcutSettings::default() };
        let settings =
            ClearSettings { clearance_m: self.settings.clearance_m, shortcut: pruned, ..ClearSettings::default() };
        let clear = plan_clear_path(space, start, goals, &settings, self.seed, &self.watch);
        let ClearPath { found, space: clear, .. } = clear.map_err(|outcome| not_found(outcome, space, start, goals))?;
        // A straight way is not made shorter by another search.
        let searches = if found.nodes == 0 { 1 } else { SEARCHES };
        let mut best = Found { path: found.path, start: 0, goal: found.goal, space: clear, plain: space.clone() };
        for attempt in 1..searches {
            let seed = self.seed.wrapping_add(attempt);
            let outcome = plan_path(&best.space, start, goals, &BirrtSettings::default(), seed, &self.watch);
            let PlanOutcome::Found(found) = outcome else { break };
            let path = shorten(&best.space, &found.path, &pruned, seed, &self.watch);
            if path.length_rad() < best.path.length_rad() {
                best = Found { path, goal: found.goal, ..best };
            }
        }
        best.path = shorten(&best.space, &best.path, &ShortcutSettings::default(), self.seed, &self.watch);
        Ok(best)
    }

    fn on_roadmap(&self, space: &ArmSpace, start: &[f64], goals: &[Vec<f64>]) -> Result<Found, Blocked> {
        let roadmap = self.roadmap.0.get_or_init(|| Roadmap::new(&space.lower, &space.upper, ROADMAP_NODES));
        let clear = space.keeping_clear(self.settings.clearance_m, &[start]);
        let usual = RoadmapSettings::default();
        // Where no way keeps clear, one that touches nothing will do.
        for (clear, settings) in [(&clear, RoadmapSettings { rounds: 4, ..usual }), (space, usual)] {
            if let PlanOutcome::Found(found) = plan_by_roadmap(clear, roadmap, start, goals, &settings, &self.watch) {
                // Places that are drawn, but the same ones whatever the scene's seed is.
                let path = shorten(clear, &found.path, &ShortcutSettings::default(), 0, &self.watch);
                return Ok(Found { path, start: 0, goal: found.goal, space: clear.clone(), plain: space.clone() });
            }
        }
        let outcome = plan_by_roadmap(space, roadmap, start, goals, &usual, &self.watch);
        Err(not_found(outcome, space, start, goals))
    }

    /// Several clearly different routes of the hand from any of the starts to any of the goals, and the way of the one
    /// that is chosen.
    ///
    /// Starts and goals at the hand pose of the first ones count. `duration_s` times a way.
    pub(super) fn by_routes(
        &self,
        space: &ArmSpace,
        among: &World,
        starts: &[Vec<f64>],
        goals: &[Vec<f64>],
        duration_s: &dyn Fn(&Path) -> Option<f64>,
    ) -> (Vec<Route>, Result<Found, Blocked>) {
        let (Some((from, start_of, starts)), Some((to, goal_of, goals))) =
            (self.at_one_pose(starts), self.at_one_pose(goals))
        else {
            return (Vec::new(), Err(Blocked::because("no configuration of the arm")));
        };
        let ik = &self.cell.ik;
        let X_WB = self.cell.robot.link_poses(&self.cell.q_start)[self.cell.arm().base_link];
        let ball = BallChecker::new(among, BALL_M);
        let room = |p: &Point3<f64>| ball.clearance_m(p);
        let shoulder = X_WB * Point3::from(ik.chain().origin());
        let free = FreeSpace::new(&shoulder, [INNER_M, ik.chain().reach_m()], CELL_M, &room);
        let settings = RouteSettings { center_H: Point3::from(BALL_CENTER_H), ..RouteSettings::default() };
        let found = match diverse_routes(&free, &from, &to, &settings, &self.watch) {
            Ok(found) => found,
            Err(refusal) => return (Vec::new(), Err(Blocked::because(no_route(&refusal)))),
        };
        let arm = FollowingArm { ik, X_WB, starts: &starts, goals: Some(&goals) };
        let mut routes = Vec::new();
        let mut best: Option<Found> = None;
        let mut first: Option<Blocked> = None;
        for (number, hand) in found.iter().enumerate() {
            let mut route = Route {
                points_W: hand.points().to_vec(),
                length_m: hand.length_m,
                clearance_m: hand.clearance_m,
                duration_s: None,
                refused: None,
                chosen: false,
            };
            match follow_route(space, &arm, hand, &FollowSettings::default(), &self.watch) {
                Ok(followed) => {
                    let Followed { path, start, goal } = followed.followed;
                    route.duration_s = duration_s(&path);
                    if self.settings.route.map_or(best.is_none(), |wanted| wanted == number) {
                        route.chosen = true;
                        let (start, goal) = (start_of[start], goal_of[goal.unwrap_or(0)]);
                        best = Some(Found { path, start, goal, space: space.clone(), plain: space.clone() });
                    }
                }
                Err(stop) => {
                    let blocked = not_followed(&stop);
                    route.refused = Some(blocked.reason.clone());
                    if self.settings.route.is_none_or(|wanted| wanted == number) {
                        first = first.or(Some(blocked));
                    }
                }
            }
            routes.push(route);
        }
        let count = routes.len();
        let way = best.ok_or_else(|| match (first, self.settings.route) {
            (Some(blocked), Some(wanted)) => {
                Blocked { reason: format!("route {} of {count}: {}", wanted + 1, blocked.reason), ..blocked }
            }
            (Some(blocked), None) => {
                Blocked { reason: format!("none of {count} routes can be followed: {}", blocked.reason), ..blocked }
            }
            (None, Some(wanted)) => Blocked::because(format!("there is no route {}, there are {count}", wanted + 1)),
            (None, None) => Blocked::because("there is no route"),
        });
        (routes, way)
    }

    /// The hand pose of the first configuration, and those that share it with their indices.
    fn at_one_pose(&self, configurations: &[Vec<f64>]) -> Option<AtOnePose> {
        let pose = self.hand_pose(configurations.first()?);
        let same = |q: &Vec<f64>| {
            let off = pose.inv_mul(&self.hand_pose(q));
            off.translation.vector.norm() < SAME_POSE && off.rotation.angle() < SAME_POSE
        };
        let (indices, shared) = configurations.iter().cloned().enumerate().filter(|(_, q)| same(q)).unzip();
        Some((pose, indices, shared))
    }

    /// Pose of the hand frame in the world at a configuration of the arm.
    fn hand_pose(&self, q: &[f64]) -> Isometry3<f64> {
        let mut q_all = self.cell.q_start.clone();
        self.cell.arm().dofs.iter().zip(q).for_each(|(&dof, &position)| q_all[dof] = position);
        self.cell.robot.link_poses(&q_all)[self.cell.arm().hand.tcp_link]
    }
}

/// Why a search found nothing, for a person.
fn not_found(outcome: PlanOutcome, space: &ArmSpace, start: &[f64], goals: &[Vec<f64>]) -> Blocked {
    match outcome {
        PlanOutcome::StartInvalid { fault } => Blocked::because(format!("the start posture: {fault}")),
        PlanOutcome::StartInCollision { pair } => {
            Blocked::at(format!("in the start posture {} hits {}", pair.a, pair.b), &pair, start)
        }
        PlanOutcome::StartTilted { tilt } => Blocked::because(format!("in the start posture the hand is {tilt}")),
        PlanOutcome::GoalsTilted { least, count } => {
            Blocked::because(format!("at all {count} goals the hand is tilted too far, at the best one {least}"))
        }
        PlanOutcome::GoalsInvalid { count, .. } => {
            Blocked::because(format!("none of {count} goals is within the joint limits"))
        }
        PlanOutcome::GoalsInCollision { first, count } => {
            let reason = format!("at all {count} goals something is hit, first {} and {}", first.a, first.b);
            Blocked::at(reason, &first, goals.first().map_or(&[], Vec::as_slice))
        }
        PlanOutcome::NoPath(NoPath { nodes, iterations, nearest_gap_rad, nearest, .. }) => {
            let between = nearest.and_then(|[from, to]| {
                let blocked = space.edge_hit(&mut Scratch::default(), &from, &to)?;
                let at = |(a, b): (&f64, &f64)| a + (b - a) * blocked.fraction;
                Some((blocked.cause, from.iter().zip(&to).map(at).collect::<Vec<f64>>()))
            });
            let reason = format!(
                "no path among {nodes} nodes after {iterations} draws; the trees stayed {nearest_gap_rad:.2} rad apart"
            );
            match between {
                Some((EdgeCause::Contact(hit), q)) => Blocked::at(format!("{reason}, where {hit}"), &hit, &q),
                Some((EdgeCause::Tilted(tilt), _)) => Blocked::because(format!("{reason}, where the hand is {tilt}")),
                None => Blocked::because(reason),
            }
        }
        PlanOutcome::Found(_) | PlanOutcome::Stopped => Blocked::because("stopped"),
    }
}

fn no_route(refusal: &RouteRefusal) -> String {
    match refusal {
        RouteRefusal::StartBlocked { room_m } => format!("the hand has no room to leave: {:.0} mm", 1e3 * room_m),
        RouteRefusal::GoalBlocked { room_m } => format!("the hand has no room to arrive: {:.0} mm", 1e3 * room_m),
        RouteRefusal::Separate { cells } => {
            format!("the hand's start and goal lie in separate pockets; that of the start has {cells} cells")
        }
        RouteRefusal::Stopped => "stopped".to_owned(),
    }
}

fn not_followed(stop: &FollowStop) -> Blocked {
    let share = 100 * stop.pose / stop.poses.max(1);
    match &stop.reason {
        FollowReason::Invalid(Some(fault)) => Blocked::because(fault.to_string()),
        FollowReason::Invalid(None) => Blocked::because("no configuration of the arm"),
        FollowReason::Elsewhere { gap_m, .. } => Blocked::because(format!("the hand is {:.0} mm off it", 1e3 * gap_m)),
        FollowReason::NoIk(reject) => Blocked::because(format!("{} after {share} % of the way", reject.reason())),
        FollowReason::Blocked(hit) => Blocked {
            reason: format!("{} hits {} after {share} % of the way", hit.a, hit.b),
            culprits: vec![hit.a.clone(), hit.b.clone()],
            q: Vec::new(),
        },
        FollowReason::Jump { joint, .. } => {
            Blocked::because(format!("{joint} would have to jump after {share} % of the way"))
        }
        FollowReason::Stopped => Blocked::because("stopped"),
    }
}
