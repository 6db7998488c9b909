//! Searching a roadmap that is proven only where the search goes (Lazy PRM; Bohlin and Kavraki 2000).

use std::collections::HashMap;

use super::birrt::{Found, NoPath, PlanOutcome};
use super::low_discrepancy::EvenPoints;
use super::queue::Queue;
use super::roadmap::{Roadmap, nearest};
use super::space::{ArmSpace, Path, distance_rad, lerp};
use crate::collision::{Hit, Scratch};
use crate::watch::Watch;

/// How fine the roadmap becomes before the search is given up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoadmapSettings {
    /// Nodes of the roadmap in the first round; each further round takes twice as many.
    pub first_nodes: usize,
    /// Nearest goals to which the straight motion is tried first.
    pub straight_tries: usize,
    /// Nearest goals that the search looks for.
    pub goals: usize,
    /// Rounds in which an end that can go nowhere is given more nodes.
    pub rounds: usize,
}

impl Default for RoadmapSettings {
    fn default() -> Self {
        Self { first_nodes: 256, straight_tries: 8, goals: 8, rounds: 40 }
    }
}

/// Configurations that an end that can go nowhere is grown towards, per round.
const GROWTH: usize = 128;
/// Longest motion that is grown, rad.
const STEP_RAD: f64 = 1.0;
/// How many nodes of the roadmap a node that is not of it is joined with.
const NEIGHBOURS: usize = 16;

/// Searches a path of the arm from `start` to any of `goals` along a roadmap made for its limits; no random numbers.
///
/// From both ends the search goes on where the way promises to be short, and a motion is proven when the search wants to
/// use it. When one end can go nowhere, the roadmap is searched again with twice the nodes, and with configurations
/// grown from what that end has reached: so it leaves narrow places. In the answer `nodes` counts the configurations of the last round and `iterations` the motions that
/// were looked at. A path is the first one found; [`super::shorten`] takes its detours out.
///
/// * `roadmap`: [`Roadmap::new`] of the space's limits; its last nodes are used only in hard cases.
pub fn plan_by_roadmap(
    space: &ArmSpace,
    roadmap: &Roadmap,
    start: &[f64],
    goals: &[Vec<f64>],
    settings: &RoadmapSettings,
    watch: &Watch<'_>,
) -> PlanOutcome {
    let mut scratch = Scratch::default();
    if let Some(fault) = space.fault(start) {
        return PlanOutcome::StartInvalid { fault };
    }
    if let Some(pair) = space.first_hit(&mut scratch, start) {
        return PlanOutcome::StartInCollision { pair };
    }
    let mut inside: Vec<usize> = (0..goals.len()).filter(|&index| space.fault(&goals[index]).is_none()).collect();
    if inside.is_empty() {
        let first = goals.first().and_then(|goal| space.fault(goal));
        return PlanOutcome::GoalsInvalid { first, count: goals.len() };
    }
    inside.sort_by(|&a, &b| distance_rad(start, &goals[a]).total_cmp(&distance_rad(start, &goals[b])));
    let mut first_hit: Option<Hit> = None;
    let count = inside.len();
    let mut free = Vec::new();
    for goal in inside {
        if watch.should_stop() {
            return PlanOutcome::Stopped;
        }
        if let Some(hit) = space.first_hit(&mut scratch, &goals[goal]) {
            first_hit.get_or_insert(hit);
            continue;
        }
        if free.len() < settings.straight_tries && space.edge_is_free(&mut scratch, start, &goals[goal]) {
            let path = Path { points: vec![start.to_vec(), goals[goal].clone()] };
            return PlanOutcome::Found(Found { path, goal, nodes: 0, iterations: 0 });
        }
        free.push(goal);
        if free.len() == settings.goals.max(1) {
            break;
        }
    }
    match first_hit {
        Some(first) if free.is_empty() => return PlanOutcome::GoalsInCollision { first, count },
        _ => {}
    }
    Search::new(space, roadmap, start, goals, free, scratch).run(settings, watch)
}

