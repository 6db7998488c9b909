//! `table`: any table of the interface as CSV or JSON.

use std::path::PathBuf;

use clap::builder::PossibleValue;

use super::saved::{Of, write};
use super::{Common, Failure};
use crate::export::{TableFormat, TableKind, table_lines, table_text};

#[derive(clap::Args)]
pub(super) struct Args {
    /// Which table.
    table: TableKind,
    #[command(flatten)]
    of: Of,
    /// File that receives it: .csv or .json; standard output without one.
    #[arg(long, value_parser = table_file)]
    out: Option<PathBuf>,
}

impl clap::ValueEnum for TableKind {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(self.title()))
    }
}

fn format_of(file: &std::path::Path) -> Option<TableFormat> {
    TableFormat::of_extension(file.extension()?.to_str()?)
}

fn table_file(text: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(text);
    match format_of(&file) {
        Some(_) => Ok(file),
        None => Err("wanted a file that ends in .csv or .json".to_owned()),
    }
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let found = match args.table.stage() {
        Some(stage) => args.of.find(stage, args.table == TableKind::Objectives, common)?,
        None => args.of.maps(common)?,
    };
    let results = found.results();
    if let Some((file, format)) = args.out.as_ref().and_then(|file| Some((file, format_of(file)?))) {
        let text = table_text(&results, args.table, format).map_err(Failure::new)?;
        return write(&text, Some(file));
    }
    let text = match common.json {
        true => table_lines(&results, args.table).map(|lines| lines.join("\n") + "\n"),
        false => table_text(&results, args.table, TableFormat::Csv),
    };
    write(&text.map_err(Failure::new)?, None)
}
