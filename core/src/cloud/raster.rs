//! A z-buffer: which triangle each pixel sees, and how far away.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::mesh::Mesh;

/// Nothing nearer than this is drawn, metres; triangles that cross the plane are cut there.
const NEAR_M: f64 = 0.01;

/// One triangle as the camera sees it.
pub(super) struct Face {
    /// Index of the body it belongs to.
    pub(super) body: u16,
    /// Unit normal in the optical frame C.
    pub(super) n_C: Vector3<f64>,
}

/// The image of the scene, row-major.
pub(super) struct Raster {
    pub(super) width: usize,
    pub(super) height: usize,
    focal_px: f64,
    /// Index into `faces` per pixel; `u32::MAX` where nothing is seen.
    face: Vec<u32>,
    /// 1 / depth per pixel, 1/m; 0 where nothing is seen.
    inv_depth: Vec<f64>,
    faces: Vec<Face>,
}

impl Raster {
    pub(super) fn new(width: usize, height: usize, focal_px: f64) -> Self {
        let count = width * height;
        Self { width, height, focal_px, face: vec![u32::MAX; count], inv_depth: vec![0.0; count], faces: Vec::new() }
    }

    /// Direction of the ray through a pixel's centre, its z being 1; the principal point is the middle of the image.
    pub(super) fn ray(&self, column: usize, row: usize) -> Vector3<f64> {
        let (cx, cy) = self.middle();
        Vector3::new((column as f64 - cx) / self.focal_px, (row as f64 - cy) / self.focal_px, 1.0)
    }

    /// What a pixel sees: 1 / depth and the face.
    pub(super) fn seen(&self, column: usize, row: usize) -> Option<(f64, &Face)> {
        let pixel = row * self.width + column;
        let face = self.faces.get(*self.face.get(pixel)? as usize)?;
        Some((*self.inv_depth.get(pixel)?, face))
    }

    /// Depth at a pixel, metres; infinity where nothing is seen.
    pub(super) fn depth(&self, pixel: usize) -> f64 {
        self.inv_depth.get(pixel).map_or(f64::INFINITY, |inv| 1.0 / inv)
    }

    fn middle(&self) -> (f64, f64) {
        ((self.width as f64 - 1.0) / 2.0, (self.height as f64 - 1.0) / 2.0)
    }

    /// Draws a mesh; both sides of a triangle are seen.
    pub(super) fn draw(&mut self, mesh: &Mesh, X_CM: &Isometry3<f64>, body: u16) {
        let seen: Vec<Point3<f64>> = mesh.positions.iter().map(|p| X_CM * p).collect();
        for triangle in &mesh.triangles {
            let [Some(a), Some(b), Some(c)] = triangle.map(|i| seen.get(i as usize).copied()) else { continue };
            let Some(n_C) = (b - a).cross(&(c - a)).try_normalize(1e-18) else { continue };
            let face = self.faces.len() as u32;
            self.faces.push(Face { body, n_C });
            if a.z >= NEAR_M && b.z >= NEAR_M && c.z >= NEAR_M {
                self.fill([a, b, c], face);
                continue;
            }
            let polygon = cut_near([a, b, c]);
            for k in 2..polygon.len() {
                self.fill([polygon[0], polygon[k - 1], polygon[k]], face);
            }
        }
    }

    /// Fills one triangle that lies in front of the camera.
    fn fill(&mut self, triangle: [Point3<f64>; 3], face: u32) {
        let (cx, cy) = self.middle();
        let [a, b, c] =
            triangle.map(|p| Vector3::new(self.focal_px * p.x / p.z + cx, self.focal_px * p.y / p.z + cy, 1.0 / p.z));
        let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        let has_area = area.abs() > 1e-12;
        if !has_area {
            return;
        }
        // 1/z is an affine function of the pixel.
        let slope_u = ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) / area;
        let slope_v = ((c.z - a.z) * (b.x - a.x) - (b.z - a.z) * (c.x - a.x)) / area;
        let first = a.y.min(b.y).min(c.y).ceil().max(0.0);
        let last = a.y.max(b.y).max(c.y).floor().min(self.height as f64 - 1.0);
        if first > last {
            return;
        }
        for row in first as usize..=last as usize {
            let v = row as f64;
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for (p, q) in [(a, b), (b, c), (c, a)] {
                // The same ends in the same order give neighbouring triangles the same edge, so no pixel is lost.
                let (p, q) = if p.y <= q.y { (p, q) } else { (q, p) };
                if p.y > v || q.y < v {
                    continue;
                }
                let u = if q.y > p.y { p.x + (q.x - p.x) * ((v - p.y) / (q.y - p.y)) } else { q.x };
                left = left.min(u).min(if q.y > p.y { u } else { p.x });
                right = right.max(u).max(if q.y > p.y { u } else { p.x });
            }
            let left = left.ceil().max(0.0);
            let right = right.floor().min(self.width as f64 - 1.0);
            if left > right {
                continue;
            }
            let (start, stop) = (left as usize, right as usize);
            let base = row * self.width;
            let at_start = a.z + (start as f64 - a.x) * slope_u + (v - a.y) * slope_v;
            let pixels = base + start..=base + stop;
            let (Some(inv_depth), Some(faces)) = (self.inv_depth.get_mut(pixels.clone()), self.face.get_mut(pixels))
            else {
                continue;
            };
            for (k, (nearest, owner)) in inv_depth.iter_mut().zip(faces).enumerate() {
                let inv = at_start + k as f64 * slope_u;
                if inv > *nearest {
                    *nearest = inv;
                    *owner = face;
                }
            }
        }
    }
}

/// The part of a triangle in front of the near plane: 0, 3 or 4 corners.
fn cut_near(triangle: [Point3<f64>; 3]) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(4);
    for k in 0..3 {
        let (p, q) = (triangle[k], triangle[(k + 1) % 3]);
        if p.z >= NEAR_M {
            kept.push(p);
        }
        if (p.z >= NEAR_M) != (q.z >= NEAR_M) {
            kept.push(p + (q - p) * ((NEAR_M - p.z) / (q.z - p.z)));
        }
    }
    kept
}
