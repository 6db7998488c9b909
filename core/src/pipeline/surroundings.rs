//! What a robot meets in a posture that somebody puts it into by hand.

use nalgebra::Point3;

use super::handover::add_surroundings;
use super::rank::{add_fit, furniture, obstacles, refusal};
use crate::collision::{Checker, Clearance, CollisionModel, Hit, Scratch, World};
use crate::job::{FitOutput, Refusal};
use crate::robot::Robot;
use crate::scene::Scene;
use crate::task::{TARGET, WorkcellError};

/// What the camera saw in a scene.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// A fit of every cluster.
    pub fits: &'a FitOutput,
    /// The points of every cluster in the world, metres.
    pub clusters: &'a [Vec<Point3<f64>>],
    /// Whether the cloud was brought by a person, so that the scene's own objects and boxes do not count.
    pub is_dropped: bool,
}

/// A robot among everything that stands in a scene, ready to be asked about posture after posture.
#[derive(Clone, Debug)]
pub struct Surroundings {
    checker: Checker,
    scratch: Scratch,
}

/// What a posture meets, and how near it comes to everything else.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    /// All touching pairs.
    pub hits: Vec<Hit>,
    /// The smallest distance between any two that must not touch.
    pub clearance: Clearance,
}

impl Surroundings {
    /// The robot of a scene before its table, its boxes and, once the camera has looked, everything that was fitted.
    ///
    /// # Errors
    /// [`Refusal`] naming the body that makes no sense.
    pub fn of(scene: &Scene, robot: &Robot, seen: Option<Seen<'_>>) -> Result<Self, Refusal> {
        let mut world = world(scene, seen).map_err(|error| refusal(&error))?;
        add_surroundings(&mut world, scene)?;
        let build = || {
            let model = CollisionModel::new(robot)?;
            Checker::whole(&model, &world, None, &[])
        };
        let checker = build().map_err(|error| refusal(&error))?;
        Ok(Self { checker, scratch: Scratch::default() })
    }

    /// What a posture meets.
    ///
    /// * `q`: one value per degree of freedom of the robot, radians or metres.
    pub fn meets(&mut self, q: &[f64]) -> Meeting {
        let hits = self.checker.all_hits(&mut self.scratch, q);
        Meeting { hits, clearance: self.checker.distance(&mut self.scratch, q) }
    }
}

fn world(scene: &Scene, seen: Option<Seen<'_>>) -> Result<World, WorkcellError> {
    let Some(Seen { fits, clusters, is_dropped }) = seen else { return furniture(scene, false) };
    let mut world = obstacles(scene, fits, clusters, is_dropped)?;
    if let Some(Ok(target)) = fits.fits.get(fits.target) {
        add_fit(&mut world, TARGET, target)?;
    }
    Ok(world)
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::robot::samples;
    use crate::scene::Obstacle;

    #[test]
    fn a_box_in_the_hand_is_met_and_one_beside_it_gives_the_clearance() {
        let robot = samples::alita();
        let mut scene = Scene::parse(include_str!("../../../objects/scenes/mustard.json")).unwrap();
        let q = robot.posture("table_ready").unwrap();
        let free = Surroundings::of(&scene, &robot, None).unwrap().meets(q);
        assert_eq!(free.hits, Vec::new());
        assert!(free.clearance.distance_m > 0.0);
        let palm = &robot.arms[0].hand;
        let X_WB = Isometry3::from(robot.link_poses(q)[palm.palm_link].translation);
        scene.obstacles.push(Obstacle { name: "brick".into(), size_m: nalgebra::Vector3::repeat(0.05), X_WB });
        let met = Surroundings::of(&scene, &robot, None).unwrap().meets(q);
        assert!(met.hits.iter().any(|hit| hit.b == "brick"), "{:?}", met.hits);
        assert!(met.clearance.distance_m < 0.0);
    }
}
