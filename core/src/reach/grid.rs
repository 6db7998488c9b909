//! Cubic voxels of one size, aligned with the origin of their frame.

use nalgebra::{Point3, Vector3};

use super::ReachError;

/// Most voxels of a grid: a sphere of 1.6 m radius in voxels of 2.5 cm, with room.
pub(super) const MOST_VOXELS: usize = 4_000_000;
/// Most voxels along an edge.
pub(super) const MOST_EDGE: usize = 1024;
/// Edge lengths that voxels may have, metres.
pub(super) const VOXEL_M: std::ops::RangeInclusive<f64> = 0.005..=0.5;

/// A box of voxels; voxel `(i, j, k)` reaches from `(first + (i, j, k)) · voxel_m` to one edge further.
///
/// Corners are whole multiples of the edge, so grids of one frame and edge are parts of one lattice, and a part that is
/// cut out has the same centres to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    pub(super) voxel_m: f64,
    pub(super) first: [i32; 3],
    pub(super) size: [usize; 3],
}

impl Grid {
    /// The voxels that hold a box.
    pub(super) fn around(lower: &Point3<f64>, upper: &Point3<f64>, voxel_m: f64) -> Result<Self, ReachError> {
        if !VOXEL_M.contains(&voxel_m) {
            return Err(ReachError::BadVoxel { found: voxel_m });
        }
        let ends = |axis: usize| ((lower[axis] / voxel_m).floor(), (upper[axis] / voxel_m).ceil());
        let edges: [f64; 3] = std::array::from_fn(|axis| ends(axis).1 - ends(axis).0);
        let voxels = edges.iter().product::<f64>();
        // Not a number compares as false.
        if !(voxels <= MOST_VOXELS as f64 && edges.iter().all(|edge| *edge <= MOST_EDGE as f64)) {
            return Err(ReachError::TooMany { what: "voxels", found: voxels, most: MOST_VOXELS as f64 });
        }
        let first = std::array::from_fn(|axis| ends(axis).0 as i32);
        Ok(Self { voxel_m, first, size: edges.map(|edge| edge.max(1.0) as usize) })
    }

    pub(super) fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// Number of the voxel that holds a point.
    #[inline]
    pub(super) fn at(&self, p: &Vector3<f64>) -> Option<usize> {
        let mut place = [0; 3];
        for axis in 0..3 {
            let along = p[axis] / self.voxel_m - f64::from(self.first[axis]);
            // What is not a number is nowhere.
            if !(along >= 0.0 && along < self.size[axis] as f64) {
                return None;
            }
            place[axis] = along as usize;
        }
        Some(self.number(place))
    }

    #[inline]
    pub(super) fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.size[0] * (j + self.size[1] * k)
    }

    pub(super) fn place(&self, number: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size;
        [number % nx, number / nx % ny, number / (nx * ny)]
    }

    /// A point of a voxel; `offset` in edges from its centre.
    pub(super) fn point(&self, number: usize, offset: &[f64; 3]) -> Point3<f64> {
        let place = self.place(number);
        let along =
            |axis: usize| (f64::from(self.first[axis] + place[axis] as i32) + 0.5 + offset[axis]) * self.voxel_m;
        Point3::new(along(0), along(1), along(2))
    }

    /// The least part that holds the given voxels, and where they are in it; the first voxel alone if there are none.
    pub(super) fn cut(&self, voxels: impl Iterator<Item = usize> + Clone) -> Self {
        let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
        for place in voxels.map(|voxel| self.place(voxel)) {
            for axis in 0..3 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        if low[0] == usize::MAX {
            low = [0; 3];
        }
        let first = std::array::from_fn(|axis| self.first[axis] + low[axis] as i32);
        Self { voxel_m: self.voxel_m, first, size: std::array::from_fn(|axis| high[axis] - low[axis] + 1) }
    }

    /// Number of this grid's voxel in another grid of the same lattice, which must hold it.
    pub(super) fn number_in(&self, part: &Self, voxel: usize) -> usize {
        let place = self.place(voxel);
        part.number(std::array::from_fn(|axis| {
            (self.first[axis] + place[axis] as i32 - part.first[axis]).max(0) as usize
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn a_point_is_in_the_voxel_whose_centre_is_nearest() {
        let grid = Grid::around(&Point3::new(-0.97, -0.2, 0.31), &Point3::new(0.4, 0.9, 1.2), 0.05).unwrap();
        let mut rng = Rng::new(1, 0);
        for _ in 0..5_000 {
            let mut along = |axis: usize| {
                let (first, size) = (f64::from(grid.first[axis]), grid.size[axis] as f64);
                rng.uniform(first * 0.05, (first + size) * 0.05)
            };
            let p = Vector3::new(along(0), along(1), along(2));
            let voxel = grid.at(&p).unwrap();
            assert!((grid.point(voxel, &[0.0; 3]).coords - p).amax() < 0.025 + 1e-12);
            assert_eq!(grid.number(grid.place(voxel)), voxel);
        }
        for outside in [[-1.01, 0.0, 0.5], [0.0, 0.0, 1.21], [f64::NAN, 0.0, 0.5], [1e300, 0.0, 0.5]] {
            assert_eq!(grid.at(&Vector3::from(outside)), None);
        }
    }

    #[test]
    fn a_part_has_the_same_centres_to_the_last_bit() {
        let grid = Grid::around(&Point3::new(-1.0, -1.0, -1.0), &Point3::new(1.0, 1.0, 1.0), 0.05).unwrap();
        let inside = [grid.number([3, 9, 20]), grid.number([30, 8, 7])];
        let part = grid.cut(inside.into_iter());
        assert_eq!(part.size, [28, 2, 14]);
        for voxel in inside {
            let there = grid.number_in(&part, voxel);
            assert_eq!(part.point(there, &[0.45; 3]), grid.point(voxel, &[0.45; 3]));
        }
    }

    #[test]
    fn a_grid_that_does_not_fit_into_memory_is_refused() {
        let around = |r: f64, voxel_m| Grid::around(&Point3::new(-r, -r, -r), &Point3::new(r, r, r), voxel_m);
        assert!(matches!(around(1.0, 0.0), Err(ReachError::BadVoxel { .. })));
        assert!(matches!(around(1.0, f64::NAN), Err(ReachError::BadVoxel { .. })));
        assert!(matches!(around(1.0, 0.006), Err(ReachError::TooMany { .. })));
        assert!(matches!(around(f64::INFINITY, 0.05), Err(ReachError::TooMany { .. })));
    }
}
