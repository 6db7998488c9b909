//! The radial objective (3.4, corrected) with its analytic Jacobian, summed into normal equations.
//!
//! Residual of a point, signed: `d = |p_S| (1 - 1/ρ)` with the gauge `ρ = f^(e1/2)`. With `s = |p_S|/ρ`, the distance
//! from the centre to the surface along the ray, `∂d/∂θ = s ∂ln ρ/∂θ` for a shape parameter θ, and
//! `g = ∂d/∂p_S = (1 - 1/ρ) p_S/|p_S| + s ∂ln ρ/∂p_S`. Moving the centre gives `-R g`, turning S about its own axes
//! `g × p_S`.
//!
//! An object that stands on a table adds one residual: the superquadric's lowest point is on the plane,
//! `n · t - h(n) - offset`, with its support function h.

use nalgebra::Point3;

use super::candidate::{Candidate, UNKNOWNS};
use crate::segment::Plane;
use crate::simd::{Kernel, widest};
use crate::superquadric::{AxesGauge, fast_exp};

/// Points handled side by side; their arrays stay in the nearest cache.
const CHUNK: usize = 16;
/// Partial sums per entry, so that additions need not wait for each other; a fixed number fixes the rounding.
const LANES: usize = 4;
/// Entries of the upper triangle of an 11 × 11 matrix.
const TRIANGLE: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;

/// Points with weights, laid out in chunks and padded with weight 0.
#[derive(Clone, Debug)]
pub(crate) struct WeightedPoints {
    chunks: Vec<Chunk>,
    total_weight: f64,
    count: usize,
}

#[derive(Clone, Debug)]
struct Chunk {
    p: [[f64; CHUNK]; 3],
    /// Square roots of the weights.
    root_weight: [f64; CHUNK],
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

/// Normal equations of the least-squares problem at one candidate.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations {
    /// `JᵀJ`, both triangles.
    pub(crate) hessian: [[f64; UNKNOWNS]; UNKNOWNS],
    /// `Jᵀr`.
    pub(crate) gradient: [f64; UNKNOWNS],
    /// Sum of squared residuals, weighted, metres squared.
    pub(crate) cost: f64,
}

/// The least-squares problem of one fit.
#[derive(Clone, Copy)]
pub(crate) struct Objective<'a> {
    points: &'a WeightedPoints,
    /// The table in D, and the weight of standing on it as a share of the points' total weight.
    table: Option<(Plane, f64)>,
    /// Half extents of the cloud that the semi-axes are drawn to, and the weight as a share of the points' total.
    drawn_to: Option<([f64; 3], f64)>,
}

impl<'a> Objective<'a> {
    /// The radial distances of `points`, and `table` with its weight relative to all points together.
    pub(crate) fn new(points: &'a WeightedPoints, table: Option<(Plane, f64)>) -> Self {
        Self { points, table, drawn_to: None }
    }

    /// The same with semi-axes drawn towards these lengths, metres.
    ///
    /// An open side says nothing about how far the shape goes on; among shapes that explain the points alike, this
    /// prefers the small one (the thesis's scale factors `√(abc)` are there for the same reason).
    pub(crate) fn drawn_to(self, semi_axes: [f64; 3], share: f64) -> Self {
        Self { drawn_to: Some((semi_axes, share)), ..self }
    }

    /// Sum of the weights: the cost over this is a mean square, metres squared.
    pub(crate) fn total_weight(&self) -> f64 {
        self.points.total_weight
    }

    /// Number of points.
    pub(crate) fn points(&self) -> usize {
        self.points.count
    }

    /// Cost, gradient and Gauss–Newton matrix at a candidate.
    pub(crate) fn at(&self, candidate: &Candidate) -> NormalEquations {
        let mut equations = widest(Pass { chunks: &self.points.chunks, frame: CandidateFrame::new(candidate) });
        if let Some((plane, share)) = &self.table {
            let (residual, row) = standing_row(candidate, plane);
            equations.add_row(residual, &row, share * self.points.total_weight);
        }
        if let Some((semi_axes, share)) = &self.drawn_to {
            for (k, target) in semi_axes.iter().enumerate() {
                let mut row = [0.0; UNKNOWNS];
                row[k] = 1.0;
                equations.add_row(candidate.values[k] - target, &row, share * self.points.total_weight);
            }
        }
        equations
    }
}

