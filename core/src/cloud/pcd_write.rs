//! Writing PCD v0.7.

use std::fmt::Write as _;

use super::PointCloud;

/// How the points of a PCD file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PcdEncoding {
    /// Text, readable and large.
    Ascii,
    /// Little-endian binary.
    Binary,
    /// Binary, compressed with LZF.
    BinaryCompressed,
}

/// The bytes of a PCD v0.7 file: x y z as 32-bit floats, `rgb` packed when the cloud has colours.
///
/// An organised cloud gets its holes back, as NaN; VIEWPOINT is `X_FC` as translation and w x y z. A sensor at the
/// origin with identity axes is the format's default, which readers take as "not said" unless the cloud is organised.
pub fn write_pcd(cloud: &PointCloud, encoding: PcdEncoding) -> Vec<u8> {
    let colored = cloud.colors.len() == cloud.points.len() && !cloud.colors.is_empty();
    let image = cloud.grid.as_ref().filter(|grid| grid.pixels.len() == cloud.points.len());
    let (width, height) = image.map_or((cloud.points.len() as u32, 1), |grid| (grid.width, grid.height));
    let count = width as usize * height as usize;
    let mut rows = vec![([f32::NAN; 3], 0u32); count];
    for (k, point) in cloud.points.iter().enumerate() {
        let place = image.map_or(k, |grid| grid.pixels.get(k).map_or(k, |pixel| *pixel as usize));
        let [r, g, b] = if colored { cloud.colors.get(k).copied().unwrap_or_default() } else { [0; 3] };
        if let Some(row) = rows.get_mut(place) {
            *row = ([point.x as f32, point.y as f32, point.z as f32], u32::from_be_bytes([0, r, g, b]));
        }
    }
    let columns = if colored { 4 } else { 3 };
    let mut out = header(cloud, colored, width, height, encoding).into_bytes();
    let words = |row: &([f32; 3], u32)| [row.0[0].to_bits(), row.0[1].to_bits(), row.0[2].to_bits(), row.1];
    match encoding {
        PcdEncoding::Ascii => {
            let mut text = String::new();
            for ([x, y, z], rgb) in &rows {
                // Writing into a string cannot fail.
                let _ = if colored { writeln!(text, "{x} {y} {z} {rgb}") } else { writeln!(text, "{x} {y} {z}") };
            }
            out.extend_from_slice(text.as_bytes());
        }
        PcdEncoding::Binary => {
            for row in &rows {
                words(row).iter().take(columns).for_each(|word| out.extend_from_slice(&word.to_le_bytes()));
            }
        }
        PcdEncoding::BinaryCompressed => {
            let mut raw = Vec::with_capacity(count * columns * 4);
            for column in 0..columns {
                rows.iter().for_each(|row| raw.extend_from_slice(&words(row)[column].to_le_bytes()));
            }
            let packed = lzf::compress(&raw).unwrap_or_else(|_| as_literals(&raw));
            out.extend_from_slice(&(packed.len() as u32).to_le_bytes());
            out.extend_from_slice(&(raw.len() as u32).to_le_bytes());
            out.extend_from_slice(&packed);
        }
    }
    out
}

fn header(cloud: &PointCloud, colored: bool, width: u32, height: u32, encoding: PcdEncoding) -> String {
    let (fields, size, kind, count) = if colored { (" rgb", " 4", " U", " 1") } else { ("", "", "", "") };
    let pose = cloud.X_FC.unwrap_or_default();
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    let data = match encoding {
        PcdEncoding::Ascii => "ascii",
        PcdEncoding::Binary => "binary",
        PcdEncoding::BinaryCompressed => "binary_compressed",
    };
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z{fields}\nSIZE 4 4 4{size}\n\
         TYPE F F F{kind}\nCOUNT 1 1 1{count}\nWIDTH {width}\nHEIGHT {height}\n\
         VIEWPOINT {} {} {} {} {} {} {}\nPOINTS {}\nDATA {data}\n",
        t.x,
        t.y,
        t.z,
        q.w,
        q.x,
        q.y,
        q.z,
        u64::from(width) * u64::from(height)
    )
}

/// LZF without any compression, for data that cannot be compressed: runs of up to 32 literal bytes.
fn as_literals(raw: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(raw.len() + raw.len() / 32 + 1);
    for run in raw.chunks(32) {
        out.push((run.len() - 1) as u8);
        out.extend_from_slice(run);
    }
    out
}
