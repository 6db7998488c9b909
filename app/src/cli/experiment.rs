//! `experiment`: the thesis's tables, measured again. Those on fitting are here.

use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::builder::PossibleValuesParser;
use endcomfort_core::experiment::{
    Experiment, ExperimentSettings, GraspExperiment, Outcome, Record, Row, Summary, csv, household_views, read_trials,
    run_experiment,
};
use endcomfort_core::object::HouseholdObject;
use endcomfort_core::watch::Watch;

use super::motion_options::PlannerName;
use super::pictures::write_pictures;
use super::table::Table;
use super::views::read_views;
use super::{Common, Failure, experiment_grasps, input};
use crate::assets;
use crate::clock::stopwatch;

/// Progress is shown this often, milliseconds.
const PROGRESS_MS: f64 = 500.0;

#[derive(clap::Args)]
pub(super) struct Args {
    /// Which experiment.
    #[arg(value_parser = PossibleValuesParser::new(possible_values()))]
    name: String,
    /// Trials per condition (and robot); views per object for `objects`. Default: as many as in the thesis's tables,
    /// else 100, 3 views.
    #[arg(long)]
    pub(super) trials: Option<usize>,
    /// Shapes instead of random ones: one line `a b c e1 e2 tx ty tz gamma beta alpha` each, metres and radians.
    #[arg(long, conflicts_with = "trials")]
    trials_file: Option<PathBuf>,
    /// Folder of views (`NAME_view.json` beside its cloud) instead of the bundled objects seen by the robot's camera.
    #[arg(long)]
    views: Option<PathBuf>,
    /// Only this robot, in the experiments on grasps; default: both.
    #[arg(long)]
    pub(super) robot: Option<String>,
    /// Boxes that stand beside the object in each case (experiment `prioritization`).
    #[arg(long)]
    pub(super) clutter: Option<usize>,
    /// Accepts grasps without looking at straight ways in and out, as the thesis does (experiment `prioritization`).
    #[arg(long)]
    pub(super) any_way: bool,
    /// Only these scenarios, such as `butler` or `self_alita`; default: all (experiment `handover`).
    #[arg(long, value_delimiter = ',')]
    pub(super) scenario: Vec<String>,
    /// What plans look for their way with (experiment `motion`).
    #[arg(long, value_enum)]
    pub(super) planner: Option<PlannerName>,
    /// One fit or case after the other on one processor: gives times.
    #[arg(long)]
    pub(super) serial: bool,
    /// One case after the other, each on all processors: gives times as a user sees them, in the experiments on grasps.
    #[arg(long, conflicts_with = "serial")]
    pub(super) in_turn: bool,
    /// File that receives the rows: .csv or .json.
    #[arg(long)]
    pub(super) out: Option<PathBuf>,
    /// File that receives every single fit or case: .csv or .json.
    #[arg(long, visible_alias = "cases")]
    pub(super) fits: Option<PathBuf>,
    /// Folder that receives a picture of every view with its fits side by side, worst first (experiment `objects`).
    #[arg(long)]
    pictures: Option<PathBuf>,
}

fn possible_values() -> Vec<clap::builder::PossibleValue> {
    let fits = Experiment::ALL.map(|experiment| (experiment.name(), experiment.about()));
    let grasps = GraspExperiment::ALL.map(|experiment| (experiment.name(), experiment.about()));
    let value = |(name, about)| clap::builder::PossibleValue::new(name).help(about);
    fits.into_iter().chain(grasps).map(value).collect()
}

pub(super) fn run(args: &Args, common: &Common) -> Result<(), Failure> {
    for file in [&args.out, &args.fits].into_iter().flatten() {
        format_of(file)?;
    }
    if let Some(experiment) = GraspExperiment::ALL.into_iter().find(|experiment| experiment.name() == args.name) {
        return experiment_grasps::run(experiment, args, common);
    }
    let Some(experiment) = Experiment::ALL.into_iter().find(|experiment| experiment.name() == args.name) else {
        return Err(Failure::new(format!("no experiment {:?}", args.name)));
    };
    let settings = settings(experiment, args, common)?;
    let elapsed_ms = stopwatch();
    let outcome = watched(&elapsed_ms, |watch| run_experiment(experiment, &settings, watch))
        .map_err(|refusal| Failure::new(refusal.to_string()))?;
    if let Some(file) = &args.out {
        write_records(file, &outcome.rows)?;
    }
    if let Some(file) = &args.fits {
        write_records(file, &outcome.trials)?;
    }
    if let Some(folder) = &args.pictures {
        write_pictures(folder, &settings.views, &outcome.trials)?;
    }
    if common.json {
        outcome.rows.iter().for_each(|row| println!("{}", row.json()));
    } else {
        print_outcome(experiment, &outcome, &settings, elapsed_ms() * 1e-3);
    }
    Ok(())
}

impl Args {
    /// The options that only experiments on fitting take, those that were given.
    pub(super) fn fitting_options(&self) -> Vec<&'static str> {
        let given = [
            ("--views", self.views.is_some()),
            ("--pictures", self.pictures.is_some()),
            ("--trials-file", self.trials_file.is_some()),
        ];
        given.into_iter().filter(|(_, is_given)| *is_given).map(|(option, _)| option).collect()
    }
}

