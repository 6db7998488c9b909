//! Tables and plots that a person saves as files.

use std::sync::Arc;

use endcomfort_core::robot::Robot;

use super::{Effect, ViewerState};
use crate::assets;
use crate::export::{PlotKind, Results, TableFormat, TableKind, plot_svg, table_text};

/// What can be saved beside a table or a plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// A table.
    Table(TableKind, TableFormat),
    /// A plot, as SVG.
    Plot(PlotKind),
}

impl Saved {
    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Table(_, format) => format.title(),
            Self::Plot(_) => "Save the plot as SVG",
        }
    }

    /// Name and extension of its file: what stands behind the scene's name.
    fn file(self) -> (&'static str, &'static str) {
        match self {
            Self::Table(kind, format) => (kind.name(), format.extension()),
            Self::Plot(kind) => (kind.name(), "svg"),
        }
    }
}

impl ViewerState {
    /// What tables and plots are made of. A plan of another robot is none of it.
    pub(super) fn results<'a>(&'a self, robot: &'a Robot) -> Results<'a> {
        let plan = self.outputs.plan.as_deref().filter(|plan| plan.q_start.len() == robot.dof_count());
        Results {
            robot,
            segment: self.outputs.segment.as_deref(),
            fit: self.outputs.fit.as_deref(),
            objectives: self.comparison().map_or(&[], |comparison| &comparison.rows),
            plan,
            tries: self.tries(),
            maps: [0, 1].map(|arm| self.reaching.map(arm)),
        }
    }

    /// Writes a table or a plot of what is shown now.
    pub(super) fn save(&mut self, saved: Saved) -> Vec<Effect> {
        let text = match assets::library().robot_of(&self.document.scene) {
            Ok(robot) => {
                let results = self.results(&robot);
                match saved {
                    Saved::Table(kind, format) => table_text(&results, kind, format),
                    Saved::Plot(kind) => plot_svg(&results, &self.document.scene, kind, self.examined_cluster()),
                }
            }
            Err(error) => Err(error.to_string()),
        };
        match text {
            Ok(text) => {
                let (what, extension) = saved.file();
                let name = self.saved_name(what, extension);
                vec![Effect::Save { name, bytes: Arc::new(text.into_bytes()) }]
            }
            Err(reason) => {
                let sentence = format!("It could not be saved: {reason}.");
                self.say(true, sentence.clone(), Vec::new());
                vec![Effect::Announce(sentence)]
            }
        }
    }

    /// Name of a file that tells the scene and what it holds: `endcomfort-jar-phases.csv`.
    pub(super) fn saved_name(&self, what: &str, extension: &str) -> String {
        let scene = self.file_name(extension);
        let scene = scene.trim_end_matches(extension).trim_end_matches('.');
        format!("endcomfort-{scene}-{what}.{extension}")
    }
}
