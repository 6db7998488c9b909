//! The shapes that links are made of: turned profiles, lofted sections, rounded boxes and swept tubes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::surface::{Surface, V3, cross, sub, unit};

/// Segments around a turned body.
const AROUND: usize = 30;

/// Points around a lofted section.
const SECTION: usize = 26;

/// Steps of a rounded quarter turn; a small rounding is one step with the normals of an arc.
const CORNER: f64 = 3.0;

/// Up to here a rounding is small, metres.
const SMALL: f64 = 0.0025;

/// A corner of a profile: radius, height, and how far it is rounded.
pub(super) type Corner = (f64, f64, f64);

/// A body turned about z. The profile runs upwards along the outside, so that normals point outwards; a corner of
/// rounding 0 stays sharp.
pub(super) fn lathe(profile: &[Corner]) -> Surface {
    lathe_with(profile, AROUND)
}

/// As [`lathe`], with a number of segments of its own for small parts.
pub(super) fn lathe_with(profile: &[Corner], around: usize) -> Surface {
    let mut rows: Vec<(f64, f64, f64, f64)> = Vec::new(); // r, z, and the normal's two parts
    for (i, &(r, z, rounding)) in profile.iter().enumerate() {
        let direction = |from: Corner, to: Corner| {
            let (dr, dz) = (to.0 - from.0, to.1 - from.1);
            let length = dr.hypot(dz).max(1e-12);
            (dr / length, dz / length, length)
        };
        let before = i.checked_sub(1).map(|k| direction(profile[k], profile[i]));
        let after = profile.get(i + 1).map(|&next| direction(profile[i], next));
        match (before, after) {
            (Some(a), Some(b)) if rounding > 0.0 => {
                // The arc touches both edges at the same distance from the corner.
                let turn = (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1);
                let reach = (rounding * (0.5 * turn.abs()).tan()).min(0.49 * a.2).min(0.49 * b.2);
                let radius = reach / (0.5 * turn.abs()).tan();
                let start = (r - a.0 * reach, z - a.1 * reach);
                let side = turn.signum();
                let center = (start.0 - side * a.1 * radius, start.1 + side * a.0 * radius);
                let arc = (CORNER * turn.abs() / FRAC_PI_2).ceil() as usize;
                let steps = if rounding <= SMALL { 1 } else { arc.max(1) };
                for step in 0..=steps {
                    let (sin, cos) = (turn * step as f64 / steps as f64).sin_cos();
                    let n = (a.1 * cos + a.0 * sin, -a.0 * cos + a.1 * sin);
                    rows.push((center.0 + side * radius * n.0, center.1 + side * radius * n.1, n.0, n.1));
                }
            }
            _ => {
                for edge in [before, after].into_iter().flatten() {
                    rows.push((r, z, edge.1, -edge.0));
                }
            }
        }
    }
    let mut surface = Surface::default();
    for (r, z, nr, nz) in &rows {
        for j in 0..around {
            let (sin, cos) = (TAU * j as f64 / around as f64).sin_cos();
            surface.points.push([r * cos, r * sin, *z]);
            surface.normals.push([nr * cos, nr * sin, *nz]);
        }
    }
    surface.stitch(rows.len(), around);
    surface
}

/// A ring with a round section about z; the part of its inner side that the body hides is left out.
pub(super) fn ring(radius: f64, tube: f64, z: f64) -> Surface {
    let profile: Vec<(f64, f64)> = (-2..=2).map(|i| (f64::from(i) * 1.15).sin_cos()).collect();
    let mut surface = Surface::default();
    for (sin, cos) in &profile {
        for j in 0..AROUND {
            let (s, c) = (TAU * j as f64 / AROUND as f64).sin_cos();
            let r = radius + tube * cos;
            surface.points.push([r * c, r * s, z + tube * sin]);
            surface.normals.push([cos * c, cos * s, *sin]);
        }
    }
    surface.stitch(profile.len(), AROUND);
    surface
}

/// A ball.
pub(super) fn ball(radius: f64) -> Surface {
    let mut surface = Surface::default();
    let rows = 11;
    for i in 0..=rows {
        let (z, r) = (PI * f64::from(i) / f64::from(rows) - FRAC_PI_2).sin_cos();
        for j in 0..AROUND {
            let (s, c) = (TAU * j as f64 / AROUND as f64).sin_cos();
            surface.points.push([radius * r * c, radius * r * s, radius * z]);
            surface.normals.push([r * c, r * s, z]);
        }
    }
    surface.stitch(rows as usize + 1, AROUND);
    surface
}

/// One section of a loft: a superellipse at a height.
#[derive(Clone, Copy)]
pub(super) struct Section {
    pub(super) z: f64,
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
    /// 2 is an ellipse, larger is squarer.
    pub(super) exponent: f64,
}

