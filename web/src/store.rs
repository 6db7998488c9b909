//! What this browser keeps of the page from visit to visit: one entry of its `localStorage`.

use endcomfort::host::Store;
use wasm_bindgen::JsValue;
use web_sys::Storage;

/// Name of the entry.
const KEY: &str = "endcomfort_session";

/// The entry. A browser that keeps nothing (a private window, a strict setting) makes no difference but this one.
pub(crate) struct LocalStore;

fn storage() -> Option<Storage> {
    web_sys::window()?.local_storage().ok().flatten()
}

impl Store for LocalStore {
    fn read(&self) -> Option<String> {
        storage()?.get_item(KEY).ok().flatten()
    }

    fn write(&mut self, text: &str) -> Result<(), String> {
        let storage = storage().ok_or("this browser keeps nothing for the page")?;
        let full = |error: JsValue| format!("the browser refuses it: {error:?}");
        storage.set_item(KEY, text).map_err(full)
    }

    fn forget(&mut self) {
        if let Some(storage) = storage() {
            // Where it cannot be removed it is met again at the next visit, and dropped again.
            let _stays = storage.remove_item(KEY);
        }
    }
}
