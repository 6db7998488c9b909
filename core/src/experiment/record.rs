//! Results as named cells: one JSON object or one CSV line each, the same names in both.

use serde::Serialize;
use serde::ser::{SerializeMap as _, Serializer};

/// One named value of a result.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A whole number.
    Count(usize),
    /// A measure in the unit that its name ends in.
    Number(f64),
    /// Yes or no.
    Flag(bool),
    /// Does not apply: left out of JSON, empty in CSV.
    Nothing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<bool> for Cell {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Nothing, Into::into)
    }
}

/// A result that can be written to a file.
pub trait Record {
    /// Its cells with their names, always the same names in the same order.
    fn cells(&self) -> Vec<(&'static str, Cell)>;

    /// One JSON object; cells that do not apply are left out, and numbers that are not finite are null.
    fn json(&self) -> String {
        // Text, numbers and flags under distinct names always serialise.
        serde_json::to_string(&Cells(self.cells())).unwrap_or_default()
    }
}

/// A table with one header line; the cells of every record, `,` between them, text in quotes where it needs them.
pub fn csv<R: Record>(records: &[R]) -> String {
    let mut text = String::new();
    for (number, record) in records.iter().enumerate() {
        let cells = record.cells();
        if number == 0 {
            let names: Vec<&str> = cells.iter().map(|(name, _)| *name).collect();
            text.push_str(&names.join(","));
            text.push('\n');
        }
        let fields: Vec<String> = cells.iter().map(|(_, cell)| field(cell)).collect();
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

fn field(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) if text.contains([',', '"', '\n']) => format!("\"{}\"", text.replace('"', "\"\"")),
        Cell::Text(text) => text.clone(),
        Cell::Count(count) => count.to_string(),
        Cell::Number(number) => number.to_string(),
        Cell::Flag(flag) => flag.to_string(),
        Cell::Nothing => String::new(),
    }
}

struct Cells(Vec<(&'static str, Cell)>);

impl Serialize for Cells {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, cell) in &self.0 {
            match cell {
                Cell::Text(text) => map.serialize_entry(name, text)?,
                Cell::Count(count) => map.serialize_entry(name, count)?,
                Cell::Number(number) => map.serialize_entry(name, number)?,
                Cell::Flag(flag) => map.serialize_entry(name, flag)?,
                Cell::Nothing => (),
            }
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Row;

    impl Record for Row {
        fn cells(&self) -> Vec<(&'static str, Cell)> {
            vec![
                ("name", "a, \"b\"".into()),
                ("trials", 3_usize.into()),
                ("radial_m", 0.1.into()),
                ("time_s", Cell::from(None::<f64>)),
                ("good", true.into()),
                ("bad", f64::INFINITY.into()),
            ]
        }
    }

    #[test]
    fn json_leaves_out_what_does_not_apply_and_keeps_the_order() {
        assert_eq!(Row.json(), r#"{"name":"a, \"b\"","trials":3,"radial_m":0.1,"good":true,"bad":null}"#);
    }

    #[test]
    fn csv_quotes_what_would_break_a_line() {
        assert_eq!(
            csv(&[Row, Row]),
            "name,trials,radial_m,time_s,good,bad\n\"a, \"\"b\"\"\",3,0.1,,true,inf\n\"a, \"\"b\"\"\",3,0.1,,true,inf\n"
        );
        assert_eq!(csv::<Row>(&[]), "");
    }
}
