//! Convex hulls that answer quickly which of their corners is farthest in a direction.
//!
//! GJK asks that question some ten times per pair. A hull of a fit has hundreds of corners; instead of looking at all
//! of them, the search starts at the corner that is farthest in a nearby direction, looked up in a small table, and
//! climbs along edges. On a convex body every climb ends at the top.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use super::cover::{Capsule, Cuboid, box_around, hull_cover};
use super::model::CollisionError;
use super::parry::hull_of;

/// Cells along each edge of the cube of directions that the table divides.
const CELLS: usize = 4;
/// With fewer corners than this, looking at all of them is as quick.
const FEW: usize = 12;

/// The convex hull of points, in the frame that they were given in; cheap to clone.
#[derive(Clone, Debug)]
pub struct ConvexHull(Arc<Hull>);

#[derive(Debug)]
struct Hull {
    corners: Vec<Vector3<f64>>,
    /// Corners at the other ends of the edges of each corner: `neighbours[first[k]..first[k + 1]]`.
    neighbours: Vec<u32>,
    first: Vec<u32>,
    /// For each cell of the cube of directions, the farthest corner in its middle.
    starts: Vec<u32>,
    center: Vector3<f64>,
    bound: f64,
    around: Cuboid,
    capsules: Vec<Capsule>,
}

impl ConvexHull {
    /// The hull of points that must be finite and span a volume, metres; errors call it `thing`.
    ///
    /// # Errors
    /// [`CollisionError::PointNotFinite`] or [`CollisionError::NoVolume`].
    pub fn new(thing: &str, points: &[Point3<f64>]) -> Result<Self, CollisionError> {
        if let Some(index) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(CollisionError::PointNotFinite { thing: thing.to_owned(), index });
        }
        let points: Vec<Vector3<f64>> = points.iter().map(|p| p.coords).collect();
        let (corners, triangles) = hull_of(&points)
            .ok_or_else(|| CollisionError::NoVolume { thing: thing.to_owned(), points: points.len() })?;
        let mut edges: Vec<(u32, u32)> =
            triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]).collect();
        edges.sort_unstable();
        edges.dedup();
        let count = corners.len() as u32;
        let first = (0..=count).map(|corner| edges.partition_point(|&(from, _)| from < corner) as u32).collect();
        let lower = corners.iter().fold(Vector3::repeat(f64::INFINITY), |m, p| m.inf(p));
        let upper = corners.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |m, p| m.sup(p));
        let center = 0.5 * (lower + upper);
        let bound = corners.iter().map(|p| (p - center).norm()).fold(0.0, f64::max);
        let around = box_around(&corners);
        let capsules = hull_cover(&corners, &edges, &around);
        let mut hull = Hull {
            corners,
            neighbours: edges.into_iter().map(|(_, to)| to).collect(),
            first,
            starts: Vec::new(),
            center,
            bound,
            around,
            capsules,
        };
        if hull.corners.len() >= FEW {
            hull.starts = (0..6 * CELLS * CELLS).map(|cell| hull.farthest(&middle(cell)) as u32).collect();
        }
        Ok(Self(Arc::new(hull)))
    }

    /// Its corners.
    pub fn corners(&self) -> &[Vector3<f64>] {
        &self.0.corners
    }

    /// Centre and radius of a ball around it, metres.
    pub(crate) fn ball(&self) -> (Vector3<f64>, f64) {
        (self.0.center, self.0.bound)
    }

    /// A box around it.
    pub(crate) fn box_around(&self) -> &Cuboid {
        &self.0.around
    }

    /// Capsules that together hold it.
    pub(crate) fn capsules(&self) -> &[Capsule] {
        &self.0.capsules
    }

    /// The corner that is farthest in a direction, which need not have unit length.
    #[inline]
    pub(crate) fn support(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let hull = &*self.0;
        let at = match hull.starts.get(cell(direction)) {
            Some(&start) => hull.climb(start as usize, direction),
            None => hull.farthest(direction),
        };
        hull.corners[at]
    }
}

