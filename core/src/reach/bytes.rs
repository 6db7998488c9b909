//! Numbers and names in the order of a file, least byte first.

use super::ReachError;

/// Longest name, bytes.
const LONGEST: usize = 200;

/// Takes a file apart; every error names the place.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

pub(super) fn bad<T>(place: &'static str, found: impl ToString, wanted: impl ToString) -> Result<T, ReachError> {
    Err(ReachError::BadFile { place, found: found.to_string(), wanted: wanted.to_string() })
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// How far it is.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    pub(super) fn take(&mut self, place: &'static str, count: usize) -> Result<&'a [u8], ReachError> {
        let left = &self.bytes[self.at..];
        let Some(taken) = left.get(..count) else {
            return bad(place, format!("the end of the file after {} bytes", left.len()), format!("{count} bytes"));
        };
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, place: &'static str) -> Result<[u8; N], ReachError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(place, N)?);
        Ok(array)
    }

    pub(super) fn u8(&mut self, place: &'static str) -> Result<u8, ReachError> {
        self.array(place).map(u8::from_le_bytes)
    }

    pub(super) fn u16(&mut self, place: &'static str) -> Result<u16, ReachError> {
        self.array(place).map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self, place: &'static str) -> Result<u32, ReachError> {
        self.array(place).map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self, place: &'static str) -> Result<i32, ReachError> {
        self.array(place).map(i32::from_le_bytes)
    }

    pub(super) fn u64(&mut self, place: &'static str) -> Result<u64, ReachError> {
        self.array(place).map(u64::from_le_bytes)
    }

    pub(super) fn f64(&mut self, place: &'static str) -> Result<f64, ReachError> {
        self.array(place).map(f64::from_le_bytes)
    }

    pub(super) fn name(&mut self, place: &'static str) -> Result<String, ReachError> {
        let length = usize::from(self.u8(place)?);
        let bytes = self.take(place, length)?;
        match std::str::from_utf8(bytes) {
            Ok(name) if length <= LONGEST => Ok(name.to_owned()),
            _ => bad(place, format!("{length} bytes"), format!("at most {LONGEST} bytes of UTF-8")),
        }
    }
}

/// Adds a name; what is too long for the file is cut.
pub(super) fn add_name(bytes: &mut Vec<u8>, name: &str) {
    let mut end = name.len().min(LONGEST);
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    bytes.push(end as u8);
    bytes.extend_from_slice(&name.as_bytes()[..end]);
}
