//! Completing the unseen side by a mirror image (Bohg et al. 2011; thesis 3.5.2).
//!
//! Candidate planes contain the table normal, so mirrored points keep their height and never go below the table.
//! The camera judges them: a mirrored point outside the object's outline, or in front of the surface that was measured
//! there, is impossible; behind it, it is merely hidden. A plane costs the mean impossibility of its points, in metres;
//! a perfect mirror costs 0 and wins.
//!
//! Planes nearly parallel to the view complete nothing, so the normal stays within 50° of the direction of view.
//! When the plane across the first one passes as well, the object is mirrored at both: a box seen at a corner has two
//! hidden sides.

use nalgebra::{Point3, Vector3};

use super::thin::voxel_centroids;
use super::view::View;
use crate::math;

/// A plane passes when its points are impossible by no more than this on average, metres: the noise of the sensor at
/// 1 m plus a pixel of the outline.
pub(crate) const PASS_M: f64 = 0.004;
/// A single mirrored point that is more impossible than this is not added to the cloud, metres.
const POINT_PASS_M: f64 = 0.004;
/// The normal of the plane stays this close to the direction of view, radians (50°).
const MAX_ANGLE_RAD: f64 = 0.873;
/// Search grid: angles either side of the direction of view, and offsets.
const ANGLES_EACH_SIDE: i32 = 6;
const OFFSETS: i32 = 24;
/// Angles of the grid that are refined, and how often; each refinement halves the steps.
const REFINED_ANGLES: usize = 4;
const REFINEMENTS: u32 = 5;
/// Points are thinned to about this many for the search.
const SEARCH_POINTS: f64 = 180.0;

/// A vertical plane in D: `normal · p = offset_m`, normal horizontal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MirrorPlane {
    pub(crate) normal: Vector3<f64>,
    pub(crate) offset_m: f64,
    /// Mean impossibility of the mirrored points, metres.
    pub(crate) cost_m: f64,
}

/// What the search found.
#[derive(Clone, Debug)]
pub(crate) struct Mirroring {
    /// The best plane, whether it passes or not.
    pub(crate) first: MirrorPlane,
    /// The plane across it, when both pass.
    pub(crate) second: Option<MirrorPlane>,
    /// Points that mirroring adds, in D; empty when the first plane does not pass.
    pub(crate) added: Vec<Point3<f64>>,
}

impl MirrorPlane {
    fn reflect(&self, p: &Point3<f64>) -> Point3<f64> {
        p - self.normal * (2.0 * (self.normal.dot(&p.coords) - self.offset_m))
    }
}

/// Mean impossibility of the points mirrored at a plane, metres.
fn cost_of(points: &[(Point3<f64>, usize)], view: &View, normal: &Vector3<f64>, offset_m: f64) -> f64 {
    let plane = MirrorPlane { normal: *normal, offset_m, cost_m: 0.0 };
    let sum: f64 = points.iter().map(|(p, _)| view.impossibility(&plane.reflect(p)).total_m()).sum();
    sum / points.len().max(1) as f64
}

/// A horizontal unit vector at an angle from x_D, radians.
fn horizontal(angle_rad: f64) -> Vector3<f64> {
    let (sin, cos) = math::sin_cos(angle_rad);
    Vector3::new(cos, sin, 0.0)
}

/// Smallest and largest coordinate of the points along a direction.
fn range_along(points: &[(Point3<f64>, usize)], direction: &Vector3<f64>) -> [f64; 2] {
    points
        .iter()
        .map(|(p, _)| direction.dot(&p.coords))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
}

