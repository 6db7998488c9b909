//! The science of Endcomfort: from a depth cloud to ranked grasps and a timed plan.
//!
//! Rooms in the order in which the data flows: [`cloud`] → [`segment`] → [`fit`] → [`grasp`] → [`plan`] → [`task`],
//! with [`superquadric`], [`object`], [`robot`] and [`collision`] beside them. [`scene`] is the document that people
//! save and share, [`job`] the request that runs the whole way and the updates that come back. [`experiment`] runs the
//! thesis's trials and gives their tables as data. [`guest`] is whatever people bring: robots and objects of their own.
//!
//! What is absent, by design: this crate opens no file, reads no clock (time arrives through [`watch::Watch`]), starts
//! no thread of its own (loops that may run in parallel go through [`parallel`]), and knows neither egui, wgpu nor
//! JavaScript. Every random routine takes a seed, and every transcendental function comes from [`math`], so the same
//! scene and seed give the same plan natively and in a browser.
#![forbid(unsafe_code)]
#![allow(non_snake_case, reason = "frame letters: X_WO is the pose of O in W")]

mod bulk;
pub mod cloud;
pub mod collision;
pub mod experiment;
pub mod fit;
pub mod grasp;
pub mod guest;
pub mod handover;
pub mod job;
pub mod library;
pub mod loaded;
pub mod math;
pub mod mesh;
pub mod mesh_file;
pub mod object;
pub mod parallel;
pub mod pipeline;
pub mod plan;
pub mod reach;
pub mod rng;
pub mod robot;
pub mod scene;
pub mod segment;
mod simd;
pub mod superquadric;
pub mod task;
pub mod watch;
