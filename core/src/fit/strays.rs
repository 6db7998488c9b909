//! Gross outliers: points that stand alone, found before a second search, and points far from the result.

use std::collections::HashMap;

use nalgebra::Point3;

use super::objective::Residual;
use super::robust::sigma_m;
use super::thin::cell;

/// Outliers are suspected when more than this share of the points is far from the first fit.
const SUSPICIOUS_SHARE: f64 = 0.02;
/// Residuals of noise are below this, metres, or below this part of the mean distance from the centre.
const POOR_M: f64 = 0.003;
const POOR_SHARE: f64 = 0.02;
/// A point is far beyond this many σ, and beyond this part of the mean distance from the centre.
const FAR_SIGMAS: f64 = 6.0;
const FAR_SHARE: f64 = 0.04;
/// A point with fewer points around it than this part of the median stands alone. On a surface the least is about a
/// quarter (a corner of a rim), in a cloud of strays around it a few percent.
const LONELY_SHARE: f64 = 0.2;
/// Points per cell that the grid for neighbours aims at, on the surface of the cloud's bounding box.
const PER_CELL: f64 = 2.0;
/// Cells on that surface at most.
const MOST_CELLS: f64 = 3000.0;
/// Passes: each makes the bounding box, and with it the cells, smaller.
const PASSES: usize = 3;

/// Distance along the normal beyond which a point does not belong to the shape, metres.
pub(crate) fn limit_m(residuals: &[Residual]) -> f64 {
    (FAR_SIGMAS * sigma_m(residuals)).max(FAR_SHARE * radius_m(residuals))
}

/// Mean distance from the centre, metres.
fn radius_m(residuals: &[Residual]) -> f64 {
    residuals.iter().map(|r| r.radius_m).sum::<f64>() / residuals.len().max(1) as f64
}

/// Whether the residuals are larger than noise: more than 3 mm and than a fiftieth of the mean distance from the centre.
pub(crate) fn is_poor(residuals: &[Residual]) -> bool {
    sigma_m(residuals) > POOR_M.max(POOR_SHARE * radius_m(residuals))
}

/// Whether so many points are far that gross outliers may have spoiled the search.
pub(crate) fn are_suspected(residuals: &[Residual]) -> bool {
    let limit_m = limit_m(residuals);
    let far = residuals.iter().filter(|r| r.normal_m.abs() > limit_m).count();
    // Strays may have spoiled the fit so much that none of them is far from it.
    far as f64 > SUSPICIOUS_SHARE * residuals.len() as f64 || is_poor(residuals)
}

/// Which points have neighbours: as many as most have, or nearly.
pub(crate) fn in_company(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    (0..PASSES).fold(points.to_vec(), |left, _| without_lonely(left))
}

fn without_lonely(points: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
    let Some(edge_m) = cell_m(&points) else { return points };
    // Looked up, never iterated, so the order of the hash does not matter.
    let mut counts: HashMap<[i32; 3], u32> = HashMap::new();
    for p in &points {
        *counts.entry(cell(p, edge_m)).or_default() += 1;
    }
    let mut known: HashMap<[i32; 3], u32> = HashMap::with_capacity(counts.len());
    let company: Vec<u32> = points
        .iter()
        .map(|p| {
            *known
                .entry(cell(p, edge_m))
                .or_insert_with_key(|key| around(*key).filter_map(|near| counts.get(&near)).sum())
        })
        .collect();
    let mut sorted = company.clone();
    sorted.sort_unstable();
    let median = f64::from(sorted[sorted.len() / 2]);
    points.into_iter().zip(company).filter(|(_, n)| f64::from(*n) >= LONELY_SHARE * median).map(|(p, _)| p).collect()
}

/// A cell and the 26 that touch it.
fn around([x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (-1..=1).flat_map(move |i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])))
}

/// Connected pieces of a set of points, largest first: indices of their points in ascending order.
///
/// Points are connected when their cells touch, cells being as large as neighbours are apart.
pub(crate) fn pieces(points: &[Point3<f64>]) -> Vec<Vec<usize>> {
    let Some(edge_m) = cell_m(points) else { return Vec::new() };
    // Looked up, never iterated, so the order of the hash does not matter.
    let mut members: HashMap<[i32; 3], Vec<usize>> = HashMap::new();
    for (k, p) in points.iter().enumerate() {
        members.entry(cell(p, edge_m)).or_default().push(k);
    }
    let mut is_taken = vec![false; points.len()];
    let mut pieces = Vec::new();
    for first in 0..points.len() {
        if is_taken[first] {
            continue;
        }
        is_taken[first] = true;
        let mut piece = vec![first];
        let mut next = 0;
        while let Some(&k) = piece.get(next) {
            next += 1;
            for key in around(cell(&points[k], edge_m)) {
                for &other in members.get(&key).into_iter().flatten() {
                    if !std::mem::replace(&mut is_taken[other], true) {
                        piece.push(other);
                    }
                }
            }
        }
        piece.sort_unstable();
        pieces.push(piece);
    }
    pieces.sort_by_key(|piece| std::cmp::Reverse(piece.len())); // stable: equal pieces keep their order
    pieces
}

/// Edge of the grid for neighbours, metres; `None` without extent.
fn cell_m(points: &[Point3<f64>]) -> Option<f64> {
    let first = points.first()?;
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let [x, y, z] = (high - low).into();
    let surface = 2.0 * (x * y + y * z + z * x);
    let per_cell = PER_CELL.max(points.len() as f64 / MOST_CELLS);
    let edge_m = (surface * per_cell / points.len() as f64).sqrt();
    (edge_m.is_finite() && edge_m > 0.0).then_some(edge_m)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Vector3};

    use super::*;
    use crate::rng::Rng;
    use crate::superquadric::Superquadric;

    #[test]
    fn strays_in_space_go_and_the_surface_stays() {
        let mut rng = Rng::new(61, 0);
        for (axes, e) in [([0.03, 0.05, 0.08], 0.2), ([0.1, 0.1, 0.1], 1.0), ([0.02, 0.2, 0.1], 0.6)] {
            let shape = Superquadric::new(axes[0], axes[1], axes[2], e, e, Isometry3::identity()).unwrap();
            let surface: Vec<_> = shape.samples(60).iter().map(|q| q.p_F).collect();
            let strays: Vec<_> = (0..surface.len() / 4)
                .map(|_| {
                    let p = Vector3::from(axes.map(|a| rng.uniform(-2.0 * a, 2.0 * a)));
                    Point3::from(p)
                })
                .collect();
            assert_eq!(in_company(&surface).len(), surface.len(), "a clean cloud loses nothing");
            let all: Vec<_> = surface.iter().chain(&strays).copied().collect();
            let kept = in_company(&all);
            let far = |p: &&Point3<f64>| shape.radial_distance(p) > 0.02;
            let left = kept.iter().filter(far).count();
            let before = strays.iter().filter(far).count();
            assert!(kept.iter().filter(|p| shape.radial_distance(p) < 1e-6).count() == surface.len());
            assert!(left * 4 < before, "{left} of {before} far strays are left for {axes:?}");
        }
    }
}
