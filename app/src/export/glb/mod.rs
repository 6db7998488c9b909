//! A scene as one binary glTF 2.0 file: bodies and colours, with an animation over the plan, or with clouds and lines as
//! they stand.
//!
//! Every body of the picture is a node; those that move have a translation and a rotation over time. Metres and
//! seconds; the world's z is turned to glTF's y.

mod marks;

use std::sync::Arc;

use endcomfort_core::mesh::Mesh;
use nalgebra::Isometry3;
use serde_json::{Value, json};

use self::marks::Marks;
use crate::render::{Frame, LineDraw, MeshDraw, PointsDraw, Surface};

/// Largest file that is written, bytes: 256 MB.
const MAX_BYTES: usize = 256 << 20;
/// Bodies that move less than this all the time stand still, metres and sine of half the angle.
const STILL: f64 = 1e-9;

/// Bodies at one time, seconds; the same ones in the same order at all times.
pub struct Moment {
    /// Seconds from the start of the plan.
    pub time_s: f64,
    /// Bodies.
    pub meshes: Vec<MeshDraw>,
}

/// The moments as a file; one moment alone stands still.
///
/// # Errors
/// A sentence when there is nothing to write, when bodies come or go from moment to moment, or when the file would be
/// larger than 256 MB.
pub fn glb(moments: &[Moment]) -> Result<Vec<u8>, String> {
    write(moments, &[], &[])
}

/// Everything that a picture shows: bodies, clouds as points in their colours, lines.
///
/// # Errors
/// A sentence when the picture is empty, or when the file would be larger than 256 MB.
pub fn glb_scene(frame: &Frame) -> Result<Vec<u8>, String> {
    if frame.bodies().next().is_none() && frame.points.is_empty() && frame.lines.is_empty() {
        return Err("there is nothing to export".to_owned());
    }
    write(&[Moment { time_s: 0.0, meshes: frame.bodies().cloned().collect() }], &frame.points, &frame.lines)
}

fn write(moments: &[Moment], clouds: &[PointsDraw], lines: &[LineDraw]) -> Result<Vec<u8>, String> {
    let first = moments.first().ok_or("there is nothing to export")?;
    for moment in moments {
        let same = |(a, b): (&MeshDraw, &MeshDraw)| Arc::ptr_eq(&a.mesh, &b.mesh);
        if moment.meshes.len() != first.meshes.len() || !moment.meshes.iter().zip(&first.meshes).all(same) {
            return Err(format!("at {:.2} s there are other bodies than at the start", moment.time_s));
        }
    }
    let mut file = File::default();
    let mut geometries: Vec<(Arc<Mesh>, Geometry)> = Vec::new();
    let mut looks: Vec<([f32; 4], Surface)> = Vec::new();
    let mut meshes: Vec<(usize, usize)> = Vec::new();
    let mut nodes = Vec::new();
    for draw in &first.meshes {
        let geometry = match geometries.iter().position(|(known, _)| Arc::ptr_eq(known, &draw.mesh)) {
            Some(index) => index,
            None => {
                let geometry = file.geometry(&draw.mesh)?;
                geometries.push((draw.mesh.clone(), geometry));
                geometries.len() - 1
            }
        };
        let look = index_of(&mut looks, (draw.color, draw.surface));
        let mesh = index_of(&mut meshes, (geometry, look));
        nodes.push(json!({
            "mesh": mesh,
            "translation": translation(&draw.X_WM),
            "rotation": rotation(&draw.X_WM, None),
        }));
    }
    let marks = Marks::of(&mut file, clouds, lines, looks.len())?;
    nodes.extend((0..marks.meshes.len()).map(|mark| json!({ "mesh": meshes.len() + mark })));
    let animations = file.animation(moments)?;
    // The world: z up becomes y up.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let bodies: Vec<usize> = (0..nodes.len()).collect();
    let world = nodes.len();
    nodes.push(json!({ "name": "world", "rotation": [-half, 0.0, 0.0, half], "children": bodies }));
    let primitive = |&(geometry, look): &(usize, usize)| {
        let Geometry { positions, normals, indices } = geometries[geometry].1;
        json!({ "primitives": [{
            "attributes": { "POSITION": positions, "NORMAL": normals },
            "indices": indices,
            "material": look,
        }] })
    };
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "Endcomfort" },
        "scene": 0,
        "scenes": [{ "nodes": [world] }],
        "nodes": nodes,
        "meshes": meshes.iter().map(primitive).chain(marks.meshes).collect::<Vec<_>>(),
        "materials": looks.iter().map(material).chain(marks.materials.iter().cloned()).collect::<Vec<_>>(),
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.bytes.len() }],
    });
    if !marks.materials.is_empty() {
        root["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    }
    if let Some(animation) = animations {
        root["animations"] = json!([animation]);
    }
    Ok(container(&root, &file.bytes))
}

fn index_of<T: PartialEq>(list: &mut Vec<T>, wanted: T) -> usize {
    list.iter().position(|known| *known == wanted).unwrap_or_else(|| {
        list.push(wanted);
        list.len() - 1
    })
}

fn translation(X: &Isometry3<f64>) -> [f32; 3] {
    X.translation.vector.map(|x| x as f32).into()
}

/// The quaternion x, y, z, w, on the side of the one before it, so that nothing turns the long way round.
fn rotation(X: &Isometry3<f64>, before: Option<[f32; 4]>) -> [f32; 4] {
    let mut q: [f32; 4] = X.rotation.coords.map(|x| x as f32).into();
    if before.is_some_and(|before| before.iter().zip(&q).map(|(a, b)| a * b).sum::<f32>() < 0.0) {
        q = q.map(|x| -x);
    }
    q
}

/// The linear value of a display value: glTF's colours are linear.
fn linear(c: f32) -> f32 {
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn material(&(color, surface): &([f32; 4], Surface)) -> Value {
    let [r, g, b, a] = color;
    let (metallic, roughness) = match surface {
        Surface::Gloss => (0.3, 0.25),
        Surface::Satin => (0.0, 0.5),
        Surface::Matte | Surface::Unlit | Surface::Facet | Surface::Ghost => (0.0, 0.95),
    };
    let mut material = json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [linear(r), linear(g), linear(b), a],
            "metallicFactor": metallic,
            "roughnessFactor": roughness,
        },
        "doubleSided": true,
    });
    if a < 1.0 {
        material["alphaMode"] = json!("BLEND");
    }
    material
}

