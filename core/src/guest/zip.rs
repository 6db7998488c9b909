//! Zip archives: the central directory, stored and deflated entries. No encryption, no archives beyond 4 GB.

use super::GuestError;
use super::files::{MAX_FILES, MAX_TOTAL_BYTES};

/// The record at the end: this long without its comment.
const END_BYTES: usize = 22;
/// Longest comment behind it.
const MAX_COMMENT: usize = 65_535;

/// Whether bytes begin as an archive does.
pub(super) fn looks_like_zip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06")
}

/// The files of an archive, in its order; folders are left out.
///
/// Sizes are compared with the limits before anything is unpacked, and checksums afterwards.
pub(super) fn unzip(archive: &str, bytes: &[u8]) -> Result<Vec<(String, Vec<u8>)>, GuestError> {
    let wrong = |place: &str, found: String, wanted: &str| GuestError::Zip {
        archive: archive.to_owned(),
        place: place.to_owned(),
        found,
        wanted: wanted.to_owned(),
    };
    let ends_early = |place: &str| wrong(place, "the end of the file".to_owned(), "more bytes: is it truncated?");
    let tail = bytes.len().saturating_sub(END_BYTES + MAX_COMMENT);
    let end = bytes[tail..].windows(END_BYTES).rposition(|window| window.starts_with(b"PK\x05\x06"));
    let end = tail + end.ok_or_else(|| ends_early("end of the directory"))?;
    let count = usize::from(u16_at(bytes, end + 10).unwrap_or(0));
    let mut at = u32_at(bytes, end + 16).unwrap_or(0) as usize;
    if count > MAX_FILES {
        let (found, limit) = (count as u64, MAX_FILES as u64);
        return Err(GuestError::TooMuch { thing: archive.to_owned(), found, limit, limit_name: "MAX_FILES" });
    }
    let mut files = Vec::new();
    let mut total = 0_u64;
    for number in 0..count {
        let place = format!("entry {number}");
        let entry = Entry::read(bytes, at).ok_or_else(|| ends_early(&place))?;
        at = entry.next;
        if entry.name.ends_with('/') {
            continue;
        }
        let place = entry.name.as_str();
        if entry.flags & 1 != 0 {
            return Err(wrong(place, "an encrypted file".to_owned(), "a plain one"));
        }
        total += u64::from(entry.size);
        if total > MAX_TOTAL_BYTES {
            let (found, limit) = (total, MAX_TOTAL_BYTES);
            let thing = format!("{archive}, unpacked up to {place}");
            return Err(GuestError::TooMuch { thing, found, limit, limit_name: "MAX_TOTAL_BYTES" });
        }
        let packed = entry.packed(bytes).ok_or_else(|| ends_early(place))?;
        let content = match entry.method {
            0 => packed.to_vec(),
            8 => miniz_oxide::inflate::decompress_to_vec_with_limit(packed, entry.size as usize)
                .map_err(|error| wrong(place, format!("{:?}", error.status), "a deflate stream of the stated size"))?,
            method => return Err(wrong(place, format!("compression method {method}"), "0 (stored) or 8 (deflate)")),
        };
        if content.len() != entry.size as usize || crc32fast::hash(&content) != entry.crc {
            return Err(wrong(place, "another size or checksum than stated".to_owned(), "an intact file"));
        }
        files.push((entry.name, content));
    }
    Ok(files)
}

/// What the directory says of one file.
struct Entry {
    name: String,
    flags: u16,
    method: u16,
    crc: u32,
    packed_size: u32,
    size: u32,
    /// Where its own header begins.
    header: usize,
    /// Where the next entry of the directory begins.
    next: usize,
}

impl Entry {
    fn read(bytes: &[u8], at: usize) -> Option<Self> {
        if bytes.get(at..at.checked_add(4)?)? != b"PK\x01\x02" {
            return None;
        }
        let [name, extra, comment] = [28, 30, 32].map(|offset| u16_at(bytes, at + offset).map(usize::from));
        let (name, begin) = (name?, at + 46);
        let text = bytes.get(begin..begin + name)?;
        Some(Self {
            name: String::from_utf8_lossy(text).replace('\\', "/"),
            flags: u16_at(bytes, at + 8)?,
            method: u16_at(bytes, at + 10)?,
            crc: u32_at(bytes, at + 16)?,
            packed_size: u32_at(bytes, at + 20)?,
            size: u32_at(bytes, at + 24)?,
            header: u32_at(bytes, at + 42)? as usize,
            next: begin + name + extra? + comment?,
        })
    }

