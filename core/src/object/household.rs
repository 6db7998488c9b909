//! The description of an object.

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::ObjectError;
use super::loft::loft_mesh;
use crate::mesh::Mesh;
use crate::mesh_file::{MAX_TRIANGLES, area_weighted_normals};

/// More parts than any bundled object needs.
const MAX_PARTS: usize = 64;
/// More sections than any bundled part needs.
const MAX_SECTIONS: usize = 256;
/// Nothing on a table is larger than this, metres.
const MAX_SIZE_M: f64 = 2.0;
/// Nothing thinner than this is seen or held, metres.
const MIN_SIZE_M: f64 = 0.005;
/// How far the origin may be from the centre of the bounding box, metres: sizes are written to a tenth of a millimetre.
const MAX_OFF_CENTRE_M: f64 = 2e-4;

/// A household object in its own frame O: z up as it usually stands, origin at the centre of its bounding box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HouseholdObject {
    /// File name without extension: `mustard_bottle`.
    pub name: String,
    /// What a person reads: `Mustard bottle`.
    pub title: String,
    /// Where the sizes come from: `YCB 006, published 50 × 85 × 175 mm`.
    pub source: String,
    /// Mass in kilograms.
    pub mass_kg: f64,
    /// sRGB colour.
    pub color: [u8; 3],
    /// Its solid parts.
    pub parts: Vec<Part>,
}

/// One solid part of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Part {
    /// Superellipse sections stacked along z: bottles, cans, boxes, fruit, glasses. The ends are closed by flat caps.
    Loft {
        /// Sections from bottom to top: `[z, semi-axis along x, semi-axis along y]` in metres. The first and the last may
        /// have no extent: a tip.
        sections: Vec<[f64; 3]>,
        /// Exponent of every section: 1 ellipse, towards 0 rectangle.
        e2: f64,
        /// Pose of the part in O.
        #[serde(default = "Isometry3::identity")]
        X_OP: Isometry3<f64>,
    },
    /// A closed surface that somebody brought, in O, metres.
    Mesh {
        /// Corners.
        positions: Vec<[f32; 3]>,
        /// Corners of each triangle, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
}

impl HouseholdObject {
    /// Reads and checks a description.
    ///
    /// # Errors
    /// [`ObjectError::Json`] for text that is not a description, [`ObjectError::Value`] for one that is no solid: a number
    /// that is not finite or outside its limits, sections that do not ascend, an origin off the centre.
    pub fn parse(json: &str) -> Result<Self, ObjectError> {
        let object: Self = serde_json::from_str(json).map_err(|error| ObjectError::Json {
            line: error.line(),
            column: error.column(),
            message: error.to_string(),
        })?;
        object.check()?;
        Ok(object)
    }

    /// The surface in O: closed parts, smooth where the profile is smooth, sharp at caps and edges.
    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        for part in &self.parts {
            match part {
                Part::Loft { sections, e2, X_OP } => mesh.append(&loft_mesh(sections, *e2).transformed(X_OP)),
                Part::Mesh { positions, triangles } => mesh.append(&surface(positions, triangles)),
            }
        }
        mesh
    }

    /// Half the extents of the bounding box, which is centred on the origin, metres.
    pub fn half_extents(&self) -> Vector3<f64> {
        let (least, most) = bounds(&self.mesh());
        (most - least) / 2.0
    }

    pub(super) fn check(&self) -> Result<(), ObjectError> {
        let wrong = |place: String, found: String, wanted: &str| {
            Err(ObjectError::Value { object: self.name.clone(), place, found, wanted: wanted.to_owned() })
        };
        if !(self.mass_kg > 0.0 && self.mass_kg <= 100.0) {
            return wrong(String::from("mass_kg"), self.mass_kg.to_string(), "more than 0, at most 100");
        }
        if self.parts.is_empty() || self.parts.len() > MAX_PARTS {
            return wrong(String::from("parts"), self.parts.len().to_string(), "1 to 64");
        }
        for (number, part) in self.parts.iter().enumerate() {
            let (sections, e2, X_OP) = match part {
                Part::Loft { sections, e2, X_OP } => (sections, e2, X_OP),
                Part::Mesh { positions, triangles } => {
                    self.check_surface(number, positions, triangles)?;
                    continue;
                }
            };
            let place = |thing: &str| format!("part {number}, {thing}");
            if sections.len() < 2 || sections.len() > MAX_SECTIONS {
                return wrong(place("sections"), sections.len().to_string(), "2 to 256");
            }
            if !(0.05..=2.0).contains(e2) {
                return wrong(place("e2"), e2.to_string(), "0.05 to 2");
            }
            let turn = X_OP.rotation.coords.norm();
            let shift = X_OP.translation.vector.amax();
            // NaN fails both.
            if !((turn - 1.0).abs() < 1e-3 && shift <= MAX_SIZE_M) {
                return wrong(place("X_OP"), format!("{X_OP}"), "a unit quaternion, and a shift of at most 2 m");
            }
            for (row, [z, x, y]) in sections.iter().enumerate() {
                let is_end = row == 0 || row + 1 == sections.len();
                let is_tip = is_end && *x == 0.0 && *y == 0.0;
                let least = x.min(*y);
                if !(z.abs() <= MAX_SIZE_M && x.max(*y) <= MAX_SIZE_M && (least >= 1e-5 || is_tip)) {
                    let wanted = "z within 2 m, semi-axes of 0.01 mm to 2 m, or both 0 at an end";
                    return wrong(place(&format!("section {row}")), format!("[{z}, {x}, {y}]"), wanted);
                }
            }
            if let Some(row) =
                sections.windows(2).position(|pair| pair[1][0].partial_cmp(&pair[0][0]).is_none_or(|o| o.is_lt()))
            {
                return wrong(
                    place(&format!("section {}", row + 1)),
                    String::from("z below the section before"),
                    "ascending z",
                );
            }
            let height = sections.last().map_or(0.0, |top| top[0]) - sections.first().map_or(0.0, |bottom| bottom[0]);
            if height <= 0.0 {
                return wrong(place("sections"), String::from("no height"), "ascending z");
            }
        }
        let (least, most) = bounds(&self.mesh());
        let edges = most - least;
        if edges.max() > MAX_SIZE_M || edges.min() < MIN_SIZE_M {
            let found = format!("{:.3} × {:.3} × {:.3} m", edges.x, edges.y, edges.z);
            return wrong(String::from("bounding box"), found, "edges of 5 mm to 2 m");
        }
        let centre = (least + most) / 2.0;
        if centre.amax() > MAX_OFF_CENTRE_M {
            let found = format!("its centre at ({:.4}, {:.4}, {:.4})", centre.x, centre.y, centre.z);
            return wrong(String::from("bounding box"), found, "its centre at the origin, to 0.2 mm");
        }
        Ok(())
    }
}

