//! Times the segmentation of a 640 × 480 organised cloud and checks its answer; prints one JSON object.
//!
//! `cargo run --release -p endcomfort-core --example bench_segment -- DIR [RUNS]`, DIR holding `depth.u16` (0.1 mm per
//! step, 0 for none), `label.u8` (truth per pixel: 255 none, 0 table, 1… objects); f = 525 px. Reading and
//! back-projection are not timed; an answer that misses an object fails the bench.

use std::process::ExitCode;
use std::sync::Mutex;

use endcomfort_core::cloud::{PixelGrid, PointCloud};
use endcomfort_core::segment::{SegmentSettings, Segmentation, segment};
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Point3};

const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;
const FOCAL_PX: f64 = 525.0;

#[expect(clippy::disallowed_methods, reason = "a bench measures time, natively")]
fn now() -> std::time::Instant {
    std::time::Instant::now()
}

fn main() -> ExitCode {
    let mut args = std::env::args().skip(1);
    let Some(dir) = args.next() else {
        eprintln!("usage: bench_segment DIR [RUNS]");
        return ExitCode::from(2);
    };
    let runs: usize = args.next().and_then(|runs| runs.parse().ok()).unwrap_or(60).max(1);
    let (depth, label) = match (std::fs::read(format!("{dir}/depth.u16")), std::fs::read(format!("{dir}/label.u8"))) {
        (Ok(depth), Ok(label)) if depth.len() == 2 * label.len() && label.len() == (WIDTH * HEIGHT) as usize => {
            (depth, label)
        }
        _ => {
            eprintln!("{dir}: wanted depth.u16 of 614400 bytes and label.u8 of 307200 bytes");
            return ExitCode::FAILURE;
        }
    };
    let (cloud, truth) = back_project(&depth, &label);
    let settings = SegmentSettings::default();
    let mut times_ms = Vec::with_capacity(runs);
    let mut last = None;
    let stages: Mutex<Vec<(String, Vec<f64>)>> = Mutex::new(Vec::new());
    for run in 0..runs + 3 {
        let start = now();
        let reached = |_: f64, note: &str| {
            let Ok(mut stages) = stages.lock() else { return };
            let at = start.elapsed().as_secs_f64() * 1e3;
            match stages.iter_mut().find(|(name, _)| name == note) {
                Some((_, times)) => times.push(at),
                None => stages.push((note.to_owned(), vec![at])),
            }
        };
        let result = segment(&cloud, &settings, run as u64, Watch::new(&|| false, &reached, &|| 0.0));
        let elapsed_ms = start.elapsed().as_secs_f64() * 1e3;
        // The first three warm the caches.
        if run >= 3 {
            times_ms.push(elapsed_ms);
        }
        match result {
            Ok(segmentation) => last = Some(segmentation),
            Err(refusal) => {
                eprintln!("{refusal}");
                return ExitCode::FAILURE;
            }
        }
    }
    times_ms.sort_by(f64::total_cmp);
    let at = |part: f64| times_ms[((times_ms.len() as f64 * part) as usize).min(times_ms.len() - 1)];
    let reached_ms: Vec<(String, f64)> = (stages.into_inner().unwrap_or_default().into_iter())
        .map(|(name, mut times)| {
            times.sort_by(f64::total_cmp);
            (name, times[0])
        })
        .collect();
    let ious = last.as_ref().map(|segmentation| ious(segmentation, &truth)).unwrap_or_default();
    let clusters = last.as_ref().map_or(0, |segmentation| segmentation.clusters.len());
    println!(
        "{}",
        serde_json::json!({
            "bench": "segment", "problem": "640 x 480 organised, table and 8 objects", "points": cloud.points.len(),
            "seeds": format!("3..{}", runs + 3), "samples": times_ms.len(),
            "min_ms": at(0.0), "median_ms": at(0.5), "p75_ms": at(0.75), "p95_ms": at(0.95),
            "min_ms_until": reached_ms, "clusters": clusters, "iou_per_object": ious,
        })
    );
    // Points lower than 1 cm belong to the table by the settings; of the smallest object here they are a quarter.
    if clusters == 8 && ious.iter().all(|iou| *iou > 0.7) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn back_project(depth: &[u8], label: &[u8]) -> (PointCloud, Vec<u8>) {
    let mut cloud = PointCloud { points: vec![], colors: vec![], grid: None, X_FC: Some(Isometry3::identity()) };
    let mut pixels = Vec::new();
    let mut truth = Vec::new();
    for ((pixel, raw), label) in (0u32..).zip(depth.chunks_exact(2)).zip(label) {
        let z = f64::from(u16::from_le_bytes([raw[0], raw[1]])) * 1e-4;
        if z > 0.0 {
            let (u, v) = (f64::from(pixel % WIDTH), f64::from(pixel / WIDTH));
            let x = (u - (f64::from(WIDTH) - 1.0) / 2.0) / FOCAL_PX * z;
            let y = (v - (f64::from(HEIGHT) - 1.0) / 2.0) / FOCAL_PX * z;
            cloud.points.push(Point3::new(x, y, z));
            pixels.push(pixel);
            truth.push(*label);
        }
    }
    cloud.grid = Some(PixelGrid { width: WIDTH, height: HEIGHT, pixels });
    (cloud, truth)
}

/// Intersection over union of each true object with the cluster that covers most of it.
fn ious(segmentation: &Segmentation, truth: &[u8]) -> Vec<f64> {
    let objects = truth.iter().filter(|label| **label != 255).max().copied().unwrap_or(0);
    (1..=objects)
        .map(|object| {
            let size = truth.iter().filter(|label| **label == object).count();
            let best = segmentation.clusters.iter().map(|cluster| {
                let both = cluster.iter().filter(|index| truth.get(**index as usize) == Some(&object)).count();
                both as f64 / (size + cluster.len() - both) as f64
            });
            (best.fold(0.0, f64::max) * 1e3).round() / 1e3
        })
        .collect()
}
