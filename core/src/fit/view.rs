//! What the camera saw of the cluster, as a small image: its mask, its depth, and how impossible a point is.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

/// Pixels along one side at most; a cluster of 10 000 points gets about 100.
const MAX_SIDE: usize = 160;
/// Points per pixel that the mask should have on average, so that it has few holes before they are closed.
const POINTS_PER_PIXEL: f64 = 2.0;
/// Free pixels around the cluster: farther away a point is outside by at least this many pixels anyway.
const MARGIN: usize = 4;

/// The virtual image of a cluster; the pinhole looks along the camera's z axis.
pub(crate) struct View {
    /// Rotation and translation of X_CD; a matrix is quicker than a quaternion for thousands of points.
    R_CD: Matrix3<f64>,
    p_CD: Vector3<f64>,
    width: usize,
    height: usize,
    /// Image plane coordinates (x/z, y/z) of the corner of pixel (0, 0), and the size of a pixel there.
    corner: [f64; 2],
    pitch: f64,
    /// Nearest measured depth per pixel, metres; infinite where nothing was seen.
    depth: Vec<f64>,
    /// Distance of a pixel from the mask, pixels; 0 inside.
    outside: Vec<f64>,
}

/// How a point contradicts the view; both 0 for a point that the camera could not see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impossibility {
    /// Distance from the object's outline, metres at the depth of the point.
    pub(crate) outside_m: f64,
    /// How far it floats in front of the measured surface, metres.
    pub(crate) in_front_m: f64,
}

impl Impossibility {
    /// Both together, metres.
    pub(crate) fn total_m(&self) -> f64 {
        self.outside_m + self.in_front_m
    }
}

impl View {
    /// The image of points in D from a camera at `X_DC`; `None` when a point is not in front of the camera.
    pub(crate) fn new(points: &[Point3<f64>], X_DC: &Isometry3<f64>) -> Option<Self> {
        let X_CD = X_DC.inverse();
        let (R_CD, p_CD) = (*X_CD.rotation.to_rotation_matrix().matrix(), X_CD.translation.vector);
        let projected: Vec<([f64; 2], f64)> =
            points.iter().map(|p| project(&(R_CD * p.coords + p_CD))).collect::<Option<_>>()?;
        let range = |axis: usize| {
            projected
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], (q, _)| [lo.min(q[axis]), hi.max(q[axis])])
        };
        let ([left, right], [top, bottom]) = (range(0), range(1));
        let (across, down) = (right - left, bottom - top);
        let longest = across.max(down);
        if !(longest.is_finite() && longest > 0.0) {
            return None;
        }
        let by_density =
            (across.max(0.05 * longest) * down.max(0.05 * longest) * POINTS_PER_PIXEL / points.len() as f64).sqrt();
        let pitch = by_density.max(longest / MAX_SIDE as f64);
        let corner = [left - MARGIN as f64 * pitch, top - MARGIN as f64 * pitch];
        let side = |extent: f64| (extent / pitch) as usize + 1 + 2 * MARGIN;
        let (width, height) = (side(across), side(down));

        let mut depth = vec![f64::INFINITY; width * height];
        for (q, z) in &projected {
            let column = ((q[0] - corner[0]) / pitch) as usize;
            let row = ((q[1] - corner[1]) / pitch) as usize;
            if let Some(nearest) = depth.get_mut(row * width + column) {
                *nearest = nearest.min(*z);
            }
        }
        let seen: Vec<bool> = depth.iter().map(|z| z.is_finite()).collect();
        // Close single-pixel holes: grow the mask by one pixel, then shrink it by one.
        let grown = grow(&seen, width, height);
        let shrunk: Vec<bool> = grow(&grown.iter().map(|m| !m).collect::<Vec<_>>(), width, height);
        let mask: Vec<bool> = shrunk.iter().map(|m| !m).collect();
        let outside = distance_to(&mask, width, height);
        Some(Self { R_CD, p_CD, width, height, corner, pitch, depth, outside })
    }

    /// How a point of D contradicts the view.
    pub(crate) fn impossibility(&self, p_D: &Point3<f64>) -> Impossibility {
        let Some((q, z)) = project(&(self.R_CD * p_D.coords + self.p_CD)) else {
            return Impossibility { outside_m: self.pitch * self.width as f64, in_front_m: 0.0 };
        };
        let last = [self.width - 1, self.height - 1];
        let place = [0, 1].map(|axis| (q[axis] - self.corner[axis]) / self.pitch);
        // A cast cuts towards zero and holds at the ends of its range.
        let pixel = [0, 1].map(|axis| (place[axis] as usize).min(last[axis]));
        let beyond = [0, 1].map(|axis| (place[axis] - (last[axis] + 1) as f64).max(-place[axis]).max(0.0));
        let index = pixel[1] * self.width + pixel[0];
        let outside_px = self.outside[index] + (beyond[0] * beyond[0] + beyond[1] * beyond[1]).sqrt();
        let depth = self.depth[index];
        let in_front_m = if depth.is_finite() { (depth - z).max(0.0) } else { 0.0 };
        Impossibility { outside_m: outside_px * self.pitch * z, in_front_m }
    }

    /// Where the camera is, in D.
    pub(crate) fn camera(&self) -> Point3<f64> {
        Point3::from(-self.R_CD.tr_mul(&self.p_CD))
    }
}

