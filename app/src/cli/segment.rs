//! `segment`: table plane and clusters of a scene or a cloud.

use std::path::{Path, PathBuf};

use endcomfort_core::cloud::{PlyEncoding, PointCloud, read_cloud, write_ply};
use endcomfort_core::pipeline::synthetic_cloud;
use endcomfort_core::segment::{PointFate, SegmentSettings, segment};
use endcomfort_core::watch::Watch;
use serde_json::json;

use super::depth_options::DepthOptions;
use super::{Common, Failure, input};
use crate::assets;
use crate::clock::stopwatch;

#[derive(clap::Args)]
pub(super) struct Args {
    /// A demo, a scene file, a cloud file or a depth image (16-bit PNG).
    scene: String,
    #[command(flatten)]
    depth: DepthOptions,
    /// Folder that receives each cluster as a PLY file.
    #[arg(long)]
    out: Option<PathBuf>,
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let (cloud, settings, seed) = if input::is_scene(&args.scene) {
        args.depth.refuse_alone()?;
        let mut scene = input::scene(&args.scene)?;
        scene.seed = common.seed.unwrap_or(scene.seed);
        (synthetic_cloud(&scene, &assets::library())?, scene.segment, scene.seed)
    } else {
        let file = args.depth.cloud(Path::new(&args.scene))?;
        let loaded =
            read_cloud(&file.name, &file.bytes).map_err(|error| Failure::new(format!("{}: {error}", args.scene)))?;
        loaded.notes.iter().for_each(|note| eprintln!("{note}"));
        (loaded.value, SegmentSettings::default(), common.seed.unwrap_or(0))
    };
    let elapsed_ms = stopwatch();
    let found = segment(&cloud, &settings, seed, Watch::idle())
        .map_err(|refusal| Failure::new(format!("{}: {refusal}", args.scene)))?;
    let segment_ms = elapsed_ms();

    let count = |wanted: fn(&PointFate) -> bool| found.fates.iter().filter(|fate| wanted(fate)).count();
    let fates = json!({
        "table": count(|f| matches!(f, PointFate::Table)),
        "cluster": count(|f| matches!(f, PointFate::Cluster(_))),
        "below_table": count(|f| matches!(f, PointFate::BelowTable)),
        "too_low": count(|f| matches!(f, PointFate::TooLow)),
        "too_high": count(|f| matches!(f, PointFate::TooHigh)),
        "off_table": count(|f| matches!(f, PointFate::OffTable)),
        "known_obstacle": count(|f| matches!(f, PointFate::KnownObstacle)),
        "small_cluster": count(|f| matches!(f, PointFate::SmallCluster)),
    });
    let clusters: Vec<_> = found.clusters.iter().map(|indices| cluster_json(&cloud, indices)).collect();
    if common.json {
        println!(
            "{}",
            json!({
                "file": args.scene, "points": cloud.points.len(),
                "table": { "normal": found.table.normal.into_inner(), "offset_m": found.table.offset_m },
                "clusters": clusters, "fates": fates, "segment_ms": segment_ms,
            })
        );
    } else {
        println!("{}: {} points, {} clusters in {segment_ms:.1} ms", args.scene, cloud.points.len(), clusters.len());
        for (index, cluster) in clusters.iter().enumerate() {
            println!("  cluster {index}: {} points around {} m", cluster["points"], cluster["centroid_m"]);
        }
        println!("  points by fate: {fates}");
    }
    if let Some(folder) = &args.out {
        write_clusters(folder, &cloud, &found.clusters)?;
    }
    Ok(())
}

fn cluster_json(cloud: &PointCloud, indices: &[u32]) -> serde_json::Value {
    let (mut low, mut high, mut sum) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], [0.0; 3]);
    for p in indices.iter().map(|&i| &cloud.points[i as usize]) {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
            sum[axis] += p[axis];
        }
    }
    let centroid = sum.map(|s| s / indices.len().max(1) as f64);
    json!({ "points": indices.len(), "centroid_m": centroid, "min_m": low, "max_m": high })
}

fn write_clusters(folder: &Path, cloud: &PointCloud, clusters: &[Vec<u32>]) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::new(format!("{}: {error}", folder.display()));
    std::fs::create_dir_all(folder).map_err(failed)?;
    for (index, indices) in clusters.iter().enumerate() {
        let path = folder.join(format!("cluster_{index}.ply"));
        std::fs::write(&path, write_ply(&cloud.subset(indices), PlyEncoding::LittleEndian)).map_err(failed)?;
        eprintln!("wrote {}", path.display());
    }
    Ok(())
}
