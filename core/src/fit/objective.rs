//! The five objectives (3.4–3.8, corrected) with their analytic Jacobians, summed into normal equations.
//!
//! All of them are a function of the gauge `ρ = f^(e1/2)` and of the distance `r = |p_0|` of a point from the centre,
//! both in the base shape (before taper and bend): `d = s · r^k · h(ln ρ)` with `s` either 1 or `√(abc)`.
//!
//! | objective | s | k | h(L), L = ln ρ |
//! | --- | --- | --- | --- |
//! | radial | 1 | 1 | `1 - e^-L` |
//! | Solina | `√(abc)` | 0 | `e^2L - 1` |
//! | Ichim | `√(abc)` | 1 | `e^2L - 1` |
//! | Chevalier | 1 | 1 | `e^L - 1` |
//! | f5 | 1 | 1 | `e^2L - 1` |
//!
//! So `∂d/∂θ = s r^k h' ∂L/∂θ` for a shape parameter θ (and `d/(2a)` more for a semi-axis under the root), and
//! `g = ∂d/∂p_0 = s (k r^(k-2) h p_0 + r^k h' ∂L/∂p_0)`. Moving the centre gives `-R g`, turning S about its own axes
//! `g × p_S`; with a deformation, `∂p_0/∂p_S` stands between.

use nalgebra::{Point3, Vector3};

use super::candidate::{BEND, Candidate, DEFORMED, PLAIN, TAPER};
use super::normal_equations::{NormalEquations, Rows, Sums};
use super::standing::standing_row;
use super::types::ObjectiveKind;
use super::weighted::{CHUNK, Chunk, WeightedPoints};
use crate::segment::Plane;
use crate::simd::{Kernel, widest};
use crate::superquadric::{AxesGauge, Deformation, Undeformed, fast_exp};

/// The least-squares problem of one fit.
#[derive(Clone, Copy)]
pub(crate) struct Objective<'a> {
    points: &'a WeightedPoints,
    kind: ObjectiveKind,
    /// The table in D, and the weight of standing on it as a share of the points' total weight.
    table: Option<(Plane, f64)>,
    /// Half extents of the cloud that the semi-axes are drawn to, and the weight as a share of the points' total.
    drawn_to: Option<([f64; 3], f64)>,
}

impl<'a> Objective<'a> {
    /// The objective on these points.
    pub(crate) fn new(points: &'a WeightedPoints, kind: ObjectiveKind) -> Self {
        Self { points, kind, table: None, drawn_to: None }
    }

    /// The same with one more residual: the lowest point is on the plane; weight relative to all points together.
    pub(crate) fn standing_on(self, table: Option<(Plane, f64)>) -> Self {
        Self { table, ..self }
    }

    /// The same with semi-axes drawn towards these lengths, metres.
    ///
    /// An open side says nothing about how far the shape goes on; among shapes that explain the points alike, this
    /// prefers the small one (the thesis's scale factors `√(abc)` are there for the same reason).
    pub(crate) fn drawn_to(self, semi_axes: [f64; 3], share: f64) -> Self {
        Self { drawn_to: Some((semi_axes, share)), ..self }
    }

    /// Sum of the weights: the cost over this is a mean square.
    pub(crate) fn total_weight(&self) -> f64 {
        self.points.total_weight
    }

