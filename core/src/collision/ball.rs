//! A ball alone, placed somewhere: how much room there is for a hand before its rotation is known.

use nalgebra::{Matrix3, Point3, Vector3};

use super::build::squared_distance_to_box;
use super::frames::Rigid;
use super::narrow::signed_distance;
use super::solid::{Core, Solid};
use super::world::World;

/// Distances of a ball to the obstacles of a world, for many places.
#[derive(Clone, Debug)]
pub struct BallChecker {
    ball: Solid,
    /// Bodies with the corners of the boxes around them.
    obstacles: Vec<(Solid, Vector3<f64>, Vector3<f64>)>,
}

impl BallChecker {
    /// A ball of this radius, metres, among all obstacles.
    pub fn new(world: &World, radius_m: f64) -> Self {
        let point = Core::Segment { a: Vector3::zeros(), b: Vector3::zeros() };
        let obstacles = world.obstacles.iter().map(|obstacle| {
            let (lower, upper) = obstacle.solid_W.aabb();
            (obstacle.solid_W.clone(), lower, upper)
        });
        Self {
            ball: Solid::new(point, radius_m.max(0.0), &nalgebra::Isometry3::identity()),
            obstacles: obstacles.collect(),
        }
    }

    /// Distance between the ball with its centre at `p_W` and the nearest obstacle, metres; negative is a depth, infinity
    /// means that there is nothing to meet. It changes by at most as much as the ball is moved.
    pub fn clearance_m(&self, p_W: &Point3<f64>) -> f64 {
        let X_WB = Rigid { R: Matrix3::identity(), t: p_W.coords };
        let mut least = f64::INFINITY;
        for (solid, lower, upper) in &self.obstacles {
            let reach = least + self.ball.radius;
            // A place that is not finite is far from everything instead of reaching GJK.
            if reach >= 0.0 && squared_distance_to_box(&p_W.coords, lower, upper) <= reach * reach && p_W.x.is_finite()
            {
                least = least.min(signed_distance(&self.ball, &X_WB, solid, &Rigid::identity()));
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;

    #[test]
    fn a_ball_is_as_far_from_box_and_can_as_geometry_says() {
        let mut world = World::new();
        world.add_box("box", Vector3::new(0.2, 0.2, 0.2), &Isometry3::translation(0.0, 0.0, 0.1)).unwrap();
        world.add_cylinder("can", 0.05, 0.2, &Isometry3::translation(0.5, 0.0, 0.1)).unwrap();
        let ball = BallChecker::new(&world, 0.03);
        let near = |p: [f64; 3], wanted: f64| {
            let found = ball.clearance_m(&Point3::from(p));
            assert!((found - wanted).abs() < 1e-6, "{found} at {p:?}, wanted {wanted}");
        };
        near([0.2, 0.0, 0.1], 0.07);
        near([0.4, 0.0, 0.1], 0.02);
        near([0.13, 0.14, 0.1], 0.02);
        near([0.08, 0.0, 0.1], -0.05);
        assert_eq!(BallChecker::new(&World::new(), 0.03).clearance_m(&Point3::origin()), f64::INFINITY);
    }
}
