//! What a person sees of Endcomfort: the panels, the renderer and, natively, the command line.
//!
//! The interface reads state and emits commands; it never computes. Every long computation is a
//! [`endcomfort_core::job::Request`] that a [`host::Host`] carries to a worker.

pub mod assets;
pub mod host;
pub mod render;
pub mod viewer;