    /// Cost, gradient and Gauss–Newton matrix at a candidate, over N unknowns (`PLAIN` or `DEFORMED`).
    pub(crate) fn at<const N: usize>(&self, candidate: &Candidate) -> NormalEquations<N> {
        let chunks = &self.points.chunks;
        let frame = CandidateFrame::new(candidate, self.kind);
        // One kernel per objective, so that the loop over points has no branch.
        let mut equations = match self.kind {
            ObjectiveKind::Radial => widest(Pass::<N, 0> { chunks, frame }),
            ObjectiveKind::Chevalier => widest(Pass::<N, 1> { chunks, frame }),
            ObjectiveKind::Solina => widest(Pass::<N, 2> { chunks, frame }),
            ObjectiveKind::Ichim | ObjectiveKind::F5 => widest(Pass::<N, 3> { chunks, frame }),
        };
        // The other objectives are not lengths; their residuals are this much larger for the same distance.
        let per_metre = frame.per_metre(self.kind);
        if let Some((plane, share)) = &self.table {
            let (residual, row) = standing_row::<N>(candidate, plane);
            equations.add_row(residual, &row, share * per_metre * per_metre * self.points.total_weight);
        }
        if let Some((semi_axes, share)) = &self.drawn_to {
            for (k, target) in semi_axes.iter().enumerate() {
                let mut row = [0.0; N];
                row[k] = 1.0;
                let weight = share * per_metre * per_metre * self.points.total_weight;
                equations.add_row(candidate.values[k] - target, &row, weight);
            }
        }
        equations
    }
}

impl WeightedPoints {
    /// How far each point is from the surface of a candidate, whatever is minimised.
    pub(crate) fn residuals(&self, candidate: &Candidate) -> Vec<Residual> {
        let (chunks, frame) = (&self.chunks, CandidateFrame::new(candidate, ObjectiveKind::Radial));
        let mut residuals = if candidate.is_deformed() {
            widest(ResidualPass::<DEFORMED> { chunks, frame })
        } else {
            widest(ResidualPass::<PLAIN> { chunks, frame })
        };
        residuals.truncate(self.count);
        residuals
    }
}

/// How far a point is from a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual {
    /// Distance along the normal to first order, metres; negative inside.
    pub(crate) normal_m: f64,
    /// `(radial distance / distance along the normal)²`, at least 1: by how much the ray from the centre is oblique.
    pub(crate) obliqueness: f64,
    /// Distance from the centre, metres.
    pub(crate) radius_m: f64,
}

/// One pass over the points. `FORM`: 0 radial, 1 Chevalier, 2 Solina, 3 Ichim and f5.
struct Pass<'a, const N: usize, const FORM: u8> {
    chunks: &'a [Chunk],
    frame: CandidateFrame,
}

impl<const N: usize, const FORM: u8> Kernel for Pass<'_, N, FORM> {
    type Output = NormalEquations<N>;

    #[inline(always)]
    fn run(self) -> NormalEquations<N> {
        let mut sums = Sums::new();
        for chunk in self.chunks {
            sums.add(&self.frame.rows::<N, FORM>(chunk));
        }
        sums.finish()
    }
}

/// The pass of [`WeightedPoints::residuals`].
struct ResidualPass<'a, const N: usize> {
    chunks: &'a [Chunk],
    frame: CandidateFrame,
}

impl<const N: usize> Kernel for ResidualPass<'_, N> {
    type Output = Vec<Residual>;

    #[inline(always)]
    fn run(self) -> Vec<Residual> {
        let mut residuals = Vec::with_capacity(self.chunks.len() * CHUNK);
        for chunk in self.chunks {
            for k in 0..CHUNK {
                let p_S = self.frame.in_axes(chunk, k);
                let base = if N == PLAIN { None } else { Some(self.frame.undeformed(p_S)) };
                let p = base.as_ref().map_or(p_S, |base| base.p_0.coords.into());
                let squared = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
                let gauge = self.frame.gauge.at(p);
                let g = match &base {
                    None => gauge.gradient,
                    Some(base) => base.by_point.tr_mul(&Vector3::from(gauge.gradient)).into(),
                };
                let slope = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
                let radius_m = (if squared > 1e-24 { squared } else { 1e-24 }).sqrt();
                let obliqueness = squared * slope;
                let obliqueness = if obliqueness > 1.0 { obliqueness } else { 1.0 };
                let radial_m = radius_m * (1.0 - fast_exp(-gauge.ln_rho));
                residuals.push(Residual { normal_m: radial_m / obliqueness.sqrt(), obliqueness, radius_m });
            }
        }
        residuals
    }
}

