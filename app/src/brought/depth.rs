//! Depth images: a 16-bit PNG, and the intrinsics of its camera or at least its field of view.

use endcomfort_core::cloud::{Intrinsics, MAX_DEPTH_SIDE, PcdEncoding, depth_cloud, write_pcd};
use endcomfort_core::job::DroppedCloud;
use endcomfort_core::loaded::Loaded;

/// Whether bytes begin as a PNG does.
pub fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// A depth image as it stands in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DepthImage {
    /// File name.
    pub name: String,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row, in the file's units.
    pub depth: Vec<u16>,
}

impl DepthImage {
    /// Reads a PNG of one channel of 16 bits.
    ///
    /// # Errors
    /// A sentence that says what was found instead.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), image::ImageFormat::Png);
        let mut limits = image::Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(MAX_DEPTH_SIDE), Some(MAX_DEPTH_SIDE));
        reader.limits(limits);
        let decoded = reader.decode().map_err(|error| format!("{name}: {error}"))?;
        let color = decoded.color();
        let image::DynamicImage::ImageLuma16(picture) = decoded else {
            let (channels, bits) = (color.channel_count(), color.bits_per_pixel() / u16::from(color.channel_count()));
            return Err(format!(
                "{name}: found {channels} channels of {bits} bits, wanted a depth image of one channel of 16 bits"
            ));
        };
        let (width, height) = picture.dimensions();
        Ok(Self { name: name.to_owned(), width, height, depth: picture.into_raw() })
    }

    /// The cloud that a camera measured so, as the file that the pipeline takes; and what was left out.
    ///
    /// # Errors
    /// A sentence when the intrinsics are wrong or those of another image.
    pub fn cloud(&self, camera: &Loaded<Intrinsics>) -> Result<DroppedCloud, String> {
        let found = depth_cloud(self.width, self.height, &self.depth, &camera.value);
        let cloud = found.map_err(|error| format!("{}: {error}", self.name))?;
        let stem = self.name.rsplit_once('.').map_or(self.name.as_str(), |(stem, _)| stem);
        Ok(DroppedCloud { name: format!("{stem}.pcd"), bytes: write_pcd(&cloud, PcdEncoding::Binary) })
    }

    /// The camera of this image if only its horizontal field of view is known.
    ///
    /// # Errors
    /// A sentence when no lens has such a view.
    pub fn camera_of_view(&self, degrees: f64) -> Result<Loaded<Intrinsics>, String> {
        let value = Intrinsics::of_view(self.width, self.height, degrees.to_radians());
        let value = value.map_err(|error| error.to_string())?;
        let note = format!("no intrinsics: a field of view of {degrees:.1}° was taken, the axis in the middle");
        Ok(Loaded { value, notes: vec![note] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use endcomfort_core::cloud::read_cloud;

    fn png(width: u32, height: u32, depth: Vec<u16>) -> Vec<u8> {
        let image = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(width, height, depth).expect("its size");
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).expect("it can be written");
        bytes.into_inner()
    }

    #[test]
    fn a_depth_image_becomes_an_organised_cloud_whose_sensor_is_known() {
        let depth: Vec<u16> = (0..64 * 48).map(|k| if k % 7 == 0 { 0 } else { 900 + (k % 64) as u16 }).collect();
        let bytes = png(64, 48, depth.clone());
        assert!(is_png(&bytes));
        let image = DepthImage::read("a.png", &bytes).expect("it is right");
        let cloud = image.cloud(&image.camera_of_view(60.0).expect("a lens")).expect("it has points");
        let read = read_cloud(&cloud.name, &cloud.bytes).expect("our own writer").value;
        assert_eq!(read.points.len(), depth.iter().filter(|&&d| d > 0).count());
        assert_eq!(read.grid.map(|grid| (grid.width, grid.height)), Some((64, 48)));
        let sensor = read.X_FC.expect("found from the pixels");
        assert!(sensor.translation.vector.norm() < 1e-9 && sensor.rotation.angle() < 0.01, "{sensor}");
    }

    #[test]
    fn a_photo_and_a_broken_file_are_refused_in_words() {
        let photo = image::RgbImage::new(4, 4);
        let mut bytes = std::io::Cursor::new(Vec::new());
        photo.write_to(&mut bytes, image::ImageFormat::Png).expect("it can be written");
        let photo = DepthImage::read("photo.png", bytes.get_ref()).expect_err("no depth");
        assert_eq!(photo, "photo.png: found 3 channels of 8 bits, wanted a depth image of one channel of 16 bits");
        let whole = png(8, 8, vec![7; 64]);
        assert!(DepthImage::read("cut.png", &whole[..40]).is_err());
        // No byte that is another one makes it panic.
        for at in 0..whole.len() {
            for other in [0, 1, 127, 255] {
                let mut bytes = whole.clone();
                bytes[at] = other;
                let _any = DepthImage::read("a.png", &bytes);
            }
        }
    }
}
