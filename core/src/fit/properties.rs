//! What must hold for every fit, whatever the cloud: tests of the whole room through its public door.

use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::{DeformMode, Fit, FitInput, FitSettings, ObjectiveKind, fit, fit_errors};
use crate::rng::Rng;
use crate::superquadric::{Superquadric, bend_limit_per_m};
use crate::watch::Watch;

fn random_shape(rng: &mut Rng) -> Superquadric {
    let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
    let axes = [0.0; 3].map(|_: f64| rng.uniform(0.03, 0.2));
    Superquadric::new(axes[0], axes[1], axes[2], rng.uniform(0.15, 1.6), rng.uniform(0.15, 1.6), X_FS).unwrap()
}

fn surface(shape: &Superquadric, spacing_m: f64) -> Vec<Point3<f64>> {
    shape.samples_spaced(spacing_m).iter().map(|q| q.p_F).collect()
}

fn fitted(points: &[Point3<f64>], settings: &FitSettings) -> Fit {
    fit(FitInput { points, X_FC: None, table: None }, settings, Watch::idle()).unwrap()
}

/// Mean radial distance of one shape's surface from another's, metres.
fn apart_m(found: &Superquadric, wanted: &Superquadric) -> f64 {
    fit_errors(found, &surface(wanted, 0.01)).radial_m
}

#[test]
fn a_moved_cloud_gives_the_moved_shape() {
    let mut rng = Rng::new(71, 0);
    for _ in 0..8 {
        let shape = random_shape(&mut rng);
        let points = surface(&shape, 0.008);
        let first = fitted(&points, &FitSettings::default());
        let X_GF = Isometry3::from_parts(Translation3::from(rng.direction() * 3.0), rng.rotation());
        let moved: Vec<Point3<f64>> = points.iter().map(|p| X_GF * p).collect();
        let second = fitted(&moved, &FitSettings::default());
        // Rounding of 1e-16 in 3 m moves a few points across voxel borders.
        assert!(apart_m(&second.superquadric, &first.superquadric.transformed(&X_GF)) < 1e-4, "{shape:?}");
    }
}

#[test]
fn a_cloud_of_another_size_gives_the_shape_of_that_size() {
    let mut rng = Rng::new(72, 0);
    for scale in [0.4, 0.9, 2.0, 7.0] {
        let shape = random_shape(&mut rng);
        let points = surface(&shape, 0.008);
        let settings = FitSettings::default();
        let first = fitted(&points, &settings).superquadric;
        let scaled: Vec<Point3<f64>> = points.iter().map(|p| p * scale).collect();
        let second = fitted(&scaled, &FitSettings { voxel_m: scale * settings.voxel_m, ..settings }).superquadric;
        for (one, other) in [(first.a, second.a), (first.b, second.b), (first.c, second.c)] {
            assert!((other / (scale * one) - 1.0).abs() < 1e-3, "scale {scale}: {first:?} {second:?}");
        }
        assert!((first.e1 - second.e1).abs() < 1e-2 && (first.e2 - second.e2).abs() < 1e-2, "{first:?} {second:?}");
    }
}

#[test]
fn shuffled_and_duplicated_points_change_no_bit() {
    let mut rng = Rng::new(73, 0);
    for settings in [FitSettings::default(), FitSettings { voxel_m: 0.0, ..FitSettings::default() }] {
        let shape = random_shape(&mut rng);
        let mut points = surface(&shape, 0.012);
        let first = fitted(&points, &settings);
        for k in (1..points.len()).rev() {
            points.swap(k, rng.index(k + 1));
        }
        let copies: Vec<Point3<f64>> = (0..points.len()).filter(|k| k % 3 == 0).map(|k| points[k]).collect();
        points.extend(copies);
        assert_eq!(fitted(&points, &settings).superquadric, first.superquadric);
    }
}

#[test]
fn every_objective_finds_a_clean_shape() {
    let mut rng = Rng::new(74, 0);
    for objective in ObjectiveKind::ALL {
        for reject_outliers in [false, true] {
            let shape = Superquadric { X_FS: random_shape(&mut rng).X_FS, ..cushion() };
            let settings = FitSettings { objective, reject_outliers, voxel_m: 0.0, ..FitSettings::default() };
            let found = fitted(&surface(&shape, 0.008), &settings);
            // The cloud lies exactly on the shape: what is left is where the minimiser stops.
            assert!(found.radial_m < 1e-5, "{objective:?}: {} {:?}", found.radial_m, found.superquadric);
            assert!(found.runs.iter().all(|run| run.rms.windows(2).all(|pair| pair[1] <= pair[0])));
        }
    }
}

fn cushion() -> Superquadric {
    Superquadric::new(0.05, 0.09, 0.13, 0.4, 0.7, Isometry3::identity()).unwrap()
}