/// What a candidate contributes to every point.
#[derive(Clone, Copy)]
struct CandidateFrame {
    gauge: AxesGauge,
    inverse_axes: [f64; 3],
    /// Row-major rotation of S in D, and the centre in D.
    rotation: [[f64; 3]; 3],
    center: [f64; 3],
    deformation: Deformation,
    /// `√(abc)` for the objectives that have it, else 1, and ½ or 0: the power of the semi-axes in it.
    scale: f64,
    root_power: f64,
}

impl CandidateFrame {
    fn new(candidate: &Candidate, kind: ObjectiveKind) -> Self {
        let gauge = AxesGauge::new(candidate.axes(), candidate.exponents());
        let R = candidate.rotation();
        let rotation = [0, 1, 2].map(|i| [R[(i, 0)], R[(i, 1)], R[(i, 2)]]);
        let t = candidate.center();
        let [a, b, c] = candidate.axes();
        let is_scaled = matches!(kind, ObjectiveKind::Solina | ObjectiveKind::Ichim);
        Self {
            gauge,
            inverse_axes: gauge.inverse_axes,
            rotation,
            center: [t.x, t.y, t.z],
            deformation: Deformation::new(candidate.values[TAPER], candidate.values[BEND], c),
            scale: if is_scaled { (a * b * c).sqrt() } else { 1.0 },
            root_power: if is_scaled { 0.5 } else { 0.0 },
        }
    }

    /// Size of the residual of a point one metre off the surface, to first order, at the mean semi-axis.
    fn per_metre(&self, kind: ObjectiveKind) -> f64 {
        let mean_inverse = (self.inverse_axes[0] + self.inverse_axes[1] + self.inverse_axes[2]) / 3.0;
        match kind {
            ObjectiveKind::Radial | ObjectiveKind::Chevalier => 1.0,
            ObjectiveKind::F5 => 2.0,
            ObjectiveKind::Ichim => 2.0 * self.scale,
            ObjectiveKind::Solina => 2.0 * self.scale * mean_inverse,
        }
    }

    #[inline(always)]
    fn in_axes(&self, chunk: &Chunk, k: usize) -> [f64; 3] {
        let R = &self.rotation;
        let v = [0, 1, 2].map(|i| chunk.p[i][k] - self.center[i]);
        [0, 1, 2].map(|j| R[0][j] * v[0] + R[1][j] * v[1] + R[2][j] * v[2])
    }

    /// A point of S before taper and bend; their derivatives exist even where both are still 0.
    #[inline(always)]
    fn undeformed(&self, p_S: [f64; 3]) -> Undeformed {
        self.deformation.undeformed_with_derivatives(&Point3::from(p_S))
    }

