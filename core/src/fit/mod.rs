//! Fitting a superquadric to a partial, noisy cluster (thesis chapter 3).
//!
//! The way of a cluster through [`fit`]: into a frame of its own (`frame`), completed by its mirror image as far as the
//! camera allows (`view`, `mirror`), thinned (`thin`), then Levenberg–Marquardt on the radial objective (`objective`,
//! `levenberg_marquardt`) from every axis of several boxes (`starts`), few points first.
//!
//! Not here: deformed shapes, several superquadrics for one object, and the thesis's other four objectives.

mod candidate;
mod frame;
mod levenberg_marquardt;
mod metrics;
mod mirror;
mod models;
mod normal_equations;
mod objective;
mod prepare;
mod robust;
mod run;
mod search;
mod standing;
mod starts;
mod strays;
#[cfg(test)]
mod test_scenes;
mod thin;
mod types;
mod view;
mod weighted;

pub use metrics::{FitErrors, fit_errors};
pub use run::fit;
pub use types::{
    DeformMode, Fit, FitInput, FitRefusal, FitSettings, MirrorMode, ModelReport, ObjectiveKind, Part, RejectedPoint,
    RunReport, StopReason,
};
