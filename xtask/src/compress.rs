//! `.br` and `.gz` beside each file of the site, remembered by content.

use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};
use sha2::{Digest as _, Sha256};

use crate::process;

/// How hard to try: small files for the web, or quick ones for a page that is served to this machine alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    Quick,
    Small,
}

/// Sizes of a file in bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sizes {
    pub(crate) raw: usize,
    pub(crate) gzip: usize,
    pub(crate) brotli: usize,
}

/// Writes a file with its compressed forms beside it.
pub(crate) fn write(path: &Path, bytes: &[u8], effort: Effort) -> Result<Sizes> {
    let (quality, level) = match effort {
        Effort::Quick => (5, 6),
        Effort::Small => (11, 9),
    };
    let brotli = remembered(bytes, &format!("{quality}.br"), || brotli(bytes, quality))?;
    let gzip = remembered(bytes, &format!("{level}.gz"), || gzip(bytes, level))?;
    store(path, bytes)?;
    store(&with_suffix(path, "br"), &brotli)?;
    store(&with_suffix(path, "gz"), &gzip)?;
    Ok(Sizes { raw: bytes.len(), gzip: gzip.len(), brotli: brotli.len() })
}

/// The first hexadecimal digits of the content's SHA-256.
pub(crate) fn fingerprint(bytes: &[u8], digits: usize) -> String {
    let mut text: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    text.truncate(digits);
    text
}

/// `page.js` and `br` make `page.js.br`.
pub(crate) fn with_suffix(path: &Path, suffix: &str) -> std::path::PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(suffix);
    name.into()
}

fn remembered(bytes: &[u8], kind: &str, compress: impl FnOnce() -> Result<Vec<u8>>) -> Result<Vec<u8>> {
    let memory = process::root().join("target/site/compressed").join(format!("{}.{kind}", fingerprint(bytes, 64)));
    if let Ok(known) = std::fs::read(&memory) {
        return Ok(known);
    }
    let compressed = compress()?;
    store(&memory, &compressed)?;
    Ok(compressed)
}

fn brotli(bytes: &[u8], quality: i32) -> Result<Vec<u8>> {
    let parameters = brotli::enc::BrotliEncoderParams {
        quality,
        lgwin: 22,
        size_hint: bytes.len(),
        ..brotli::enc::BrotliEncoderParams::default()
    };
    let mut compressed = Vec::new();
    let mut input = bytes;
    brotli::BrotliCompress(&mut input, &mut compressed, &parameters)?;
    Ok(compressed)
}

fn gzip(bytes: &[u8], level: u32) -> Result<Vec<u8>> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::new(level));
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

fn store(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_compressions_give_the_bytes_back() {
        let bytes: Vec<u8> = (0..10_000_u32).flat_map(|i| (i / 7).to_le_bytes()).collect();
        let mut plain = Vec::new();
        let packed = brotli(&bytes, 5).unwrap();
        brotli::BrotliDecompress(&mut packed.as_slice(), &mut plain).unwrap();
        assert_eq!(plain, bytes);
        let mut plain = Vec::new();
        std::io::copy(&mut flate2::read::GzDecoder::new(gzip(&bytes, 6).unwrap().as_slice()), &mut plain).unwrap();
        assert_eq!(plain, bytes);
    }

    #[test]
    fn the_fingerprint_is_sha_256() {
        // FIPS 180-2, appendix B.1.
        assert_eq!(fingerprint(b"abc", 16), "ba7816bf8f01cfea");
    }
}
