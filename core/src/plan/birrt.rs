//! Bidirectional RRT-Connect with a whole IK set as goals (IK-BiRRT; thesis 4.3; Kuffner and LaValle 2000; Berenson
//! et al. 2009).

use super::space::{ArmSpace, ConfigurationFault, Path, distance_rad, lerp};
use super::tree::Tree;
use crate::collision::{Hit, Scratch};
use crate::rng::Rng;
use crate::watch::Watch;

/// When to give up, and how far to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BirrtSettings {
    /// Nodes of both trees together.
    pub max_nodes: usize,
    /// Random configurations drawn.
    pub max_iterations: usize,
    /// Longest motion added in one piece, Euclidean, rad.
    pub step_rad: f64,
    /// Nearest goals to which the straight motion is tried first.
    pub straight_tries: usize,
    /// Goals that stand in the goal tree from the beginning.
    pub first_roots: usize,
    /// Chance per iteration that a further goal of the IK set is drawn as a root.
    pub root_chance: f64,
}

impl Default for BirrtSettings {
    fn default() -> Self {
        Self {
            max_nodes: 20_000,
            max_iterations: 20_000,
            step_rad: 1.0,
            straight_tries: 8,
            first_roots: 4,
            root_chance: 0.1,
        }
    }
}

/// What the search came to.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanOutcome {
    /// A path; all its motions are proven free.
    Found(Found),
    /// The start is not a configuration of the arm.
    StartInvalid { fault: ConfigurationFault },
    /// The start touches something.
    StartInCollision { pair: Hit },
    /// No goal is a configuration of the arm; `first` is the first one's fault, none if there are no goals at all.
    GoalsInvalid { first: Option<ConfigurationFault>, count: usize },
    /// Every goal within limits touches something; `first` is what the nearest goal touches.
    GoalsInCollision { first: Hit, count: usize },
    /// The search was given up.
    NoPath(NoPath),
    /// It was cancelled.
    Stopped,
}

/// How far a search came that found no path.
#[derive(Clone, Debug)]
pub struct NoPath {
    /// Nodes of both trees.
    pub nodes: usize,
    /// Configurations drawn.
    pub iterations: usize,
    /// Time it took by the watch, milliseconds. No result depends on it, and equality does not look at it.
    pub elapsed_ms: f64,
    /// The two nearest configurations that the trees tried to join: one reached from the start, one from a goal.
    pub nearest: Option<[Vec<f64>; 2]>,
    /// How far they are apart, rad; infinite if no join was tried.
    pub nearest_gap_rad: f64,
}

impl PartialEq for NoPath {
    fn eq(&self, other: &Self) -> bool {
        let all = |this: &Self| (this.nodes, this.iterations, this.nearest.clone(), this.nearest_gap_rad);
        all(self) == all(other)
    }
}

/// A path and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// From the start to the goal.
    pub path: Path,
    /// Index of the goal that was reached.
    pub goal: usize,
    /// Nodes of both trees; 0 when a straight motion was enough.
    pub nodes: usize,
    /// Configurations drawn.
    pub iterations: usize,
}

/// Goals in the order of their distance to the start, each checked when first asked for.
struct Goals<'a> {
    all: &'a [Vec<f64>],
    /// Indices not yet drawn, nearest first.
    waiting: std::collections::VecDeque<usize>,
    first_hit: Option<Hit>,
    in_collision: usize,
}

impl Goals<'_> {
    /// Takes the waiting goal at a position out; `None` if it touches something.
    fn take(&mut self, space: &ArmSpace, scratch: &mut Scratch, position: usize) -> Option<usize> {
        let goal = self.waiting.remove(position)?;
        match space.first_hit(scratch, &self.all[goal]) {
            None => Some(goal),
            Some(hit) => {
                self.in_collision += 1;
                self.first_hit.get_or_insert(hit);
                None
            }
        }
    }
}