/// Node numbers: those of the roadmap, then the start, the goals, and what was grown.
struct Search<'a> {
    space: &'a ArmSpace,
    roadmap: &'a Roadmap,
    /// Which goals the search looks for; their nodes follow that of the start.
    wanted: Vec<usize>,
    /// Nodes of the roadmap that count in this round.
    active: usize,
    /// Configurations that are not of the roadmap.
    added: Vec<f64>,
    /// Neighbours that are not both of the roadmap.
    links: Vec<Vec<(u32, f64)>>,
    /// Whether each node is free; unknown until asked.
    nodes: Vec<Option<bool>>,
    /// Whether each motion is free, smaller number first; unknown until asked.
    motions: HashMap<(u32, u32), bool>,
    scratch: Scratch,
    /// For each configuration that was grown, the node that it grew from.
    parents: Vec<usize>,
    /// Even configurations that were grown towards.
    drawn: usize,
}

/// One end of the search.
struct End {
    queue: Queue,
    /// Cost from this end, rad; infinite until settled.
    cost: Vec<f64>,
    before: Vec<u32>,
    settled: Vec<usize>,
}

const NONE: u32 = u32::MAX;

impl<'a> Search<'a> {
    fn new(
        space: &'a ArmSpace,
        roadmap: &'a Roadmap,
        start: &[f64],
        goals: &[Vec<f64>],
        wanted: Vec<usize>,
        scratch: Scratch,
    ) -> Self {
        let mut added = start.to_vec();
        wanted.iter().for_each(|&goal| added.extend_from_slice(&goals[goal]));
        Self {
            space,
            roadmap,
            wanted,
            active: 0,
            added,
            links: Vec::new(),
            nodes: Vec::new(),
            motions: HashMap::new(),
            scratch,
            parents: Vec::new(),
            drawn: 0,
        }
    }

    fn run(mut self, settings: &RoadmapSettings, watch: &Watch<'_>) -> PlanOutcome {
        let begin_ms = watch.now_ms();
        let mut gap_rad = f64::INFINITY;
        for round in 0..settings.rounds.max(1) {
            let twice = settings.first_nodes.max(1).saturating_mul(1 << round.min(32));
            // A roadmap of another arm has no nodes for this one.
            let usable = if self.roadmap.dimension() == self.space.dimension() { self.roadmap.len() } else { 0 };
            self.active = twice.min(usable);
            self.link();
            match self.join(watch) {
                Joined::Path(nodes) => return self.found(&nodes),
                Joined::Stopped => return PlanOutcome::Stopped,
                Joined::Apart { nearest_gap_rad, reached } => {
                    gap_rad = gap_rad.min(nearest_gap_rad);
                    self.grow(&reached);
                }
            }
        }
        let nodes = self.active + self.added.len() / self.space.dimension();
        let (iterations, elapsed_ms) = (self.motions.len(), watch.now_ms() - begin_ms);
        PlanOutcome::NoPath(NoPath { nodes, iterations, elapsed_ms, nearest: None, nearest_gap_rad: gap_rad })
    }

    /// Grows a tree from what an end that can go nowhere has reached, towards even configurations one after the other
    /// (LaValle and Kuffner 2001, without the random numbers).
    fn grow(&mut self, reached: &[usize]) {
        let even = EvenPoints::new(self.space.dimension());
        let mut nodes = reached.to_vec();
        let mut tree: Vec<f64> = reached.iter().flat_map(|&node| self.q(node).to_vec()).collect();
        let mut scratch = std::mem::take(&mut self.scratch);
        for _ in 0..GROWTH {
            let mut towards = Vec::with_capacity(self.space.dimension());
            even.push(self.drawn, &self.space.lower, &self.space.upper, &mut towards);
            self.drawn += 1;
            let Some(&(near, gap)) = nearest(&tree, &towards, 1).first() else { break };
            let q_near = self.q(nodes[near]);
            let q = if gap > STEP_RAD { lerp(q_near, &towards, STEP_RAD / gap) } else { towards };
            if self.space.edge_is_free(&mut scratch, q_near, &q) {
                let node = self.start() + self.added.len() / self.space.dimension();
                self.motions.insert((nodes[near] as u32, node as u32), true);
                self.parents.push(nodes[near]);
                tree.extend_from_slice(&q);
                self.added.extend(q);
                nodes.push(node);
            }
        }
        self.scratch = scratch;
    }

