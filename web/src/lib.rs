//! The browser entry points: page and worker, two instances of one module.
//!
//! The page draws and never computes; it sends each [`endcomfort_core::job::Request`] to a worker as bytes ([`wire`])
//! and gets [`endcomfort_core::job::Update`]s back. Natively only [`wire`] exists, for its tests.

pub mod wire;

#[cfg(target_arch = "wasm32")]
mod dom;
#[cfg(target_arch = "wasm32")]
mod host;
#[cfg(target_arch = "wasm32")]
pub mod page;
#[cfg(target_arch = "wasm32")]
mod store;
#[cfg(target_arch = "wasm32")]
pub mod worker;
