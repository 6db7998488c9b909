//! `cargo xtask test`: everything that must hold, in the order in which a mistake is cheapest to find.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};

use crate::compress::Effort;
use crate::{process, serve, setup, site, wasm};

/// Tells the browser tests where the site is served.
const SITE_VARIABLE: &str = "ENDCOMFORT_SITE";

/// A page that is to open quickly weighs no more than this, in bytes.
const BROTLI_BUDGET: usize = 3_000_000;

/// `cargo xtask test`.
pub(crate) fn command(args: &[String]) -> Result<()> {
    if let Some(arg) = args.first() {
        bail!("`test` has no option {arg:?}: it runs everything");
    }
    let mut steps = Steps(Vec::new());
    steps.run("what the machine needs", setup::for_tests)?;
    steps.run("format", || process::run(process::cargo().args(["fmt", "--all", "--check"])))?;
    steps.run("lints", || {
        process::run(process::cargo().args(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
    })?;
    steps.run("lints of the browser's own code", wasm::clippy)?;
    let folder = steps.run("the site", || {
        let (folder, sizes) = site::build(wasm::Options { quick: false, build_std: false }, Effort::Small)?;
        ensure!(
            sizes.brotli <= BROTLI_BUDGET,
            "the site has {} bytes in brotli, and {BROTLI_BUDGET} are allowed",
            sizes.brotli
        );
        Ok(folder)
    })?;
    let server = serve::Site::start(folder, None)?;
    let tally = steps.run("the tests", || {
        count(process::cargo().args(["test", "--workspace", "--no-fail-fast"]).env(SITE_VARIABLE, server.url()))
    })?;

    println!();
    for (name, duration) in &steps.0 {
        println!("{:>7.1} s  {name}", duration.as_secs_f64());
    }
    println!("{} passed, {} failed, {} ignored", tally.passed, tally.failed, tally.ignored);
    if !tally.succeeded {
        bail!("{} of the tests failed (see above)", tally.failed);
    }
    Ok(())
}

struct Steps(Vec<(&'static str, Duration)>);

impl Steps {
    #[expect(clippy::disallowed_methods, reason = "nothing here runs in a browser")]
    fn run<T>(&mut self, name: &'static str, step: impl FnOnce() -> Result<T>) -> Result<T> {
        println!("\n== {name}");
        let start = Instant::now();
        let result = step().with_context(|| format!("{name}: failed"))?;
        self.0.push((name, start.elapsed()));
        Ok(result)
    }
}

/// What cargo's test programs said.
#[derive(Debug, Default, PartialEq, Eq)]
struct Tally {
    passed: u32,
    failed: u32,
    ignored: u32,
    succeeded: bool,
}

/// Runs the tests, shows what they say as they say it, and adds up their closing lines.
fn count(command: &mut Command) -> Result<Tally> {
    let line = process::line(command);
    let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| format!("cannot start {line}"))?;
    let stdout = child.stdout.take().context("the output of the tests cannot be read")?;
    let mut tally = Tally::default();
    for line in BufReader::new(stdout).lines() {
        let line = line.context("the output of the tests is not text")?;
        writeln!(std::io::stdout(), "{line}")?;
        tally.add(&line);
    }
    tally.succeeded = child.wait()?.success();
    Ok(tally)
}

impl Tally {
    /// Adds a line such as `test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; …`; others count nothing.
    fn add(&mut self, line: &str) {
        let Some((_, result)) = line.split_once("test result: ") else { return };
        for part in result.split(['.', ';']) {
            let mut words = part.split_whitespace();
            let number = words.next().and_then(|word| word.parse::<u32>().ok());
            match (number, words.next()) {
                (Some(number), Some("passed")) => self.passed += number,
                (Some(number), Some("failed")) => self.failed += number,
                (Some(number), Some("ignored")) => self.ignored += number,
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closing_lines_of_several_programs_add_up() {
        let mut tally = Tally::default();
        tally.add("running 3 tests");
        tally.add("test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.31s");
        tally.add("test result: FAILED. 2 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.00s");
        assert_eq!(tally, Tally { passed: 14, failed: 3, ignored: 1, succeeded: false });
    }
}
