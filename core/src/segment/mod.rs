//! From a scene cloud to a table plane and the clusters that stand on it (thesis 3.5.1).

use nalgebra::{Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};

/// The plane `normal · p = offset_m`; for a table the normal points up, away from the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Unit normal.
    pub normal: Unit<Vector3<f64>>,
    /// Distance of the plane from the origin along the normal, metres.
    pub offset_m: f64,
}

impl Plane {
    /// Signed distance of a point, positive on the side of the normal, metres.
    pub fn height(&self, p: &Point3<f64>) -> f64 {
        self.normal.dot(&p.coords) - self.offset_m
    }
}

/// Settings of the segmentation; the defaults are the thesis's where it gives them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SegmentSettings {
    /// A point belongs to the table when it is this close to the plane, metres.
    pub plane_distance_m: f64,
    /// RANSAC hypotheses.
    pub plane_hypotheses: u32,
    /// A plane with fewer inliers is no table.
    pub plane_min_points: usize,
    /// Objects start this far above the plane, metres.
    pub min_height_m: f64,
    /// Points higher than this above the plane are dropped, metres.
    pub max_height_m: f64,
    /// Two points closer than this belong to one cluster, metres (3 cm in the thesis).
    pub cluster_distance_m: f64,
    /// A cluster with fewer points is dropped (300 in the thesis).
    pub cluster_min_points: usize,
}

impl Default for SegmentSettings {
    fn default() -> Self {
        Self {
            plane_distance_m: 0.010,
            plane_hypotheses: 400,
            plane_min_points: 300,
            min_height_m: 0.010,
            max_height_m: 0.50,
            cluster_distance_m: 0.03,
            cluster_min_points: 300,
        }
    }
}

/// What became of one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PointFate {
    /// On the table plane.
    Table,
    /// Part of the cluster with this index.
    Cluster(u16),
    /// Below the table plane.
    BelowTable,
    /// Within `min_height_m` of the plane, too low to tell from the table.
    TooLow,
    /// Higher above the table than `max_height_m`.
    TooHigh,
    /// Outside the outline of the table (a wall, the floor, a chair).
    OffTable,
    /// On an obstacle that the robot knows already.
    KnownObstacle,
    /// In a cluster smaller than `cluster_min_points`.
    SmallCluster,
}
