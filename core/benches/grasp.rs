//! From a fit to ranked grasps on the bundled demos: candidates, IK sets at start and goal, collision filter, order.
//!
//! `cargo bench -p endcomfort-core --bench grasp`. The density is chosen per demo so that there are at least 500
//! candidates. Cloud, segmentation and fit are computed once and not timed; neither are the qualities (success under
//! noise, wrench volume), which the program tells after the plan and which have lines of their own. A demo without ten
//! accepted grasps at its own density, or whose answer changes from run to run, fails the bench.
#![allow(non_snake_case, reason = "frame letters")]

#[path = "common/report.rs"]
mod report;

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use endcomfort_core::job::{Output, Request, Stage, Update};
use endcomfort_core::library::Library;
use endcomfort_core::parallel::on_one_thread;
use endcomfort_core::pipeline::Pipeline;
use endcomfort_core::scene::Scene;
use endcomfort_core::watch::Watch;
use report::{Report, now_ms};

const RUNS: usize = 12;
/// Runs that only warm the caches.
const WARM_UP: usize = 2;
/// Demos and the densities that give them 500 candidates.
const DEMOS: [(&str, u32); 3] = [("mustard", 16), ("jar", 13), ("glass", 13)];

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let files = root.clone();
    let library = Arc::new(Library::new(Box::new(move |path: &str| {
        std::fs::read(files.join(path)).ok().map(|bytes| &*bytes.leak())
    })));
    let mut report = Report::new("grasp", "of each demo");
    for (demo, density) in DEMOS {
        let mut scene = Scene::parse(&std::fs::read_to_string(root.join(format!("objects/scenes/{demo}.json")))?)?;
        scene.grasp.density = density;
        for (threads, is_serial) in [("all threads", false), ("one thread", true)] {
            let measure = || measure(&library, &scene);
            let measured = if is_serial { on_one_thread(measure) } else { measure() }?;
            let Measured { candidates, accepted, grasps_ms, rank_ms, both_ms, quality_ms } = measured;
            let problem = format!("{demo}, {candidates} candidates, {threads}");
            report.add(&problem, "candidates, closed", "ms", grasps_ms, "");
            report.add(&problem, "IK sets, filter, order", "ms", rank_ms, format!("{accepted} accepted"));
            report.add(&problem, "fit → ranked", "ms", both_ms, "same answer every run");
            report.add(&problem, "qualities afterwards", "ms", quality_ms, "");
        }
    }
    report.print();
    Ok(())
}

#[derive(Default)]
struct Measured {
    candidates: usize,
    accepted: usize,
    grasps_ms: Vec<f64>,
    rank_ms: Vec<f64>,
    both_ms: Vec<f64>,
    quality_ms: Vec<f64>,
}

fn measure(library: &Arc<Library>, scene: &Scene) -> Result<Measured, String> {
    let mut pipeline = Pipeline::new(library.clone());
    let mut measured = Measured::default();
    let mut answer = None;
    for run in 0..RUNS + WARM_UP {
        // A noise that the ranking does not look at: what was computed for the last run does not answer this one.
        let mut scene = scene.clone();
        scene.grasp.noise.position_m += f64::from(run as u32) * 1e-12;
        let request = Request { last: Stage::Rank, ..Request::new(scene) };
        let (mut times, mut refused, mut ranked) = ([0.0; 3], None, None);
        pipeline.run(&request, &Watch::new(&|| false, &|_, _| (), &now_ms), &mut |update| match update {
            Update::Done { elapsed_ms, output, .. } => match *output {
                Output::Grasps(grasps) => (times[0], measured.candidates) = (elapsed_ms, grasps.grasps.len()),
                Output::Rank(rank) => {
                    (times[1], measured.accepted) = (elapsed_ms, rank.accepted);
                    ranked = Some(rank.grasps.iter().map(|grasp| grasp.id).collect::<Vec<_>>());
                }
                Output::Quality(_) => times[2] = elapsed_ms,
                _ => {}
            },
            Update::Refused { refusal, .. } => refused = Some(refusal.message),
            _ => {}
        });
        if let Some(message) = refused {
            return Err(format!("{}: {message}", request.scene.name));
        }
        if answer.get_or_insert_with(|| ranked.clone()) != &ranked {
            return Err(format!("{}: another order in run {run}", request.scene.name));
        }
        if run >= WARM_UP {
            measured.grasps_ms.push(times[0]);
            measured.rank_ms.push(times[1]);
            measured.both_ms.push(times[0] + times[1]);
            measured.quality_ms.push(times[2]);
        }
    }
    if measured.accepted < 10 {
        return Err(format!("{}: {} grasps accepted, wanted 10", scene.name, measured.accepted));
    }
    Ok(measured)
}
