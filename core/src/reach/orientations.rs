//! Sets of rotations spread over SO(3): lattice points of the boundary of a cube in the space of quaternions.

use nalgebra::{Quaternion, UnitQuaternion};

/// Rotations that stand for all others: 1 (any rotation), 40 or 272 of them.
///
/// The points of the boundary of `{-k..k}⁴` in quaternion space, scaled to length 1, opposite ones counted once: 40 for
/// k = 1, 272 for k = 2. They are sorted by `(w, x, y, z)`, the first component that is not 0 being positive. No
/// rotation is farther than 61° (k = 1) or 41° (k = 2) from its nearest one.
#[derive(Clone, Debug, PartialEq)]
pub struct Orientations {
    k: i32,
    rotations: Vec<UnitQuaternion<f64>>,
    /// Lattice points with `w ≥ x ≥ y ≥ z ≥ 0`, and their unit vectors: all others are these, permuted and with signs.
    shapes: Vec<([i32; 4], [f64; 4])>,
    /// Number of the rotation for each point of the whole cube.
    numbers: Vec<u16>,
}

impl Orientations {
    /// The sizes that there are.
    pub const COUNTS: [usize; 3] = [1, 40, 272];

    /// The set of this size; `None` unless it is one of [`Orientations::COUNTS`].
    pub fn new(count: usize) -> Option<Self> {
        let k = Self::COUNTS.iter().position(|known| *known == count)? as i32;
        let width = 2 * k + 1;
        let mut set = Self {
            k,
            rotations: Vec::with_capacity(count),
            shapes: Vec::new(),
            numbers: vec![0; width.pow(4) as usize],
        };
        if k == 0 {
            set.rotations.push(UnitQuaternion::identity());
            return Some(set);
        }
        for place in 0..width.pow(4) {
            let c: [i32; 4] = std::array::from_fn(|axis| place / width.pow(3 - axis as u32) % width - k);
            let is_on_boundary = c.iter().any(|c| c.abs() == k);
            if !is_on_boundary || c.iter().find(|c| **c != 0).is_some_and(|first| *first < 0) {
                continue;
            }
            let number = set.rotations.len() as u16;
            let (here, opposite) = (set.place(&c), set.place(&c.map(|c| -c)));
            set.numbers[here] = number;
            set.numbers[opposite] = number;
            let [w, x, y, z] = c.map(f64::from);
            set.rotations.push(UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)));
            if c.windows(2).all(|pair| pair[0] >= pair[1]) && c[3] >= 0 {
                let length = (w * w + x * x + y * y + z * z).sqrt();
                set.shapes.push((c, [w, x, y, z].map(|c| c / length)));
            }
        }
        Some(set)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.rotations.len()
    }

    /// The rotations, by number.
    pub fn rotations(&self) -> &[UnitQuaternion<f64>] {
        &self.rotations
    }

    /// Number of the rotation that is nearest to this one.
    pub fn nearest(&self, rotation: &UnitQuaternion<f64>) -> usize {
        let q = rotation.quaternion();
        self.nearest_to([q.w, q.i, q.j, q.k])
    }

    /// As [`Orientations::nearest`], for a quaternion `[w, x, y, z]` of any length.
    #[inline]
    pub(super) fn nearest_to(&self, q: [f64; 4]) -> usize {
        if self.k == 0 {
            return 0;
        }
        // A product of two vectors of given components is largest when both are in the same order and of equal signs.
        // Without branches: how many components are larger, or equal and earlier.
        let size = q.map(f64::abs);
        let rank: [usize; 4] = std::array::from_fn(|i| {
            let is_before = |j: usize| if j < i { size[j] >= size[i] } else { size[j] > size[i] };
            (0..4).map(|j| usize::from(is_before(j))).sum()
        });
        let mut sorted = [0.0; 4];
        (0..4).for_each(|axis| sorted[rank[axis] & 3] = size[axis]);
        let (mut best, mut most) = (0, f64::NEG_INFINITY);
        for (number, (_, unit)) in self.shapes.iter().enumerate() {
            let cosine = sorted[0] * unit[0] + sorted[1] * unit[1] + sorted[2] * unit[2] + sorted[3] * unit[3];
            best = if cosine > most { number } else { best };
            most = most.max(cosine);
        }
        let shape = &self.shapes[best].0;
        let c: [i32; 4] = std::array::from_fn(|axis| {
            let size = shape[rank[axis] & 3];
            if q[axis] < 0.0 { -size } else { size }
        });
        usize::from(self.numbers[self.place(&c)])
    }

    #[inline]
    fn place(&self, c: &[i32; 4]) -> usize {
        let width = 2 * self.k + 1;
        c.iter().fold(0, |place, c| place * width + c + self.k) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn the_sets_have_their_sizes_and_no_rotation_twice() {
        for count in Orientations::COUNTS {
            let set = Orientations::new(count).unwrap();
            assert_eq!(set.count(), count);
            for (i, a) in set.rotations().iter().enumerate() {
                assert_eq!(set.nearest(a), i);
                assert!(set.rotations()[..i].iter().all(|b| a.angle_to(b) > 0.3));
            }
        }
        assert!(Orientations::new(41).is_none());
    }

    #[test]
    fn the_nearest_rotation_is_that_of_a_loop_over_all() {
        let mut rng = Rng::new(4, 0);
        for (count, farthest_deg) in [(40, 61.0), (272, 41.0)] {
            let set = Orientations::new(count).unwrap();
            let mut worst = 0.0_f64;
            for _ in 0..20_000 {
                let rotation = rng.rotation();
                let angles = set.rotations().iter().map(|known| known.angle_to(&rotation));
                let least = angles.fold(f64::INFINITY, f64::min);
                let found = set.rotations()[set.nearest(&rotation)].angle_to(&rotation);
                // Two that are equally near may change places by round-off of an arc cosine.
                assert!(found - least < 1e-7, "{found} {least}");
                worst = worst.max(least);
            }
            assert!(worst.to_degrees() < farthest_deg && worst.to_degrees() > 0.8 * farthest_deg, "{worst}");
        }
    }

    #[test]
    fn the_order_of_the_set_is_part_of_the_file_format() {
        let set = Orientations::new(40).unwrap();
        // (0, 0, 0, 1) is the half turn about z, (1, 0, 0, 0) the middle of the 27 with w = 1 after 13 with w = 0.
        assert_eq!(set.nearest(&UnitQuaternion::from_quaternion(Quaternion::new(0.0, 0.0, 0.0, 1.0))), 0);
        assert_eq!(set.nearest(&UnitQuaternion::identity()), 26);
    }
}
