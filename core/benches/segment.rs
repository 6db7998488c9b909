//! Segmentation of a 640 × 480 organised cloud with a table and eight objects.
//!
//! `cargo bench -p endcomfort-core --bench segment [-- FOLDER]`, FOLDER holding `depth.u16` (0.1 mm per step, 0 for none)
//! and `label.u8` (truth per pixel: 255 none, 0 table, 1… objects); f = 525 px. Reading and back-projection are not
//! timed; an answer that misses an object fails the bench.

#[path = "common/report.rs"]
mod report;
#[path = "common/workload.rs"]
mod workload;

use std::error::Error;
use std::sync::Mutex;

use endcomfort_core::cloud::{PixelGrid, PointCloud};
use endcomfort_core::segment::{SegmentSettings, Segmentation, segment};
use endcomfort_core::watch::Watch;
use nalgebra::{Isometry3, Point3};
use report::{Report, now_ms};

const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;
const FOCAL_PX: f64 = 525.0;
const RUNS: usize = 60;
/// Runs that only warm the caches.
const WARM_UP: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = workload::folder("seg", "depth.u16") else { return Ok(()) };
    let (depth, label) = (std::fs::read(folder.join("depth.u16"))?, std::fs::read(folder.join("label.u8"))?);
    if depth.len() != 2 * label.len() || label.len() != (WIDTH * HEIGHT) as usize {
        let wanted = "wanted depth.u16 of 614400 bytes and label.u8 of 307200 bytes";
        return Err(format!("{}: {wanted}", folder.display()).into());
    }
    let (cloud, truth) = back_project(&depth, &label);
    let settings = SegmentSettings::default();
    let mut times_ms = Vec::with_capacity(RUNS);
    let stages: Mutex<Vec<(String, Vec<f64>)>> = Mutex::new(Vec::new());
    let mut last = None;
    for run in 0..RUNS + WARM_UP {
        let begin_ms = now_ms();
        let reached = |_: f64, note: &str| {
            let (Ok(mut stages), true) = (stages.lock(), run >= WARM_UP) else { return };
            let at_ms = now_ms() - begin_ms;
            match stages.iter_mut().find(|(name, _)| name == note) {
                Some((_, times)) => times.push(at_ms),
                None => stages.push((note.to_owned(), vec![at_ms])),
            }
        };
        let found = segment(&cloud, &settings, run as u64, Watch::new(&|| false, &reached, &|| 0.0))?;
        if run >= WARM_UP {
            times_ms.push(now_ms() - begin_ms);
        }
        last = Some(found);
    }
    let ious = last.as_ref().map(|found| ious(found, &truth)).unwrap_or_default();
    let clusters = last.as_ref().map_or(0, |found| found.clusters.len());
    let worst = ious.iter().copied().fold(1.0, f64::min);
    let mut report = Report::new("segment", format!("{WARM_UP}..{}", RUNS + WARM_UP));
    let problem = format!("640 × 480, {} points, table and 8 objects", cloud.points.len());
    for (stage, at_ms) in stages.into_inner().unwrap_or_default() {
        report.add(&problem, format!("until {stage}"), "ms", at_ms, "");
    }
    report.add(&problem, "all", "ms", times_ms, format!("{clusters} clusters, worst overlap {worst:.2}"));
    report.print();
    // Points lower than 1 cm belong to the table by the settings; of the smallest object here they are a quarter.
    if clusters == 8 && worst > 0.7 { Ok(()) } else { Err(format!("overlap with each object: {ious:?}").into()) }
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
