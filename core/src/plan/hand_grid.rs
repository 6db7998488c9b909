//! Where the hand's ball has room, in voxels.

use nalgebra::{Point3, Vector3};

/// Costs of a step to a neighbour across a face, an edge, a corner: tenths of a cell, near enough to 1, √2, √3.
const COSTS: [u32; 3] = [10, 14, 17];

/// What a cell costs that was not reached.
pub(super) const FAR: u32 = u32::MAX;

/// Ways past obstacles nearer than this count as blocked when a straight line is proven, metres: it bounds the steps.
const LEAST_ROOM_M: f64 = 5e-4;

/// Room for a ball around the hand: the distance to the nearest obstacle in metres at a place in the world, negative
/// where it touches. It may change by at most as much as the place does ([`crate::collision::BallChecker`]).
pub type Room<'a> = dyn Fn(&Point3<f64>) -> f64 + Sync + 'a;

/// Voxels of the region around a shoulder, each free or not.
pub struct FreeSpace<'a> {
    /// Centre of the first cell.
    corner: Point3<f64>,
    cell_m: f64,
    /// Cells along each axis; the outermost ones are never free.
    counts: [usize; 3],
    free: Vec<bool>,
    center: Point3<f64>,
    inner_m: f64,
    room_m: &'a Room<'a>,
}

impl<'a> FreeSpace<'a> {
    /// The cells whose centres are between two distances from `center` and have room.
    ///
    /// * `center`: the shoulder.
    /// * `shell_m`: nearer to it the hand is hardly ever, since the elbow cannot fold so far, and farther away it
    ///   cannot be; metres. The inner ball is what routes go round, one way or the other: joints that do not turn all
    ///   the way round make these ways as different as an obstacle would.
    ///
    /// A block of cells is decided at once where the room at its middle is larger than the block.
    pub fn new(center: &Point3<f64>, shell_m: [f64; 2], cell_m: f64, room_m: &'a Room<'a>) -> Self {
        let [inner_m, outer_m] = shell_m;
        // A hundred cells to either side are 8 million.
        let cell_m = cell_m.max(outer_m / 100.0).max(1e-3);
        let half = (outer_m / cell_m).ceil().max(0.0) as usize + 1;
        let count = 2 * half + 1;
        let corner = center - Vector3::repeat(half as f64 * cell_m);
        let free = vec![false; count * count * count];
        let mut space = Self { corner, cell_m, counts: [count; 3], free, center: *center, inner_m, room_m };
        space.fill([1; 3], [count - 2; 3], outer_m);
        space
    }

    /// Decides the block of cells that begins at `first`.
    fn fill(&mut self, first: [usize; 3], size: [usize; 3], outer_m: f64) {
        let half = Vector3::from_fn(|axis, _| 0.5 * (size[axis] - 1) as f64 * self.cell_m);
        let middle = self.center(self.index(first)) + half;
        let bound = half.norm();
        let inside = outer_m - (middle - self.center).norm();
        if inside < -bound {
            return;
        }
        let room = self.room_outside_m(&middle);
        if room <= -bound {
            return;
        }
        if room > bound && inside >= bound {
            for z in first[2]..first[2] + size[2] {
                for y in first[1]..first[1] + size[1] {
                    let row = self.index([first[0], y, z]);
                    self.free[row..row + size[0]].fill(true);
                }
            }
            return;
        }
        // A single cell has bound 0 and was decided above, unless its centre is outside.
        let Some(axis) = (0..3).filter(|&axis| size[axis] > 1).max_by_key(|&axis| size[axis]) else { return };
        let low = size[axis] / 2;
        let (mut low_size, mut high_size, mut high_first) = (size, size, first);
        low_size[axis] = low;
        high_size[axis] = size[axis] - low;
        high_first[axis] += low;
        self.fill(first, low_size, outer_m);
        self.fill(high_first, high_size, outer_m);
    }

    /// Room outside of the inner ball, metres.
    pub(super) fn room_outside_m(&self, p_W: &Point3<f64>) -> f64 {
        self.room_m(p_W).min((p_W - self.center).norm() - self.inner_m)
    }

    /// Edge length of a cell, metres.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Number of free cells.
    pub fn free_cells(&self) -> usize {
        self.free.iter().filter(|&&free| free).count()
    }

