//! The outline of a table: the convex hull of where its plane is covered with points.

use nalgebra::{Point2, Point3, Vector3};

use super::Plane;

/// Least edge of the cells in which coverage is counted, metres.
const CELL_M: f64 = 0.02;
/// At most so many cells per axis, so that thousands of sampled points still cover a table without gaps.
const MAX_CELLS: f64 = 64.0;
/// Patches with less than this part of the points of the largest patch are not table: the strip where the plane cuts a
/// wall or a chair.
const PATCH_PART: f64 = 0.1;

/// A convex outline in a plane.
pub(super) struct Outline {
    origin: Point3<f64>,
    u: Vector3<f64>,
    v: Vector3<f64>,
    /// Corners, counter-clockwise seen from the side of the normal.
    corners: Vec<Point2<f64>>,
    /// Inward half-planes `a x + b y >= c` of the edges.
    edges: Vec<[f64; 3]>,
    /// Cells that lie inside as a whole, so that most points need no look at the edges.
    inner: InnerCells,
}

/// A coarse grid over the outline.
struct InnerCells {
    least: Point2<f64>,
    cells_per_m: nalgebra::Vector2<f64>,
    inside: Vec<bool>,
}

impl InnerCells {
    /// Cells per axis.
    const COUNT: usize = 64;

    fn new(corners: &[Point2<f64>], edges: &[[f64; 3]]) -> Option<Self> {
        let first = corners.first()?;
        let (least, most) = corners.iter().fold((*first, *first), |(least, most), p| (least.inf(p), most.sup(p)));
        let size = (most - least).map(|extent| extent.max(1e-9) / Self::COUNT as f64);
        let corner_inside: Vec<bool> = (0..=Self::COUNT)
            .flat_map(|row| (0..=Self::COUNT).map(move |column| (column as f64, row as f64)))
            .map(|(column, row)| within(edges, least.x + column * size.x, least.y + row * size.y))
            .collect();
        let at = |column: usize, row: usize| corner_inside.get(row * (Self::COUNT + 1) + column) == Some(&true);
        let inside = (0..Self::COUNT * Self::COUNT)
            .map(|cell| (cell % Self::COUNT, cell / Self::COUNT))
            // The outline is convex: four corners inside make the whole cell inside.
            .map(|(column, row)| {
                at(column, row) && at(column + 1, row) && at(column, row + 1) && at(column + 1, row + 1)
            })
            .collect();
        Some(Self { least, cells_per_m: size.map(|size| 1.0 / size), inside })
    }

    fn contain(&self, x: f64, y: f64) -> bool {
        let (column, row) = ((x - self.least.x) * self.cells_per_m.x, (y - self.least.y) * self.cells_per_m.y);
        let count = Self::COUNT as f64;
        column >= 0.0
            && row >= 0.0
            && column < count
            && row < count
            && self.inside.get(row as usize * Self::COUNT + column as usize) == Some(&true)
    }
}

fn within(edges: &[[f64; 3]], x: f64, y: f64) -> bool {
    edges.iter().all(|[a, b, c]| a * x + b * y >= *c)
}

impl Outline {
    /// The outline of the points within a distance of the plane, widened by a margin.
    ///
    /// A sample that stands for all points says which patches of the plane belong to the table and gives a first hull;
    /// of all points only those outside that hull are looked at closely. The order of the points does not matter.
    pub(super) fn new(
        plane: &Plane,
        sample: &[Point3<f64>],
        points: &[Point3<f64>],
        distance_m: f64,
        margin_m: f64,
    ) -> Option<Self> {
        let (u, v) = plane.basis();
        let flat = |p: &Point3<f64>| Point2::new(u.dot(&p.coords), v.dot(&p.coords));
        let near = |p: &&Point3<f64>| plane.height(p).abs() <= distance_m;
        let sampled: Vec<Point2<f64>> = sample.iter().filter(near).map(flat).collect();
        let patches = Patches::new(&sampled)?;
        let mut hull = convex_hull(sampled.into_iter().filter(|p| patches.contain(p)).collect());
        let first = InnerCells::new(&hull, &half_planes(&hull, 0.0))?;
        let outside = points.iter().filter(near).map(flat).filter(|p| !first.contain(p.x, p.y) && patches.contain(p));
        hull.extend(outside);
        let corners = convex_hull(hull);
        let edges = half_planes(&corners, margin_m);
        if edges.len() < 3 {
            return None;
        }
        let origin = Point3::from(plane.normal.into_inner() * plane.offset_m);
        Some(Self { origin, u, v, inner: InnerCells::new(&corners, &edges)?, corners, edges })
    }

    /// Whether the foot of a point on the plane lies inside.
    pub(super) fn contains(&self, p: &Point3<f64>) -> bool {
        let (x, y) = (self.u.dot(&p.coords), self.v.dot(&p.coords));
        self.inner.contain(x, y) || within(&self.edges, x, y)
    }

    /// The same outline seen from the other side of the plane: only the order of the corners changes.
    pub(super) fn flip(&mut self) {
        self.corners.reverse();
    }

    /// The corners in the frame of the cloud, without the margin.
    pub(super) fn corners(&self) -> Vec<Point3<f64>> {
        self.corners.iter().map(|c| self.origin + self.u * c.x + self.v * c.y).collect()
    }
}

/// Inward half-planes of a counter-clockwise polygon, moved outward by a margin.
fn half_planes(corners: &[Point2<f64>], margin_m: f64) -> Vec<[f64; 3]> {
    let next = corners.iter().cycle().skip(1);
    (corners.iter().zip(next))
        .filter_map(|(a, b)| {
            let d = (b - a).try_normalize(1e-12)?;
            Some([-d.y, d.x, -d.y * a.x + d.x * a.y - margin_m])
        })
        .collect()
}

