//! Points that fill a box evenly, the same ones always.

/// The sequence `frac(½ + k α)` with `αᵢ = φ⁻ⁱ`, where `φ` is the positive root of `x^(d+1) = x + 1` (Roberts 2018).
///
/// For one dimension that is the golden ratio. Every beginning of the sequence covers the unit cube about as evenly as
/// so many points can.
#[derive(Clone, Debug)]
pub(crate) struct EvenPoints {
    pub(crate) alpha: Vec<f64>,
}

impl EvenPoints {
    pub(crate) fn new(dimension: usize) -> Self {
        let mut root: f64 = 2.0;
        // Newton's method from above on a convex function: monotone, and at rest well before this many steps.
        for _ in 0..60 {
            let power = (0..dimension).fold(1.0, |power, _| power * root);
            root -= (power * root - root - 1.0) / ((dimension + 1) as f64 * power - 1.0);
        }
        let mut alpha = Vec::with_capacity(dimension);
        let mut term = 1.0;
        for _ in 0..dimension {
            term /= root;
            alpha.push(term);
        }
        Self { alpha }
    }

    /// The point of a number, appended to `into` with every coordinate in its interval.
    pub(super) fn push(&self, number: usize, lower: &[f64], upper: &[f64], into: &mut Vec<f64>) {
        into.extend(self.alpha.iter().zip(lower.iter().zip(upper)).map(|(alpha, (lower, upper))| {
            let at = 0.5 + number as f64 * alpha;
            lower + (upper - lower) * (at - at.floor())
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_golden_ratio_and_the_plastic_number_come_out() {
        assert!((EvenPoints::new(1).alpha[0] - 0.618_033_988_749_894_9).abs() < 1e-15);
        assert!((EvenPoints::new(2).alpha[0] - 0.754_877_666_246_692_8).abs() < 1e-15);
        let seven = EvenPoints::new(7).alpha[0];
        let eighth = (0..8).fold(1.0, |power, _| power / seven);
        assert!((eighth - 1.0 / seven - 1.0).abs() < 1e-13);
    }

    #[test]
    fn every_small_box_gets_its_share_of_the_points() {
        let even = EvenPoints::new(7);
        let mut points = Vec::new();
        (0..4096).for_each(|k| even.push(k, &[-1.0; 7], &[3.0; 7], &mut points));
        // Halves of every pair of axes: a quarter each, within a tenth (random numbers would stay within it as well, on
        // most axes; points on a lattice that resonates would not).
        for i in 0..7 {
            for j in 0..i {
                for corner in 0..4 {
                    let inside = |q: &[f64]| (q[i] < 1.0) == (corner & 1 == 0) && (q[j] < 1.0) == (corner & 2 == 0);
                    let count = points.chunks_exact(7).filter(|q| inside(q)).count();
                    assert!((922..=1126).contains(&count), "{i} {j} {corner}: {count}");
                }
            }
        }
    }
}