/// Searches a path of the arm from `start` to any of `goals`; equal seeds give equal paths.
pub fn plan_path(
    space: &ArmSpace,
    start: &[f64],
    goals: &[Vec<f64>],
    settings: &BirrtSettings,
    seed: u64,
    watch: &Watch<'_>,
) -> PlanOutcome {
    let mut scratch = Scratch::default();
    let scratch = &mut scratch;
    if let Some(fault) = space.fault(start) {
        return PlanOutcome::StartInvalid { fault };
    }
    if let Some(pair) = space.first_hit(scratch, start) {
        return PlanOutcome::StartInCollision { pair };
    }
    let mut inside: Vec<usize> = (0..goals.len()).filter(|&index| space.fault(&goals[index]).is_none()).collect();
    if inside.is_empty() {
        let first = goals.first().and_then(|goal| space.fault(goal));
        return PlanOutcome::GoalsInvalid { first, count: goals.len() };
    }
    inside.sort_by(|&a, &b| distance_rad(start, &goals[a]).total_cmp(&distance_rad(start, &goals[b])));
    let mut goals = Goals { all: goals, waiting: inside.into(), first_hit: None, in_collision: 0 };

    let mut goal_tree = Tree::new(space.dimension());
    let mut tried = 0;
    while tried < settings.straight_tries.max(settings.first_roots).max(1) && !goals.waiting.is_empty() {
        if watch.should_stop() {
            return PlanOutcome::Stopped;
        }
        let Some(goal) = goals.take(space, scratch, 0) else { continue };
        let q_goal = &goals.all[goal];
        if tried < settings.straight_tries && space.edge_is_free(scratch, start, q_goal) {
            let path = Path { points: vec![start.to_vec(), q_goal.clone()] };
            return PlanOutcome::Found(Found { path, goal, nodes: 0, iterations: 0 });
        }
        tried += 1;
        goal_tree.add_root(q_goal, goal);
    }
    if goal_tree.len() == 0 {
        return match goals.first_hit {
            Some(first) => PlanOutcome::GoalsInCollision { first, count: goals.in_collision },
            None => PlanOutcome::GoalsInvalid { first: None, count: 0 },
        };
    }
    let mut start_tree = Tree::new(space.dimension());
    start_tree.add_root(start, 0);
    search(space, scratch, start_tree, goal_tree, goals, settings, seed, watch)
}