/// Searches the planes and mirrors the cloud; points and view in D, whose z axis is the table normal.
///
/// `None` for a cloud without points.
pub(crate) fn mirror(points: &[Point3<f64>], view: &View) -> Option<Mirroring> {
    let mean = super::frame::centroid(points.iter());
    let spread = (points.iter().map(|p| (p - mean).norm_squared()).sum::<f64>() / points.len().max(1) as f64).sqrt();
    // A visible half shell of radius r has about 2π r² of surface.
    let edge_m = (std::f64::consts::TAU * spread * spread / SEARCH_POINTS).sqrt();
    let sparse = voxel_centroids(points, edge_m);
    if sparse.is_empty() {
        return None;
    }
    let to_object = mean - view.camera();
    let ahead_rad = math::atan2(to_object.y, to_object.x);

    let first = search_first(&sparse, view, ahead_rad);
    if first.cost_m > PASS_M {
        return Some(Mirroring { first, second: None, added: Vec::new() });
    }
    let second = search_second(&sparse, view, &first);
    let mut added = possible(points.iter().map(|p| first.reflect(p)), view);
    if let Some(second) = &second {
        let once: Vec<Point3<f64>> = points.iter().chain(&added).map(|p| second.reflect(p)).collect();
        added.extend(possible(once.into_iter(), view));
    }
    Some(Mirroring { first, second, added })
}

fn possible(points: impl Iterator<Item = Point3<f64>>, view: &View) -> Vec<Point3<f64>> {
    points.filter(|p| view.impossibility(p).total_m() <= POINT_PASS_M).collect()
}

/// Grid over angle and offset around the direction of view, then refinement of the best angles.
///
/// The valley around a box's plane is only about 6° wide, so the best grid cell alone may lie in another one.
fn search_first(points: &[(Point3<f64>, usize)], view: &View, ahead_rad: f64) -> MirrorPlane {
    let angle_step = MAX_ANGLE_RAD / f64::from(ANGLES_EACH_SIDE);
    // From the direction of view outwards, so that of equal planes the one facing the camera wins.
    let mut by_angle: Vec<Cell> = (0..=2 * ANGLES_EACH_SIDE)
        .map(|k| {
            let angle_rad = ahead_rad + angle_step * f64::from(outwards(k));
            let normal = horizontal(angle_rad);
            let [near, far] = range_along(points, &normal);
            let offset_step = (far - near) / f64::from(OFFSETS);
            // The middle of the object is behind the front of what is seen; it may even be behind its rear.
            let first = Cell { cost_m: f64::INFINITY, angle_rad, offset_m: near, offset_step };
            (0..OFFSETS)
                .map(|j| near + (far - near) * 0.25 + offset_step * f64::from(j))
                .fold(first, |best, offset_m| best.or(points, view, angle_rad, offset_m))
        })
        .collect();
    by_angle.sort_by(|p, q| p.cost_m.total_cmp(&q.cost_m)); // stable: equal costs keep their order
    let refined = by_angle.iter().take(REFINED_ANGLES).map(|cell| {
        let mut best = *cell;
        let (mut da, mut d) = (0.5 * angle_step, 0.5 * cell.offset_step);
        for _ in 0..REFINEMENTS {
            let middle = best;
            for (i, j) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)] {
                let turned = middle.angle_rad + da * f64::from(i);
                let turned = turned.max(ahead_rad - MAX_ANGLE_RAD).min(ahead_rad + MAX_ANGLE_RAD);
                best = best.or(points, view, turned, middle.offset_m + d * f64::from(j));
            }
            da *= 0.5;
            d *= 0.5;
        }
        best
    });
    let best = refined.min_by(|p, q| p.cost_m.total_cmp(&q.cost_m));
    let (angle_rad, offset_m, cost_m) =
        best.map_or((ahead_rad, 0.0, f64::INFINITY), |best| (best.angle_rad, best.offset_m, best.cost_m));
    MirrorPlane { normal: horizontal(angle_rad), offset_m, cost_m }
}

/// 0, -1, 1, -2, 2, … for k = 0, 1, 2, 3, 4, ….
fn outwards(k: i32) -> i32 {
    if k % 2 == 0 { k / 2 } else { -(k + 1) / 2 }
}

/// A plane of the search, and the step of the grid it came from.
#[derive(Clone, Copy)]
struct Cell {
    cost_m: f64,
    angle_rad: f64,
    offset_m: f64,
    offset_step: f64,
}

