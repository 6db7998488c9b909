//! Objects that people bring as meshes: welded, centred, in metres.

use std::collections::BTreeMap;

use super::ObjectError;
use super::household::{HouseholdObject, Part, bounds};
use crate::mesh::Mesh;

/// Colour of an object that nobody gave one, sRGB.
const COLOR: [u8; 3] = [196, 148, 92];
/// Mass of an object of which nothing is known, kilograms.
const MASS_KG: f64 = 0.3;

impl HouseholdObject {
    /// An object of a mesh: its corners welded, the centre of its bounding box at the origin.
    ///
    /// Its name in scenes is that of the file with a fingerprint of the shape, as in `bracket@5d20c4e1`.
    ///
    /// * `file`: name of the file.
    /// * `scale_m`: metres in one unit of the mesh.
    /// * `source`: where its size comes from, in words.
    ///
    /// # Errors
    /// [`ObjectError::Value`] when it is too large or too small to stand on a table.
    pub fn of_mesh(file: &str, mesh: &Mesh, scale_m: f64, source: &str) -> Result<Self, ObjectError> {
        let (least, most) = bounds(mesh);
        let centre = 0.5 * (least + most);
        let mut known: BTreeMap<[u32; 3], u32> = BTreeMap::new();
        let mut positions = Vec::new();
        let mut index = |p: &nalgebra::Point3<f64>| {
            let corner = <[f64; 3]>::from((p.coords - centre) * scale_m).map(|x| x as f32);
            // 0 and -0 are one place.
            *known.entry(corner.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                positions.push(corner);
                positions.len() as u32 - 1
            })
        };
        let welded: Vec<[u32; 3]> =
            mesh.triangles.iter().map(|t| t.map(|corner| index(&mesh.positions[corner as usize]))).collect();
        let triangles: Vec<[u32; 3]> = welded.into_iter().filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        // FNV-1a.
        let numbers = positions.iter().flatten().map(|x| x.to_bits()).chain(triangles.iter().flatten().copied());
        for byte in numbers.flat_map(u32::to_le_bytes) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
        let stem = file.rsplit('/').next().unwrap_or(file);
        let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
        let object = Self {
            name: format!("{stem}@{:08x}", (hash ^ (hash >> 32)) as u32),
            title: stem.replace('_', " "),
            source: source.to_owned(),
            mass_kg: MASS_KG,
            color: COLOR,
            parts: vec![Part::Mesh { positions, triangles }],
        };
        object.check()?;
        Ok(object)
    }

    /// Whether somebody brought it.
    pub fn is_brought(name: &str) -> bool {
        name.contains('@')
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::object::box_mesh;

    #[test]
    fn a_box_in_millimetres_comes_to_stand_about_its_middle() {
        let mut mesh = box_mesh(&Vector3::new(60.0, 80.0, 120.0));
        mesh.positions.iter_mut().for_each(|p| *p += Vector3::new(500.0, 0.0, 60.0));
        let object = HouseholdObject::of_mesh("cad/tall_box.STL", &mesh, 1e-3, "test").unwrap();
        assert!((object.half_extents() - Vector3::new(0.03, 0.04, 0.06)).norm() < 1e-6);
        assert!(object.name.starts_with("tall_box@") && HouseholdObject::is_brought(&object.name));
        let Part::Mesh { positions, triangles } = &object.parts[0] else { panic!("a mesh") };
        assert_eq!((positions.len(), triangles.len()), (8, 12), "24 corners of six faces are 8");
        // Closed and outwards: its volume is that of the box.
        let surface = object.mesh();
        let corner = |t: &[u32; 3], k: usize| surface.positions[t[k] as usize].coords;
        let volume: f64 =
            surface.triangles.iter().map(|t| corner(t, 0).dot(&corner(t, 1).cross(&corner(t, 2))) / 6.0).sum();
        assert!((volume - 0.06 * 0.08 * 0.12).abs() < 1e-9, "{volume}");
        let json = serde_json::to_string(&object).unwrap();
        assert_eq!(HouseholdObject::parse(&json).unwrap(), object);
    }

    #[test]
    fn what_does_not_fit_on_a_table_is_refused_with_its_size() {
        let mesh = box_mesh(&Vector3::new(60.0, 80.0, 120.0));
        let error = HouseholdObject::of_mesh("a.stl", &mesh, 1.0, "test").unwrap_err().to_string();
        assert!(error.contains("found 60.000 × 80.000 × 120.000 m, wanted edges of 5 mm to 2 m"), "{error}");
        let broken = r#"{"name": "a", "title": "A", "source": "", "mass_kg": 1, "color": [0, 0, 0],
            "parts": [{"kind": "mesh", "positions": [[0, 0, 0]], "triangles": [[0, 0, 7]]}]}"#;
        let error = HouseholdObject::parse(broken).unwrap_err().to_string();
        assert!(error.contains("part 0, triangles: found corner 7 of 1"), "{error}");
    }
}