    #[inline(always)]
    fn rows<const N: usize, const FORM: u8>(&self, chunk: &Chunk) -> Rows<N> {
        let mut rows = Rows { columns: [[0.0; CHUNK]; N], residual: [0.0; CHUNK] };
        let R = &self.rotation;
        for k in 0..CHUNK {
            let p_S = self.in_axes(chunk, k);
            let base = if N == PLAIN { None } else { Some(self.undeformed(p_S)) };
            let p = base.as_ref().map_or(p_S, |base| base.p_0.coords.into());
            let squared = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            let radius = (if squared > 1e-24 { squared } else { 1e-24 }).sqrt();
            let gauge = self.gauge.at(p);
            let (value, slope) = form::<FORM>(gauge.ln_rho);
            // d = length · value, ∂d/∂L = length · slope, ∂length/∂p = outward p.
            let length = self.scale * (if FORM == 2 { 1.0 } else { radius });
            let outward = if FORM == 2 { 0.0 } else { self.scale * value / radius };
            let (d, steep) = (length * value, length * slope);
            let g_0 = [0, 1, 2].map(|i| outward * p[i] + steep * gauge.gradient[i]);
            let w = chunk.root_weight[k];
            rows.residual[k] = w * d;
            let g = match &base {
                None => g_0,
                Some(base) => base.by_point.tr_mul(&Vector3::from(g_0)).into(),
            };
            for (i, R_i) in R.iter().enumerate() {
                rows.columns[i][k] = w * (self.root_power * d - steep * gauge.shares[i]) * self.inverse_axes[i];
                rows.columns[5 + i][k] = -w * (R_i[0] * g[0] + R_i[1] * g[1] + R_i[2] * g[2]);
            }
            rows.columns[3][k] = w * steep * gauge.by_exponent[0];
            rows.columns[4][k] = w * steep * gauge.by_exponent[1];
            rows.columns[8][k] = w * (g[1] * p_S[2] - g[2] * p_S[1]);
            rows.columns[9][k] = w * (g[2] * p_S[0] - g[0] * p_S[2]);
            rows.columns[10][k] = w * (g[0] * p_S[1] - g[1] * p_S[0]);
            if let Some(base) = &base {
                let along = |v: &Vector3<f64>| v.x * g_0[0] + v.y * g_0[1] + v.z * g_0[2];
                rows.columns[2][k] += w * along(&base.by_c);
                if N == DEFORMED {
                    rows.columns[11][k] = w * along(&base.by_taper);
                    rows.columns[12][k] = w * along(&base.by_bend);
                }
            }
        }
        rows
    }
}

