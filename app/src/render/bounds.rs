//! Bounding spheres, remembered per mesh.

use std::{
    collections::BTreeMap,
    sync::{Arc, Weak},
};

use endcomfort_core::mesh::Mesh;
use nalgebra::{Isometry3, Point3};

use super::Frame;

/// A sphere around a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, in the frame of the mesh.
    pub center: Point3<f64>,
    /// Radius in metres.
    pub radius: f64,
}

impl Sphere {
    /// The sphere about the middle of the bounding box; `None` without a finite vertex.
    fn around(mesh: &Mesh) -> Option<Self> {
        let mut bounds: Option<Bounds> = None;
        for point in mesh.positions.iter().filter(|p| p.coords.iter().all(|c| c.is_finite())) {
            Bounds::extend(&mut bounds, point);
        }
        let center = bounds?.center();
        let radius = mesh.positions.iter().map(|p| (p - center).norm()).filter(|r| r.is_finite()).fold(0.0, f64::max);
        Some(Self { center, radius })
    }
}

/// An axis-aligned box in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates in metres.
    pub min: Point3<f64>,
    /// Largest coordinates in metres.
    pub max: Point3<f64>,
}

impl Bounds {
    /// The middle.
    pub fn center(&self) -> Point3<f64> {
        nalgebra::center(&self.min, &self.max)
    }

    /// The eight corners.
    pub fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|k| {
            let at = |axis: usize| if k >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            Point3::new(at(0), at(1), at(2))
        })
    }

    /// Half of the diagonal, in metres.
    pub fn radius(&self) -> f64 {
        (self.max - self.min).norm() / 2.0
    }

    fn extend(bounds: &mut Option<Self>, point: &Point3<f64>) {
        *bounds = Some(match *bounds {
            None => Self { min: *point, max: *point },
            Some(Self { min, max }) => Self { min: min.inf(point), max: max.sup(point) },
        });
    }

    /// The box around everything that a frame shows; `None` if it shows nothing.
    pub fn of_frame(frame: &Frame, cache: &mut BoundsCache) -> Option<Self> {
        let mut bounds = None;
        for draw in frame.bodies() {
            if let Some(sphere) = cache.sphere(&draw.mesh) {
                let center = draw.X_WM * sphere.center;
                if center.coords.iter().all(|c| c.is_finite()) {
                    for sign in [-1.0, 1.0] {
                        Self::extend(&mut bounds, &center.coords.map(|c| c + sign * sphere.radius).into());
                    }
                }
            }
        }
        let points = frame.points.iter().flat_map(|draw| draw.points.iter());
        let vertices = frame.lines.iter().flat_map(|draw| draw.points.iter());
        for point in points.chain(vertices).filter(|p| p.coords.iter().all(|c| c.is_finite())) {
            Self::extend(&mut bounds, point);
        }
        bounds
    }
}

/// Spheres of the meshes seen so far. An entry lives as long as its mesh is used somewhere.
#[derive(Default)]
pub struct BoundsCache {
    /// By address; the weak reference keeps the address from being given to another mesh.
    entries: BTreeMap<usize, (Weak<Mesh>, Option<Sphere>)>,
}

impl BoundsCache {
    /// The bounding sphere of a mesh in its own frame; `None` if it is empty.
    pub fn sphere(&mut self, mesh: &Arc<Mesh>) -> Option<Sphere> {
        let key = Arc::as_ptr(mesh) as usize;
        self.entries.entry(key).or_insert_with(|| (Arc::downgrade(mesh), Sphere::around(mesh))).1
    }

    /// Forgets the meshes that nobody holds any more.
    pub fn drop_unused(&mut self) {
        self.entries.retain(|_, (mesh, _)| mesh.strong_count() > 0);
    }
}

/// Whether a pose has only finite numbers.
pub(super) fn is_finite(pose: &Isometry3<f64>) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{MeshDraw, Surface, shapes};

    #[test]
    fn the_sphere_holds_every_vertex_and_dies_with_its_mesh() {
        let mesh = Arc::new(shapes::cylinder(0.2, 1.0));
        let mut cache = BoundsCache::default();
        let sphere = cache.sphere(&mesh).unwrap();
        assert!(mesh.positions.iter().all(|p| (p - sphere.center).norm() <= sphere.radius + 1e-12));
        assert!((sphere.radius - (0.2_f64.powi(2) + 0.5_f64.powi(2)).sqrt()).abs() < 1e-9);
        drop(mesh);
        cache.drop_unused();
        assert!(cache.entries.is_empty());
    }

    #[test]
    fn a_frame_without_finite_content_has_no_bounds() {
        let mut frame = Frame::default();
        assert_eq!(Bounds::of_frame(&frame, &mut BoundsCache::default()), None);
        frame.meshes.push(MeshDraw {
            mesh: Arc::new(shapes::sphere(0.1)),
            X_WM: Isometry3::translation(f64::NAN, 0.0, 0.0),
            color: [1.0; 4],
            surface: Surface::Satin,
            pick_id: 0,
        });
        assert_eq!(Bounds::of_frame(&frame, &mut BoundsCache::default()), None);
    }
}
