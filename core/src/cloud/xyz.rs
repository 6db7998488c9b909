//! Reading XYZ text: three or more columns, with or without colours, comments and a line of column names.

use super::error::excerpt;
use super::packed::Collector;
use super::read::MAX_POINTS;
use super::scalar::{numbered_lines, parse_number};
use super::{CloudError, PointCloud};
use crate::loaded::Loaded;

/// Marks that start a comment.
const COMMENTS: [&str; 4] = ["#", "//", "%", ";"];

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_ascii_whitespace() || c == ',' || c == ';').filter(|word| !word.is_empty())
}

fn is_comment(text: &str) -> bool {
    let text = text.trim_start();
    text.is_empty() || COMMENTS.iter().any(|mark| text.starts_with(mark))
}

/// Whether the first line with content is made of three or more numbers.
pub(super) fn looks_like_xyz(bytes: &[u8]) -> bool {
    numbered_lines(bytes.get(..4096).unwrap_or(bytes), 1)
        .filter_map(|(_, line)| str::from_utf8(line).ok())
        .find(|text| !is_comment(text))
        .is_some_and(|text| words(text).count() >= 3 && words(text).all(|word| word.parse::<f64>().is_ok()))
}

/// Reads text with x, y and z in the first three columns.
///
/// Columns are separated by blanks, tabs, commas or semicolons. The last three of six or seven columns are colours
/// when all of them are whole numbers up to 255 and one is greater than 1; else they count as normals and are left out.
/// One line of column names, or of a single number (the count of a PTS file), may come first.
pub(super) fn read_xyz(bytes: &[u8]) -> Result<Loaded<PointCloud>, CloudError> {
    let mut notes = Vec::new();
    // Five digits and separators are the shortest line: "0 0 0".
    let mut points = Collector::new((bytes.len() / 16).min(MAX_POINTS));
    let mut are_colors = true;
    let mut brightest = 0;
    let mut first = true;
    for (line, raw) in numbered_lines(bytes, 1) {
        let text = str::from_utf8(raw).map_err(|_| CloudError::Line {
            line,
            thing: "XYZ text",
            found: excerpt(&String::from_utf8_lossy(raw)),
            wanted: String::from("numbers"),
        })?;
        if is_comment(text) {
            continue;
        }
        let columns = words(text).count();
        if std::mem::take(&mut first) {
            let name_like = words(text).all(|word| word.parse::<f64>().is_err());
            if name_like || columns == 1 {
                notes.push(format!("line {line} was taken as a heading: {}", excerpt(text)));
                continue;
            }
        }
        if columns < 3 {
            return Err(CloudError::Line {
                line,
                thing: "a point",
                found: excerpt(text),
                wanted: String::from("three numbers: x y z"),
            });
        }
        if points.read() == MAX_POINTS {
            return Err(CloudError::TooManyPoints { line, found: MAX_POINTS as u64 + 1, limit: MAX_POINTS });
        }
        let mut xyz = [0.0; 3];
        for ((value, word), thing) in xyz.iter_mut().zip(words(text)).zip(["x", "y", "z"]) {
            *value = parse_number(word, line, thing)?;
        }
        let color = match columns {
            6 | 7 => color_of(words(text).skip(columns - 3)),
            _ => None,
        };
        are_colors &= color.is_some();
        brightest = color.iter().flatten().copied().fold(brightest, u8::max);
        let [x, y, z] = xyz;
        points.push(x, y, z, color.or(Some([0; 3])));
    }
    if !are_colors || brightest <= 1 {
        points.drop_colors();
    }
    let value = points.finish(None, &mut notes)?;
    Ok(Loaded { value, notes })
}

fn color_of<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<[u8; 3]> {
    let mut next = || words.next()?.parse().ok();
    Some([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_comments_names_and_colours_are_understood() {
        let loaded = read_xyz(b"x, y, z, r, g, b\n# a comment\n1, 2, 3, 255, 0, 7\r\n\n4;5;6;1;2;3\n").unwrap();
        assert_eq!(loaded.value.points.len(), 2);
        assert_eq!(loaded.value.colors, [[255, 0, 7], [1, 2, 3]]);
        assert_eq!(loaded.notes.len(), 1);
    }

    #[test]
    fn normals_are_not_taken_for_colours() {
        assert!(read_xyz(b"1 2 3 0 0 1\n4 5 6 0 1 0\n").unwrap().value.colors.is_empty());
        assert!(read_xyz(b"1 2 3 0.5 0.5 -0.7\n").unwrap().value.colors.is_empty());
    }

    #[test]
    fn a_bad_number_is_named_with_its_line() {
        let error = read_xyz(b"1 2 3\n4 five 6\n").unwrap_err();
        assert_eq!(error.to_string(), "line 2: y: found \"five\", wanted a number");
        assert!(matches!(read_xyz(b"1 2 3\n4 5\n"), Err(CloudError::Line { line: 2, .. })));
        assert!(matches!(read_xyz(b"# nothing\n"), Err(CloudError::NoPoints { read: 0, .. })));
    }
}
