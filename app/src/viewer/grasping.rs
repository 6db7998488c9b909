//! Grasps as a person examines them: what is asked for, how they are coloured, and what is written out.

use endcomfort_core::grasp::{ExportFormat, GraspFilter, GraspSettings, Quantity, RankSettings, Region};
use endcomfort_core::job::Stage;
use endcomfort_core::scene::Scene;

use super::state::Step;
use super::{Column, ColumnSet, Effect, Listed, ViewerState};

/// What a person does with grasps.
#[derive(Clone, Debug, PartialEq)]
pub enum GraspCommand {
    /// Opens a page of the inspector.
    Page(GraspPage),
    /// Colours grasps by a quantity; `None` by what ranks them.
    ColorBy(Option<Quantity>),
    /// Shows other columns.
    Columns(ColumnSet),
    /// Sorts the table by a column; once more turns the order round.
    SortBy(Column),
    /// Lists other candidates.
    List(Listed),
    /// Lists the rows that contain these words.
    Search(String),
    /// Lists the candidates that met this fate, told in words.
    ListFate(&'static str),
    /// Asks for other grasps.
    Settings(GraspSettings),
    /// Shows a filter in the view while a number of it is dragged.
    Preview(GraspFilter),
    /// Takes the next drag in the view for the region.
    DrawRegion(bool),
    /// The region that was drawn.
    SetRegion(Region),
    /// The upper half of the object as the region.
    TakeUpperHalf,
    /// Holds this part of the object alone; `None` any part.
    SetPart(Option<usize>),
    /// Ranks in another way.
    Rank(RankSettings),
    /// Whether the torso moves with the arm.
    SetTorso(bool),
    /// Saves the ranked grasps as a file.
    Export(ExportFormat),
}

/// A page of the inspector at the steps Grasps and Rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraspPage {
    /// How many candidates met which fate.
    Fates,
    /// Every candidate.
    Table,
    /// The selected one.
    Grasp,
    /// What the synthesis is asked.
    Settings,
    /// Which grasps are wanted.
    Filter,
    /// What counts, and the way out.
    Order,
}

impl GraspPage {
    /// The pages of a step.
    pub fn of(stage: Stage) -> &'static [Self] {
        if stage == Stage::Rank {
            &[Self::Table, Self::Grasp, Self::Order]
        } else {
            &[Self::Fates, Self::Table, Self::Grasp, Self::Settings, Self::Filter]
        }
    }

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Fates => "Fates",
            Self::Table => "Table",
            Self::Grasp => "Grasp",
            Self::Settings => "Settings",
            Self::Filter => "Filter",
            Self::Order => "Order",
        }
    }
}

/// How grasps are examined.
#[derive(Clone, Debug)]
pub struct Grasping {
    /// The open page at the step Grasps.
    grasps_page: GraspPage,
    /// The open page at the step Rank.
    rank_page: GraspPage,
    /// What colours the grasps; `None` for what ranks them.
    pub colored_by: Option<Quantity>,
    /// The filter while a number of it is dragged.
    pub preview: Option<GraspFilter>,
    /// Whether the next drag in the view draws the region.
    pub draws_region: bool,
}

impl Default for Grasping {
    fn default() -> Self {
        Self {
            grasps_page: GraspPage::Fates,
            rank_page: GraspPage::Table,
            colored_by: None,
            preview: None,
            draws_region: false,
        }
    }
}

/// What examining grasps adds to the picture; equal values give equal pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GraspingKey {
    /// What colours the grasps; `None` for what ranks them.
    pub colored_by: Option<Quantity>,
    /// The filter that is drawn: the document's, or the one that is being dragged; `None` away from the grasps.
    pub filter: Option<GraspFilter>,
}

impl ViewerState {
    /// The open page of the inspector at a step with grasps.
    pub fn grasp_page(&self, stage: Stage) -> GraspPage {
        if stage == Stage::Rank { self.grasping.rank_page } else { self.grasping.grasps_page }
    }

