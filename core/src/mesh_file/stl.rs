//! STL: binary (80 bytes of header, a count, 50 bytes per triangle) and ascii (`vertex x y z`, three per facet).

use nalgebra::{Point3, Vector3};

use super::{MeshError, check_count, wrong};
use crate::mesh::Mesh;

/// Header and count of a binary file.
const HEADER: usize = 84;
/// Bytes of a triangle.
const RECORD: usize = 50;

/// Reads either kind. A file is binary when its length is that of its count: headers of binary files may begin with
/// `solid` as well.
pub(super) fn read_stl(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let count = bytes.get(80..HEADER).and_then(|count| Some(u32::from_le_bytes(*count.first_chunk()?) as usize));
    let holds = bytes.len().saturating_sub(HEADER) / RECORD;
    if bytes.trim_ascii_start().starts_with(b"solid") && count != Some(holds) {
        return read_ascii(bytes);
    }
    let Some(count) = count else {
        return Err(wrong(
            "header",
            format!("{} bytes", bytes.len()),
            "84 bytes of header, or text that begins with solid",
        ));
    };
    check_count(count)?;
    if count == 0 || holds < count {
        let found = format!("{count} triangles announced and {holds} there");
        return Err(wrong("count", found, "as many triangles as announced, and at least one"));
    }
    let mut mesh = Mesh::default();
    for record in bytes[HEADER..].chunks_exact(RECORD).take(count) {
        let number = |k: usize| f64::from(f32::from_le_bytes([record[k], record[k + 1], record[k + 2], record[k + 3]]));
        let corner = |k: usize| Point3::new(number(k), number(k + 4), number(k + 8));
        // The stored normal is often zero: ours come from the corners.
        push(&mut mesh, [corner(12), corner(24), corner(36)]);
    }
    Ok(mesh)
}

fn read_ascii(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let mut mesh = Mesh::default();
    let mut corners: Vec<Point3<f64>> = Vec::new();
    for (line, raw) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let place = || format!("line {}", line + 1);
        let text = str::from_utf8(raw).map_err(|_| wrong(place(), "bytes that are no text", "ascii STL"))?;
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("vertex") => {
                let mut p = Vector3::zeros();
                for axis in 0..3 {
                    let word = words.next().unwrap_or("nothing");
                    p[axis] = word.parse().map_err(|_| wrong(place(), word, "three numbers: vertex x y z"))?;
                }
                corners.push(p.into());
            }
            Some("endfacet" | "endloop") => {
                if let [a, b, c] = corners[..] {
                    check_count(mesh.triangles.len() + 1)?;
                    push(&mut mesh, [a, b, c]);
                } else if !corners.is_empty() {
                    return Err(wrong(place(), format!("{} corners", corners.len()), "three corners of a facet"));
                }
                corners.clear();
            }
            _ => {}
        }
    }
    Ok(mesh)
}

fn push(mesh: &mut Mesh, corners: [Point3<f64>; 3]) {
    let base = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.push([base, base + 1, base + 2]);
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A strip of triangles.
    pub(in crate::mesh_file) fn binary(count: u32) -> Vec<u8> {
        let mut bytes = b"solid, but binary".to_vec();
        bytes.resize(80, 0);
        bytes.extend(count.to_le_bytes());
        for k in 0..count {
            let x = k as f32;
            for value in [0.0, 0.0, 0.0, x, 0.0, 0.0, x + 1.0, 0.0, 0.0, x, 1.0, 0.0] {
                bytes.extend(f32::to_le_bytes(value));
            }
            bytes.extend([0, 0]);
        }
        bytes
    }

    pub(in crate::mesh_file) fn ascii() -> Vec<u8> {
        b"solid part\n facet normal 0 0 0\n  outer loop\n   vertex 0 0 0\n   vertex 1e0 0 0\n   vertex 0 1 0\n  endloop\n \
          endfacet\nendsolid part\n"
            .to_vec()
    }

    #[test]
    fn binary_and_ascii_hold_the_same_triangle() {
        for bytes in [binary(1), ascii()] {
            let mesh = read_stl(&bytes).unwrap();
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
            assert_eq!(mesh.positions[1], Point3::new(1.0, 0.0, 0.0));
        }
    }

    #[test]
    fn what_is_cut_short_or_no_number_is_refused_by_its_place() {
        let refused = |bytes: &[u8]| read_stl(bytes).unwrap_err().to_string();
        let mut cut = binary(5);
        cut[0] = b'x';
        assert!(refused(&cut[..150]).starts_with("count: found 5 triangles announced and 1 there"));
        let text = String::from_utf8(ascii()).unwrap();
        assert!(refused(text.replace("1e0", "one").as_bytes()).starts_with("line 5: found one, wanted three numbers"));
        let two = text.replacen("vertex 0 0 0\n", "", 1);
        assert!(refused(two.as_bytes()).contains("found 2 corners"));
        let mut many = binary(1);
        many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        many[0] = b'x';
        assert!(refused(&many).contains("MAX_TRIANGLES"));
    }
}
