//! How soon the worker answers when a computation is stopped.
//!
//! `cargo bench -p endcomfort --bench cancel`. Each request is started and stopped after a time drawn evenly from its
//! own whole length, so that every stage is met; the time from the stop to the last update of the worker is measured.
//! (In the browser the page ends its worker instead, which takes no longer than a frame.)
#![allow(non_snake_case, reason = "frame letters")]

#[path = "../../core/benches/common/report.rs"]
mod report;

use std::error::Error;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use endcomfort::assets;
use endcomfort::jobs::Worker;
use endcomfort_core::job::{MapMethod, MapRequest, Request, Update};
use endcomfort_core::rng::Rng;
use report::{Report, now_ms};

const SEED: u64 = 1;
const STOPS: usize = 40;

fn main() -> Result<(), Box<dyn Error>> {
    let mut report = Report::new("cancel", SEED);
    let demo = |name: &str| assets::demo(name).ok_or_else(|| format!("no demo {name:?}"));
    let map = |orientations: usize| MapRequest {
        arms: vec!["left".to_owned(), "right".to_owned()],
        torso: false,
        voxel_m: 0.05,
        orientations,
        method: MapMethod::Inverse,
    };
    let requests = [
        ("plan of jar", Request::new(demo("jar")?)),
        ("plan of butler", Request::new(demo("butler")?)),
        ("maps, 40 orientations", Request { map: Some(map(40)), ..Request::new(demo("jar")?) }),
        ("maps, 272 orientations", Request { map: Some(map(272)), ..Request::new(demo("jar")?) }),
    ];
    for (name, request) in requests {
        let (whole_ms, answers_ms) = measure(&request)?;
        let checked = format!("{whole_ms:.0} ms when not stopped");
        report.add(name, "stopped → answered", "ms", answers_ms, checked);
    }
    report.print();
    Ok(())
}

/// How long the request takes, and how long after each stop its end was told, milliseconds.
fn measure(request: &Request) -> Result<(f64, Vec<f64>), Box<dyn Error>> {
    let (woken, wakes) = channel();
    let worker = Worker::start(move || {
        let _ = woken.send(());
    })?;
    let mut rng = Rng::new(SEED, 0);
    let begin_ms = now_ms();
    worker.submit(Request { revision: 0, ..request.clone() });
    wait_for_end(&worker, &wakes, 0)?;
    let whole_ms = now_ms() - begin_ms;
    let mut answers_ms = Vec::new();
    for revision in 1..=STOPS as u64 {
        worker.submit(Request { revision, ..request.clone() });
        std::thread::sleep(Duration::from_secs_f64(1e-3 * rng.uniform(0.0, whole_ms)));
        let stop_ms = now_ms();
        worker.cancel();
        wait_for_end(&worker, &wakes, revision)?;
        answers_ms.push(now_ms() - stop_ms);
    }
    Ok((whole_ms, answers_ms))
}

fn wait_for_end(worker: &Worker, wakes: &Receiver<()>, wanted: u64) -> Result<(), Box<dyn Error>> {
    loop {
        wakes.recv_timeout(Duration::from_secs(60))?;
        if worker.poll().iter().any(|update| matches!(update, Update::Finished { revision } if *revision == wanted)) {
            return Ok(());
        }
    }
}
