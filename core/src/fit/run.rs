//! The fit from beginning to end.

use nalgebra::Point3;

use super::candidate::Candidate;
use super::composite::split;
use super::contradiction::{contradiction_m, is_better, is_too_much};
use super::metrics::{fit_errors, fit_errors_of_parts};
use super::models::{Model, best_model};
use super::objective::Residual;
use super::prepare::{LEVELS_M, Prepared, finite_points, prepare, thinned};
use super::search::Search;
use super::strays;
use super::types::{Fit, FitInput, FitRefusal, FitSettings, ModelReport, Part, RejectedPoint, RunReport};
use super::weighted::WeightedPoints;
use crate::superquadric::Superquadric;
use crate::watch::Watch;

/// A level must lower the radial error by this share, or it is the last.
const LEVEL_GAIN: f64 = 0.02;

/// Fits a superquadric to a cluster: mirrored at the camera's evidence, from several starts, coarse to fine.
///
/// The answer does not depend on the order of the points, and turns with the frame F (up to rounding).
///
/// # Errors
/// [`FitRefusal`] says what the cluster lacks: too few points, points on a line, a mirror plane when
/// [`MirrorMode::On`](super::MirrorMode::On) asks for one; or that the caller stopped it.
pub fn fit(input: FitInput<'_>, settings: &FitSettings, watch: Watch<'_>) -> Result<Fit, FitRefusal> {
    watch.progress(0.0, "mirroring");
    let mut prepared = prepare(&input, settings)?;
    watch.progress(0.2, "trying starts");
    let mut coarse = coarse_search(&prepared, settings, watch)?;
    if settings.reject_outliers && coarse.is_spoiled && prepared.keep_company(settings) {
        let again = coarse_search(&prepared, settings, watch)?;
        coarse = Coarse { runs: [coarse.runs, again.runs].concat(), ..again };
    }
    let mut found = fit_from(&prepared, coarse, settings, watch)?;
    if let Some(inside) = within_view(&mut prepared, &found, settings, watch)? {
        found = Found { runs: [found.runs, inside.runs].concat(), ..inside };
    }
    let mut parts = vec![found.candidate];
    if settings.max_parts > 1 {
        watch.progress(0.85, "looking for parts");
        let mut composite = split(&prepared, found.candidate, settings, watch)?;
        found.models.append(&mut composite.models);
        found.runs.append(&mut composite.runs);
        parts = composite.parts;
    }
    watch.progress(1.0, "fitted");
    Ok(answer(&input, &prepared, settings, found, &parts))
}

/// The result with its errors, in the frame of the input; the largest part first.
fn answer(input: &FitInput<'_>, prepared: &Prepared, settings: &FitSettings, found: Found, parts: &[Candidate]) -> Fit {
    let mut bodies: Vec<Superquadric> = parts.iter().map(|part| part.superquadric(&prepared.X_FD)).collect();
    bodies.sort_by(|p, q| q.volume().total_cmp(&p.volume()));
    let finite: Vec<Point3<f64>> = finite_points(input.points);
    let (errors, owned) = fit_errors_of_parts(&bodies, &finite);
    let others = bodies.iter().zip(&owned).skip(1).map(|(superquadric, (points, radial_m))| Part {
        superquadric: *superquadric,
        points: *points,
        radial_m: *radial_m,
    });
    Fit {
        superquadric: bodies[0],
        radial_m: errors.radial_m,
        goodness_of_fit: errors.goodness_of_fit,
        goodness_of_fit_abs: errors.goodness_of_fit_abs,
        volume_m3: bodies.iter().map(Superquadric::volume).sum(),
        iterations: found.runs.iter().map(|run| run.iterations).sum(),
        points: input.points.len(),
        used_points: found.used_points,
        mirrored: prepared.mirrored_D.iter().map(|p| prepared.X_FD * p).collect(),
        mirror_note: prepared.mirror_note.clone(),
        rejected: if settings.reject_outliers { rejected(prepared, parts) } else { Vec::new() },
        others: others.collect(),
        runs: found.runs,
        models: found.models,
    }
}

