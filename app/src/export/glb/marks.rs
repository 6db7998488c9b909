//! Clouds and lines of a scene: meshes of points and of line strips, in their colours without light.

use serde_json::{Value, json};

use super::{File, linear};
use crate::render::{LineDraw, PointsDraw};

/// Modes of glTF's primitives.
const POINTS: u32 = 0;
const LINE_STRIP: u32 = 3;

/// Meshes and what they are made of, as they stand in the file.
#[derive(Default)]
pub(super) struct Marks {
    pub(super) meshes: Vec<Value>,
    pub(super) materials: Vec<Value>,
}

impl Marks {
    /// Writes clouds and lines; their materials are counted from `first_material`.
    pub(super) fn of(
        file: &mut File,
        clouds: &[PointsDraw],
        lines: &[LineDraw],
        first_material: usize,
    ) -> Result<Self, String> {
        let mut marks = Self::default();
        for cloud in clouds.iter().filter(|cloud| !cloud.points.is_empty() && !cloud.colors.is_empty()) {
            let places: Vec<[f32; 3]> = cloud.points.iter().map(|p| p.coords.map(|x| x as f32).into()).collect();
            // One colour for each point, or one for all.
            let last = cloud.colors.len() - 1;
            let colors: Vec<[f32; 4]> =
                (0..places.len()).map(|k| shade(cloud.colors[k.min(last)].map(|c| f32::from(c) / 255.0))).collect();
            let (places, colors) = (file.floats(&places, true)?, file.floats(&colors, false)?);
            let material = first_material + marks.material([1.0; 4]);
            marks.meshes.push(json!({ "primitives": [{
                "attributes": { "POSITION": places, "COLOR_0": colors },
                "material": material,
                "mode": POINTS,
            }] }));
        }
        for line in lines.iter().filter(|line| line.points.len() > 1) {
            let places: Vec<[f32; 3]> = line.points.iter().map(|p| p.coords.map(|x| x as f32).into()).collect();
            let places = file.floats(&places, true)?;
            let material = first_material + marks.material(shade(line.color));
            marks.meshes.push(json!({ "primitives": [{
                "attributes": { "POSITION": places },
                "material": material,
                "mode": LINE_STRIP,
            }] }));
        }
        Ok(marks)
    }

    /// The index of an unlit material of a linear colour.
    fn material(&mut self, color: [f32; 4]) -> usize {
        let mut material = json!({
            "pbrMetallicRoughness": { "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 1.0 },
            "extensions": { "KHR_materials_unlit": {} },
        });
        if color[3] < 1.0 {
            material["alphaMode"] = json!("BLEND");
        }
        super::index_of(&mut self.materials, material)
    }
}

/// Linear colour with its opacity.
fn shade([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    [linear(r), linear(g), linear(b), a]
}
