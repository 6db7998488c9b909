//! A tree of boxes over many things that stand still: what is near is found without looking at everything.
//!
//! Nodes lie in one list in depth-first order. A node that is not near is left by jumping to the first node that is not
//! below it, so that a visit needs no stack.

use nalgebra::Vector3;

/// Boxes within boxes, the things at the leaves.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

/// An axis-aligned box around everything below it.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) lower: Vector3<f64>,
    pub(crate) upper: Vector3<f64>,
    /// The first node after those below this one.
    past: usize,
    /// The thing itself, at a leaf.
    leaf: Option<usize>,
}

impl Tree {
    /// Over things with these lower and upper corners, metres.
    pub(crate) fn new(boxes: &[(Vector3<f64>, Vector3<f64>)]) -> Self {
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        let mut tree = Self { nodes: Vec::with_capacity(2 * boxes.len()) };
        if !order.is_empty() {
            tree.grow(boxes, &mut order);
        }
        tree
    }

    /// Adds a node for these things and all below it, each divided where half of its things lie on either side.
    fn grow(&mut self, boxes: &[(Vector3<f64>, Vector3<f64>)], things: &mut [usize]) {
        let lower = things.iter().fold(Vector3::repeat(f64::INFINITY), |m, &k| m.inf(&boxes[k].0));
        let upper = things.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |m, &k| m.sup(&boxes[k].1));
        let at = self.nodes.len();
        let leaf = if things.len() == 1 { things.first().copied() } else { None };
        self.nodes.push(Node { lower, upper, past: 0, leaf });
        if things.len() > 1 {
            let middle = |k: usize, axis: usize| boxes[k].0[axis] + boxes[k].1[axis];
            let spread = |axis: usize| {
                let most = things.iter().map(|&k| middle(k, axis)).fold(f64::NEG_INFINITY, f64::max);
                most - things.iter().map(|&k| middle(k, axis)).fold(f64::INFINITY, f64::min)
            };
            let wider = |a: usize, b: usize| if spread(b) > spread(a) { b } else { a };
            let axis = wider(wider(0, 1), 2);
            let half = things.len() / 2;
            things.select_nth_unstable_by(half, |&a, &b| middle(a, axis).total_cmp(&middle(b, axis)).then(a.cmp(&b)));
            let (left, right) = things.split_at_mut(half);
            self.grow(boxes, left);
            self.grow(boxes, right);
        }
        self.nodes[at].past = self.nodes.len();
    }

    /// Shows the things below nodes that are all near, until `show` answers `false`.
    #[inline(always)]
    pub(crate) fn visit<State>(
        &self,
        state: &mut State,
        is_near: impl Fn(&State, &Node) -> bool,
        mut show: impl FnMut(&mut State, usize) -> bool,
    ) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !is_near(state, node) {
                at = node.past;
                continue;
            }
            if let Some(thing) = node.leaf
                && !show(state, thing)
            {
                return;
            }
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn a_visit_shows_exactly_what_a_loop_over_all_boxes_finds() {
        let mut rng = Rng::new(41, 0);
        for count in [0, 1, 2, 3, 50, 700] {
            let boxes: Vec<_> = (0..count)
                .map(|_| {
                    let lower = rng.direction() * rng.uniform(0.0, 1.0);
                    (lower, lower + Vector3::from_fn(|_, _| rng.uniform(0.0, 0.1)))
                })
                .collect();
            let tree = Tree::new(&boxes);
            for _ in 0..100 {
                let (p, reach) = (rng.direction() * rng.uniform(0.0, 1.0), rng.uniform(0.0, 0.3));
                let near = |lower: &Vector3<f64>, upper: &Vector3<f64>| {
                    super::super::build::squared_distance_to_box(&p, lower, upper) <= reach * reach
                };
                let mut shown = Vec::new();
                tree.visit(
                    &mut shown,
                    |_, node| near(&node.lower, &node.upper),
                    |shown, thing| {
                        shown.push(thing);
                        true
                    },
                );
                shown.sort_unstable();
                let wanted: Vec<usize> = (0..count).filter(|&k| near(&boxes[k].0, &boxes[k].1)).collect();
                assert_eq!(shown, wanted);
            }
        }
    }
}
