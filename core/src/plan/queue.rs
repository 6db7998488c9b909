//! What a best-first search looks at next: the cheapest, of equally cheap ones the first in a fixed order.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A node that waits, and what it would be joined with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    /// Smallest first.
    pub(crate) key: f64,
    /// The node.
    pub(crate) node: u32,
    /// The node from which it was met.
    pub(crate) from: u32,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap gives its greatest first.
        other.key.total_cmp(&self.key).then_with(|| (other.node, other.from).cmp(&(self.node, self.from)))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

/// Nodes that wait, cheapest first; the same insertions always come out in the same order.
#[derive(Default)]
pub(crate) struct Queue {
    heap: BinaryHeap<Waiting>,
}

impl Queue {
    pub(crate) fn push(&mut self, key: f64, node: u32, from: u32) {
        self.heap.push(Waiting { key, node, from });
    }

    pub(crate) fn pop(&mut self) -> Option<Waiting> {
        self.heap.pop()
    }

    pub(crate) fn clear(&mut self) {
        self.heap.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_comes_first_and_ties_are_broken_by_number_whatever_the_order_of_insertion() {
        let mut orders = Vec::new();
        for turn in 0..4 {
            let mut entries = [(2.0, 1, 0), (1.0, 7, 3), (1.0, 7, 2), (1.0, 5, 9)];
            entries.rotate_left(turn);
            let mut queue = Queue::default();
            entries.iter().for_each(|&(key, node, from)| queue.push(key, node, from));
            let popped = std::iter::from_fn(|| queue.pop()).map(|w| (w.node, w.from)).collect::<Vec<_>>();
            orders.push(popped);
        }
        assert!(orders.iter().all(|order| *order == [(5, 9), (7, 2), (7, 3), (1, 0)]), "{orders:?}");
    }
}
