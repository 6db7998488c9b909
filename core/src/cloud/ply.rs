//! Reading the vertices of a PLY file: ascii and both binaries, lists and other elements skipped.

use super::error::excerpt;
use super::packed::Collector;
use super::ply_header::{Element, Format, Header, Property, read_header};
use super::read::MAX_POINTS;
use super::scalar::{Scalar, numbered_lines, parse_number};
use super::{CloudError, PointCloud};
use crate::loaded::Loaded;

/// Whether the first line is `ply`.
pub(super) fn looks_like_ply(bytes: &[u8]) -> bool {
    bytes.strip_prefix(b"ply").is_some_and(|rest| matches!(rest.first(), Some(b'\n' | b'\r' | b' ')))
}

/// Reads a PLY file; faces are ignored, so a mesh is read as the cloud of its vertices.
pub(super) fn read_ply(bytes: &[u8]) -> Result<Loaded<PointCloud>, CloudError> {
    let header = read_header(bytes)?;
    let place = header.elements.iter().position(|element| element.name == "vertex");
    let Some((place, vertex)) = place.and_then(|place| Some((place, header.elements.get(place)?))) else {
        return Err(CloudError::Line {
            line: header.data_line - 1,
            thing: "PLY header",
            found: String::from("no element vertex"),
            wanted: String::from("an element vertex with x, y and z"),
        });
    };
    if vertex.count > MAX_POINTS as u64 {
        return Err(CloudError::TooManyPoints { line: vertex.line, found: vertex.count, limit: MAX_POINTS });
    }
    let layout = Layout::new(vertex)?;
    let before = header.elements.get(..place).unwrap_or_default();
    let data = bytes.get(header.data_start..).unwrap_or_default();
    let points = match header.format {
        Format::Ascii => read_ascii(data, &header, before, vertex, &layout)?,
        _ => read_binary(data, &header, before, vertex, &layout)?,
    };
    let mut notes = Vec::new();
    let value = points.finish(None, &mut notes)?;
    Ok(Loaded { value, notes })
}

/// Where the used properties stand among the properties of a vertex.
struct Layout {
    xyz: [usize; 3],
    /// Property and whether its values lie in [0, 1].
    rgb: Option<[(usize, bool); 3]>,
}

impl Layout {
    fn new(vertex: &Element) -> Result<Self, CloudError> {
        let find = |wanted: &str| {
            vertex.properties.iter().enumerate().find_map(|(k, property)| match property {
                Property::Value { name, scalar } if name == wanted => Some((k, scalar.is_float())),
                _ => None,
            })
        };
        let need = |name: &str| {
            find(name).map(|(k, _)| k).ok_or_else(|| CloudError::Line {
                line: vertex.line,
                thing: "element vertex",
                found: format!("no property {name}"),
                wanted: String::from("x, y and z"),
            })
        };
        let color = |name: &str| find(name).or_else(|| find(&format!("diffuse_{name}")));
        let rgb = match (color("red"), color("green"), color("blue")) {
            (Some(red), Some(green), Some(blue)) => Some([red, green, blue]),
            _ => None,
        };
        Ok(Self { xyz: [need("x")?, need("y")?, need("z")?], rgb })
    }

    fn push(&self, values: &[f64], points: &mut Collector) {
        let value = |k: usize| values.get(k).copied().unwrap_or(f64::NAN);
        let color = self.rgb.map(|rgb| {
            // `as` saturates, and turns NaN into 0.
            rgb.map(|(k, unit)| if unit { (value(k) * 255.0 + 0.5) as u8 } else { value(k) as u8 })
        });
        let [x, y, z] = self.xyz.map(value);
        points.push(x, y, z, color);
    }
}

fn read_ascii(
    data: &[u8],
    header: &Header,
    before: &[Element],
    vertex: &Element,
    layout: &Layout,
) -> Result<Collector, CloudError> {
    let count = vertex.count as usize;
    let mut points = Collector::new(count.min(data.len() / (2 * vertex.properties.len().max(1)) + 1));
    let mut skip = before
        .iter()
        .filter(|element| !element.properties.is_empty())
        .fold(0u64, |sum, element| sum.saturating_add(element.count));
    let mut last_line = header.data_line;
    let mut values = Vec::with_capacity(vertex.properties.len());
    for (line, bytes) in numbered_lines(data, header.data_line) {
        if points.read() == count {
            break;
        }
        let text = str::from_utf8(bytes).unwrap_or("\u{fffd}");
        let mut words = text.split_ascii_whitespace().peekable();
        if words.peek().is_none() {
            continue;
        }
        last_line = line;
        if skip > 0 {
            skip -= 1;
            continue;
        }
        values.clear();
        for property in &vertex.properties {
            let mut next = |thing| match words.next() {
                Some(word) => parse_number(word, line, thing),
                None => Err(CloudError::Line {
                    line,
                    thing: "a vertex",
                    found: excerpt(text),
                    wanted: format!("{} properties", vertex.properties.len()),
                }),
            };
            match property {
                Property::Value { .. } => values.push(next("a vertex")?),
                Property::List { .. } => {
                    let items = next("a list's length")?.max(0.0) as u64;
                    for _ in 0..items {
                        next("a list")?;
                    }
                    values.push(f64::NAN);
                }
            }
        }
        layout.push(&values, &mut points);
    }
    if points.read() < count {
        return Err(CloudError::TruncatedText { line: last_line, found: points.read(), wanted: count });
    }
    Ok(points)
}

