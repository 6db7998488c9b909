//! Points with weights, laid out for passes that handle several points side by side.

use nalgebra::Point3;

/// Points handled side by side; their arrays stay in the nearest cache.
pub(crate) const CHUNK: usize = 16;

/// Points with weights, laid out in chunks and padded with weight 0.
#[derive(Clone, Debug)]
pub(crate) struct WeightedPoints {
    pub(crate) chunks: Vec<Chunk>,
    pub(crate) total_weight: f64,
    pub(crate) count: usize,
}

/// Points side by side.
#[derive(Clone, Debug)]
pub(crate) struct Chunk {
    pub(crate) p: [[f64; CHUNK]; 3],
    /// Square roots of the weights.
    pub(crate) root_weight: [f64; CHUNK],
}

impl WeightedPoints {
    /// Lays out points with their weights, which are not negative.
    pub(crate) fn new(points: &[(Point3<f64>, f64)]) -> Self {
        let chunks = points
            .chunks(CHUNK)
            .map(|some| {
                let mut chunk = Chunk { p: [[0.0; CHUNK]; 3], root_weight: [0.0; CHUNK] };
                for k in 0..CHUNK {
                    // Padding repeats a real point: its derivatives are as finite as that point's.
                    let (p, weight) = some[k.min(some.len() - 1)];
                    for axis in 0..3 {
                        chunk.p[axis][k] = p[axis];
                    }
                    chunk.root_weight[k] = if k < some.len() { weight.sqrt() } else { 0.0 };
                }
                chunk
            })
            .collect();
        Self { chunks, total_weight: points.iter().map(|(_, w)| w).sum(), count: points.len() }
    }
}
