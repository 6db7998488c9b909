//! Pictures of every view of an experiment with its fits, worst first.

use std::path::Path;

use endcomfort_core::experiment::{ObjectView, Trial};

use super::Failure;
use crate::figures::draw_fits;
use crate::render::{Offscreen, Theme};

/// Writes one picture per view into a folder, numbered from the worst: one column per condition, in their order.
///
/// A view is as bad as the largest error of its extents under any condition.
pub(super) fn write_pictures(folder: &Path, views: &[ObjectView], trials: &[Trial]) -> Result<(), Failure> {
    let refuse = |message: String| Failure::new(format!("{}: {message}", folder.display()));
    std::fs::create_dir_all(folder).map_err(|error| refuse(error.to_string()))?;
    let mut offscreen = Offscreen::new().map_err(|error| refuse(error.to_string()))?;
    let of = |view: usize| trials.iter().filter(move |trial| trial.trial == view);
    let badness = |view: usize| {
        let errors = of(view).filter_map(|trial| trial.answer.as_ref().ok()?.extent_errors_m);
        errors.flatten().map(f64::abs).fold(0.0, f64::max)
    };
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by(|p, q| badness(*q).total_cmp(&badness(*p)));
    for (place, index) in order.iter().enumerate() {
        let view = &views[*index];
        let fits: Vec<_> = of(*index).map(|trial| trial.answer.as_ref().ok().map(|answer| answer.found)).collect();
        let picture =
            draw_fits(&mut offscreen, view, &fits, Theme::Light).map_err(|error| refuse(error.to_string()))?;
        let file = folder.join(format!("{:02}_{}.png", place + 1, view.name));
        picture.save(&file).map_err(|error| refuse(format!("{}: {error}", view.name)))?;
    }
    eprintln!("wrote {} pictures to {}", order.len(), folder.display());
    Ok(())
}
