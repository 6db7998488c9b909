//! The header of a PLY file.

use super::CloudError;
use super::error::excerpt;
use super::scalar::Scalar;

const MAX_HEADER_BYTES: usize = 256 * 1024;
const MAX_ELEMENTS: usize = 64;
const MAX_PROPERTIES: usize = 256;

/// How the elements are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// One property of an element.
#[derive(Clone, Debug)]
pub(super) enum Property {
    Value { name: String, scalar: Scalar },
    List { count: Scalar, item: Scalar },
}

/// One kind of element and how many there are.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Line that declares it.
    pub(super) line: usize,
}

impl Element {
    /// Bytes of one element; `None` when it holds lists.
    pub(super) fn stride(&self) -> Option<usize> {
        self.properties.iter().try_fold(0, |sum, property| match property {
            Property::Value { scalar, .. } => Some(sum + scalar.size()),
            Property::List { .. } => None,
        })
    }
}

/// A header.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// First byte after the header.
    pub(super) data_start: usize,
    /// Number of the line that starts there.
    pub(super) data_line: usize,
}

fn wrong(line: usize, thing: &'static str, found: &str, wanted: &str) -> CloudError {
    CloudError::Line { line, thing, found: excerpt(found), wanted: wanted.to_owned() }
}

fn scalar(word: Option<&str>, line: usize) -> Result<Scalar, CloudError> {
    Ok(match word {
        Some("char" | "int8") => Scalar::I8,
        Some("uchar" | "uint8") => Scalar::U8,
        Some("short" | "int16") => Scalar::I16,
        Some("ushort" | "uint16") => Scalar::U16,
        Some("int" | "int32") => Scalar::I32,
        Some("uint" | "uint32") => Scalar::U32,
        Some("float" | "float32") => Scalar::F32,
        Some("double" | "float64") => Scalar::F64,
        other => {
            return Err(wrong(line, "property type", other.unwrap_or("nothing"), "char to double, or int8 to float64"));
        }
    })
}

/// Reads the header, from the word `ply` to `end_header`.
pub(super) fn read_header(bytes: &[u8]) -> Result<Header, CloudError> {
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    let (mut start, mut line) = (0, 0);
    loop {
        line += 1;
        let rest = bytes.get(start..).unwrap_or_default();
        if rest.is_empty() || start > MAX_HEADER_BYTES {
            return Err(wrong(line, "PLY header", "no end_header", "a line end_header"));
        }
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        start += length + 1;
        let text = String::from_utf8_lossy(rest.get(..length.min(4096)).unwrap_or_default());
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("ply") if line == 1 => {}
            _ if line == 1 => return Err(wrong(line, "PLY header", &text, "ply")),
            None | Some("comment" | "obj_info") => {}
            Some("format") => {
                format = Some(match words.next() {
                    Some("ascii") => Format::Ascii,
                    Some("binary_little_endian") => Format::LittleEndian,
                    Some("binary_big_endian") => Format::BigEndian,
                    other => {
                        let found = other.unwrap_or("nothing");
                        return Err(wrong(line, "format", found, "ascii, binary_little_endian or binary_big_endian"));
                    }
                });
            }
            Some("element") => {
                let name = words.next().unwrap_or_default().to_owned();
                let count = words.next().unwrap_or("nothing");
                let count = count.parse().map_err(|_| wrong(line, "element count", count, "a whole number"))?;
                if elements.len() == MAX_ELEMENTS {
                    return Err(wrong(line, "element", "a 65th kind of element", "at most 64"));
                }
                elements.push(Element { name, count, properties: Vec::new(), line });
            }
            Some("property") => {
                let Some(element) = elements.last_mut() else {
                    return Err(wrong(line, "property", "no element before it", "an element line first"));
                };
                if element.properties.len() == MAX_PROPERTIES {
                    return Err(wrong(line, "property", "a 257th property", "at most 256"));
                }
                element.properties.push(match words.next() {
                    Some("list") => Property::List {
                        count: match scalar(words.next(), line)? {
                            count if count.is_float() => {
                                return Err(wrong(
                                    line,
                                    "list count type",
                                    "a floating-point type",
                                    "a whole-number type",
                                ));
                            }
                            count => count,
                        },
                        item: scalar(words.next(), line)?,
                    },
                    word => Property::Value {
                        scalar: scalar(word, line)?,
                        name: words.next().unwrap_or_default().to_owned(),
                    },
                });
            }
            Some("end_header") => break,
            Some(other) => return Err(wrong(line, "PLY header", other, "format, element, property or end_header")),
        }
    }
    let format =
        format.ok_or_else(|| wrong(line, "PLY header", "no format line", "format ascii 1.0 or a binary one"))?;
    Ok(Header { format, elements, data_start: start.min(bytes.len()), data_line: line + 1 })
}
