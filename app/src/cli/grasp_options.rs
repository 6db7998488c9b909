//! Options of `grasps`: what is asked for, filtered and ranked by. Whatever is not given stays as the scene has it.

use endcomfort_core::grasp::{ApproachCone, ContactSurface, RankBy, Region, Weights};
use endcomfort_core::scene::Scene;
use nalgebra::{Point3, Vector3};

use super::{Failure, input};

/// Half the opening angle of an approach cone that comes without one, degrees.
const USUAL_CONE_DEG: f64 = 30.0;

#[derive(clap::Args)]
pub(super) struct Options {
    /// Density N of the surface samples: about N²/π candidates per roll and depth.
    #[arg(long, help_heading = "Candidates")]
    density: Option<u32>,
    /// Rolls of the hand about its approach at each sample.
    #[arg(long, help_heading = "Candidates")]
    rolls: Option<u32>,
    /// Stand-off depths at each sample, from the palm to the fingertips.
    #[arg(long, help_heading = "Candidates")]
    depths: Option<u32>,
    /// On what the fingers close: superquadric, cloud or mesh.
    #[arg(long, value_parser = surface, help_heading = "Candidates")]
    surface: Option<ContactSurface>,
    /// Coulomb friction coefficient of every contact.
    #[arg(long, help_heading = "Candidates")]
    friction: Option<f64>,
    /// Poses tried per grasp for its success probability; 0 leaves it out.
    #[arg(long, help_heading = "Candidates")]
    noise_trials: Option<u32>,
    /// Standard deviation of the object's position along each axis, millimetres.
    #[arg(long, help_heading = "Candidates")]
    noise_mm: Option<f64>,
    /// Standard deviation of the object's rotation about each axis, degrees.
    #[arg(long, help_heading = "Candidates")]
    noise_deg: Option<f64>,
    /// Direction in the world in which the hand comes: x,y,z; 0,0,-1 comes from above.
    #[arg(long, value_parser = input::numbers::<3>, allow_hyphen_values = true, help_heading = "Filters")]
    approach: Option<[f64; 3]>,
    /// How far the hand may be off that direction, degrees [default: 30].
    #[arg(long, requires = "approach", help_heading = "Filters")]
    approach_cone: Option<f64>,
    /// Box in the world in which the hand holds the object: its centre x,y,z and half its edges, metres.
    #[arg(long, value_parser = input::numbers::<6>, allow_hyphen_values = true, help_heading = "Filters")]
    region: Option<[f64; 6]>,
    /// The only part of a composite object that may be held; 0 is its main body.
    #[arg(long, help_heading = "Filters")]
    part: Option<usize>,
    /// The hand stays this far from table and neighbours, metres.
    #[arg(long, help_heading = "Filters")]
    clearance: Option<f64>,
    /// Order: goal, start, mean, score, epsilon or random.
    #[arg(long, value_parser = rank_by, help_heading = "Order")]
    rank_by: Option<RankBy>,
    /// Weights of the score, as in m_g_goal=1,success=0.5; what is not named counts nothing.
    #[arg(long, value_delimiter = ',', help_heading = "Order")]
    weights: Option<Vec<String>>,
    /// Arm angles over a full turn at which IK sets are sampled.
    #[arg(long, help_heading = "Order")]
    arm_angles: Option<usize>,
    /// Accepts grasps without looking at straight ways in and out.
    #[arg(long, help_heading = "Order")]
    any_way: bool,
    /// Lets the torso move with the arm.
    #[arg(long, help_heading = "Order")]
    torso: bool,
}

fn surface(text: &str) -> Result<ContactSurface, String> {
    let known = ContactSurface::ALL.map(ContactSurface::name);
    let found = ContactSurface::ALL.into_iter().find(|surface| surface.name() == text);
    found.ok_or_else(|| format!("wanted {}", known.join(", ")))
}

