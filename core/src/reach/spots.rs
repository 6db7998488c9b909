//! Where in a voxel, and turned by how much, its poses are sought.

use nalgebra::{Unit, UnitQuaternion, Vector3};

/// Points of a voxel, in edges from its centre: the centre, or near a corner.
pub(super) const POINTS: [[f64; 3]; 9] = {
    const C: f64 = 0.45;
    [
        [0.0, 0.0, 0.0],
        [-C, -C, -C],
        [C, -C, -C],
        [-C, C, -C],
        [C, C, -C],
        [-C, -C, C],
        [C, -C, C],
        [-C, C, C],
        [C, C, C],
    ]
};

/// Axes about which all orientations of a voxel are turned when none of them is reached as it is.
const AXES: [[f64; 3]; 14] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0],
    [-1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [1.0, -1.0, -1.0],
    [-1.0, -1.0, -1.0],
];

/// Points of a voxel × turns of its orientations, by number; the turn is 0, or one about [`AXES`] that is smaller than
/// half of the least angle between two orientations of the set: so a turned one is nearest to itself. The order is part
/// of the file format.
#[derive(Clone, Debug)]
pub(super) struct Spots {
    turns: Vec<UnitQuaternion<f64>>,
}

impl Spots {
    pub(super) const COUNT: usize = POINTS.len() * (1 + AXES.len());

    /// For a set of so many orientations.
    pub(super) fn new(orientations: usize) -> Self {
        // The least angles of the sets are 60° and 27.8°.
        let angle = if orientations <= 40 { 25.0_f64.to_radians() } else { 12.0_f64.to_radians() };
        let turn = |axis: &[f64; 3]| {
            // Not zero: every axis has a component.
            let axis = Unit::try_new(Vector3::from(*axis), 1e-9).unwrap_or(Vector3::x_axis());
            let (sin, cos) = crate::math::sin_cos(0.5 * angle);
            let v = axis.into_inner() * sin;
            UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cos, v.x, v.y, v.z))
        };
        Self { turns: std::iter::once(UnitQuaternion::identity()).chain(AXES.iter().map(turn)).collect() }
    }

    /// The point of a spot, in edges from the centre, and the turn of its orientations.
    pub(super) fn of(&self, spot: u8) -> ([f64; 3], UnitQuaternion<f64>) {
        let (turn, point) = (usize::from(spot) / POINTS.len(), usize::from(spot) % POINTS.len());
        (POINTS[point], self.turns.get(turn).copied().unwrap_or_default())
    }

    /// The spots of each turn, none first.
    pub(super) fn by_turn() -> impl Iterator<Item = std::ops::Range<u8>> {
        let points = POINTS.len() as u8;
        (0..Self::COUNT as u8).step_by(POINTS.len()).map(move |first| first..first + points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reach::Orientations;

    #[test]
    fn a_turned_orientation_is_nearest_to_itself() {
        for count in [40, 272] {
            let (set, spots) = (Orientations::new(count).unwrap(), Spots::new(count));
            let mut seen = 0;
            for spot in Spots::by_turn().flatten() {
                let turn = spots.of(spot).1;
                for (number, rotation) in set.rotations().iter().enumerate() {
                    assert_eq!(set.nearest(&(turn * rotation)), number);
                }
                seen += 1;
            }
            assert_eq!(seen, Spots::COUNT);
        }
    }
}