impl Section {
    /// A circle about the axis.
    pub(super) fn circle(z: f64, r: f64) -> Self {
        Self { z, x: [-r, r], y: [-r, r], exponent: 2.0 }
    }

    /// A rounded rectangle between two corners.
    pub(super) fn between(z: f64, x: [f64; 2], y: [f64; 2], exponent: f64) -> Self {
        Self { z, x, y, exponent }
    }

    fn points(&self, around: usize) -> Vec<V3> {
        let (cx, hx) = (0.5 * (self.x[0] + self.x[1]), 0.5 * (self.x[1] - self.x[0]));
        let (cy, hy) = (0.5 * (self.y[0] + self.y[1]), 0.5 * (self.y[1] - self.y[0]));
        (0..around)
            .map(|j| {
                let (sin, cos) = (TAU * j as f64 / around as f64).sin_cos();
                let power = |v: f64| v.signum() * v.abs().powf(2.0 / self.exponent);
                [cx + hx * power(cos), cy + hy * power(sin), self.z]
            })
            .collect()
    }
}

/// A smooth body through sections from the lowest to the highest, closed at both ends.
pub(super) fn loft(sections: &[Section]) -> Surface {
    loft_with(sections, SECTION)
}

/// As [`loft`], with a number of points around of its own for small parts.
pub(super) fn loft_with(sections: &[Section], around: usize) -> Surface {
    let mut rows: Vec<Vec<V3>> = sections.iter().map(|section| section.points(around)).collect();
    let cap = |row: &Vec<V3>| {
        let sum = row.iter().fold([0.0; 3], |sum, p| [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]]);
        vec![sum.map(|x| x / row.len() as f64); row.len()]
    };
    let caps = [rows.first().map(cap), rows.last().map(cap)];
    let [bottom, top] = caps.map(Option::unwrap_or_default);
    rows.insert(0, bottom);
    rows.push(top);
    Surface::closed_rows(&rows)
}

/// A box with rounded edges, centred.
pub(super) fn rounded_box(size: V3, rounding: f64) -> Surface {
    let steps = 2;
    let mut surface = Surface::default();
    let corner = size.map(|edge| 0.5 * edge - rounding);
    let angle = |i: usize| FRAC_PI_2 * i as f64 / steps as f64;
    let mut rows = 0;
    for half in 0..2 {
        for i in 0..=steps {
            let (nz, nr) = (angle(i) - if half == 0 { FRAC_PI_2 } else { 0.0 }).sin_cos();
            for quadrant in 0..4 {
                let sign = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][quadrant];
                for j in 0..=steps {
                    let (s, c) = (FRAC_PI_2 * quadrant as f64 + angle(j)).sin_cos();
                    let n = [nr * c, nr * s, nz];
                    let z = if half == 0 { -corner[2] } else { corner[2] };
                    surface.points.push([
                        sign[0] * corner[0] + rounding * n[0],
                        sign[1] * corner[1] + rounding * n[1],
                        z + rounding * n[2],
                    ]);
                    surface.normals.push(n);
                }
            }
            rows += 1;
        }
    }
    let n = 4 * (steps + 1);
    surface.stitch(rows, n);
    // The two flat ends: the first and the last row enclose them.
    let corners = |row: usize| (0..4).map(move |q| row * n + q * (steps + 1)).collect::<Vec<_>>();
    surface.faces.push(corners(0).into_iter().rev().collect());
    surface.faces.push(corners(rows - 1));
    surface
}

/// A tube along a quadratic Bézier curve in the plane y = 0, with round ends left open (they end inside other bodies).
pub(super) fn bent_tube(from: V3, over: V3, to: V3, radius: f64) -> Surface {
    let steps = 12;
    let curve = |t: f64| -> V3 {
        let (a, b, c) = ((1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t);
        std::array::from_fn(|k| a * from[k] + b * over[k] + c * to[k])
    };
    let mut surface = Surface::default();
    for i in 0..=steps {
        let t = f64::from(i) / f64::from(steps);
        let p = curve(t);
        let along = unit(sub(curve((t + 0.01).min(1.0)), curve((t - 0.01).max(0.0))));
        let side = [0.0, 1.0, 0.0];
        let up = cross(along, side);
        for j in 0..AROUND / 2 {
            let (sin, cos) = (TAU * j as f64 / (AROUND / 2) as f64).sin_cos();
            let n: V3 = std::array::from_fn(|k| up[k] * cos - side[k] * sin);
            surface.normals.push(n);
            surface.points.push(std::array::from_fn(|k| p[k] + radius * n[k]));
        }
    }
    surface.stitch(steps as usize + 1, AROUND / 2);
    surface
}
