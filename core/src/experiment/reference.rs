//! What the thesis reports for the same trials: its own numbers, never mixed with ours.
//!
//! Table 3.2 and, for the radial objective, Table 3.3 are printed in the thesis. Medians and the other four objectives
//! come from the raw data of the same 500 trials that its author published. Times are of a 3.6 GHz Xeon E5-1620.

use super::Experiment;
use crate::fit::ObjectiveKind;

/// One row of the thesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThesisRow {
    /// E_g as its tables use it: mean |f - 1|.
    pub goodness_of_fit_abs_mean: Option<f64>,
    /// E_r, metres.
    pub radial_mean_m: f64,
    /// Median of E_r, metres.
    pub radial_median_m: Option<f64>,
    /// Error of the volume, percent.
    pub volume_error_mean_percent: f64,
    /// Seconds per fit.
    pub time_mean_s: f64,
}

/// Table 3.2: condition, E_g, E_r in mm, volume error in %, time in s.
const TABLE_3_2: [(&str, f64, f64, f64, f64); 6] = [
    ("voxel 0.005 m", 0.040, 2.3, 0.573, 6.246),
    ("voxel 0.010 m", 0.054, 3.3, 0.697, 3.787),
    ("voxel 0.015 m", 0.061, 3.8, 0.821, 1.763),
    ("voxel 0.020 m", 0.064, 4.2, 0.994, 1.425),
    ("voxel 0.025 m", 0.069, 4.3, 1.201, 0.919),
    ("voxel 0.030 m", 0.069, 4.6, 1.472, 0.669),
];

/// Table 3.3, as [`TABLE_3_2`]; radial objective.
const TABLE_3_3: [(&str, f64, f64, f64, f64); 4] = [
    ("full", 0.061602, 3.733, 0.827583, 1.602047),
    ("full noisy", 0.062367, 3.822, 0.769512, 1.865845),
    ("partial", 1.235281, 13.045, 19.9356, 5.078875),
    ("partial noisy", 25.410158, 14.554, 20.641092, 4.604418),
];

/// All objectives on the trials of Table 3.3, in the order of [`ObjectiveKind::ALL`]: E_r mean and median in mm, volume
/// error in %, time in s.
const OBJECTIVES: [(&str, [[f64; 4]; 5]); 4] = [
    (
        "full",
        [
            [3.73, 1.54, 0.83, 1.60],
            [3.05, 1.29, 1.03, 1.89],
            [3.46, 1.56, 1.38, 1.46],
            [3.67, 1.52, 1.57, 1.98],
            [3.77, 1.54, 2.07, 2.89],
        ],
    ),
    (
        "full noisy",
        [
            [3.82, 1.77, 0.77, 1.87],
            [3.63, 2.30, 1.06, 2.09],
            [3.80, 2.30, 1.50, 1.86],
            [3.83, 1.84, 1.93, 2.22],
            [3.98, 1.87, 2.83, 2.90],
        ],
    ),
    (
        "partial",
        [
            [13.05, 7.80, 19.9, 5.08],
            [13.09, 6.84, 19.6, 4.10],
            [16.86, 9.20, 14.1, 2.45],
            [13.18, 7.32, 18.5, 4.58],
            [13.21, 7.36, 17.7, 4.89],
        ],
    ),
    (
        "partial noisy",
        [
            [14.55, 9.36, 20.6, 4.60],
            [16.32, 9.96, 20.0, 3.51],
            [21.24, 15.4, 17.7, 2.52],
            [14.53, 8.65, 19.2, 3.95],
            [14.18, 8.51, 18.3, 4.34],
        ],
    ),
];

/// The thesis's numbers for a row of ours, if it has any.
pub fn thesis_row(experiment: Experiment, condition: &str, objective: ObjectiveKind) -> Option<ThesisRow> {
    let from_table = |table: &[(&str, f64, f64, f64, f64)]| {
        let (_, goodness, radial_mm, volume_percent, time_s) = table.iter().find(|row| row.0 == condition)?;
        Some(ThesisRow {
            goodness_of_fit_abs_mean: Some(*goodness),
            radial_mean_m: radial_mm / 1e3,
            radial_median_m: None,
            volume_error_mean_percent: *volume_percent,
            time_mean_s: *time_s,
        })
    };
    match experiment {
        Experiment::Downsampling => from_table(&TABLE_3_2),
        Experiment::Visibility => {
            let median_mm = OBJECTIVES.iter().find(|row| row.0 == condition)?.1.first()?[1];
            let row = from_table(&TABLE_3_3)?;
            Some(ThesisRow { radial_median_m: Some(median_mm / 1e3), ..row })
        }
        Experiment::Objectives => {
            let column = ObjectiveKind::ALL.iter().position(|kind| *kind == objective)?;
            let [mean_mm, median_mm, volume_percent, time_s] =
                *OBJECTIVES.iter().find(|row| row.0 == condition)?.1.get(column)?;
            Some(ThesisRow {
                goodness_of_fit_abs_mean: None,
                radial_mean_m: mean_mm / 1e3,
                radial_median_m: Some(median_mm / 1e3),
                volume_error_mean_percent: volume_percent,
                time_mean_s: time_s,
            })
        }
        _ => None,
    }
}
