//! Mesh files: OBJ, STL (binary and ascii) and GLB (binary glTF with static triangles), from bytes.
//!
//! Coordinates stay in the file's own unit; [`guess_unit`] tells metres from millimetres. What is not here: Collada,
//! textures, colours, compressed or animated glTF.

mod glb;
mod obj;
mod stl;
mod unit;

use nalgebra::Vector3;

use crate::mesh::Mesh;

pub use unit::{MeshUnit, guess_unit};

/// Most triangles of a mesh.
pub const MAX_TRIANGLES: usize = 500_000;
/// Largest mesh file, bytes.
pub const MAX_MESH_BYTES: usize = 64 << 20;
/// Endings of the formats that are read.
pub const ENDINGS: [&str; 3] = ["obj", "stl", "glb"];

/// Why a file is no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A format that is not read.
    #[error("meshes ending in .{ending} are not read, wanted .obj, .stl or .glb")]
    Format { ending: String },
    /// More than is read.
    #[error("found {found} {thing}, at most {limit} are read ({limit_name})")]
    TooMuch { thing: &'static str, found: usize, limit: usize, limit_name: &'static str },
    /// Something in the file is wrong.
    #[error("{place}: found {found}, wanted {wanted}")]
    Wrong { place: String, found: String, wanted: &'static str },
    /// Nothing to see.
    #[error("it has no faces")]
    Empty,
    /// The reader of OBJ files gave up.
    #[error("{reason}")]
    Obj { reason: String },
}

fn wrong(place: impl Into<String>, found: impl ToString, wanted: &'static str) -> MeshError {
    MeshError::Wrong { place: place.into(), found: found.to_string(), wanted }
}

fn check_count(triangles: usize) -> Result<(), MeshError> {
    let (found, limit) = (triangles, MAX_TRIANGLES);
    if found > limit {
        return Err(MeshError::TooMuch { thing: "triangles", found, limit, limit_name: "MAX_TRIANGLES" });
    }
    Ok(())
}

/// Reads a mesh by the ending of its name, with unit normals; z of a GLB, which has y up, is turned up.
///
/// # Errors
/// [`MeshError`] naming the place, what was found and what was wanted.
pub fn read_mesh(name: &str, bytes: &[u8]) -> Result<Mesh, MeshError> {
    let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    if !ENDINGS.contains(&ending.as_str()) {
        return Err(MeshError::Format { ending });
    }
    if bytes.len() > MAX_MESH_BYTES {
        let (found, limit) = (bytes.len(), MAX_MESH_BYTES);
        return Err(MeshError::TooMuch { thing: "bytes", found, limit, limit_name: "MAX_MESH_BYTES" });
    }
    let mut mesh = match ending.as_str() {
        "obj" => obj::read_obj(bytes)?,
        "stl" => stl::read_stl(bytes)?,
        _ => glb::read_glb(bytes)?,
    };
    if mesh.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    check_count(mesh.triangles.len())?;
    if let Some(at) = mesh.positions.iter().position(|p| !p.coords.iter().all(|x| x.is_finite())) {
        return Err(wrong(format!("vertex {at}"), "a coordinate that is not finite", "a finite number"));
    }
    if mesh.normals.len() != mesh.positions.len() {
        mesh.normals = area_weighted_normals(&mesh);
    }
    for n in &mut mesh.normals {
        *n = n.try_normalize(1e-12).unwrap_or_else(Vector3::z);
    }
    Ok(mesh)
}

/// Normals from the triangles around each vertex.
pub(crate) fn area_weighted_normals(mesh: &Mesh) -> Vec<Vector3<f64>> {
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
    fn formats_that_are_not_read_and_files_that_are_too_large_are_refused_by_name() {
        let refused = |name: &str, bytes: &[u8]| read_mesh(name, bytes).unwrap_err().to_string();
        assert_eq!(refused("a.dae", b"<COLLADA/>"), "meshes ending in .dae are not read, wanted .obj, .stl or .glb");
        let huge = vec![0; MAX_MESH_BYTES + 1];
        assert!(refused("a.stl", &huge).contains("MAX_MESH_BYTES"));
        assert_eq!(refused("a.obj", b"v 0 0 0\n"), "it has no faces");
    }

    #[test]
    fn no_bytes_make_a_reader_panic() {
        let obj = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n".to_vec();
        let good = [
            ("a.obj", obj),
            ("a.stl", stl::tests::binary(3)),
            ("b.stl", stl::tests::ascii()),
            ("a.glb", glb::tests::cube_corner()),
        ];
        let mut rng = crate::rng::Rng::new(21, 0);
        for (name, whole) in &good {
            assert!(read_mesh(name, whole).is_ok(), "{name}");
            for _ in 0..2000 {
                let mut bytes = whole.clone();
                for _ in 0..3 {
                    let at = (rng.unit() * bytes.len() as f64) as usize;
                    bytes[at] = (rng.unit() * 256.0) as u8;
                }
                bytes.truncate((rng.unit() * 1.3 * whole.len() as f64) as usize);
                let _any = read_mesh(name, &bytes);
            }
        }
    }
}
