//! Plots of a fit: the cost of every run, and the distances of the points.

use endcomfort_core::fit::{Fit, ObjectiveKind, RunReport};

use super::chart::{Axis, Bar, Chart, Line, Sheet};
use super::histogram::{HISTOGRAM_BARS, Histogram};
use super::{TEAL, hex};
use crate::render::{ColorMap, Scale};

/// Costs below this are drawn as this: a perfect fit has none, and no logarithm.
const LEAST: f64 = 1e-6;

/// The run that a fit was taken from: of those on the most points the cheapest, the last of equals.
pub fn taken_run(runs: &[RunReport]) -> usize {
    let most = runs.iter().map(|run| run.points).max().unwrap_or(0);
    let cost = |run: &RunReport| run.rms.last().copied().unwrap_or(f64::INFINITY);
    let candidates = runs.iter().enumerate().filter(|(_, run)| run.points == most).rev();
    candidates.min_by(|l, r| cost(l.1).total_cmp(&cost(r.1))).map_or(0, |(index, _)| index)
}

/// Cost of every run over its steps, on a logarithmic axis. `of` is what the title calls the cloud.
pub(super) fn cost(fit: &Fit, of: &str, objective: ObjectiveKind) -> Result<Sheet, String> {
    if fit.runs.is_empty() {
        return Err("no run is on record".to_owned());
    }
    let is_length = matches!(objective, ObjectiveKind::Radial | ObjectiveKind::Chevalier);
    let (factor, unit) = if is_length { (1e3, ", mm") } else { (1.0, "") };
    let taken = taken_run(&fit.runs);
    let line = |index: usize| {
        let run = &fit.runs[index];
        let points = run.rms.iter().enumerate().map(|(step, rms)| (step as f64, (factor * rms).max(LEAST)));
        let (name, color, width) = match index == taken {
            true => (format!("taken: {}", run.name), TEAL, 2.2),
            false => (String::new(), "#b9c0c7", 1.0),
        };
        Line { name, color: color.to_owned(), width, points: points.collect() }
    };
    // The one that was taken lies on top.
    let mut lines: Vec<Line> = (0..fit.runs.len()).filter(|&index| index != taken).map(line).collect();
    lines.push(line(taken));
    let costs = || lines.iter().flat_map(|line| line.points.iter().map(|(_, cost)| *cost));
    let (low, high) = costs().fold((f64::INFINITY, 0.0_f64), |(low, high), cost| (low.min(cost), high.max(cost)));
    let steps = fit.runs.iter().map(|run| run.rms.len().saturating_sub(1)).max().unwrap_or(1).max(1);
    let label = format!("rms of the residuals{unit}");
    let y = Axis { label, min: 0.8 * low, max: 1.25 * high.max(low), is_log: true };
    Ok(Sheet {
        title: format!("Cost of the {} runs on {of}", fit.runs.len()),
        key: Vec::new(),
        charts: vec![Chart {
            title: String::new(),
            x: Axis::new("step", 0.0, steps as f64),
            y,
            lines,
            bars: Vec::new(),
            limits: Vec::new(),
            strips: Vec::new(),
        }],
        shares_x: false,
        height: 280.0,
    })
}

/// Distances of the points from the surface. `of` is what the title calls the cloud.
pub(super) fn residuals(distances_m: &[f64], of: &str) -> Result<Sheet, String> {
    let found = Histogram::of(distances_m).ok_or("there are no distances")?;
    let scale = Scale { map: ColorMap::Diverging, min: -found.end_m, max: found.end_m, is_log: false };
    let bar = |index: usize| Bar {
        from: 1e3 * found.edge_m(index),
        to: 1e3 * found.edge_m(index + 1),
        height: found.counts[index] as f64,
        color: hex(scale.color(0.5 * (found.edge_m(index) + found.edge_m(index + 1)))),
    };
    let most = found.counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let side = if found.mean_m < 0.0 { "inside" } else { "outside" };
    let said = format!(
        "95 % within {:.2} mm of the surface; on average {:.2} mm {side}",
        1e3 * found.within_95_m,
        1e3 * found.mean_m.abs()
    );
    let end_mm = 1e3 * found.end_m;
    Ok(Sheet {
        title: format!("Signed radial distance of the points of {of}"),
        key: Vec::new(),
        charts: vec![Chart {
            title: said,
            x: Axis::new("distance from the surface, mm (negative inside)", -end_mm, end_mm),
            y: Axis::new("points", 0.0, 1.06 * most),
            lines: Vec::new(),
            bars: (0..HISTOGRAM_BARS).filter(|&index| found.counts[index] > 0).map(bar).collect(),
            limits: Vec::new(),
            strips: Vec::new(),
        }],
        shares_x: false,
        height: 240.0,
    })
}

#[cfg(test)]
mod tests {
    use endcomfort_core::fit::StopReason;

    use super::*;

    #[test]
    fn the_taken_run_is_the_cheapest_of_those_on_all_points() {
        let run = |points: usize, rms: f64| RunReport {
            name: String::new(),
            points,
            rms: vec![1.0, rms],
            iterations: 3,
            stop: StopReason::Converged,
        };
        assert_eq!(taken_run(&[run(100, 0.1), run(300, 0.5), run(300, 0.4)]), 2);
        assert_eq!(taken_run(&[run(300, 0.4), run(300, 0.4), run(200, 0.1)]), 1);
        assert_eq!(taken_run(&[]), 0);
    }
}
