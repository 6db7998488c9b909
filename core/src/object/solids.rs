//! Plain bodies of a scene: boxes and slabs.

use nalgebra::{Point3, Vector3};

use crate::mesh::Mesh;

/// A box with these edge lengths, centred, with flat faces.
pub fn box_mesh(size_m: &Vector3<f64>) -> Mesh {
    let half = size_m / 2.0;
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = side;
            // The next two axes are right-handed with this one.
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = mesh.positions.len() as u32;
            for (along_u, along_v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = Vector3::zeros();
                corner[axis] = side * half[axis];
                corner[u] = along_u * half[u];
                corner[v] = along_v * half[v];
                mesh.positions.push(Point3::from(corner));
                mesh.normals.push(normal);
            }
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                mesh.triangles.push(if side > 0.0 {
                    [first + a, first + b, first + c]
                } else {
                    [first + a, first + c, first + b]
                });
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_point_outwards_and_enclose_the_volume() {
        let mesh = box_mesh(&Vector3::new(0.2, 0.3, 0.4));
        let mut volume = 0.0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(&(c - a)).dot(&mesh.normals[t[0] as usize]) > 0.0);
            volume += a.coords.dot(&b.coords.cross(&c.coords)) / 6.0;
        }
        assert!((volume - 0.024).abs() < 1e-12);
    }
}