#[test]
fn a_fifth_of_the_points_may_be_strays() {
    let mut rng = Rng::new(75, 0);
    let mut errors = Vec::new();
    for _ in 0..15 {
        let shape = random_shape(&mut rng);
        let mut points = surface(&shape, 0.01);
        let clean = points.len();
        let half = shape.half_extents() * 2.0;
        for _ in 0..clean / 4 {
            let stray = Vector3::from_fn(|k, _| rng.uniform(-half[k], half[k]));
            points.push(Point3::from(shape.X_FS.translation.vector + stray));
        }
        let found = fitted(&points, &FitSettings::default());
        errors.push((found.volume_m3 / shape.volume() - 1.0).abs());
        for rejected in &found.rejected {
            assert!(rejected.distance_m.abs() > rejected.limit_m);
            assert!(points.contains(&rejected.p_F), "a rejected point is a point of the input, to the last bit");
        }
        assert!(!found.rejected.is_empty());
    }
    errors.sort_by(f64::total_cmp);
    assert!(errors[errors.len() / 2] < 0.03, "{errors:?}");
}

#[test]
fn deformations_are_recognised_and_plain_shapes_stay_plain() {
    let mut rng = Rng::new(76, 0);
    let auto = FitSettings { deform: DeformMode::Auto, voxel_m: 0.0, ..FitSettings::default() };
    for (wanted, taper, bend) in [("plain", 0.0, 0.0), ("taper", 0.5, 0.0), ("bend", 0.0, 0.6)] {
        let X_FS = Isometry3::from_parts(Translation3::from(rng.direction()), rng.rotation());
        let plain = Superquadric::new(0.035, 0.03, 0.09, 0.3, 0.9, X_FS).unwrap();
        let shape = plain.deformed(taper, bend * bend_limit_per_m(plain.b, plain.c, taper)).unwrap();
        let found = fitted(&surface(&shape, 0.005), &auto);
        let chosen: Vec<&str> = found.models.iter().filter(|m| m.is_chosen).map(|m| m.name.as_str()).collect();
        assert_eq!(chosen, [wanted], "{:?}", found.models);
        assert!((found.volume_m3 / shape.volume() - 1.0).abs() < 0.01, "{:?} {shape:?}", found.superquadric);
        assert!(found.radial_m < 1e-4, "{}", found.radial_m);
        assert_eq!(found.superquadric.is_deformed(), wanted != "plain");
    }
}

#[test]
fn coarse_to_fine_is_as_good_and_says_its_levels() {
    let shape = cushion();
    let points = surface(&shape, 0.004);
    let levels = fitted(&points, &FitSettings { hierarchical: true, ..FitSettings::default() });
    let single = fitted(&points, &FitSettings::default());
    assert!(levels.radial_m < 1.05 * single.radial_m + 1e-5, "{} {}", levels.radial_m, single.radial_m);
    assert!(levels.runs.iter().any(|run| run.name.contains("level 2 of 5")), "{:?}", levels.runs.last());
}

#[test]
fn a_mug_and_a_hammer_are_two_parts_and_a_box_is_one() {
    let at = |x: f64, z: f64| Isometry3::translation(x, 0.0, z);
    let part = |a, b, c, e1, e2, X_FS| Superquadric::new(a, b, c, e1, e2, X_FS).unwrap();
    let mug = [part(0.04, 0.04, 0.05, 0.1, 1.0, at(0.0, 0.0)), part(0.02, 0.008, 0.03, 0.5, 0.5, at(0.055, 0.0))];
    let hammer = [part(0.012, 0.015, 0.13, 0.2, 0.8, at(0.0, 0.0)), part(0.05, 0.015, 0.018, 0.3, 0.3, at(0.01, 0.14))];
    let cuboid = [part(0.03, 0.05, 0.08, 0.1, 0.1, at(0.0, 0.0))];
    let settings = FitSettings { max_parts: 4, voxel_m: 0.006, ..FitSettings::default() };
    for bodies in [&mug[..], &hammer[..], &cuboid[..]] {
        let points: Vec<Point3<f64>> = bodies
            .iter()
            .enumerate()
            .flat_map(|(k, body)| {
                let outside = move |p: &Point3<f64>| bodies.iter().enumerate().all(|(j, b)| j == k || !b.contains(p));
                surface(body, 0.004).into_iter().filter(outside)
            })
            .collect();
        let found = fitted(&points, &settings);
        assert_eq!(found.bodies().count(), bodies.len(), "{:?}", found.models);
        assert!(found.radial_m < 0.0006, "{}", found.radial_m);
        let total: f64 = bodies.iter().map(Superquadric::volume).sum();
        assert!((found.volume_m3 / total - 1.0).abs() < 0.1, "{} {total}", found.volume_m3);
        assert!(
            found.bodies().zip(found.bodies().skip(1)).all(|(larger, smaller)| larger.volume() >= smaller.volume())
        );
    }
}