impl Cell {
    /// The better of this plane and another one.
    fn or(self, points: &[(Point3<f64>, usize)], view: &View, angle_rad: f64, offset_m: f64) -> Self {
        let cost_m = cost_of(points, view, &horizontal(angle_rad), offset_m);
        if cost_m < self.cost_m { Self { cost_m, angle_rad, offset_m, ..self } } else { self }
    }
}

/// The plane across the first one, by its offset alone; `None` when none passes.
fn search_second(points: &[(Point3<f64>, usize)], view: &View, first: &MirrorPlane) -> Option<MirrorPlane> {
    let normal = Vector3::z().cross(&first.normal);
    let [near, far] = range_along(points, &normal);
    let mut step = (far - near) / f64::from(2 * OFFSETS);
    let middle = 0.5 * (near + far);
    let mut best = (f64::INFINITY, middle);
    for k in 0..=2 * OFFSETS {
        let offset = middle + step * f64::from(outwards(k));
        let cost = cost_of(points, view, &normal, offset);
        if cost < best.0 {
            best = (cost, offset);
        }
    }
    for _ in 0..REFINEMENTS {
        step *= 0.5;
        for offset in [best.1 - step, best.1 + step] {
            let cost = cost_of(points, view, &normal, offset);
            if cost < best.0 {
                best = (cost, offset);
            }
        }
    }
    (best.0 <= PASS_M).then_some(MirrorPlane { normal, offset_m: best.1, cost_m: best.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::test_scenes::{Scene, standing};

    #[test]
    fn a_perfect_mirror_wins() {
        for yaw_rad in [0.0, 0.3, -0.6, 0.78] {
            // A box of 6 × 10 × 12 cm: its planes of symmetry are at yaw and yaw + 90°, through its centre.
            let Scene { seen, X_DC, truth } = standing([0.03, 0.05, 0.06], [0.1, 0.1], yaw_rad);
            let view = View::new(&seen, &X_DC).unwrap();
            let found = mirror(&seen, &view).unwrap();
            assert!(found.first.cost_m < 0.001, "yaw {yaw_rad}: {:?}", found.first);
            let across = truth.X_FS.inverse_transform_vector(&found.first.normal);
            assert!(across.x.abs().max(across.y.abs()) > math::cos(0.1), "yaw {yaw_rad}: normal {across:?}");
            let miss = found.first.normal.dot(&truth.X_FS.translation.vector) - found.first.offset_m;
            assert!(miss.abs() < 0.003, "yaw {yaw_rad}: {miss}");
            assert!(found.second.is_some() && found.added.len() > seen.len() / 2);
            for p in &found.added {
                let far_m = truth.radial_distance(p);
                assert!(
                    far_m < 0.015,
                    "yaw {yaw_rad}: a mirrored point is {far_m} from the box: {p} {:?} {:?}",
                    found.first,
                    found.second
                );
            }
        }
    }

    #[test]
    fn a_plane_off_the_middle_costs_more_on_either_side() {
        let Scene { seen, X_DC, truth } = standing([0.04, 0.04, 0.06], [0.1, 1.0], 0.0);
        let view = View::new(&seen, &X_DC).unwrap();
        let sparse = voxel_centroids(&seen, 0.01);
        let ahead = truth.X_FS.translation.vector - view.camera().coords;
        let normal = horizontal(math::atan2(ahead.y, ahead.x));
        let middle = normal.dot(&truth.X_FS.translation.vector);
        let cost = |shift: f64| cost_of(&sparse, &view, &normal, middle + shift);
        assert!(cost(0.0) < 0.0005, "{}", cost(0.0));
        assert!(cost(0.01) > 3.0 * cost(0.0) && cost(-0.01) > 3.0 * cost(0.0), "{} {}", cost(0.01), cost(-0.01));
        assert!(cost(0.02) > cost(0.01) && cost(-0.02) > cost(-0.01));
    }

    #[test]
    fn mirrored_points_keep_their_height() {
        let Scene { seen, X_DC, .. } = standing([0.03, 0.03, 0.05], [0.1, 1.0], 0.0);
        let found = mirror(&seen, &View::new(&seen, &X_DC).unwrap()).unwrap();
        assert!(!found.added.is_empty() && found.added.iter().all(|p| p.z >= 0.0));
    }
}