/// What a search gave.
struct Found {
    candidate: Candidate,
    model: Model,
    runs: Vec<RunReport>,
    models: Vec<ModelReport>,
    used_points: usize,
}

/// A plain shape on few points.
struct Coarse {
    candidate: Candidate,
    /// Whether so many points are far from it that strays may have led the search astray.
    is_spoiled: bool,
    runs: Vec<RunReport>,
}

fn coarse_search(prepared: &Prepared, settings: &FitSettings, watch: Watch<'_>) -> Result<Coarse, FitRefusal> {
    let mut search = Search::new(prepared, &prepared.points, settings, watch);
    let candidate = search.coarse_best()?;
    let is_spoiled = strays::are_suspected(&search.residuals(&search.coarse, &candidate));
    Ok(Coarse { candidate, is_spoiled, runs: search.runs })
}

/// The fit from a coarse shape, at one voxel size or level by level.
fn fit_from(
    prepared: &Prepared,
    coarse: Coarse,
    settings: &FitSettings,
    watch: Watch<'_>,
) -> Result<Found, FitRefusal> {
    let whole = if settings.hierarchical { fit_levels } else { fit_once };
    whole(prepared, coarse, settings, watch)
}

/// A fit within the extents of what was seen, when the present one contradicts the camera and that one does less; with
/// robust weights and, if need be, without.
fn within_view(
    prepared: &mut Prepared,
    present: &Found,
    settings: &FitSettings,
    watch: Watch<'_>,
) -> Result<Option<Found>, FitRefusal> {
    let score = |prepared: &Prepared, candidate: &Candidate| {
        let contradiction_m = prepared.view.as_ref().map(|view| contradiction_m(prepared, view, candidate))?;
        let shape = candidate.superquadric(&nalgebra::Isometry3::identity());
        Some((contradiction_m, fit_errors(&shape, &prepared.seen).radial_m))
    };
    let Some(first) = score(prepared, &present.candidate).filter(|(by_m, _)| is_too_much(*by_m)) else {
        return Ok(None);
    };
    let was_complete = std::mem::replace(&mut prepared.around.complete, true);
    let weightings = if settings.reject_outliers { &[true, false][..] } else { &[false] };
    for &reject_outliers in weightings {
        let settings = FitSettings { reject_outliers, ..settings.clone() };
        let coarse = coarse_search(prepared, &settings, watch)?;
        let other = fit_from(prepared, coarse, &settings, watch)?;
        if score(prepared, &other.candidate).is_some_and(|other| is_better(other, first)) {
            return Ok(Some(other));
        }
    }
    prepared.around.complete = was_complete;
    Ok(None)
}

/// The fit at one voxel size: the deformation that pays, then all points.
fn fit_once(
    prepared: &Prepared,
    coarse: Coarse,
    settings: &FitSettings,
    watch: Watch<'_>,
) -> Result<Found, FitRefusal> {
    let mut search = Search::new(prepared, &prepared.points, settings, watch);
    search.runs = coarse.runs;
    let (model, candidate, models) = best_model(&mut search, coarse.candidate, settings.deform)?;
    watch.progress(0.8, "fitting all points");
    let candidate = search.fine(candidate, model, "best on all points")?;
    Ok(Found { candidate, model, used_points: search.points.len(), runs: search.runs, models })
}

/// Coarse to fine (Duncan et al. 2013): voxels of 0.03 to 0.005 m, each level from the last one's shape, until the
/// radial error of the whole cloud stops falling.
fn fit_levels(
    prepared: &Prepared,
    coarse: Coarse,
    settings: &FitSettings,
    watch: Watch<'_>,
) -> Result<Found, FitRefusal> {
    let radial_of = |candidate: &Candidate| {
        let shape = candidate.superquadric(&nalgebra::Isometry3::identity());
        fit_errors(&shape, &prepared.seen).radial_m
    };
    let mut found = fit_once(prepared, coarse, settings, watch)?;
    let mut radial_m = radial_of(&found.candidate);
    for (level, voxel_m) in LEVELS_M.iter().enumerate().skip(1) {
        watch.progress(0.3 + 0.12 * level as f64, "refining the voxels");
        let points = thinned(&prepared.seen, &prepared.mirrored_D, *voxel_m);
        let mut search = Search::new(prepared, &points, settings, watch);
        let name = format!("level {} of {}, voxels of {:.1} mm", level + 1, LEVELS_M.len(), voxel_m * 1e3);
        let candidate = search.fine(found.candidate, found.model, &name)?;
        found.runs.append(&mut search.runs);
        let next_m = radial_of(&candidate);
        let is_better = next_m < radial_m;
        if is_better {
            found.candidate = candidate;
            found.used_points = points.len();
        }
        if radial_m - next_m < LEVEL_GAIN * radial_m {
            break;
        }
        radial_m = next_m;
    }
    Ok(found)
}

