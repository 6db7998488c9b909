//! Metres or millimetres: what a mesh file does not say.

use serde::{Deserialize, Serialize};

use crate::mesh::Mesh;

/// Nothing that stands on a table is longer than this, metres.
const LONGEST_M: f64 = 2.0;

/// The unit of a mesh file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshUnit {
    /// Metres.
    Metres,
    /// Centimetres.
    Centimetres,
    /// Millimetres.
    Millimetres,
}

impl MeshUnit {
    /// All of them, the largest first.
    pub const ALL: [Self; 3] = [Self::Metres, Self::Centimetres, Self::Millimetres];

    /// Metres in one of it.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metres => 1.0,
            Self::Centimetres => 1e-2,
            Self::Millimetres => 1e-3,
        }
    }

    /// As it is written behind a number.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metres => "m",
            Self::Centimetres => "cm",
            Self::Millimetres => "mm",
        }
    }
}

/// The unit that makes the mesh a thing on a table, and why: metres unless it would be longer than 2 m.
///
/// glTF is in metres by its definition, whatever its size.
pub fn guess_unit(name: &str, mesh: &Mesh) -> (MeshUnit, String) {
    let extent = |axis: usize| {
        let values = || mesh.positions.iter().map(|p| p[axis]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let longest = (0..3).map(extent).fold(0.0, f64::max);
    if name.to_ascii_lowercase().ends_with(".glb") {
        return (MeshUnit::Metres, "glTF is in metres".to_owned());
    }
    if longest > LONGEST_M {
        let reason = format!("its longest edge would be {longest:.4} m, so it is taken to be in millimetres");
        return (MeshUnit::Millimetres, reason);
    }
    (MeshUnit::Metres, format!("its longest edge is {longest:.3} m, so it is taken to be in metres"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::box_mesh;
    use nalgebra::Vector3;

    #[test]
    fn what_would_be_larger_than_a_table_is_in_millimetres() {
        let of = |name: &str, edge: f64| guess_unit(name, &box_mesh(&Vector3::new(edge, 0.5 * edge, 0.1 * edge)));
        assert_eq!(of("a.stl", 120.0).0, MeshUnit::Millimetres);
        assert_eq!(of("a.stl", 0.12).0, MeshUnit::Metres);
        assert!(of("a.stl", 120.0).1.contains("120.0000 m"));
        assert_eq!(of("a.glb", 120.0).0, MeshUnit::Metres);
    }
}
