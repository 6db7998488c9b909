//! Pictures of the gallery travel inside the program, so they are kept small: 128 colours instead of millions take a
//! quarter of the bytes and look the same on a card.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use color_quant::NeuQuant;

/// Colours of a thumbnail.
const COLORS: usize = 128;
/// Pixels that the palette is learnt from: every one.
const EVERY: i32 = 1;

/// Writes a PNG anew with a palette.
pub(crate) fn shrink(path: &Path) -> Result<()> {
    let place = || path.display().to_string();
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).with_context(place)?)).read_info()?;
    let mut pixels = vec![0; reader.output_buffer_size().with_context(place)?];
    let info = reader.next_frame(&mut pixels)?;
    if (info.color_type, info.bit_depth) != (png::ColorType::Rgba, png::BitDepth::Eight) {
        bail!("{}: found {:?} of {:?}, wanted 8-bit RGBA", place(), info.color_type, info.bit_depth);
    }
    let pixels = &pixels[..info.buffer_size()];
    let palette = NeuQuant::new(EVERY, COLORS, pixels);
    let indices: Vec<u8> = pixels.chunks_exact(4).map(|pixel| palette.index_of(pixel) as u8).collect();
    let mut encoder =
        png::Encoder::new(BufWriter::new(File::create(path).with_context(place)?), info.width, info.height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.color_map_rgb());
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(&indices)?;
    Ok(())
}
