//! Boxes that the robot knows about are not objects.

use super::{PointFate, Segmentation};
use crate::cloud::PointCloud;
use crate::scene::Obstacle;

impl Segmentation {
    /// Takes the points in or near known boxes out of the clusters; the cloud and the boxes must be in one frame.
    ///
    /// * `margin_m`: how far outside a box a point may be measured and still be the box's; the sensor's noise.
    /// * `min_points`: a cluster that keeps fewer points is dropped, as in [`super::segment`].
    pub fn remove_known(&mut self, cloud: &PointCloud, boxes: &[Obstacle], margin_m: f64, min_points: usize) {
        if boxes.is_empty() {
            return;
        }
        let is_known = |index: u32| {
            cloud.points.get(index as usize).is_some_and(|p| {
                boxes.iter().any(|b| {
                    let p_B = b.X_WB.inverse_transform_point(p);
                    p_B.iter().zip(b.size_m.iter()).all(|(x, size)| x.abs() <= size / 2.0 + margin_m)
                })
            })
        };
        let clusters = std::mem::take(&mut self.clusters);
        let mut kept = Vec::with_capacity(clusters.len());
        for cluster in clusters {
            let (known, mut rest): (Vec<u32>, Vec<u32>) = cluster.into_iter().partition(|index| is_known(*index));
            self.set_fates(&known, PointFate::KnownObstacle);
            if rest.len() < min_points {
                self.set_fates(&rest, PointFate::SmallCluster);
                rest.clear();
            }
            kept.push(rest);
        }
        kept.retain(|cluster| !cluster.is_empty());
        // A stable sort: clusters of equal size stay in the order that the segmentation chose.
        kept.sort_by_key(|cluster| std::cmp::Reverse(cluster.len()));
        for (number, cluster) in (0u16..).zip(&kept) {
            for index in cluster {
                if let Some(fate) = self.fates.get_mut(*index as usize) {
                    *fate = PointFate::Cluster(number);
                }
            }
        }
        self.clusters = kept;
    }

    fn set_fates(&mut self, indices: &[u32], fate: PointFate) {
        for index in indices {
            if let Some(slot) = self.fates.get_mut(*index as usize) {
                *slot = fate;
            }
        }
    }
}
