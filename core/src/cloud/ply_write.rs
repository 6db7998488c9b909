//! Writing PLY.

use super::PointCloud;

/// How the vertices of a PLY file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyEncoding {
    /// Text.
    Ascii,
    /// Binary, least significant byte first.
    LittleEndian,
    /// Binary, most significant byte first.
    BigEndian,
}

/// The bytes of a PLY file: x y z as doubles, so nothing is rounded, and red green blue when the cloud has colours.
///
/// The format has no place for the image or the sensor's pose.
pub fn write_ply(cloud: &PointCloud, encoding: PlyEncoding) -> Vec<u8> {
    let colored = cloud.colors.len() == cloud.points.len() && !cloud.colors.is_empty();
    let format = match encoding {
        PlyEncoding::Ascii => "ascii",
        PlyEncoding::LittleEndian => "binary_little_endian",
        PlyEncoding::BigEndian => "binary_big_endian",
    };
    let color = if colored { "property uchar red\nproperty uchar green\nproperty uchar blue\n" } else { "" };
    let mut out = format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n{color}\
         end_header\n",
        cloud.points.len()
    )
    .into_bytes();
    for (k, point) in cloud.points.iter().enumerate() {
        let rgb = cloud.colors.get(k).filter(|_| colored);
        match encoding {
            PlyEncoding::Ascii => {
                let mut line = format!("{} {} {}", point.x, point.y, point.z);
                if let Some([r, g, b]) = rgb {
                    line += &format!(" {r} {g} {b}");
                }
                out.extend_from_slice(line.as_bytes());
                out.push(b'\n');
                continue;
            }
            PlyEncoding::LittleEndian => point.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes())),
            PlyEncoding::BigEndian => point.iter().for_each(|x| out.extend_from_slice(&x.to_be_bytes())),
        }
        out.extend(rgb.into_iter().flatten());
    }
    out
}
