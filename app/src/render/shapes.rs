//! Simple meshes: what the robots' files, the scenes and the glyphs are put together from. All in metres.
//!
//! Solids of revolution stand on z; boxes and cylinders are centred at the origin, arrows and cones start there.
//! Make each mesh once and share its `Arc`: the renderer uploads once per `Arc`.

use std::{
    f64::consts::{FRAC_PI_2, PI, TAU},
    sync::Arc,
};

use endcomfort_core::{mesh::Mesh, robot::Geometry};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};

/// Facets around a full turn: at 48 the silhouette of a sphere leaves the circle by 0.2 % of the radius.
const FACETS: u32 = 48;

/// A vertex of a profile in the half plane x ≥ 0, with its normal there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileVertex {
    /// Distance from the axis.
    pub radius: f64,
    /// Height.
    pub z: f64,
    /// Radial and axial component of the normal; any length but 0.
    pub normal: [f64; 2],
}

impl ProfileVertex {
    fn new(radius: f64, z: f64, normal: [f64; 2]) -> Self {
        Self { radius, z, normal }
    }
}

/// A solid of revolution about z. The profile runs upwards on the outside; where an edge is sharp it has two vertices
/// at the same place with two normals.
pub fn revolve(profile: &[ProfileVertex], facets: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let rings = profile.len() as u32;
    for facet in 0..=facets {
        let (sin, cos) = (TAU * f64::from(facet) / f64::from(facets)).sin_cos();
        for vertex in profile {
            mesh.positions.push(Point3::new(vertex.radius * cos, vertex.radius * sin, vertex.z));
            let [radial, axial] = vertex.normal;
            mesh.normals.push(unit_or_z(Vector3::new(radial * cos, radial * sin, axial)));
        }
    }
    for facet in 0..facets {
        for ring in 1..rings {
            let (a, b) = (facet * rings + ring - 1, (facet + 1) * rings + ring - 1);
            let (below, above) = (profile[ring as usize - 1], profile[ring as usize]);
            if below.radius > 0.0 {
                mesh.triangles.push([a, b, b + 1]);
            }
            if above.radius > 0.0 {
                mesh.triangles.push([a, b + 1, a + 1]);
            }
        }
    }
    mesh
}

/// Vertices of a quarter or half circle about `(center_radius, center_z)`, angles from the horizontal.
fn arc(center_radius: f64, center_z: f64, radius: f64, from_rad: f64, to_rad: f64, steps: u32) -> Vec<ProfileVertex> {
    (0..=steps)
        .map(|step| {
            let (sin, cos) = (from_rad + (to_rad - from_rad) * f64::from(step) / f64::from(steps)).sin_cos();
            // A pole lies exactly on the axis.
            let distance = center_radius + if cos.abs() < 1e-12 { 0.0 } else { radius * cos };
            ProfileVertex::new(distance, center_z + radius * sin, [cos, sin])
        })
        .collect()
}

/// A sphere about the origin.
pub fn sphere(radius_m: f64) -> Mesh {
    revolve(&arc(0.0, 0.0, radius_m, -FRAC_PI_2, FRAC_PI_2, FACETS / 2), FACETS)
}

/// A sphere with few facets (168 triangles), for glyphs by the thousand.
pub fn bead(radius_m: f64) -> Mesh {
    revolve(&arc(0.0, 0.0, radius_m, -FRAC_PI_2, FRAC_PI_2, 8), 12)
}

/// A cylinder along z, centred.
pub fn cylinder(radius_m: f64, length_m: f64) -> Mesh {
    rounded_cylinder(radius_m, length_m, 0.0)
}

/// A cylinder along z, centred, whose rims are rounded by `rim_m` (at most the radius and half the length).
pub fn rounded_cylinder(radius_m: f64, length_m: f64, rim_m: f64) -> Mesh {
    let half = length_m / 2.0;
    let rim = rim_m.max(0.0).min(radius_m).min(half);
    let flat = radius_m - rim;
    let mut profile = vec![ProfileVertex::new(0.0, -half, [0.0, -1.0])];
    if rim > 0.0 {
        profile.extend(arc(flat, rim - half, rim, -FRAC_PI_2, 0.0, 6));
        profile.extend(arc(flat, half - rim, rim, 0.0, FRAC_PI_2, 6));
    } else {
        for (z, axial) in [(-half, -1.0), (half, 1.0)] {
            let mut edge = [ProfileVertex::new(radius_m, z, [0.0, axial]), ProfileVertex::new(radius_m, z, [1.0, 0.0])];
            if axial > 0.0 {
                edge.reverse();
            }
            profile.extend(edge);
        }
    }
    profile.push(ProfileVertex::new(0.0, half, [0.0, 1.0]));
    revolve(&profile, FACETS)
}

