//! Which reader a file needs.

use super::error::excerpt;
use super::{CloudError, PointCloud, pcd, ply, xyz};
use crate::loaded::Loaded;

/// More points than this are refused: 65 times a 640 × 480 image, about 0.5 GB of coordinates.
pub const MAX_POINTS: usize = 20_000_000;

/// Points with a coordinate beyond this are dropped and counted, metres. Map coordinates (a northing reaches 10 000 km)
/// are still points; numbers without meaning are not, and squares of what is left cannot overflow.
pub const MAX_COORDINATE_M: f64 = 1e7;

/// Reads a PCD (v0.7: ascii, binary, binary_compressed), PLY (ascii, both binaries) or XYZ file.
///
/// The content decides which reader is used, and the extension of `name` where the content does not say. Notes count
/// the points that were dropped and say how the sensor's pose was found. Counts in a header are compared with the
/// bytes that are there before anything is allocated.
///
/// # Errors
/// [`CloudError`] names the line or byte, the thing that is wrong, what was found and what was wanted.
pub fn read_cloud(name: &str, bytes: &[u8]) -> Result<Loaded<PointCloud>, CloudError> {
    let extension = name.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    if ply::looks_like_ply(bytes) {
        return ply::read_ply(bytes);
    }
    if pcd::looks_like_pcd(bytes) {
        return pcd::read_pcd(bytes);
    }
    match extension.as_deref() {
        Some("pcd") => pcd::read_pcd(bytes),
        Some("ply") => ply::read_ply(bytes),
        Some("xyz" | "txt" | "asc" | "pts" | "csv") => xyz::read_xyz(bytes),
        _ if xyz::looks_like_xyz(bytes) => xyz::read_xyz(bytes),
        _ => Err(CloudError::UnknownFormat {
            name: name.chars().take(80).collect(),
            start: excerpt(&String::from_utf8_lossy(bytes.get(..64).unwrap_or(bytes))).trim_matches('"').to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_refused_by_name_and_beginning() {
        let error = read_cloud("photo.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").unwrap_err();
        let text = error.to_string();
        assert!(text.contains("photo.png") && text.contains("PNG"), "{text}");
        assert!(matches!(read_cloud("empty", b""), Err(CloudError::UnknownFormat { .. })));
    }

    #[test]
    fn the_content_outranks_the_extension() {
        let pcd =
            b"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n";
        assert_eq!(read_cloud("cloud.xyz", pcd).unwrap().value.points.len(), 1);
        assert_eq!(read_cloud("no extension", b"1 2 3\n4 5 6\n").unwrap().value.points.len(), 2);
    }
}
