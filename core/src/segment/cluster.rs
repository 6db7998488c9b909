//! Euclidean clusters: points are linked when they are within a distance of each other, exactly.
//!
//! The grid's cells are so small (edge d/√3) that two points in one cell are always linked, so only pairs of cells need
//! a look, and of those only the ones that no chain of other cells has linked already.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::Point3;

/// A cell of the grid.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Cell(i64, i64, i64);

/// Multiplies and mixes; cells come from coordinates, nobody attacks them, and their order is never used.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_i64(i64::from(*byte)));
    }

    fn write_i64(&mut self, part: i64) {
        self.0 = (self.0.rotate_left(23) ^ part as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

impl Cell {
    /// The cell so many cells away; at the end of the world it wraps around, and the distances of the points tell.
    fn moved(self, by: [i64; 3]) -> Self {
        Self(self.0.wrapping_add(by[0]), self.1.wrapping_add(by[1]), self.2.wrapping_add(by[2]))
    }
}

type Cells = HashMap<Cell, u32, BuildHasherDefault<CellHasher>>;

/// The cluster of each point, as numbers from 0 in order of first appearance.
pub(super) fn link(points: &[Point3<f64>], distance_m: f64) -> Vec<u32> {
    let grid = Grid::new(points, distance_m);
    let mut sets = Sets::new(grid.cells.len());
    for offset in half_neighbours() {
        for (here, cell) in (0u32..).zip(&grid.cells) {
            let neighbour = cell.at.moved(offset);
            let Some(&there) = grid.index.get(&neighbour) else { continue };
            if sets.find(here) != sets.find(there) && grid.touch(here, there, distance_m) {
                sets.unite(here, there);
            }
        }
    }
    let mut names = vec![u32::MAX; grid.cells.len()];
    let mut next = 0;
    (grid.cell_of.iter())
        .map(|&cell| {
            let root = sets.find(cell) as usize;
            if names[root] == u32::MAX {
                names[root] = next;
                next += 1;
            }
            names[root]
        })
        .collect()
}

/// One of each two opposite offsets to the cells that can hold a linked point, nearest first, so that most cells are
/// united by touching neighbours before the far ones are looked at.
fn half_neighbours() -> Vec<[i64; 3]> {
    let mut offsets: Vec<[i64; 3]> =
        (0..125i64).map(|k| [k / 25 - 2, k / 5 % 5 - 2, k % 5 - 2]).filter(|offset| *offset > [0; 3]).collect();
    offsets.sort_by_key(|offset| offset.iter().map(|part| part * part).sum::<i64>());
    offsets
}

/// An occupied cell with its points and their bounds.
struct Occupied {
    at: Cell,
    members: std::ops::Range<usize>,
    least: Point3<f64>,
    most: Point3<f64>,
}

struct Grid {
    cells: Vec<Occupied>,
    index: Cells,
    cell_of: Vec<u32>,
    /// Points ordered by cell.
    sorted: Vec<Point3<f64>>,
}

impl Grid {
    fn new(points: &[Point3<f64>], distance_m: f64) -> Self {
        let corner = points.iter().fold(Point3::from([f64::INFINITY; 3]), |least, p| least.inf(p));
        // A hair less than d/√3, so that round-off cannot put points into one cell that are not within d.
        let cells_per_m = (3f64.sqrt() + 1e-6) / distance_m;
        let mut index = Cells::default();
        let mut cells: Vec<Occupied> = Vec::new();
        let mut cell_of = Vec::with_capacity(points.len());
        let mut last = (Cell(-1, -1, -1), 0u32);
        for p in points {
            let at = (p - corner) * cells_per_m;
            let at = Cell(at.x as i64, at.y as i64, at.z as i64);
            if at != last.0 {
                let fresh = cells.len() as u32;
                last = (at, *index.entry(at).or_insert(fresh));
                if last.1 == fresh {
                    cells.push(Occupied { at, members: 0..0, least: *p, most: *p });
                }
            }
            cell_of.push(last.1);
            if let Some(cell) = cells.get_mut(last.1 as usize) {
                cell.members.end += 1;
                cell.least = cell.least.inf(p);
                cell.most = cell.most.sup(p);
            }
        }
        let mut start = 0;
        for cell in &mut cells {
            let count = cell.members.len();
            // Empty for now; filling moves the end.
            cell.members = start..start;
            start += count;
        }
        let mut sorted = vec![Point3::origin(); points.len()];
        for (p, cell) in points.iter().zip(&cell_of) {
            let members = &mut cells[*cell as usize].members;
            sorted[members.end] = *p;
            members.end += 1;
        }
        Self { cells, index, cell_of, sorted }
    }

    /// Whether some point of one cell is within the distance of some point of the other.
    fn touch(&self, a: u32, b: u32, distance_m: f64) -> bool {
        let (a, b) = (&self.cells[a as usize], &self.cells[b as usize]);
        let reach = distance_m * distance_m;
        if gap_squared(&a.least, &a.most, &b.least, &b.most) > reach {
            return false;
        }
        let near_b: Vec<&Point3<f64>> =
            self.sorted[a.members.clone()].iter().filter(|p| gap_squared(p, p, &b.least, &b.most) <= reach).collect();
        self.sorted[b.members.clone()]
            .iter()
            .filter(|q| gap_squared(q, q, &a.least, &a.most) <= reach)
            .any(|q| near_b.iter().any(|p| (*p - q).norm_squared() <= reach))
    }
}

/// Squared distance between two boxes.
fn gap_squared(least: &Point3<f64>, most: &Point3<f64>, other_least: &Point3<f64>, other_most: &Point3<f64>) -> f64 {
    (0..3).map(|k| (least[k] - other_most[k]).max(other_least[k] - most[k]).max(0.0)).map(|gap| gap * gap).sum()
}

/// Disjoint sets of cells, with path halving.
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    fn find(&mut self, mut cell: u32) -> u32 {
        while self.parent[cell as usize] != cell {
            let up = self.parent[self.parent[cell as usize] as usize];
            self.parent[cell as usize] = up;
            cell = up;
        }
        cell
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The slow truth: every pair is looked at.
    fn link_slowly(points: &[Point3<f64>], distance_m: f64) -> Vec<u32> {
        let mut labels: Vec<u32> = (0..points.len() as u32).collect();
        for i in 0..points.len() {
            for j in 0..i {
                if (points[i] - points[j]).norm_squared() <= distance_m * distance_m && labels[i] != labels[j] {
                    let (from, to) = (labels[i], labels[j]);
                    labels.iter_mut().filter(|label| **label == from).for_each(|label| *label = to);
                }
            }
        }
        let mut names: Vec<u32> = Vec::new();
        (labels.iter())
            .map(|label| {
                names.iter().position(|name| name == label).unwrap_or_else(|| {
                    names.push(*label);
                    names.len() - 1
                }) as u32
            })
            .collect()
    }

    proptest! {
        #[test]
        fn cells_give_the_same_clusters_as_looking_at_every_pair(
            points in prop::collection::vec(prop::array::uniform3(-0.15f64..0.15).prop_map(Point3::from), 0..150),
            // From nearly all points alone to nearly all points together.
            distance in 0.01f64..0.08,
        ) {
            prop_assert_eq!(link(&points, distance), link_slowly(&points, distance));
        }
    }

    #[test]
    fn points_at_exactly_the_distance_are_linked_and_a_little_farther_are_not() {
        let pair = |gap: f64| link(&[Point3::new(1.0, 0.0, 0.0), Point3::new(1.0, gap, 0.0)], 0.25);
        assert_eq!(pair(0.25), [0, 0]);
        assert_eq!(pair(0.2500001), [0, 1]);
    }
}
