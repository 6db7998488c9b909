//! Files in a ZIP archive, stored as they are: PNG has packed them already.
//!
//! As the format's specification (PKWARE APPNOTE 6.3, sections 4.3.7, 4.3.12 and 4.3.16) lays it out, without ZIP64: the
//! archive stays below 4 GB and 65 535 files. Every file is dated 1980-01-01, so that equal files give equal archives.

/// Version 2.0 of the format.
const VERSION: u16 = 20;
/// Midnight, and 1980-01-01.
const TIME: u16 = 0;
const DATE: u16 = 0x21;

/// An archive that grows.
#[derive(Default)]
pub(super) struct Zip {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    count: u16,
}

impl Zip {
    /// Adds a file.
    pub(super) fn add(&mut self, name: &str, content: &[u8]) {
        let offset = self.bytes.len() as u32;
        let common = Self::common(name, content);
        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&common);
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(content);
        self.directory.extend(b"PK\x01\x02");
        self.directory.extend(VERSION.to_le_bytes());
        self.directory.extend(&common);
        // Length of the comment, number of the disk, attributes within and without.
        self.directory.extend([0; 10]);
        self.directory.extend(offset.to_le_bytes());
        self.directory.extend(name.as_bytes());
        self.count += 1;
    }

    /// What stands both before a file and in the directory.
    fn common(name: &str, content: &[u8]) -> Vec<u8> {
        let size = (content.len() as u32).to_le_bytes();
        let mut common = Vec::with_capacity(26);
        // Version that is needed, no flags, stored.
        for word in [VERSION, 0, 0, TIME, DATE] {
            common.extend(word.to_le_bytes());
        }
        common.extend(crc32fast::hash(content).to_le_bytes());
        common.extend(size);
        common.extend(size);
        // Length of the name, and of the extra field.
        for word in [name.len() as u16, 0] {
            common.extend(word.to_le_bytes());
        }
        common
    }

    /// Bytes so far.
    pub(super) fn len(&self) -> usize {
        self.bytes.len() + self.directory.len()
    }

    /// The finished archive.
    pub(super) fn finish(mut self) -> Vec<u8> {
        let (offset, size) = (self.bytes.len() as u32, self.directory.len() as u32);
        self.bytes.append(&mut self.directory);
        self.bytes.extend(b"PK\x05\x06");
        // Number of this disk, and of the one with the directory.
        self.bytes.extend([0; 4]);
        self.bytes.extend(self.count.to_le_bytes());
        self.bytes.extend(self.count.to_le_bytes());
        self.bytes.extend(size.to_le_bytes());
        self.bytes.extend(offset.to_le_bytes());
        // Length of the comment.
        self.bytes.extend([0; 2]);
        self.bytes
    }
}
