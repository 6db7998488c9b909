//! Tables on a terminal: aligned columns, those without a single value left out.

use std::fmt;

/// A table that grows row by row.
pub(super) struct Table {
    heads: Vec<&'static str>,
    rows: Vec<Vec<String>>,
    /// Columns of words, which stand to the left; numbers stand to the right.
    words: usize,
}

impl Table {
    /// A table with these heads, the first `words` of them over words; without a line of heads when all are empty.
    pub(super) fn new(words: usize, heads: Vec<&'static str>) -> Self {
        Self { heads, rows: Vec::new(), words }
    }

    /// Adds a row: one text per head, empty where there is nothing to say.
    pub(super) fn push(&mut self, row: Vec<String>) {
        self.rows.push(row);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cell = |row: usize, column: usize| self.rows[row].get(column).map_or("", String::as_str);
        let shown: Vec<usize> =
            (0..self.heads.len()).filter(|&k| (0..self.rows.len()).any(|row| !cell(row, k).is_empty())).collect();
        let width = |column: usize| {
            let cells = (0..self.rows.len()).map(|row| cell(row, column).chars().count());
            cells.chain([self.heads[column].chars().count()]).max().unwrap_or(0)
        };
        let mut line = |text: &dyn Fn(usize) -> String| {
            let cells: Vec<String> = shown
                .iter()
                .map(|&k| {
                    let (text, width) = (text(k), width(k));
                    if k < self.words { format!("{text:<width$}") } else { format!("{text:>width$}") }
                })
                .collect();
            writeln!(f, "{}", cells.join("  ").trim_end())
        };
        if self.heads.iter().any(|head| !head.is_empty()) {
            line(&|k| self.heads[k].to_owned())?;
        }
        (0..self.rows.len()).try_for_each(|row| line(&|k| cell(row, k).to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_empty_ones_left_out() {
        let mut table = Table::new(1, vec!["what", "E_r mm", "t ms", "ΔV %"]);
        table.push(vec!["full".into(), "1.20".into(), String::new(), "0.5".into()]);
        table.push(vec!["partial noisy".into(), "13.00".into(), String::new(), "20.0".into()]);
        let wanted = "what           E_r mm  ΔV %\nfull             1.20   0.5\npartial noisy   13.00  20.0\n";
        assert_eq!(table.to_string(), wanted);
    }
}