    /// What examining grasps adds to the picture.
    pub fn grasping_key(&self) -> GraspingKey {
        let is_shown = matches!(self.selection.step, Step::Stage(Stage::Grasps | Stage::Rank));
        let filter = self.grasping.preview.as_ref().unwrap_or(&self.document.scene.grasp.filter);
        GraspingKey { colored_by: self.grasping.colored_by, filter: is_shown.then(|| filter.clone()) }
    }

    /// Whether a click on a body of the target chooses the part that may be held.
    pub fn picks_part(&self) -> bool {
        self.selection.step == Step::Stage(Stage::Grasps) && self.grasping.grasps_page == GraspPage::Filter
    }

    /// Whether somebody works on what grasps are asked for or ranked by.
    pub(super) fn edits_grasps(&self) -> bool {
        match self.selection.step {
            Step::Stage(Stage::Grasps) => matches!(self.grasping.grasps_page, GraspPage::Settings | GraspPage::Filter),
            Step::Stage(Stage::Rank) => self.grasping.rank_page == GraspPage::Order,
            _ => false,
        }
    }

    pub(super) fn apply_grasping(&mut self, command: GraspCommand) -> Vec<Effect> {
        match command {
            GraspCommand::Page(page) => {
                self.grasping.draws_region = false;
                if self.selection.step == Step::Stage(Stage::Rank) {
                    self.grasping.rank_page = page;
                } else {
                    self.grasping.grasps_page = page;
                }
            }
            GraspCommand::ColorBy(quantity) => self.grasping.colored_by = quantity,
            GraspCommand::Columns(columns) => self.table.columns = columns,
            GraspCommand::SortBy(column) => self.table.sort_by(column),
            GraspCommand::List(listed) => self.table.listed = listed,
            GraspCommand::Search(words) => self.table.search = words,
            GraspCommand::ListFate(words) => {
                self.table.listed = Listed::All;
                self.table.search = words.to_lowercase();
                self.grasping.grasps_page = GraspPage::Table;
            }
            GraspCommand::Settings(settings) => return self.edit_checked(|scene| scene.grasp = settings),
            GraspCommand::Preview(filter) => self.grasping.preview = Some(filter),
            GraspCommand::DrawRegion(draws) => {
                self.grasping.draws_region = draws;
                // In a narrow window the inspector would lie over the object.
                self.drawer = self.drawer.filter(|_| !draws);
            }
            GraspCommand::SetRegion(region) => {
                self.grasping.draws_region = false;
                return self.edit_checked(|scene| scene.grasp.filter.region = Some(region));
            }
            GraspCommand::TakeUpperHalf => {
                if let Some(region) = self.upper_half() {
                    return self.apply_grasping(GraspCommand::SetRegion(region));
                }
            }
            GraspCommand::SetPart(part) => return self.edit_checked(|scene| scene.grasp.filter.part = part),
            GraspCommand::Rank(settings) => return self.edit_checked(|scene| scene.rank = settings),
            GraspCommand::SetTorso(moves) => return self.edit_checked(|scene| scene.torso = moves),
            GraspCommand::Export(format) => return vec![Effect::Export(format)],
        }
        Vec::new()
    }

    /// Edits the scene unless a number would leave its range: then the person is told, and nothing changes.
    fn edit_checked(&mut self, change: impl FnOnce(&mut Scene)) -> Vec<Effect> {
        self.grasping.preview = None;
        let mut scene = (*self.document.scene).clone();
        change(&mut scene);
        match scene.clone().checked() {
            Ok(_) => self.edit_scene(|present| *present = scene),
            Err(error) => {
                let sentence = format!("That setting cannot be: {error}.");
                self.say(true, sentence.clone(), Vec::new());
                vec![Effect::Announce(sentence)]
            }
        }
    }
}