    fn packed<'b>(&self, bytes: &'b [u8]) -> Option<&'b [u8]> {
        let at = self.header;
        if bytes.get(at..at.checked_add(4)?)? != b"PK\x03\x04" {
            return None;
        }
        let begin = at + 30 + usize::from(u16_at(bytes, at + 26)?) + usize::from(u16_at(bytes, at + 28)?);
        bytes.get(begin..begin.checked_add(self.packed_size as usize)?)
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// An archive of these files, deflated where `packs`; for tests, which write what is read here.
#[cfg(test)]
pub(super) fn zip_of(files: &[(&str, &[u8])], packs: bool) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let packed = if packs { miniz_oxide::deflate::compress_to_vec(content, 6) } else { content.to_vec() };
        let method: u16 = if packs { 8 } else { 0 };
        let header = out.len() as u32;
        let mut common = Vec::new();
        common.extend(20_u16.to_le_bytes());
        common.extend(0_u16.to_le_bytes());
        common.extend(method.to_le_bytes());
        common.extend(0_u32.to_le_bytes());
        common.extend(crc32fast::hash(content).to_le_bytes());
        common.extend((packed.len() as u32).to_le_bytes());
        common.extend((content.len() as u32).to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend(0_u16.to_le_bytes());
        out.extend(b"PK\x03\x04");
        out.extend(&common);
        out.extend(name.as_bytes());
        out.extend(packed);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend(header.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (begin, length) = (out.len() as u32, directory.len() as u32);
    out.extend(&directory);
    out.extend(b"PK\x05\x06\0\0\0\0");
    out.extend([(files.len() as u16).to_le_bytes(); 2].concat());
    out.extend(length.to_le_bytes());
    out.extend(begin.to_le_bytes());
    out.extend([0, 0]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILES: [(&str, &[u8]); 2] = [("robot/arm.urdf", b"<robot/>"), ("robot/meshes/a.stl", &[7; 300])];

    #[test]
    fn stored_and_deflated_files_come_out_as_they_went_in() {
        for packs in [false, true] {
            let bytes = zip_of(&FILES, packs);
            assert!(looks_like_zip(&bytes));
            let files = unzip("r.zip", &bytes).unwrap();
            let found: Vec<(&str, &[u8])> =
                files.iter().map(|(name, content)| (name.as_str(), content.as_slice())).collect();
            assert_eq!(found, FILES);
        }
    }

    #[test]
    fn the_checksum_is_that_of_the_format() {
        // The check value of CRC-32/ISO-HDLC.
        assert_eq!(crc32fast::hash(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn what_is_broken_is_refused_by_its_place() {
        let whole = zip_of(&FILES, true);
        let refused = |bytes: &[u8]| unzip("r.zip", bytes).unwrap_err().to_string();
        assert!(refused(&whole[..whole.len() - 30]).contains("end of the directory"));
        let mut flipped = whole.clone();
        flipped[45] ^= 0x55;
        assert!(refused(&flipped).contains("robot/arm.urdf"), "{}", refused(&flipped));
        // A size that would not fit into memory is refused before it is made room for.
        let mut huge = zip_of(&FILES, false);
        let at = huge.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
        huge[at + 24..at + 28].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(refused(&huge).contains("MAX_TOTAL_BYTES"), "{}", refused(&huge));
    }

    #[test]
    fn no_bytes_make_it_panic() {
        let whole = zip_of(&FILES, true);
        let mut rng = crate::rng::Rng::new(5, 0);
        for _ in 0..2000 {
            let mut bytes = whole.clone();
            for _ in 0..4 {
                let at = (rng.unit() * bytes.len() as f64) as usize;
                bytes[at] = (rng.unit() * 256.0) as u8;
            }
            bytes.truncate((rng.unit() * 1.5 * whole.len() as f64) as usize);
            let _any = unzip("r.zip", &bytes);
        }
    }
}
