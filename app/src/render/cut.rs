//! A plane that takes away what lies on one side of it, to look into things.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// A plane across an axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// x, y or z.
    pub axis: usize,
    /// Where it crosses the axis, metres.
    pub at_m: f64,
    /// Whether what has larger coordinates stays; else what has smaller ones.
    pub keeps_above: bool,
}

impl Cut {
    /// Whether a point in the world stays.
    pub fn keeps(&self, p_W: &Point3<f64>) -> bool {
        (p_W[self.axis.min(2)] >= self.at_m) == self.keeps_above
    }

    /// Normal and offset: what stays has `n · p + d >= 0`, relative to the scene centre. Without a cut everything does.
    pub(super) fn plane(cut: Option<Self>, scene_center: &Point3<f64>) -> [f32; 4] {
        let Some(Self { axis, at_m, keeps_above }) = cut else { return [0.0, 0.0, 0.0, 1.0] };
        let mut normal = Vector3::zeros();
        normal[axis.min(2)] = if keeps_above { 1.0 } else { -1.0 };
        let offset = normal.dot(&scene_center.coords) - at_m * normal[axis.min(2)];
        [normal.x as f32, normal.y as f32, normal.z as f32, offset as f32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_and_the_points_agree_on_what_stays() {
        let center = Point3::new(64.0, -64.0, 0.0);
        for (axis, keeps_above) in [(0, true), (0, false), (1, true), (2, false)] {
            let cut = Cut { axis, at_m: 0.4, keeps_above };
            let [x, y, z, d] = Cut::plane(Some(cut), &center).map(f64::from);
            for value in [-1.0, 0.1, 0.39, 0.41, 2.0] {
                let p_W = Point3::new(value, value, value);
                let side = Vector3::new(x, y, z).dot(&(p_W - center)) + d;
                assert_eq!(side >= 0.0, cut.keeps(&p_W), "{cut:?} at {value}");
            }
        }
    }
}
