//! What is under the cursor: a ray against the triangles of the draw list, on the CPU, in f64.

use nalgebra::{Point3, Unit, Vector3};

use super::{BoundsCache, Cut, Frame, MeshDraw, Ray, bounds::is_finite};

/// Opacity from which a body hides what is behind it.
const OPAQUE: f32 = 0.999;

/// The nearest surface along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// [`MeshDraw::pick_id`] of the body; 0 if it means nothing (a table, say), which is still a point to turn about.
    pub pick_id: u32,
    /// Which of [`Frame::bodies`].
    pub draw_idx: usize,
    /// Where, in the world.
    pub point: Point3<f64>,
    /// Unit normal of the triangle in the world, towards the ray's origin.
    pub normal: Vector3<f64>,
    /// Distance from the origin of the ray in metres.
    pub distance_m: f64,
}

/// The nearest body that the ray meets, from either side. See-through bodies that mean nothing (`pick_id` 0) are
/// passed through. For repeated questions keep a [`Picker`].
pub fn pick(frame: &Frame, origin: Point3<f64>, direction: Unit<Vector3<f64>>) -> Option<Hit> {
    Picker::default().pick(frame, Ray { origin, direction }, None)
}

/// Picks and remembers the bounding spheres of the meshes between questions.
#[derive(Default)]
pub struct Picker {
    bounds: BoundsCache,
}

impl Picker {
    /// As [`pick`]; with a cut, of what it leaves.
    pub fn pick(&mut self, frame: &Frame, ray: Ray, cut: Option<Cut>) -> Option<Hit> {
        self.bounds.drop_unused();
        let mut nearest: Option<Hit> = None;
        for (draw_idx, draw) in frame.bodies().enumerate() {
            let opacity = draw.color[3];
            if opacity <= 0.0 || (draw.pick_id == 0 && opacity < OPAQUE) || !is_finite(&draw.X_WM) {
                continue;
            }
            let limit = nearest.map_or(f64::INFINITY, |hit| hit.distance_m);
            if let Some(hit) = self.meet(draw, draw_idx, &ray, limit, cut) {
                nearest = Some(hit);
            }
        }
        nearest
    }

    /// Meets one body nearer than `limit`.
    fn meet(&mut self, draw: &MeshDraw, draw_idx: usize, ray: &Ray, limit: f64, cut: Option<Cut>) -> Option<Hit> {
        let sphere = self.bounds.sphere(&draw.mesh)?;
        let origin = draw.X_WM.inverse_transform_point(&ray.origin);
        let direction = draw.X_WM.inverse_transform_vector(&ray.direction);
        let to_center = sphere.center - origin;
        let along = to_center.dot(&direction);
        let off_axis = (to_center - direction * along).norm();
        if !(off_axis <= sphere.radius && along + sphere.radius >= 0.0 && along - sphere.radius <= limit) {
            return None;
        }
        let mut best: Option<(f64, Vector3<f64>)> = None;
        for triangle in &draw.mesh.triangles {
            let [Some(a), Some(b), Some(c)] = triangle.map(|i| draw.mesh.positions.get(i as usize)) else { continue };
            if let Some((t, normal)) = meet_triangle(&origin, &direction, a, b, c)
                && t < best.map_or(limit, |(nearest, _)| nearest)
                && cut.is_none_or(|cut| cut.keeps(&ray.at(t)))
            {
                best = Some((t, normal));
            }
        }
        let (distance_m, normal) = best?;
        let normal = Unit::try_new(draw.X_WM * normal, 0.0)?.into_inner();
        Some(Hit {
            pick_id: draw.pick_id,
            draw_idx,
            point: ray.origin + *ray.direction * distance_m,
            normal,
            distance_m,
        })
    }
}

/// Möller and Trumbore (1997): distance along the ray and the normal (not of unit length) towards its origin.
fn meet_triangle(
    origin: &Point3<f64>,
    direction: &Vector3<f64>,
    a: &Point3<f64>,
    b: &Point3<f64>,
    c: &Point3<f64>,
) -> Option<(f64, Vector3<f64>)> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(&ac);
    let det = ab.dot(&across);
    if det == 0.0 {
        return None;
    }
    let from_a = origin - a;
    let u = from_a.dot(&across) / det;
    let upward = from_a.cross(&ab);
    let v = direction.dot(&upward) / det;
    let t = ac.dot(&upward) / det;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0;
    let normal = ab.cross(&ac);
    inside.then(|| (t, if normal.dot(direction) > 0.0 { -normal } else { normal }))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Isometry3;

    use super::*;
    use crate::render::{Surface, shapes};

    fn ball(x: f64, pick_id: u32, opacity: f32) -> MeshDraw {
        MeshDraw {
            mesh: Arc::new(shapes::sphere(0.1)),
            X_WM: Isometry3::translation(x, 0.0, 0.0),
            color: [1.0, 1.0, 1.0, opacity],
            surface: Surface::Satin,
            pick_id,
        }
    }

    fn along_x(frame: &Frame) -> Option<Hit> {
        pick(frame, Point3::new(-5.0, 0.001, 0.002), Vector3::x_axis())
    }

    #[test]
    fn the_nearest_body_is_hit_where_its_surface_is() {
        let frame = Frame { meshes: vec![ball(2.0, 7, 1.0), ball(1.0, 8, 1.0)], ..Frame::default() };
        let hit = along_x(&frame).unwrap();
        assert_eq!((hit.pick_id, hit.draw_idx), (8, 1));
        // The sphere is a polyhedron: its surface is less than 1 % of the radius inside the sphere.
        assert!((hit.point.x - 0.9).abs() < 1e-3, "hit at {}", hit.point);
        assert!((hit.distance_m - 5.9).abs() < 1e-3);
        assert!(hit.normal.x < -0.98);
    }

    #[test]
    fn see_through_bodies_that_mean_nothing_are_passed() {
        let frame = Frame { meshes: vec![ball(1.0, 0, 0.4), ball(2.0, 7, 0.4)], ..Frame::default() };
        assert_eq!(along_x(&frame).unwrap().pick_id, 7);
        let table = Frame { meshes: vec![ball(1.0, 0, 1.0), ball(2.0, 7, 1.0)], ..Frame::default() };
        assert_eq!(along_x(&table).unwrap().pick_id, 0);
    }

    #[test]
    fn broken_meshes_and_bodies_behind_are_no_hits() {
        let mut broken = ball(1.0, 3, 1.0);
        let mut mesh = (*broken.mesh).clone();
        mesh.triangles = vec![[0, 1, 9_999_999], [0, 0, 0]];
        broken.mesh = Arc::new(mesh);
        let frame = Frame { meshes: vec![broken, ball(-9.0, 4, 1.0)], ..Frame::default() };
        assert_eq!(along_x(&frame), None);
    }
}
