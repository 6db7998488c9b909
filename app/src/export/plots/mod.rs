//! Every plot of the interface as an SVG in the colours of the light theme: axes, units, limits, legends.

mod chart;
mod histogram;
mod of_fit;
mod of_plan;
mod svg;

#[cfg(test)]
mod tests;

#[cfg(not(target_arch = "wasm32"))]
use endcomfort_core::fit::{Fit, ObjectiveKind};
use endcomfort_core::job::Stage;
use endcomfort_core::scene::Scene;

pub use histogram::{HISTOGRAM_BARS, Histogram};
pub use of_fit::taken_run;

use super::Results;
use crate::viewer::Curve;

/// The colour of the curve that matters.
const TEAL: &str = "#0d9a85";

/// A plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlotKind {
    /// Cost of every run of the search for a fit.
    Cost,
    /// Signed distances of the points from their fit.
    Residuals,
    /// Manipulability and clearance over the plan.
    Timeline,
    /// A curve of every joint over the plan.
    Joints(Curve),
}

impl PlotKind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Cost,
        Self::Residuals,
        Self::Timeline,
        Self::Joints(Curve::Position),
        Self::Joints(Curve::Velocity),
        Self::Joints(Curve::Acceleration),
    ];

    /// Its name on the command line and in the names of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cost => "cost",
            Self::Residuals => "residuals",
            Self::Timeline => "timeline",
            Self::Joints(Curve::Position) => "positions",
            Self::Joints(Curve::Velocity) => "velocities",
            Self::Joints(Curve::Acceleration) => "accelerations",
        }
    }

    /// The last stage of the pipeline that it needs.
    pub fn stage(self) -> Stage {
        match self {
            Self::Cost | Self::Residuals => Stage::Fit,
            Self::Timeline | Self::Joints(_) => Stage::Plan,
        }
    }
}

/// A plot as the text of an SVG file.
///
/// * `cluster`: the one whose fit is plotted; the target without one.
///
/// # Errors
/// A clause when there is nothing to plot yet.
pub fn plot_svg(
    results: &Results<'_>,
    scene: &Scene,
    kind: PlotKind,
    cluster: Option<usize>,
) -> Result<String, String> {
    let sheet = match kind {
        PlotKind::Timeline => of_plan::timeline(results.plan.ok_or("there is no plan")?),
        PlotKind::Joints(curve) => {
            of_plan::joints(results.plan.ok_or("there is no plan")?, results.robot, scene, curve)?
        }
        PlotKind::Cost | PlotKind::Residuals => {
            let found = results.fit.ok_or("there is no fit")?;
            let cluster = cluster.unwrap_or(found.target);
            let fit = found.fits.get(cluster).ok_or_else(|| format!("there is no cluster {cluster}"))?;
            let fit = fit.as_ref().map_err(Clone::clone)?;
            let of = format!("cluster {cluster}");
            match kind {
                PlotKind::Cost => of_fit::cost(fit, &of, scene.fit.objective)?,
                _ => of_fit::residuals(found.distances_m.get(cluster).map_or(&[], Vec::as_slice), &of)?,
            }
        }
    };
    Ok(svg::svg(&sheet))
}

/// The plots of a single cloud's fit, by their kinds: the cost of its runs, and the distances of its points.
///
/// * `of`: what the titles call the cloud.
///
/// # Errors
/// A clause when there is nothing to plot.
#[cfg(not(target_arch = "wasm32"))]
pub fn fit_svgs(
    fit: &Fit,
    distances_m: &[f64],
    objective: ObjectiveKind,
    of: &str,
) -> Result<[(PlotKind, String); 2], String> {
    let cost = of_fit::cost(fit, of, objective)?;
    let residuals = of_fit::residuals(distances_m, of)?;
    Ok([(PlotKind::Cost, svg::svg(&cost)), (PlotKind::Residuals, svg::svg(&residuals))])
}

/// `#rrggbb` of a display colour.
fn hex([r, g, b, _]: [f32; 4]) -> String {
    let byte = |channel: f32| (255.0 * channel).round() as u8;
    format!("#{:02x}{:02x}{:02x}", byte(r), byte(g), byte(b))
}
