//! The number types of PCD and PLY files, and numbers in text.

use super::CloudError;
use super::error::excerpt;

/// Type of one number in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// Bytes of one number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether the numbers are floating point.
    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// The number at the start of `bytes`; NaN when there are too few.
    pub(super) fn read(self, bytes: &[u8], big_endian: bool) -> f64 {
        let Some(field) = bytes.get(..self.size()) else { return f64::NAN };
        let mut raw = [0u8; 8];
        for (k, byte) in field.iter().enumerate() {
            let place = if big_endian { field.len() - 1 - k } else { k };
            raw[place] = *byte;
        }
        let bits = u64::from_le_bytes(raw);
        match self {
            Self::I8 => f64::from(bits as u8 as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as u16 as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as u32 as i32),
            Self::U32 => f64::from(bits as u32),
            Self::I64 => bits as i64 as f64,
            Self::U64 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

/// Reads one number of a text line; `nan` and `inf` are numbers here, dropped later with the points they belong to.
pub(super) fn parse_number(token: &str, line: usize, thing: &'static str) -> Result<f64, CloudError> {
    token.parse().map_err(|_| CloudError::Line { line, thing, found: excerpt(token), wanted: String::from("a number") })
}

/// Lines of a text with their numbers, counted from `first`; a carriage return at the end is not part of a line.
pub(super) fn numbered_lines(bytes: &[u8], first: usize) -> impl Iterator<Item = (usize, &[u8])> {
    bytes
        .split(|byte| *byte == b'\n')
        .map(|line| line.strip_suffix(b"\r").unwrap_or(line))
        .enumerate()
        .map(move |(k, line)| (first + k, line))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_give_the_same_number() {
        assert_eq!(Scalar::F64.read(&(-1.25f64).to_le_bytes(), false), -1.25);
        assert_eq!(Scalar::F64.read(&(-1.25f64).to_be_bytes(), true), -1.25);
        assert_eq!(Scalar::I16.read(&(-7i16).to_be_bytes(), true), -7.0);
        assert_eq!(Scalar::I8.read(&[0xff], false), -1.0);
        assert_eq!(Scalar::U32.read(&u32::MAX.to_le_bytes(), false), 4_294_967_295.0);
        assert!(Scalar::F32.read(&[0, 0, 0], false).is_nan());
    }
}
