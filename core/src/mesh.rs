//! Triangle meshes as the rooms exchange them: positions, normals and triangles in metres.

use nalgebra::{Isometry3, Point3, Vector3};

/// A triangle mesh; `normals` has one unit vector per position, triangles are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertices in metres.
    pub positions: Vec<Point3<f64>>,
    /// Unit normals, one per vertex.
    pub normals: Vec<Vector3<f64>>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The same mesh in another frame: vertices `X · p`, normals `R · n`.
    pub fn transformed(&self, X: &Isometry3<f64>) -> Self {
        Self {
            positions: self.positions.iter().map(|p| X * p).collect(),
            normals: self.normals.iter().map(|n| X.rotation * n).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Appends another mesh, renumbering its triangles.
    pub fn append(&mut self, other: &Self) {
        let base = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }
}