fn settings(experiment: Experiment, args: &Args, common: &Common) -> Result<ExperimentSettings, Failure> {
    let refuse = |option: &str, takers: &str| {
        Err(Failure::new(format!("{option}: experiment {} has no use for it, {takers}", experiment.name())))
    };
    if args.views.is_some() && !experiment.needs_objects() {
        return refuse("--views", "objects and objectives look at views");
    }
    if args.pictures.is_some() && experiment != Experiment::Objects {
        return refuse("--pictures", "objects draws its views");
    }
    if args.trials_file.is_some() && !experiment.takes_shapes() {
        return refuse("--trials-file", "its trials are views of objects");
    }
    if args.robot.is_some() {
        return refuse("--robot", "it has no robot");
    }
    if args.in_turn {
        return refuse("--in-turn", "one fit runs on one processor: --serial");
    }
    if args.any_way {
        return refuse("--any-way", "nothing is grasped");
    }
    if !args.scenario.is_empty() {
        return refuse("--scenario", "nothing is handed over");
    }
    if args.clutter.is_some() {
        return refuse("--clutter", "nothing is planned");
    }
    let shapes = args.trials_file.as_deref().map(shapes_of).transpose()?;
    let trials = args.trials.unwrap_or(experiment.default_trials());
    let seed = common.seed.unwrap_or(1);
    let views = match &args.views {
        Some(folder) => {
            let (views, notes) = read_views(folder)?;
            notes.iter().for_each(|note| eprintln!("{note}"));
            views
        }
        None if experiment.needs_objects() => {
            let per_object = if experiment == Experiment::Objects { trials } else { 1 };
            household_views(&bundled_objects()?, per_object, seed)
        }
        None => Vec::new(),
    };
    Ok(ExperimentSettings { trials, seed, shapes, is_serial: args.serial, views })
}

fn shapes_of(file: &Path) -> Result<Vec<endcomfort_core::superquadric::Superquadric>, Failure> {
    let bytes = input::read_file(file)?;
    read_trials(&String::from_utf8_lossy(&bytes)).map_err(|error| Failure::new(format!("{}: {error}", file.display())))
}

fn bundled_objects() -> Result<Vec<HouseholdObject>, Failure> {
    let library = assets::library();
    let object = |name| match library.object(name) {
        Ok(object) => Ok(object.as_ref().clone()),
        Err(error) => Err(Failure::new(error.to_string())),
    };
    assets::object_names().into_iter().map(object).collect()
}

/// Runs the work and shows on standard error how far it is: in place on a terminal, a line per tenth elsewhere.
///
/// Nothing is written before the work is done, so interrupting it leaves no half-written file.
pub(super) fn watched<R>(elapsed_ms: &(impl Fn() -> f64 + Sync), work: impl FnOnce(Watch<'_>) -> R) -> R {
    let is_terminal = std::io::stderr().is_terminal();
    let shown = Mutex::new((f64::NEG_INFINITY, 0));
    let progress = |fraction: f64, note: &str| {
        let Ok(mut shown) = shown.lock() else { return };
        let (now_ms, tenth) = (elapsed_ms(), (fraction * 10.0) as u32);
        if is_terminal && (now_ms - shown.0 > PROGRESS_MS || fraction >= 1.0) {
            eprint!("\r{note} ");
        } else if !is_terminal && tenth > shown.1 {
            eprintln!("{note}");
        } else {
            return;
        }
        *shown = (now_ms, tenth);
    };
    let now_ms = || elapsed_ms();
    let outcome = work(Watch::new(&|| false, &progress, &now_ms));
    if is_terminal {
        eprint!("\r{:30}\r", "");
    }
    outcome
}

#[derive(Clone, Copy)]
enum Format {
    Csv,
    Json,
}

fn format_of(file: &Path) -> Result<Format, Failure> {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("csv") => Ok(Format::Csv),
        Some("json") => Ok(Format::Json),
        _ => Err(Failure::new(format!("{}: wanted a file that ends in .csv or .json", file.display()))),
    }
}

/// Writes a table in one go: first beside the file, then in its place.
pub(super) fn write_records<R: Record>(file: &Path, records: &[R]) -> Result<(), Failure> {
    let text = match format_of(file)? {
        Format::Csv => csv(records),
        Format::Json => {
            let lines: Vec<String> = records.iter().map(Record::json).collect();
            format!("[\n{}\n]\n", lines.join(",\n"))
        }
    };
    let mut beside = file.as_os_str().to_owned();
    beside.push(".part");
    let write = || -> std::io::Result<()> {
        let mut part = std::fs::File::create(&beside)?;
        part.write_all(text.as_bytes())?;
        std::fs::rename(&beside, file)
    };
    write().map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
    eprintln!("wrote {} ({} rows)", file.display(), records.len());
    Ok(())
}

