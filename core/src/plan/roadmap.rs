//! A roadmap of an arm: configurations spread evenly over its joint space and who is near whom, whatever the scene.

use super::low_discrepancy::EvenPoints;

/// How many earlier nodes each node is joined with.
const NEIGHBOURS: usize = 10;

/// Even configurations of an arm, each joined with the nearest of those before it (Kavraki et al. 1996; with points of
/// low discrepancy LaValle, Branicky and Lindemann 2004).
///
/// It knows the joint limits and nothing else: made once per arm, it serves every scene. Every beginning of it is a
/// roadmap too, a coarser one.
#[derive(Clone, Debug)]
pub struct Roadmap {
    dimension: usize,
    values: Vec<f64>,
    /// Per node its neighbours and their distances, rad; the order is that of their numbers.
    neighbours: Vec<Vec<(u32, f64)>>,
}

impl Roadmap {
    /// A roadmap of `nodes` configurations between joint limits, rad.
    ///
    /// It takes time in the square of the nodes: 4 000 take about a tenth of a second.
    pub fn new(lower: &[f64], upper: &[f64], nodes: usize) -> Self {
        let dimension = lower.len().min(upper.len());
        let even = EvenPoints::new(dimension);
        let mut values = Vec::with_capacity(nodes * dimension);
        (0..nodes).for_each(|number| even.push(number, lower, upper, &mut values));
        let mut neighbours: Vec<Vec<(u32, f64)>> = vec![Vec::new(); nodes];
        for node in 1..nodes {
            let q = &values[node * dimension..(node + 1) * dimension];
            for (other, distance) in nearest(&values[..node * dimension], q, NEIGHBOURS) {
                neighbours[node].push((other as u32, distance));
                neighbours[other].push((node as u32, distance));
            }
        }
        neighbours.iter_mut().for_each(|list| list.sort_by_key(|&(other, _)| other));
        Self { dimension, values, neighbours }
    }

    /// Number of configurations.
    pub fn len(&self) -> usize {
        self.neighbours.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.neighbours.is_empty()
    }

    /// Number of joints.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    pub(super) fn q(&self, node: usize) -> &[f64] {
        &self.values[node * self.dimension..(node + 1) * self.dimension]
    }

    /// The first configurations, one after the other.
    pub(super) fn first(&self, nodes: usize) -> &[f64] {
        &self.values[..nodes * self.dimension]
    }

    pub(super) fn neighbours(&self, node: usize) -> &[(u32, f64)] {
        &self.neighbours[node]
    }
}

/// The nearest of some configurations, nearest first, of equally near ones the first; with their distances, rad.
pub(super) fn nearest(values: &[f64], q: &[f64], count: usize) -> Vec<(usize, f64)> {
    let mut best: Vec<(usize, f64)> = Vec::with_capacity(count + 1);
    let mut bound = f64::INFINITY;
    for (index, other) in values.chunks_exact(q.len().max(1)).enumerate() {
        let mut squared = 0.0;
        for (a, b) in q.iter().zip(other) {
            squared += (a - b) * (a - b);
        }
        if squared < bound {
            let place = best.partition_point(|&(_, known)| known <= squared);
            best.insert(place, (index, squared));
            best.truncate(count);
            if best.len() == count {
                bound = best.last().map_or(bound, |&(_, farthest)| farthest);
            }
        }
    }
    best.iter_mut().for_each(|(_, squared)| *squared = squared.sqrt());
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::space::distance_rad;

    #[test]
    fn each_node_is_joined_with_the_nearest_before_it_and_every_beginning_is_a_roadmap() {
        let (lower, upper) = ([-2.0, -1.0, -3.0], [2.0, 1.5, 3.0]);
        let map = Roadmap::new(&lower, &upper, 300);
        let coarse = Roadmap::new(&lower, &upper, 120);
        assert_eq!((map.len(), map.dimension(), map.is_empty()), (300, 3, false));
        for node in 0..300 {
            let q = map.q(node);
            assert!((0..3).all(|joint| (lower[joint]..=upper[joint]).contains(&q[joint])));
            let mut slow: Vec<(f64, usize)> = (0..node).map(|other| (distance_rad(q, map.q(other)), other)).collect();
            slow.sort_by(|a, b| a.0.total_cmp(&b.0));
            slow.truncate(NEIGHBOURS);
            let mut before: Vec<usize> = slow.into_iter().map(|(_, other)| other).collect();
            before.sort_unstable();
            let joined: Vec<usize> =
                map.neighbours(node).iter().map(|&(other, _)| other as usize).filter(|&other| other < node).collect();
            assert_eq!(joined, before, "node {node}");
            if node < 120 {
                let known: Vec<_> = map.neighbours(node).iter().filter(|(other, _)| *other < 120).copied().collect();
                assert_eq!(known, coarse.neighbours(node));
            }
        }
    }
}
