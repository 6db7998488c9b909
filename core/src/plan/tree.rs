//! A tree of configurations.

/// Nodes with their parents; roots are their own parents.
pub(crate) struct Tree {
    dimension: usize,
    values: Vec<f64>,
    parents: Vec<usize>,
    /// Index of the goal at the root; 0 in the start tree.
    origins: Vec<usize>,
}

impl Tree {
    pub(crate) fn new(dimension: usize) -> Self {
        Self { dimension, values: Vec::new(), parents: Vec::new(), origins: Vec::new() }
    }

    pub(crate) fn len(&self) -> usize {
        self.parents.len()
    }

    pub(crate) fn node(&self, index: usize) -> &[f64] {
        &self.values[index * self.dimension..(index + 1) * self.dimension]
    }

    pub(crate) fn origin(&self, index: usize) -> usize {
        self.origins[index]
    }

    pub(crate) fn add_root(&mut self, q: &[f64], origin: usize) -> usize {
        let index = self.len();
        self.values.extend_from_slice(q);
        self.parents.push(index);
        self.origins.push(origin);
        index
    }

    pub(crate) fn add(&mut self, q: &[f64], parent: usize) -> usize {
        let index = self.len();
        self.values.extend_from_slice(q);
        self.parents.push(parent);
        self.origins.push(self.origins[parent]);
        index
    }

    /// The node nearest to `q` and its distance, rad; of equally near ones the oldest.
    pub(crate) fn nearest(&self, q: &[f64]) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        for (index, node) in self.values.chunks_exact(self.dimension).enumerate() {
            let mut squared = 0.0;
            for (a, b) in node.iter().zip(q) {
                squared += (a - b) * (a - b);
            }
            if squared < best.1 {
                best = (index, squared);
            }
        }
        (best.0, best.1.sqrt())
    }

    /// Configurations from a node to its root.
    pub(crate) fn to_root(&self, mut index: usize) -> Vec<Vec<f64>> {
        let mut branch = vec![self.node(index).to_vec()];
        while self.parents[index] != index {
            index = self.parents[index];
            branch.push(self.node(index).to_vec());
        }
        branch
    }
}