/// Walks through binary data and knows where it ends.
struct Reader<'a> {
    data: &'a [u8],
    at: usize,
    start: usize,
    big_endian: bool,
}

impl Reader<'_> {
    /// Leaves out so many bytes.
    fn skip(&mut self, count: u64, size: usize) -> Result<(), CloudError> {
        let left = self.data.len() - self.at;
        match usize::try_from(count).ok().and_then(|count| count.checked_mul(size)) {
            Some(bytes) if bytes <= left => {
                self.at += bytes;
                Ok(())
            }
            bytes => Err(CloudError::TruncatedBinary {
                byte: self.start,
                found: self.data.len(),
                wanted: bytes.unwrap_or(usize::MAX).saturating_add(self.at),
            }),
        }
    }

    fn next(&mut self, scalar: Scalar) -> Result<f64, CloudError> {
        let from = self.at;
        self.skip(1, scalar.size())?;
        Ok(scalar.read(self.data.get(from..).unwrap_or_default(), self.big_endian))
    }

    fn list(&mut self, count: Scalar, item: Scalar) -> Result<(), CloudError> {
        let items = self.next(count)?;
        if items < 0.0 {
            return Err(CloudError::Byte {
                byte: self.start + self.at - count.size(),
                thing: "a list's length",
                found: format!("{items}"),
                wanted: String::from("0 or more"),
            });
        }
        self.skip(items as u64, item.size())
    }
}

fn read_binary(
    data: &[u8],
    header: &Header,
    before: &[Element],
    vertex: &Element,
    layout: &Layout,
) -> Result<Collector, CloudError> {
    let big_endian = header.format == Format::BigEndian;
    let mut reader = Reader { data, at: 0, start: header.data_start, big_endian };
    for element in before {
        match element.stride() {
            Some(stride) => reader.skip(element.count, stride)?,
            // Every list takes at least a byte, so the data ends this loop however large the count is.
            None => {
                for _ in 0..element.count {
                    walk(&mut reader, element, |_| ())?;
                }
            }
        }
    }
    if let Some(stride) = vertex.stride() {
        let at = reader.at;
        reader.skip(vertex.count, stride)?;
        reader.at = at;
    }
    let room = data.len() / vertex.properties.len().max(1) + 1;
    let mut points = Collector::new((vertex.count as usize).min(room));
    let mut values = Vec::with_capacity(vertex.properties.len());
    for _ in 0..vertex.count {
        values.clear();
        walk(&mut reader, vertex, |value| values.push(value))?;
        layout.push(&values, &mut points);
    }
    Ok(points)
}

/// Reads one element; a list counts as one value, NaN.
fn walk(reader: &mut Reader<'_>, element: &Element, mut take: impl FnMut(f64)) -> Result<(), CloudError> {
    for property in &element.properties {
        take(match property {
            Property::Value { scalar, .. } => reader.next(*scalar)?,
            Property::List { count, item } => {
                reader.list(*count, *item)?;
                f64::NAN
            }
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_other_elements_before_the_vertices_are_skipped() {
        let text = "ply\nformat ascii 1.0\ncomment made by hand\nelement tag 2\nproperty list uchar int ids\n\
                    element vertex 2\nproperty float x\nproperty list uchar float w\nproperty float y\nproperty float z\n\
                    property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n\
                    2 7 8\n0\n1 2 0.5 0.5 2 3 10 20 30\n4 0 5 6 40 50 60\n";
        let cloud = read_ply(text.as_bytes()).unwrap().value;
        assert_eq!(cloud.points, [nalgebra::Point3::new(1., 2., 3.), nalgebra::Point3::new(4., 5., 6.)]);
        assert_eq!(cloud.colors, [[10, 20, 30], [40, 50, 60]]);
    }

    #[test]
    fn big_endian_vertices_behind_binary_lists_are_read() {
        let mut file = b"ply\nformat binary_big_endian 1.0\nelement face 1\nproperty list uchar short i\n\
                         element vertex 1\nproperty double x\nproperty float y\nproperty short z\nend_header\n"
            .to_vec();
        file.extend_from_slice(&[2, 0, 1, 0, 2]);
        file.extend_from_slice(&1.5f64.to_be_bytes());
        file.extend_from_slice(&(-2.5f32).to_be_bytes());
        file.extend_from_slice(&(-3i16).to_be_bytes());
        assert_eq!(read_ply(&file).unwrap().value.points, [nalgebra::Point3::new(1.5, -2.5, -3.0)]);
        file.pop();
        assert!(matches!(read_ply(&file), Err(CloudError::TruncatedBinary { found: 18, wanted: 19, .. })));
    }

    #[test]
    fn endless_counts_end_with_the_data() {
        let header = |count: &str| {
            format!(
                "ply\nformat binary_little_endian 1.0\nelement face {count}\nproperty list uchar int i\nelement none {count}\n\
                 element vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
            )
        };
        assert!(read_ply(header("18446744073709551615").as_bytes()).is_err());
        assert!(read_ply(header("-1").as_bytes()).unwrap_err().to_string().contains("line 3: element count"));
    }
}
