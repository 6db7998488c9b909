//! Every table of the interface as CSV or JSON: the same rows from the page and from the command line.
//!
//! Names of columns end in their unit (`clearance_m`, `duration_s`, `off_line_rad`); without one a number has none.
//! Clusters, routes, places and tries are counted from 0, as in every other file.

mod fit;
mod plan;
mod reach;
mod segment;

use endcomfort_core::experiment::{Cell, Record, csv};
use endcomfort_core::job::{FitOutput, ObjectiveFit, SegmentOutput, Stage};
use endcomfort_core::reach::ReachMap;
use endcomfort_core::robot::Robot;
use endcomfort_core::task::{Plan, TrajectoryFormat, Try, plan_json_lines, trajectory_text};

/// A table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TableKind {
    /// What became of the points of the cloud.
    Fates,
    /// What stands on the table.
    Clusters,
    /// The fit of every cluster: parameters and errors.
    Fits,
    /// Every run of the search for a fit.
    Runs,
    /// The models that were compared for a fit.
    Models,
    /// The objectives side by side.
    Objectives,
    /// The signed distance of every point from its fit.
    Residuals,
    /// The phases of the plan.
    Phases,
    /// What was tried in vain.
    Tried,
    /// Routes of the hand.
    Routes,
    /// Places for a handover.
    Places,
    /// Every joint over time.
    Joints,
    /// The voxels that the arms reach.
    Voxels,
}

impl TableKind {
    /// All of them, in the order of the pipeline.
    pub const ALL: [Self; 13] = [
        Self::Fates,
        Self::Clusters,
        Self::Fits,
        Self::Runs,
        Self::Models,
        Self::Objectives,
        Self::Residuals,
        Self::Phases,
        Self::Tried,
        Self::Routes,
        Self::Places,
        Self::Joints,
        Self::Voxels,
    ];

    /// Its name on the command line and in the names of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fates => "fates",
            Self::Clusters => "clusters",
            Self::Fits => "fits",
            Self::Runs => "runs",
            Self::Models => "models",
            Self::Objectives => "objectives",
            Self::Residuals => "residuals",
            Self::Phases => "phases",
            Self::Tried => "tried",
            Self::Routes => "routes",
            Self::Places => "places",
            Self::Joints => "joints",
            Self::Voxels => "voxels",
        }
    }

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Fates => "points by their fate",
            Self::Clusters => "clusters",
            Self::Fits => "fits with their errors",
            Self::Runs => "runs of the search",
            Self::Models => "models compared",
            Self::Objectives => "objectives side by side",
            Self::Residuals => "distances of the points",
            Self::Phases => "phases",
            Self::Tried => "what was tried",
            Self::Routes => "routes of the hand",
            Self::Places => "places for the handover",
            Self::Joints => "joints over time",
            Self::Voxels => "reached voxels",
        }
    }

    /// The last stage of the pipeline that it needs; none for the stored maps.
    pub fn stage(self) -> Option<Stage> {
        match self {
            Self::Fates | Self::Clusters => Some(Stage::Segment),
            Self::Fits | Self::Runs | Self::Models | Self::Objectives | Self::Residuals => Some(Stage::Fit),
            Self::Phases | Self::Tried | Self::Routes | Self::Places | Self::Joints => Some(Stage::Plan),
            Self::Voxels => None,
        }
    }
}

/// What a table is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Commas between cells, one line of heads.
    Csv,
    /// An array with one object per row.
    Json,
}

impl TableFormat {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Csv, Self::Json];

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
        }
    }

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Csv => "Save as CSV",
            Self::Json => "Save as JSON",
        }
    }

    /// The format of a file by its extension.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(extension))
    }
}