/// Accessors of a mesh.
#[derive(Clone, Copy)]
struct Geometry {
    positions: usize,
    normals: usize,
    indices: usize,
}

/// The binary chunk and what lies where in it.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// Floats in groups of `N`, as an accessor.
    fn floats<const N: usize>(&mut self, values: &[[f32; N]], with_bounds: bool) -> Result<usize, String> {
        let begin = self.bytes.len();
        values.iter().flatten().for_each(|value| self.bytes.extend(value.to_le_bytes()));
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let mut accessor =
            json!({ "bufferView": self.views.len(), "componentType": 5126, "count": values.len(), "type": kind });
        if with_bounds {
            let fold = |pick: fn(f32, f32) -> f32, from: f32| -> Vec<f32> {
                (0..N).map(|k| values.iter().map(|value| value[k]).fold(from, pick)).collect()
            };
            accessor["min"] = json!(fold(f32::min, f32::INFINITY));
            accessor["max"] = json!(fold(f32::max, f32::NEG_INFINITY));
        }
        self.push(begin, accessor)
    }

    fn push(&mut self, begin: usize, accessor: Value) -> Result<usize, String> {
        if self.bytes.len() > MAX_BYTES {
            return Err(format!("the file would be larger than {} MB", MAX_BYTES >> 20));
        }
        self.views.push(json!({ "buffer": 0, "byteOffset": begin, "byteLength": self.bytes.len() - begin }));
        self.accessors.push(accessor);
        Ok(self.accessors.len() - 1)
    }

    fn geometry(&mut self, mesh: &Mesh) -> Result<Geometry, String> {
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.coords.map(|x| x as f32).into()).collect();
        let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|n| n.map(|x| x as f32).into()).collect();
        let positions = self.floats(&positions, true)?;
        let normals = self.floats(&normals, false)?;
        let begin = self.bytes.len();
        mesh.triangles.iter().flatten().for_each(|index| self.bytes.extend(index.to_le_bytes()));
        let count = 3 * mesh.triangles.len();
        let accessor =
            json!({ "bufferView": self.views.len(), "componentType": 5125, "count": count, "type": "SCALAR" });
        Ok(Geometry { positions, normals, indices: self.push(begin, accessor)? })
    }

    /// Where every body that moves is at every moment; `None` if none does.
    fn animation(&mut self, moments: &[Moment]) -> Result<Option<Value>, String> {
        let first = &moments[0];
        let moves = |index: usize| {
            let X = &first.meshes[index].X_WM;
            moments.iter().any(|moment| {
                let to = X.inv_mul(&moment.meshes[index].X_WM);
                to.translation.vector.norm() > STILL || to.rotation.coords.xyz().norm() > STILL
            })
        };
        let moving: Vec<usize> = (0..first.meshes.len()).filter(|&index| moves(index)).collect();
        if moving.is_empty() {
            return Ok(None);
        }
        let times: Vec<[f32; 1]> = moments.iter().map(|moment| [moment.time_s as f32]).collect();
        let input = self.floats(&times, true)?;
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        for index in moving {
            let poses = || moments.iter().map(|moment| &moment.meshes[index].X_WM);
            let translations: Vec<[f32; 3]> = poses().map(translation).collect();
            let mut rotations: Vec<[f32; 4]> = Vec::with_capacity(moments.len());
            for X in poses() {
                rotations.push(rotation(X, rotations.last().copied()));
            }
            let outputs =
                [("translation", self.floats(&translations, false)?), ("rotation", self.floats(&rotations, false)?)];
            for (path, output) in outputs {
                channels.push(json!({ "sampler": samplers.len(), "target": { "node": index, "path": path } }));
                samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
            }
        }
        Ok(Some(json!({ "name": "plan", "samplers": samplers, "channels": channels })))
    }
}

