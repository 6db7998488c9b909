//! The whole way from a cloud to a table, clusters and the fate of every point.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::cluster::link;
use super::outline::Outline;
use super::ransac::largest_plane;
use super::{Plane, SegmentSettings};
use crate::cloud::PointCloud;
use crate::watch::Watch;

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
    /// In a cluster smaller than `cluster_min_points`.
    SmallCluster,
    /// On a box that the robot knows about.
    KnownObstacle,
}

/// A table and what stands on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segmentation {
    /// The table plane in the frame of the cloud, its normal pointing up.
    pub table: Plane,
    /// Corners of the convex outline of the table, counter-clockwise seen from above.
    pub outline: Vec<Point3<f64>>,
    /// Points with the fate [`PointFate::Table`].
    pub table_points: usize,
    /// Root mean square distance of the table's points to the plane, metres.
    pub table_rms_m: f64,
    /// Fate of each point.
    pub fates: Vec<PointFate>,
    /// Indices of the points of each cluster, ascending; largest cluster first.
    pub clusters: Vec<Vec<u32>>,
}

/// Why a cloud has no table with objects.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SegmentRefusal {
    /// There is nothing to segment.
    #[error("the cloud has no points")]
    NoPoints,
    /// A setting has a value that means nothing.
    #[error("setting {setting}: found {found}, wanted {wanted}")]
    Setting { setting: &'static str, found: f64, wanted: String },
    /// No plane has enough points.
    #[error("no table: the best plane has {found} points within {:.0} mm, wanted {wanted}", distance_m * 1e3)]
    NoPlane { found: usize, wanted: usize, distance_m: f64 },
    /// The table is empty.
    #[error(
        "nothing stands on the table: {above} points above it, the largest cluster has {largest}, wanted {wanted} \
         (the table has {table} points)"
    )]
    NothingOnTable { table: usize, above: usize, largest: usize, wanted: usize },
    /// Somebody pressed cancel.
    #[error("the segmentation was stopped")]
    Stopped,
}

/// Finds the table, the clusters on it and the fate of every point.
///
/// The table is the plane with the most points (RANSAC, then least squares). Its normal points to the sensor; when the
/// cloud does not know its sensor, to the side on which more points stand, and up (+z) when that does not decide.
/// Points above the plane, within its outline, that are within `cluster_distance_m` of each other form clusters.
///
/// * `seed`: seed of the hypotheses; any seed finds any table that has a tenth of the points.
///
/// # Errors
/// [`SegmentRefusal`] when there is no plane, nothing on it, or a setting is meaningless.
pub fn segment(
    cloud: &PointCloud,
    settings: &SegmentSettings,
    seed: u64,
    watch: Watch<'_>,
) -> Result<Segmentation, SegmentRefusal> {
    settings.check()?;
    if cloud.points.is_empty() {
        return Err(SegmentRefusal::NoPoints);
    }
    let no_plane = |found| SegmentRefusal::NoPlane {
        found,
        wanted: settings.plane_min_points,
        distance_m: settings.plane_distance_m,
    };
    let found = largest_plane(&cloud.points, settings, seed).ok_or_else(|| no_plane(0))?;
    if found.inliers < settings.plane_min_points {
        return Err(no_plane(found.inliers));
    }
    go_on(watch, 0.3, "table plane")?;

    let mut table = found.plane;
    // What stands on the rim may lean over it by as much as the plane is thick.
    let distance = settings.plane_distance_m;
    let mut edge = Outline::new(&table, &found.sample, &cloud.points, distance, distance)
        .ok_or_else(|| no_plane(found.inliers))?;
    if !faces_up(&table, cloud, settings, &edge) {
        table = table.flipped();
        edge.flip();
    }
    go_on(watch, 0.5, "table outline")?;

    let mut standing = Standing::default();
    let mut table_points = 0;
    let mut fates = Vec::with_capacity(cloud.points.len());
    for (index, p) in (0u32..).zip(&cloud.points) {
        let fate = fate(p, &table, settings, &edge);
        match fate {
            // The number is not known yet.
            PointFate::Cluster(_) => standing.push(p, index),
            PointFate::Table => table_points += 1,
            _ => {}
        }
        fates.push(fate);
    }
    go_on(watch, 0.7, "points above the table")?;

    let labels = link(&standing.points, settings.cluster_distance_m);
    let (clusters, largest) = standing.clusters(&labels, settings.cluster_min_points);
    for index in &standing.indices {
        if let Some(fate) = fates.get_mut(*index as usize) {
            *fate = PointFate::SmallCluster;
        }
    }
    for (number, cluster) in (0u16..).zip(&clusters) {
        for index in cluster {
            if let Some(fate) = fates.get_mut(*index as usize) {
                *fate = PointFate::Cluster(number);
            }
        }
    }
    go_on(watch, 1.0, "clusters")?;
    if clusters.is_empty() {
        return Err(SegmentRefusal::NothingOnTable {
            table: table_points,
            above: standing.points.len(),
            largest,
            wanted: settings.cluster_min_points,
        });
    }
    Ok(Segmentation { table, outline: edge.corners(), table_points, table_rms_m: found.rms_m, fates, clusters })
}