/// One pass over the points.
struct Pass<'a> {
    chunks: &'a [Chunk],
    frame: CandidateFrame,
}

impl Kernel for Pass<'_> {
    type Output = NormalEquations;

    #[inline(always)]
    fn run(self) -> NormalEquations {
        let mut sums = Sums::new();
        for chunk in self.chunks {
            sums.add(&self.frame.rows(chunk));
        }
        sums.finish()
    }
}

/// Residuals and Jacobian columns of one chunk, each already times the root of its weight.
struct Rows {
    columns: [[f64; CHUNK]; UNKNOWNS],
    residual: [f64; CHUNK],
}

/// What a candidate contributes to every point.
struct CandidateFrame {
    gauge: AxesGauge,
    inverse_axes: [f64; 3],
    /// Row-major rotation of S in D, and the centre in D.
    rotation: [[f64; 3]; 3],
    center: [f64; 3],
}

impl CandidateFrame {
    fn new(candidate: &Candidate) -> Self {
        let gauge = AxesGauge::new(candidate.axes(), candidate.exponents());
        let R = candidate.rotation();
        let rotation = [0, 1, 2].map(|i| [R[(i, 0)], R[(i, 1)], R[(i, 2)]]);
        let t = candidate.center();
        Self { gauge, inverse_axes: gauge.inverse_axes, rotation, center: [t.x, t.y, t.z] }
    }

    #[inline(always)]
    fn rows(&self, chunk: &Chunk) -> Rows {
        let mut rows = Rows { columns: [[0.0; CHUNK]; UNKNOWNS], residual: [0.0; CHUNK] };
        let R = &self.rotation;
        for k in 0..CHUNK {
            let v = [0, 1, 2].map(|i| chunk.p[i][k] - self.center[i]);
            let p = [0, 1, 2].map(|j| R[0][j] * v[0] + R[1][j] * v[1] + R[2][j] * v[2]);
            let squared = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            let radius = (if squared > 1e-24 { squared } else { 1e-24 }).sqrt();
            let gauge = self.gauge.at(p);
            let shrink = fast_exp(-gauge.ln_rho);
            let surface = radius * shrink;
            let outward = (1.0 - shrink) / radius;
            let g = [0, 1, 2].map(|i| outward * p[i] + surface * gauge.gradient[i]);
            let w = chunk.root_weight[k];
            rows.residual[k] = w * (radius - surface);
            for (i, R_i) in R.iter().enumerate() {
                rows.columns[i][k] = -w * surface * gauge.shares[i] * self.inverse_axes[i];
                rows.columns[5 + i][k] = -w * (R_i[0] * g[0] + R_i[1] * g[1] + R_i[2] * g[2]);
            }
            rows.columns[3][k] = w * surface * gauge.by_exponent[0];
            rows.columns[4][k] = w * surface * gauge.by_exponent[1];
            rows.columns[8][k] = w * (g[1] * p[2] - g[2] * p[1]);
            rows.columns[9][k] = w * (g[2] * p[0] - g[0] * p[2]);
            rows.columns[10][k] = w * (g[0] * p[1] - g[1] * p[0]);
        }
        rows
    }
}

/// Partial sums of the normal equations.
struct Sums {
    hessian: [[f64; LANES]; TRIANGLE],
    gradient: [[f64; LANES]; UNKNOWNS],
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

impl Sums {
    fn new() -> Self {
        Self { hessian: [[0.0; LANES]; TRIANGLE], gradient: [[0.0; LANES]; UNKNOWNS], cost: [0.0; LANES] }
    }

