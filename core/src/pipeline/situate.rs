//! A candidate where the object stands and where it shall go: IK sets, straight ways in and out, and how much room.

use nalgebra::{Isometry3, Translation3, Vector3};

use crate::collision::{Checker, CollisionError, HandChecker, Hit, Scratch};
use crate::grasp::{Grasp, GraspStatus, Obstruction, Reach, Situated, Unwanted};
use crate::parallel;
use crate::plan::CartesianSettings;
use crate::scene::Scene;
use crate::task::{MotionSettings, STRAIGHT_STEP_M, Workcell};

/// Configurations with straight ways that are looked for in an IK set; the planner starts from them.
const WAYS_WANTED: usize = 3;
/// Configurations of an IK set that are tried for that, the most manipulable first.
const WAYS_TRIED: usize = 48;
/// Configurations that the planner gets untried when straight ways are not asked for.
const UNTRIED_WAYS: usize = 12;

/// Situates all accepted candidates; `should_stop` is asked before each.
pub(super) fn situate_all(
    cell: &Workcell,
    grasps: &[Grasp],
    scene: &Scene,
    should_stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Grasp>, CollisionError> {
    let situate = Situate::new(cell, scene)?;
    let judged = parallel::map(grasps, |grasp| {
        let mut grasp = grasp.clone();
        if grasp.is_accepted() && !should_stop() {
            situate.grasp(&mut grasp)?;
        }
        Ok(grasp)
    });
    judged.into_iter().collect()
}

/// One of the two places of a task, and the open hand there.
struct Place {
    X_WO: Isometry3<f64>,
    /// What the object stands on there.
    supports: Vec<String>,
    /// The arm with the open hand beside the standing object.
    open: Checker,
}

struct Situate<'a> {
    cell: &'a Workcell,
    scene: &'a Scene,
    start: Place,
    goal: Option<Place>,
    motion: &'a MotionSettings,
}

impl<'a> Situate<'a> {
    fn new(cell: &'a Workcell, scene: &'a Scene) -> Result<Self, CollisionError> {
        let place = |X_WO: Isometry3<f64>| -> Result<Place, CollisionError> {
            let open = cell.checker(&cell.approaching(&X_WO)?)?;
            Ok(Place { X_WO, supports: cell.supports(&X_WO), open })
        };
        let goal = cell.X_WO_goal.map(place).transpose()?;
        Ok(Self { cell, scene, start: place(cell.X_WO_start)?, goal, motion: &scene.motion })
    }

    /// Fills in the grasp's sets at start and goal, its clearance, and what speaks against it.
    fn grasp(&self, grasp: &mut Grasp) -> Result<(), CollisionError> {
        let cell = self.cell;
        if let Some(status) = self.room(grasp)? {
            grasp.status = status;
            return Ok(());
        }
        let closed = cell.checker(&cell.grasping(&self.start.X_WO, &grasp.closed)?)?;
        let mut start = self.set(grasp, &self.start, &closed);
        if start.ik_count == 0 {
            grasp.status = GraspStatus::NoIkAtStart { reason: start.main_reason() };
            grasp.start = Some(start);
            return Ok(());
        }
        // At its start the object is lifted from its support, at its goal it is lowered onto another one.
        let lifting = self.carrying(grasp, &self.start)?;
        let way_in = self.ways(grasp, &self.start, &lifting, &mut start);
        grasp.start = Some(start);
        if let Err(reason) = way_in {
            grasp.status = GraspStatus::NoWayAtStart { reason };
            return Ok(());
        }
        let Some(place) = &self.goal else { return Ok(()) };
        let placing = self.carrying(grasp, place)?;
        let mut goal = self.set(grasp, place, &placing);
        if goal.ik_count == 0 {
            grasp.status = GraspStatus::NoIkAtGoal { reason: goal.main_reason() };
        } else if let Err(reason) = self.ways(grasp, place, &placing, &mut goal) {
            grasp.status = GraspStatus::NoWayAtGoal { reason };
        }
        grasp.goal = Some(goal);
        Ok(())
    }

    fn carrying(&self, grasp: &Grasp, place: &Place) -> Result<Checker, CollisionError> {
        self.cell.checker(&self.cell.carrying(grasp, &place.supports)?)
    }

    /// The distance of the closed hand from everything at start and goal, and whether it is enough.
    fn room(&self, grasp: &mut Grasp) -> Result<Option<GraspStatus>, CollisionError> {
        let cell = self.cell;
        let hand = HandChecker::new(&cell.model, &cell.world, &[], cell.arm_index, &grasp.closed)?;
        let places = std::iter::once(&self.start).chain(&self.goal);
        let nearest = places
            .map(|place| hand.distance(&(place.X_WO * grasp.X_OH)))
            .min_by(|l, r| l.distance_m.total_cmp(&r.distance_m));
        let Some(nearest) = nearest.filter(|nearest| nearest.distance_m.is_finite()) else { return Ok(None) };
        grasp.clearance_m = Some(nearest.distance_m);
        let wanted_m = self.scene.grasp.filter.min_clearance_m;
        let wish = Unwanted::Clearance { found_m: nearest.distance_m, wanted_m, other: nearest.b };
        Ok((wanted_m > 0.0 && nearest.distance_m < wanted_m).then_some(GraspStatus::Unwanted { wish }))
    }

