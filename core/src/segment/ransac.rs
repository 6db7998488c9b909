//! The largest plane of a cloud: random sample consensus on a sample that does not depend on the order of the points.

use nalgebra::{Point3, Unit};

use super::{Plane, SegmentSettings};
use crate::rng::Rng;

/// Points that the plane is refined on: their mean distance leaves an error of σ/√8192, 0.03 mm at 3 mm of noise.
const REFINE: usize = 8192;
/// Points that a hypothesis is counted on; a plane with a tenth of the cloud is seen to within a tenth of its count.
const SCORE: usize = 1024;
/// Rounds of least squares on the inliers; the set of inliers settles in two or three.
const ROUNDS: usize = 4;

/// A plane with how well it holds on the sample.
pub(super) struct Found {
    pub(super) plane: Plane,
    /// Estimated points of the whole cloud within the distance.
    pub(super) inliers: usize,
    /// Root mean square distance of the inliers, metres.
    pub(super) rms_m: f64,
    /// The sample, which does not depend on the order of the cloud's points.
    pub(super) sample: Vec<Point3<f64>>,
}

/// The plane with the most points near it, or `None` when no three points span one.
pub(super) fn largest_plane(points: &[Point3<f64>], settings: &SegmentSettings, seed: u64) -> Option<Found> {
    let sample = sample(points, seed);
    let score: Vec<Point3<f64>> = sample.iter().take(SCORE).copied().collect();
    let distance = settings.plane_distance_m;
    let mut rng = Rng::new(seed, 0);
    let mut best: Option<(usize, Plane)> = None;
    for _ in 0..settings.plane_hypotheses {
        let [Some(a), Some(b), Some(c)] = [(); 3].map(|()| score.get(rng.index(score.len()))) else { return None };
        let Some(normal) = Unit::try_new((b - a).cross(&(c - a)), 1e-12) else { continue };
        let plane = Plane { normal, offset_m: normal.dot(&a.coords) };
        let count = score.iter().filter(|p| plane.height(p).abs() <= distance).count();
        if best.as_ref().is_none_or(|(most, _)| count > *most) {
            best = Some((count, plane));
        }
    }
    let (_, mut plane) = best?;
    for _ in 0..ROUNDS {
        let near = sample.iter().filter(|p| plane.height(p).abs() <= distance);
        plane = Plane::through(near).unwrap_or(plane);
    }
    let (count, squares) = (sample.iter().map(|p| plane.height(p)))
        .filter(|height| height.abs() <= distance)
        .fold((0usize, 0.0), |(count, squares), height| (count + 1, squares + height * height));
    let scale = points.len() as f64 / sample.len().max(1) as f64;
    Some(Found {
        plane,
        inliers: (count as f64 * scale).round() as usize,
        rms_m: (squares / count.max(1) as f64).sqrt(),
        sample,
    })
}

/// About [`REFINE`] points, chosen and ordered by a hash of their coordinates, so that a permuted cloud gives the same.
fn sample(points: &[Point3<f64>], seed: u64) -> Vec<Point3<f64>> {
    let wanted = REFINE as f64 / points.len().max(1) as f64;
    // `as` saturates: a small cloud is taken whole.
    let limit = (wanted * u64::MAX as f64) as u64;
    let mut chosen: Vec<(u64, Point3<f64>)> =
        points.iter().map(|p| (hash(p, seed), *p)).filter(|(key, _)| *key <= limit).collect();
    chosen.sort_unstable_by(|(k, p), (l, q)| {
        k.cmp(l).then_with(|| p.x.total_cmp(&q.x)).then_with(|| p.y.total_cmp(&q.y)).then_with(|| p.z.total_cmp(&q.z))
    });
    // Copies of one point are all chosen or none; this bounds the work if a file is made of copies.
    chosen.truncate(2 * REFINE);
    chosen.into_iter().map(|(_, p)| p).collect()
}

/// Mixes the bits of the coordinates (the finaliser of splitmix64, Steele et al. 2014).
fn hash(p: &Point3<f64>, seed: u64) -> u64 {
    let mut key = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ p.x.to_bits()
        ^ p.y.to_bits().rotate_left(21)
        ^ p.z.to_bits().rotate_left(42);
    key = (key ^ (key >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    key = (key ^ (key >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    key ^ (key >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane of 6 000 points with 3 mm of noise and 4 000 points anywhere.
    fn scene(plane: &Plane, seed: u64) -> Vec<Point3<f64>> {
        let mut rng = Rng::new(seed, 9);
        let (u, v) = plane.basis();
        let n = plane.normal.into_inner();
        let mut points: Vec<Point3<f64>> = (0..6000)
            .map(|_| {
                let (x, y) = (rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3));
                Point3::from(n * (plane.offset_m + 0.003 * rng.normal()) + u * x + v * y)
            })
            .collect();
        points.extend((0..4000).map(|_| Point3::from(rng.direction() * rng.unit())));
        points
    }

    #[test]
    fn the_plane_is_found_among_outliers_in_any_frame() {
        for seed in 0..20 {
            let mut rng = Rng::new(seed, 1);
            let truth =
                Plane { normal: Unit::try_new(rng.direction(), 0.1).unwrap(), offset_m: rng.uniform(-1.0, 1.0) };
            let found = largest_plane(&scene(&truth, seed), &SegmentSettings::default(), seed).unwrap();
            let angle = found.plane.normal.dot(&truth.normal).abs();
            // 6 000 points of 3 mm over a metre fix the tilt to about 0.1 mm/m; outliers near the plane add some.
            assert!(angle > 1.0 - 2e-6, "{angle}");
            assert!((found.inliers as i64 - 6000).abs() < 300, "{}", found.inliers);
            assert!((found.rms_m - 0.003).abs() < 0.0004, "{}", found.rms_m);
        }
    }

    #[test]
    fn copies_of_one_point_span_no_plane() {
        assert!(largest_plane(&vec![Point3::new(1.0, 2.0, 3.0); 50_000], &SegmentSettings::default(), 1).is_none());
        assert!(largest_plane(&[], &SegmentSettings::default(), 1).is_none());
    }
}
