//! What every bench prints: one line per measured thing, with its problem set, seed, sample count and quantiles.

use std::sync::OnceLock;
use std::time::Instant;

/// Lines of one bench, printed as an aligned table, or as one JSON object per line with `--json`.
pub(crate) struct Report {
    bench: &'static str,
    seed: String,
    lines: Vec<Line>,
}

struct Line {
    problem: String,
    what: String,
    unit: &'static str,
    sorted: Vec<f64>,
    note: String,
}

impl Report {
    /// An empty report.
    pub(crate) fn new(bench: &'static str, seed: impl ToString) -> Self {
        Self { bench, seed: seed.to_string(), lines: Vec::new() }
    }

    /// Adds samples of one thing on one problem set; the note says what was checked outside the timed part.
    pub(crate) fn add(
        &mut self,
        problem: impl ToString,
        what: impl ToString,
        unit: &'static str,
        samples: impl IntoIterator<Item = f64>,
        note: impl ToString,
    ) {
        let mut sorted: Vec<f64> = samples.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (problem, what, note) = (problem.to_string(), what.to_string(), note.to_string());
        self.lines.push(Line { problem, what, unit, sorted, note });
    }

    /// Prints the report on standard output.
    pub(crate) fn print(&self) {
        if std::env::args().any(|argument| argument == "--json") {
            return self.lines.iter().for_each(|line| println!("{}", self.json(line)));
        }
        let rows = self.lines.iter().map(|line| {
            let numbers = [0.5, 0.75, 0.95].map(|share| short(line.quantile(share)));
            let [median, p75, p95] = numbers;
            let count = line.sorted.len().to_string();
            [line.problem.clone(), line.what.clone(), count, median, p75, p95, line.unit.to_owned(), line.note.clone()]
        });
        let head = ["problem set", "what", "n", "median", "75 %", "95 %", "", "checked"].map(str::to_owned);
        let rows: Vec<[String; 8]> = std::iter::once(head).chain(rows).collect();
        let width: Vec<usize> =
            (0..8).map(|k| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0)).collect();
        println!("{}, seed {}", self.bench, self.seed);
        for row in &rows {
            let cells: Vec<String> = (row.iter().zip(&width).enumerate())
                .map(|(k, (text, width))| match k {
                    2..=5 => format!("{text:>width$}"),
                    _ => format!("{text:<width$}"),
                })
                .collect();
            println!("  {}", cells.join("  ").trim_end());
        }
        println!();
    }

    fn json(&self, line: &Line) -> serde_json::Value {
        serde_json::json!({
            "bench": self.bench, "seed": self.seed, "problem": line.problem, "what": line.what, "unit": line.unit,
            "samples": line.sorted.len(), "median": line.quantile(0.5), "p75": line.quantile(0.75),
            "p95": line.quantile(0.95), "checked": line.note,
        })
    }
}

impl Line {
    /// The value that this share of the samples does not exceed; NaN for no sample.
    fn quantile(&self, share: f64) -> f64 {
        let rank = (share * self.sorted.len() as f64).ceil() as usize;
        self.sorted.get(rank.max(1) - 1).copied().unwrap_or(f64::NAN)
    }
}

/// Three significant digits, without an exponent.
fn short(x: f64) -> String {
    match x.abs() {
        size if size >= 100.0 => format!("{x:.0}"),
        size if size >= 10.0 => format!("{x:.1}"),
        size if size >= 1.0 => format!("{x:.2}"),
        _ => format!("{x:.4}"),
    }
}

/// Milliseconds since the first call.
pub(crate) fn now_ms() -> f64 {
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    #[expect(clippy::disallowed_methods, reason = "a native bench reads the clock")]
    let begin = BEGIN.get_or_init(Instant::now);
    begin.elapsed().as_secs_f64() * 1e3
}