/// A capsule along z, centred; `length_m` is the length of its cylindrical part.
pub fn capsule(radius_m: f64, length_m: f64) -> Mesh {
    let half = length_m / 2.0;
    let mut profile = arc(0.0, -half, radius_m, -FRAC_PI_2, 0.0, FACETS / 4);
    profile.extend(arc(0.0, half, radius_m, 0.0, FRAC_PI_2, FACETS / 4));
    revolve(&profile, FACETS)
}

/// A cone with its base at z = 0 and its tip at z = `height_m`.
pub fn cone(radius_m: f64, height_m: f64) -> Mesh {
    revolve(&cone_profile(radius_m, 0.0, 0.0, height_m), FACETS / 2)
}

/// From the inner radius of the base out to its rim and up to the tip.
fn cone_profile(radius: f64, inner_radius: f64, base_z: f64, height: f64) -> Vec<ProfileVertex> {
    let slope = [height, radius];
    vec![
        ProfileVertex::new(inner_radius, base_z, [0.0, -1.0]),
        ProfileVertex::new(radius, base_z, [0.0, -1.0]),
        ProfileVertex::new(radius, base_z, slope),
        ProfileVertex::new(0.0, base_z + height, slope),
    ]
}

/// An arrow from the origin along z; its head is a third of it at most.
pub fn arrow(length_m: f64, radius_m: f64) -> Mesh {
    let head = (radius_m * 6.0).min(length_m / 3.0);
    let neck = length_m - head;
    let mut profile = vec![
        ProfileVertex::new(0.0, 0.0, [0.0, -1.0]),
        ProfileVertex::new(radius_m, 0.0, [0.0, -1.0]),
        ProfileVertex::new(radius_m, 0.0, [1.0, 0.0]),
        ProfileVertex::new(radius_m, neck, [1.0, 0.0]),
    ];
    profile.extend(cone_profile(radius_m * 2.2, radius_m, neck, head));
    revolve(&profile, FACETS / 2)
}

/// A ring (torus) about z.
pub fn ring(radius_m: f64, tube_radius_m: f64) -> Mesh {
    revolve(&arc(radius_m, 0.0, tube_radius_m, -PI, PI, 16), FACETS)
}

/// A box about the origin with these edge lengths.
pub fn cuboid(size_m: Vector3<f64>) -> Mesh {
    let mut mesh = Mesh::default();
    let half = size_m / 2.0;
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let base = mesh.positions.len() as u32;
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = Vector3::zeros();
                corner[axis] = sign;
                corner[(axis + 1) % 3] = u * sign;
                corner[(axis + 2) % 3] = v;
                mesh.positions.push(corner.component_mul(&half).into());
                mesh.normals.push(normal);
            }
            mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        }
    }
    mesh
}

