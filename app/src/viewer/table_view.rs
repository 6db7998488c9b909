//! Which grasps the table lists, in which order, and with which columns.

use endcomfort_core::grasp::{Grasp, Quantity};

use super::{ViewerState, format};

/// A column of the grasp table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Rank, or number.
    Number,
    /// One of the numbers.
    Of(Quantity),
    /// The reason.
    Why,
}

/// Numbers that are looked at together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColumnSet {
    /// A little of everything.
    #[default]
    Overview,
    /// What the arm says.
    Arm,
    /// What the hand says.
    Hand,
    /// What the score is made of.
    Score,
}

impl ColumnSet {
    /// All sets.
    pub const ALL: [Self; 4] = [Self::Overview, Self::Arm, Self::Hand, Self::Score];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Overview => "Overview",
            Self::Arm => "Arm",
            Self::Hand => "Hand",
            Self::Score => "Score",
        }
    }

    /// Its columns from left to right.
    pub fn quantities(self) -> &'static [Quantity] {
        use Quantity::*;
        match self {
            Self::Overview => &[MgStart, MgGoal, IkGoal, Epsilon, Success],
            Self::Arm => &[MgStart, MgGoal, MgMean, IkStart, IkGoal],
            Self::Hand => &[Epsilon, Volume, Success, Contacts, Width],
            Self::Score => &[Score, MgMean, Success, Clearance],
        }
    }
}

/// Which candidates are listed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Listed {
    /// The usable ones.
    Accepted,
    /// All of them.
    #[default]
    All,
    /// Those that were dropped.
    Rejected,
}

impl Listed {
    /// All choices.
    pub const ALL: [Self; 3] = [Self::Accepted, Self::All, Self::Rejected];

    fn takes(self, grasp: &Grasp) -> bool {
        match self {
            Self::Accepted => grasp.is_accepted(),
            Self::All => true,
            Self::Rejected => !grasp.is_accepted(),
        }
    }
}

/// How the grasp table is sorted and filtered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableView {
    /// The column that orders the rows.
    pub sort: Column,
    /// Whether the order is turned round.
    pub reversed: bool,
    /// Which candidates are listed.
    pub listed: Listed,
    /// Which numbers are shown.
    pub columns: ColumnSet,
    /// Words that a row has to contain; empty for all rows.
    pub search: String,
}

impl Default for TableView {
    fn default() -> Self {
        Self {
            sort: Column::Number,
            reversed: false,
            listed: Listed::default(),
            columns: ColumnSet::default(),
            search: String::new(),
        }
    }
}

impl TableView {
    /// Sorts by a column, or turns its order round.
    pub(super) fn sort_by(&mut self, column: Column) {
        self.reversed = self.sort == column && !self.reversed;
        self.sort = column;
    }
}

impl ViewerState {
    /// Rows of the grasp table in the order in which they stand, as indices into [`super::Outputs::candidates`].
    pub fn table_rows(&self) -> Vec<usize> {
        let grasps = self.outputs.candidates();
        let words = self.table.search.trim().to_lowercase();
        let mut rows: Vec<usize> = (0..grasps.len()).filter(|&row| self.table.listed.takes(&grasps[row])).collect();
        if !words.is_empty() {
            rows.retain(|&row| self.speaks_of(&grasps[row], &words));
        }
        match self.table.sort {
            Column::Number => {
                // The rejected ones have no rank: they stay last, in the order of their numbers.
                let is_ranked = self.outputs.is_ranked();
                let turned = rows.iter().take_while(|&&row| !is_ranked || grasps[row].is_accepted()).count();
                if self.table.reversed {
                    rows[..turned].reverse();
                }
            }
            Column::Of(quantity) => {
                let (mut known, unknown): (Vec<usize>, Vec<usize>) =
                    rows.into_iter().partition(|&row| quantity.of(&grasps[row]).is_some());
                let sign = if self.table.reversed { 1.0 } else { -1.0 };
                let value = |row: usize| sign * quantity.of(&grasps[row]).unwrap_or(f64::NAN);
                known.sort_by(|&a, &b| value(a).total_cmp(&value(b)));
                known.extend(unknown);
                rows = known;
            }
            Column::Why => {
                rows.sort_by_cached_key(|&row| grasps[row].status.reason());
                if self.table.reversed {
                    rows.reverse();
                }
            }
        }
        rows
    }

    /// Whether what the table says of a grasp contains all words of a search in lower case.
    fn speaks_of(&self, grasp: &Grasp, words: &str) -> bool {
        let why = format::why(grasp, self.outputs.X_WO_start());
        let text = format!("{} {why}", format::status_words(&grasp.status)).to_lowercase();
        words.split_whitespace().all(|word| text.contains(word))
    }

    /// Selects the row so many rows further down.
    pub(super) fn move_selection(&mut self, by: isize) {
        let rows = self.table_rows();
        let grasps = self.outputs.candidates();
        let present = rows.iter().position(|&row| Some(grasps[row].id) == self.selection.grasp);
        let next = present.map_or(0, |row| row.saturating_add_signed(by)).min(rows.len().saturating_sub(1));
        if let Some(id) = rows.get(next).map(|&row| grasps[row].id) {
            self.select_grasp(id);
        }
    }
}
