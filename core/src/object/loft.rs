//! The surface of a stack of superellipse sections.

use nalgebra::{Point3, Vector2, Vector3};

use crate::math;
use crate::mesh::Mesh;

/// Corners of a section.
const SEGMENTS: usize = 64;
/// Where the profile turns by more than this there is an edge, rad (30°).
const EDGE_RAD: f64 = 0.52;

/// Direction and normal of a section of unit semi-axes at each corner.
struct Corner {
    at: Vector2<f64>,
    /// Outward gradient of the superellipse, before division by the semi-axes.
    gradient: Vector2<f64>,
}

/// The closed surface of a loft; `sections` and `e2` are those of a checked [`Part`](super::Part).
///
/// Normals are shared along the profile where it is smooth; rows of vertices are doubled at edges and around the caps.
pub(super) fn loft_mesh(sections: &[[f64; 3]], e2: f64) -> Mesh {
    let corners: Vec<Corner> = (0..SEGMENTS)
        .map(|k| {
            let (sin, cos) = math::sin_cos(std::f64::consts::TAU * k as f64 / SEGMENTS as f64);
            // Right angles are exact, so that opposite corners have the same extent.
            let clean = |x: f64| if x.abs() < 1e-12 { 0.0 } else { x };
            let (sin, cos) = (clean(sin), clean(cos));
            Corner {
                at: Vector2::new(math::signed_powf(cos, e2), math::signed_powf(sin, e2)),
                gradient: Vector2::new(math::signed_powf(cos, 2.0 - e2), math::signed_powf(sin, 2.0 - e2)),
            }
        })
        .collect();
    let mut mesh = Mesh::default();
    let mut below: Option<Row> = None;
    for (k, pair) in sections.windows(2).enumerate() {
        let [bottom, top] = [pair[0], pair[1]];
        let here = slope(&bottom, &top);
        let previous = k.checked_sub(1).and_then(|k| sections.get(k)).map(|before| slope(before, &bottom));
        let next = sections.get(k + 2).map(|after| slope(&top, after));
        let start = match (below.take(), previous) {
            (Some(row), Some(previous)) if is_smooth(previous, here) => row,
            _ => Row::add(&mut mesh, &bottom, &corners, here),
        };
        let turned = next.filter(|next| is_smooth(here, *next)).map_or(here, |next| middle(here, next));
        let end = Row::add(&mut mesh, &top, &corners, turned);
        stitch(&mut mesh, start, end, is_tip(&bottom), is_tip(&top));
        below = Some(end);
    }
    if let (Some(bottom), Some(top)) = (sections.first(), sections.last()) {
        cap(&mut mesh, bottom, &corners, -Vector3::z());
        cap(&mut mesh, top, &corners, Vector3::z());
    }
    mesh
}

fn is_tip(section: &[f64; 3]) -> bool {
    section[1] == 0.0 && section[2] == 0.0
}

/// Direction of the profile between two sections: `[outward, up]`, of unit length, by the mean of the semi-axes.
fn slope(bottom: &[f64; 3], top: &[f64; 3]) -> Vector2<f64> {
    let outward = (top[1] + top[2] - bottom[1] - bottom[2]) / 2.0;
    Vector2::new(outward, top[0] - bottom[0]).try_normalize(1e-12).unwrap_or(Vector2::y())
}

fn is_smooth(a: Vector2<f64>, b: Vector2<f64>) -> bool {
    a.dot(&b) > math::cos(EDGE_RAD)
}

fn middle(a: Vector2<f64>, b: Vector2<f64>) -> Vector2<f64> {
    (a + b).try_normalize(1e-9).unwrap_or(a)
}

/// First vertex of a row of [`SEGMENTS`] vertices.
#[derive(Clone, Copy)]
struct Row(u32);

impl Row {
    fn add(mesh: &mut Mesh, section: &[f64; 3], corners: &[Corner], slope: Vector2<f64>) -> Self {
        let first = mesh.positions.len() as u32;
        let [z, a, b] = *section;
        // A tip has the normals of a small section of equal semi-axes.
        let (wide, deep) = if is_tip(section) { (1.0, 1.0) } else { (a, b) };
        for corner in corners {
            mesh.positions.push(Point3::new(a * corner.at.x, b * corner.at.y, z));
            let across = Vector2::new(corner.gradient.x / wide, corner.gradient.y / deep);
            let across = across.try_normalize(1e-12).unwrap_or(Vector2::x());
            mesh.normals.push(Vector3::new(across.x * slope.y, across.y * slope.y, -slope.x));
        }
        Self(first)
    }
}

/// Triangles between two rows, none of them without area.
fn stitch(mesh: &mut Mesh, below: Row, above: Row, tip_below: bool, tip_above: bool) {
    let count = SEGMENTS as u32;
    for k in 0..count {
        let next = (k + 1) % count;
        let [a, b, c, d] = [below.0 + k, below.0 + next, above.0 + next, above.0 + k];
        if !tip_below {
            mesh.triangles.push([a, b, c]);
        }
        if !tip_above {
            mesh.triangles.push([a, c, d]);
        }
    }
}

