//! How well a superquadric explains a cloud: E_r (3.10) and E_g (3.9) in both readings.

use nalgebra::Point3;

use crate::simd::{Kernel, widest};
use crate::superquadric::{AxesGauge, Superquadric, fast_exp};

/// Points handled side by side.
const CHUNK: usize = 16;

/// Errors of a superquadric on a cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitErrors {
    /// E_r (3.10): mean radial distance `|p_S| |1 - f^(-e1/2)|`, metres.
    pub radial_m: f64,
    /// E_g as printed in (3.9): mean `(f^e1 - 1)²`.
    pub goodness_of_fit: f64,
    /// E_g as the thesis's tables use it: mean `|f - 1|`.
    pub goodness_of_fit_abs: f64,
}

/// The errors of `superquadric` on points of its frame F; zero for no points.
///
/// For a tapered or bent shape they are measured before the deformation, as its author does.
pub fn fit_errors(superquadric: &Superquadric, points: &[Point3<f64>]) -> FitErrors {
    let sums = if superquadric.is_deformed() {
        widest(ErrorSums::<true> { superquadric, points })
    } else {
        widest(ErrorSums::<false> { superquadric, points })
    };
    let [radial_m, goodness_of_fit, goodness_of_fit_abs] = sums.map(|sum| sum / points.len().max(1) as f64);
    FitErrors { radial_m, goodness_of_fit, goodness_of_fit_abs }
}

/// Sums over the points of the three errors.
struct ErrorSums<'a, const DEFORMED: bool> {
    superquadric: &'a Superquadric,
    points: &'a [Point3<f64>],
}

impl<const DEFORMED: bool> Kernel for ErrorSums<'_, DEFORMED> {
    type Output = [f64; 3];

    #[inline(always)]
    fn run(self) -> [f64; 3] {
        let shape = self.superquadric;
        let gauge = AxesGauge::new(shape.semi_axes().into(), [shape.e1, shape.e2]);
        let per_rho = 2.0 / shape.e1;
        let R = *shape.X_FS.rotation.to_rotation_matrix().matrix();
        let t = shape.X_FS.translation.vector;
        let mut sums = [0.0; 3];
        for chunk in self.points.chunks(CHUNK) {
            let mut errors = [[0.0; CHUNK]; 3];
            for (k, p_F) in chunk.iter().enumerate() {
                let v = p_F.coords - t;
                let mut p = [0, 1, 2].map(|j| R[(0, j)] * v.x + R[(1, j)] * v.y + R[(2, j)] * v.z);
                if DEFORMED {
                    p = shape.to_base(&Point3::from(p)).coords.into();
                }
                let ln_rho = gauge.at(p).ln_rho;
                let power = fast_exp(2.0 * ln_rho) - 1.0;
                let radius = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
                errors[0][k] = (radius * (1.0 - fast_exp(-ln_rho))).abs();
                errors[1][k] = power * power;
                errors[2][k] = (fast_exp(per_rho * ln_rho) - 1.0).abs();
            }
            for (sum, error) in sums.iter_mut().zip(&errors) {
                *sum += error[..chunk.len()].iter().sum::<f64>();
            }
        }
        sums
    }
}

/// The errors of several superquadrics on points of their frame F, every point against the nearest of them, and for each
/// superquadric how many points are nearest to it with their mean radial distance, metres.
pub fn fit_errors_of_parts(parts: &[Superquadric], points: &[Point3<f64>]) -> (FitErrors, Vec<(usize, f64)>) {
    if let [part] = parts {
        let errors = fit_errors(part, points);
        return (errors, vec![(points.len(), errors.radial_m)]);
    }
    let mut owned: Vec<Vec<Point3<f64>>> = vec![Vec::new(); parts.len()];
    for p in points {
        let distance = |part: &usize| parts[*part].radial_distance(p);
        if let Some(nearest) = (0..parts.len()).min_by(|i, j| distance(i).total_cmp(&distance(j))) {
            owned[nearest].push(*p);
        }
    }
    let each: Vec<FitErrors> = parts.iter().zip(&owned).map(|(part, own)| fit_errors(part, own)).collect();
    let mean = |error: fn(&FitErrors) -> f64| {
        let sum: f64 = each.iter().zip(&owned).map(|(errors, own)| error(errors) * own.len() as f64).sum();
        sum / points.len().max(1) as f64
    };
    let errors = FitErrors {
        radial_m: mean(|e| e.radial_m),
        goodness_of_fit: mean(|e| e.goodness_of_fit),
        goodness_of_fit_abs: mean(|e| e.goodness_of_fit_abs),
    };
    (errors, each.iter().zip(&owned).map(|(errors, own)| (own.len(), errors.radial_m)).collect())
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    #[test]
    fn errors_of_a_larger_sphere_are_as_computed_by_hand() {
        let sphere = Superquadric::new(0.1, 0.1, 0.1, 1.0, 1.0, Isometry3::translation(0.5, 0.0, 0.0)).unwrap();
        let center = sphere.X_FS.translation.vector;
        let grown = |p: Point3<f64>| Point3::from(center + (p.coords - center) * 1.5);
        let cloud: Vec<Point3<f64>> = sphere.samples(20).into_iter().map(|q| grown(q.p_F)).collect();
        let errors = fit_errors(&sphere, &cloud);
        // |p| = 0.15: f = 2.25, f^e1 - 1 = 1.25.
        assert!((errors.radial_m - 0.05).abs() < 1e-12);
        assert!((errors.goodness_of_fit - 1.5625).abs() < 1e-12);
        assert!((errors.goodness_of_fit_abs - 1.25).abs() < 1e-12);
        assert_eq!(fit_errors(&sphere, &[]).radial_m, 0.0);
    }
}