impl Hull {
    fn farthest(&self, direction: &Vector3<f64>) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for (index, corner) in self.corners.iter().enumerate() {
            let reach = corner.dot(direction);
            if reach > best.1 {
                best = (index, reach);
            }
        }
        best.0
    }

    /// Follows edges upwards until no neighbour is farther.
    fn climb(&self, start: usize, direction: &Vector3<f64>) -> usize {
        let mut best = (start, self.corners[start].dot(direction));
        loop {
            let at = best.0;
            for &next in &self.neighbours[self.first[at] as usize..self.first[at + 1] as usize] {
                let reach = self.corners[next as usize].dot(direction);
                if reach > best.1 {
                    best = (next as usize, reach);
                }
            }
            if best.0 == at {
                return at;
            }
        }
    }
}

/// The cell of the cube of directions that a direction points into; some cell for a direction of length 0.
#[inline]
fn cell(direction: &Vector3<f64>) -> usize {
    let size = direction.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let main = direction[axis];
    let scale = 0.5 * CELLS as f64 / size[axis].max(f64::MIN_POSITIVE);
    // Casting truncates towards zero and turns what is not a number into 0.
    let along = |x: f64| ((x * scale + 0.5 * CELLS as f64) as usize).min(CELLS - 1);
    let (u, v) = (along(direction[(axis + 1) % 3]), along(direction[(axis + 2) % 3]));
    ((2 * axis + usize::from(main < 0.0)) * CELLS + u) * CELLS + v
}

/// The direction in the middle of a cell.
fn middle(cell: usize) -> Vector3<f64> {
    let (face, u, v) = (cell / (CELLS * CELLS), cell / CELLS % CELLS, cell % CELLS);
    let along = |k: usize| (k as f64 + 0.5) * 2.0 / CELLS as f64 - 1.0;
    let mut direction = Vector3::zeros();
    let axis = face / 2;
    direction[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
    direction[(axis + 1) % 3] = along(u);
    direction[(axis + 2) % 3] = along(v);
    direction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::superquadric::Superquadric;
    use nalgebra::Isometry3;

    #[test]
    fn the_climb_finds_what_looking_at_every_corner_finds() {
        let mut rng = Rng::new(3, 0);
        for round in 0..40 {
            // Boxes with many corners in one plane, cans, balls and loose points.
            let points: Vec<Point3<f64>> = if round % 4 == 3 {
                (0..60).map(|_| Point3::from(rng.direction() * rng.uniform(0.05, 0.2))).collect()
            } else {
                let e = [0.1, 0.5, 1.0][round % 3];
                let mut axis = || rng.uniform(0.01, 0.2);
                let shape = Superquadric::new(axis(), axis(), axis(), e, 1.0, Isometry3::identity()).unwrap();
                shape.convex_pieces_in_axes(4).remove(0)
            };
            let hull = ConvexHull::new("body", &points).unwrap();
            for _ in 0..500 {
                let direction = rng.direction() * rng.uniform(0.1, 3.0);
                let found = hull.support(&direction).dot(&direction);
                let best = points.iter().map(|p| p.coords.dot(&direction)).fold(f64::NEG_INFINITY, f64::max);
                // The hull may leave out points that stand out of it by less than round-off of its own test.
                assert!((found - best).abs() < 1e-9, "round {round}: {found} against {best}");
            }
        }
    }

    #[test]
    fn the_middle_of_every_cell_is_in_it_and_odd_directions_are_in_some() {
        for index in 0..6 * CELLS * CELLS {
            assert_eq!(cell(&middle(index)), index);
        }
        for odd in [Vector3::zeros(), Vector3::repeat(f64::NAN), Vector3::repeat(f64::INFINITY)] {
            assert!(cell(&odd) < 6 * CELLS * CELLS);
        }
    }
}
