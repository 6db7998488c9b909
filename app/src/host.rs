//! What the interface needs from wherever it runs: a worker that computes, and a way to hand a file to the person.

use endcomfort_core::job::{Request, Update};

/// What is done with a file that was brought, or with the reason why it was not.
pub type Fetched = Box<dyn FnOnce(Result<Vec<u8>, String>)>;

/// The window or the page around the interface.
pub trait Host {
    /// Starts a request; whatever still runs is cancelled first.
    fn submit(&mut self, request: Request);

    /// Stops whatever runs.
    fn cancel(&mut self);

    /// Takes the updates that arrived since the last call.
    fn poll(&mut self) -> Vec<Update>;

    /// Brings a file that travels beside the program, `maps/alita_left.reach`; `done` is called once, now or later, with
    /// its content or with why it cannot be had.
    fn fetch(&mut self, path: &str, done: Fetched);

    /// Hands a file to the person: a download in the browser, a file in the working folder natively.
    ///
    /// Returns a sentence that says where it went.
    fn save(&mut self, name: &str, bytes: &[u8]) -> String;

    /// Says a sentence to assistive technology and to the page's status line.
    fn announce(&mut self, sentence: &str);

    /// Address of the page without its `#…`, to which the rest of a link is added; nothing natively.
    fn page(&self) -> String {
        String::new()
    }

    /// The place where something is kept from visit to visit; `None` where there is none.
    fn store(&mut self) -> Option<&mut dyn Store> {
        None
    }

    /// Asks the person for a file, which then comes in like a dropped one; only the browser has such a list.
    fn pick(&mut self) {}

    /// Tells whoever embeds the page that something happened: a JSON object.
    fn tell(&mut self, _event: &serde_json::Value) {}

    /// One word for the backend that draws: `WebGPU`, `WebGL2`, `Vulkan`, …
    fn backend(&self) -> String;
}

/// What is kept from visit to visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// What was open.
    Session,
    /// Sizes of the panels.
    Layout,
}

/// A place for texts that are kept from visit to visit.
pub trait Store {
    /// What was written last, by this visit or an earlier one.
    fn read(&self, entry: Entry) -> Option<String>;

    /// Replaces it.
    ///
    /// # Errors
    /// Why it cannot be kept, for a log.
    fn write(&mut self, entry: Entry, text: &str) -> Result<(), String>;

    /// Forgets it.
    fn forget(&mut self, entry: Entry);
}
