//! Fitting a superquadric to a partial, noisy cluster (thesis chapter 3).
//!
//! The way of a cluster through [`fit`]: checked, into a frame of its own (`frame`), completed by its mirror image as far
//! as the camera allows (`view`, `mirror`), thinned (`prepare`, `thin`). Then `search`: Levenberg–Marquardt
//! (`levenberg_marquardt`) on one of five objectives (`objective`) from every axis of several boxes (`starts`), few
//! points first, with weights that noise and strays cannot spoil (`robust`, `strays`). Taper and bend are taken when they
//! pay (`models`), and an object that one shape cannot describe is split into a few (`composite`).

mod candidate;
mod composite;
mod contradiction;
mod frame;
mod levenberg_marquardt;
mod metrics;
mod mirror;
mod models;
mod normal_equations;
mod objective;
mod pass;
mod prepare;
#[cfg(test)]
mod properties;
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

pub use metrics::{FitErrors, fit_errors, fit_errors_of_parts};
pub use pass::ObjectivePass;
pub use run::fit;
pub use types::{
    DeformMode, Fit, FitInput, FitRefusal, FitSettings, MirrorMode, ModelReport, ObjectiveKind, Part, RejectedPoint,
    RunReport, StopReason,
};
