//! Points on their way from a file into a cloud: unusable ones dropped and counted, colours and pixels kept in step.

use nalgebra::Point3;

use super::read::MAX_COORDINATE_M;
use super::{CloudError, PixelGrid, PointCloud};

/// Collects points in file order.
pub(super) struct Collector {
    points: Vec<Point3<f64>>,
    colors: Vec<[u8; 3]>,
    pixels: Vec<u32>,
    read: usize,
    not_finite: usize,
    too_far: usize,
}

impl Collector {
    /// A collector with room for `capacity` points, which the caller has checked against the bytes that are there.
    pub(super) fn new(capacity: usize) -> Self {
        Self {
            points: Vec::with_capacity(capacity),
            colors: Vec::new(),
            pixels: Vec::new(),
            read: 0,
            not_finite: 0,
            too_far: 0,
        }
    }

    /// How many points were read so far, dropped ones included.
    pub(super) fn read(&self) -> usize {
        self.read
    }

    /// Takes the next point of the file; colours must come with every point or with none.
    pub(super) fn push(&mut self, x: f64, y: f64, z: f64, color: Option<[u8; 3]>) {
        let pixel = self.read as u32;
        self.read += 1;
        if !(x.is_finite() && y.is_finite() && z.is_finite()) {
            self.not_finite += 1;
        } else if x.abs().max(y.abs()).max(z.abs()) > MAX_COORDINATE_M {
            self.too_far += 1;
        } else {
            self.points.push(Point3::new(x, y, z));
            self.pixels.push(pixel);
            self.colors.extend(color);
        }
    }

    /// Forgets the colours, when they turned out to be something else.
    pub(super) fn drop_colors(&mut self) {
        self.colors.clear();
    }

    /// The cloud, without a sensor pose; `size` is width and height of an organised cloud. Notes say what was dropped.
    pub(super) fn finish(self, size: Option<(u32, u32)>, notes: &mut Vec<String>) -> Result<PointCloud, CloudError> {
        if self.points.is_empty() {
            return Err(CloudError::NoPoints { read: self.read, limit_m: MAX_COORDINATE_M as u64 });
        }
        if self.not_finite > 0 {
            notes.push(format!("{} of {} points are not finite and were dropped", self.not_finite, self.read));
        }
        if self.too_far > 0 {
            notes.push(format!(
                "{} of {} points are farther than {MAX_COORDINATE_M:.0} m from the origin and were dropped",
                self.too_far, self.read
            ));
        }
        let pixels = self.pixels;
        Ok(PointCloud {
            points: self.points,
            colors: self.colors,
            grid: size.map(|(width, height)| PixelGrid { width, height, pixels }),
            X_FC: None,
        })
    }
}
