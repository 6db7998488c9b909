//! The cloud: what became of its points, and the clusters.

use endcomfort_core::job::SegmentOutput;
use endcomfort_core::segment::PointFate;
use nalgebra::Point3;

use super::Row;

const FATES: [&str; 8] =
    ["cluster", "table", "too_low", "below_table", "too_high", "off_table", "small_cluster", "known_obstacle"];

fn name(fate: PointFate) -> &'static str {
    match fate {
        PointFate::Cluster(_) => "cluster",
        PointFate::Table => "table",
        PointFate::TooLow => "too_low",
        PointFate::BelowTable => "below_table",
        PointFate::TooHigh => "too_high",
        PointFate::OffTable => "off_table",
        PointFate::SmallCluster => "small_cluster",
        PointFate::KnownObstacle => "known_obstacle",
    }
}

/// How many points met each fate, in the order of the panel.
pub(super) fn fates(segment: &SegmentOutput) -> Vec<Row> {
    let total = segment.fates.len().max(1) as f64;
    let row = |fate: &'static str| {
        let points = segment.fates.iter().filter(|found| name(**found) == fate).count();
        Row(vec![("fate", fate.into()), ("points", points.into()), ("share", (points as f64 / total).into())])
    };
    FATES.into_iter().map(row).collect()
}

/// Every cluster with the box around it, in the world.
pub(super) fn clusters(segment: &SegmentOutput) -> Vec<Row> {
    let row = |(cluster, points): (usize, &Vec<Point3<f64>>)| {
        let first = points.first().copied().unwrap_or_default();
        let (min, max) = points.iter().fold((first, first), |(min, max), p| (min.inf(p), max.sup(p)));
        let (center, size) = (nalgebra::center(&min, &max), max - min);
        Row(vec![
            ("cluster", cluster.into()),
            ("points", points.len().into()),
            ("is_target", (cluster == segment.target).into()),
            ("center_x_m", center.x.into()),
            ("center_y_m", center.y.into()),
            ("center_z_m", center.z.into()),
            ("size_x_m", size.x.into()),
            ("size_y_m", size.y.into()),
            ("size_z_m", size.z.into()),
        ])
    };
    segment.clusters.iter().enumerate().map(row).collect()
}
