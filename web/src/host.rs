//! The page around the interface: a worker that computes, downloads, and the status line.

use std::cell::RefCell;
use std::rc::Rc;

use eframe::egui;
use endcomfort::host::{Fetched, Host, Store};
use endcomfort_core::job::{Refusal, Request, Stage, Update};
use js_sys::{Array, ArrayBuffer, Uint8Array};
use wasm_bindgen::prelude::*;
use web_sys::{ErrorEvent, Event, HtmlAnchorElement, MessageEvent, Worker, WorkerOptions, WorkerType};

use crate::store::LocalStore;
use crate::{dom, wire};

/// The browser as a [`Host`].
///
/// There is one worker at a time. A worker that has finished is used again, because it remembers the stages of its
/// last request; one that is still computing cannot be interrupted, so it is ended and a new one takes its place.
pub(crate) struct WebHost {
    context: egui::Context,
    backend: &'static str,
    /// The compiled module: a new worker starts without compiling it again.
    module: JsValue,
    worker_url: String,
    desk: Rc<RefCell<Desk>>,
    worker: Option<Hired>,
    store: LocalStore,
}

/// What page and worker's callbacks share.
#[derive(Default)]
struct Desk {
    updates: Vec<Update>,
    state: WorkerState,
    /// Revision of the request that is being computed.
    running: Option<u64>,
    /// Its stage, as far as is known.
    stage: Option<Stage>,
}

#[derive(Default)]
enum WorkerState {
    /// It loads; the request it will be given waits here.
    #[default]
    Starting,
    StartingWith(Uint8Array),
    Ready,
    /// It met a fault and is of no use any more.
    Broken,
}

/// A running worker with the callbacks that live as long as it does.
struct Hired {
    worker: Worker,
    _on_message: Closure<dyn FnMut(MessageEvent)>,
    _on_error: Closure<dyn FnMut(Event)>,
}

impl Drop for Hired {
    fn drop(&mut self) {
        // First the callbacks, so that no message on its way meets a closure that is gone.
        self.worker.set_onmessage(None);
        self.worker.set_onerror(None);
        self.worker.terminate();
    }
}

impl WebHost {
    /// A host whose first worker starts at once.
    pub(crate) fn new(context: egui::Context, backend: &'static str, module: JsValue, worker_url: String) -> Self {
        let mut host =
            Self { context, backend, module, worker_url, desk: Rc::default(), worker: None, store: LocalStore };
        host.hire();
        host
    }

    /// Ends the worker, if there is one, and starts another.
    fn hire(&mut self) {
        self.worker = None;
        // A new desk: whatever the last worker's callbacks might still say goes nowhere.
        let updates = std::mem::take(&mut self.desk.borrow_mut().updates);
        self.desk = Rc::new(RefCell::new(Desk { updates, ..Desk::default() }));
        match self.try_hire() {
            Ok(worker) => self.worker = Some(worker),
            Err(error) => {
                log::warn!("no worker: {error:?}");
                self.desk.borrow_mut().state = WorkerState::Broken;
            }
        }
    }

    fn try_hire(&self) -> Result<Hired, JsValue> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = Worker::new_with_options(&self.worker_url, &options)?;

        let (desk, context, sender) = (Rc::clone(&self.desk), self.context.clone(), worker.clone());
        let on_message = Closure::new(move |event: MessageEvent| {
            desk.borrow_mut().receive(&event.data(), &sender);
            context.request_repaint();
        });
        let (desk, context) = (Rc::clone(&self.desk), self.context.clone());
        let on_error = Closure::new(move |event: Event| {
            event.prevent_default();
            // A trap comes with a message; a file that did not arrive comes as a bare event without one.
            let message = event.dyn_ref::<ErrorEvent>().map(ErrorEvent::message);
            let cause = message.as_deref().unwrap_or("the worker’s files could not be loaded");
            desk.borrow_mut().fail(cause);
            context.request_repaint();
        });
        worker.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
        worker.set_onerror(Some(on_error.as_ref().unchecked_ref()));
        worker.post_message(&self.module)?;
        Ok(Hired { worker, _on_message: on_message, _on_error: on_error })
    }
}

impl Desk {
    /// Takes what the worker sent: an update as bytes, `ready`, or a sentence about a fault.
    fn receive(&mut self, data: &JsValue, worker: &Worker) {
        if let Some(buffer) = data.dyn_ref::<ArrayBuffer>() {
            match wire::from_bytes(&Uint8Array::new(buffer).to_vec()) {
                Ok(update) => self.take(update),
                Err(error) => self.fail(&error.to_string()),
            }
        } else if data.as_string().as_deref() == Some("ready") {
            if let WorkerState::StartingWith(request) = std::mem::replace(&mut self.state, WorkerState::Ready)
                && let Err(error) = post(worker, &request)
            {
                self.fail(&format!("{error:?}"));
            }
        } else {
            self.fail(&data.as_string().unwrap_or_else(|| format!("{data:?}")));
        }
    }