/// The points of the input that are too far from every part to belong to the object, in F.
fn rejected(prepared: &Prepared, parts: &[Candidate]) -> Vec<RejectedPoint> {
    let in_D = |p_F: &Point3<f64>| (prepared.X_FD.inverse_transform_point(p_F), 1.0);
    let seen = WeightedPoints::new(&prepared.points_F.iter().map(in_D).collect::<Vec<_>>());
    let by_part: Vec<Vec<Residual>> = parts.iter().map(|part| seen.residuals(part)).collect();
    let nearest: Vec<Residual> = (0..prepared.points_F.len())
        .filter_map(|k| {
            let distances = by_part.iter().map(|residuals| residuals[k]);
            distances.min_by(|p, q| p.normal_m.abs().total_cmp(&q.normal_m.abs()))
        })
        .collect();
    let limit_m = strays::limit_m(&nearest);
    let far = prepared.points_F.iter().zip(&nearest).filter(|(_, residual)| residual.normal_m.abs() > limit_m);
    far.map(|(p_F, residual)| RejectedPoint { p_F: *p_F, distance_m: residual.normal_m, limit_m }).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3, Unit, Vector3};

    use super::*;
    use crate::fit::candidate::PLAIN;
    use crate::fit::levenberg_marquardt::{Limits, minimise};
    use crate::fit::objective::Objective;
    use crate::fit::starts::{Surroundings, bounds, starts};
    use crate::fit::test_scenes::{Scene, standing, table};
    use crate::fit::types::MirrorMode;
    use crate::fit::types::ObjectiveKind;
    use crate::rng::Rng;
    use crate::segment::Plane;

    fn fit_view(scene: &Scene) -> Fit {
        let input = FitInput { points: &scene.seen, X_FC: Some(scene.X_DC), table: Some(table()) };
        fit(input, &FitSettings::default(), Watch::idle()).unwrap()
    }

    fn cloud_only(points: &[Point3<f64>]) -> FitInput<'_> {
        FitInput { points, X_FC: None, table: None }
    }

    #[test]
    fn one_view_of_standing_objects_gives_their_size_and_place() {
        for (name, axes, e) in [
            ("box", [0.03, 0.05, 0.08], [0.1, 0.1]),
            ("can", [0.04, 0.04, 0.06], [0.1, 1.0]),
            ("ball", [0.04, 0.04, 0.04], [1.0, 1.0]),
            ("lemon", [0.03, 0.04, 0.025], [1.0, 1.0]),
        ] {
            for yaw_rad in [0.2, 0.7] {
                let scene = standing(axes, e, yaw_rad);
                let fit = fit_view(&scene);
                let volume = fit.volume_m3 / scene.truth.volume();
                // Voxels of 15 mm round the edges, and the outline is known to a pixel of about 3 mm.
                assert!((volume - 1.0).abs() < 0.12, "{name} {yaw_rad}: volume {volume} {fit:?}");
                let off = fit.superquadric.X_FS.translation.vector - scene.truth.X_FS.translation.vector;
                assert!(off.norm() < 0.004, "{name} {yaw_rad}: centre {off:?}");
                let whole: Vec<Point3<f64>> = scene.truth.samples_spaced(0.004).iter().map(|q| q.p_F).collect();
                let radial_m = fit_errors(&fit.superquadric, &whole).radial_m;
                assert!(radial_m < 0.002, "{name} {yaw_rad}: {radial_m}");
                let lowest = fit.superquadric.X_FS.translation.z - fit.superquadric.support(&Vector3::z());
                assert!(lowest.abs() < 0.001, "{name} {yaw_rad}: stands {lowest} m above the table");
                assert!(fit.mirror_note.starts_with("mirrored at two planes"), "{}", fit.mirror_note);
            }
        }
    }

    #[test]
    fn whole_clouds_give_the_shape_back() {
        let mut rng = Rng::new(51, 0);
        for _ in 0..12 {
            let axes = [0.0; 3].map(|_: f64| rng.uniform(0.025, 0.2));
            let (e1, e2) = (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9));
            let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
            let truth = Superquadric::new(axes[0], axes[1], axes[2], e1, e2, X_FS).unwrap();
            let points: Vec<Point3<f64>> = truth.samples_spaced(0.005).iter().map(|q| q.p_F).collect();
            let found = fit(cloud_only(&points), &FitSettings::default(), Watch::idle()).unwrap();
            // The thinned cloud itself is off by a few tenths of a millimetre where voxels cut edges.
            assert!(found.radial_m < 0.001, "{} {truth:?} {:?}", found.radial_m, found.superquadric);
            assert!((found.volume_m3 / truth.volume() - 1.0).abs() < 0.03, "{truth:?}");
        }
    }

    #[test]
    fn the_order_of_the_points_does_not_matter_at_all() {
        let mut scene = standing([0.03, 0.05, 0.08], [0.1, 0.1], 0.4);
        let first = fit_view(&scene);
        let mut rng = Rng::new(52, 0);
        for k in (1..scene.seen.len()).rev() {
            scene.seen.swap(k, rng.index(k + 1));
        }
        let second = fit_view(&scene);
        assert_eq!(first.superquadric, second.superquadric);
        assert_eq!(first.runs, second.runs);
    }

    #[test]
    fn a_moved_scene_gives_the_moved_fit() {
        let scene = standing([0.03, 0.05, 0.08], [0.1, 0.3], 0.4);
        let fixed = fit_view(&scene);
        let mut rng = Rng::new(53, 0);
        for _ in 0..4 {
            let X_GF = Isometry3::from_parts(Translation3::from(rng.direction() * 2.0), rng.rotation());
            let points: Vec<Point3<f64>> = scene.seen.iter().map(|p| X_GF * p).collect();
            let normal = Unit::try_new(X_GF * Vector3::z(), 1e-9).unwrap();
            let plane = Plane { normal, offset_m: normal.dot(&X_GF.translation.vector) };
            let input = FitInput { points: &points, X_FC: Some(X_GF * scene.X_DC), table: Some(plane) };
            let moved = fit(input, &FitSettings::default(), Watch::idle()).unwrap();
            let expected = fixed.superquadric.transformed(&X_GF);
            // Rounding of 1e-16 in 2 m moves a handful of points across voxel borders, which moves centroids.
            assert!((moved.volume_m3 / fixed.volume_m3 - 1.0).abs() < 0.01);
            let off = moved.superquadric.X_FS.translation.vector - expected.X_FS.translation.vector;
            assert!(off.norm() < 0.0005, "{off:?}");
        }
    }

    #[test]
    fn starts_on_all_axes_fix_a_wrong_axis() {
        // A flat cushion: round in section about its shortest axis. The thesis's single start takes the longest as z.
        let truth = Superquadric::new(0.12, 0.09, 0.03, 0.3, 1.5, Isometry3::identity()).unwrap();
        let points: Vec<Point3<f64>> = truth.samples_spaced(0.006).iter().map(|q| q.p_F).collect();
        let around = Surroundings { mirror_normal: None, on_table: false, complete: false };
        let pairs: Vec<(Point3<f64>, f64)> = points.iter().map(|p| (*p, 1.0)).collect();
        let weighted = WeightedPoints::new(&pairs);
        let objective = Objective::new(&weighted, ObjectiveKind::Radial);
        let limits = Limits { max_iterations: 100, relative_reduction: 1e-7 };
        let costs: Vec<f64> = starts(&pairs, &around, &[1.0])
            .iter()
            .map(|s| {
                minimise::<PLAIN>(
                    &objective,
                    &s.candidate,
                    &bounds(&pairs, &around, &s.candidate, [false; 2]),
                    &limits,
                    Watch::idle(),
                )
            })
            .map(|found| (found.cost / objective.total_weight()).sqrt())
            .collect();
        // Principal axes come longest first, and the second assignment takes the first of them as z.
        assert!(costs[1] > 0.001, "the longest axis as z should not fit: {costs:?}");
        assert!(costs.iter().any(|rms_m| *rms_m < 1e-6), "{costs:?}");
        assert!(fit(cloud_only(&points), &FitSettings::default(), Watch::idle()).unwrap().radial_m < 0.0005);
    }

    #[test]
    fn refusals_name_what_is_missing() {
        let scene = standing([0.03, 0.05, 0.08], [0.1, 0.1], 0.4);
        let settings = FitSettings::default();
        let refused = |points: &[Point3<f64>]| fit(cloud_only(points), &settings, Watch::idle()).unwrap_err();
        assert_eq!(refused(&scene.seen[..5]), FitRefusal::TooFewPoints { found: 5, wanted: 12 });
        assert_eq!(refused(&[]), FitRefusal::TooFewPoints { found: 0, wanted: 12 });
        let lost = vec![Point3::new(f64::NAN, 0.0, 0.0); 20];
        assert_eq!(refused(&lost), FitRefusal::TooFewPoints { found: 0, wanted: 12 });
        let line: Vec<Point3<f64>> = (0..50).map(|k| Point3::new(0.01 * f64::from(k), 0.0, 0.0)).collect();
        assert!(matches!(refused(&line), FitRefusal::Degenerate { .. }));
        assert_eq!(refused(&[Point3::new(1.0, 2.0, 3.0); 50]), FitRefusal::TooFewPoints { found: 1, wanted: 12 });

        let on = FitSettings { mirror: MirrorMode::On, ..settings.clone() };
        let no_camera = FitInput { points: &scene.seen, X_FC: None, table: Some(table()) };
        let refusal = fit(no_camera, &on, Watch::idle()).unwrap_err();
        assert_eq!(refusal, FitRefusal::MirrorNeeds { missing: "camera" });
        let stopping = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        assert_eq!(fit(no_camera, &settings, stopping).unwrap_err(), FitRefusal::Stopped);
        let nonsense = FitSettings { voxel_m: f64::NAN, ..settings };
        assert!(matches!(fit(no_camera, &nonsense, Watch::idle()), Err(FitRefusal::Setting { name: "voxel_m", .. })));
    }

    #[test]
    fn a_shape_without_a_mirror_plane_is_refused_only_when_mirroring_was_demanded() {
        // Two arms of different lengths that meet at an odd angle: no vertical plane maps them onto themselves.
        let scene = standing([0.03, 0.03, 0.03], [1.0, 1.0], 0.0);
        let center = scene.truth.X_FS.translation.vector;
        let points: Vec<Point3<f64>> = [(0.3, 0.24), (1.5, 0.10)]
            .into_iter()
            .flat_map(|(angle, length): (f64, f64)| {
                let (sin, cos) = crate::math::sin_cos(angle);
                (0..60).flat_map(move |i| {
                    (0..8).map(move |j| {
                        let (along, across) = (length * f64::from(i) / 60.0, 0.002 * f64::from(j));
                        Point3::new(center.x + cos * along - sin * across, center.y + sin * along + cos * across, 0.02)
                    })
                })
            })
            .collect();
        let input = FitInput { points: &points, X_FC: Some(scene.X_DC), table: Some(table()) };
        let on = FitSettings { mirror: MirrorMode::On, ..FitSettings::default() };
        match fit(input, &on, Watch::idle()) {
            Err(FitRefusal::NoMirrorPlane { best_m, wanted_m }) => assert!(best_m > wanted_m),
            other => panic!("expected a refusal, got {other:?}"),
        }
        let auto = fit(input, &FitSettings::default(), Watch::idle()).unwrap();
        assert!(auto.mirrored.is_empty() && auto.mirror_note.starts_with("not mirrored"), "{}", auto.mirror_note);
    }
}
