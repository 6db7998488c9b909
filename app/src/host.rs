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

    /// One word for the backend that draws: `WebGPU`, `WebGL2`, `Vulkan`, …
    fn backend(&self) -> String;
}