/// h(L) and h'(L) of an objective.
#[inline(always)]
fn form<const FORM: u8>(ln_rho: f64) -> (f64, f64) {
    match FORM {
        0 => {
            let shrink = fast_exp(-ln_rho);
            (1.0 - shrink, shrink)
        }
        1 => {
            let rho = fast_exp(ln_rho);
            (rho - 1.0, rho)
        }
        _ => {
            let square = fast_exp(2.0 * ln_rho);
            (square - 1.0, 2.0 * square)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::candidate::{Bounds, VALUES};
    use crate::math;
    use crate::rng::Rng;
    use crate::superquadric::{Superquadric, bend_limit_per_m};

    const FREE: Bounds = Bounds { lower: [-9.0; VALUES], upper: [9.0; VALUES] };

    fn random_candidate(rng: &mut Rng) -> Candidate {
        let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.3));
        let e = [0.0; 2].map(|_: f64| rng.uniform(0.12, 1.88));
        Candidate::new(axes, e, rng.direction() * 0.3, rng.rotation())
    }

    /// Residual and row of one point through the public door: a cloud of one point has H = row rowᵀ.
    fn single(p: Point3<f64>, candidate: &Candidate) -> NormalEquations<PLAIN> {
        Objective::new(&WeightedPoints::new(&[(p, 1.0)]), ObjectiveKind::Radial).at(candidate)
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

    /// The residual by the formulas of the module's table, without logarithms or Jacobians.
    fn residual_by_hand(kind: ObjectiveKind, candidate: &Candidate, p: &Point3<f64>) -> f64 {
        let shape = candidate.superquadric(&nalgebra::Isometry3::identity());
        let p_0 = shape.deformation().undeformed(&shape.to_axes(p));
        let base = Superquadric { taper: 0.0, bend_per_m: 0.0, X_FS: nalgebra::Isometry3::identity(), ..shape };
        let f = base.inside_outside(&p_0);
        let (r, root) = (p_0.coords.norm(), (shape.a * shape.b * shape.c).sqrt());
        let power = |exponent: f64| math::powf(f, exponent);
        match kind {
            ObjectiveKind::Radial => r * (1.0 - power(-0.5 * shape.e1)),
            ObjectiveKind::Solina => root * (power(shape.e1) - 1.0),
            ObjectiveKind::Ichim => root * r * (power(shape.e1) - 1.0),
            ObjectiveKind::Chevalier => r * (power(0.5 * shape.e1) - 1.0),
            ObjectiveKind::F5 => r * (power(shape.e1) - 1.0),
        }
    }

    fn check_jacobian<const N: usize>(kind: ObjectiveKind, candidate: &Candidate, p: Point3<f64>, from: usize) {
        let points = WeightedPoints::new(&[(p, 1.0)]);
        let equations = Objective::new(&points, kind).at::<N>(candidate);
        let residual = residual_by_hand(kind, candidate, &p);
        // e^ln f with f up to e^20 keeps 1e-13 of its value.
        assert!((equations.cost.sqrt() - residual.abs()).abs() < 1e-10 * (1.0 + residual.abs()), "{kind:?}");
        let h = 1e-6;
        for k in (0..N).filter(|k| *k < 5 || *k >= from) {
            let mut step = [0.0; N];
            step[k] = h;
            let ahead = residual_by_hand(kind, &candidate.stepped(&step, &FREE), &p);
            step[k] = -h;
            let behind = residual_by_hand(kind, &candidate.stepped(&step, &FREE), &p);
            let difference = (ahead - behind) / (2.0 * h);
            // Gradient = row · residual, so the row is known where the residual is; third derivatives reach 1e5.
            let row = equations.gradient[k] / residual;
            let tolerance = 3e-5 * (1.0 + difference.abs()) + 1e-9 / residual.abs();
            assert!((row - difference).abs() < tolerance, "{kind:?} unknown {k}: {row} {difference} {candidate:?} {p}");
        }
    }

    #[test]
    fn jacobians_of_all_objectives_match_central_differences_on_axis_planes_too() {
        let mut rng = Rng::new(32, 0);
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
            for kind in ObjectiveKind::ALL {
                // A motion off the plane has a one-sided power |x|^(2/e) there, which no difference resolves.
                check_jacobian::<PLAIN>(kind, &candidate, p, if on_plane < 3 { PLAIN } else { 5 });
            }
        }
    }

    #[test]
    fn jacobians_of_deformed_shapes_match_central_differences() {
        let mut rng = Rng::new(35, 0);
        for trial in 0..200 {
            let mut candidate = random_candidate(&mut rng);
            let [_, b, c] = candidate.axes();
            if trial % 4 > 0 {
                candidate.values[TAPER] = rng.uniform(-0.7, 0.7);
                candidate.values[BEND] = rng.uniform(-0.8, 0.8) * bend_limit_per_m(b, c, 0.7);
            }
            let shape = candidate.superquadric(&nalgebra::Isometry3::identity());
            let mut p_0 = rng.direction().component_mul(&Vector3::from(candidate.axes())) * rng.uniform(0.6, 1.3);
            for axis in 0..3 {
                let floor = 0.1 * candidate.axes()[axis];
                p_0[axis] = if p_0[axis] < 0.0 { p_0[axis].min(-floor) } else { p_0[axis].max(floor) };
            }
            let p = shape.X_FS * shape.deformation().deformed(&Point3::from(p_0));
            for kind in ObjectiveKind::ALL {
                check_jacobian::<DEFORMED>(kind, &candidate, p, 5);
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
    fn weights_and_padding_count_as_they_should() {
        let mut rng = Rng::new(34, 0);
        let candidate = random_candidate(&mut rng);
        let points: Vec<_> = (0..37).map(|_| (Point3::from(rng.direction() * 0.3), rng.uniform(0.0, 2.0))).collect();
        let all = WeightedPoints::new(&points);
        let sum: f64 = points.iter().map(|(p, w)| w * single(*p, &candidate).cost).sum();
        assert!((Objective::new(&all, ObjectiveKind::Radial).at::<PLAIN>(&candidate).cost - sum).abs() < 1e-12);
    }
}
