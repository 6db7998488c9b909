//! The few elements of `index.html` that the program writes to, always through `textContent`, and files beside it.

use js_sys::Uint8Array;
use wasm_bindgen::{JsCast as _, JsValue};
use wasm_bindgen_futures::JsFuture;
use web_sys::{Document, HtmlElement, Response};

/// The page's document; `None` in a worker.
pub(crate) fn document() -> Option<Document> {
    web_sys::window().and_then(|window| window.document())
}

/// Says a sentence in the status line, which assistive technology reads aloud.
pub(crate) fn announce(sentence: &str) {
    set_text("sentence", sentence);
}

/// Covers the view with what happened and what to do next.
pub(crate) fn show_failure(title: &str, sentence: &str, advice: &str, detail: &str) {
    set_text("title", title);
    set_text("sentence", sentence);
    set_text("advice", advice);
    set_text("detail", detail);
    if let Some(element) = element("detail") {
        element.set_hidden(detail.is_empty());
    }
    if let Some(element) = element("status") {
        element.set_class_name("failed");
    }
}

/// The value of a parameter in the address: of `demo` in `?demo=mustard`, `mustard`.
pub(crate) fn query(parameter: &str) -> Option<String> {
    let search = web_sys::window()?.location().search().ok()?;
    web_sys::UrlSearchParams::new_with_str(&search).ok()?.get(parameter)
}

/// What follows the address's `#`, with it: `#s=…`; `None` if that is no link of ours.
pub(crate) fn link() -> Option<String> {
    let hash = web_sys::window()?.location().hash().ok()?;
    hash.starts_with("#s=").then_some(hash)
}

/// The page's address without its `#…` and without what a link says better: which demo opens and in what frame.
pub(crate) fn page() -> Option<String> {
    let url = web_sys::Url::new(&web_sys::window()?.location().href().ok()?).ok()?;
    url.set_hash("");
    for parameter in ["demo", "gallery", "embed"] {
        url.search_params().delete(parameter);
    }
    Some(url.href())
}

/// Tells `boot.js` that something happened or is wanted: an event of this name whose detail is this text.
pub(crate) fn tell(name: &str, detail: &str) {
    let options = web_sys::CustomEventInit::new();
    options.set_detail(&detail.into());
    let event = web_sys::CustomEvent::new_with_event_init_dict(name, &options);
    if let (Some(window), Ok(event)) = (web_sys::window(), event) {
        // It is only false when somebody prevents a default action, and there is none.
        let _is_not_prevented = window.dispatch_event(&event);
    }
}

/// A file beside the page.
///
/// # Errors
/// Why it cannot be had, for a person.
pub(crate) async fn fetch(path: &str) -> Result<Vec<u8>, String> {
    let window = web_sys::window().ok_or("there is no window")?;
    let unreachable = |_: JsValue| "the server cannot be reached".to_owned();
    let answer = JsFuture::from(window.fetch_with_str(path)).await.map_err(unreachable)?;
    let answer: Response = answer.unchecked_into();
    if !answer.ok() {
        return Err(format!("the server answers {}", answer.status()));
    }
    let body = answer.array_buffer().map_err(unreachable)?;
    let bytes = JsFuture::from(body).await.map_err(unreachable)?;
    Ok(Uint8Array::new(&bytes).to_vec())
}

fn element(id: &str) -> Option<HtmlElement> {
    document()?.get_element_by_id(id)?.dyn_into().ok()
}

fn set_text(id: &str, text: &str) {
    if let Some(element) = element(id) {
        element.set_text_content(Some(text));
    }
}