    /// Distance from a ball at a place to the nearest obstacle, metres.
    pub fn room_m(&self, p_W: &Point3<f64>) -> f64 {
        (self.room_m)(p_W)
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// Centre of a cell in the world.
    pub(super) fn center(&self, cell: usize) -> Point3<f64> {
        let (x, rest) = (cell % self.counts[0], cell / self.counts[0]);
        let (y, z) = (rest % self.counts[1], rest / self.counts[1]);
        self.corner + Vector3::new(x as f64, y as f64, z as f64) * self.cell_m
    }

    /// The cell that holds a place.
    fn cell(&self, p_W: &Point3<f64>) -> Option<usize> {
        let at = (p_W - self.corner) / self.cell_m;
        let mut cell = [0; 3];
        for axis in 0..3 {
            let along = (at[axis] + 0.5).floor();
            if !(along >= 0.0 && along < self.counts[axis] as f64) {
                return None;
            }
            cell[axis] = along as usize;
        }
        Some(self.index(cell))
    }

    /// The free cell nearest to a place that is seen from there, at most two cells away.
    pub(super) fn free_cell_near(&self, p_W: &Point3<f64>) -> Option<usize> {
        let middle = self.cell(p_W)?;
        let mut near = Vec::new();
        for (offset, _) in self.neighbours() {
            for (further, _) in self.neighbours().into_iter().chain([(0, 0)]) {
                near.push(middle.checked_add_signed(offset + further));
            }
        }
        near.push(Some(middle));
        let mut near: Vec<(f64, usize)> = near
            .into_iter()
            .flatten()
            .filter(|&cell| self.free.get(cell) == Some(&true))
            .map(|cell| ((self.center(cell) - p_W).norm_squared(), cell))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.dedup();
        near.into_iter().map(|(_, cell)| cell).find(|&cell| self.sees(p_W, &self.center(cell)))
    }

    /// Offsets of the 26 neighbours and what a step to them costs, in a fixed order.
    fn neighbours(&self) -> Vec<(isize, u32)> {
        let (row, slab) = (self.counts[0] as isize, (self.counts[0] * self.counts[1]) as isize);
        let mut all = Vec::with_capacity(26);
        for z in -1_isize..=1 {
            for y in -1_isize..=1 {
                for x in -1_isize..=1 {
                    let moved = x.unsigned_abs() + y.unsigned_abs() + z.unsigned_abs();
                    if moved > 0 {
                        all.push((z * slab + y * row + x, COSTS[moved - 1]));
                    }
                }
            }
        }
        all
    }

    /// Cost of the cheapest way through free cells from one cell to each, [`FAR`] where there is none; given up beyond
    /// twice the cost of `until`, where that is reached.
    pub(super) fn costs_from(&self, source: usize, until: usize) -> Vec<u32> {
        let neighbours = self.neighbours();
        let mut costs = vec![FAR; self.free.len()];
        // Dial's queue: costs that wait differ by at most the largest step.
        let mut buckets: Vec<Vec<usize>> = vec![Vec::new(); COSTS[2] as usize + 1];
        costs[source] = 0;
        buckets[0].push(source);
        let (mut cost, mut waiting, mut limit) = (0, 1_usize, FAR);
        while waiting > 0 && cost <= limit {
            let slot = cost as usize % buckets.len();
            let mut next = 0;
            while let Some(&cell) = buckets[slot].get(next) {
                next += 1;
                waiting -= 1;
                if costs[cell] != cost {
                    continue;
                }
                if cell == until {
                    limit = cost.saturating_mul(2);
                }
                for &(offset, step) in &neighbours {
                    let other = cell.wrapping_add_signed(offset);
                    if self.free[other] && cost + step < costs[other] {
                        costs[other] = cost + step;
                        buckets[(cost + step) as usize % (COSTS[2] as usize + 1)].push(other);
                        waiting += 1;
                    }
                }
            }
            buckets[slot].clear();
            cost += 1;
        }
        costs
    }

    /// The cells from a reached cell down to the source of the costs, both included.
    pub(super) fn descend(&self, costs: &[u32], from: usize) -> Vec<usize> {
        let neighbours = self.neighbours();
        let mut way = vec![from];
        let mut cell = from;
        while costs[cell] > 0 {
            let before = neighbours.iter().map(|&(offset, step)| (cell.wrapping_add_signed(offset), step));
            let Some((next, _)) =
                before.into_iter().find(|&(other, step)| costs[other] != FAR && costs[other] + step == costs[cell])
            else {
                break;
            };
            cell = next;
            way.push(cell);
        }
        way
    }

    /// Whether the straight line between two cells stays in free cells.
    pub(super) fn cells_see(&self, a: usize, b: usize) -> bool {
        let (p, q) = (self.center(a), self.center(b));
        let steps = (2.0 * (q - p).amax() / self.cell_m).ceil().max(1.0) as usize;
        (0..=steps).all(|step| {
            let at = p + (q - p) * (step as f64 / steps as f64);
            self.cell(&at).is_some_and(|cell| self.free[cell])
        })
    }

    /// Whether the ball is proven free all along a straight line: balls of room cover it.
    pub(super) fn sees(&self, a: &Point3<f64>, b: &Point3<f64>) -> bool {
        let length = (b - a).norm();
        let mut at = 0.0;
        while at <= length {
            let share = if length > 0.0 { at / length } else { 0.0 };
            let room = self.room_outside_m(&(a + (b - a) * share));
            // A room that is no number is no room.
            if room.is_nan() || room <= LEAST_ROOM_M {
                return false;
            }
            at += room;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Room of a ball of 5 cm beside a ball-shaped pillar and above a floor.
    fn room_m(p: &Point3<f64>) -> f64 {
        ((p - Point3::new(0.3, 0.0, 0.2)).norm() - 0.15).min(p.z - 0.003) - 0.05
    }

    #[test]
    fn every_cell_is_what_its_own_centre_says() {
        let center = Point3::new(0.1, 0.0, 0.2);
        let space = FreeSpace::new(&center, [0.1, 0.51], 0.025, &room_m);
        let mut free = 0;
        for cell in 0..space.free.len() {
            let p = space.center(cell);
            let wanted = room_m(&p) > 0.0 && (p - center).norm() <= 0.51 && (p - center).norm() > 0.1;
            assert_eq!(space.free[cell], wanted, "{p}");
            assert_eq!(space.cell(&p), Some(cell));
            free += usize::from(wanted);
        }
        assert_eq!(space.free_cells(), free);
        assert!(free > 10_000);
    }

    #[test]
    fn costs_are_those_of_relaxing_every_cell_until_nothing_changes() {
        let space = FreeSpace::new(&Point3::new(0.1, 0.0, 0.2), [0.0, 0.4], 0.05, &room_m);
        let source = space.free_cell_near(&Point3::new(0.0, 0.2, 0.2)).unwrap();
        // The other side of the pillar, the most expensive place to stop at.
        let until = space.free_cell_near(&Point3::new(0.4, -0.2, 0.1)).unwrap();
        let costs = space.costs_from(source, until);
        let mut slow = vec![FAR; space.free.len()];
        slow[source] = 0;
        let mut changed = true;
        while std::mem::take(&mut changed) {
            for cell in (0..slow.len()).filter(|&cell| space.free[cell]) {
                for (offset, step) in space.neighbours() {
                    let other = cell.wrapping_add_signed(offset);
                    if space.free[other] && slow[other] != FAR && slow[other] + step < slow[cell] {
                        slow[cell] = slow[other] + step;
                        changed = true;
                    }
                }
            }
        }
        assert!(slow[until] > 100 && costs[until] == slow[until]);
        for (fast, slow) in costs.iter().zip(&slow) {
            // Beyond twice the cost of the goal nothing was asked for.
            assert!(fast == slow || *slow > 2 * costs[until], "{fast} against {slow}");
        }
        let way = space.descend(&costs, until);
        assert_eq!((way[0], way[way.len() - 1]), (until, source));
        assert!(way.iter().all(|&cell| space.free[cell]));
    }

    #[test]
    fn a_line_that_is_proven_is_free_at_every_millimetre() {
        let space = FreeSpace::new(&Point3::new(0.1, 0.0, 0.2), [0.0, 0.5], 0.025, &room_m);
        let mut rng = Rng::new(3, 0);
        let (mut seen, mut hidden) = (0, 0);
        for _ in 0..400 {
            let mut draw = || Point3::new(rng.uniform(-0.2, 0.5), rng.uniform(-0.3, 0.3), rng.uniform(0.0, 0.5));
            let (a, b) = (draw(), draw());
            let least = (0..=1000).map(|k| room_m(&(a + (b - a) * (f64::from(k) * 1e-3)))).fold(f64::MAX, f64::min);
            if space.sees(&a, &b) {
                seen += 1;
                assert!(least > 0.0, "{least}");
            } else {
                hidden += 1;
                assert!(least < 2e-3, "{least}");
            }
        }
        assert!(seen > 50 && hidden > 50, "{seen} {hidden}");
    }
}
