//! Volume of the grasp wrench space (Miller and Allen 1999), by rays.
//!
//! The hull of a grasp's wrenches has tens of thousands of facets in six dimensions. Instead of building it, rays from
//! the origin are followed to where they leave it, each by a small linear programme, and the volume is
//! `det(L) · V₆ · mean ρ⁶` in coordinates in which the wrenches spread evenly: there ρ hardly varies, so that few rays
//! are enough. The directions are the same for every grasp.

use nalgebra::{Matrix6, Point3};

use super::Contact;
use super::quality::{Wrench, wrenches};
use crate::rng::Rng;

/// Rays per grasp; the estimate is then good to some tenth of its value.
const RAYS: usize = 96;
/// Seed of the directions.
const SEED: u64 = 6;
/// Pivots after which a ray is given up; twenty are usual.
const MAX_PIVOTS: usize = 200;
/// Volume of the unit ball in six dimensions, π³/6.
const BALL: f64 = std::f64::consts::PI * std::f64::consts::PI * std::f64::consts::PI / 6.0;
/// What an artificial wrench costs: far more than any way through real ones.
const ARTIFICIAL_COST: f64 = 1e5;
/// Below this gain no wrench is worth a pivot.
const NO_GAIN: f64 = 1e-9;

/// Volume of the convex hull of the unit friction-cone edges in the six dimensions of `[f; τ / size]`; 0 without force
/// closure. Forces and lengths are scaled as in [`epsilon`](super::epsilon).
pub fn volume(contacts: &[Contact], friction: f64, center_O: &Point3<f64>, size_m: f64) -> f64 {
    of_hull(&wrenches(contacts, friction, center_O, size_m))
}

/// Volume of the hull of points around the origin; 0 when the origin is not inside.
fn of_hull(points: &[Wrench]) -> f64 {
    let mut spread = Matrix6::<f64>::zeros();
    for point in points {
        for i in 0..6 {
            for j in 0..6 {
                spread[(i, j)] += point[i] * point[j] / points.len().max(1) as f64;
            }
        }
    }
    let Some(factor) = spread.cholesky() else { return 0.0 };
    let L = factor.l();
    let even: Option<Vec<Wrench>> = points.iter().map(|point| L.solve_lower_triangular(point)).collect();
    let Some(even) = even else { return 0.0 };
    let mut rng = Rng::new(SEED, 0);
    let mut sum = 0.0;
    for _ in 0..RAYS {
        let direction = Wrench::from_fn(|_, _| rng.normal());
        let Some(direction) = direction.try_normalize(1e-9) else { return 0.0 };
        let Some(length) = ray_length(&even, &direction) else { return 0.0 };
        let cube = length * length * length;
        sum += cube * cube;
    }
    L.determinant() * BALL * sum / RAYS as f64
}

/// Where a ray from the origin leaves the hull; `None` when it never enters the cone of the points.
///
/// The least sum of λ ≥ 0 with `Σ λ w = u` is the gauge of u, so the length is its inverse (revised simplex method
/// from artificial columns along the axes).
fn ray_length(points: &[Wrench], u: &Wrench) -> Option<f64> {
    const ARTIFICIAL: usize = usize::MAX;
    let mut basis = [ARTIFICIAL; 6];
    let mut costs = Wrench::repeat(ARTIFICIAL_COST);
    let mut inverse = Matrix6::from_fn(|i, j| if i == j { if u[i] < 0.0 { -1.0 } else { 1.0 } } else { 0.0 });
    for _ in 0..MAX_PIVOTS {
        // Prices: the plane through the basis. A wrench beyond it makes the sum smaller.
        let prices = weighted(&inverse, &costs);
        let mut best = (1.0 + NO_GAIN, None);
        for (index, point) in points.iter().enumerate() {
            let reach = dot(&prices, point);
            if reach > best.0 {
                best = (reach, Some(index));
            }
        }
        let amounts = applied(&inverse, u);
        let Some(entering) = best.1 else {
            let is_real =
                basis.iter().zip(amounts.iter()).all(|(column, amount)| *column != ARTIFICIAL || *amount < 1e-9);
            let sum = dot(&costs, &amounts);
            return (is_real && sum > 0.0).then(|| 1.0 / sum);
        };
        let change = applied(&inverse, &points[entering]);
        let mut leaving: Option<(f64, usize)> = None;
        for row in 0..6 {
            if change[row] > 1e-12 {
                let ratio = amounts[row].max(0.0) / change[row];
                if leaving.is_none_or(|(least, _)| ratio < least) {
                    leaving = Some((ratio, row));
                }
            }
        }
        let (_, row) = leaving?;
        let pivot = inverse.row(row) / change[row];
        for other in 0..6 {
            if other != row {
                for column in 0..6 {
                    inverse[(other, column)] -= change[other] * pivot[column];
                }
            }
        }
        inverse.set_row(row, &pivot);
        basis[row] = entering;
        costs[row] = 1.0;
    }
    None
}

/// `Mᵀ v`, summed in one order on every machine.
fn weighted(matrix: &Matrix6<f64>, v: &Wrench) -> Wrench {
    Wrench::from_fn(|column, _| (0..6).map(|row| matrix[(row, column)] * v[row]).sum())
}

/// `M v`, summed in one order on every machine.
fn applied(matrix: &Matrix6<f64>, v: &Wrench) -> Wrench {
    Wrench::from_fn(|row, _| (0..6).map(|column| matrix[(row, column)] * v[column]).sum())
}

fn dot(a: &Wrench, b: &Wrench) -> f64 {
    (0..6).map(|k| a[k] * b[k]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(k: usize, length: f64) -> Wrench {
        Wrench::from_fn(|i, _| if i == k { length } else { 0.0 })
    }

    #[test]
    fn a_cross_polytope_has_its_volume_in_any_scale() {
        // |x₁|/s₁ + … ≤ 1 has the volume 2⁶/6! · Π s.
        for scales in [[1.0; 6], [1.0, 0.5, 2.0, 0.1, 0.3, 0.7]] {
            let points: Vec<Wrench> = (0..6).flat_map(|k| [axis(k, scales[k]), axis(k, -scales[k])]).collect();
            let truth = 64.0 / 720.0 * scales.iter().product::<f64>();
            let found = of_hull(&points);
            // The corners reach 2.4 times as far as the faces: this is the hardest body for rays.
            assert!((found / truth - 1.0).abs() < 0.35, "{found} against {truth}");
        }
    }

    #[test]
    fn a_cube_has_its_volume_and_inner_points_change_nothing() {
        let corner = |bits: u32| Wrench::from_fn(|i, _| if bits >> i & 1 == 0 { -0.5 } else { 0.5 });
        let mut points: Vec<Wrench> = (0..64).map(corner).collect();
        let found = of_hull(&points);
        assert!((found - 1.0).abs() < 0.25, "{found}");
        let rays = |points: &[Wrench]| ray_length(points, &axis(2, 1.0)).unwrap();
        let before = rays(&points);
        points.push(axis(0, 0.2));
        assert!((rays(&points) - before).abs() < 1e-9 && (before - 0.5).abs() < 1e-9, "{before}");
    }

    #[test]
    fn points_on_one_side_of_the_origin_hold_no_volume() {
        let points: Vec<Wrench> = (0..6).map(|k| axis(k, 1.0)).collect();
        assert_eq!(of_hull(&points), 0.0);
        assert_eq!(of_hull(&[]), 0.0);
    }
}
