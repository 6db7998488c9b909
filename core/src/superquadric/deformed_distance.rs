//! A lower bound of the distance to a tapered and bent body.
//!
//! The base body is convex, so it lies behind the plane that touches it where the ray from its centre through the base
//! point p_0 leaves it: `g · q_0 ≤ 1/ρ` with `g = ∇ln ρ(p_0)` (and `g · p_0 = 1`). Times the section's scale
//! `s = 1 + K z/c`, and in tapered coordinates `t = (s x, s y, z)`, this reads
//!
//! `χ(t) = g_x t_x + g_y t_y + (g_z t_z - 1/ρ)(1 + k t_z) ≤ 0`, `k = K/c`,
//!
//! a quadratic, whatever the exponents: the deformed body lies in `Ψ ≤ 0`, where `Ψ(p) = χ(t(p))` undoes the bend first.
//! How fast can Ψ fall along a straight motion of length d? Let `r = 1 - κy`, the distance to the axis of curvature be
//! `ϱ = r/|κ|`, `ε = d/ϱ ≤ 1/2`, and (dx, dy, dz) the motion along x, towards the axis and along the arc. Then
//!
//! * t_y changes by `dy - sgn(κ) δ`, `0 ≤ δ ≤ |κ| d² / (2 r (1 - ε))`: the way around an arc is longer,
//! * t_z changes by `dz/r + η`, `|η| ≤ |κ| d² / (2 r² (1 - ε)²)` (the Hessian of an angle is 1/ϱ²), in all by at most
//!   `d / (r (1 - ε))`,
//!
//! so `Ψ ≥ Ψ(p) - G d - H d²/2` with `G = |∇Ψ|` and
//! `H = ((g_y κ)⁺/r + |χ_z κ|/r² + 2 (-g_z k)⁺/r²) / (1 - ε)²`. Up to the smallest d at which this is 0 there is no
//! point of the body. Near the surface that is Ψ/G, first-order exact; on a taper that opens towards the point and on a
//! plain body H = 0, and it is the distance to a plane. From far away, and next to the axis of curvature, it is too
//! small: there the distance to the bent box around the body is larger, and the larger of both is taken.

use nalgebra::{Point3, Vector3};

use super::bent_box::BentBox;
use super::deformation::Deformation;
use super::{AxesGauge, Superquadric, fast_exp};

/// A motion is looked at up to this part of the distance to the axis of curvature: ε above.
const EPSILON_MAX: f64 = 0.5;

/// The signed distance of a deformed shape in its axes S, prepared for many points.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeformedField {
    gauge: AxesGauge,
    map: Deformation,
    /// |κ|, 1/m, and κ with its sign.
    curvature: f64,
    bend_per_m: f64,
    /// c and K/c.
    c: f64,
    taper_per_m: f64,
    bent_box: BentBox,
    /// No point of the body is deeper inside than this, metres.
    deepest_m: f64,
}

/// How a smooth function that is positive outside falls around a point: value, gradient, curvature bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clearance {
    /// Ψ, in units of its own.
    value: f64,
    /// ∇Ψ in S, per metre.
    pub(super) gradient_S: Vector3<f64>,
    /// H at ε = 0.
    curvature: f64,
    /// ϱ, metres; infinite for a straight body.
    radius_m: f64,
}

impl DeformedField {
    /// Prepares a shape.
    pub(super) fn new(shape: &Superquadric) -> Self {
        let widest = 1.0 + shape.taper.abs();
        let half = Vector3::new(shape.a * widest, shape.b * widest, shape.c);
        let arc = 1.0 + shape.bend_per_m.abs() * half.y;
        let map = shape.deformation();
        Self {
            gauge: AxesGauge::new([shape.a, shape.b, shape.c], [shape.e1, shape.e2]),
            map,
            curvature: shape.bend_per_m.abs(),
            bend_per_m: shape.bend_per_m,
            c: shape.c,
            taper_per_m: shape.taper / shape.c,
            bent_box: BentBox::new(half, map.bend()),
            // Along x, towards the axis of curvature or away from it, and along the arc, a body is left within these.
            deepest_m: half.x.min(half.y).min(shape.c * arc),
        }
    }

