//! Points of which nothing else is known, as few boxes: one per occupied cell of a grid, neighbours merged.

use nalgebra::{Isometry3, Point3, Vector3};

use super::model::CollisionError;
use super::world::{World, positive};

/// Occupied cells that a cloud may have.
pub const MOST_CELLS: usize = 1 << 20;
/// Boxes that may be left after merging.
pub const MOST_BOXES: usize = 1 << 15;
/// Cells along each axis: from the least to the greatest, counted from the world's origin.
const FARTHEST_CELL: f64 = 1e6;

/// What became of a cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CloudBoxes {
    /// Cells of the grid that hold at least one point.
    pub cells: usize,
    /// Boxes that these cells were merged into.
    pub boxes: usize,
}

impl World {
    /// An obstacle known only as points in W: every cell of a grid of this edge that holds a point counts as full, and
    /// neighbouring cells become one box. Space between points that is wider than a cell stays free, unlike in
    /// [`World::add_points`]; a body inside of a closed surface of cells touches nothing.
    ///
    /// The grid is that of the world's origin, so the order of the points does not matter.
    ///
    /// # Errors
    /// [`CollisionError`] if the edge is no size, a point is not finite or too far away, or there are more than
    /// [`MOST_CELLS`] cells or [`MOST_BOXES`] boxes: a coarser grid helps.
    pub fn add_cloud(
        &mut self,
        name: &str,
        points_W: &[Point3<f64>],
        voxel_m: f64,
    ) -> Result<CloudBoxes, CollisionError> {
        positive(name, "voxel", voxel_m)?;
        if let Some(index) =
            points_W.iter().position(|p| !p.iter().all(|x| x.is_finite() && (x / voxel_m).abs() < FARTHEST_CELL))
        {
            return Err(CollisionError::PointNotFinite { thing: name.to_owned(), index });
        }
        let cell = |p: &Point3<f64>| [p.z, p.y, p.x].map(|x| (x / voxel_m).floor() as i32);
        let mut cells: Vec<[i32; 3]> = points_W.iter().map(cell).collect();
        cells.sort_unstable();
        cells.dedup();
        limit(name, "occupied cells", cells.len(), MOST_CELLS)?;
        let boxes = merged(&cells);
        limit(name, "boxes", boxes.len(), MOST_BOXES)?;
        for (first, last) in &boxes {
            let lower = Vector3::from_fn(|k, _| f64::from(first[2 - k]) * voxel_m);
            let upper = Vector3::from_fn(|k, _| f64::from(last[2 - k] + 1) * voxel_m);
            let center = 0.5 * (lower + upper);
            self.add_box(name, upper - lower, &Isometry3::translation(center.x, center.y, center.z))?;
        }
        Ok(CloudBoxes { cells: cells.len(), boxes: boxes.len() })
    }
}

/// Refuses a number above its limit.
pub(super) fn limit(thing: &str, what: &'static str, found: usize, most: usize) -> Result<(), CollisionError> {
    if found <= most { Ok(()) } else { Err(CollisionError::TooMany { thing: thing.to_owned(), what, found, most }) }
}

/// First and last cell of each box: cells become rows, equal rows plates, equal plates blocks.
fn merged(cells: &[[i32; 3]]) -> Vec<([i32; 3], [i32; 3])> {
    let mut boxes: Vec<([i32; 3], [i32; 3])> = cells.iter().map(|&cell| (cell, cell)).collect();
    for axis in [2, 1, 0] {
        // Along this axis neighbours stand one after the other once the two others come first.
        let others = [(axis + 1) % 3, (axis + 2) % 3];
        boxes.sort_unstable_by_key(|(first, last)| (others.map(|k| (first[k], last[k])), first[axis]));
        boxes.dedup_by(|next, kept| {
            let same = others.iter().all(|&k| next.0[k] == kept.0[k] && next.1[k] == kept.1[k]);
            let joins = same && next.0[axis] == kept.1[axis] + 1;
            if joins {
                kept.1[axis] = next.1[axis];
            }
            joins
        });
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn merged_boxes_hold_exactly_the_occupied_cells_each_once() {
        let mut rng = Rng::new(51, 0);
        for density in [0.1, 0.6, 0.95] {
            let mut cells = Vec::new();
            for index in 0..12 * 12 * 12 {
                if rng.uniform(0.0, 1.0) < density {
                    cells.push([index / 144, index / 12 % 12, index % 12]);
                }
            }
            let boxes = merged(&cells);
            let mut covered = Vec::new();
            for (first, last) in &boxes {
                for z in first[0]..=last[0] {
                    for y in first[1]..=last[1] {
                        covered.extend((first[2]..=last[2]).map(|x| [z, y, x]));
                    }
                }
            }
            covered.sort_unstable();
            assert_eq!(covered, cells);
            assert!(density < 0.9 || boxes.len() < cells.len() / 3, "{} of {}", boxes.len(), cells.len());
        }
    }

    #[test]
    fn a_hollow_cloud_stays_hollow_and_every_point_is_in_a_box() {
        // The rim of a bowl: its hull would close it.
        let mut points = Vec::new();
        for k in 0..2000 {
            let (sin, cos) = crate::math::sin_cos(0.01 * f64::from(k));
            points.push(Point3::new(0.5 + 0.1 * cos, 0.1 * sin, 0.7 + 0.00002 * f64::from(k)));
        }
        let mut world = World::new();
        let count = world.add_cloud("bowl", &points, 0.01).unwrap();
        assert!(count.boxes < count.cells && count.boxes == world.names().count(), "{count:?}");
        let inside = |p: &Point3<f64>| {
            world.obstacles.iter().any(|o| (0..3).all(|k| p[k] >= o.lower[k] - 1e-9 && p[k] <= o.upper[k] + 1e-9))
        };
        assert!(points.iter().all(inside));
        assert!(!inside(&Point3::new(0.5, 0.0, 0.72)));
        assert!(world.remove("bowl") && world.names().count() == 0);
    }

    #[test]
    fn what_would_fill_the_memory_is_refused_with_the_limit() {
        let mut world = World::new();
        let far = [Point3::new(1e9, 0.0, 0.0)];
        assert!(matches!(world.add_cloud("c", &far, 0.01), Err(CollisionError::PointNotFinite { index: 0, .. })));
        assert!(matches!(world.add_cloud("c", &[], 0.0), Err(CollisionError::BadSize { .. })));
        let apart: Vec<_> = (0..=MOST_BOXES).map(|k| Point3::new(0.02 * k as f64 + 0.005, 0.0, 0.0)).collect();
        let refused = world.add_cloud("c", &apart, 0.01).unwrap_err();
        assert!(refused.to_string().contains("32768"), "{refused}");
        assert_eq!(world.names().count(), 0, "nothing is added by halves");
    }
}
