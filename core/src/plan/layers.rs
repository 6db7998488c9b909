//! The configurations that reach each of a row of hand poses.

use nalgebra::Isometry3;

use super::space::ArmSpace;
use crate::collision::{Hit, Scratch};
use crate::robot::ik::{ArmIk, IkMethod};

/// Solutions of a numeric arm nearer to each other than this in every joint are one, rad.
const SAME_RAD: f64 = 1e-3;

/// Whether a node has been looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seen {
    Not,
    Free,
    Blocked,
}

/// Nodes in one layer per hand pose, each layer in the order of the first joint.
pub(super) struct Layers {
    dimension: usize,
    values: Vec<f64>,
    /// First node of each layer, and one more.
    begins: Vec<usize>,
    seen: Vec<Seen>,
    /// Per layer, whether the hand itself is blocked at the pose; unknown until asked.
    hand: Vec<Option<bool>>,
    /// Nodes that are given starts, with their indices.
    pub(super) starts: Vec<(usize, usize)>,
    /// Nodes that are given goals, with their indices.
    pub(super) goals: Vec<(usize, usize)>,
}

impl Layers {
    /// Solves every pose at all arm angles; `starts` join the first layer, `goals` the last.
    pub(super) fn of(
        ik: &ArmIk,
        poses_BH: &[Isometry3<f64>],
        starts: &[Vec<f64>],
        goals: &[Vec<f64>],
        arm_angles: usize,
    ) -> Self {
        let dimension = ik.limits().len();
        let q_now = starts.first().cloned().unwrap_or_else(|| vec![0.0; dimension]);
        let mut layers = Self {
            dimension,
            values: Vec::new(),
            begins: vec![0],
            seen: Vec::new(),
            hand: vec![None; poses_BH.len()],
            starts: Vec::new(),
            goals: Vec::new(),
        };
        let mut found: Vec<f64> = Vec::new();
        for (k, X_BH) in poses_BH.iter().enumerate() {
            if matches!(ik.method(), IkMethod::Numeric { .. }) {
                found = continued(ik, X_BH, &found, &q_now, arm_angles);
            } else {
                found.clear();
                ik.set(X_BH, &q_now, arm_angles).iter().for_each(|q| found.extend_from_slice(q));
            }
            let starts = if k == 0 { starts } else { &[] };
            let goals = if k + 1 == poses_BH.len() { goals } else { &[] };
            layers.push(&found, starts, goals);
        }
        layers
    }

    /// Adds a layer, sorted by the first joint.
    fn push(&mut self, found: &[f64], starts: &[Vec<f64>], goals: &[Vec<f64>]) {
        let begin = self.values.len() / self.dimension;
        let solutions = found.chunks_exact(self.dimension);
        let given = starts.iter().chain(goals).map(Vec::as_slice);
        let rows: Vec<&[f64]> = solutions.chain(given).collect();
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_unstable_by(|&a, &b| rows[a][0].total_cmp(&rows[b][0]).then(a.cmp(&b)));
        let first_start = rows.len() - starts.len() - goals.len();
        let first_goal = rows.len() - goals.len();
        for (place, &row) in order.iter().enumerate() {
            self.values.extend_from_slice(rows[row]);
            if row >= first_goal {
                self.goals.push((begin + place, row - first_goal));
            } else if row >= first_start {
                self.starts.push((begin + place, row - first_start));
            }
        }
        self.begins.push(begin + rows.len());
        self.seen.resize(begin + rows.len(), Seen::Not);
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.seen.len()
    }

    /// Number of layers.
    pub(super) fn count(&self) -> usize {
        self.hand.len()
    }

    /// The nodes of a layer.
    pub(super) fn layer(&self, layer: usize) -> std::ops::Range<usize> {
        self.begins[layer]..self.begins[layer + 1]
    }

    /// The layer of a node.
    pub(super) fn layer_of(&self, node: usize) -> usize {
        self.begins.partition_point(|&begin| begin <= node) - 1
    }

