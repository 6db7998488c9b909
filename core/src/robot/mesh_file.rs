//! Mesh files of robots: read like any other, then scaled as the URDF says.

use nalgebra::Vector3;

use crate::mesh::Mesh;
use crate::mesh_file;

/// Reads a mesh by the ending of its name and scales it.
///
/// # Errors
/// A phrase that completes "mesh … is left out: …".
pub(super) fn read_mesh(name: &str, bytes: &[u8], scale: Vector3<f64>) -> Result<Mesh, String> {
    let mut mesh = mesh_file::read_mesh(name, bytes).map_err(|error| error.to_string())?;
    if scale == Vector3::repeat(1.0) {
        return Ok(mesh);
    }
    for p in &mut mesh.positions {
        p.coords.component_mul_assign(&scale);
    }
    if scale.product() < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    mesh.normals = mesh_file::area_weighted_normals(&mesh);
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

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
        assert!(refusal.contains("1 triangles announced and 0 there"), "{refusal}");
    }
}
