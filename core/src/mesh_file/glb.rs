//! GLB: the container, its JSON, and accessors of positions and indices (glTF 2.0, sections 3.6, 3.7 and 4.4).
//!
//! The nodes of the scene are walked with their transforms, triangles are taken, everything else (materials, skins,
//! animations, lines) is passed over. glTF has y up and metres.

use nalgebra::{Matrix4, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;

use super::{MeshError, check_count, wrong};
use crate::mesh::Mesh;

/// Nodes that are walked; a loop among them ends there.
const MOST_NODES: usize = 10_000;
/// Component types of indices and positions.
const U8: u64 = 5121;
const U16: u64 = 5123;
const U32: u64 = 5125;
const F32: u64 = 5126;
/// Primitive mode of triangles, also where none is stated.
const TRIANGLES: u64 = 4;

pub(super) fn read_glb(bytes: &[u8]) -> Result<Mesh, MeshError> {
    if !bytes.starts_with(b"glTF") {
        let found = String::from_utf8_lossy(bytes.get(..4).unwrap_or(bytes)).into_owned();
        return Err(wrong("byte 0", format!("{found:?}"), "glTF, as a .glb begins"));
    }
    let version = u32_at(bytes, 4).unwrap_or(0);
    if version != 2 {
        return Err(wrong("byte 4", format!("version {version}"), "version 2"));
    }
    let (json, next) = chunk(bytes, 12, b"JSON")?;
    let bin = chunk(bytes, next, b"BIN\0").map_or(&[][..], |(bin, _)| bin);
    let json: Value = serde_json::from_slice(json).map_err(|error| wrong("JSON chunk", error, "JSON"))?;
    if let Some(needed) = json["extensionsRequired"].as_array().and_then(|list| list.first()) {
        return Err(wrong("extensionsRequired", needed, "a file without compression or other needed extensions"));
    }
    let file = File { json: &json, bin };
    let scene = json["scene"].as_u64().unwrap_or(0) as usize;
    let roots = &json["scenes"][scene]["nodes"];
    let all: Vec<Value> = (0..json["nodes"].as_array().map_or(0, Vec::len)).map(|node| node.into()).collect();
    let roots = roots.as_array().unwrap_or(&all);
    let mut mesh = Mesh::default();
    // z up: x stays, y becomes z.
    let upright = Matrix4::new(1., 0., 0., 0., 0., 0., -1., 0., 0., 1., 0., 0., 0., 0., 0., 1.);
    let mut pending: Vec<(usize, Matrix4<f64>)> =
        roots.iter().rev().filter_map(|n| Some((index(n)?, upright))).collect();
    let mut walked = 0;
    while let Some((node, above)) = pending.pop() {
        walked += 1;
        if walked > MOST_NODES {
            return Err(wrong("nodes", format!("more than {MOST_NODES}"), "a tree of nodes without loops"));
        }
        let node = &json["nodes"][node];
        let X = above * transform(node);
        if let Some(index) = index(&node["mesh"]) {
            file.add_mesh(index, &X, &mut mesh)?;
        }
        if let Some(children) = node["children"].as_array() {
            pending.extend(children.iter().rev().filter_map(|child| Some((self::index(child)?, X))));
        }
    }
    Ok(mesh)
}

fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// Content of the chunk at a place, and where the next one begins.
fn chunk<'b>(bytes: &'b [u8], at: usize, kind: &[u8; 4]) -> Result<(&'b [u8], usize), MeshError> {
    let place = || format!("byte {at}");
    let name = || String::from_utf8_lossy(kind).trim_end_matches('\0').to_owned();
    let length = u32_at(bytes, at).ok_or_else(|| wrong(place(), "the end of the file", "another chunk"))? as usize;
    if bytes.get(at + 4..at + 8) != Some(kind) {
        return Err(wrong(place(), format!("no {} chunk", name()), "the chunks of a .glb"));
    }
    let (begin, end) = (at + 8, at + 8 + length);
    let content = bytes.get(begin..end);
    let content = content.ok_or_else(|| wrong(place(), format!("a chunk of {length} bytes"), "one within the file"))?;
    Ok((content, end))
}

/// A node's transform: a matrix, or translation, rotation and scale.
fn transform(node: &Value) -> Matrix4<f64> {
    let numbers = |name: &str| -> Vec<f64> {
        node[name].as_array().map(|list| list.iter().filter_map(Value::as_f64).collect()).unwrap_or_default()
    };
    if let Ok(columns) = <[f64; 16]>::try_from(numbers("matrix")) {
        return Matrix4::from_column_slice(&columns);
    }
    let t = <[f64; 3]>::try_from(numbers("translation")).unwrap_or_default();
    let s = <[f64; 3]>::try_from(numbers("scale")).unwrap_or([1.0; 3]);
    let [x, y, z, w] = <[f64; 4]>::try_from(numbers("rotation")).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9).unwrap_or_default();
    Translation3::from(Vector3::from(t)).to_homogeneous()
        * turn.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&Vector3::from(s))
}

struct File<'a> {
    json: &'a Value,
    bin: &'a [u8],
}

