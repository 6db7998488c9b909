//! Random pick-and-place cases: an object on the table, and where it shall go.

use nalgebra::{Isometry3, Vector3};

use super::known::{KnownObject, TABLE, scene, turn};
use crate::rng::Rng;
use crate::scene::{ArmChoice, Obstacle, Scene, Task};

/// Where objects stand, metres in front of the torso's axis.
const FORWARD_M: [f64; 2] = [0.36, 0.70];
/// Where objects stand, metres to the side of the acting arm.
const ASIDE_M: [f64; 2] = [0.0, 0.45];
/// A goal is at least this far from the start, metres.
const LEAST_TRANSPORT_M: f64 = 0.10;
/// Edges of the boxes of the clutter along the table, and their heights, metres.
const BOX_EDGE_M: [f64; 2] = [0.04, 0.10];
const BOX_HEIGHT_M: [f64; 2] = [0.04, 0.20];
/// Between a box and the object at its start and goal there is at least this much room, metres.
const BOX_GAP_M: f64 = 0.03;
/// Draws of a place before a box is left out.
const BOX_DRAWS: usize = 50;

/// What is varied from start to goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// A translation on the table.
    WithoutRotation,
    /// A translation on the table and a rotation about its normal.
    WithRotation,
}

impl Condition {
    /// Both, in the order of Table 5.1.
    pub const ALL: [Self; 2] = [Self::WithoutRotation, Self::WithRotation];

    /// The name in rows.
    pub fn name(self) -> &'static str {
        match self {
            Self::WithoutRotation => "without rotation",
            Self::WithRotation => "with rotation",
        }
    }

    /// Cases of the thesis.
    pub fn thesis_trials(self) -> usize {
        match self {
            Self::WithoutRotation => 35,
            Self::WithRotation => 278,
        }
    }
}

/// A drawn case.
pub(super) struct Case {
    /// Robot, arm, start, goal and boxes.
    pub(super) scene: Scene,
    /// Index of the object among those known.
    pub(super) object: usize,
    /// Place and heading at the start and at the goal: x, y in metres, yaw in radians.
    pub(super) start: [f64; 3],
    pub(super) goal: [f64; 3],
}

/// Draws a case: an object, an arm, a start in front of that arm, a goal at least 10 cm away, and boxes beside both.
pub(super) fn draw(
    robot: &str,
    condition: Condition,
    objects: &[KnownObject],
    clutter: usize,
    seed: u64,
    stream: u64,
) -> Case {
    let rng = &mut Rng::new(seed, stream);
    let index = rng.index(objects.len());
    let object = &objects[index];
    let (arm, side) = if rng.unit() < 0.5 { (ArmChoice::Left, 1.0) } else { (ArmChoice::Right, -1.0) };
    let place = |rng: &mut Rng| {
        let x = rng.uniform(FORWARD_M[0], FORWARD_M[1]);
        [x, side * rng.uniform(ASIDE_M[0], ASIDE_M[1])]
    };
    let start = place(rng);
    let goal = loop {
        // The start leaves most of the field: a few draws suffice.
        let goal = place(rng);
        if distance_m(start, goal) >= LEAST_TRANSPORT_M {
            break goal;
        }
    };
    let yaw = rng.uniform(-std::f64::consts::PI, std::f64::consts::PI);
    let yaw_goal = match condition {
        Condition::WithoutRotation => yaw,
        Condition::WithRotation => rng.uniform(-std::f64::consts::PI, std::f64::consts::PI),
    };
    let mut scene = scene(robot, arm, object, object.standing(start, yaw), seed ^ stream);
    scene.task = Task::place(0, object.standing(goal, yaw_goal));
    scene.obstacles = (0..clutter).filter_map(|number| draw_box(rng, number, &place, object, [start, goal])).collect();
    Case { scene, object: index, start: [start[0], start[1], yaw], goal: [goal[0], goal[1], yaw_goal] }
}

/// A box beside the object's start and goal; `None` where there is no room.
fn draw_box(
    rng: &mut Rng,
    number: usize,
    place: &impl Fn(&mut Rng) -> [f64; 2],
    object: &KnownObject,
    kept: [[f64; 2]; 2],
) -> Option<Obstacle> {
    let edge = |rng: &mut Rng| rng.uniform(BOX_EDGE_M[0], BOX_EDGE_M[1]);
    let size_m = Vector3::new(edge(rng), edge(rng), rng.uniform(BOX_HEIGHT_M[0], BOX_HEIGHT_M[1]));
    let R = turn(rng.uniform(0.0, std::f64::consts::PI));
    let apart_m = object.radius_m() + 0.5 * size_m.xy().norm() + BOX_GAP_M;
    let [x, y] =
        (0..BOX_DRAWS).map(|_| place(rng)).find(|at| kept.iter().all(|other| distance_m(*at, *other) >= apart_m))?;
    let centre = nalgebra::Translation3::new(x, y, TABLE.height_m + 0.5 * size_m.z);
    Some(Obstacle { name: format!("box {}", number + 1), size_m, X_WB: Isometry3::from_parts(centre, R) })
}

fn distance_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    (dx * dx + dy * dy).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::grasping::known::known_objects;
    use crate::experiment::grasping::testing::settings;

    #[test]
    fn cases_stand_in_front_of_their_arm_apart_from_each_other_and_from_the_boxes() {
        let objects = known_objects(&settings(&["tomato_soup_can", "cracker_box"])).unwrap();
        let (mut lefts, mut boxes) = (0, 0);
        for stream in 0..200 {
            for condition in Condition::ALL {
                let case = draw("alita", condition, &objects, 3, 1, stream);
                let scene = case.scene.clone().checked().expect("a valid scene");
                let side = if scene.arm == ArmChoice::Left { 1.0 } else { -1.0 };
                lefts += usize::from(scene.arm == ArmChoice::Left);
                let (start, goal) = ([case.start[0], case.start[1]], [case.goal[0], case.goal[1]]);
                for [x, y] in [start, goal] {
                    assert!((0.36..0.70).contains(&x) && (0.0..0.45).contains(&(side * y)), "{x} {y}");
                }
                assert!(distance_m(start, goal) >= 0.10);
                assert_eq!(case.start[2] == case.goal[2], condition == Condition::WithoutRotation);
                let X_WO_goal = *scene.task.X_WO_goal().expect("a goal");
                let motion = X_WO_goal * scene.objects[0].X_WO.inverse();
                let up = motion.rotation * Vector3::z();
                assert!((up - Vector3::z()).norm() < 1e-12, "only about the table's normal");
                boxes += scene.obstacles.len();
                for obstacle in &scene.obstacles {
                    let half = 0.5 * obstacle.size_m;
                    assert!((obstacle.X_WB.translation.z - half.z - 0.69).abs() < 1e-12, "stands on the table");
                    for [x, y] in [start, goal] {
                        // From the object's axis to the nearest point of the box, in its axes.
                        let p_B = obstacle.X_WB.inverse_transform_point(&nalgebra::Point3::new(x, y, 0.7));
                        let gap = (p_B.xy().coords.abs() - half.xy()).sup(&nalgebra::Vector2::zeros()).norm();
                        assert!(gap > objects[case.object].radius_m(), "{gap}");
                    }
                }
            }
        }
        // 400 even draws: four deviations of 10 to either side.
        assert!((160..240).contains(&lefts) && boxes > 800, "{lefts} {boxes}");
    }
}
