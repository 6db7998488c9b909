//! A sheet of charts as SVG: lines and words that a paper can take as they are, in the colours of the light theme.

use std::fmt::Write as _;

use super::chart::{Axis, Chart, Sheet};

const WIDTH: f64 = 720.0;
const LEFT: f64 = 66.0;
const RIGHT: f64 = 18.0;
const TITLE: f64 = 30.0;
const KEY: f64 = 22.0;
/// Above a field: its title and legend.
const HEAD: f64 = 20.0;
/// Below a field with numbers and words at its axis, and below one without.
const FOOT: [f64; 2] = [12.0, 46.0];
const INK: &str = "#1d2329";
const PALE_INK: &str = "#5f6973";
const GRID: &str = "#e4e7e6";
const FRAME: &str = "#a3abb2";
const LIMIT: &str = "#c23e31";
/// Width of a letter, in sizes of the font: a little more than the mean of usual fonts.
const LETTER: f64 = 0.56;

/// The text of the file.
pub(super) fn svg(sheet: &Sheet) -> String {
    let key = if sheet.key.is_empty() { 0.0 } else { KEY };
    let count = sheet.charts.len();
    let foot = |index: usize| FOOT[usize::from(!sheet.shares_x || index + 1 == count)];
    let body: f64 = (0..count).map(|index| HEAD + sheet.height + foot(index)).sum();
    let height = TITLE + key + body;
    let mut page = Page { text: String::new() };
    page.line(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} \
         {height}\" font-family=\"Inter, Helvetica, Arial, sans-serif\">"
    ));
    page.line(&format!("<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#ffffff\"/>"));
    page.words([LEFT, 20.0], &sheet.title, (14.0, "600", INK, "start"));
    if !sheet.key.is_empty() {
        page.key([LEFT, TITLE + 12.0], &sheet.key);
    }
    let mut top = TITLE + key;
    for (index, chart) in sheet.charts.iter().enumerate() {
        let has_foot = foot(index) == FOOT[1];
        page.chart(chart, Field { top: top + HEAD, height: sheet.height }, has_foot);
        top += HEAD + sheet.height + foot(index);
    }
    page.line("</svg>");
    page.text
}

/// Where a chart's field lies on the page.
#[derive(Clone, Copy)]
struct Field {
    top: f64,
    height: f64,
}

impl Field {
    fn x(self, axis: &Axis, value: f64) -> f64 {
        LEFT + (WIDTH - LEFT - RIGHT) * axis.share(value).max(0.0).min(1.0)
    }

    fn y(self, axis: &Axis, value: f64) -> f64 {
        self.top + self.height * (1.0 - axis.share(value).max(-0.02).min(1.02))
    }

    fn bottom(self) -> f64 {
        self.top + self.height
    }
}

struct Page {
    text: String,
}

/// Size in pixels, weight, colour and anchor of words.
type Face<'a> = (f64, &'a str, &'a str, &'a str);