    fn q(&self, node: usize) -> &[f64] {
        let (fixed, dimension) = (self.roadmap.len(), self.space.dimension());
        match node.checked_sub(fixed) {
            None => self.roadmap.q(node),
            Some(added) => &self.added[added * dimension..(added + 1) * dimension],
        }
    }

    /// The node of the start; those of the goals follow.
    fn start(&self) -> usize {
        self.roadmap.len()
    }

    fn goal_nodes(&self) -> std::ops::Range<usize> {
        self.start() + 1..self.start() + 1 + self.wanted.len()
    }

    /// Joins everything that is not of the roadmap with what is near, in this round's roadmap and besides.
    fn link(&mut self) {
        let (dimension, fixed) = (self.space.dimension(), self.start());
        let added = self.added.len() / dimension;
        self.links = vec![Vec::new(); fixed + added];
        self.nodes.resize(fixed + added, None);
        for node in 0..added {
            let q = &self.added[node * dimension..(node + 1) * dimension];
            let of_roadmap = nearest(self.roadmap.first(self.active), q, NEIGHBOURS);
            let besides = nearest(&self.added[..node * dimension], q, NEIGHBOURS);
            for (other, distance) in
                of_roadmap.into_iter().chain(besides.into_iter().map(|(other, distance)| (fixed + other, distance)))
            {
                self.links[fixed + node].push((other as u32, distance));
                self.links[other].push(((fixed + node) as u32, distance));
            }
        }
        let first_grown = self.goal_nodes().end;
        for (grown, &parent) in self.parents.iter().enumerate() {
            let distance = distance_rad(self.q(first_grown + grown), self.q(parent));
            self.links[first_grown + grown].push((parent as u32, distance));
            self.links[parent].push(((first_grown + grown) as u32, distance));
        }
    }

    fn is_free(&mut self, node: usize) -> bool {
        if let Some(known) = self.nodes[node] {
            return known;
        }
        let mut scratch = std::mem::take(&mut self.scratch);
        // A roadmap made for wider limits has nodes outside of these.
        let q = self.q(node);
        let free = self.space.fault(q).is_none() && self.space.checker.is_free(&mut scratch, q);
        self.scratch = scratch;
        self.nodes[node] = Some(free);
        free
    }

    fn is_passable(&mut self, a: u32, b: u32) -> bool {
        let key = (a.min(b), a.max(b));
        if let Some(&known) = self.motions.get(&key) {
            return known;
        }
        let mut scratch = std::mem::take(&mut self.scratch);
        let free = self.space.edge_is_free(&mut scratch, self.q(key.0 as usize), self.q(key.1 as usize));
        self.scratch = scratch;
        self.motions.insert(key, free);
        free
    }