    #[inline(always)]
    fn add(&mut self, rows: &Rows) {
        let mut entry = 0;
        for i in 0..UNKNOWNS {
            for j in i..UNKNOWNS {
                accumulate(&mut self.hessian[entry], &rows.columns[i], &rows.columns[j]);
                entry += 1;
            }
            accumulate(&mut self.gradient[i], &rows.columns[i], &rows.residual);
        }
        accumulate(&mut self.cost, &rows.residual, &rows.residual);
    }

    fn finish(&self) -> NormalEquations {
        // Entry of (i, j) in the rows of the upper triangle, which get shorter by one each.
        let entry = |i: usize, j: usize| i * (2 * UNKNOWNS + 1 - i) / 2 + (j - i);
        let hessian =
            std::array::from_fn(|i| std::array::from_fn(|j| folded(&self.hessian[entry(i.min(j), i.max(j))])));
        NormalEquations { hessian, gradient: self.gradient.map(|sum| folded(&sum)), cost: folded(&self.cost) }
    }
}

impl NormalEquations {
    /// Adds one residual with its row of the Jacobian.
    fn add_row(&mut self, residual: f64, row: &[f64; UNKNOWNS], weight: f64) {
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                self.hessian[i][j] += weight * row[i] * row[j];
            }
            self.gradient[i] += weight * row[i] * residual;
        }
        self.cost += weight * residual * residual;
    }
}

