//! Normal equations of a least-squares problem, summed chunk by chunk in a fixed order.

use super::weighted::CHUNK;

/// Partial sums per entry, so that additions need not wait for each other; a fixed number fixes the rounding.
const LANES: usize = 4;

/// Normal equations of the least-squares problem at one candidate, N unknowns.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations<const N: usize> {
    /// `JᵀJ`, both triangles.
    pub(crate) hessian: [[f64; N]; N],
    /// `Jᵀr`.
    pub(crate) gradient: [f64; N],
    /// Sum of squared residuals, weighted.
    pub(crate) cost: f64,
}

/// Residuals and Jacobian columns of one chunk, each already times the root of its weight.
pub(crate) struct Rows<const N: usize> {
    pub(crate) columns: [[f64; CHUNK]; N],
    pub(crate) residual: [f64; CHUNK],
}

/// Partial sums of the normal equations.
pub(crate) struct Sums<const N: usize> {
    /// Upper triangle; the rest stays 0.
    hessian: [[[f64; LANES]; N]; N],
    gradient: [[f64; LANES]; N],
    cost: [f64; LANES],
}

#[inline(always)]
fn accumulate(sum: &mut [f64; LANES], a: &[f64; CHUNK], b: &[f64; CHUNK]) {
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
}

fn folded(sum: &[f64; LANES]) -> f64 {
    (sum[0] + sum[1]) + (sum[2] + sum[3])
}

impl<const N: usize> Sums<N> {
    pub(crate) fn new() -> Self {
        Self { hessian: [[[0.0; LANES]; N]; N], gradient: [[0.0; LANES]; N], cost: [0.0; LANES] }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, rows: &Rows<N>) {
        for i in 0..N {
            for j in i..N {
                accumulate(&mut self.hessian[i][j], &rows.columns[i], &rows.columns[j]);
            }
            accumulate(&mut self.gradient[i], &rows.columns[i], &rows.residual);
        }
        accumulate(&mut self.cost, &rows.residual, &rows.residual);
    }

    pub(crate) fn finish(&self) -> NormalEquations<N> {
        let hessian = std::array::from_fn(|i| std::array::from_fn(|j| folded(&self.hessian[i.min(j)][i.max(j)])));
        NormalEquations {
            hessian,
            gradient: std::array::from_fn(|i| folded(&self.gradient[i])),
            cost: folded(&self.cost),
        }
    }
}

impl<const N: usize> NormalEquations<N> {
    /// Adds one residual with its row of the Jacobian.
    pub(crate) fn add_row(&mut self, residual: f64, row: &[f64; N], weight: f64) {
        for i in 0..N {
            for j in 0..N {
                self.hessian[i][j] += weight * row[i] * row[j];
            }
            self.gradient[i] += weight * row[i] * residual;
        }
        self.cost += weight * residual * residual;
    }
}
