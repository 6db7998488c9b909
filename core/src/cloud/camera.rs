//! A synthetic RGB-D camera: the cloud that a robot would see of a scene of meshes.

use nalgebra::{Isometry3, Point3};

use super::noise::Gauss;
use super::raster::Raster;
use super::{DepthNoise, PixelGrid, PointCloud};
use crate::math;
use crate::mesh::Mesh;
use crate::parallel;

/// Neighbouring pixels whose depths differ by more than this are a depth edge, metres. A surface seen at 75° and 1.4 m
/// steps by 1 cm from pixel to pixel.
const EDGE_M: f64 = 0.02;
/// The ray wanders only this near to a depth edge, pixels: 2.5 deviations of 0.8 px.
const EDGE_REACH_PX: usize = 2;

/// A pinhole camera with a depth sensor; the principal point is the middle of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RgbdCamera {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Focal length, pixels.
    pub focal_px: f64,
    /// How depth is mismeasured.
    pub noise: DepthNoise,
}

impl Default for RgbdCamera {
    /// 640 × 480, f = 525 px, range and noise of the Carmine 1.09.
    fn default() -> Self {
        Self { width: 640, height: 480, focal_px: 525.0, noise: DepthNoise::carmine() }
    }
}

/// A body in front of the camera.
#[derive(Clone, Copy, Debug)]
pub struct SeenBody<'a> {
    /// Its surface, in its own frame M.
    pub mesh: &'a Mesh,
    /// Its pose in the world.
    pub X_WM: Isometry3<f64>,
    /// Its sRGB colour.
    pub color: [u8; 3],
}

/// What the camera saw.
#[derive(Clone, Debug)]
pub struct View {
    /// Organised cloud in the world frame W, `X_FC` being the camera's pose `X_WC`.
    pub cloud: PointCloud,
    /// The truth: index of the body that each point was measured on.
    pub bodies: Vec<u16>,
}