/// The cells of the plane that belong to the table: covered ones in large patches, and their neighbours.
struct Patches {
    least: Point2<f64>,
    cell_m: f64,
    columns: usize,
    rows: usize,
    kept: Vec<bool>,
}

impl Patches {
    fn new(sampled: &[Point2<f64>]) -> Option<Self> {
        let first = sampled.first()?;
        let (least, most) = sampled.iter().fold((*first, *first), |(least, most), p| (least.inf(p), most.sup(p)));
        let cell_m = CELL_M.max((most - least).max() / MAX_CELLS);
        // One more cell all around for the neighbours.
        let least = least.map(|x| x - cell_m);
        // Coordinates beyond all measure may not even divide: `min` bounds what comes of them.
        let size = ((most - least) / cell_m).map(|count| count.min(MAX_CELLS + 2.0));
        let (columns, rows) = (size.x as usize + 2, size.y as usize + 2);
        let mut grid = Self { least, cell_m, columns, rows, kept: vec![false; columns * rows] };
        let mut counts = vec![0u32; columns * rows];
        for p in sampled {
            if let Some(count) = grid.cell(p).and_then(|cell| counts.get_mut(cell)) {
                *count += 1;
            }
        }
        let patches = patches(&counts, columns, rows);
        let largest = patches.iter().map(|(points, _)| *points).max()?;
        for (points, cells) in &patches {
            if *points as f64 >= PATCH_PART * largest as f64 {
                for cell in cells {
                    for near in neighbourhood(*cell, 1, columns, rows) {
                        grid.kept[near] = true;
                    }
                }
            }
        }
        Some(grid)
    }

    fn cell(&self, p: &Point2<f64>) -> Option<usize> {
        let at = (p - self.least) / self.cell_m;
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.columns as f64 && at.y < self.rows as f64;
        inside.then(|| at.y as usize * self.columns + at.x as usize)
    }

    fn contain(&self, p: &Point2<f64>) -> bool {
        self.cell(p).is_some_and(|cell| self.kept.get(cell) == Some(&true))
    }
}

/// The cells at most `reach` away along both axes, the cell itself included.
fn neighbourhood(cell: usize, reach: usize, columns: usize, rows: usize) -> impl Iterator<Item = usize> {
    let (column, row) = (cell % columns, cell / columns);
    let across = column.saturating_sub(reach)..=(column + reach).min(columns - 1);
    (row.saturating_sub(reach)..=(row + reach).min(rows - 1))
        .flat_map(move |row| across.clone().map(move |column| row * columns + column))
}

/// Connected patches of covered cells, gaps of one cell allowed: their points and cells.
fn patches(counts: &[u32], columns: usize, rows: usize) -> Vec<(u64, Vec<usize>)> {
    let mut seen = vec![false; counts.len()];
    let mut patches = Vec::new();
    for start in 0..counts.len() {
        if counts[start] == 0 || seen[start] {
            continue;
        }
        seen[start] = true;
        let mut cells = vec![start];
        let mut points = 0u64;
        let mut next = 0;
        while let Some(&cell) = cells.get(next) {
            next += 1;
            points += u64::from(counts[cell]);
            for near in neighbourhood(cell, 2, columns, rows) {
                if counts[near] > 0 && !seen[near] {
                    seen[near] = true;
                    cells.push(near);
                }
            }
        }
        patches.push((points, cells));
    }
    patches
}

/// Corners of the convex hull, counter-clockwise (Andrew 1979).
fn convex_hull(mut points: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    points.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = &Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = Vec::new();
        for p in points {
            while let [.., a, b] = chain.as_slice() {
                if (b - a).perp(&(p - a)) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter());
    hull.extend(half(&mut points.iter().rev()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Unit;

    fn flat_table() -> Plane {
        Plane { normal: Unit::try_new(Vector3::z(), 0.5).unwrap(), offset_m: 0.7 }
    }

    #[test]
    fn a_strip_on_a_wall_does_not_widen_the_table() {
        let grid = |x0: f64, nx: i32, y0: f64, ny: i32| {
            (0..nx * ny).map(move |k| Point3::new(x0 + 0.005 * f64::from(k % nx), y0 + 0.005 * f64::from(k / nx), 0.7))
        };
        // A table of 1 m × 0.6 m, and 0.5 m behind it a strip of 2 cm × 1 m.
        let points = grid(0.0, 201, 0.0, 121).chain(grid(0.0, 201, 1.1, 4));
        let points: Vec<Point3<f64>> = points.collect();
        let sample: Vec<Point3<f64>> = points.iter().step_by(7).copied().collect();
        let outline = Outline::new(&flat_table(), &sample, &points, 0.01, 0.01).unwrap();
        for (x, y, inside) in [(0.5, 0.3, true), (-0.005, 0.3, true), (-0.02, 0.3, false), (0.5, 0.605, true)] {
            assert_eq!(outline.contains(&Point3::new(x, y, 0.9)), inside, "({x}, {y})");
        }
        assert!(!outline.contains(&Point3::new(0.5, 0.8, 0.9)));
        assert!(outline.corners().iter().all(|c| (c.z - 0.7).abs() < 1e-12 && c.y < 0.61));
    }

    #[test]
    fn the_hull_of_a_square_has_four_corners() {
        let points = (0..100).map(|k| Point2::new(f64::from(k % 10), f64::from(k / 10))).collect();
        assert_eq!(convex_hull(points).len(), 4);
        let line: Vec<Point3<f64>> = (0..9).map(|k| Point3::new(f64::from(k), 0.0, 0.7)).collect();
        assert!(Outline::new(&flat_table(), &line, &line, 0.01, 0.01).is_none());
    }
}
