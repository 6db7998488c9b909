//! Reading PCD v0.7: ascii, binary and binary_compressed, organised or not.

use super::error::excerpt;
use super::packed::Collector;
use super::pcd_header::{Data, Field, Header, read_header};
use super::scalar::{Scalar, numbered_lines, parse_number};
use super::sensor::find_sensor;
use super::{CloudError, PointCloud};
use crate::loaded::Loaded;

/// LZF never makes one byte of input into more than this many bytes of output (3 bytes stand for at most 264).
const LZF_MAX_RATIO: usize = 88;

/// Whether the first line that says anything is one of a PCD header.
pub(super) fn looks_like_pcd(bytes: &[u8]) -> bool {
    let start = bytes.get(..4096).unwrap_or(bytes);
    let mut lines = numbered_lines(start, 1).map(|(_, line)| line);
    if start.starts_with(b"# .PCD") {
        return true;
    }
    lines
        .find(|line| !line.starts_with(b"#") && !line.trim_ascii().is_empty())
        .is_some_and(|line| line.starts_with(b"VERSION ") || line.starts_with(b"FIELDS "))
}

/// Reads a PCD file.
pub(super) fn read_pcd(bytes: &[u8]) -> Result<Loaded<PointCloud>, CloudError> {
    let mut notes = Vec::new();
    let header = read_header(bytes, &mut notes)?;
    let layout = Layout::new(&header)?;
    let data = bytes.get(header.data_start..).unwrap_or_default();
    let points = match header.data {
        Data::Ascii => read_ascii(data, &header, &layout)?,
        Data::Binary => read_binary(data, &header, &layout)?,
        Data::BinaryCompressed => read_compressed(data, &header, &layout)?,
    };
    let mut cloud = points.finish(header.image, &mut notes)?;
    cloud.X_FC = find_sensor(&cloud, &header.viewpoint, &mut notes);
    Ok(Loaded { value: cloud, notes })
}

/// The fields that are used.
struct Layout {
    xyz: [Field; 3],
    color: Option<Field>,
}

impl Layout {
    fn new(header: &Header) -> Result<Self, CloudError> {
        let find = |name: &str| header.fields.iter().find(|field| field.name == name && field.count > 0).cloned();
        let need = |name: &str| {
            find(name).ok_or_else(|| {
                let names: Vec<&str> = header.fields.iter().map(|field| field.name.as_str()).collect();
                CloudError::Line {
                    line: header.data_line.saturating_sub(1),
                    thing: "FIELDS",
                    found: excerpt(&names.join(" ")),
                    wanted: format!("a field {name}"),
                }
            })
        };
        let color = find("rgb").or_else(|| find("rgba")).filter(|field| field.scalar.size() == 4);
        Ok(Self { xyz: [need("x")?, need("y")?, need("z")?], color })
    }
}

/// Blue, green, red and opacity, from the low byte up.
fn unpack(bits: u32) -> [u8; 3] {
    [(bits >> 16) as u8, (bits >> 8) as u8, bits as u8]
}

