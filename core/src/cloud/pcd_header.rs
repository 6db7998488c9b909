//! The header of a PCD file.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::CloudError;
use super::error::excerpt;
use super::read::MAX_POINTS;
use super::scalar::{Scalar, parse_number};

/// A header longer than this is not a header.
const MAX_HEADER_BYTES: usize = 64 * 1024;
/// More fields than any known point type has.
const MAX_FIELDS: usize = 256;
/// Bytes of one point; the largest known descriptor has 1 980 floats.
const MAX_POINT_BYTES: usize = 64 * 1024;

/// How the points are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Data {
    Ascii,
    Binary,
    BinaryCompressed,
}

/// One field of a point.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// How many numbers the field has.
    pub(super) count: usize,
    /// Bytes before the field within a point.
    pub(super) offset: usize,
    /// Numbers before the field within a point.
    pub(super) column: usize,
}

/// A header whose numbers agree with each other.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) fields: Vec<Field>,
    /// Bytes of one point.
    pub(super) stride: usize,
    /// Numbers of one point.
    pub(super) columns: usize,
    pub(super) points: usize,
    /// Width and height, when the cloud is an image.
    pub(super) image: Option<(u32, u32)>,
    /// The stated pose of the sensor; the default of the format counts as identity.
    pub(super) viewpoint: Isometry3<f64>,
    pub(super) data: Data,
    /// First byte after the header.
    pub(super) data_start: usize,
    /// Number of the line that starts there.
    pub(super) data_line: usize,
}

/// One line of the header: its number and what stands after the keyword.
type Entry = (usize, Vec<String>);

#[derive(Default)]
struct Entries {
    fields: Option<Entry>,
    size: Option<Entry>,
    kind: Option<Entry>,
    count: Option<Entry>,
    width: Option<Entry>,
    height: Option<Entry>,
    viewpoint: Option<Entry>,
    points: Option<Entry>,
}

/// Reads the header; `notes` gets what is odd but harmless.
pub(super) fn read_header(bytes: &[u8], notes: &mut Vec<String>) -> Result<Header, CloudError> {
    let mut entries = Entries::default();
    let mut start = 0;
    let mut line = 0;
    let (data, data_line_number) = loop {
        line += 1;
        let rest = bytes.get(start..).unwrap_or_default();
        if rest.is_empty() || start > MAX_HEADER_BYTES {
            return Err(wrong(line, "PCD header", "no DATA line", "a line DATA ascii, binary or binary_compressed"));
        }
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        start += length + 1;
        let text = String::from_utf8_lossy(rest.get(..length.min(MAX_HEADER_BYTES)).unwrap_or_default());
        let mut words = text.split_ascii_whitespace();
        let Some(keyword) = words.next().filter(|word| !word.starts_with('#')) else { continue };
        let values: Vec<String> = words.take(MAX_FIELDS + 1).map(str::to_owned).collect();
        let slot = match keyword {
            "VERSION" => continue,
            "FIELDS" | "COLUMNS" => &mut entries.fields,
            "SIZE" => &mut entries.size,
            "TYPE" => &mut entries.kind,
            "COUNT" => &mut entries.count,
            "WIDTH" => &mut entries.width,
            "HEIGHT" => &mut entries.height,
            "VIEWPOINT" => &mut entries.viewpoint,
            "POINTS" => &mut entries.points,
            "DATA" => {
                break match values.first().map(String::as_str) {
                    Some("ascii") => (Data::Ascii, line),
                    Some("binary") => (Data::Binary, line),
                    Some("binary_compressed") => (Data::BinaryCompressed, line),
                    other => {
                        let found = other.unwrap_or("nothing");
                        return Err(wrong(line, "DATA", found, "ascii, binary or binary_compressed"));
                    }
                };
            }
            other => return Err(wrong(line, "PCD header", other, "a keyword of PCD v0.7")),
        };
        *slot = Some((line, values));
    };
    let fields = read_fields(&entries, data_line_number)?;
    let (points, image) = read_size(&entries, data_line_number, notes)?;
    let last = fields.last();
    Ok(Header {
        stride: last.map_or(0, |field| field.offset + field.count * field.scalar.size()),
        columns: last.map_or(0, |field| field.column + field.count),
        fields,
        points,
        image,
        viewpoint: read_viewpoint(&entries, notes)?,
        data,
        data_start: start.min(bytes.len()),
        data_line: line + 1,
    })
}

fn wrong(line: usize, thing: &'static str, found: &str, wanted: &str) -> CloudError {
    CloudError::Line { line, thing, found: excerpt(found), wanted: wanted.to_owned() }
}

