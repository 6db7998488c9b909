//! OBJ: positions, normals and faces; materials and lines are passed over.

use nalgebra::{Point3, Vector3};

use super::{MeshError, area_weighted_normals, check_count, wrong};
use crate::mesh::Mesh;

pub(super) fn read_obj(mut bytes: &[u8]) -> Result<Mesh, MeshError> {
    // A face is a line: more lines than this cannot be within the limit of triangles.
    let faces = bytes.split(|&byte| byte == b'\n').filter(|line| line.trim_ascii_start().starts_with(b"f ")).count();
    check_count(faces)?;
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let no_materials = |_: &std::path::Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut bytes, &options, no_materials)
        .map_err(|error| MeshError::Obj { reason: error.to_string() })?;
    let mut whole = Mesh::default();
    for model in models {
        let triple = |v: &[f32]| Vector3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
        let positions: Vec<_> = model.mesh.positions.chunks_exact(3).map(|v| Point3::from(triple(v))).collect();
        let triangles: Vec<_> = model.mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        if let Some(index) = triangles.iter().flatten().find(|&&i| i as usize >= positions.len()) {
            return Err(wrong("a face", format!("vertex {}", u64::from(*index) + 1), "a vertex that exists"));
        }
        let mut part = Mesh { positions, normals: Vec::new(), triangles };
        part.normals = if model.mesh.normals.len() == 3 * part.positions.len() {
            model.mesh.normals.chunks_exact(3).map(triple).collect()
        } else {
            area_weighted_normals(&part)
        };
        whole.append(&part);
    }
    Ok(whole)
}
