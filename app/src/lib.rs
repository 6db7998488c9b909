//! What a person sees of Endcomfort: the panels, the renderer and, natively, the command line.
//!
//! The interface reads state and emits commands; it never computes. Every long computation is a
//! [`endcomfort_core::job::Request`] that a [`host::Host`] carries to a worker.
#![allow(non_snake_case, reason = "frame letters: X_WO is the pose of O in W")]

pub mod assets;
pub mod brought;
#[cfg(not(target_arch = "wasm32"))]
pub mod cli;
pub mod clock;
pub mod compose;
pub mod export;
#[cfg(not(target_arch = "wasm32"))]
pub mod figures;
pub mod host;
#[cfg(not(target_arch = "wasm32"))]
pub mod jobs;
pub mod render;
pub mod studio;
pub mod viewer;
#[cfg(not(target_arch = "wasm32"))]
pub mod window;