fn rank_by(text: &str) -> Result<RankBy, String> {
    let known = RankBy::ALL.map(RankBy::name);
    let found = RankBy::ALL.into_iter().find(|by| by.name() == text);
    found.ok_or_else(|| format!("wanted {}", known.join(", ")))
}

impl Options {
    /// Puts what was given into a scene and checks every number.
    ///
    /// # Errors
    /// What is wrong, with its place, what was found and what is wanted.
    pub(super) fn apply(&self, mut scene: Scene) -> Result<Scene, Failure> {
        let grasp = &mut scene.grasp;
        set(&mut grasp.density, self.density);
        set(&mut grasp.rolls, self.rolls);
        set(&mut grasp.depths, self.depths);
        set(&mut grasp.surface, self.surface);
        set(&mut grasp.friction, self.friction);
        set(&mut grasp.noise.trials, self.noise_trials);
        set(&mut grasp.noise.position_m, self.noise_mm.map(|mm| 1e-3 * mm));
        set(&mut grasp.noise.rotation_rad, self.noise_deg.map(f64::to_radians));
        if let Some(axis) = self.approach {
            let half_angle_rad = self.approach_cone.unwrap_or(USUAL_CONE_DEG).to_radians();
            grasp.filter.approach = Some(ApproachCone { axis_W: Vector3::from(axis), half_angle_rad });
        }
        if let Some([x, y, z, hx, hy, hz]) = self.region {
            let half_m = Vector3::new(hx, hy, hz);
            grasp.filter.region = Some(Region { center_W: Point3::new(x, y, z), half_m });
        }
        grasp.filter.part = self.part.or(grasp.filter.part);
        set(&mut grasp.filter.min_clearance_m, self.clearance);
        if let Some(pairs) = &self.weights {
            scene.rank.weights = weights(pairs)?;
            scene.rank.by = RankBy::Score;
        }
        set(&mut scene.rank.by, self.rank_by);
        set(&mut scene.rank.arm_angles, self.arm_angles);
        scene.rank.straight_ways &= !self.any_way;
        scene.torso |= self.torso;
        scene.checked().map_err(|error| Failure::new(error.to_string()))
    }
}

fn set<T>(place: &mut T, given: Option<T>) {
    if let Some(value) = given {
        *place = value;
    }
}

/// Weights from `name=number` pairs; those that are not named are 0.
fn weights(pairs: &[String]) -> Result<Weights, Failure> {
    let mut weights =
        Weights { m_g_goal: 0.0, m_g_start: 0.0, ik_count: 0.0, epsilon: 0.0, success: 0.0, clearance: 0.0 };
    for pair in pairs {
        let wrong = |wanted: &str| Failure::new(format!("--weights: found {pair:?}, wanted {wanted}"));
        let (name, number) = pair.split_once('=').ok_or_else(|| wrong("NAME=NUMBER"))?;
        let value: f64 = number.trim().parse().map_err(|_| wrong("a number behind the ="))?;
        match name.trim() {
            "m_g_goal" => weights.m_g_goal = value,
            "m_g_start" => weights.m_g_start = value,
            "ik_count" => weights.ik_count = value,
            "epsilon" => weights.epsilon = value,
            "success" => weights.success = value,
            "clearance" => weights.clearance = value,
            _ => return Err(wrong("one of m_g_goal, m_g_start, ik_count, epsilon, success, clearance")),
        }
    }
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_that_are_not_named_count_nothing_and_wrong_ones_are_named() {
        let given = weights(&["success=0.5".to_owned(), "m_g_goal = 2".to_owned()]).expect("they are right");
        assert_eq!((given.success, given.m_g_goal, given.clearance), (0.5, 2.0, 0.0));
        for (pair, wanted) in [("comfort=1", "one of m_g_goal"), ("success", "NAME=NUMBER"), ("success=x", "a number")]
        {
            let error = weights(&[pair.to_owned()]).expect_err(pair).to_string();
            assert!(error.contains(pair) && error.contains(wanted), "{error}");
        }
    }
}