/// A flat fan over an end section.
fn cap(mesh: &mut Mesh, section: &[f64; 3], corners: &[Corner], normal: Vector3<f64>) {
    if is_tip(section) {
        return;
    }
    let [z, a, b] = *section;
    let centre = mesh.positions.len() as u32;
    mesh.positions.push(Point3::new(0.0, 0.0, z));
    mesh.positions.extend(corners.iter().map(|corner| Point3::new(a * corner.at.x, b * corner.at.y, z)));
    mesh.normals.extend((0..=corners.len()).map(|_| normal));
    let count = SEGMENTS as u32;
    for k in 0..count {
        let (here, next) = (centre + 1 + k, centre + 1 + (k + 1) % count);
        mesh.triangles.push(if normal.z > 0.0 { [centre, here, next] } else { [centre, next, here] });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn volume(mesh: &Mesh) -> f64 {
        (mesh.triangles.iter())
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize].coords);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }

    /// Every edge, by position, is passed once in each direction.
    fn assert_closed(mesh: &Mesh) {
        let name = |i: u32| mesh.positions[i as usize].coords.map(|x| (x * 1e9).round() as i64);
        let key = |i: u32| -> [i64; 3] { name(i).into() };
        let mut passes: BTreeMap<([i64; 3], [i64; 3]), i32> = BTreeMap::new();
        for t in &mesh.triangles {
            for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *passes.entry((key(p), key(q))).or_default() += 1;
            }
        }
        for ((p, q), count) in &passes {
            assert_eq!(*count, 1, "edge {p:?} {q:?}");
            assert!(passes.contains_key(&(*q, *p)), "edge {p:?} {q:?} has no partner");
        }
    }

    fn assert_normals_point_out(mesh: &Mesh) {
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let flat = (b - a).cross(&(c - a)).try_normalize(1e-15).unwrap();
            for i in t {
                let n = mesh.normals[*i as usize];
                assert!((n.norm() - 1.0).abs() < 1e-9);
                assert!(n.dot(&flat) > 0.5, "{n:?} on a face towards {flat:?}");
            }
        }
    }

    #[test]
    fn a_cylinder_is_closed_and_has_its_volume() {
        let mesh = loft_mesh(&[[-0.05, 0.03, 0.04], [0.0, 0.03, 0.04], [0.05, 0.03, 0.04]], 1.0);
        assert_closed(&mesh);
        assert_normals_point_out(&mesh);
        // A polygon of n corners has n/(2π) sin(2π/n) of the area of its circle: 0.9984 for 64.
        let exact = std::f64::consts::PI * 0.03 * 0.04 * 0.1;
        assert!((volume(&mesh) / exact - 0.9984).abs() < 1e-4);
        // Three rows are shared along the wall, and the caps have their own.
        assert_eq!(mesh.positions.len(), 3 * SEGMENTS + 2 * (SEGMENTS + 1));
    }

    #[test]
    fn a_ball_with_tips_is_closed_and_smooth() {
        let rings = 24;
        let sections: Vec<[f64; 3]> = (0..=rings)
            .map(|k| {
                let (sin, cos) = math::sin_cos(std::f64::consts::PI * f64::from(k) / f64::from(rings));
                let r = if k == 0 || k == rings { 0.0 } else { 0.03 * sin };
                [-0.03 * cos, r, r]
            })
            .collect();
        let mesh = loft_mesh(&sections, 1.0);
        assert_closed(&mesh);
        assert_normals_point_out(&mesh);
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 0.03f64.powi(3);
        assert!((volume(&mesh) / exact - 1.0).abs() < 0.02);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            // A ring is 7.5°; away from the tips the normal is radial to a fraction of it.
            assert!(p.z.abs() > 0.0299 || n.dot(&p.coords) / p.coords.norm() > 0.995);
        }
    }

    #[test]
    fn a_carton_is_nearly_a_box_and_its_shoulder_is_an_edge() {
        let mesh = loft_mesh(&[[-0.1, 0.04, 0.03], [0.1, 0.04, 0.03]], 0.1);
        assert_closed(&mesh);
        assert_normals_point_out(&mesh);
        let full = 0.08 * 0.06 * 0.2;
        assert!(volume(&mesh) > 0.97 * full && volume(&mesh) < full);
        let shouldered =
            loft_mesh(&[[-0.1, 0.04, 0.04], [0.0, 0.04, 0.04], [0.01, 0.02, 0.02], [0.1, 0.02, 0.02]], 1.0);
        assert_closed(&shouldered);
        assert_normals_point_out(&shouldered);
        // Both rings of the shoulder are doubled.
        assert_eq!(shouldered.positions.len(), 6 * SEGMENTS + 2 * (SEGMENTS + 1));
    }
}
