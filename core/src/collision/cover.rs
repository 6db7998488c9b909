//! Convex bodies inside a few capsules and inside one box: what the sieve looks at instead of the body.
//!
//! Every point of a body lies in one of its capsules, so where the capsules touch nothing, neither does the body. A long
//! body takes one capsule; a flat one takes a few side by side, for one alone would be as thick as the body is wide.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::frames::Rigid;
use super::solid::{Core, Solid};

/// Capsules that may stand side by side in one body.
const MOST: usize = 4;
/// How much wider than its body's cross-section a capsule is: a wider one needs to stand out less at the ends.
const WIDER: f64 = 1.1;

/// All points within `radius` of the segment from `a` to `b`; a ball when they are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Capsule {
    pub(crate) a: Vector3<f64>,
    pub(crate) b: Vector3<f64>,
    /// Metres.
    pub(crate) radius: f64,
}

/// A box about the origin of its own frame, which stands in the frame of the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuboid {
    pub(crate) X_FB: Rigid,
    pub(crate) half: Vector3<f64>,
}

/// Capsules that together hold a body, in the frame that carries it.
pub(crate) fn capsules(solid: &Solid) -> Vec<Capsule> {
    let in_F = |mut capsule: Capsule| {
        capsule.a = solid.X_FB.point(&capsule.a);
        capsule.b = solid.X_FB.point(&capsule.b);
        capsule.radius += solid.radius;
        capsule
    };
    match &solid.core {
        Core::Segment { a, b } => vec![Capsule { a: *a, b: *b, radius: solid.radius }],
        Core::Box { half } => box_cover(half).into_iter().map(in_F).collect(),
        Core::Cylinder { radius, half_length } if half_length < radius => {
            box_cover(&Vector3::new(*radius, *radius, *half_length)).into_iter().map(in_F).collect()
        }
        Core::Cylinder { radius, half_length } => {
            let wide = WIDER * radius;
            let end = Vector3::z() * (half_length - (wide * wide - radius * radius).sqrt()).max(0.0);
            vec![in_F(Capsule { a: -end, b: end, radius: wide })]
        }
        Core::Triangle { corners } => {
            let reach = corners.iter().map(|p| p.norm()).fold(0.0, f64::max);
            vec![in_F(Capsule { a: Vector3::zeros(), b: Vector3::zeros(), radius: reach })]
        }
        Core::Hull(hull) => hull.capsules().iter().copied().map(in_F).collect(),
    }
}

/// Capsules along the longest edges of a box, side by side in the two others as stands out least.
fn box_cover(half: &Vector3<f64>) -> Vec<Capsule> {
    let mut axes = [0, 1, 2];
    axes.sort_by(|&i, &j| half[j].total_cmp(&half[i]));
    let [long, wide, flat] = axes;
    let strip = |(m, n): (usize, usize)| (half[wide] / m as f64, half[flat] / n as f64);
    let stands_out = |grid: (usize, usize)| {
        let (w, f) = strip(grid);
        (w * w + f * f).sqrt() - w.min(f)
    };
    // More capsules only where they are worth their time.
    let grids = [(1, 1), (2, 1), (3, 1), (4, 1), (2, 2)];
    let grid = grids.into_iter().fold((1, 1), |best, grid| {
        if stands_out(grid) < 0.8 * stands_out(best) && grid.0 * grid.1 <= MOST { grid } else { best }
    });
    let (w, f) = strip(grid);
    let corner = (w * w + f * f).sqrt();
    let radius = WIDER * corner;
    let end = (half[long] - (radius * radius - corner * corner).sqrt()).max(0.0);
    let mut cover = Vec::with_capacity(grid.0 * grid.1);
    for i in 0..grid.0 {
        for j in 0..grid.1 {
            let mut a = Vector3::zeros();
            a[wide] = (2 * i + 1) as f64 * w - half[wide];
            a[flat] = (2 * j + 1) as f64 * f - half[flat];
            let mut b = a;
            (a[long], b[long]) = (-end, end);
            cover.push(Capsule { a, b, radius });
        }
    }
    cover
}

/// The smaller of the box along the axes and the box along the principal axes of the corners.
pub(crate) fn box_around(corners: &[Vector3<f64>]) -> Cuboid {
    let mean = corners.iter().sum::<Vector3<f64>>() / corners.len().max(1) as f64;
    let spread = corners.iter().map(|p| (p - mean) * (p - mean).transpose()).sum::<Matrix3<f64>>();
    let mut principal = SymmetricEigen::new(spread).eigenvectors;
    if principal.determinant() < 0.0 {
        principal.swap_columns(0, 1);
    }
    let fitted = |R: Matrix3<f64>| {
        let along = |p: &Vector3<f64>| R.tr_mul(p);
        let lower = corners.iter().fold(Vector3::repeat(f64::INFINITY), |m, p| m.inf(&along(p)));
        let upper = corners.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |m, p| m.sup(&along(p)));
        Cuboid { X_FB: Rigid { R, t: R * (0.5 * (lower + upper)) }, half: 0.5 * (upper - lower) }
    };
    let (straight, turned) = (fitted(Matrix3::identity()), fitted(principal));
    if turned.half.product() < 0.95 * straight.half.product() { turned } else { straight }
}