    fn take(&mut self, update: Update) {
        match &update {
            Update::Progress { stage, .. } => self.stage = Some(*stage),
            Update::Finished { revision } if self.running == Some(*revision) => self.running = None,
            Update::Done { .. } | Update::Mapping { .. } | Update::Refused { .. } | Update::Finished { .. } => {}
        }
        self.updates.push(update);
    }

    /// The worker cannot go on: its request, if it has one, is refused with the reason.
    fn fail(&mut self, cause: &str) {
        self.state = WorkerState::Broken;
        if let Some(revision) = self.running.take() {
            let refusal = Refusal::new(
                "The computation stopped because of a fault in the program. The scene is unchanged; change a setting \
                 or choose another demo to try again.",
            )
            .with_details(vec![cause.to_owned()]);
            self.updates.push(Update::Refused { revision, stage: self.stage.unwrap_or(Stage::Scene), refusal });
            self.updates.push(Update::Finished { revision });
        }
    }
}

/// Hands the bytes over without copying them.
fn post(worker: &Worker, request: &Uint8Array) -> Result<(), JsValue> {
    let buffer = request.buffer();
    worker.post_message_with_transfer(&buffer, &Array::of1(&buffer))
}

impl Host for WebHost {
    fn submit(&mut self, request: Request) {
        let is_usable = {
            let desk = self.desk.borrow();
            desk.running.is_none() && !matches!(desk.state, WorkerState::Broken)
        };
        if !is_usable {
            self.hire();
        }
        let mut desk = self.desk.borrow_mut();
        desk.running = Some(request.revision);
        desk.stage = None;
        let bytes = match wire::to_bytes(&request) {
            Ok(bytes) => Uint8Array::from(bytes.as_slice()),
            Err(error) => return desk.fail(&error.to_string()),
        };
        match (&desk.state, &self.worker) {
            (WorkerState::Starting | WorkerState::StartingWith(_), _) => desk.state = WorkerState::StartingWith(bytes),
            (WorkerState::Ready, Some(hired)) => {
                if let Err(error) = post(&hired.worker, &bytes) {
                    desk.fail(&format!("{error:?}"));
                }
            }
            (WorkerState::Broken, _) | (_, None) => desk.fail("the browser starts no worker for this page"),
        }
    }

    fn cancel(&mut self) {
        let running = self.desk.borrow_mut().running.take();
        if let Some(revision) = running {
            self.hire();
            self.desk.borrow_mut().updates.push(Update::Finished { revision });
        }
    }

    fn poll(&mut self) -> Vec<Update> {
        std::mem::take(&mut self.desk.borrow_mut().updates)
    }

    fn fetch(&mut self, path: &str, done: Fetched) {
        let path = path.to_owned();
        wasm_bindgen_futures::spawn_local(async move { done(dom::fetch(&path).await) });
    }

    fn save(&mut self, name: &str, bytes: &[u8]) -> String {
        match download(name, bytes) {
            Ok(()) => format!("Saved {name} among this browser’s downloads."),
            Err(error) => format!("The browser would not save {name}: {error:?}"),
        }
    }

    fn announce(&mut self, sentence: &str) {
        dom::announce(sentence);
    }

    fn page(&self) -> String {
        dom::page().unwrap_or_default()
    }

    fn store(&mut self) -> Option<&mut dyn Store> {
        Some(&mut self.store)
    }

    fn pick(&mut self) {
        dom::tell("endcomfort-pick", "");
    }

    fn tell(&mut self, event: &serde_json::Value) {
        dom::tell("endcomfort", &event.to_string());
    }

    fn backend(&self) -> String {
        self.backend.to_owned()
    }
}

fn download(name: &str, bytes: &[u8]) -> Result<(), JsValue> {
    let blob = web_sys::Blob::new_with_u8_array_sequence(&Array::of1(&Uint8Array::from(bytes)))?;
    let url = web_sys::Url::create_object_url_with_blob(&blob)?;
    let document = dom::document().ok_or("no document")?;
    let link: HtmlAnchorElement = document.create_element("a")?.unchecked_into();
    link.set_href(&url);
    link.set_download(name);
    link.click();
    // Some browsers read the address only after the click has been handled; a minute is long enough for all of them.
    let revoke = Closure::once_into_js(move || web_sys::Url::revoke_object_url(&url));
    let window = web_sys::window().ok_or("no window")?;
    window.set_timeout_with_callback_and_timeout_and_arguments_0(revoke.unchecked_ref(), 60_000)?;
    Ok(())
}
