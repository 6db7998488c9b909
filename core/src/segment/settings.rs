//! Settings of the segmentation.

use serde::{Deserialize, Serialize};

use super::SegmentRefusal;

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

impl SegmentSettings {
    /// Refuses numbers that mean nothing.
    pub(super) fn check(&self) -> Result<(), SegmentRefusal> {
        let wrong = |setting, found: f64, wanted: String| Err(SegmentRefusal::Setting { setting, found, wanted });
        let positive = [
            ("plane_distance_m", self.plane_distance_m),
            ("cluster_distance_m", self.cluster_distance_m),
            ("max_height_m", self.max_height_m),
        ];
        for (setting, found) in positive {
            // Below a micrometre every point would be a cell of its own.
            if !(1e-6..=1e6).contains(&found) {
                return wrong(setting, found, String::from("1e-6 to 1e6"));
            }
        }
        if !(0.0..self.max_height_m).contains(&self.min_height_m) {
            return wrong("min_height_m", self.min_height_m, format!("0 to {} (max_height_m)", self.max_height_m));
        }
        if !(1..=100_000).contains(&self.plane_hypotheses) {
            return wrong("plane_hypotheses", f64::from(self.plane_hypotheses), String::from("1 to 100000"));
        }
        Ok(())
    }
}
