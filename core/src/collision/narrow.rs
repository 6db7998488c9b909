//! Two bodies: closer than some distance, and how far apart.

use nalgebra::Vector3;

use super::closed_form::{segment_box, segment_segment};
use super::frames::Rigid;
use super::parry::{Placed, core_distance, cores_within};
use super::solid::{Core, Solid};

/// Where a pair stands relative to two distances, `touch <= near`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Proximity {
    /// Farther apart than `near`.
    Apart,
    /// Between the two.
    Near,
    /// At most `touch` apart.
    Touching,
}

/// Compares the distance of two bodies with two thresholds in metres; negative thresholds ask for a depth.
///
/// `X_WA` and `X_WB` are the poses of the frames that carry the bodies.
pub(crate) fn proximity(a: &Solid, X_WA: &Rigid, b: &Solid, X_WB: &Rigid, touch_m: f64, near_m: f64) -> Proximity {
    let rounding = a.radius + b.radius;
    if let Some(squared) = closed_form(a, X_WA, b, X_WB) {
        let touch = rounding + touch_m;
        if squared > 0.0 || touch >= 0.0 {
            let near = rounding + near_m;
            return if touch >= 0.0 && squared <= touch * touch {
                Proximity::Touching
            } else if near >= 0.0 && squared <= near * near {
                Proximity::Near
            } else {
                Proximity::Apart
            };
        }
    }
    let (X_WA, X_WB) = (a.placed(X_WA), b.placed(X_WB));
    let towards = towards(a, &X_WA, b, &X_WB);
    let (place_a, place_b) = (Placed { core: &a.core, X_WB: &X_WA }, Placed { core: &b.core, X_WB: &X_WB });
    let near = rounding + near_m;
    if near >= 0.0 && !cores_within(&place_a, &place_b, near, &towards) {
        return Proximity::Apart;
    }
    let touch = rounding + touch_m;
    if touch >= 0.0 {
        return if near <= touch || cores_within(&place_a, &place_b, touch, &towards) {
            Proximity::Touching
        } else {
            Proximity::Near
        };
    }
    let distance = core_distance(&place_a, &place_b, &towards) - rounding;
    if distance <= touch_m {
        Proximity::Touching
    } else if distance <= near_m {
        Proximity::Near
    } else {
        Proximity::Apart
    }
}

/// Signed distance of two bodies, metres; negative is the depth of penetration.
pub(crate) fn signed_distance(a: &Solid, X_WA: &Rigid, b: &Solid, X_WB: &Rigid) -> f64 {
    let rounding = a.radius + b.radius;
    if let Some(squared) = closed_form(a, X_WA, b, X_WB)
        && (squared > 0.0 || matches!((&a.core, &b.core), (Core::Segment { .. }, Core::Segment { .. })))
    {
        return squared.sqrt() - rounding;
    }
    let (X_WA, X_WB) = (a.placed(X_WA), b.placed(X_WB));
    let towards = towards(a, &X_WA, b, &X_WB);
    let (place_a, place_b) = (Placed { core: &a.core, X_WB: &X_WA }, Placed { core: &b.core, X_WB: &X_WB });
    core_distance(&place_a, &place_b, &towards) - rounding
}

/// Squared distance of the cores where a closed form exists, m².
#[inline]
fn closed_form(a: &Solid, X_WA: &Rigid, b: &Solid, X_WB: &Rigid) -> Option<f64> {
    match (&a.core, &b.core) {
        (Core::Segment { a: a0, b: a1 }, Core::Segment { a: b0, b: b1 }) => {
            Some(segment_segment(&X_WA.point(a0), &X_WA.point(a1), &X_WB.point(b0), &X_WB.point(b1)))
        }
        (Core::Segment { a: a0, b: a1 }, Core::Box { half }) => {
            let X = b.placed(X_WB);
            Some(segment_box(&X.inverse_point(&X_WA.point(a0)), &X.inverse_point(&X_WA.point(a1)), half))
        }
        (Core::Box { .. }, Core::Segment { .. }) => closed_form(b, X_WB, a, X_WA),
        _ => None,
    }
}