impl File<'_> {
    fn add_mesh(&self, mesh: usize, X: &Matrix4<f64>, whole: &mut Mesh) -> Result<(), MeshError> {
        let primitives = self.json["meshes"][mesh]["primitives"].as_array();
        for (number, primitive) in primitives.into_iter().flatten().enumerate() {
            if primitive["mode"].as_u64().unwrap_or(TRIANGLES) != TRIANGLES {
                continue;
            }
            let place = format!("mesh {mesh}, primitive {number}");
            let positions = index(&primitive["attributes"]["POSITION"])
                .ok_or_else(|| wrong(place.clone(), "no POSITION", "positions"))?;
            let positions = self.read(&place, positions, 3, &[F32])?;
            let count = positions.len() / 3;
            let indices: Vec<u32> = match index(&primitive["indices"]) {
                Some(accessor) => {
                    self.read(&place, accessor, 1, &[U8, U16, U32])?.iter().map(|&index| index as u32).collect()
                }
                None => (0..count as u32).collect(),
            };
            check_count(whole.triangles.len() + indices.len() / 3)?;
            if let Some(index) = indices.iter().find(|&&index| index as usize >= count) {
                return Err(wrong(place, format!("index {index} of {count} vertices"), "an index of a vertex"));
            }
            let base = whole.positions.len() as u32;
            let point = |p: &[f64]| X.transform_point(&Point3::new(p[0], p[1], p[2]));
            whole.positions.extend(positions.chunks_exact(3).map(point));
            // A mirroring transform turns triangles inside out.
            let is_mirrored = X.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
            whole.triangles.extend(indices.chunks_exact(3).map(|t| {
                let [a, b, c] = [t[0] + base, t[1] + base, t[2] + base];
                if is_mirrored { [a, c, b] } else { [a, b, c] }
            }));
        }
        Ok(())
    }

    /// The numbers of an accessor, so many for each element; all of it is known to lie within the file first.
    fn read(&self, place: &str, accessor: usize, width: usize, kinds: &[u64]) -> Result<Vec<f64>, MeshError> {
        let place = format!("{place}, accessor {accessor}");
        let about = &self.json["accessors"][accessor];
        let kind = about["componentType"].as_u64().unwrap_or(0);
        let wanted_type = if width == 3 { "VEC3" } else { "SCALAR" };
        if !kinds.contains(&kind) || about["type"] != wanted_type || about.get("sparse").is_some() {
            let found = format!("{} of component type {kind}", about["type"]);
            return Err(wrong(place, found, "plain float positions or unsigned indices"));
        }
        let size = match kind {
            U8 => 1,
            U16 => 2,
            _ => 4,
        };
        let count = index(&about["count"]).unwrap_or(0);
        let view = &self.json["bufferViews"][index(&about["bufferView"]).unwrap_or(usize::MAX)];
        let stride = index(&view["byteStride"]).unwrap_or(size * width);
        let offset = |value: &Value| index(value).unwrap_or(0);
        let begin = offset(&view["byteOffset"]).checked_add(offset(&about["byteOffset"]));
        let last = count.saturating_sub(1).checked_mul(stride).and_then(|way| way.checked_add(size * width));
        let end = begin.zip(last).and_then(|(begin, last)| begin.checked_add(last));
        let fits = view.is_object() && offset(&view["buffer"]) == 0 && end.is_some_and(|end| end <= self.bin.len());
        let (Some(begin), true) = (begin, fits && count > 0) else {
            let found = format!("{count} elements beyond the {} bytes of the binary chunk", self.bin.len());
            return Err(wrong(place, found, "elements within it"));
        };
        let number = |at: usize| {
            let raw = &self.bin[at..at + size];
            match kind {
                U8 => f64::from(raw[0]),
                U16 => f64::from(u16::from_le_bytes([raw[0], raw[1]])),
                U32 => f64::from(u32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])),
                _ => f64::from(f32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])),
            }
        };
        let elements = (0..count).map(|element| begin + element * stride);
        Ok(elements.flat_map(|at| (0..width).map(move |k| at + k * size)).map(number).collect())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
        let mut json = json.as_bytes().to_vec();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(json);
        bytes.extend((bin.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(bin);
        bytes
    }

    const JSON: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "translation": [0, 1, 0]}, {"mesh": 0, "scale": [2, 2, 2]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "buffers": [{"byteLength": 44}]}"#;

    /// One triangle with its corners on the axes.
    pub(in crate::mesh_file) fn cube_corner() -> Vec<u8> {
        let mut bin = Vec::new();
        for value in [1.0_f32, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] {
            bin.extend(value.to_le_bytes());
        }
        for index in [0_u16, 1, 2, 0] {
            bin.extend(index.to_le_bytes());
        }
        glb(JSON, &bin)
    }

    #[test]
    fn nodes_place_their_meshes_and_z_is_up() {
        let mesh = read_glb(&cube_corner()).unwrap();
        // Twice as large, one higher: y up becomes z up.
        let wanted = [Point3::new(2.0, 0.0, 1.0), Point3::new(0.0, 0.0, 3.0), Point3::new(0.0, -2.0, 1.0)];
        for (found, wanted) in mesh.positions.iter().zip(wanted) {
            assert!((found - wanted).norm() < 1e-12, "{found}");
        }
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn what_does_not_fit_is_refused_by_its_place() {
        let refused = |from: &str, to: &str| {
            let text = JSON.replace(from, to);
            assert_ne!(text, JSON);
            read_glb(&glb(&text, &[0; 44])).unwrap_err().to_string()
        };
        assert!(refused("\"count\": 3},", "\"count\": 4000000000},").contains("accessor 0: found 4000000000 elements"));
        assert!(refused("5126", "5130").contains("component type 5130"));
        assert!(refused("[1], \"tr", "[0], \"tr").contains("more than 10000"));
        let compressed =
            refused("\"scene\": 0", "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"scene\": 0");
        assert!(compressed.contains("KHR_draco_mesh_compression"), "{compressed}");
        assert!(read_glb(b"not a glb").unwrap_err().to_string().starts_with("byte 0: found \"not \""));
    }
}