/// What the tables are made of: whatever there is so far.
#[derive(Clone, Copy)]
pub struct Results<'a> {
    /// The robot of the scene.
    pub robot: &'a Robot,
    /// Clusters and fates.
    pub segment: Option<&'a SegmentOutput>,
    /// Fits.
    pub fit: Option<&'a FitOutput>,
    /// Objectives that were compared, with their times in milliseconds.
    pub objectives: &'a [(f64, ObjectiveFit)],
    /// The plan.
    pub plan: Option<&'a Plan>,
    /// What was tried in vain, before the plan or instead of one.
    pub tries: &'a [Try],
    /// Reachability maps of the left and of the right arm.
    pub maps: [Option<&'a ReachMap>; 2],
}

/// A row: named cells, the same names in every row of a table.
struct Row(Vec<(&'static str, Cell)>);

impl Record for Row {
    fn cells(&self) -> Vec<(&'static str, Cell)> {
        self.0.clone()
    }
}

/// A table as the text of a file.
///
/// # Errors
/// A clause when there is no such table yet, or nothing in it.
pub fn table_text(results: &Results<'_>, kind: TableKind, format: TableFormat) -> Result<String, String> {
    match (format, results.plan) {
        (TableFormat::Csv, Some(plan)) if kind == TableKind::Joints => {
            Ok(trajectory_text(plan, results.robot, TrajectoryFormat::Csv))
        }
        (TableFormat::Csv, _) => some_rows(results, kind).map(|rows| csv(&rows)),
        (TableFormat::Json, _) => table_lines(results, kind).map(|lines| format!("[\n{}\n]\n", lines.join(",\n"))),
    }
}

/// A table as one JSON object per row.
///
/// # Errors
/// As [`table_text`].
pub fn table_lines(results: &Results<'_>, kind: TableKind) -> Result<Vec<String>, String> {
    match results.plan {
        // The joints of a phase are one object: as many numbers would be too long one by one.
        Some(plan) if kind == TableKind::Joints => {
            Ok(plan_json_lines(plan, results.robot).iter().map(ToString::to_string).collect())
        }
        _ => Ok(some_rows(results, kind)?.iter().map(Record::json).collect()),
    }
}

fn some_rows(results: &Results<'_>, kind: TableKind) -> Result<Vec<Row>, String> {
    let rows = rows(results, kind);
    if rows.is_empty() { Err(format!("the table {:?} has no row here", kind.name())) } else { Ok(rows) }
}

fn rows(results: &Results<'_>, kind: TableKind) -> Vec<Row> {
    match kind {
        TableKind::Fates => results.segment.map_or_else(Vec::new, segment::fates),
        TableKind::Clusters => results.segment.map_or_else(Vec::new, segment::clusters),
        TableKind::Fits => results.fit.map_or_else(Vec::new, fit::fits),
        TableKind::Runs => results.fit.map_or_else(Vec::new, fit::runs),
        TableKind::Models => results.fit.map_or_else(Vec::new, fit::models),
        TableKind::Objectives => fit::objectives(results.objectives),
        TableKind::Residuals => match (results.segment, results.fit) {
            (Some(segment), Some(found)) => fit::residuals(segment, found),
            _ => Vec::new(),
        },
        TableKind::Phases => results.plan.map_or_else(Vec::new, plan::phases),
        TableKind::Tried => plan::tried(results.tries),
        TableKind::Routes => results.plan.map_or_else(Vec::new, plan::routes),
        TableKind::Places => results.plan.and_then(|p| p.handover.as_deref()).map_or_else(Vec::new, plan::places),
        TableKind::Joints => Vec::new(),
        TableKind::Voxels => results.maps.into_iter().flatten().flat_map(reach::voxels).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_formats_are_told_apart_and_found_again() {
        for kind in TableKind::ALL {
            assert_eq!(TableKind::ALL.iter().filter(|other| other.name() == kind.name()).count(), 1);
        }
        assert_eq!(TableFormat::of_extension("CSV"), Some(TableFormat::Csv));
        assert_eq!(TableFormat::of_extension("txt"), None);
    }
}