/// Roughly from the first body to the second: the first direction that GJK looks in. Poses are of the bodies' own
/// frames.
fn towards(a: &Solid, X_WA: &Rigid, b: &Solid, X_WB: &Rigid) -> Vector3<f64> {
    let center = |solid: &Solid, X: &Rigid| match &solid.core {
        Core::Segment { .. } => X.point(&solid.center),
        _ => X.t,
    };
    center(b, X_WB) - center(a, X_WA)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Translation3};

    use super::*;
    use crate::collision::ConvexHull;
    use crate::collision::parry::ForeignBody;
    use crate::rng::Rng;

    fn random_core(rng: &mut Rng, kind: usize) -> (Core, f64) {
        match kind {
            0 => (Core::Segment { a: Vector3::zeros(), b: Vector3::zeros() }, rng.uniform(0.02, 0.2)),
            1 => {
                let half = rng.uniform(0.05, 0.3) * Vector3::z();
                (Core::Segment { a: -half, b: half }, rng.uniform(0.02, 0.1))
            }
            2 => (Core::Box { half: Vector3::from_fn(|_, _| rng.uniform(0.02, 0.3)) }, 0.0),
            3 => (Core::Cylinder { radius: rng.uniform(0.03, 0.2), half_length: rng.uniform(0.03, 0.3) }, 0.0),
            _ => {
                let points: Vec<_> = (0..30).map(|_| Point3::from(rng.direction() * rng.uniform(0.1, 0.2))).collect();
                (Core::Hull(ConvexHull::new("hull", &points).unwrap()), 0.0)
            }
        }
    }

    #[test]
    fn every_pair_of_shapes_agrees_with_parrys_own_shapes() {
        let mut rng = Rng::new(5, 0);
        let world = Isometry3::identity();
        let (mut apart, mut deep) = (0, 0);
        for kind_a in 0..5 {
            for kind_b in 0..5 {
                for _ in 0..60 {
                    let (core_a, radius_a) = random_core(&mut rng, kind_a);
                    let (core_b, radius_b) = random_core(&mut rng, kind_b);
                    let X_WA = Isometry3::from_parts(Translation3::identity(), rng.rotation());
                    let X_WB = Isometry3::from_parts(
                        Translation3::from(rng.direction() * rng.uniform(0.0, 0.8)),
                        rng.rotation(),
                    );
                    let foreign_a = ForeignBody::new(&core_a, radius_a, &X_WA).unwrap();
                    let foreign_b = ForeignBody::new(&core_b, radius_b, &X_WB).unwrap();
                    let theirs = foreign_a.distance(&world, &foreign_b, &world);
                    let (a, b) = (Solid::new(core_a, radius_a, &X_WA), Solid::new(core_b, radius_b, &X_WB));
                    let identity = Rigid::identity();
                    let ours = signed_distance(&a, &identity, &b, &identity);
                    let case = format!("{kind_a} {kind_b}: ours {ours}, theirs {theirs}");
                    // GJK stalls on curved shapes: parry's capsules are up to 2e-5 m off, our cylinders as much.
                    // EPA stops at 1e-3 of a facet.
                    if theirs > 0.0 {
                        apart += 1;
                        assert!((ours - theirs).abs() < 5e-5, "{case}");
                    } else {
                        deep += 1;
                        assert!(ours < 1e-6, "{case}");
                        assert!((ours - theirs).abs() < 2e-3 || ours <= theirs + 2e-3, "{case}");
                    }
                    for threshold in [0.0, 0.03] {
                        if (theirs - threshold).abs() < 5e-5 {
                            continue;
                        }
                        let answer = proximity(&a, &identity, &b, &identity, threshold, threshold);
                        assert_eq!(answer == Proximity::Touching, theirs <= threshold, "{case} at {threshold}");
                    }
                }
            }
        }
        assert!(apart > 300 && deep > 100, "the cases must cover both sides: {apart} apart, {deep} deep");
    }

    #[test]
    fn a_capsule_sunk_into_a_box_has_a_negative_distance_that_grows_with_depth() {
        let floor = Solid::new(Core::Box { half: Vector3::new(1.0, 1.0, 0.1) }, 0.0, &Isometry3::identity());
        let half = Vector3::x() * 0.1;
        let rod = Solid::new(Core::Segment { a: -half, b: half }, 0.02, &Isometry3::identity());
        for (height, wanted) in [(0.15, 0.03), (0.12, 0.0), (0.11, -0.01), (0.09, -0.03), (0.05, -0.07)] {
            let X = Rigid { t: Vector3::z() * height, ..Rigid::identity() };
            let found = signed_distance(&floor, &Rigid::identity(), &rod, &X);
            assert!((found - wanted).abs() < 1e-9, "at {height}: {found}, wanted {wanted}");
        }
    }
}