fn go_on(watch: Watch<'_>, fraction: f64, note: &str) -> Result<(), SegmentRefusal> {
    if watch.should_stop() {
        return Err(SegmentRefusal::Stopped);
    }
    watch.progress(fraction, note);
    Ok(())
}

/// What a point is, before clusters are known: those that may belong to one get `Cluster(0)`.
fn fate(p: &Point3<f64>, table: &Plane, settings: &SegmentSettings, edge: &Outline) -> PointFate {
    let height = table.height(p);
    if height < -settings.plane_distance_m {
        PointFate::BelowTable
    } else if !edge.contains(p) {
        PointFate::OffTable
    } else if height <= settings.plane_distance_m {
        PointFate::Table
    } else if height < settings.min_height_m {
        PointFate::TooLow
    } else if height > settings.max_height_m {
        PointFate::TooHigh
    } else {
        PointFate::Cluster(0)
    }
}

/// Whether the plane's normal points to the side on which things stand.
fn faces_up(table: &Plane, cloud: &PointCloud, settings: &SegmentSettings, edge: &Outline) -> bool {
    if let Some(X_FC) = &cloud.X_FC {
        return table.height(&Point3::from(X_FC.translation.vector)) >= 0.0;
    }
    let band = settings.min_height_m.max(settings.plane_distance_m)..=settings.max_height_m;
    let (mut above, mut below) = (0u64, 0u64);
    for p in &cloud.points {
        let height = table.height(p);
        if band.contains(&height.abs()) && edge.contains(p) {
            *(if height > 0.0 { &mut above } else { &mut below }) += 1;
        }
    }
    // Noise alone gives both sides a few points.
    if above.max(below) > 2 * above.min(below) { above > below } else { table.normal.z >= 0.0 }
}

/// The points that stand on the table.
#[derive(Default)]
struct Standing {
    points: Vec<Point3<f64>>,
    indices: Vec<u32>,
}

impl Standing {
    fn push(&mut self, p: &Point3<f64>, index: u32) {
        self.points.push(*p);
        self.indices.push(index);
    }

    /// The clusters with enough points, largest first, and the size of the largest of all.
    fn clusters(&self, labels: &[u32], min_points: usize) -> (Vec<Vec<u32>>, usize) {
        let count = labels.iter().max().map_or(0, |most| *most as usize + 1);
        let mut sizes = vec![0usize; count];
        for label in labels {
            sizes[*label as usize] += 1;
        }
        let largest = sizes.iter().copied().max().unwrap_or(0);
        let mut clusters: Vec<Vec<u32>> =
            sizes.iter().map(|size| Vec::with_capacity(if *size >= min_points { *size } else { 0 })).collect();
        // Equal sizes are ordered by the least point, so that the order of the points in the file does not matter.
        let mut least: Vec<Point3<f64>> = vec![Point3::from([f64::INFINITY; 3]); count];
        for ((label, index), p) in labels.iter().zip(&self.indices).zip(&self.points) {
            let label = *label as usize;
            if sizes[label] >= min_points {
                clusters[label].push(*index);
                if (p.x, p.y, p.z) < (least[label].x, least[label].y, least[label].z) {
                    least[label] = *p;
                }
            }
        }
        let mut ranked: Vec<(Point3<f64>, Vec<u32>)> =
            least.into_iter().zip(clusters).filter(|(_, cluster)| !cluster.is_empty()).collect();
        ranked.sort_by(|(p, a), (q, b)| {
            b.len()
                .cmp(&a.len())
                .then_with(|| p.x.total_cmp(&q.x))
                .then_with(|| p.y.total_cmp(&q.y))
                .then_with(|| p.z.total_cmp(&q.z))
        });
        // Fates number clusters with 16 bits; what comes after is smaller than 65 535 others.
        ranked.truncate(usize::from(u16::MAX));
        (ranked.into_iter().map(|(_, cluster)| cluster).collect(), largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use nalgebra::{Isometry3, Vector3};
    use proptest::prelude::*;

    /// A table of 1 m × 0.6 m at z = 0 with 1 mm of noise, a floor 0.7 m below it, a wall behind it, and two objects of
    /// 8 cm × 8 cm × 12 cm (600 and 400 points) with 5 cm between them.
    fn scene(seed: u64) -> PointCloud {
        let mut rng = Rng::new(seed, 0);
        let mut points = Vec::new();
        for _ in 0..4000 {
            points.push(Point3::new(rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3), 0.001 * rng.normal()));
        }
        for _ in 0..1000 {
            points.push(Point3::new(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), -0.7));
            points.push(Point3::new(rng.uniform(-1.0, 1.0), 1.0, rng.uniform(-0.7, 0.8)));
        }
        for (count, x) in [(600, -0.13), (400, 0.0)] {
            for _ in 0..count {
                let (u, v) = (rng.uniform(0.0, 0.08), rng.uniform(0.0, 0.12));
                points.push(Point3::new(x + u, rng.uniform(0.0, 0.08), v));
            }
        }
        PointCloud { points, colors: Vec::new(), grid: None, X_FC: None }
    }

