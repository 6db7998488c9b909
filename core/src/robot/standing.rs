//! How high a robot's root is when it stands on the floor in some posture: on its feet, on its knees, on a stool.

use nalgebra::{Isometry3, Vector3};

use super::{CollisionBody, Geometry, Robot};

impl Robot {
    /// Height of the root above the floor when the lowest point of the robot's bodies rests on it, metres; z of the root
    /// is up. Negative for a robot that kneels while its root is at the height of the soles of straight legs.
    ///
    /// Exact for primitives and for the hulls of meshes; 0 for a robot without bodies.
    ///
    /// * `q`: one value per degree of freedom, radians or metres.
    pub fn standing_height_m(&self, q: &[f64]) -> f64 {
        let X_BL = self.link_poses(q);
        let bodies = self.links.iter().zip(&X_BL);
        let lowest_m = bodies
            .flat_map(|(link, X_BL)| link.collisions.iter().map(|body| lowest_m(body, X_BL)))
            .fold(f64::INFINITY, f64::min);
        if lowest_m.is_finite() { -lowest_m } else { 0.0 }
    }
}

/// z of the lowest point of a body, metres.
fn lowest_m(body: &CollisionBody, X_BL: &Isometry3<f64>) -> f64 {
    let X_BC = X_BL * body.X_LC;
    // The vertical, seen from the body.
    let up = X_BC.rotation.inverse() * Vector3::z();
    let depth_m = match &body.geometry {
        Geometry::Sphere { radius_m } => *radius_m,
        Geometry::Capsule { radius_m, length_m } => radius_m + 0.5 * length_m * up.z.abs(),
        Geometry::Cylinder { radius_m, length_m } => {
            radius_m * (up.x * up.x + up.y * up.y).sqrt() + 0.5 * length_m * up.z.abs()
        }
        Geometry::Box { size_m } => 0.5 * size_m.dot(&up.abs()),
        Geometry::Mesh { mesh, .. } => {
            mesh.positions.iter().map(|p| -up.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max)
        }
    };
    X_BC.translation.z - depth_m
}

#[cfg(test)]
mod tests {
    use crate::robot::{read_urdf, samples};

    #[test]
    fn the_lowest_point_of_each_shape_is_on_the_floor() {
        // Tilted by 30° about y: sin 1/2, cos √3/2.
        let tilted = |shape: &str| {
            let urdf = format!(
                "<robot name='r'><link name='base'/><link name='body'><collision><geometry>{shape}</geometry></collision></link>
                 <joint name='tilt' type='revolute'><parent link='base'/><child link='body'/><origin xyz='0 0 1'/>
                 <axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint></robot>"
            );
            read_urdf(&urdf, &|_| None).unwrap().value.standing_height_m(&[std::f64::consts::FRAC_PI_6])
        };
        let cos = 0.75_f64.sqrt();
        for (shape, wanted) in [
            ("<sphere radius='0.1'/>", 0.1),
            ("<capsule radius='0.1' length='0.4'/>", 0.1 + 0.2 * cos),
            ("<cylinder radius='0.1' length='0.4'/>", 0.1 * 0.5 + 0.2 * cos),
            ("<box size='0.2 0.6 0.4'/>", 0.1 * 0.5 + 0.2 * cos),
        ] {
            assert!((tilted(shape) - (wanted - 1.0)).abs() < 1e-12, "{shape}: {}", tilted(shape));
        }
    }

    #[test]
    fn receivers_have_their_shoulders_at_the_published_heights() {
        let hubo = samples::hubo();
        let human = samples::human();
        // Heights of the shoulder line: sums of the published lengths; kneeling with a knee of half thickness 5.5 cm (Hubo)
        // and 5 cm (human); a person who sits has the hips as high as the knees, 0.507 m below the shoulders.
        for (robot, posture, wanted) in [
            (&hubo, "standing", 1.064),
            (&hubo, "kneeling", 0.724),
            (&human, "standing", 1.439),
            (&human, "kneeling", 0.988),
            (&human, "sitting", 1.008),
        ] {
            let q = robot.posture(posture).unwrap();
            let shoulder = robot.link_index("left_arm_1").unwrap();
            let height_m = robot.standing_height_m(q) + robot.link_poses(q)[shoulder].translation.z;
            assert!((height_m - wanted).abs() < 1e-3, "{} {posture}: {height_m}", robot.name);
        }
    }
}
