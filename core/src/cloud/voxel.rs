//! Thinning a cloud: one centroid per occupied cell of a grid.

use nalgebra::Point3;

/// Fixed-point steps per cell edge in which centroids are summed: whole numbers add up to the same sum in any order,
/// and 2²⁴ points (more than a cloud may have) of 2³⁸ steps each still fit a `u64`.
const STEPS: f64 = (1u64 << 38) as f64;

/// The centroids of the points in each cell of a grid with this edge, metres, ordered by cell (z, then y, then x).
///
/// The grid starts at the least corner of the points, so moving the cloud moves the result with it, and neither the
/// order of the points nor a hash decides anything: a permuted cloud gives the same centroids, bit by bit. An edge that
/// is not greater than 0 gives the points back as they are.
pub fn voxel_centroids(points: &[Point3<f64>], edge_m: f64) -> Vec<Point3<f64>> {
    if !(edge_m > 0.0 && edge_m.is_finite()) {
        return points.to_vec();
    }
    let corner = points.iter().fold(Point3::from([f64::INFINITY; 3]), |least, p| least.inf(p));
    // A float becomes a whole number by truncation, and stays in range by saturation.
    let mut cells: Vec<([u32; 3], u32)> = (points.iter().zip(0u32..))
        .map(|(p, index)| {
            let cell = (p - corner) / edge_m;
            ([cell.z as u32, cell.y as u32, cell.x as u32], index)
        })
        .collect();
    cells.sort_unstable();
    cells
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|cell| {
            let [z, y, x] = cell.first()?.0.map(f64::from);
            let base = corner + edge_m * nalgebra::Vector3::new(x, y, z);
            // Round-off may put a point a hair outside its cell: below counts as 0 by saturation.
            let mut sums = [0u64; 3];
            for (_, index) in cell {
                let offset = (points.get(*index as usize)? - base) / edge_m;
                for (sum, part) in sums.iter_mut().zip(offset.iter()) {
                    *sum += (part.min(1.0) * STEPS) as u64;
                }
            }
            let scale = edge_m / (STEPS * cell.len() as f64);
            let [x, y, z] = sums.map(|sum| sum as f64 * scale);
            Some(base + nalgebra::Vector3::new(x, y, z))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points() -> impl Strategy<Value = Vec<Point3<f64>>> {
        prop::collection::vec(prop::array::uniform3(-0.2f64..0.2).prop_map(Point3::from), 0..200)
    }

    proptest! {
        #[test]
        fn the_order_of_the_points_does_not_matter(points in points(), edge in 0.005f64..0.1) {
            let mut reversed = points.clone();
            reversed.reverse();
            prop_assert_eq!(voxel_centroids(&points, edge), voxel_centroids(&reversed, edge));
        }

        #[test]
        fn every_point_has_a_centroid_in_its_cell_and_no_two_centroids_share_one(points in points(), edge in 0.01f64..0.1) {
            let thinned = voxel_centroids(&points, edge);
            for p in &points {
                // The diagonal of a cell is √3 edges.
                prop_assert!(thinned.iter().any(|c| (c - p).norm() <= 1.7321 * edge));
            }
            let corner = points.iter().fold(Point3::from([f64::INFINITY; 3]), |least, p| least.inf(p));
            let mut cells: Vec<[i64; 3]> = thinned
                .iter()
                .map(|c| ((c - corner) / edge).map(|x| (x + 1e-9).floor() as i64).into())
                .collect();
            cells.sort_unstable();
            cells.dedup();
            prop_assert_eq!(cells.len(), thinned.len());
        }
    }

    #[test]
    fn one_cell_gives_the_mean() {
        let points = [Point3::new(0.0, 0.0, 0.0), Point3::new(0.02, 0.04, 0.06)];
        let centroid = voxel_centroids(&points, 0.1);
        assert_eq!(centroid.len(), 1);
        assert!((centroid[0] - Point3::new(0.01, 0.02, 0.03)).norm() < 1e-12);
        assert_eq!(voxel_centroids(&points, 0.0).len(), 2);
    }
}