fn read_ascii(data: &[u8], header: &Header, layout: &Layout) -> Result<Collector, CloudError> {
    // A number and its separator take two bytes at least.
    let room = data.len() / (2 * header.columns.max(1)) + 1;
    let mut points = Collector::new(header.points.min(room));
    let mut last_line = header.data_line;
    let mut words = Vec::with_capacity(header.columns.min(64));
    for (line, bytes) in numbered_lines(data, header.data_line) {
        if points.read() == header.points {
            break;
        }
        let text = str::from_utf8(bytes).map_err(|_| CloudError::Line {
            line,
            thing: "ascii data",
            found: excerpt(&String::from_utf8_lossy(bytes)),
            wanted: String::from("numbers"),
        })?;
        words.clear();
        words.extend(text.split_ascii_whitespace());
        if words.is_empty() {
            continue;
        }
        last_line = line;
        if words.len() < header.columns {
            return Err(CloudError::Line {
                line,
                thing: "a point",
                found: format!("{} numbers", words.len()),
                wanted: format!("{}, as FIELDS and COUNT say", header.columns),
            });
        }
        let number = |field: &Field, thing| {
            let value = parse_number(words.get(field.column).copied().unwrap_or(""), line, thing)?;
            // A field of 32 bits means the same number in every encoding.
            Ok(if field.scalar == Scalar::F32 { f64::from(value as f32) } else { value })
        };
        let [x, y, z] = &layout.xyz;
        let color = match &layout.color {
            Some(field) => {
                let value = number(field, "rgb")?;
                let bits = match field.scalar {
                    Scalar::F32 => (value as f32).to_bits(),
                    Scalar::I32 => value as i32 as u32,
                    _ => value as u32,
                };
                Some(unpack(bits))
            }
            None => None,
        };
        points.push(number(x, "x")?, number(y, "y")?, number(z, "z")?, color);
    }
    if points.read() < header.points {
        return Err(CloudError::TruncatedText { line: last_line, found: points.read(), wanted: header.points });
    }
    Ok(points)
}

fn read_binary(data: &[u8], header: &Header, layout: &Layout) -> Result<Collector, CloudError> {
    let wanted = header.points.saturating_mul(header.stride);
    let Some(data) = data.get(..wanted) else {
        return Err(CloudError::TruncatedBinary { byte: header.data_start, found: data.len(), wanted });
    };
    let mut points = Collector::new(header.points);
    for point in data.chunks_exact(header.stride) {
        let at = |field: &Field| point.get(field.offset..).unwrap_or_default();
        let [x, y, z] = layout.xyz.each_ref().map(|field| field.scalar.read(at(field), false));
        let color = layout.color.as_ref().map(|field| unpack(Scalar::U32.read(at(field), false) as u32));
        points.push(x, y, z, color);
    }
    Ok(points)
}

