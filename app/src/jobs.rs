//! The native worker: one thread that runs requests, newest first, and can be stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use crate::assets;
use crate::clock::stopwatch;
use endcomfort_core::grasp::Quality;
use endcomfort_core::job::{ObjectiveFit, Output, Refusal, Request, Stage, Update};
use endcomfort_core::pipeline::Pipeline;
use endcomfort_core::watch::Watch;

/// A thread that runs the pipeline.
pub struct Worker {
    requests: Sender<(u64, Request)>,
    updates: Receiver<Update>,
    /// Number of the newest request; older ones see that it moved on and stop.
    newest: Arc<AtomicU64>,
}

impl Worker {
    /// Starts the thread; `wake` is called after every update.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let (requests, incoming) = channel::<(u64, Request)>();
        let (outgoing, updates) = channel();
        let newest = Arc::new(AtomicU64::new(0));
        let current = newest.clone();
        std::thread::Builder::new().name("pipeline".into()).spawn(move || {
            let mut pipeline = Pipeline::new(assets::library());
            for (number, request) in incoming {
                run(&mut pipeline, &request, &|| current.load(Ordering::Relaxed) != number, &mut |update| {
                    // The window is gone when nobody receives: nothing is left to tell.
                    let _ = outgoing.send(update);
                    wake();
                });
            }
        })?;
        Ok(Self { requests, updates, newest })
    }

    /// Starts a request; whatever still runs is stopped.
    pub fn submit(&self, request: Request) {
        let number = self.newest.fetch_add(1, Ordering::Relaxed) + 1;
        if self.requests.send((number, request)).is_err() {
            log::error!("the pipeline thread has ended");
        }
    }

    /// Stops whatever runs.
    pub fn cancel(&self) {
        self.newest.fetch_add(1, Ordering::Relaxed);
    }

    /// Takes the updates that arrived.
    pub fn poll(&self) -> Vec<Update> {
        self.updates.try_iter().collect()
    }
}

/// Runs one request on this thread and hands every update to `emit`, progress included.
pub fn run(
    pipeline: &mut Pipeline,
    request: &Request,
    should_stop: &(dyn Fn() -> bool + Sync),
    emit: &mut (dyn FnMut(Update) + Send),
) {
    let now_ms = stopwatch();
    pipeline.run(request, &Watch::new(should_stop, &|_, _| (), &now_ms), emit);
}

/// Runs a request on this thread until `last` is done; the outputs, and the refusal that ended it early.
pub fn run_as_far_as_possible(request: &Request, last: Stage) -> (Vec<Output>, Option<Refusal>) {
    let (mut outputs, mut refused) = (Vec::new(), None);
    let mut pipeline = Pipeline::new(assets::library());
    run(&mut pipeline, &Request { last, ..request.clone() }, &|| false, &mut |update| match update {
        Update::Done { output, .. } => match *output {
            Output::Quality(qualities) => outputs.iter_mut().for_each(|known| {
                if let Output::Rank(ranked) = known {
                    Quality::put_all(&qualities, &mut ranked.grasps);
                }
            }),
            output => outputs.push(output),
        },
        Update::Refused { refusal, .. } => refused = Some(refusal),
        Update::Progress { .. } | Update::Mapping { .. } | Update::Finished { .. } => {}
    });
    (outputs, refused)
}

/// Runs a request on this thread until a stage is done and gives all outputs.
///
/// # Errors
/// The refusal of the first stage that cannot be done.
pub fn run_until(request: &Request, last: Stage) -> Result<Vec<Output>, Refusal> {
    let (outputs, refused) = run_as_far_as_possible(request, last);
    refused.map_or(Ok(outputs), Err)
}

/// Fits the cluster of [`Request::compare`] with every objective, on this thread; each with its time in milliseconds.
///
/// # Errors
/// The refusal of the stage that cannot be done.
pub fn compare(request: &Request) -> Result<Vec<(f64, ObjectiveFit)>, Refusal> {
    let (mut rows, mut refused) = (Vec::new(), None);
    run(&mut Pipeline::new(assets::library()), request, &|| false, &mut |update| match update {
        Update::Done { elapsed_ms, output, .. } => {
            if let Output::Objective(row) = *output {
                rows.push((elapsed_ms, *row));
            }
        }
        Update::Refused { refusal, .. } => refused = Some(refusal),
        Update::Progress { .. } | Update::Mapping { .. } | Update::Finished { .. } => {}
    });
    refused.map_or(Ok(rows), Err)
}