#[expect(clippy::too_many_arguments, reason = "the second half of one function")]
fn search(
    space: &ArmSpace,
    scratch: &mut Scratch,
    mut start_tree: Tree,
    mut goal_tree: Tree,
    mut goals: Goals<'_>,
    settings: &BirrtSettings,
    seed: u64,
    watch: &Watch<'_>,
) -> PlanOutcome {
    let step = if settings.step_rad > 1e-3 { settings.step_rad } else { 1e-3 };
    let mut rng = Rng::new(seed, 0x0062_6972_7274);
    let begin_ms = watch.now_ms();
    let mut nearest = None;
    let mut nearest_gap_rad = f64::INFINITY;
    let mut iterations = 0;
    let mut q_random = vec![0.0; space.dimension()];
    while iterations < settings.max_iterations && start_tree.len() + goal_tree.len() < settings.max_nodes {
        iterations += 1;
        if iterations % 16 == 0 && watch.should_stop() {
            return PlanOutcome::Stopped;
        }
        if !goals.waiting.is_empty() && rng.unit() < settings.root_chance {
            let position = rng.index(goals.waiting.len());
            if let Some(goal) = goals.take(space, scratch, position) {
                goal_tree.add_root(&goals.all[goal], goal);
            }
        }
        for (value, (lower, upper)) in q_random.iter_mut().zip(space.lower.iter().zip(&space.upper)) {
            *value = rng.uniform(*lower, *upper);
        }
        // The smaller tree explores, the larger one connects: both sides of a narrow door get their share.
        let from_start = start_tree.len() <= goal_tree.len();
        let (explorer, connector) =
            if from_start { (&mut start_tree, &mut goal_tree) } else { (&mut goal_tree, &mut start_tree) };
        let (near, gap) = explorer.nearest(&q_random);
        let q_new = lerp(explorer.node(near), &q_random, if gap > step { step / gap } else { 1.0 });
        if !space.edge_is_free(scratch, explorer.node(near), &q_new) {
            continue;
        }
        let new = explorer.add(&q_new, near);
        let (mut tip, mut gap) = connector.nearest(&q_new);
        let joined = loop {
            if gap < nearest_gap_rad {
                nearest_gap_rad = gap;
                let reached = connector.node(tip).to_vec();
                nearest = Some(if from_start { [q_new.clone(), reached] } else { [reached, q_new.clone()] });
            }
            let reaches = gap <= step;
            let q_next = if reaches { q_new.clone() } else { lerp(connector.node(tip), &q_new, step / gap) };
            if !space.edge_is_free(scratch, connector.node(tip), &q_next) {
                break None;
            }
            if reaches {
                break Some(tip);
            }
            tip = connector.add(&q_next, tip);
            gap = distance_rad(&q_next, &q_new);
        };
        if let Some(tip) = joined {
            let nodes = explorer.len() + connector.len();
            let (start_end, goal_end) = if from_start { (new, tip) } else { (tip, new) };
            let mut points = start_tree.to_root(start_end);
            points.reverse();
            let mut tail = goal_tree.to_root(goal_end);
            if points.last() == tail.first() {
                tail.remove(0);
            }
            points.extend(tail);
            let goal = goal_tree.origin(goal_end);
            return PlanOutcome::Found(Found { path: Path { points }, goal, nodes, iterations });
        }
    }
    let (nodes, elapsed_ms) = (start_tree.len() + goal_tree.len(), watch.now_ms() - begin_ms);
    PlanOutcome::NoPath(NoPath { nodes, iterations, elapsed_ms, nearest, nearest_gap_rad })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::{Bench, shelf_configurations};
    use crate::plan::walk_path;

    #[test]
    fn the_arm_goes_from_shelf_cell_to_shelf_cell_and_equal_seeds_give_equal_paths() {
        let bench = Bench::shelf();
        let space = bench.space();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let cells = shelf_configurations();
        let settings = BirrtSettings::default();
        let mut searched = 0;
        for (k, pair) in cells.windows(2).enumerate() {
            let goals = [pair[1].clone()];
            let plan = |seed| plan_path(&space, &pair[0], &goals, &settings, seed, &Watch::idle());
            let PlanOutcome::Found(found) = plan(7) else { panic!("cell {k}: {:?}", plan(7)) };
            assert_eq!(found.path.points.first(), Some(&pair[0]));
            assert_eq!(found.path.points.last(), Some(&pair[1]));
            assert_eq!(walk_path(&judge, &bench.dofs(), &bench.rest(), &found.path, 0.005), None, "cell {k}");
            assert_eq!(plan(7), PlanOutcome::Found(found.clone()));
            if found.nodes > 0 {
                searched += 1;
                assert_ne!(plan(8), PlanOutcome::Found(found), "another seed searches elsewhere");
            }
        }
        assert!(searched >= 3, "straight motions alone would test nothing: {searched} searches");
    }

    #[test]
    fn a_start_that_touches_is_named_and_so_are_goals() {
        let bench = Bench::shelf();
        let space = bench.space();
        let cells = shelf_configurations();
        // Stretched out forwards the arm pierces the back of the shelf.
        let inside_wall = vec![0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0, 0.0, 0.0];
        let settings = BirrtSettings::default();
        let plan = |start: &[f64], goals: &[Vec<f64>]| plan_path(&space, start, goals, &settings, 1, &Watch::idle());
        let PlanOutcome::StartInCollision { pair } = plan(&inside_wall, &cells) else { panic!("must touch") };
        assert!(pair.a.starts_with('l') && pair.b.starts_with("board"), "{pair}");
        let goals = [inside_wall.clone(), inside_wall.clone()];
        let PlanOutcome::GoalsInCollision { first, count } = plan(&cells[0], &goals) else { panic!("must touch") };
        assert!(first.b.starts_with("board") && count == 2, "{first}");
        let one_good = [inside_wall, cells[1].clone()];
        assert!(matches!(plan(&cells[0], &one_good), PlanOutcome::Found(Found { goal: 1, .. })));
    }

    #[test]
    fn lists_that_are_no_configurations_are_refused_with_the_joint() {
        let bench = Bench::shelf();
        let space = bench.space();
        let cells = shelf_configurations();
        let settings = BirrtSettings::default();
        let plan = |start: &[f64], goals: &[Vec<f64>]| plan_path(&space, start, goals, &settings, 1, &Watch::idle());
        let mut beyond = cells[0].clone();
        beyond[3] = 3.0;
        let PlanOutcome::StartInvalid { fault } = plan(&beyond, &cells) else { panic!("beyond its limit") };
        assert!(matches!(fault, ConfigurationFault::OutsideLimits { joint, found: 3.0, .. } if joint == "j4"));
        assert!(matches!(plan(&[0.0; 3], &cells), PlanOutcome::StartInvalid { .. }));
        assert!(matches!(plan(&[f64::NAN; 7], &cells), PlanOutcome::StartInvalid { .. }));
        assert!(matches!(plan(&cells[0], &[beyond]), PlanOutcome::GoalsInvalid { first: Some(_), count: 1 }));
        assert_eq!(plan(&cells[0], &[]), PlanOutcome::GoalsInvalid { first: None, count: 0 });
    }

    #[test]
    fn a_search_ends_when_it_is_cancelled_or_its_budget_is_spent() {
        let bench = Bench::shelf();
        let space = bench.space();
        let cells = shelf_configurations();
        let (start, goal) = (cells[0].clone(), [cells[1].clone()]);
        // Fifty motions of 0.02 rad lead nowhere.
        let settings = BirrtSettings { max_iterations: 50, step_rad: 0.02, ..BirrtSettings::default() };
        let clock = std::sync::atomic::AtomicU32::new(0);
        let now_ms = || f64::from(clock.fetch_add(1, std::sync::atomic::Ordering::Relaxed));
        let watch = Watch::new(&|| false, &|_, _| (), &now_ms);
        let outcome = plan_path(&space, &start, &goal, &settings, 1, &watch);
        let PlanOutcome::NoPath(found) = outcome.clone() else { panic!("{outcome:?}") };
        assert!(found.iterations == 50 && found.nodes > 2 && found.elapsed_ms > 0.0, "{found:?}");
        let [reached, wanted] = found.nearest.unwrap();
        assert!((distance_rad(&reached, &wanted) - found.nearest_gap_rad).abs() < 1e-12);
        assert!(found.nearest_gap_rad > 0.0 && found.nearest_gap_rad <= distance_rad(&start, &goal[0]));
        // Fifty motions of 0.02 rad from the start are on its side, those from the goal on the goal's.
        assert!(distance_rad(&start, &reached) <= 1.0 && distance_rad(&goal[0], &wanted) <= 1.0);
        // Another clock, the same outcome.
        assert_eq!(plan_path(&space, &start, &goal, &settings, 1, &Watch::idle()), outcome);
        let stop = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        assert_eq!(plan_path(&space, &start, &goal, &settings, 1, &stop), PlanOutcome::Stopped);
    }

    #[test]
    fn further_goals_are_drawn_from_the_ik_set_while_planning() {
        let bench = Bench::shelf();
        let space = bench.space();
        let cells = shelf_configurations();
        let settings =
            BirrtSettings { straight_tries: 0, first_roots: 1, root_chance: 1.0, ..BirrtSettings::default() };
        let reached: std::collections::BTreeSet<usize> = (0..20)
            .filter_map(|seed| match plan_path(&space, &cells[0], &cells[1..], &settings, seed, &Watch::idle()) {
                PlanOutcome::Found(found) => Some(found.goal),
                _ => None,
            })
            .collect();
        assert!(reached.len() > 1, "always the same goal: {reached:?}");
    }
}