    /// Goes on from the end that has settled fewer nodes until both meet.
    fn join(&mut self, watch: &Watch<'_>) -> Joined {
        let count = self.links.len();
        let end = || End {
            queue: Queue::default(),
            cost: vec![f64::INFINITY; count],
            before: vec![NONE; count],
            settled: Vec::new(),
        };
        let mut ends = [end(), end()];
        ends[0].queue.push(0.0, self.start() as u32, NONE);
        self.goal_nodes().for_each(|goal| ends[1].queue.push(0.0, goal as u32, NONE));
        let mut turn = 0;
        loop {
            turn += 1;
            if turn % 16 == 0 && watch.should_stop() {
                return Joined::Stopped;
            }
            let side = usize::from(ends[1].settled.len() < ends[0].settled.len());
            let Some(waiting) = ends[side].queue.pop() else {
                let nearest_gap_rad = self.gap_rad(&ends);
                return Joined::Apart { nearest_gap_rad, reached: std::mem::take(&mut ends[side].settled) };
            };
            let node = waiting.node as usize;
            if ends[side].cost[node].is_finite() {
                continue;
            }
            let mut cost = 0.0;
            if waiting.from != NONE {
                if !self.is_passable(waiting.from, waiting.node) {
                    continue;
                }
                let from = waiting.from as usize;
                cost = ends[side].cost[from] + distance_rad(self.q(from), self.q(node));
            }
            ends[side].cost[node] = cost;
            ends[side].before[node] = waiting.from;
            ends[side].settled.push(node);
            if ends[1 - side].cost[node].is_finite() {
                let to_root = |end: &End| {
                    let mut way = vec![node];
                    while let Some(&last) = way.last().filter(|&&last| end.before[last] != NONE) {
                        way.push(end.before[last] as usize);
                    }
                    way
                };
                let mut way = to_root(&ends[0]);
                way.reverse();
                way.extend(to_root(&ends[1]).into_iter().skip(1));
                return Joined::Path(way);
            }
            let of_roadmap = if node < self.start() { self.roadmap.neighbours(node) } else { &[] };
            let of_roadmap = &of_roadmap[..of_roadmap.partition_point(|&(other, _)| (other as usize) < self.active)];
            let links = std::mem::take(&mut self.links[node]);
            for &(other, distance) in of_roadmap.iter().chain(&links) {
                let to = other as usize;
                if ends[side].cost[to].is_finite() {
                    continue;
                }
                if self.is_free(to) {
                    let key = cost + distance + self.least_rad(to, side);
                    ends[side].queue.push(key, other, waiting.node);
                }
            }
            self.links[node] = links;
        }
    }

    /// The straight distance from a node to the other end, rad.
    fn least_rad(&self, node: usize, side: usize) -> f64 {
        let q = self.q(node);
        if side == 1 {
            return distance_rad(q, self.q(self.start()));
        }
        self.goal_nodes().map(|goal| distance_rad(q, self.q(goal))).fold(f64::INFINITY, f64::min)
    }

    /// How near what was reached from the start comes to a goal, or from a goal to the start, rad.
    fn gap_rad(&self, ends: &[End; 2]) -> f64 {
        let of = |side: usize| {
            let settled = (0..self.links.len()).filter(move |&node| ends[side].cost[node].is_finite());
            settled.map(move |node| self.least_rad(node, side)).fold(f64::INFINITY, f64::min)
        };
        of(0).min(of(1))
    }

    fn found(&self, nodes: &[usize]) -> PlanOutcome {
        let points = nodes.iter().map(|&node| self.q(node).to_vec()).collect();
        let first_goal = self.goal_nodes().start;
        let goal = nodes.last().and_then(|&last| self.wanted.get(last.wrapping_sub(first_goal))).copied().unwrap_or(0);
        let nodes = self.active + self.added.len() / self.space.dimension();
        PlanOutcome::Found(Found { path: Path { points }, goal, nodes, iterations: self.motions.len() })
    }
}

enum Joined {
    /// Nodes from the start to a goal.
    Path(Vec<usize>),
    Apart {
        nearest_gap_rad: f64,
        /// Nodes reached from the end that could go nowhere.
        reached: Vec<usize>,
    },
    Stopped,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Exhaustive;
    use crate::plan::testing::{Bench, shelf_configurations};
    use crate::plan::{ConfigurationFault, walk_path};

    fn roadmap(space: &ArmSpace) -> Roadmap {
        Roadmap::new(&space.lower, &space.upper, 2048)
    }

