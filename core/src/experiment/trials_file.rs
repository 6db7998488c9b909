//! Trials from a file instead of random ones, so that several programs can be given the same.

use super::protocol::posed;
use crate::superquadric::{Superquadric, SuperquadricError};

/// The numbers of a line, in order.
const NAMES: [&str; 11] = ["a", "b", "c", "e1", "e2", "tx", "ty", "tz", "gamma", "beta", "alpha"];
/// More than anybody waits for.
const MAX_TRIALS: usize = 1_000_000;

/// Why a file holds no trials.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrialsFileError {
    /// A line has too few or too many numbers.
    #[error("line {line}: found {found} numbers, wanted 11: {}", NAMES.join(" "))]
    Count { line: usize, found: usize },
    /// A word is not a finite number.
    #[error("line {line}, {name}: found {found:?}, wanted a finite number")]
    Number { line: usize, name: &'static str, found: String },
    /// The numbers describe no superquadric.
    #[error("line {line}: {source}")]
    Shape { line: usize, source: SuperquadricError },
    /// Nothing but blank lines and comments.
    #[error("found no trial in {lines} lines, wanted at least one line of {}", NAMES.join(" "))]
    Empty { lines: usize },
    /// Too many.
    #[error("line {line}: found more than {MAX_TRIALS} trials")]
    TooMany { line: usize },
}

/// The shapes of a trials file: one line `a b c e1 e2 tx ty tz gamma beta alpha` each, metres and radians.
///
/// Numbers are separated by blanks, tabs or commas, `#` starts a comment, blank lines are skipped. The rotation is
/// `Rz(alpha) Ry(beta) Rx(gamma)`.
///
/// # Errors
/// [`TrialsFileError`] names the line, what was found and what was wanted.
pub fn read_trials(text: &str) -> Result<Vec<Superquadric>, TrialsFileError> {
    let mut shapes = Vec::new();
    let lines = text.trim_start_matches('\u{feff}').lines();
    for (line, content) in (1..).zip(lines) {
        let content = content.split('#').next().unwrap_or_default();
        let words: Vec<&str> = content.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        if words.len() != NAMES.len() {
            return Err(TrialsFileError::Count { line, found: words.len() });
        }
        if shapes.len() == MAX_TRIALS {
            return Err(TrialsFileError::TooMany { line });
        }
        let mut numbers = [0.0; 11];
        for ((number, word), name) in numbers.iter_mut().zip(words).zip(NAMES) {
            *number = (word.parse().ok().filter(|x: &f64| x.is_finite())).ok_or_else(|| TrialsFileError::Number {
                line,
                name,
                found: word.to_owned(),
            })?;
        }
        let [a, b, c, e1, e2, x, y, z, gamma, beta, alpha] = numbers;
        let shape = Superquadric::new(a, b, c, e1, e2, posed([x, y, z], gamma, beta, alpha));
        shapes.push(shape.map_err(|source| TrialsFileError::Shape { line, source })?);
    }
    if shapes.is_empty() { Err(TrialsFileError::Empty { lines: text.lines().count() }) } else { Ok(shapes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_with_comments_are_read() {
        let text = "# a b c ...\r\n\n0.1 0.2,0.3\t1 0.5  0 0 1  0 0 1.5 # first\n0.1 0.2 0.3 1 0.5 0 0 1 0 0 0";
        let shapes = read_trials(text).unwrap();
        assert_eq!(shapes.len(), 2);
        assert_eq!([shapes[0].a, shapes[0].e2, shapes[0].X_FS.translation.z], [0.1, 0.5, 1.0]);
        assert!((shapes[0].X_FS.rotation.angle() - 1.5).abs() < 1e-12);
    }

    #[test]
    fn bad_lines_are_named() {
        let good = "0.1 0.2 0.3 1 0.5 0 0 1 0 0 0\n";
        for (line, expected) in [
            ("0.1 0.2 0.3", "line 3: found 3 numbers, wanted 11: a b c e1"),
            ("0.1 0.2 0.3 1 0.5 0 0 1 0 0 0 7", "line 3: found 12 numbers"),
            ("0.1 0.2 0.3 1 0.5 0 0 1 0 zero 0", "line 3, beta: found \"zero\", wanted a finite number"),
            ("0.1 0.2 0.3 1 0.5 0 0 NaN 0 0 0", "line 3, tz: found \"NaN\""),
            ("0.1 0.2 0.3 3 0.5 0 0 1 0 0 0", "line 3: exponent e1 is 3, wanted 0.01 to 1.99"),
            ("-0.1 0.2 0.3 1 0.5 0 0 1 0 0 0", "line 3: semi-axis a is -0.1"),
        ] {
            let message = read_trials(&format!("# head\n{good}{line}\n{good}")).unwrap_err().to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
        assert_eq!(read_trials("# only\n\n"), Err(TrialsFileError::Empty { lines: 2 }));
        assert_eq!(read_trials(""), Err(TrialsFileError::Empty { lines: 0 }));
    }
}
