//! The fits: parameters, errors, how they were found.

use endcomfort_core::experiment::Cell;
use endcomfort_core::fit::{Fit, ModelReport, RunReport};
use endcomfort_core::job::{FitOutput, ObjectiveFit, SegmentOutput};

use super::Row;

/// The clusters that have a fit.
fn found(output: &FitOutput) -> impl Iterator<Item = (usize, &Fit)> {
    output.fits.iter().enumerate().filter_map(|(cluster, fit)| Some((cluster, fit.as_ref().ok()?)))
}

/// Every cluster with its fit, or with why there is none.
pub(super) fn fits(output: &FitOutput) -> Vec<Row> {
    let row = |(cluster, fit): (usize, &Result<Fit, String>)| {
        let reason = fit.as_ref().err().cloned();
        let mut cells: Vec<(&'static str, Cell)> =
            vec![("cluster", cluster.into()), ("is_target", (cluster == output.target).into())];
        cells.extend(parameters(fit.as_ref().ok()));
        cells.push(("refused", reason.into()));
        Row(cells)
    };
    output.fits.iter().enumerate().map(row).collect()
}

/// Shape, pose and errors; every cell is there, also without a fit.
fn parameters(fit: Option<&Fit>) -> Vec<(&'static str, Cell)> {
    let number = |of: fn(&Fit) -> f64| Cell::from(fit.map(of));
    let count = |of: fn(&Fit) -> usize| Cell::from(fit.map(of));
    let mut cells = vec![
        ("a_m", number(|fit| fit.superquadric.a)),
        ("b_m", number(|fit| fit.superquadric.b)),
        ("c_m", number(|fit| fit.superquadric.c)),
        ("e1", number(|fit| fit.superquadric.e1)),
        ("e2", number(|fit| fit.superquadric.e2)),
        ("taper", number(|fit| fit.superquadric.taper)),
        ("bend_per_m", number(|fit| fit.superquadric.bend_per_m)),
        ("x_m", number(|fit| fit.superquadric.X_FS.translation.x)),
        ("y_m", number(|fit| fit.superquadric.X_FS.translation.y)),
        ("z_m", number(|fit| fit.superquadric.X_FS.translation.z)),
        ("qx", number(|fit| fit.superquadric.X_FS.rotation.i)),
        ("qy", number(|fit| fit.superquadric.X_FS.rotation.j)),
        ("qz", number(|fit| fit.superquadric.X_FS.rotation.k)),
        ("qw", number(|fit| fit.superquadric.X_FS.rotation.w)),
    ];
    cells.extend(errors(fit));
    cells.extend([
        ("points", count(|fit| fit.points)),
        ("used_points", count(|fit| fit.used_points)),
        ("mirrored_points", count(|fit| fit.mirrored.len())),
        ("rejected_points", count(|fit| fit.rejected.len())),
        ("parts", count(|fit| fit.bodies().count())),
        ("runs", count(|fit| fit.runs.len())),
        ("iterations", count(|fit| fit.iterations as usize)),
    ]);
    cells
}

fn errors(fit: Option<&Fit>) -> [(&'static str, Cell); 4] {
    [
        ("radial_m", fit.map(|fit| fit.radial_m).into()),
        ("goodness_of_fit", fit.map(|fit| fit.goodness_of_fit).into()),
        ("goodness_of_fit_abs", fit.map(|fit| fit.goodness_of_fit_abs).into()),
        ("volume_m3", fit.map(|fit| fit.volume_m3).into()),
    ]
}

/// Every run of every fit; the cost is in metres for the radial objective and Chevalier's.
pub(super) fn runs(output: &FitOutput) -> Vec<Row> {
    let row = |cluster: usize, (number, run): (usize, &RunReport)| {
        Row(vec![
            ("cluster", cluster.into()),
            ("run", number.into()),
            ("name", run.name.clone().into()),
            ("points", run.points.into()),
            ("steps", run.rms.len().saturating_sub(1).into()),
            ("evaluations", (run.iterations as usize).into()),
            ("rms_first", run.rms.first().copied().into()),
            ("rms_last", run.rms.last().copied().into()),
            ("stop", run.stop.to_string().into()),
        ])
    };
    found(output).flat_map(|(cluster, fit)| fit.runs.iter().enumerate().map(move |run| row(cluster, run))).collect()
}

/// Every model that was compared.
pub(super) fn models(output: &FitOutput) -> Vec<Row> {
    let row = |cluster: usize, model: &ModelReport| {
        Row(vec![
            ("cluster", cluster.into()),
            ("model", model.name.clone().into()),
            ("bic", model.criterion.into()),
            ("rms_m", model.rms_m.into()),
            ("is_chosen", model.is_chosen.into()),
        ])
    };
    found(output).flat_map(|(cluster, fit)| fit.models.iter().map(move |model| row(cluster, model))).collect()
}

/// Every objective with what it makes of the cluster.
pub(super) fn objectives(compared: &[(f64, ObjectiveFit)]) -> Vec<Row> {
    let row = |(elapsed_ms, compared): &(f64, ObjectiveFit)| {
        let fit = compared.fit.as_ref().ok();
        let mut cells: Vec<(&'static str, Cell)> =
            vec![("cluster", compared.cluster.into()), ("objective", compared.objective.name().into())];
        cells.extend(errors(fit));
        cells.push(("iterations", fit.map(|fit| fit.iterations as usize).into()));
        cells.push(("time_s", (elapsed_ms / 1e3).into()));
        cells.push(("refused", compared.fit.as_ref().err().cloned().into()));
        Row(cells)
    };
    compared.iter().map(row).collect()
}

/// Every point of every cluster with its signed radial distance from the fit; outside is positive.
pub(super) fn residuals(segment: &SegmentOutput, output: &FitOutput) -> Vec<Row> {
    let clusters = segment.clusters.iter().zip(&output.distances_m).enumerate();
    // A cluster without a fit has no distances.
    let clusters = clusters.filter(|(_, (points, distances_m))| points.len() == distances_m.len());
    let of_cluster = |(cluster, (points, distances_m)): (usize, (&Vec<nalgebra::Point3<f64>>, &Vec<f64>))| {
        let row = |(p, distance_m): (&nalgebra::Point3<f64>, &f64)| {
            Row(vec![
                ("cluster", cluster.into()),
                ("x_m", p.x.into()),
                ("y_m", p.y.into()),
                ("z_m", p.z.into()),
                ("distance_m", (*distance_m).into()),
            ])
        };
        points.iter().zip(distances_m).map(row).collect::<Vec<Row>>()
    };
    clusters.flat_map(of_cluster).collect()
}