/// A box about the origin with these edge lengths whose edges are rounded by `edge_m` (at most half the least length).
pub fn rounded_cuboid(size_m: Vector3<f64>, edge_m: f64) -> Mesh {
    let half = size_m / 2.0;
    if edge_m.is_nan() || edge_m <= 0.0 {
        return cuboid(size_m);
    }
    let edge = edge_m.min(half.min());
    /// Steps of each quarter turn.
    const STEPS: u32 = 6;
    let inner = half.add_scalar(-edge);
    let mut mesh = Mesh::default();
    // A sphere whose quarters are pulled apart to the corners; the gaps are the faces and edges.
    let angles = |quarters: [f64; 2]| {
        quarters
            .into_iter()
            .flat_map(|start| (0..=STEPS).map(move |k| start + FRAC_PI_2 * f64::from(k) / f64::from(STEPS)))
    };
    let latitudes: Vec<(f64, f64)> = angles([-FRAC_PI_2, 0.0]).zip([-1.0; 7].into_iter().chain([1.0; 7])).collect();
    let quarter_signs = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    for (quarter, (sign_x, sign_y)) in quarter_signs.into_iter().enumerate() {
        for k in 0..=STEPS {
            let (sin_lon, cos_lon) = (FRAC_PI_2 * (quarter as f64 + f64::from(k) / f64::from(STEPS))).sin_cos();
            for &(latitude, sign_z) in &latitudes {
                let (sin_lat, cos_lat) = latitude.sin_cos();
                let normal = Vector3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
                let corner = inner.component_mul(&Vector3::new(sign_x, sign_y, sign_z));
                mesh.positions.push((corner + normal * edge).into());
                mesh.normals.push(normal);
            }
        }
    }
    let (columns, rows) = (4 * (STEPS + 1), 2 * (STEPS + 1));
    for column in 0..columns {
        for row in 1..rows {
            let (a, b) = (column * rows + row - 1, (column + 1) % columns * rows + row - 1);
            mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    // The flat top and bottom, between the four poles of each.
    let pole = |quarter: u32, row: u32| quarter * (STEPS + 1) * rows + row;
    let top = [0, 1, 2, 3].map(|quarter| pole(quarter, rows - 1));
    let bottom = [3, 2, 1, 0].map(|quarter| pole(quarter, 0));
    for [a, b, c, d] in [top, bottom] {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// A round tube along a polyline, closed at its ends by flat discs. Vertices nearer than a nanometre to the one
/// before, or not finite, are left out; fewer than two make an empty mesh.
pub fn tube(path: &[Point3<f64>], radius_m: f64) -> Mesh {
    const SIDES: u32 = 16;
    let mut points: Vec<Point3<f64>> = Vec::with_capacity(path.len());
    for point in path.iter().filter(|p| p.coords.iter().all(|c| c.is_finite())) {
        if points.last().is_none_or(|last| (point - last).norm() > 1e-9) {
            points.push(*point);
        }
    }
    let mut mesh = Mesh::default();
    if points.len() < 2 {
        return mesh;
    }
    let tangents: Vec<Vector3<f64>> = points.windows(2).map(|pair| unit_or_z(pair[1] - pair[0])).collect();
    // A side vector carried along without twist (rotation-minimising by the turn between tangents).
    let mut side = perpendicular(&tangents[0]);
    let mut rings: Vec<(Point3<f64>, Vector3<f64>, Vector3<f64>)> = Vec::with_capacity(points.len());
    for (idx, point) in points.iter().enumerate() {
        let before = tangents[idx.max(1) - 1];
        let after = tangents[idx.min(tangents.len() - 1)];
        let tangent = Unit::try_new(before + after, 1e-9).map_or(after, Unit::into_inner);
        if let Some((last_tangent, last_side)) = rings.last().map(|ring| (ring.1, ring.2)) {
            let turn = UnitQuaternion::rotation_between(&last_tangent, &tangent).unwrap_or_default();
            side = turn * last_side;
        }
        rings.push((*point, tangent, side));
    }
    for (point, tangent, side) in &rings {
        let across = tangent.cross(side);
        for k in 0..=SIDES {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
            let normal = side * cos + across * sin;
            mesh.positions.push(point + normal * radius_m);
            mesh.normals.push(normal);
        }
    }
    let around = SIDES + 1;
    for ring in 1..rings.len() as u32 {
        for k in 0..SIDES {
            let (a, b) = ((ring - 1) * around + k, ring * around + k);
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    for (ring, outward) in [(0, -1.0), (rings.len() as u32 - 1, 1.0)] {
        let (center, tangent, _) = rings[ring as usize];
        let base = mesh.positions.len() as u32;
        mesh.positions.push(center);
        mesh.normals.push(tangent * outward);
        for k in 0..around {
            mesh.positions.push(mesh.positions[(ring * around + k) as usize]);
            mesh.normals.push(tangent * outward);
        }
        for k in 0..SIDES {
            let (b, c) = (base + 1 + k, base + 2 + k);
            mesh.triangles.push(if outward > 0.0 { [base, b, c] } else { [base, c, b] });
        }
    }
    mesh
}

/// A horizontal square of `cells` × `cells` squares at z = 0 about the origin, facing up.
pub fn grid_plane(size_m: f64, cells: u32) -> Mesh {
    let cells = cells.max(1);
    let at = |k: u32| size_m * (f64::from(k) / f64::from(cells) - 0.5);
    let mut mesh = Mesh::default();
    for row in 0..=cells {
        for column in 0..=cells {
            mesh.positions.push(Point3::new(at(column), at(row), 0.0));
            mesh.normals.push(Vector3::z());
        }
    }
    for row in 0..cells {
        for column in 0..cells {
            let a = row * (cells + 1) + column;
            let b = a + cells + 1;
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    mesh
}

/// The mesh of a robot's body, in the body's frame. Call it once per body and keep the result.
pub fn geometry_mesh(geometry: &Geometry) -> Arc<Mesh> {
    match geometry {
        Geometry::Mesh { mesh, .. } => Arc::clone(mesh),
        Geometry::Box { size_m } => Arc::new(cuboid(*size_m)),
        Geometry::Cylinder { radius_m, length_m } => Arc::new(cylinder(*radius_m, *length_m)),
        Geometry::Sphere { radius_m } => Arc::new(sphere(*radius_m)),
        Geometry::Capsule { radius_m, length_m } => Arc::new(capsule(*radius_m, *length_m)),
    }
}

fn unit_or_z(vector: Vector3<f64>) -> Vector3<f64> {
    Unit::try_new(vector, 0.0).map_or(Vector3::z(), Unit::into_inner)
}

/// Some unit vector at right angles to a unit vector.
fn perpendicular(unit: &Vector3<f64>) -> Vector3<f64> {
    let axis = if unit.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    unit_or_z(axis - unit * unit.dot(&axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume by the divergence theorem: positive only if triangles are counter-clockwise seen from outside.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |i: u32| mesh.positions[i as usize].coords;
        mesh.triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
    }

    fn check(name: &str, mesh: &Mesh, expected_volume: f64) {
        assert_eq!(mesh.positions.len(), mesh.normals.len(), "{name}");
        assert!(mesh.normals.iter().all(|n| (n.norm() - 1.0).abs() < 1e-9), "{name}: unit normals");
        let volume = volume(mesh);
        // Facets cut off up to 5 % on the coarsest rounding (16 sides of a tube).
        assert!((volume / expected_volume - 1.0).abs() < 0.05, "{name}: volume {volume}, expected {expected_volume}");
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let face = (b - a).cross(&(c - a));
            let mean: Vector3<f64> = triangle.iter().map(|&i| mesh.normals[i as usize]).sum();
            assert!(face.dot(&mean) >= -1e-12, "{name}: triangle {triangle:?} faces against its normals");
        }
    }

    #[test]
    fn solids_are_closed_outward_and_of_the_right_volume() {
        let (r, l) = (0.1, 0.4);
        check("sphere", &sphere(r), 4.0 / 3.0 * PI * r * r * r);
        check("cylinder", &cylinder(r, l), PI * r * r * l);
        check("capsule", &capsule(r, l), PI * r * r * l + 4.0 / 3.0 * PI * r * r * r);
        check("cone", &cone(r, l), PI * r * r * l / 3.0);
        check("ring", &ring(0.3, 0.02), 2.0 * PI * PI * 0.3 * 0.02 * 0.02);
        check("cuboid", &cuboid(Vector3::new(0.1, 0.2, 0.3)), 0.006);
        let tube_path =
            [Point3::origin(), Point3::new(0.0, 0.0, 0.3), Point3::new(0.0, 0.0, 0.3), Point3::new(0.0, 0.0, 1.0)];
        check("tube", &tube(&tube_path, 0.01), PI * 1e-4);
        let (edge, size) = (0.02_f64, Vector3::new(0.1, 0.2, 0.3));
        let inner = size.add_scalar(-2.0 * edge);
        let rounded = inner.product()
            + 2.0 * edge * (inner.x * inner.y + inner.y * inner.z + inner.z * inner.x)
            + PI * edge * edge * inner.sum()
            + 4.0 / 3.0 * PI * edge.powi(3);
        check("rounded cuboid", &rounded_cuboid(size, edge), rounded);
        let shaft = PI * r * r * 0.0001;
        let head = PI * (0.022_f64).powi(2) * 0.06 / 3.0;
        check("arrow", &arrow(0.4, 0.01), shaft / r / r * 0.34 + head);
        check("rounded cylinder", &rounded_cylinder(r, l, 0.001), PI * r * r * l);
    }

    #[test]
    fn odd_arguments_make_no_panic() {
        assert!(tube(&[], 0.1).triangles.is_empty());
        assert!(tube(&[Point3::origin(), Point3::new(f64::NAN, 0.0, 0.0)], 0.1).triangles.is_empty());
        assert_eq!(rounded_cuboid(Vector3::repeat(0.1), f64::NAN).triangles.len(), 12);
        assert_eq!(rounded_cuboid(Vector3::repeat(0.1), 9.0).positions.len(), 4 * 7 * 14);
        assert_eq!(grid_plane(1.0, 0).triangles.len(), 2);
    }

    #[test]
    fn a_tube_that_turns_back_stays_finite() {
        let path = [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.5, 0.0, 0.0)];
        assert!(tube(&path, 0.1).positions.iter().all(|p| p.coords.iter().all(|c| c.is_finite())));
    }
}
