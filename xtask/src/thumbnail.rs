//! Pictures of the gallery travel inside the program, so they are kept small: as JPEG they take a third of the bytes of a
//! PNG and look the same on a card.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use anyhow::{Context as _, Result};
use image::codecs::jpeg::JpegEncoder;

/// Quality of a thumbnail, of 100: thin lines stay clean.
const QUALITY: u8 = 74;

/// Writes a drawn PNG as the JPEG of a thumbnail.
pub(crate) fn shrink(drawn: &Path, thumbnail: &Path) -> Result<()> {
    let picture = image::open(drawn).with_context(|| drawn.display().to_string())?.into_rgb8();
    let file = File::create(thumbnail).with_context(|| thumbnail.display().to_string())?;
    JpegEncoder::new_with_quality(BufWriter::new(file), QUALITY).encode_image(&picture)?;
    Ok(())
}
