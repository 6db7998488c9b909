//! What this browser keeps of the page from visit to visit: two entries of its `localStorage`.

use endcomfort::host::{Entry, Store};
use wasm_bindgen::JsValue;
use web_sys::Storage;

/// Name of an entry.
fn key(entry: Entry) -> &'static str {
    match entry {
        Entry::Session => "endcomfort_session",
        Entry::Layout => "endcomfort_layout",
    }
}

/// The entries. A browser that keeps nothing (a private window, a strict setting) makes no difference but this one.
pub(crate) struct LocalStore;

fn storage() -> Option<Storage> {
    web_sys::window()?.local_storage().ok().flatten()
}

impl Store for LocalStore {
    fn read(&self, entry: Entry) -> Option<String> {
        storage()?.get_item(key(entry)).ok().flatten()
    }

    fn write(&mut self, entry: Entry, text: &str) -> Result<(), String> {
        let storage = storage().ok_or("this browser keeps nothing for the page")?;
        let full = |error: JsValue| format!("the browser refuses it: {error:?}");
        storage.set_item(key(entry), text).map_err(full)
    }

    fn forget(&mut self, entry: Entry) {
        if let Some(storage) = storage() {
            // Where it cannot be removed it is met again at the next visit, and dropped again.
            let _stays = storage.remove_item(key(entry));
        }
    }
}
