//! What a body that stands somewhere touches, robot or no robot.

use nalgebra::Isometry3;

use super::frames::Rigid;
use super::hull::ConvexHull;
use super::narrow::signed_distance;
use super::solid::{Core, Solid};
use super::world::World;

impl World {
    /// Signed distance from a hull in its frame O, standing at `X_WO`, to every obstacle nearer than `within_m`:
    /// name and metres, nearest (or deepest) first.
    pub fn near_hull(&self, hull_O: &ConvexHull, X_WO: &Isometry3<f64>, within_m: f64) -> Vec<(String, f64)> {
        let solid = Solid::new(Core::Hull(hull_O.clone()), 0.0, X_WO);
        let world = Rigid::identity();
        let mut near: Vec<(String, f64)> = self
            .obstacles
            .iter()
            .map(|o| (o.name.clone(), signed_distance(&solid, &world, &o.solid_W, &world)))
            .filter(|(_, distance_m)| *distance_m < within_m)
            .collect();
        near.sort_by(|l, r| l.1.total_cmp(&r.1).then_with(|| l.0.cmp(&r.0)));
        near
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    #[test]
    fn a_cube_near_a_table_is_that_far_from_it_and_from_nothing_else() {
        let mut world = World::new();
        let slab = Isometry3::translation(0.0, 0.0, -0.02);
        world.add_box("table", Vector3::new(1.0, 1.0, 0.04), &slab).unwrap();
        world.add_box("far", Vector3::repeat(0.1), &Isometry3::translation(0.4, 0.0, 0.05)).unwrap();
        let corner = |k: u32, bit: u32| if k & bit == 0 { -0.05 } else { 0.05 };
        let cube: Vec<_> = (0..8).map(|k| Point3::new(corner(k, 1), corner(k, 2), corner(k, 4))).collect();
        let cube = ConvexHull::new("cube", &cube).unwrap();
        for height in [0.055, 0.05, 0.045] {
            let near = world.near_hull(&cube, &Isometry3::translation(0.0, 0.0, height), 0.01);
            assert_eq!(near.len(), 1);
            assert!(near[0].0 == "table" && (near[0].1 - (height - 0.05)).abs() < 1e-4, "{near:?} at {height}");
        }
    }
}
