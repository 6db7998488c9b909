//! How well a superquadric explains a cloud: E_r (3.10) and E_g (3.9) in both readings.

use nalgebra::Point3;

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
    let mut sums = [0.0; 3];
    let (gauge, e1) =
        (AxesGauge::new(superquadric.semi_axes().into(), [superquadric.e1, superquadric.e2]), superquadric.e1);
    let X_SF = superquadric.X_FS.inverse().to_matrix();
    for chunk in points.chunks(CHUNK) {
        let mut errors = [[0.0; CHUNK]; 3];
        for (k, p_F) in chunk.iter().enumerate() {
            let p_S = superquadric.to_base(&X_SF.transform_point(p_F));
            let ln_rho = gauge.at([p_S.x, p_S.y, p_S.z]).ln_rho;
            let power = fast_exp(2.0 * ln_rho) - 1.0;
            errors[0][k] = (p_S.coords.norm() * (1.0 - fast_exp(-ln_rho))).abs();
            errors[1][k] = power * power;
            errors[2][k] = (fast_exp(2.0 / e1 * ln_rho) - 1.0).abs();
        }
        for (sum, error) in sums.iter_mut().zip(&errors) {
            *sum += error[..chunk.len()].iter().sum::<f64>();
        }
    }
    let [radial_m, goodness_of_fit, goodness_of_fit_abs] = sums.map(|sum| sum / points.len().max(1) as f64);
    FitErrors { radial_m, goodness_of_fit, goodness_of_fit_abs }
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