/// Image plane coordinates and depth; `None` within 1 mm of the camera's plane or behind it.
fn project(p: &Vector3<f64>) -> Option<([f64; 2], f64)> {
    (p.z > 1e-3).then(|| ([p.x / p.z, p.y / p.z], p.z))
}

/// The mask and the eight neighbours of each of its pixels.
fn grow(mask: &[bool], width: usize, height: usize) -> Vec<bool> {
    let mut grown = mask.to_vec();
    for row in 0..height {
        for column in 0..width {
            if mask[row * width + column] {
                for r in row.saturating_sub(1)..(row + 2).min(height) {
                    for c in column.saturating_sub(1)..(column + 2).min(width) {
                        grown[r * width + c] = true;
                    }
                }
            }
        }
    }
    grown
}

/// Distance of every pixel from the mask in pixels, by two passes with steps 1 and √2 (at most 8 % too long).
fn distance_to(mask: &[bool], width: usize, height: usize) -> Vec<f64> {
    let diagonal = std::f64::consts::SQRT_2;
    let far = (width + height) as f64;
    let mut distance: Vec<f64> = mask.iter().map(|m| if *m { 0.0 } else { far }).collect();
    let relax = |distance: &mut [f64], row: usize, column: usize, forward: bool| {
        let mut best = distance[row * width + column];
        let ahead = [(-1i64, -1i64, diagonal), (-1, 0, 1.0), (-1, 1, diagonal), (0, -1, 1.0)];
        for (dr, dc, cost) in ahead {
            let (dr, dc) = if forward { (dr, dc) } else { (-dr, -dc) };
            let (r, c) = (row as i64 + dr, column as i64 + dc);
            if r >= 0 && c >= 0 && (r as usize) < height && (c as usize) < width {
                best = best.min(distance[r as usize * width + c as usize] + cost);
            }
        }
        distance[row * width + column] = best;
    };
    for row in 0..height {
        for column in 0..width {
            relax(&mut distance, row, column, true);
        }
    }
    for row in (0..height).rev() {
        for column in (0..width).rev() {
            relax(&mut distance, row, column, false);
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 10 cm square facing a camera 1 m away, 2 mm between points.
    fn square() -> Vec<Point3<f64>> {
        (0..51)
            .flat_map(|i| {
                (0..51).map(move |j| Point3::new(0.002 * f64::from(i) - 0.05, 0.002 * f64::from(j) - 0.05, 1.0))
            })
            .collect()
    }

    #[test]
    fn points_behind_are_allowed_points_in_front_and_beside_are_not() {
        let view = View::new(&square(), &Isometry3::identity()).unwrap();
        let at = |x: f64, y: f64, z: f64| view.impossibility(&Point3::new(x, y, z));
        assert_eq!(at(0.01, 0.02, 1.0).total_m(), 0.0);
        assert_eq!(at(0.01, 0.02, 1.2).total_m(), 0.0);
        assert!((at(0.01, 0.02, 0.95).in_front_m - 0.05).abs() < 1e-12);
        assert_eq!(at(0.01, 0.02, 0.95).outside_m, 0.0);
        // 3 cm beside the edge, to within a pixel (about 3.5 mm) and the 8 % of the distance transform.
        assert!((at(0.08, 0.0, 1.0).outside_m - 0.03).abs() < 0.006);
        assert!(at(0.3, 0.3, 1.0).outside_m > 0.3);
        assert!(at(0.0, 0.0, -1.0).outside_m > 0.0);
    }

    #[test]
    fn clouds_behind_the_camera_or_in_one_place_have_no_view() {
        assert!(
            View::new(&[Point3::new(0.0, 0.0, -1.0), Point3::new(0.1, 0.0, 1.0)], &Isometry3::identity()).is_none()
        );
        assert!(View::new(&[Point3::new(0.0, 0.0, 1.0); 4], &Isometry3::identity()).is_none());
    }
}
