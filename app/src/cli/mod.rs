//! The command line: one file per subcommand, one JSON object per line on request.

mod check;
mod depth_options;
mod experiment;
mod experiment_grasps;
mod film_options;
mod fit;
mod grasp_options;
mod grasps;
mod ik;
mod input;
mod look_options;
mod motion_options;
mod pictures;
mod plan;
mod plot;
mod reach;
mod reach_options;
mod render;
mod robot_options;
mod saved;
mod segment;
mod start_options;
mod table;
mod tables;
mod views;
mod window;

use std::fmt;
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use endcomfort_core::job::Refusal;
use endcomfort_core::task::Try;

/// See a robot decide how to grasp. Without a subcommand the window opens.
#[derive(Parser)]
#[command(name = "endcomfort", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    common: Common,
}

/// Options of every subcommand.
#[derive(clap::Args, Clone)]
struct Common {
    /// Seed of everything random.
    #[arg(long, global = true)]
    seed: Option<u64>,
    /// One JSON object per line on standard output: SI units, snake case.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Opens the window with a demo or with what a link holds.
    View(window::Args),
    /// Finds the table plane and the clusters on it.
    Segment(segment::Args),
    /// Fits a superquadric to each cloud.
    Fit(fit::Args),
    /// Ranks the grasps of an object.
    Grasps(Box<grasps::Args>),
    /// Plans a task.
    Plan(Box<plan::Args>),
    /// Builds the reachability maps of a robot's arms, or says what is in a map's file.
    Reach(reach::Args),
    /// Draws one picture without a window.
    Render(Box<render::Args>),
    /// Writes a table of the interface: clusters, fits, phases, joints and so on.
    Table(tables::Args),
    /// Writes a plot of the interface as SVG.
    Plot(plot::Args),
    /// Measures the thesis's tables again.
    Experiment(experiment::Args),
    /// Solves a file of hand poses for the joints of a robot's arm.
    Ik(ik::Args),
    /// Loads files and says what they hold and what is wrong with them.
    Check(check::Args),
}

/// Which arm acts.
#[derive(Clone, Copy, ValueEnum)]
enum ArmName {
    Left,
    Right,
}

impl From<ArmName> for endcomfort_core::scene::ArmChoice {
    fn from(name: ArmName) -> Self {
        match name {
            ArmName::Left => Self::Left,
            ArmName::Right => Self::Right,
        }
    }
}

/// A "no" that the user can act on: exit code 1.
#[derive(Debug)]
struct Failure {
    message: String,
    details: Vec<String>,
    tries: Vec<Try>,
}

impl Failure {
    fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), details: Vec::new(), tries: Vec::new() }
    }

    fn with_details(self, details: Vec<String>) -> Self {
        Self { details, ..self }
    }

    /// The failure as a JSON object with a stage of the pipeline, if there is one.
    fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "status": "refused", "reason": self.message, "details": self.details, "tries": self.tries,
        })
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        self.details.iter().try_for_each(|line| write!(f, "\n  {line}"))
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        Self { message: refusal.message, details: refusal.details, tries: refusal.tries }
    }
}

/// Runs the program and gives its exit code: 0 done, 1 refused, 2 bad usage.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let common = cli.common;
    let outcome = match cli.command {
        None => window::run(window::Args::default()),
        Some(Command::View(args)) => window::run(args),
        Some(Command::Segment(args)) => segment::run(&args, &common),
        Some(Command::Fit(args)) => fit::run(&args, &common),
        Some(Command::Grasps(args)) => grasps::run(&args, &common),
        Some(Command::Plan(args)) => plan::run(&args, &common),
        Some(Command::Reach(args)) => reach::run(&args, &common),
        Some(Command::Render(args)) => render::run(&args, &common),
        Some(Command::Table(args)) => tables::run(&args, &common),
        Some(Command::Plot(args)) => plot::run(&args, &common),
        Some(Command::Experiment(args)) => experiment::run(&args, &common),
        Some(Command::Ik(args)) => ik::run(&args, &common),
        Some(Command::Check(args)) => check::run(&args, &common),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if common.json {
                println!("{}", failure.json());
            }
            eprintln!("endcomfort: {failure}");
            ExitCode::FAILURE
        }
    }
}
