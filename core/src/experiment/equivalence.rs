//! When two sets of parameters describe one shape: what an exponent's error is measured against.
//!
//! The exponents of a superquadric are not unique. A box may take any of its axes as z; an octahedron is at the same
//! time the upper limit of both exponents and, turned by 45°, the lower limit of one; a square section with exponent e
//! is nearly the section with 2 - e, turned by 45°. Of these only the limits are exact, so equivalence needs a
//! tolerance, and there is a natural one: the statistic asks for exponents *within 0.1*, and a change of 0.1 moves the
//! surface by a factor of up to `2^0.05` at the corners of the section. Parameters whose surface stays within that
//! factor of the truth's everywhere therefore cannot be told from it by the statistic, and count as the same shape.
//!
//! By this rule the 45° dual of a square section is the same shape for every exponent (it is off by 3.3 % at most), a
//! sphere has no other name than (1, 1), and a cylinder with its axis along x is none of the cylinder's names.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::protocol::ln_gauge;
use crate::math;
use crate::superquadric::{EXPONENT_MAX, EXPONENT_MIN, Superquadric};

/// Largest error of an exponent that counts as found.
pub const EXPONENT_TOLERANCE: f64 = 0.1;
/// Directions along which surfaces are compared: a grid over one eighth of the sphere, and its mirror image in x.
const GRID: usize = 12;

/// The exponents `[e1, e2]` of every parametrisation of the shape, its own first.
///
/// Tried are the three axes as z, each as it is and turned by 45° about z, with the exponents as they are, exchanged,
/// and either or both replaced by their duals `2 - e`; semi-axes are the shape's own radii along the new axes.
///
/// Deformed shapes have no other names than their own.
pub fn equivalent_exponents(shape: &Superquadric) -> Vec<[f64; 2]> {
    let own = [shape.e1, shape.e2];
    let mut names = vec![own];
    if shape.is_deformed() {
        return names;
    }
    let exponents = [
        own,
        [own[1], own[0]],
        [own[0], 2.0 - own[1]],
        [2.0 - own[1], own[0]],
        [2.0 - own[0], own[1]],
        [own[1], 2.0 - own[0]],
        [2.0 - own[0], 2.0 - own[1]],
        [2.0 - own[1], 2.0 - own[0]],
    ];
    for R_SA in frames() {
        let radii = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| radius(shape, &(R_SA * axis)));
        for [e1, e2] in exponents {
            let [e1, e2] = [e1, e2].map(|e| e.max(EXPONENT_MIN).min(EXPONENT_MAX));
            let mut X_FA = shape.X_FS;
            X_FA.rotation = shape.X_FS.rotation * R_SA;
            let other = Superquadric::new(radii[0], radii[1], radii[2], e1, e2, X_FA);
            if other.is_ok_and(|other| !names.contains(&[e1, e2]) && is_same(shape, &other)) {
                names.push([e1, e2]);
            }
        }
    }
    names
}

/// The error of found exponents: the larger of the two differences, to the nearest of the truth's names.
pub fn exponent_error(names: &[[f64; 2]], found: [f64; 2]) -> f64 {
    let errors = names.iter().map(|name| (name[0] - found[0]).abs().max((name[1] - found[1]).abs()));
    errors.fold(f64::INFINITY, f64::min)
}

/// The three axes as z, straight and turned by 45°, as rotations from the new axes to S.
fn frames() -> Vec<UnitQuaternion<f64>> {
    let half = std::f64::consts::FRAC_PI_8;
    let turned = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(math::cos(half), 0.0, 0.0, math::sin(half)));
    let cycle = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let cycle = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(cycle));
    [UnitQuaternion::identity(), cycle, cycle * cycle].into_iter().flat_map(|R| [R, R * turned]).collect()
}

/// Distance from the centre to the surface along a unit direction of S, metres.
fn radius(shape: &Superquadric, direction_S: &Vector3<f64>) -> f64 {
    math::exp(-ln_gauge(shape, &(*direction_S).into()))
}