impl RgbdCamera {
    /// The cloud of these bodies as seen from `X_WC` (optical frame: x right, y down, z forward), in W.
    ///
    /// Depth comes from a z-buffer; per pixel, in this order: at depth edges the ray wanders sideways, surfaces seen too
    /// obliquely are lost, noise is added along the optical axis, disparity is rounded, and what is out of range is
    /// lost. Each image row has its own random stream, so the result depends on the seed alone. Colours are the bodies'
    /// own, darker where the surface turns away.
    pub fn render(&self, bodies: &[SeenBody<'_>], X_WC: &Isometry3<f64>, seed: u64) -> View {
        let (width, height) = (self.width as usize, self.height as usize);
        let mut raster = Raster::new(width, height, self.focal_px);
        for (body, index) in bodies.iter().zip(0u16..) {
            raster.draw(body.mesh, &X_WC.inv_mul(&body.X_WM), index);
        }
        let near_edge = if self.noise.edge_jitter_px > 0.0 { near_edges(&raster) } else { vec![false; width * height] };
        let rows: Vec<usize> = (0..height).collect();
        let measured = parallel::map(&rows, |&row| self.measure_row(&raster, &near_edge, bodies, X_WC, row, seed));

        let count = measured.iter().map(Vec::len).sum();
        let mut cloud = PointCloud {
            points: Vec::with_capacity(count),
            colors: Vec::with_capacity(count),
            grid: None,
            X_FC: Some(*X_WC),
        };
        let mut pixels = Vec::with_capacity(count);
        let mut truth = Vec::with_capacity(count);
        for sample in measured.iter().flatten() {
            pixels.push(sample.pixel);
            cloud.points.push(sample.p_W);
            cloud.colors.push(sample.color);
            truth.push(sample.body);
        }
        cloud.grid = Some(PixelGrid { width: self.width, height: self.height, pixels });
        View { cloud, bodies: truth }
    }

    fn measure_row(
        &self,
        raster: &Raster,
        near_edge: &[bool],
        bodies: &[SeenBody<'_>],
        X_WC: &Isometry3<f64>,
        row: usize,
        seed: u64,
    ) -> Vec<Sample> {
        let mut gauss = Gauss::new(seed, row as u64);
        let least_cos = math::cos(self.noise.max_incidence_rad);
        let mut samples = Vec::with_capacity(raster.width);
        for column in 0..raster.width {
            let pixel = row * raster.width + column;
            let (mut at_column, mut at_row) = (column, row);
            if near_edge.get(pixel).copied().unwrap_or(false) {
                at_column = wander(column, raster.width, self.noise.edge_jitter_px * gauss.next());
                at_row = wander(row, raster.height, self.noise.edge_jitter_px * gauss.next());
            }
            let Some((inv_depth, face)) = raster.seen(at_column, at_row) else { continue };
            let ray = raster.ray(at_column, at_row);
            let cos = (face.n_C.dot(&ray) / ray.norm()).abs();
            if cos < least_cos {
                continue;
            }
            let Some(depth) = self.noise.measure(1.0 / inv_depth, &mut gauss) else { continue };
            let Some(body) = bodies.get(face.body as usize) else { continue };
            samples.push(Sample {
                pixel: pixel as u32,
                p_W: X_WC * Point3::from(raster.ray(column, row) * depth),
                color: body.color.map(|channel| (f64::from(channel) * (0.55 + 0.45 * cos)) as u8),
                body: face.body,
            });
        }
        samples
    }
}

/// One measured pixel.
struct Sample {
    pixel: u32,
    p_W: Point3<f64>,
    color: [u8; 3],
    body: u16,
}

/// The pixel that is met after a sideways step, kept inside the image.
fn wander(from: usize, size: usize, step_px: f64) -> usize {
    (from as f64 + step_px.round()).max(0.0).min(size as f64 - 1.0) as usize
}

/// Pixels within [`EDGE_REACH_PX`] of a depth edge.
fn near_edges(raster: &Raster) -> Vec<bool> {
    let (width, height) = (raster.width, raster.height);
    let mut marked = vec![false; width * height];
    for row in 0..height {
        for column in 0..width {
            let here = row * width + column;
            let depth = raster.depth(here);
            // Two pixels without depth differ by NaN, which is no edge.
            let differs = |other: usize| (depth - raster.depth(other)).abs() > EDGE_M;
            let mut mark = |other: usize| {
                if differs(other) {
                    for pixel in [here, other] {
                        if let Some(mark) = marked.get_mut(pixel) {
                            *mark = true;
                        }
                    }
                }
            };
            if column + 1 < width {
                mark(here + 1);
            }
            if row + 1 < height {
                mark(here + width);
            }
        }
    }
    widen(&widen(&marked, width, 1), width, width)
}

/// Marks every pixel that has a marked one within the reach along one direction of the image.
fn widen(marked: &[bool], width: usize, step: usize) -> Vec<bool> {
    let mut wide = marked.to_vec();
    for (pixel, _) in marked.iter().enumerate().filter(|(_, mark)| **mark) {
        for reach in 1..=EDGE_REACH_PX {
            for other in [pixel.checked_sub(reach * step), Some(pixel + reach * step)].into_iter().flatten() {
                let same_line = step != 1 || other / width == pixel / width;
                if let Some(mark) = wide.get_mut(other).filter(|_| same_line) {
                    *mark = true;
                }
            }
        }
    }
    wide
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// A square plate in the plane z = 0 of its frame, facing -z.
    fn plate(half_m: f64) -> Mesh {
        let corner = |x: f64, y: f64| Point3::new(x * half_m, y * half_m, 0.0);
        Mesh {
            positions: vec![corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)],
            normals: vec![-Vector3::z(); 4],
            triangles: vec![[0, 2, 1], [0, 3, 2]],
        }
    }

    fn seen(mesh: &Mesh, X_WM: Isometry3<f64>) -> SeenBody<'_> {
        SeenBody { mesh, X_WM, color: [200, 100, 50] }
    }