    pub(super) fn q(&self, node: usize) -> &[f64] {
        &self.values[node * self.dimension..(node + 1) * self.dimension]
    }

    /// Calls back with every node of a layer to which all joints of `node` move by at most `step_rad`, and how far that
    /// is, Euclidean.
    pub(super) fn near(&self, node: usize, layer: usize, step_rad: f64, mut found: impl FnMut(usize, f64)) {
        let q = self.q(node);
        let nodes = self.layer(layer);
        let (mut first, mut beyond) = (nodes.start, nodes.end);
        while first < beyond {
            let middle = usize::midpoint(first, beyond);
            if self.q(middle)[0] < q[0] - step_rad { first = middle + 1 } else { beyond = middle }
        }
        'nodes: for other in first..nodes.end {
            let mut squared = 0.0;
            let q_other = self.q(other);
            if q_other[0] > q[0] + step_rad {
                break;
            }
            for (a, b) in q.iter().zip(q_other) {
                let step = a - b;
                if step.abs() > step_rad {
                    continue 'nodes;
                }
                squared += step * step;
            }
            if other != node {
                found(other, squared.sqrt());
            }
        }
    }

    /// Whether nothing touches at a node; asked once per node, and for the hand once per pose.
    pub(super) fn is_free(&mut self, space: &ArmSpace, scratch: &mut Scratch, node: usize) -> bool {
        if self.seen[node] == Seen::Not {
            let layer = self.layer_of(node);
            let q = &self.values[node * self.dimension..(node + 1) * self.dimension];
            let hand = &mut self.hand[layer];
            let hand_blocked = *hand.get_or_insert_with(|| space.checker.first_hit_of_hand(scratch, q).is_some());
            let blocked = hand_blocked || space.checker.first_hit_besides_hand(scratch, q).is_some();
            self.seen[node] = if blocked { Seen::Blocked } else { Seen::Free };
        }
        self.seen[node] == Seen::Free
    }

    /// What is touched most often at some nodes, the first of equals; `None` if one of them is free or there are none.
    pub(super) fn obstruction(
        &self,
        space: &ArmSpace,
        scratch: &mut Scratch,
        nodes: impl Iterator<Item = usize>,
    ) -> Option<Hit> {
        let mut counts = HitCounts::default();
        for node in nodes {
            counts.add(space.first_hit(scratch, self.q(node))?);
        }
        counts.most()
    }
}

/// Hits and how often each was met.
#[derive(Default)]
pub(super) struct HitCounts {
    counts: Vec<(Hit, usize)>,
}

impl HitCounts {
    pub(super) fn add(&mut self, hit: Hit) {
        match self.counts.iter_mut().find(|(known, _)| *known == hit) {
            Some((_, count)) => *count += 1,
            None => self.counts.push((hit, 1)),
        }
    }

    /// The most frequent one, the first of equals.
    pub(super) fn most(self) -> Option<Hit> {
        // The last of equal maxima is taken, hence the reversed order.
        self.counts.into_iter().rev().max_by_key(|(_, count)| *count).map(|(hit, _)| hit)
    }
}

/// Solutions of a pose for an arm without a closed form: those of the pose before, moved on, so that a family of
/// solutions stays one, and fresh ones where families have ended.
fn continued(ik: &ArmIk, X_BH: &Isometry3<f64>, before: &[f64], q_now: &[f64], wanted: usize) -> Vec<f64> {
    let dimension = q_now.len();
    let mut found: Vec<f64> = Vec::new();
    let mut add = |q: &[f64]| {
        let apart = |known: &[f64]| known.iter().zip(q).any(|(a, b)| (a - b).abs() > SAME_RAD);
        if found.len() < wanted * dimension && found.chunks_exact(dimension).all(apart) {
            found.extend_from_slice(q);
        }
        found.len() < wanted * dimension
    };
    let mut more = true;
    for q in before.chunks_exact(dimension) {
        if let Some(q) = ik.near(X_BH, q) {
            more = add(&q);
        }
    }
    if more {
        for q in ik.set(X_BH, q_now, wanted).iter() {
            add(q);
        }
    }
    found
}