    /// The signed distance bound at a point of S and what it rests on; `None` at the centre.
    ///
    /// Inside, the same H tells how far one has to go along ∇Ψ at most to leave the body: the value is at least as deep.
    #[inline(always)]
    pub(super) fn at(&self, p_S: &Point3<f64>) -> Option<(f64, Clearance)> {
        let base = self.map.base_point(p_S);
        let p_0 = &base.p_0;
        let gauge = self.gauge.at([p_0.x, p_0.y, p_0.z]);
        let g = gauge.gradient();
        if g.norm_squared() == 0.0 {
            return None;
        }
        let (level, z) = (fast_exp(-gauge.ln_rho), p_0.z); // 1/ρ
        // Beyond the ends the taper's scale is another than 1 + k z, in which χ is quadratic.
        let linear = if z.abs() <= self.c { base.scale.value } else { 1.0 + self.taper_per_m * z };
        let value = base.scale.value * (1.0 - gauge.shares[2]) + linear * (gauge.shares[2] - level);
        let chi_z = g.z * linear + (g.z * z - level) * self.taper_per_m;
        let over = 1.0 / base.tapered.stretch;
        let hollow = (g.y * self.bend_per_m).max(0.0) * over;
        let closing = (-g.z * self.taper_per_m).max(0.0);
        let clearance = Clearance {
            value,
            gradient_S: base.tapered.inverse_transposed_times(&Vector3::new(g.x, g.y, chi_z)),
            curvature: hollow + (chi_z.abs() * self.curvature + 2.0 * closing) * over * over,
            radius_m: base.tapered.stretch / self.curvature,
        };
        let slope = clearance.gradient_S.norm();
        let distance = if gauge.ln_rho > 0.0 {
            clearance.safe_step(slope).max(self.bent_box.distance(p_S, &base.tapered))
        } else {
            -clearance.way_out(slope).min(self.deepest_m)
        };
        Some((distance, clearance))
    }

    /// Where the base point's ray leaves the surface, and the outward normal there (not of unit length), in S.
    pub(super) fn onto_surface(&self, p_S: &Point3<f64>) -> (Point3<f64>, Vector3<f64>) {
        let p_0 = self.map.undeformed(p_S);
        let gauge = self.gauge.at([p_0.x, p_0.y, p_0.z]);
        let foot_0 = p_0 * fast_exp(-gauge.ln_rho);
        (self.map.deformed(&foot_0), self.map.at_base(&foot_0).gradient_in_axes(&gauge.gradient()))
    }
}

impl Clearance {
    /// A clearance that is linear in the point: the distance to a plane, in any unit.
    #[inline(always)]
    pub(super) fn linear(value: f64, gradient_S: Vector3<f64>) -> Self {
        Self { value, gradient_S, curvature: 0.0, radius_m: f64::INFINITY }
    }

    /// How far one may go, metres, while Ψ > 0 falls by at most `fall` per metre to first order; may be infinite.
    #[inline(always)]
    pub(super) fn safe_step(&self, fall: f64) -> f64 {
        let step = |curvature: f64| {
            let root = (fall * fall + 2.0 * curvature * self.value).sqrt();
            if fall > 0.0 { 2.0 * self.value / (fall + root) } else { (root - fall) / curvature }
        };
        if self.value <= 0.0 {
            return 0.0;
        }
        if self.radius_m == f64::INFINITY {
            return if self.curvature > 0.0 || fall > 0.0 { step(self.curvature) } else { f64::INFINITY };
        }
        let epsilon = (step(self.curvature) / self.radius_m).min(EPSILON_MAX);
        let rest = 1.0 - epsilon;
        step(self.curvature / (rest * rest)).min(EPSILON_MAX * self.radius_m)
    }

    /// How far one has to go up the gradient until Ψ < 0 is positive for sure, metres; may be infinite.
    #[inline(always)]
    fn way_out(&self, slope: f64) -> f64 {
        let way = |curvature: f64| {
            let square = slope * slope + 2.0 * curvature * self.value;
            if square > 0.0 { -2.0 * self.value / (slope + square.sqrt()) } else { f64::INFINITY }
        };
        // ε for twice the first-order way: a longer one than that is not believed.
        let epsilon = -2.0 * self.value / (slope * self.radius_m);
        if epsilon > EPSILON_MAX {
            return f64::INFINITY;
        }
        let rest = 1.0 - epsilon;
        let found = way(self.curvature / (rest * rest));
        if found <= -2.0 * self.value / slope { found } else { f64::INFINITY }
    }
}
