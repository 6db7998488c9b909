//! What can be wrong with a cloud file.

/// Why a file cannot be read as a point cloud: the place, the thing, what was found and what was wanted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CloudError {
    /// The file is none of the formats that are read.
    #[error("{name:?} is not a point cloud that can be read: it starts with {start:?}, wanted a PCD, PLY or XYZ file")]
    UnknownFormat { name: String, start: String },
    /// A line of a header or of ascii data is wrong.
    #[error("line {line}: {thing}: found {found}, wanted {wanted}")]
    Line { line: usize, thing: &'static str, found: String, wanted: String },
    /// Something in the binary part is wrong.
    #[error("byte {byte}: {thing}: found {found}, wanted {wanted}")]
    Byte { byte: usize, thing: &'static str, found: String, wanted: String },
    /// The binary part is shorter than the header promises.
    #[error("binary data ends after {found} of {wanted} bytes (it starts at byte {byte}): the file is truncated")]
    TruncatedBinary { byte: usize, found: usize, wanted: usize },
    /// The ascii part is shorter than the header promises.
    #[error("the file ends at line {line} after {found} of {wanted} points: the file is truncated")]
    TruncatedText { line: usize, found: usize, wanted: usize },
    /// More points than [`MAX_POINTS`](super::MAX_POINTS).
    #[error("line {line}: {found} points, the limit is {limit}")]
    TooManyPoints { line: usize, found: u64, limit: usize },
    /// A depth image or the intrinsics of its camera are wrong.
    #[error("{thing}: found {found}, wanted {wanted}")]
    Intrinsics { thing: &'static str, found: String, wanted: String },
    /// Nothing is left to work with.
    #[error("none of the {read} points in the file is finite and within {limit_m:.0} m of the origin")]
    NoPoints { read: usize, limit_m: u64 },
}

/// The beginning of a token or line, short enough for a message.
pub(super) fn excerpt(text: &str) -> String {
    const LONGEST: usize = 40;
    let clean: String = text.chars().take(LONGEST).map(|c| if c.is_control() { '·' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() { format!("{clean:?} …") } else { format!("{clean:?}") }
}
