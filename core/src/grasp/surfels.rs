//! A measured cloud as a surface that fingers can close on: points with normals from their neighbours.
//!
//! Only what was seen is there: a finger that comes from behind finds nothing and closes further than it would on the
//! real object. Near a point the surface is its tangent disc, so the distance between two points is not a hole.

use nalgebra::{Point3, SymmetricEigen, Vector3};

use crate::superquadric::SurfaceSample;

/// Neighbours from which a normal is estimated.
const NEIGHBOURS: usize = 12;
/// Radius of a disc in mean distances between neighbours: discs of loose points overlap.
const DISC_SPACINGS: f64 = 2.0;
/// Cells are this many mean point distances wide.
const CELL_SPACINGS: f64 = 3.0;
/// No more cells along an edge than this.
const MAX_CELLS: f64 = 96.0;

/// Points of a surface in O, each with its outward normal, in a grid.
pub struct Surfels {
    samples: Vec<SurfaceSample>,
    /// Radius of the discs, metres.
    disc_m: f64,
    low: Point3<f64>,
    high: Point3<f64>,
    cell_m: f64,
    counts: [usize; 3],
    /// Samples of each cell: `order[first[c]..first[c + 1]]`.
    first: Vec<u32>,
    order: Vec<u32>,
}

impl Surfels {
    /// Points in O, normals pointing away from `inside_O`, metres; `None` for fewer points than a normal needs.
    pub fn new(points_O: &[Point3<f64>], inside_O: &Point3<f64>) -> Option<Self> {
        if points_O.len() <= NEIGHBOURS {
            return None;
        }
        let (mut low, mut high) = (points_O[0], points_O[0]);
        for p in points_O {
            (low, high) = (low.inf(p), high.sup(p));
        }
        // A surface of this box's size covered evenly: good enough to choose cells by.
        let size = high - low;
        let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
        let guess_m = (area / points_O.len() as f64).sqrt().max(1e-4);
        let cell_m = (CELL_SPACINGS * guess_m).max(size.max() / MAX_CELLS);
        let counts = [0, 1, 2].map(|axis| (size[axis] / cell_m) as usize + 1);
        let mut surfels = Self {
            samples: points_O.iter().map(|&p_F| SurfaceSample { p_F, n_F: Vector3::zeros() }).collect(),
            disc_m: guess_m,
            low,
            high,
            cell_m,
            counts,
            first: Vec::new(),
            order: (0..points_O.len() as u32).collect(),
        };
        let cell_of: Vec<usize> = points_O.iter().map(|p| surfels.index(&surfels.cell(p))).collect();
        surfels.order.sort_by_key(|&sample| (cell_of[sample as usize], sample));
        surfels.first = (0..=counts.iter().product::<usize>())
            .map(|cell| surfels.order.partition_point(|&sample| cell_of[sample as usize] < cell) as u32)
            .collect();
        surfels.estimate_normals(inside_O);
        Some(surfels)
    }

    fn cell(&self, p: &Point3<f64>) -> [usize; 3] {
        [0, 1, 2].map(|axis| (((p[axis] - self.low[axis]) / self.cell_m).max(0.0) as usize).min(self.counts[axis] - 1))
    }

    fn index(&self, cell: &[usize; 3]) -> usize {
        (cell[0] * self.counts[1] + cell[1]) * self.counts[2] + cell[2]
    }

