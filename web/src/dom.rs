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
