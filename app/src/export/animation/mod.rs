//! A plan as moving pictures: a GIF, an animated PNG, or one PNG for every frame, packed together.
//!
//! Frame `k` shows the plan at `from + k / fps`, however long it takes to draw: [`Recorder::wanted_s`] says which moment
//! comes next, [`Recorder::take`] takes its picture. No clock is asked, so equal pictures give equal files.
//! There is no film with sound and no MP4: no small encoder of one runs in every browser.

mod apng;
mod changes;
mod clip;
mod gif;
mod palette;
mod recorder;
mod zip;

#[cfg(test)]
mod tests;

pub use clip::{AnimationError, AnimationFormat, Clip};
pub use recorder::Recorder;