/// Whether two surfaces about one centre differ by at most the factor that a change of 0.1 of an exponent makes.
fn is_same(shape: &Superquadric, other: &Superquadric) -> bool {
    // 2^(0.1/2) at the corner of a section, and one part in a million for rounding.
    let most = 0.5 * EXPONENT_TOLERANCE * std::f64::consts::LN_2 + 1e-6;
    directions(shape).all(|p_S| {
        let p_F = shape.X_FS * nalgebra::Point3::from(p_S);
        (ln_gauge(shape, &p_S.into()) - ln_gauge(other, &other.to_axes(&p_F))).abs() <= most
    })
}

/// Directions in S that are even in the stretched axes, where flat and long shapes show their corners.
fn directions(shape: &Superquadric) -> impl Iterator<Item = Vector3<f64>> + '_ {
    let angle = |k: usize| std::f64::consts::FRAC_PI_2 * k as f64 / GRID as f64;
    let axes = shape.semi_axes();
    (0..=GRID).flat_map(move |i| {
        let (z, ring) = math::sin_cos(angle(i));
        // Both signs of x: a frame turned by 45° sees its own octants only half.
        (0..=2 * GRID).map(move |j| {
            let (y, x) = math::sin_cos(angle(j));
            axes.component_mul(&Vector3::new(ring * x, ring * y, z))
        })
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    fn names(a: f64, b: f64, c: f64, e1: f64, e2: f64) -> Vec<[f64; 2]> {
        let turn = Isometry3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.4, -1.0, 0.2));
        equivalent_exponents(&Superquadric::new(a, b, c, e1, e2, turn).unwrap())
    }

    fn has(names: &[[f64; 2]], wanted: [f64; 2]) -> bool {
        exponent_error(names, wanted) < 1e-12
    }

    #[test]
    fn balls_boxes_and_tall_ellipsoids_have_one_name() {
        assert_eq!(names(0.1, 0.1, 0.1, 1.0, 1.0), [[1.0, 1.0]]);
        assert_eq!(names(0.05, 0.1, 0.2, 1.0, 1.0), [[1.0, 1.0]]);
        assert_eq!(names(0.05, 0.1, 0.2, 0.1, 0.1), [[0.1, 0.1]]);
    }

    #[test]
    fn square_sections_have_their_dual_and_oblong_ones_do_not() {
        for e2 in [0.1, 0.4, 0.7, 1.3, 1.6, 1.9] {
            assert!(has(&names(0.1, 0.1, 0.2, 0.3, e2), [0.3, 2.0 - e2]), "{e2}");
        }
        assert!(!has(&names(0.1, 0.2, 0.2, 0.3, 0.1), [0.3, 1.9]));
    }

    #[test]
    fn a_lying_cylinder_is_no_name_of_a_standing_one() {
        let cylinder = names(0.1, 0.1, 0.1, 0.1, 1.0);
        assert!(!has(&cylinder, [1.0, 0.1]), "{cylinder:?}");
    }

    #[test]
    fn an_octahedron_is_also_a_square_double_pyramid() {
        let octahedron = names(0.1, 0.1, 0.1, 1.9, 1.9);
        assert!(has(&octahedron, [1.9, 0.1]) && octahedron.len() == 2, "{octahedron:?}");
        assert_eq!(exponent_error(&octahedron, [1.85, 0.16]).max(0.06), 0.06);
    }

    #[test]
    fn shapes_without_a_symmetry_have_one_name() {
        for (a, b, c) in [(0.05, 0.1, 0.2), (0.2, 0.1, 0.05), (0.3, 0.2, 0.1)] {
            for (e1, e2) in [(0.1, 0.7), (0.3, 1.6), (1.8, 0.5), (1.4, 1.9), (0.5, 1.0)] {
                assert_eq!(names(a, b, c, e1, e2), [[e1, e2]], "{a} {b} {c}");
            }
        }
    }
}