    fn run(cloud: &PointCloud) -> Result<Segmentation, SegmentRefusal> {
        segment(cloud, &SegmentSettings::default(), 1, Watch::idle())
    }

    #[test]
    fn objects_table_floor_and_wall_get_their_fates() {
        let found = run(&scene(1)).unwrap();
        let count = |fate| found.fates.iter().filter(|f| **f == fate).count();
        // A twelfth of each object is lower than 1 cm.
        assert_eq!(found.clusters.len(), 2);
        assert!((540..560).contains(&found.clusters[0].len()) && (350..380).contains(&found.clusters[1].len()));
        assert!((4000..4200).contains(&count(PointFate::Table)) && found.table_points == count(PointFate::Table));
        assert!(count(PointFate::BelowTable) > 1300 && count(PointFate::OffTable) > 400);
        assert!(found.table.normal.z > 0.9999 && found.table.offset_m.abs() < 5e-4);
        // The objects' lowest centimetre, some 80 points, adds 0.3 mm to the noise.
        assert!((found.table_rms_m - 0.0013).abs() < 1e-4, "{}", found.table_rms_m);
        assert!(found.outline.iter().all(|c| c.x.abs() < 0.51 && c.y.abs() < 0.31));
    }

    #[test]
    fn up_is_where_the_sensor_is_or_else_where_things_stand() {
        let mut cloud = scene(2);
        let turned = Isometry3::new(Vector3::zeros(), Vector3::x() * 3.0);
        let up = |cloud: &PointCloud| run(cloud).map(|found| found.table.normal.into_inner());
        assert!(up(&cloud.transformed(&turned)).unwrap().dot(&(turned.rotation * Vector3::z())) > 0.999);
        // Seen from below, the floor is what stands on the table, and it is too far away.
        cloud.X_FC = Some(Isometry3::translation(0.0, 0.0, -0.5));
        assert!(matches!(up(&cloud), Err(SegmentRefusal::NothingOnTable { wanted: 300, .. })));
    }

    #[test]
    fn refusals_say_what_was_found_and_what_was_wanted() {
        let mut cloud = scene(3);
        let settings = SegmentSettings { plane_min_points: 50_000, ..SegmentSettings::default() };
        let refusal = segment(&cloud, &settings, 1, Watch::idle()).unwrap_err();
        assert!(matches!(refusal, SegmentRefusal::NoPlane { found: 4000..4300, wanted: 50_000, .. }), "{refusal}");
        let settings = SegmentSettings { cluster_distance_m: f64::NAN, ..SegmentSettings::default() };
        let refusal = segment(&cloud, &settings, 1, Watch::idle()).unwrap_err();
        assert!(refusal.to_string().starts_with("setting cluster_distance_m: found NaN"), "{refusal}");
        let stop = Watch::new(&|| true, &|_, _| (), &|| 0.0);
        assert_eq!(segment(&cloud, &SegmentSettings::default(), 1, stop), Err(SegmentRefusal::Stopped));
        cloud.points.truncate(4000);
        assert!(matches!(run(&cloud), Err(SegmentRefusal::NothingOnTable { above: 0, largest: 0, .. })));
        cloud.points.clear();
        assert_eq!(run(&cloud), Err(SegmentRefusal::NoPoints));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn a_permuted_cloud_gives_the_same_fates(seed in 0u64..1000) {
            let cloud = scene(seed);
            let mut rng = Rng::new(seed, 7);
            let mut order: Vec<u32> = (0..cloud.points.len() as u32).collect();
            for k in (1..order.len()).rev() {
                order.swap(k, rng.index(k + 1));
            }
            let (found, permuted) = (run(&cloud).unwrap(), run(&cloud.subset(&order)).unwrap());
            prop_assert_eq!(found.table, permuted.table);
            for (place, original) in order.iter().enumerate() {
                prop_assert_eq!(permuted.fates[place], found.fates[*original as usize]);
            }
        }

        #[test]
        fn wild_numbers_are_refused_or_segmented_but_never_panic(
            points in prop::collection::vec(prop::array::uniform3(prop_oneof![
                -1.0f64..1.0, Just(0.0), Just(1e-300), Just(1e7), Just(-1e200), Just(f64::MAX),
            ]).prop_map(Point3::from), 0..80),
        ) {
            let cloud = PointCloud { points, colors: Vec::new(), grid: None, X_FC: None };
            let settings = SegmentSettings { plane_min_points: 3, cluster_min_points: 1, ..SegmentSettings::default() };
            if let Ok(found) = segment(&cloud, &settings, 1, Watch::idle()) {
                prop_assert_eq!(found.fates.len(), cloud.points.len());
            }
        }
    }
}