    #[test]
    fn a_plate_covers_the_pixels_that_its_size_and_distance_say() {
        let camera = RgbdCamera { noise: DepthNoise::none(), ..RgbdCamera::default() };
        let mesh = plate(0.0495);
        let view = camera.render(&[seen(&mesh, Isometry3::translation(0.0, 0.0, 0.7))], &Isometry3::identity(), 1);
        // 0.099 m at 0.7 m and f = 525 px are 74.25 px: from 282.4 to 356.6, so 74 columns and rows.
        assert_eq!(view.cloud.points.len(), 74 * 74);
        assert!(view.cloud.points.iter().all(|p| (p.z - 0.7).abs() < 1e-9));
        let grid = view.cloud.grid.unwrap();
        for (p, pixel) in view.cloud.points.iter().zip(&grid.pixels) {
            let (u, v) = (f64::from(pixel % 640), f64::from(pixel / 640));
            assert!((525.0 * p.x / p.z + 319.5 - u).abs() < 1e-6 && (525.0 * p.y / p.z + 239.5 - v).abs() < 1e-6);
        }
    }

    #[test]
    fn the_nearer_body_hides_the_other_in_whatever_order_they_come() {
        let camera = RgbdCamera { noise: DepthNoise::none(), ..RgbdCamera::default() };
        let (near, far) = (plate(0.05), plate(0.5));
        let near = seen(&near, Isometry3::translation(0.0, 0.0, 0.6));
        let far = seen(&far, Isometry3::translation(0.0, 0.0, 1.0));
        let count = |bodies: &[SeenBody<'_>], body| {
            let view = camera.render(bodies, &Isometry3::identity(), 1);
            view.bodies.iter().filter(|b| **b == body).count()
        };
        assert_eq!(count(&[near, far], 0), count(&[far, near], 1));
        assert_eq!(count(&[near, far], 1), count(&[far, near], 0));
        assert!(count(&[near, far], 0) > 7000);
    }

    #[test]
    fn a_plate_through_the_camera_is_cut_and_not_wrapped_around() {
        let camera = RgbdCamera { noise: DepthNoise::none(), ..RgbdCamera::default() };
        let mesh = plate(2.0);
        // A floor 0.5 m below the camera, reaching 2 m in front of it and behind it.
        let floor = Isometry3::new(Vector3::new(0.0, 0.5, 0.0), Vector3::x() * std::f64::consts::FRAC_PI_2);
        let view = camera.render(&[seen(&mesh, floor)], &Isometry3::identity(), 1);
        assert!(view.cloud.points.len() > 10_000);
        assert!(view.cloud.points.iter().all(|p| (p.y - 0.5).abs() < 1e-6 && p.z > 0.0 && p.z < 2.01));
    }

    #[test]
    fn depth_noise_has_the_deviation_of_the_data_sheet() {
        let camera = RgbdCamera::default();
        let mesh = plate(0.4);
        let view = camera.render(&[seen(&mesh, Isometry3::translation(0.0, 0.0, 0.84))], &Isometry3::identity(), 3);
        let inner: Vec<f64> = view.cloud.points.iter().filter(|p| p.x.abs() < 0.3).map(|p| p.z - 0.84).collect();
        let deviation = (inner.iter().map(|e| e * e).sum::<f64>() / inner.len() as f64).sqrt();
        // 1.09 mm of noise, and rounding to steps of 2.05 mm adds 2.05/√12 = 0.59 mm: 1.24 mm together.
        assert!((deviation - 0.00124).abs() < 0.0001, "{deviation}");
    }

    #[test]
    fn oblique_far_and_near_surfaces_are_lost_and_seeds_decide_the_rest() {
        let camera = RgbdCamera::default();
        let mesh = plate(0.2);
        let count = |X_WM, seed| camera.render(&[seen(&mesh, X_WM)], &Isometry3::identity(), seed).cloud.points;
        let turned = |degrees: f64| Isometry3::new(Vector3::z() * 0.8, Vector3::y() * degrees.to_radians());
        assert!(count(turned(60.0), 1).len() > 5000);
        assert_eq!(count(turned(84.0), 1).len(), 0);
        assert_eq!(count(Isometry3::translation(0.0, 0.0, 1.6), 1).len(), 0);
        assert_eq!(count(Isometry3::translation(0.0, 0.0, 0.3), 1).len(), 0);
        assert_eq!(count(turned(10.0), 1), count(turned(10.0), 1));
        assert_ne!(count(turned(10.0), 1), count(turned(10.0), 2));
    }
}
