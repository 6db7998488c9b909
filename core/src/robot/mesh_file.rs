//! Mesh files of robots: OBJ and binary STL, from bytes.

use nalgebra::{Point3, Vector3};

use crate::mesh::Mesh;

/// Reads a mesh by the ending of its name and scales it.
///
/// # Errors
/// A phrase that completes "mesh … is left out: …".
pub(super) fn read_mesh(name: &str, bytes: &[u8], scale: Vector3<f64>) -> Result<Mesh, String> {
    let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    let mut mesh = match ending.as_str() {
        "obj" => read_obj(bytes)?,
        "stl" => read_binary_stl(bytes)?,
        _ => return Err(format!("meshes ending in .{ending} are not read, wanted .obj or .stl")),
    };
    for p in &mut mesh.positions {
        p.coords.component_mul_assign(&scale);
    }
    if scale.product() < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    if !mesh.positions.iter().all(|p| p.coords.iter().all(|x| x.is_finite())) {
        return Err("a vertex is not finite".to_owned());
    }
    let scaled = scale.iter().any(|&s| s != 1.0);
    if scaled || mesh.normals.len() != mesh.positions.len() {
        mesh.normals = area_weighted_normals(&mesh);
    }
    for n in &mut mesh.normals {
        *n = n.try_normalize(1e-12).unwrap_or_else(Vector3::z);
    }
    Ok(mesh)
}

fn read_obj(mut bytes: &[u8]) -> Result<Mesh, String> {
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let no_materials = |_: &std::path::Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut bytes, &options, no_materials).map_err(|error| error.to_string())?;
    let mut whole = Mesh::default();
    for model in models {
        let triple = |v: &[f32]| Vector3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
        let positions: Vec<_> = model.mesh.positions.chunks_exact(3).map(|v| Point3::from(triple(v))).collect();
        let triangles: Vec<_> = model.mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        if triangles.iter().flatten().any(|&i| i as usize >= positions.len()) {
            return Err("a face names a vertex that does not exist".to_owned());
        }
        let mut part = Mesh { positions, normals: Vec::new(), triangles };
        part.normals = if model.mesh.normals.len() == 3 * part.positions.len() {
            model.mesh.normals.chunks_exact(3).map(triple).collect()
        } else {
            area_weighted_normals(&part)
        };
        whole.append(&part);
    }
    if whole.triangles.is_empty() { Err("it has no faces".to_owned()) } else { Ok(whole) }
}

/// Binary STL: 80 bytes of header, a count, then 50 bytes per triangle.
fn read_binary_stl(bytes: &[u8]) -> Result<Mesh, String> {
    let Some((count, body)) = bytes.get(80..).and_then(|rest| rest.split_first_chunk::<4>()) else {
        return Err(format!("{} bytes are too few for binary STL", bytes.len()));
    };
    let count = u32::from_le_bytes(*count) as usize;
    if count == 0 || body.len() / 50 < count {
        return Err(format!("binary STL announces {count} triangles and holds {}", body.len() / 50));
    }
    let mut mesh = Mesh::default();
    for record in body.chunks_exact(50).take(count) {
        let mut values = record[..48].chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
        let mut triple = || {
            let mut next = || values.next().unwrap_or_default();
            Vector3::new(next(), next(), next())
        };
        triple(); // the stored normal is often zero: ours come from the corners
        let base = mesh.positions.len() as u32;
        mesh.positions.extend((0..3).map(|_| Point3::from(triple())));
        mesh.triangles.push([base, base + 1, base + 2]);
    }
    Ok(mesh)
}

fn area_weighted_normals(mesh: &Mesh) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let doubled_area = (b - a).cross(&(c - a));
        for &i in triangle {
            normals[i as usize] += doubled_area;
        }
    }
    normals.iter().map(|n| n.try_normalize(1e-300).unwrap_or_else(Vector3::z)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn obj_quads_keep_their_normals_and_scale() {
        let obj = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n";
        let mesh = read_mesh("a/plate.OBJ", obj, Vector3::new(1.0, 2.0, 1.0)).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
        assert!(mesh.normals.iter().all(|n| (n - Vector3::z()).norm() < 1e-9));
        assert!(mesh.positions.iter().any(|p| (p - Point3::new(1.0, 2.0, 0.0)).norm() < 1e-9));
    }

    #[test]
    fn binary_stl_is_read_and_a_short_one_is_refused() {
        let mut bytes = vec![0u8; 80];
        bytes.extend(1u32.to_le_bytes());
        for value in [0.0f32, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0, 0]);
        let mesh = read_mesh("x.stl", &bytes, Vector3::repeat(1.0)).unwrap();
        assert_eq!(mesh.normals[0], Vector3::z());
        let refusal = read_mesh("x.stl", &bytes[..120], Vector3::repeat(1.0)).unwrap_err();
        assert!(refusal.contains("announces 1"), "{refusal}");
    }
}