/// Header, JSON and binary chunk, each padded to four bytes.
fn container(root: &Value, bytes: &[u8]) -> Vec<u8> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut data = bytes.to_vec();
    data.resize(data.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + data.len();
    let mut file = Vec::with_capacity(length);
    let word = |file: &mut Vec<u8>, value: usize| file.extend((value as u32).to_le_bytes());
    file.extend(b"glTF");
    word(&mut file, 2);
    word(&mut file, length);
    word(&mut file, text.len());
    file.extend(b"JSON");
    file.extend(&text);
    word(&mut file, data.len());
    file.extend(b"BIN\0");
    file.extend(&data);
    file
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

    use super::*;

    fn triangle() -> Arc<Mesh> {
        Arc::new(Mesh {
            positions: vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 2.0, 0.0)],
            normals: vec![Vector3::z(); 3],
            triangles: vec![[0, 1, 2]],
        })
    }

    fn draw(mesh: &Arc<Mesh>, X_WM: Isometry3<f64>) -> MeshDraw {
        MeshDraw { mesh: mesh.clone(), X_WM, color: [0.5, 0.5, 0.5, 1.0], surface: Surface::Satin, pick_id: 0 }
    }

    /// The JSON chunk and the binary chunk, read as the format's specification lays them out.
    fn read(file: &[u8]) -> (Value, Vec<u8>) {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        let text = word(12);
        assert_eq!((&file[16..20], text % 4), (&b"JSON"[..], 0));
        let at = 20 + text;
        assert_eq!((&file[at + 4..at + 8], word(at) % 4, at + 8 + word(at)), (&b"BIN\0"[..], 0, file.len()));
        (serde_json::from_slice(&file[20..at]).expect("JSON"), file[at + 8..].to_vec())
    }

    fn floats(root: &Value, bytes: &[u8], accessor: &Value) -> Vec<f32> {
        let accessor = &root["accessors"][accessor.as_u64().expect("an index") as usize];
        let view = &root["bufferViews"][accessor["bufferView"].as_u64().expect("an index") as usize];
        let (begin, length) = (view["byteOffset"].as_u64().expect("a number"), view["byteLength"].as_u64());
        let slice = &bytes[begin as usize..(begin + length.expect("a number")) as usize];
        slice.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect()
    }

    #[test]
    fn a_body_that_moves_has_its_poses_over_time_and_one_that_stands_has_none() {
        let mesh = triangle();
        let turned = |k: f64| {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), k * 1.5);
            Isometry3::from_parts(Translation3::new(0.1 * k, 0.0, 0.0), turn)
        };
        let moment = |k: u32| Moment {
            time_s: 0.5 * f64::from(k),
            meshes: vec![draw(&mesh, Isometry3::identity()), draw(&mesh, turned(f64::from(k)))],
        };
        let (root, bytes) = read(&glb(&(0..5).map(moment).collect::<Vec<_>>()).expect("it can be written"));
        assert_eq!(root["meshes"].as_array().map(Vec::len), Some(1), "one geometry in one colour is one mesh");
        let animation = &root["animations"][0];
        let channels = animation["channels"].as_array().expect("channels");
        assert!(channels.len() == 2 && channels.iter().all(|channel| channel["target"]["node"] == 1));
        let sampler = &animation["samplers"][1];
        assert_eq!(floats(&root, &bytes, &sampler["input"]), [0.0, 0.5, 1.0, 1.5, 2.0]);
        let rotations = floats(&root, &bytes, &sampler["output"]);
        for pair in rotations.chunks_exact(4).collect::<Vec<_>>().windows(2) {
            let dot: f32 = pair[0].iter().zip(pair[1]).map(|(a, b)| a * b).sum();
            assert!((dot - 0.75_f32.cos()).abs() < 1e-6, "1.5 rad a step, never the long way round: {dot}");
        }
        let positions = &root["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
        assert_eq!(floats(&root, &bytes, positions), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
        assert_eq!(root["accessors"][positions.as_u64().expect("an index") as usize]["max"], json!([1.0, 2.0, 0.0]));
    }

    #[test]
    fn a_scene_has_its_clouds_as_points_and_its_paths_as_lines() {
        let cloud = PointsDraw {
            points: Arc::new(vec![Point3::new(1.0, 2.0, 3.0), Point3::new(-1.0, 0.0, 0.5)]),
            colors: Arc::new(vec![[255, 128, 0, 255]]),
            diameter_m: 0.002,
        };
        let line = |color: [f32; 4]| LineDraw::new(vec![Point3::origin(), Point3::new(0.0, 0.0, 1.0)], color, 2.0);
        let lines = vec![line([0.0, 0.0, 1.0, 1.0]), line([0.0, 0.0, 1.0, 0.5]), line([0.0, 0.0, 1.0, 1.0])];
        let meshes = vec![draw(&triangle(), Isometry3::identity())];
        let (root, bytes) =
            read(&glb_scene(&Frame { meshes, points: vec![cloud], lines, ..Frame::default() }).expect("a file"));
        let mode = |mesh: usize| root["meshes"][mesh]["primitives"][0]["mode"].as_u64();
        assert_eq!((0..5).map(mode).collect::<Vec<_>>(), [None, Some(0), Some(3), Some(3), Some(3)]);
        assert_eq!(root["nodes"].as_array().map(Vec::len), Some(6), "each has a node, and the world one");
        assert_eq!(root["nodes"][5]["children"], json!([0, 1, 2, 3, 4]));
        assert_eq!(root["materials"].as_array().map(Vec::len), Some(4), "equal lines share theirs");
        assert_eq!(root["extensionsUsed"], json!(["KHR_materials_unlit"]));
        let attributes = &root["meshes"][1]["primitives"][0]["attributes"];
        assert_eq!(floats(&root, &bytes, &attributes["POSITION"]), [1.0, 2.0, 3.0, -1.0, 0.0, 0.5]);
        let colors = floats(&root, &bytes, &attributes["COLOR_0"]);
        // Half of the display value is about a fifth of the light.
        assert!(colors.len() == 8 && (colors[5] - 0.216).abs() < 1e-3, "{colors:?}");
        assert!(glb_scene(&Frame::default()).is_err());
    }

    #[test]
    fn bodies_that_come_and_go_are_refused_and_nothing_is_no_file() {
        let mesh = triangle();
        let moments = [
            Moment { time_s: 0.0, meshes: vec![draw(&mesh, Isometry3::identity())] },
            Moment { time_s: 0.1, meshes: vec![draw(&triangle(), Isometry3::identity())] },
        ];
        assert!(glb(&moments).expect_err("another body").contains("0.10 s"));
        assert!(glb(&[]).is_err());
        let still = glb(&moments[..1]).expect("one moment alone");
        assert!(read(&still).0.get("animations").is_none());
    }
}
