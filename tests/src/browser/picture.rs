//! Looking at a screenshot.

use std::collections::BTreeSet;

use anyhow::{Context as _, Result};
use image::RgbaImage;

/// A screenshot.
pub struct Picture(pub RgbaImage);

impl Picture {
    /// Reads a PNG.
    ///
    /// # Errors
    /// When the bytes are no PNG.
    pub fn from_png(bytes: &[u8]) -> Result<Self> {
        let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Png).context("no PNG")?;
        Ok(Self(image.into_rgba8()))
    }

    /// The upper part of the picture, for example three quarters of its height.
    #[must_use]
    pub fn top(&self, share: f64) -> Self {
        let (width, height) = self.0.dimensions();
        Self(image::imageops::crop_imm(&self.0, 0, 0, width, (f64::from(height) * share) as u32).to_image())
    }

    /// How many different colours there are; a blank picture has one.
    pub fn colors(&self) -> usize {
        self.0.pixels().map(|pixel| pixel.0).collect::<BTreeSet<_>>().len()
    }

    /// Share of pixels that differ from the other picture's; 1 if the sizes differ.
    pub fn difference(&self, other: &Self) -> f64 {
        if self.0.dimensions() != other.0.dimensions() || self.0.is_empty() {
            return 1.0;
        }
        let differing = self.0.pixels().zip(other.0.pixels()).filter(|(a, b)| a != b).count();
        differing as f64 / (self.0.len() / 4) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;

    #[test]
    fn colors_and_differences_are_counted() {
        let blank = Picture(RgbaImage::from_pixel(10, 10, Rgba([9, 9, 9, 255])));
        let mut dotted = Picture(blank.0.clone());
        dotted.0.put_pixel(3, 4, Rgba([200, 9, 9, 255]));
        assert_eq!((blank.colors(), dotted.colors()), (1, 2));
        assert_eq!(blank.difference(&dotted), 0.01);
        assert_eq!(blank.top(0.3).difference(&dotted.top(0.3)), 0.0, "the dot is in the fifth row of ten");
        assert_eq!(blank.top(0.5).difference(&dotted.top(0.5)), 0.02);
    }
}
