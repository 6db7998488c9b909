//! Thinning: one centroid per voxel, the same whatever the order of the points.

use nalgebra::Point3;

/// Index of the voxel a coordinate falls into; far-away points share the outermost voxels.
pub(crate) fn cell(p: &Point3<f64>, edge_m: f64) -> [i32; 3] {
    [0, 1, 2].map(|axis| (p[axis] / edge_m).floor() as i32)
}

/// Points in ascending order of x, y, z: after this nothing depends on the order of the input.
pub(crate) fn sorted(mut points: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
    points.sort_unstable_by(|p, q| {
        p.x.total_cmp(&q.x).then_with(|| p.y.total_cmp(&q.y)).then_with(|| p.z.total_cmp(&q.z))
    });
    points
}

/// Centroids of the occupied voxels with the number of points in each, in the order of the voxels.
///
/// An edge of 0 keeps every point.
pub(crate) fn voxel_centroids(points: &[Point3<f64>], edge_m: f64) -> Vec<(Point3<f64>, usize)> {
    if edge_m <= 0.0 {
        return points.iter().map(|p| (*p, 1)).collect();
    }
    let mut keyed: Vec<([i32; 3], usize)> = points.iter().enumerate().map(|(k, p)| (cell(p, edge_m), k)).collect();
    keyed.sort_unstable();
    keyed
        .chunk_by(|(key, _), (next, _)| key == next)
        .map(|group| {
            let sum: nalgebra::Vector3<f64> = group.iter().map(|(_, k)| points[*k].coords).sum();
            (Point3::from(sum / group.len() as f64), group.len())
        })
        .collect()
}

/// At most `count` of the items, evenly spaced in their order.
pub(crate) fn every_nth<T: Copy>(items: &[T], count: usize) -> Vec<T> {
    if items.len() <= count {
        return items.to_vec();
    }
    (0..count).map(|k| items[k * items.len() / count]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxels_average_their_points_in_any_order() {
        let points = vec![
            Point3::new(0.001, 0.0, 0.0),
            Point3::new(0.003, 0.0, 0.0),
            Point3::new(-0.001, 0.0, 0.0),
            Point3::new(0.02, 0.0, 0.0),
        ];
        let thinned = voxel_centroids(&sorted(points.clone()), 0.015);
        let reversed = voxel_centroids(&sorted(points.into_iter().rev().collect()), 0.015);
        assert_eq!(thinned, reversed);
        assert_eq!(thinned.len(), 3);
        assert!((thinned[1].0.x - 0.002).abs() < 1e-15 && thinned[1].1 == 2);
        assert_eq!(voxel_centroids(&[Point3::origin(); 3], 0.0).len(), 3);
        assert_eq!(every_nth(&[0, 1, 2, 3, 4, 5], 3), vec![0, 2, 4]);
    }
}