impl Page {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn words(&mut self, [x, y]: [f64; 2], words: &str, (size, weight, color, anchor): Face<'_>) {
        let words = escaped(words);
        self.line(&format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" font-weight=\"{weight}\" fill=\"{color}\" \
             text-anchor=\"{anchor}\">{words}</text>"
        ));
    }

    fn stroke(&mut self, [x0, y0, x1, y1]: [f64; 4], (color, width): (&str, f64), dashes: &str) {
        self.line(&format!(
            "<line x1=\"{x0:.2}\" y1=\"{y0:.2}\" x2=\"{x1:.2}\" y2=\"{y1:.2}\" stroke=\"{color}\" \
             stroke-width=\"{width}\"{dashes}/>"
        ));
    }

    fn rect(&mut self, [x, y, width, height]: [f64; 4], color: &str) {
        self.line(&format!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{color}\"/>"
        ));
    }

    /// Swatches with their words, side by side.
    fn key(&mut self, [mut x, y]: [f64; 2], entries: &[(String, String)]) {
        for (words, color) in entries {
            self.rect([x, y - 8.0, 9.0, 9.0], color);
            self.words([x + 13.0, y], words, (11.0, "400", PALE_INK, "start"));
            x += 13.0 + LETTER * 11.0 * words.chars().count() as f64 + 14.0;
        }
    }

    fn chart(&mut self, chart: &Chart, field: Field, has_foot: bool) {
        let right = WIDTH - RIGHT;
        self.words([LEFT, field.top - 6.0], &chart.title, (11.0, "600", INK, "start"));
        self.legend(chart, field.top - 6.0);
        let few = if field.height < 100.0 { 3 } else { 6 };
        for value in chart.y.ticks(few) {
            let y = field.y(&chart.y, value);
            self.stroke([LEFT, y, right, y], (GRID, 1.0), "");
            self.words([LEFT - 7.0, y + 3.5], &number(value), (10.0, "400", PALE_INK, "end"));
        }
        for value in chart.x.ticks(9) {
            let x = field.x(&chart.x, value);
            self.stroke([x, field.top, x, field.bottom()], (GRID, 1.0), "");
            if has_foot {
                self.words([x, field.bottom() + 18.0], &number(value), (10.0, "400", PALE_INK, "middle"));
            }
        }
        for bar in &chart.bars {
            let (x0, x1) = (field.x(&chart.x, bar.from), field.x(&chart.x, bar.to));
            let y = field.y(&chart.y, bar.height);
            // The outline keeps pale bars apart from the paper.
            let (x, width, height) = (x0 + 0.75, (x1 - x0 - 1.5).max(0.5), field.bottom() - y);
            self.line(&format!(
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{}\" \
                 stroke=\"{FRAME}\" stroke-width=\"0.5\"/>",
                bar.color
            ));
        }
        for limit in &chart.limits {
            let y = field.y(&chart.y, *limit);
            self.stroke([LEFT, y, right, y], (LIMIT, 1.0), " stroke-dasharray=\"5 3\"");
        }
        for line in &chart.lines {
            let mut points = String::new();
            let mut last: Option<[f64; 2]> = None;
            for &(x, y) in line.points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
                let at = [field.x(&chart.x, x), field.y(&chart.y, y)];
                // A third of a pixel apart is enough.
                if last.is_none_or(|last| (at[0] - last[0]).hypot(at[1] - last[1]) >= 0.33) {
                    let _ = write!(points, "{:.2},{:.2} ", at[0], at[1]);
                    last = Some(at);
                }
            }
            self.line(&format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"/>",
                points.trim_end(),
                line.color,
                line.width
            ));
        }
        for strip in &chart.strips {
            let (x0, x1) = (field.x(&chart.x, strip.from), field.x(&chart.x, strip.to));
            self.rect([x0, field.bottom() + 2.0, (x1 - x0 - 0.5).max(0.5), 4.0], &strip.color);
        }
        self.line(&format!(
            "<rect x=\"{LEFT}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"none\" stroke=\"{FRAME}\"/>",
            field.top,
            right - LEFT,
            field.height
        ));
        if has_foot {
            let middle = 0.5 * (LEFT + right);
            self.words([middle, field.bottom() + 37.0], &chart.x.label, (11.0, "400", INK, "middle"));
        }
        if chart.y.label.is_empty() {
            return;
        }
        let (x, y) = (15.0, field.top + 0.5 * field.height);
        self.line(&format!(
            "<text x=\"{x}\" y=\"{y:.1}\" font-size=\"11\" fill=\"{INK}\" text-anchor=\"middle\" \
             transform=\"rotate(-90 {x} {y:.1})\">{}</text>",
            escaped(&chart.y.label)
        ));
    }

    /// Names of the curves, from right to left, above the field.
    fn legend(&mut self, chart: &Chart, y: f64) {
        let mut x = WIDTH - RIGHT;
        for line in chart.lines.iter().rev().filter(|line| !line.name.is_empty()) {
            let words = &line.name;
            let width = LETTER * 11.0 * words.chars().count() as f64;
            self.words([x, y], words, (11.0, "400", PALE_INK, "end"));
            let left = x - width - 20.0;
            self.stroke([left, y - 3.5, left + 15.0, y - 3.5], (&line.color, line.width.max(1.5)), "");
            x = left - 12.0;
        }
    }
}

/// A round number without idle zeros, with a true minus.
fn number(value: f64) -> String {
    let size = value.abs();
    let text = if size != 0.0 && !(1e-3..1e5).contains(&size) {
        format!("{value:e}")
    } else {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
}

/// Words as XML takes them.
fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_words_are_escaped() {
        let told = [0.1 + 0.2, -2.5, 0.0, -0.0, 40.0, 1e-5, 120_000.0].map(number);
        assert_eq!(told, ["0.3", "−2.5", "0", "0", "40", "1e−5", "1.2e5"]);
        assert_eq!(escaped("a < b & \"c\""), "a &lt; b &amp; &quot;c&quot;");
    }
}