fn print_outcome(experiment: Experiment, outcome: &Outcome, settings: &ExperimentSettings, elapsed_s: f64) {
    println!("{}: {}", experiment.name(), experiment.about());
    let source = match (&settings.shapes, experiment.takes_shapes()) {
        (Some(shapes), _) => format!("{} given shapes", shapes.len()),
        (None, true) => format!("{} random shapes", settings.trials),
        (None, false) => String::from("views only"),
    };
    let views = if settings.views.is_empty() { String::new() } else { format!(", {} views", settings.views.len()) };
    let threads = if settings.is_serial { "one fit after the other" } else { "fits side by side, so without times" };
    println!("{source}{views}, seed {}, {threads}, {elapsed_s:.1} s\n", settings.seed);
    print!("{}", table(&outcome.rows));
    let has = |of: fn(&Row) -> bool| outcome.rows.iter().any(of);
    let mut notes = vec![String::from("E_r and ΔV: mean / median / 95 % of the fits.")];
    if has(|row| row.extent_error_m.is_none()) {
        notes.push(String::from("ok: E_r < 1 mm."));
    }
    if has(|row| row.exponents_within.is_some()) {
        notes.push(String::from("e ± 0.1: share of fits with both exponents, up to equivalent parametrisations."));
    }
    if has(|row| row.extent_error_m.is_some()) {
        notes.push(String::from("size: errors of the extents along the object's axes, and the worst of them."));
    }
    if has(|row| row.recognised.is_some()) {
        notes.push(String::from("known: fits with the deformations that the shape has."));
    }
    if has(|row| row.thesis.is_some()) {
        notes.push(String::from("thesis: its own numbers for the same table, not measured here."));
    }
    println!("\n{}", notes.join("\n"));
}

/// The rows for a person, each followed by the thesis's own where it has one.
fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        4,
        vec![
            "",
            "condition",
            "objective",
            "object",
            "fits",
            "ok",
            "E_r mm",
            "|f-1|",
            "(f^e1-1)²",
            "ΔV %",
            "e ± 0.1 %",
            "size mm",
            "worst",
            "known",
            "mirrored",
            "t ms",
        ],
    );
    let is_one_objective = rows.iter().all(|row| Some(row.objective) == rows.first().map(|first| first.objective));
    for row in rows {
        let three = |summary: Option<Summary>, scale: f64| {
            let all = |s: Summary| if row.success > 1 { vec![s.mean, s.median, s.p95] } else { vec![s.mean] };
            let text = |s: Summary| {
                let numbers: Vec<String> = all(s).iter().map(|x| digits(x * scale)).collect();
                numbers.join(" / ")
            };
            summary.map(text).unwrap_or_default()
        };
        let mean = |summary: Option<Summary>| summary.map(|s| short(s.mean)).unwrap_or_default();
        let objective = if is_one_objective { String::new() } else { row.objective.name().to_owned() };
        let has_views = row.extent_error_m.is_some();
        table.push(vec![
            String::new(),
            row.condition.clone(),
            objective.clone(),
            row.object.clone().unwrap_or_default(),
            if row.success == row.trials { row.trials.to_string() } else { format!("{}/{}", row.success, row.trials) },
            if has_views { String::new() } else { row.recovered.to_string() },
            three(row.radial_m, 1e3),
            mean(row.goodness_of_fit_abs),
            mean(row.goodness_of_fit),
            three(row.volume_error_percent, 1.0),
            row.exponents_within_percent().map(|share| format!("{share:.0}")).unwrap_or_default(),
            three(row.extent_error_m, 1e3),
            row.extent_error_max_m.map(|worst| format!("{:.1}", worst * 1e3)).unwrap_or_default(),
            row.recognised.map(|count| count.to_string()).unwrap_or_default(),
            if has_views { row.mirrored.to_string() } else { String::new() },
            three(row.time_s, 1e3),
        ]);
        if let Some(thesis) = &row.thesis {
            let median = thesis.radial_median_m.map_or(String::from("-"), |m| format!("{:.2}", m * 1e3));
            let mut line = vec![String::new(); 16];
            line[0] = String::from("thesis");
            line[1] = row.condition.clone();
            line[2] = objective;
            line[4] = String::from("500");
            line[6] = format!("{:.2} / {median} / -", thesis.radial_mean_m * 1e3);
            line[7] = thesis.goodness_of_fit_abs_mean.map(short).unwrap_or_default();
            line[9] = format!("{:.2} / - / -", thesis.volume_error_mean_percent);
            line[15] = format!("{:.0} / - / -", thesis.time_mean_s * 1e3);
            table.push(line);
        }
    }
    table
}

/// Three significant digits of a number of everyday size.
pub(super) fn digits(x: f64) -> String {
    match x.abs() {
        size if size >= 1e5 => format!("{x:.1e}"),
        size if size >= 100.0 => format!("{x:.0}"),
        size if size >= 10.0 => format!("{x:.1}"),
        size if size >= 1.0 => format!("{x:.2}"),
        _ => format!("{x:.3}"),
    }
}

/// Three or four digits of a number that may be tiny or huge.
fn short(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e4).contains(&x.abs()) { format!("{x:.1e}") } else { format!("{x:.3}") }
}