    /// Shows the samples of all cells whose largest offset from a cell is `ring`.
    fn visit_ring(&self, center: &[usize; 3], ring: usize, mut visit: impl FnMut(usize)) {
        let range = |axis: usize| center[axis].saturating_sub(ring)..=(center[axis] + ring).min(self.counts[axis] - 1);
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    let offset = [x, y, z].iter().zip(center).map(|(a, b)| a.abs_diff(*b)).max();
                    if offset != Some(ring) {
                        continue;
                    }
                    let cell = self.index(&[x, y, z]);
                    let run = self.first[cell] as usize..self.first[cell + 1] as usize;
                    self.order[run].iter().for_each(|&sample| visit(sample as usize));
                }
            }
        }
    }

    fn estimate_normals(&mut self, inside_O: &Point3<f64>) {
        let mut spacing_sum = 0.0;
        let mut normals = Vec::with_capacity(self.samples.len());
        for sample in &self.samples {
            let mut near: Vec<(f64, usize)> = Vec::new();
            let center = self.cell(&sample.p_F);
            let most = self.counts.iter().copied().max().unwrap_or(1);
            for ring in 0..most {
                self.visit_ring(&center, ring, |other| {
                    near.push(((self.samples[other].p_F - sample.p_F).norm_squared(), other));
                });
                // One ring more than needed: a nearer one may lie beyond the cell's edge.
                if ring > 0 && near.len() > NEIGHBOURS {
                    break;
                }
            }
            near.sort_by(|l, r| l.0.total_cmp(&r.0).then(l.1.cmp(&r.1)));
            near.truncate(NEIGHBOURS + 1);
            spacing_sum += near.get(1..5).map_or(0.0, |four| four.iter().map(|(d, _)| d.sqrt()).sum::<f64>() / 4.0);
            let mean: Vector3<f64> =
                near.iter().map(|&(_, k)| self.samples[k].p_F.coords).sum::<Vector3<f64>>() / near.len() as f64;
            let mut spread = nalgebra::Matrix3::zeros();
            for &(_, k) in &near {
                let d = self.samples[k].p_F.coords - mean;
                spread += d * d.transpose();
            }
            let eigen = SymmetricEigen::new(spread);
            let normal: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
            let outwards = sample.p_F - inside_O;
            normals.push(if normal.dot(&outwards) < 0.0 { -normal } else { normal });
        }
        self.disc_m = DISC_SPACINGS * (spacing_sum / self.samples.len() as f64).max(1e-5);
        self.samples.iter_mut().zip(normals).for_each(|(sample, n_F)| sample.n_F = n_F);
    }

    /// Distance from the box around all points, metres; 0 inside.
    fn outside_m(&self, p_O: &Point3<f64>) -> f64 {
        (self.low - p_O).sup(&(p_O - self.high)).sup(&Vector3::zeros()).norm()
    }

    /// The nearest sample, if there is one nearer than `within_m`.
    fn nearest(&self, p_O: &Point3<f64>, within_m: f64) -> Option<&SurfaceSample> {
        let center = self.cell(p_O);
        let mut best: Option<(f64, usize)> = None;
        let rings = self.counts.iter().copied().max().unwrap_or(1);
        for ring in 0..rings {
            // All samples of this ring are at least this far away.
            let least_m = (ring as f64 - 1.0).max(0.0) * self.cell_m;
            if best.is_some_and(|(squared, _)| squared < least_m * least_m) || least_m > within_m {
                break;
            }
            self.visit_ring(&center, ring, |sample| {
                let squared = (self.samples[sample].p_F - p_O).norm_squared();
                if best.is_none_or(|(known, index)| squared < known || (squared == known && sample < index)) {
                    best = Some((squared, sample));
                }
            });
        }
        best.map(|(_, sample)| &self.samples[sample])
    }

    /// A lower bound of the signed distance, metres, negative behind the surface; tight near it.
    pub fn signed_distance(&self, p_O: &Point3<f64>) -> f64 {
        let outside_m = self.outside_m(p_O);
        if outside_m > 2.0 * self.cell_m {
            return outside_m;
        }
        let Some(sample) = self.nearest(p_O, f64::INFINITY) else { return outside_m };
        let offset = p_O - sample.p_F;
        let height = offset.dot(&sample.n_F);
        let aside = (offset - sample.n_F * height).norm();
        // Over the disc its plane counts; beside it its rim.
        let beyond = (aside - self.disc_m).max(0.0);
        let distance = (height * height + beyond * beyond).sqrt();
        if height < 0.0 && beyond <= -height { -distance } else { distance }
    }

    /// The foot of a point on the nearest disc; `None` far away.
    pub fn foot(&self, p_O: &Point3<f64>) -> Option<SurfaceSample> {
        let sample = self.nearest(p_O, f64::INFINITY)?;
        let offset = p_O - sample.p_F;
        let aside = offset - sample.n_F * offset.dot(&sample.n_F);
        let length = aside.norm();
        let kept = if length > self.disc_m { aside * (self.disc_m / length) } else { aside };
        Some(SurfaceSample { p_F: sample.p_F + kept, n_F: sample.n_F })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn ball(count: usize) -> Surfels {
        let mut rng = Rng::new(4, 0);
        let points: Vec<_> = (0..count).map(|_| Point3::from(rng.direction() * 0.05)).collect();
        Surfels::new(&points, &Point3::origin()).unwrap()
    }

    #[test]
    fn distances_and_normals_of_a_ball_are_those_of_the_ball() {
        let surfels = ball(8000);
        let mut rng = Rng::new(5, 0);
        for _ in 0..2000 {
            let direction = rng.direction();
            let radius = rng.uniform(0.04, 0.2);
            let found = surfels.signed_distance(&Point3::from(direction * radius));
            let truth = radius - 0.05;
            // Discs of about 1 mm on a ball of 50 mm stand 0.01 mm off it; far away only the box is asked.
            if truth < 0.01 {
                assert!((found - truth).abs() < 5e-4, "{found} at {truth}");
            } else {
                assert!(found <= truth + 5e-4, "{found} at {truth}");
            }
            let foot = surfels.foot(&Point3::from(direction * radius)).unwrap();
            assert!(foot.n_F.dot(&direction) > 0.99 && (foot.p_F.coords.norm() - 0.05).abs() < 5e-4);
        }
    }

    #[test]
    fn too_few_points_are_no_surface() {
        assert!(Surfels::new(&[Point3::origin(); 5], &Point3::origin()).is_none());
    }
}