    #[test]
    fn the_arm_goes_from_shelf_cell_to_shelf_cell_and_always_on_the_same_path() {
        let bench = Bench::shelf();
        let space = bench.space();
        let judge = Exhaustive::new(&bench.model, &bench.world, None, &[]).unwrap();
        let cells = shelf_configurations();
        let map = roadmap(&space);
        let mut searched = 0;
        for (k, pair) in cells.windows(2).enumerate() {
            let goals = [pair[1].clone()];
            let plan = || plan_by_roadmap(&space, &map, &pair[0], &goals, &RoadmapSettings::default(), &Watch::idle());
            let PlanOutcome::Found(found) = plan() else { panic!("cell {k}: {:?}", plan()) };
            assert_eq!(found.path.points.first(), Some(&pair[0]));
            assert_eq!(found.path.points.last(), Some(&pair[1]));
            assert_eq!(walk_path(&judge, &bench.dofs(), &bench.rest(), &found.path, 0.01), None, "cell {k}");
            searched += usize::from(found.nodes > 0);
            assert_eq!(plan(), PlanOutcome::Found(found));
        }
        assert!(searched >= 3, "straight motions alone would test nothing: {searched} searches");
        // With all cells as goals, one of them is told, and it is where the path ends.
        let outcome =
            plan_by_roadmap(&space, &map, &cells[0], &cells[1..], &RoadmapSettings::default(), &Watch::idle());
        let PlanOutcome::Found(found) = outcome else { panic!("{outcome:?}") };
        assert_eq!(found.path.points.last(), Some(&cells[1..][found.goal]));
    }

    #[test]
    fn every_refusal_is_the_one_of_the_random_search() {
        let bench = Bench::shelf();
        let space = bench.space();
        let cells = shelf_configurations();
        let map = roadmap(&space);
        let plan = |start: &[f64], goals: &[Vec<f64>]| {
            plan_by_roadmap(&space, &map, start, goals, &RoadmapSettings::default(), &Watch::idle())
        };
        let inside_wall = vec![0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0, 0.0, 0.0];
        let beyond = vec![9.0; 7];
        let questions: [(&[f64], &[Vec<f64>]); 6] = [
            (&inside_wall, &cells),
            (&cells[0], &[inside_wall.clone(), inside_wall.clone()]),
            (&beyond, &cells),
            (&cells[0], std::slice::from_ref(&beyond)),
            (&cells[0], &[]),
            (&[0.0; 3], &cells),
        ];
        for (start, goals) in questions {
            let random = crate::plan::plan_path(&space, start, goals, &Default::default(), 1, &Watch::idle());
            assert!(!matches!(random, PlanOutcome::Found(_)));
            assert_eq!(plan(start, goals), random);
        }
        assert!(matches!(
            plan(&cells[0], &[beyond]),
            PlanOutcome::GoalsInvalid { first: Some(ConfigurationFault::OutsideLimits { .. }), count: 1 }
        ));
    }

    #[test]
    fn an_arm_in_a_cage_has_no_path_and_a_cancelled_search_says_so() {
        // Four walls around the upright arm's wrist.
        let wall = |x: f64, y: f64| {
            ([x, y, 0.85], [if x == 0.0 { 0.5 } else { 0.02 }, if y == 0.0 { 0.5 } else { 0.02 }, 0.9])
        };
        let walls: Vec<_> = [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)].map(|(x, y)| wall(x, y)).into();
        let boxes: Vec<_> = walls.iter().map(|&(center, size)| ("wall", center, size)).collect();
        let space = Bench::new(&boxes).space();
        let (start, goal) = (vec![0.0; 7], vec![vec![0.0, 1.9, 0.0, 1.0, 0.0, 0.0, 0.0]]);
        let map = roadmap(&space);
        let outcome = plan_by_roadmap(&space, &map, &start, &goal, &RoadmapSettings::default(), &Watch::idle());
        assert!(matches!(&outcome, PlanOutcome::NoPath(found) if found.nearest_gap_rad > 0.1), "{outcome:?}");
        let watch = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        let outcome = plan_by_roadmap(&space, &map, &start, &goal, &RoadmapSettings::default(), &watch);
        assert_eq!(outcome, PlanOutcome::Stopped);
    }
}