/// Two lengths, then the LZF-compressed data, field by field instead of point by point.
fn read_compressed(data: &[u8], header: &Header, layout: &Layout) -> Result<Collector, CloudError> {
    let start = header.data_start;
    let wanted = header.points.saturating_mul(header.stride);
    let length = |at: usize| data.get(at..at + 4).map(|field| Scalar::U32.read(field, false) as usize);
    let (Some(packed_length), Some(length)) = (length(0), length(4)) else {
        return Err(CloudError::TruncatedBinary { byte: start, found: data.len(), wanted: 8 });
    };
    let packed = data.get(8..).unwrap_or_default();
    let Some(packed) = packed.get(..packed_length) else {
        return Err(CloudError::TruncatedBinary { byte: start + 8, found: packed.len(), wanted: packed_length });
    };
    if length != wanted || length / LZF_MAX_RATIO > packed_length {
        return Err(CloudError::Byte {
            byte: start + 4,
            thing: "length of the uncompressed data",
            found: format!("{length} bytes from {packed_length} compressed ones"),
            wanted: format!("{wanted} bytes for {} points of {} bytes", header.points, header.stride),
        });
    }
    let damaged = |found: String| CloudError::Byte {
        byte: start + 8,
        thing: "compressed data",
        found,
        wanted: format!("LZF data of {wanted} bytes"),
    };
    let raw = if wanted == 0 {
        Vec::new()
    } else {
        lzf::decompress(packed, wanted).map_err(|error| damaged(format!("damaged data ({error:?})")))?
    };
    if raw.len() != wanted {
        return Err(damaged(format!("{} bytes", raw.len())));
    }
    let mut points = Collector::new(header.points);
    let column = |field: &Field, point: usize| {
        // Within `raw` these products fit; nothing else can be read.
        let begin =
            (header.points.saturating_mul(field.offset)).saturating_add(point * field.count * field.scalar.size());
        raw.get(begin..).unwrap_or_default()
    };
    for point in 0..header.points {
        let [x, y, z] = layout.xyz.each_ref().map(|field| field.scalar.read(column(field, point), false));
        let color = layout.color.as_ref().map(|field| unpack(Scalar::U32.read(column(field, point), false) as u32));
        points.push(x, y, z, color);
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(extra: &str, points: &str) -> String {
        format!("# .PCD v.7\nVERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\n{extra}POINTS {points}\n")
    }

    #[test]
    fn a_truncated_binary_file_says_how_much_is_missing() {
        let mut file = header("WIDTH 2\nHEIGHT 1\n", "2").into_bytes();
        file.extend_from_slice(b"DATA binary\n");
        let start = file.len();
        file.extend_from_slice(&[0; 20]);
        let error = read_pcd(&file).unwrap_err();
        assert_eq!(error, CloudError::TruncatedBinary { byte: start, found: 20, wanted: 32 });
        assert!(error.to_string().starts_with("binary data ends after 20 of 32 bytes"), "{error}");
    }

    #[test]
    fn a_header_that_promises_too_much_is_refused_before_anything_is_allocated() {
        let huge = header("", "18446744073709551615") + "DATA binary\n";
        assert!(matches!(read_pcd(huge.as_bytes()), Err(CloudError::TooManyPoints { line: 6, .. })));
        let large = header("", "20000000") + "DATA binary_compressed\n\x08\0\0\0\0\0\0\0";
        assert!(matches!(read_pcd(large.as_bytes()), Err(CloudError::TruncatedBinary { .. })));
        let wide = header("COUNT 99999 1 1 1\n", "1") + "DATA ascii\n";
        assert!(matches!(read_pcd(wide.as_bytes()), Err(CloudError::Line { line: 6, thing: "COUNT", .. })));
    }

    #[test]
    fn ascii_lines_are_named_by_number() {
        let short = header("", "2") + "DATA ascii\n0 0 1 255\n0 0\n";
        assert!(matches!(read_pcd(short.as_bytes()), Err(CloudError::Line { line: 9, .. })));
        let word = header("", "1") + "DATA ascii\n0 zero 1 255\n";
        assert_eq!(read_pcd(word.as_bytes()).unwrap_err().to_string(), "line 8: y: found \"zero\", wanted a number");
        let few = header("", "3") + "DATA ascii\n0 0 1 255\n\n";
        let error = read_pcd(few.as_bytes()).unwrap_err();
        assert_eq!(error, CloudError::TruncatedText { line: 8, found: 1, wanted: 3 });
    }

    #[test]
    fn colours_are_unpacked_from_integers_and_from_floats() {
        let bits = 0x00_0a_14_1eu32;
        let integer = header("", "1") + &format!("DATA ascii\n0 0 1 {bits}\n");
        assert_eq!(read_pcd(integer.as_bytes()).unwrap().value.colors, [[10, 20, 30]]);
        let float = integer.replace("TYPE F F F U", "TYPE F F F F").replace(&bits.to_string(), &{
            let value = f32::from_bits(bits);
            format!("{value:e}")
        });
        assert_eq!(read_pcd(float.as_bytes()).unwrap().value.colors, [[10, 20, 30]]);
    }

    #[test]
    fn points_that_are_not_finite_are_dropped_and_counted() {
        let file = header("WIDTH 3\nHEIGHT 1\n", "3") + "DATA ascii\nnan 0 1 0\n0 0 1 0\n0 0 1e30 0\n";
        let loaded = read_pcd(file.as_bytes()).unwrap();
        assert_eq!(loaded.value.points.len(), 1);
        assert_eq!(loaded.notes.len(), 2, "{:?}", loaded.notes);
        let none = header("", "1") + "DATA ascii\nnan nan nan 0\n";
        assert!(matches!(read_pcd(none.as_bytes()), Err(CloudError::NoPoints { read: 1, .. })));
    }
}