    fn set(&self, grasp: &Grasp, place: &Place, checker: &Checker) -> Situated {
        let cell = self.cell;
        let q_rest = cell.q_with_fingers(&grasp.closed);
        let arm_angles = self.scene.rank.arm_angles;
        let reach = Reach { robot: &cell.robot, arm: cell.arm(), ik: &cell.ik, q_rest: &q_rest, arm_angles };
        let mut scratch = Scratch::default();
        // All configurations of the set put the hand at the same place.
        let mut of_hand = None;
        reach.situate(&(place.X_WO * grasp.X_OH), |q| {
            let of_hand = of_hand.get_or_insert_with(|| checker.first_hit_of_hand(&mut scratch, q)).clone();
            of_hand.or_else(|| checker.first_hit_besides_hand(&mut scratch, q)).map(Obstruction::from)
        })
    }

    /// Looks for configurations from which the open hand can back off straight and the carried object can rise.
    fn ways(&self, grasp: &Grasp, place: &Place, carrying: &Checker, set: &mut Situated) -> Result<(), Obstruction> {
        if !self.scene.rank.straight_ways {
            set.with_ways = most_manipulable(set).into_iter().take(UNTRIED_WAYS).collect();
            return Ok(());
        }
        let cell = self.cell;
        let X_BW = cell.robot.link_poses(&cell.q_start)[cell.arm().base_link].inverse();
        let X_WH = place.X_WO * grasp.X_OH;
        let mut scratch = Scratch::default();
        let jump_rad = CartesianSettings::default().max_joint_step_rad;
        let mut follow = |q: &[f64], length_m: f64, way: &dyn Fn(f64) -> Isometry3<f64>, checker: &Checker| {
            let mut q = q.to_vec();
            let steps = libm::ceil(length_m / STRAIGHT_STEP_M) as u32;
            for step in 1..=steps {
                let X_BH = X_BW * way(length_m * f64::from(step) / f64::from(steps));
                let Some(next) = cell.ik.near(&X_BH, &q) else { return Err(Blocked::NoIk { X_BH, q }) };
                if next.iter().zip(&q).any(|(to, from)| (to - from).abs() > jump_rad) {
                    return Err(Blocked::Jump);
                }
                if let Some(hit) = checker.first_hit(&mut scratch, &next) {
                    return Err(Blocked::Hit(hit));
                }
                q = next;
            }
            Ok(())
        };
        let (back_m, rise_m) = (self.motion.min_approach_m, self.motion.lift_m);
        let back = |way_m: f64| X_WH * Translation3::new(0.0, 0.0, -way_m);
        let rise = |way_m: f64| Translation3::from(Vector3::z() * way_m) * X_WH;
        let mut first = None;
        for index in most_manipulable(set).into_iter().take(WAYS_TRIED) {
            let q = &set.solutions[index];
            match follow(q, back_m, &back, &place.open).and_then(|()| follow(q, rise_m, &rise, carrying)) {
                Ok(()) => set.with_ways.push(index),
                Err(reason) => first = first.or(Some(reason)),
            }
            if set.with_ways.len() == WAYS_WANTED {
                break;
            }
        }
        let Some(blocked) = first.filter(|_| set.with_ways.is_empty()) else { return Ok(()) };
        let jump = || Obstruction::Invalid { reason: "a joint would have to jump".to_owned() };
        Err(match blocked {
            Blocked::Hit(hit) => hit.into(),
            Blocked::Jump => jump(),
            // Somewhere within reach: then only a far posture gets there.
            Blocked::NoIk { X_BH, q } => cell.ik.first(&X_BH, &q).err().map_or_else(jump, |reject| (&reject).into()),
        })
    }
}

/// Why a straight way ends early; said in words only for the one that is told.
enum Blocked {
    NoIk { X_BH: Isometry3<f64>, q: Vec<f64> },
    Jump,
    Hit(Hit),
}

/// Indices of the solutions of a set, the most manipulable first, ties in their own order.
fn most_manipulable(set: &Situated) -> Vec<usize> {
    let mut order: Vec<usize> = (0..set.solutions.len()).collect();
    order.sort_by(|&l, &r| set.manipulability[r].total_cmp(&set.manipulability[l]).then(l.cmp(&r)));
    order
}