/// Capsules around a hull of these corners and edges, along the longest edge of the box around it.
pub(crate) fn hull_cover(corners: &[Vector3<f64>], edges: &[(u32, u32)], around: &Cuboid) -> Vec<Capsule> {
    let half = &around.half;
    let mut axes = [0, 1, 2];
    axes.sort_by(|&i, &j| half[j].total_cmp(&half[i]));
    let [long, wide, flat] = axes;
    let turned: Vec<Vector3<f64>> = corners.iter().map(|p| around.X_FB.inverse_point(p)).collect();
    let strips = ((half[wide] / half[flat].max(1e-9)) as usize).max(1).min(MOST);
    let width = 2.0 * half[wide] / strips as f64;
    let mut cover = Vec::with_capacity(strips);
    for strip in 0..strips {
        let (lo, hi) = (strip as f64 * width - half[wide], (strip + 1) as f64 * width - half[wide]);
        let mut inside: Vec<Vector3<f64>> = turned.iter().filter(|p| p[wide] >= lo && p[wide] <= hi).copied().collect();
        for &(from, to) in edges.iter().filter(|(from, to)| from < to) {
            let (p, q) = (turned[from as usize], turned[to as usize]);
            for cut in [lo, hi] {
                if (p[wide] - cut) * (q[wide] - cut) < 0.0 {
                    inside.push(p + (q - p) * ((cut - p[wide]) / (q[wide] - p[wide])));
                }
            }
        }
        cover.extend(capsule_around(&inside, long).map(|capsule| Capsule {
            a: around.X_FB.point(&capsule.a),
            b: around.X_FB.point(&capsule.b),
            radius: capsule.radius,
        }));
    }
    cover
}

/// A capsule along an axis around points; `None` for no points.
fn capsule_around(points: &[Vector3<f64>], axis: usize) -> Option<Capsule> {
    let lower = points.iter().fold(Vector3::repeat(f64::INFINITY), |m, p| m.inf(p));
    let upper = points.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |m, p| m.sup(p));
    let mut middle = 0.5 * (lower + upper);
    middle[axis] = 0.0;
    let aside = |p: &Vector3<f64>| {
        let mut across = p - middle;
        across[axis] = 0.0;
        across.norm_squared()
    };
    let widest = points.iter().map(aside).fold(0.0, f64::max);
    let radius = WIDER * widest.sqrt();
    // Each point asks for an axis point within √(r² − ρ²) of its own height.
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in points {
        let play = (radius * radius - aside(p)).max(0.0).sqrt();
        first = first.min(p[axis] + play);
        last = last.max(p[axis] - play);
    }
    if first > last {
        (first, last) = (0.5 * (first + last), 0.5 * (first + last));
    }
    let (mut a, mut b) = (middle, middle);
    (a[axis], b[axis]) = (first, last);
    // Cut points carry round-off of the corners that they lie between.
    (!points.is_empty()).then_some(Capsule { a, b, radius: radius + 1e-9 })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Translation3};

    use super::*;
    use crate::collision::ConvexHull;
    use crate::rng::Rng;

    fn is_in(capsule: &Capsule, p: &Vector3<f64>) -> bool {
        let d = capsule.b - capsule.a;
        let t = if d.norm_squared() > 0.0 { (p - capsule.a).dot(&d) / d.norm_squared() } else { 0.0 };
        (p - capsule.a - d * t.max(0.0).min(1.0)).norm() <= capsule.radius + 1e-9
    }

    #[test]
    fn every_point_of_a_body_is_in_one_of_its_capsules_and_in_its_box() {
        let mut rng = Rng::new(31, 0);
        for round in 0..400 {
            let size = Vector3::from_fn(|_, _| rng.uniform(0.005, 0.3));
            let core = match round % 4 {
                0 => Core::Box { half: size },
                1 => Core::Cylinder { radius: size.x, half_length: size.y },
                2 => {
                    let points: Vec<_> = (0..40).map(|_| Point3::from(rng.direction().component_mul(&size))).collect();
                    Core::Hull(ConvexHull::new("hull", &points).unwrap())
                }
                _ => {
                    let corner = |k: i32, bit: i32, h: f64| if k & bit == 0 { -h } else { h };
                    let corners: Vec<_> = (0..8)
                        .map(|k| Point3::new(corner(k, 1, size.x), corner(k, 2, size.y), corner(k, 4, size.z)))
                        .collect();
                    Core::Hull(ConvexHull::new("brick", &corners).unwrap())
                }
            };
            let place = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
            let solid = Solid::new(core, 0.01 * f64::from(round % 3), &place);
            let cover = capsules(&solid);
            assert!(!cover.is_empty() && cover.len() <= MOST);
            for _ in 0..300 {
                // A convex combination of points of the surface, swept by the rounding.
                let mut support = || solid.X_FB.point(&solid.core.support(&rng.direction()));
                let (p, q, r) = (support(), support(), support());
                let (s, t) = (rng.uniform(0.0, 1.0), rng.uniform(0.0, 1.0));
                let swept = rng.direction() * solid.radius;
                let p = p + (q - p) * s + (r - p) * (t * (1.0 - s)) + swept;
                assert!(cover.iter().any(|capsule| is_in(capsule, &p)), "round {round}: {p} is in no capsule");
            }
            if let Core::Hull(hull) = &solid.core {
                let around = hull.box_around();
                for corner in hull.corners() {
                    let p = around.X_FB.inverse_point(corner);
                    assert!((p.abs() - around.half).max() < 1e-12, "round {round}");
                }
            }
        }
    }
}
