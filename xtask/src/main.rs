mod compress;
mod figures;
mod process;
mod robots;
mod serve;
mod setup;
mod site;
mod suite;
mod thumbnail;
mod wasm;

use std::process::ExitCode;

use anyhow::{Result, bail};

const USAGE: &str = "\
cargo xtask serve [--port N] [--no-open] [--as-is] [--quick] [--build-std]
    builds the site and serves it on 127.0.0.1; --as-is serves dist/ without building,
    --quick trades size and speed of the page for build time
cargo xtask dist [--build-std]
    writes the static site to dist/, each file with .br and .gz beside it
cargo xtask test
    everything that must hold: format, lints, tests, the site, a real browser
cargo xtask figures
    draws the pictures of the gallery and of the README
cargo xtask robots
    writes the meshes of the robots to robots/meshes/

--build-std builds the wasm standard library from Debian's sources even where rustup has it.";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match dispatch(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(args: &[String]) -> Result<()> {
    let Some((command, rest)) = args.split_first() else {
        println!("{USAGE}");
        return Ok(());
    };
    match command.as_str() {
        "serve" => serve::command(rest),
        "dist" => site::command(rest),
        "test" => suite::command(rest),
        "figures" => figures::command(rest),
        "robots" => robots::run(&process::root()),
        "help" | "--help" | "-h" => {
            println!("{USAGE}");
            Ok(())
        }
        other => bail!("no command {other:?}; there are:\n{USAGE}"),
    }
}
