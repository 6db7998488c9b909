//! A picture as a file.

use std::io::Cursor;

use image::{ImageFormat, RgbaImage};

/// The picture as a PNG.
///
/// # Errors
/// What the encoder says.
pub fn png_bytes(picture: &RgbaImage) -> Result<Vec<u8>, String> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}