/// Height of the superquadric's lowest point above the plane, metres, and its derivatives.
fn standing_row(candidate: &Candidate, plane: &Plane) -> (f64, [f64; UNKNOWNS]) {
    let axes = candidate.axes();
    let dual = AxesGauge::new(axes.map(|a| 1.0 / a), candidate.exponents().map(|e| 2.0 - e));
    let n_D = plane.normal.into_inner();
    let n_S = candidate.R_DS.inverse_transform_vector(&n_D);
    let gauge = dual.at([n_S.x, n_S.y, n_S.z]);
    let support = fast_exp(gauge.ln_rho);
    let turning = gauge.gradient().cross(&n_S) * support;
    let residual = n_D.dot(&candidate.center()) - support - plane.offset_m;
    let row = [
        -support * gauge.shares[0] / axes[0],
        -support * gauge.shares[1] / axes[1],
        -support * gauge.shares[2] / axes[2],
        support * gauge.by_exponent[0],
        support * gauge.by_exponent[1],
        n_D.x,
        n_D.y,
        n_D.z,
        -turning.x,
        -turning.y,
        -turning.z,
    ];
    (residual, row)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Unit, Vector3};

    use super::*;
    use crate::fit::candidate::{BOUNDED, Bounds};
    use crate::rng::Rng;

    const FREE: Bounds = Bounds { lower: [-9.0; BOUNDED], upper: [9.0; BOUNDED] };

    fn random_candidate(rng: &mut Rng) -> Candidate {
        let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.3));
        let e = [0.0; 2].map(|_: f64| rng.uniform(0.12, 1.88));
        Candidate::new(axes, e, rng.direction() * 0.3, rng.rotation())
    }

    /// Residual and row of one point through the public door: a cloud of one point has H = row rowᵀ.
    fn single(p: Point3<f64>, candidate: &Candidate) -> NormalEquations {
        Objective::new(&WeightedPoints::new(&[(p, 1.0)]), None).at(candidate)
    }

    #[test]
    fn residual_is_the_radial_distance() {
        let mut rng = Rng::new(31, 0);
        for _ in 0..200 {
            let candidate = random_candidate(&mut rng);
            let p = Point3::from(candidate.center() + rng.direction() * rng.uniform(0.01, 0.5));
            let expected = candidate.superquadric(&nalgebra::Isometry3::identity()).radial_distance(&p);
            assert!((single(p, &candidate).cost.sqrt() - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn jacobian_matches_central_difference_on_axis_planes_too() {
        let mut rng = Rng::new(32, 0);
        let h = 1e-6;
        for trial in 0..400 {
            let candidate = random_candidate(&mut rng);
            let axes = Vector3::from(candidate.axes());
            let mut p_S = rng.direction().component_mul(&axes) * rng.uniform(0.5, 1.6);
            // A point exactly on an axis plane, or 5 % of a semi-axis away: |x|^(2/e - 2) is not smooth between.
            for axis in 0..3 {
                let floor = 0.05 * axes[axis];
                p_S[axis] = if p_S[axis] < 0.0 { p_S[axis].min(-floor) } else { p_S[axis].max(floor) };
            }
            let on_plane = trial % 4;
            if on_plane < 3 {
                p_S[on_plane] = 0.0;
            }
            let p = Point3::from(candidate.center() + candidate.R_DS * p_S);
            let equations = single(p, &candidate);
            let signed = |c: &Candidate| c.superquadric(&nalgebra::Isometry3::identity()).signed_radial_distance(&p);
            let residual = signed(&candidate);
            for k in 0..UNKNOWNS {
                // A motion off the plane has a one-sided power |x|^(2/e) there, which no difference resolves.
                if on_plane < 3 && k >= 5 {
                    continue;
                }
                let mut step = [0.0; UNKNOWNS];
                step[k] = h;
                let ahead = signed(&candidate.stepped(&step, &FREE));
                step[k] = -h;
                let behind = signed(&candidate.stepped(&step, &FREE));
                let difference = (ahead - behind) / (2.0 * h);
                // Gradient = row · residual, so the row is known where the residual is; third derivatives reach 1e4.
                let row = equations.gradient[k] / residual;
                let tolerance = 1e-5 * (1.0 + difference.abs()) + 1e-9 / residual.abs();
                assert!((row - difference).abs() < tolerance, "unknown {k}: {row} {difference} {candidate:?} {p_S:?}");
            }
        }
    }

    #[test]
    fn everything_is_finite_on_planes_axes_and_at_the_centre() {
        let candidate = Candidate::new([0.03, 0.05, 0.3], [0.1, 1.9], Vector3::zeros(), Default::default());
        for p in [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.0, 0.2], [0.0, 1e-300, 0.0], [5.0, 0.0, 1e-9]] {
            let equations = single(Point3::from(p), &candidate);
            assert!(equations.hessian.iter().flatten().all(|h| h.is_finite()), "{p:?}");
            assert!(equations.gradient.iter().all(|g| g.is_finite()) && equations.cost.is_finite());
        }
    }

    #[test]
    fn standing_on_the_table_matches_central_difference_and_is_zero_when_it_stands() {
        let mut rng = Rng::new(33, 0);
        for _ in 0..200 {
            let candidate = random_candidate(&mut rng);
            let normal = Unit::try_new(rng.direction(), 1e-9).unwrap();
            let plane = Plane { normal, offset_m: rng.uniform(-0.2, 0.2) };
            let (residual, row) = standing_row(&candidate, &plane);
            for k in 0..UNKNOWNS {
                let h = 1e-6;
                let mut step = [0.0; UNKNOWNS];
                step[k] = h;
                let ahead = standing_row(&candidate.stepped(&step, &FREE), &plane).0;
                step[k] = -h;
                let behind = standing_row(&candidate.stepped(&step, &FREE), &plane).0;
                let difference = (ahead - behind) / (2.0 * h);
                assert!((row[k] - difference).abs() < 1e-5 * (1.0 + difference.abs()), "unknown {k} {candidate:?}");
            }
            let moved = Plane { normal, offset_m: plane.offset_m + residual };
            assert!(standing_row(&candidate, &moved).0.abs() < 1e-12);
        }
    }

    #[test]
    fn weights_and_padding_count_as_they_should() {
        let mut rng = Rng::new(34, 0);
        let candidate = random_candidate(&mut rng);
        let points: Vec<_> = (0..37).map(|_| (Point3::from(rng.direction() * 0.3), rng.uniform(0.0, 2.0))).collect();
        let all = WeightedPoints::new(&points);
        let sum: f64 = points.iter().map(|(p, w)| w * single(*p, &candidate).cost).sum();
        assert!((Objective::new(&all, None).at(&candidate).cost - sum).abs() < 1e-12);
    }
}
