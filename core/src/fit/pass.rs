//! One evaluation of an objective over a cloud, for whoever wants its value or its time.

use nalgebra::Point3;

use super::candidate::{Candidate, DEFORMED, PLAIN};
use super::objective::Objective;
use super::types::ObjectiveKind;
use super::weighted::WeightedPoints;
use crate::superquadric::Superquadric;

/// A cloud laid out for an objective, every point with the same weight.
#[derive(Clone, Debug)]
pub struct ObjectivePass {
    points: WeightedPoints,
    kind: ObjectiveKind,
}

impl ObjectivePass {
    /// Lays out the points, finite and in the frame of the superquadrics to come.
    pub fn new(points: &[Point3<f64>], kind: ObjectiveKind) -> Self {
        let weighted: Vec<(Point3<f64>, f64)> = points.iter().map(|p| (*p, 1.0)).collect();
        Self { points: WeightedPoints::new(&weighted), kind }
    }

    /// Mean square of the residuals, in the objective's own unit squared; 0 for no points.
    ///
    /// Gradient and Gauss–Newton matrix over the 11 unknowns (13 of a deformed shape) are summed in the same pass, as
    /// in every step of a fit, so the time of this call is the time of such a pass.
    pub fn mean_square(&self, superquadric: &Superquadric) -> f64 {
        let s = superquadric;
        let t = s.X_FS.translation.vector;
        let values = [s.a, s.b, s.c, s.e1, s.e2, t.x, t.y, t.z, s.taper, s.bend_per_m];
        let candidate = Candidate { values, R_DS: s.X_FS.rotation };
        let objective = Objective::new(&self.points, self.kind);
        let cost = if s.is_deformed() {
            objective.at::<DEFORMED>(&candidate).cost
        } else {
            objective.at::<PLAIN>(&candidate).cost
        };
        if self.points.total_weight > 0.0 { cost / self.points.total_weight } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    #[test]
    fn every_objective_of_a_larger_sphere_is_as_computed_by_hand() {
        let sphere = Superquadric::new(0.1, 0.1, 0.1, 1.0, 1.0, Isometry3::translation(0.5, 0.0, 0.0)).unwrap();
        let center = sphere.X_FS.translation.vector;
        let grown = |p: Point3<f64>| Point3::from(center + (p.coords - center) * 1.5);
        let cloud: Vec<Point3<f64>> = sphere.samples(20).into_iter().map(|q| grown(q.p_F)).collect();
        // |p| = 0.15, f = 2.25, √(abc) = 0.1^1.5.
        let scale = 0.1 * 0.1_f64.sqrt();
        for (kind, residual) in ObjectiveKind::ALL.into_iter().zip([
            0.15 * (1.0 - 1.0 / 1.5),
            scale * 1.25,
            scale * 0.15 * 1.25,
            0.15 * 0.5,
            0.15 * 1.25,
        ]) {
            let found = ObjectivePass::new(&cloud, kind).mean_square(&sphere);
            assert!((found / (residual * residual) - 1.0).abs() < 1e-9, "{kind:?}: {found}");
            assert_eq!(ObjectivePass::new(&[], kind).mean_square(&sphere), 0.0);
        }
    }
}
