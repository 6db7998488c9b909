//! Reachability maps of one arm: by inverse sampling, by forward sampling, and how right they are.
//!
//! `cargo bench -p endcomfort-core --bench reach`
#![allow(non_snake_case, reason = "frame letters")]

#[path = "common/report.rs"]
mod report;

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use endcomfort_core::library::Library;
use endcomfort_core::parallel::on_one_thread;
use endcomfort_core::reach::{ForwardSettings, InverseSettings, ReachMap, build_forward, build_inverse};
use endcomfort_core::robot::Robot;
use endcomfort_core::watch::Watch;
use report::{Report, now_ms};

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let library =
        Library::new(Box::new(move |path: &str| std::fs::read(root.join(path)).ok().map(|bytes| &*bytes.leak())));
    let crichton = library.robot("crichton")?;
    let mut report = Report::new("reach", 1);
    for orientations in [1, 40] {
        let settings = ForwardSettings { orientations, ..ForwardSettings::default() };
        let mut times = Vec::new();
        for _ in 0..5 {
            let begin = now_ms();
            let map = on_one_thread(|| build_forward(&crichton, 0, &settings, Watch::idle()))?;
            times.push(now_ms() - begin);
            if times.len() == 1 {
                println!("{} voxels {} poses", map.voxels().count(), map.reached_poses());
            }
        }
        report.add(format!("forward {orientations}"), "build", "ms", times, "");
    }
    for orientations in [40, 272] {
        let settings = InverseSettings { orientations, ..InverseSettings::default() };
        let mut times = Vec::new();
        for _ in 0..if orientations == 40 { 3 } else { 1 } {
            let begin = now_ms();
            let map = build_inverse(&crichton, 0, &settings, Watch::idle())?;
            times.push(now_ms() - begin);
            if times.len() == 1 {
                println!("{} voxels {} poses", map.voxels().count(), map.reached_poses());
            }
        }
        report.add(format!("inverse {orientations}"), "build", "ms", times, "");
    }
    report.print();
    Ok(())
}
