//! The worker's side: takes requests, runs the pipeline, sends back what comes of it.
//!
//! The worker talks in two ways: updates as bytes ([`crate::wire`]), and, when it cannot go on, one sentence as text.

use endcomfort::assets;
use endcomfort_core::job::{Request, Update};
use endcomfort_core::pipeline::Pipeline;
use endcomfort_core::watch::Watch;
use js_sys::{Array, ArrayBuffer, Uint8Array};
use wasm_bindgen::prelude::*;
use web_sys::{DedicatedWorkerGlobalScope, MessageEvent};

use crate::wire;

/// Makes this worker ready for requests.
#[wasm_bindgen]
pub fn start_worker() {
    std::panic::set_hook(Box::new(|info| say(&info.to_string())));
    let mut pipeline = Pipeline::new(assets::library());
    let clock = web_time::Instant::now();
    let on_message = Closure::<dyn FnMut(MessageEvent)>::new(move |event: MessageEvent| {
        let bytes = Uint8Array::new(&event.data().unchecked_into::<ArrayBuffer>()).to_vec();
        match wire::from_bytes::<Request>(&bytes) {
            Ok(request) => {
                // Nobody can ask this thread to stop while it computes: the page ends it instead.
                let now_ms = || clock.elapsed().as_secs_f64() * 1e3;
                pipeline.run(&request, &Watch::new(&|| false, &|_, _| (), &now_ms), &mut send);
            }
            Err(error) => say(&error.to_string()),
        }
    });
    scope().set_onmessage(Some(on_message.as_ref().unchecked_ref()));
    on_message.forget(); // it lives as long as the worker
}

fn send(update: Update) {
    match wire::to_bytes(&update) {
        Ok(bytes) => {
            let buffer = Uint8Array::from(bytes.as_slice()).buffer();
            if let Err(error) = scope().post_message_with_transfer(&buffer, &Array::of1(&buffer)) {
                say(&format!("a result could not be sent: {error:?}"));
            }
        }
        Err(error) => say(&error.to_string()),
    }
}

/// Tells the page that this worker cannot go on.
fn say(sentence: &str) {
    if scope().post_message(&JsValue::from_str(sentence)).is_err() {
        log::error!("{sentence}");
    }
}

fn scope() -> DedicatedWorkerGlobalScope {
    js_sys::global().unchecked_into()
}