fn read_fields(entries: &Entries, end: usize) -> Result<Vec<Field>, CloudError> {
    let need = |entry: &Option<Entry>, thing: &'static str| {
        entry.clone().ok_or_else(|| wrong(end, thing, "no such line in the header", "one value per field"))
    };
    let (line, names) = need(&entries.fields, "FIELDS")?;
    let (size_line, sizes) = need(&entries.size, "SIZE")?;
    let (kind_line, kinds) = need(&entries.kind, "TYPE")?;
    let (count_line, counts) =
        entries.count.clone().unwrap_or_else(|| (line, names.iter().map(|_| String::from("1")).collect()));
    if names.len() > MAX_FIELDS {
        return Err(wrong(line, "FIELDS", "more than 256 names", "at most 256"));
    }
    for (at, thing, values) in
        [(size_line, "SIZE", &sizes), (kind_line, "TYPE", &kinds), (count_line, "COUNT", &counts)]
    {
        if values.len() != names.len() {
            let found = format!("{} values", values.len());
            return Err(wrong(at, thing, &found, &format!("{}, one per field", names.len())));
        }
    }
    let mut fields = Vec::with_capacity(names.len());
    let (mut offset, mut column) = (0usize, 0usize);
    for (((name, size), kind), count_text) in names.into_iter().zip(&sizes).zip(&kinds).zip(&counts) {
        let scalar = match (kind.as_str(), size.as_str()) {
            ("F", "4") => Scalar::F32,
            ("F", "8") => Scalar::F64,
            ("I", "1") => Scalar::I8,
            ("I", "2") => Scalar::I16,
            ("I", "4") => Scalar::I32,
            ("I", "8") => Scalar::I64,
            ("U", "1") => Scalar::U8,
            ("U", "2") => Scalar::U16,
            ("U", "4") => Scalar::U32,
            ("U", "8") => Scalar::U64,
            _ => return Err(wrong(kind_line, "TYPE and SIZE", &format!("{kind} {size}"), "F 4, F 8, I or U 1 to 8")),
        };
        let count = count_text.parse::<usize>().ok().filter(|count| *count <= MAX_POINT_BYTES);
        let Some(count) = count else {
            return Err(wrong(count_line, "COUNT", count_text, &format!("a whole number up to {MAX_POINT_BYTES}")));
        };
        fields.push(Field { name, scalar, count, offset, column });
        column += count;
        offset += count * scalar.size();
        if offset > MAX_POINT_BYTES {
            return Err(wrong(count_line, "COUNT", "a point that is too large", &format!("{MAX_POINT_BYTES} bytes")));
        }
    }
    Ok(fields)
}

fn read_size(
    entries: &Entries,
    end: usize,
    notes: &mut Vec<String>,
) -> Result<(usize, Option<(u32, u32)>), CloudError> {
    let number = |entry: &Option<Entry>, thing: &'static str| -> Result<Option<(usize, u64)>, CloudError> {
        let Some((line, values)) = entry else { return Ok(None) };
        let text = values.first().map_or("nothing", String::as_str);
        let value = text.parse().map_err(|_| wrong(*line, thing, text, "a whole number"))?;
        Ok(Some((*line, value)))
    };
    let width = number(&entries.width, "WIDTH")?;
    let height = number(&entries.height, "HEIGHT")?;
    let points = number(&entries.points, "POINTS")?;
    let area = match (width, height) {
        (Some((line, width)), Some((_, height))) => Some((line, width.saturating_mul(height))),
        (Some((line, width)), None) => Some((line, width)),
        _ => None,
    };
    let Some((line, count)) = points.or(area) else {
        return Err(wrong(end, "POINTS", "neither POINTS nor WIDTH and HEIGHT", "the number of points"));
    };
    if count > MAX_POINTS as u64 {
        return Err(CloudError::TooManyPoints { line, found: count, limit: MAX_POINTS });
    }
    let image = match (width, height) {
        (Some((_, width)), Some((_, height))) if width > 1 && height > 1 => {
            if width.checked_mul(height) == Some(count) {
                Some((width as u32, height as u32))
            } else {
                notes.push(format!(
                    "line {line}: POINTS is {count}, but WIDTH times HEIGHT is {width} × {height}: read as {count} points \
                     without an image"
                ));
                None
            }
        }
        _ => None,
    };
    Ok((count as usize, image))
}

/// `VIEWPOINT tx ty tz qw qx qy qz`.
fn read_viewpoint(entries: &Entries, notes: &mut Vec<String>) -> Result<Isometry3<f64>, CloudError> {
    let Some((line, words)) = &entries.viewpoint else { return Ok(Isometry3::identity()) };
    let mut values = [0.0; 7];
    if words.len() != values.len() {
        return Err(wrong(*line, "VIEWPOINT", &format!("{} values", words.len()), "7: tx ty tz qw qx qy qz"));
    }
    for (value, word) in values.iter_mut().zip(words) {
        *value = parse_number(word, *line, "VIEWPOINT")?;
    }
    let [tx, ty, tz, w, x, y, z] = values;
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6);
    let near = [tx, ty, tz].iter().all(|t| t.abs() <= super::MAX_COORDINATE_M);
    match rotation {
        Some(rotation) if near && rotation.coords.iter().all(|part| part.is_finite()) => {
            Ok(Isometry3::from_parts(Translation3::new(tx, ty, tz), rotation))
        }
        _ => {
            notes.push(format!("line {line}: VIEWPOINT is no pose and was ignored"));
            Ok(Isometry3::identity())
        }
    }
}
