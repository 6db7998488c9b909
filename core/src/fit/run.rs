//! The fit from beginning to end.

use nalgebra::{Isometry3, Point3};

use super::candidate::Candidate;
use super::frame::{principal_axes, working_frame};
use super::levenberg_marquardt::{Limits, Minimum, StopReason, minimise};
use super::metrics::fit_errors;
use super::mirror::{Mirroring, PASS_M, mirror};
use super::objective::{Objective, WeightedPoints};
use super::starts::{Start, Surroundings, bounds, similar, starts};
use super::thin::{every_nth, sorted, voxel_centroids};
use super::types::{Fit, FitInput, FitRefusal, FitSettings, MirrorMode};
use super::view::View;
use crate::parallel;
use crate::segment::Plane;
use crate::watch::Watch;

/// One more point than unknowns.
const MIN_POINTS: usize = 12;
/// Points that spread less than this across their main direction are a line, metres.
const MIN_SPREAD_M: f64 = 0.0005;
/// All starts are tried on at most this many points; the best go on with all.
const COARSE_POINTS: usize = 300;

pub(crate) fn tune(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

/// The cloud as the minimiser sees it.
struct Prepared {
    X_FD: Isometry3<f64>,
    /// Voxel centroids in D with their weights.
    points: Vec<(Point3<f64>, f64)>,
    around: Surroundings,
    /// The table in D, if the object stands on it.
    table: Option<Plane>,
    mirrored_D: Vec<Point3<f64>>,
    mirror_note: String,
}

/// Fits a superquadric to a cluster: mirrored at the camera's evidence, from several starts, coarse to fine.
///
/// The answer does not depend on the order of the points, and turns with the frame F (up to rounding).
///
/// # Errors
/// [`FitRefusal`] says what the cluster lacks: too few points, points on a line, a mirror plane when
/// [`MirrorMode::On`] asks for one; or that the caller stopped it.
pub fn fit(input: FitInput<'_>, settings: &FitSettings, watch: Watch<'_>) -> Result<Fit, FitRefusal> {
    watch.progress(0.0, "mirroring");
    let prepared = prepare(&input, settings)?;
    let (best, lines, iterations) = search(&prepared, settings, watch)?;
    let superquadric = best.candidate.superquadric(&prepared.X_FD);
    let finite: Vec<Point3<f64>> = finite_points(input.points);
    let errors = fit_errors(&superquadric, &finite);
    watch.progress(1.0, "fitted");
    Ok(Fit {
        superquadric,
        radial_m: errors.radial_m,
        goodness_of_fit: errors.goodness_of_fit,
        goodness_of_fit_abs: errors.goodness_of_fit_abs,
        volume_m3: superquadric.volume(),
        iterations,
        points: input.points.len(),
        used_points: prepared.points.len(),
        mirrored: prepared.mirrored_D.iter().map(|p| prepared.X_FD * p).collect(),
        mirror_note: prepared.mirror_note,
        starts: lines,
    })
}

fn finite_points(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    points.iter().filter(|p| p.iter().all(|x| x.is_finite())).copied().collect()
}

fn prepare(input: &FitInput<'_>, settings: &FitSettings) -> Result<Prepared, FitRefusal> {
    if !(settings.voxel_m.is_finite() && settings.voxel_m >= 0.0) {
        return Err(FitRefusal::Setting { name: "voxel_m", found: settings.voxel_m, wanted: "0 or a length in metres" });
    }
    let points_F = sorted(finite_points(input.points));
    if points_F.len() < MIN_POINTS {
        return Err(FitRefusal::TooFewPoints { found: points_F.len(), wanted: MIN_POINTS });
    }
    let deviations = principal_axes(&points_F).1;
    if deviations[1] < MIN_SPREAD_M {
        return Err(FitRefusal::Degenerate { found_m: deviations[1], wanted_m: MIN_SPREAD_M });
    }
    let X_FD = working_frame(&points_F, input.X_FC.as_ref(), input.table.as_ref());
    let seen: Vec<Point3<f64>> = points_F.iter().map(|p| X_FD.inverse_transform_point(p)).collect();

    // In D the table is the plane z = 0.
    let table = input
        .table
        .filter(|_| stands_on_table(&seen))
        .map(|_| Plane { normal: nalgebra::Vector3::z_axis(), offset_m: 0.0 });
    let (mirroring, mirror_note) = mirrored(input, settings, &seen, &X_FD)?;
    let mirrored_D = mirroring.as_ref().map(|m| m.added.clone()).unwrap_or_default();
    let around = Surroundings {
        mirror_normal: mirroring.as_ref().map(|m| m.first.normal),
        on_table: table.is_some(),
        complete: table.is_some() && mirroring.as_ref().is_some_and(|m| m.second.is_some()),
    };
    let points = thinned(&seen, &mirrored_D, settings.voxel_m);
    Ok(Prepared { X_FD, points, around, table, mirrored_D, mirror_note })
}

/// Whether a cluster on z ≥ 0 reaches down to z = 0, as far as one can tell from a view that hides its underside.
fn stands_on_table(points: &[Point3<f64>]) -> bool {
    let (low, high) =
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
    // Segmentation drops the lowest centimetre; a ball shows its outline from a quarter of its height upwards.
    low < 0.03_f64.max(0.3 * high)
}

/// Voxel centroids of what was seen and of its mirror image, seen voxels first.
fn thinned(seen: &[Point3<f64>], mirrored: &[Point3<f64>], voxel_m: f64) -> Vec<(Point3<f64>, f64)> {
    let mut edge_m = voxel_m;
    // A small object would be left with fewer points than unknowns: halve the edge until it is not.
    let mut own = voxel_centroids(seen, edge_m);
    while own.len() < (tune("MINVOX", 100.0) as usize).min(seen.len()) && edge_m > 1e-4 {
        edge_m *= tune("VOXSHRINK", 0.7);
        own = voxel_centroids(seen, edge_m);
    }
    let w = tune("WMIRROR", 1.0);
    let mut points: Vec<(Point3<f64>, f64)> = own.into_iter().map(|(p, _)| (p, 1.0)).collect();
    if w > 0.0 {
        points.extend(voxel_centroids(mirrored, edge_m).into_iter().map(|(p, _)| (p, w)));
    }
    points
}

/// Mirrors the cloud when the settings and the input allow it; the sentence says what became of it.
fn mirrored(
    input: &FitInput<'_>,
    settings: &FitSettings,
    seen: &[Point3<f64>],
    X_FD: &Isometry3<f64>,
) -> Result<(Option<Mirroring>, String), FitRefusal> {
    let asked = settings.mirror == MirrorMode::On;
    if settings.mirror == MirrorMode::Off {
        return Ok((None, "mirroring is off".into()));
    }
    let missing = match (&input.X_FC, &input.table) {
        (None, _) => Some("camera"),
        (_, None) => Some("table"),
        _ => None,
    };
    if let Some(missing) = missing {
        if asked {
            return Err(FitRefusal::MirrorNeeds { missing });
        }
        return Ok((None, format!("not mirrored: the {missing} is not known")));
    }
    let view = input.X_FC.and_then(|X_FC| View::new(seen, &(X_FD.inverse() * X_FC)));
    let Some(mirroring) = view.and_then(|view| mirror(seen, &view)) else {
        if asked {
            return Err(FitRefusal::MirrorNeeds { missing: "side the camera is on: it does not look at the cluster" });
        }
        return Ok((None, "not mirrored: the camera does not look at the cluster".into()));
    };
    let best_mm = mirroring.first.cost_m * 1e3;
    if mirroring.first.cost_m > PASS_M {
        if asked {
            return Err(FitRefusal::NoMirrorPlane { best_m: mirroring.first.cost_m, wanted_m: PASS_M });
        }
        let limit_mm = PASS_M * 1e3;
        return Ok((None, format!("not mirrored: the best plane is impossible by {best_mm:.1} mm, at most {limit_mm:.1} mm pass")));
    }
    let count = mirroring.added.len();
    let note = match &mirroring.second {
        Some(second) => format!(
            "mirrored at two planes (impossible by {best_mm:.1} and {:.1} mm), {count} points added",
            second.cost_m * 1e3
        ),
        None => format!("mirrored at one plane (impossible by {best_mm:.1} mm), {count} points added"),
    };
    Ok((Some(mirroring), note))
}

/// All starts briefly on few points, the best of them and their look-alikes further, the winner on all points.
fn search(
    prepared: &Prepared,
    settings: &FitSettings,
    watch: Watch<'_>,
) -> Result<(Minimum, Vec<String>, u32), FitRefusal> {
    let positions: Vec<Point3<f64>> = prepared.points.iter().map(|(p, _)| *p).collect();
    let coarse = WeightedPoints::new(&every_nth(&prepared.points, COARSE_POINTS));
    let all = WeightedPoints::new(&prepared.points);
    let table = prepared.table.map(|plane| (plane, tune("WTABLE", 0.3)));
    let coarse_objective = Objective::new(&coarse, table);
    let objective = Objective::new(&all, table);
    let exps: Vec<f64> = if tune("E2", 0.0) > 0.0 { vec![tune("E1", 1.0), tune("E2", 0.0)] } else { vec![tune("E1", 1.0)] };
    let brief = Limits { max_iterations: settings.max_iterations.min(tune("BRIEF", 12.0) as u32), relative_reduction: 1e-4 };
    let longer = Limits { max_iterations: settings.max_iterations, relative_reduction: 1e-5 };
    let last = Limits { max_iterations: settings.max_iterations, relative_reduction: 1e-7 };
    let run = |objective: &Objective<'_>, from: &Candidate, limits: &Limits| {
        minimise(objective, from, &bounds(&positions, &prepared.around, from), limits, watch)
    };

    watch.progress(0.2, "trying starts");
    let all_starts = starts(&positions, &prepared.around, &exps);
    let mut tried: Vec<(Start, Minimum)> = parallel::map(&all_starts, |start| run(&coarse_objective, &start.candidate, &brief))
        .into_iter()
        .zip(&all_starts)
        .map(|(found, start)| (start.clone(), found))
        .collect();
    let mut iterations: u32 = tried.iter().map(|(_, found)| found.iterations).sum();
    let mut lines: Vec<String> = tried.iter().map(|(start, found)| line(&start.name, found, &coarse_objective)).collect();
    tried.sort_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
    tried.truncate(tune("KEEP", 3.0) as usize);

    watch.progress(0.5, "refining the best");
    let refined = parallel::map(&tried, |(_, found)| run(&coarse_objective, &found.candidate, &longer));
    iterations += refined.iter().map(|found| found.iterations).sum::<u32>();
    let Some(mut best) = refined.into_iter().min_by(|p, q| p.cost.total_cmp(&q.cost)) else {
        return Err(FitRefusal::Stopped);
    };
    let tol = tune("SIMTOL", 1.0);
    for _ in 0..2 {
        let twins = similar(&best.candidate);
        let found = parallel::map(&twins, |(_, twin)| run(&coarse_objective, twin, &longer));
        iterations += found.iter().map(|found| found.iterations).sum::<u32>();
        let better = twins.iter().zip(found).min_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
        match better {
            Some(((name, _), found)) if found.cost < tol * best.cost => {
                lines.push(line(&format!("look-alike, {name}"), &found, &coarse_objective));
                best = found;
            }
            _ => break,
        }
    }

    watch.progress(0.8, "fitting all points");
    let mut finest = run(&objective, &best.candidate, &last);
    iterations += finest.iterations;
    if finest.stop == StopReason::Stopped {
        return Err(FitRefusal::Stopped);
    }
    lines.push(line("best on all points", &finest, &objective));
    finest.iterations = iterations;
    Ok((finest, lines, iterations))
}

/// One line of the history: name, root mean square of the residuals, why it stopped.
fn line(name: &str, found: &Minimum, objective: &Objective<'_>) -> String {
    let rms_mm = (found.cost / objective.total_weight().max(1e-300)).sqrt() * 1e3;
    format!("{name}: {rms_mm:.2} mm rms after {} iterations, {}", found.iterations, found.stop)
}
