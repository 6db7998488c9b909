//! `plot`: any plot of the interface as SVG.

use std::path::PathBuf;

use clap::builder::PossibleValue;

use super::saved::{Of, write};
use super::{Common, Failure};
use crate::export::{PlotKind, plot_svg};

#[derive(clap::Args)]
pub(super) struct Args {
    /// Which plot.
    plot: PlotKind,
    #[command(flatten)]
    of: Of,
    /// Cluster whose fit is plotted; the one that is grasped without it.
    #[arg(long)]
    cluster: Option<usize>,
    /// File that receives it: .svg; standard output without one.
    #[arg(long, value_parser = plot_file)]
    out: Option<PathBuf>,
}

impl clap::ValueEnum for PlotKind {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

fn plot_file(text: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(text);
    match file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg")) {
        true => Ok(file),
        false => Err("wanted a file that ends in .svg".to_owned()),
    }
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    let found = args.of.find(args.plot.stage(), false, common)?;
    let text = plot_svg(&found.results(), &found.scene, args.plot, args.cluster).map_err(Failure::new)?;
    write(&text, args.out.as_ref())
}