impl HouseholdObject {
    fn check_surface(&self, part: usize, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<(), ObjectError> {
        let wrong = |place: &str, found: String, wanted: String| ObjectError::Value {
            object: self.name.clone(),
            place: format!("part {part}, {place}"),
            found,
            wanted,
        };
        let count = triangles.len();
        if count == 0 || count > MAX_TRIANGLES {
            return Err(wrong("triangles", count.to_string(), format!("1 to {MAX_TRIANGLES}")));
        }
        if let Some(corner) = triangles.iter().flatten().find(|&&corner| corner as usize >= positions.len()) {
            let found = format!("corner {corner} of {}", positions.len());
            return Err(wrong("triangles", found, "corners that exist".to_owned()));
        }
        if let Some(position) = positions.iter().find(|p| !p.iter().all(|x| f64::from(x.abs()) < 1e3 * MAX_SIZE_M)) {
            return Err(wrong("positions", format!("{position:?}"), "coordinates within 2 m".to_owned()));
        }
        Ok(())
    }
}

/// A mesh with its normals.
fn surface(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    let positions = positions.iter().map(|p| Point3::from(p.map(f64::from))).collect();
    let mut mesh = Mesh { positions, normals: Vec::new(), triangles: triangles.to_vec() };
    mesh.normals = area_weighted_normals(&mesh);
    mesh
}

/// Least and greatest coordinates; both zero for an empty mesh.
pub(super) fn bounds(mesh: &Mesh) -> (Vector3<f64>, Vector3<f64>) {
    let first = mesh.positions.first().map_or(Vector3::zeros(), |p| p.coords);
    mesh.positions.iter().fold((first, first), |(least, most), p| (least.inf(&p.coords), most.sup(&p.coords)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAN: &str = r#"{"name": "can", "title": "Can", "source": "test", "mass_kg": 0.3, "color": [200, 0, 0],
        "parts": [{"kind": "loft", "e2": 1.0, "sections": [[-0.05, 0.03, 0.03], [0.05, 0.03, 0.03]]}]}"#;

    #[test]
    fn a_description_is_read_written_and_read_again() {
        let can = HouseholdObject::parse(CAN).unwrap();
        let again = HouseholdObject::parse(&serde_json::to_string(&can).unwrap()).unwrap();
        assert_eq!(can, again);
        assert!((can.half_extents() - Vector3::new(0.03, 0.03, 0.05)).norm() < 1e-9);
    }

    #[test]
    fn what_is_no_solid_is_refused_by_name_and_place() {
        for (from, to, expected) in [
            ("0.3,", "-1,", "mass_kg: found -1"),
            ("1.0,", "0.01,", "part 0, e2: found 0.01"),
            ("[0.05, 0.03, 0.03]", "[-0.06, 0.03, 0.03]", "part 0, section 1"),
            ("[0.05, 0.03, 0.03]", "[0.05, -0.03, 0.03]", "part 0, section 1: found [0.05, -0.03, 0.03]"),
            ("[0.05, 0.03, 0.03]", "[0.07, 0.03, 0.03]", "bounding box"),
            ("[0.05, 0.03, 0.03]", "[-0.05, 0.03, 0.03]", "no height"),
            (", [0.05, 0.03, 0.03]", "", "part 0, sections: found 1"),
            ("[200, 0, 0]", "[300, 0, 0]", "line 1, column"),
        ] {
            let text = CAN.replace(from, to);
            assert_ne!(text, CAN, "{from}");
            let message = HouseholdObject::parse(&text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
    }
}
