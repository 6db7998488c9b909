//! A candidate where the object stands and where it shall go: IK sets, straight ways in and out, and how much room.

use nalgebra::{Isometry3, Translation3, Vector3};

use crate::collision::{Checker, CollisionError, HandChecker, Hit, Scratch};
use crate::grasp::{Grasp, GraspStatus, Obstruction, Reach, Situated, Unwanted};
use crate::parallel;
use crate::plan::{CartesianSettings, straight_line};
use crate::robot::Dexterity;
use crate::scene::{Action, Scene};
use crate::task::{MotionSettings, STRAIGHT_STEP_M, STRAIGHT_STEP_RAD, Stop, Workcell, upright_again};

/// Configurations with straight ways that are looked for in an IK set; the planner starts from them.
const WAYS_WANTED: usize = 3;
/// Configurations of an IK set that are tried for that, the most manipulable first.
const WAYS_TRIED: usize = 48;
/// Configurations that the planner gets untried when straight ways are not asked for.
const UNTRIED_WAYS: usize = 12;
/// Arm angles at which the poses of a soft goal are compared before one is looked at closely.
const COARSE_ARM_ANGLES: usize = 6;
/// Poses of a soft goal that are looked at closely.
const CLOSE_POSES: usize = 4;

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

/// A pose of the object, and the open hand there.
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
    /// The stops of the leg, each with the poses that the object itself can have there.
    stops: Vec<(&'a Stop, Vec<Place>)>,
    motion: &'a MotionSettings,
    X_BW: Isometry3<f64>,
}

/// What keeps a grasp from a stop.
enum Missing {
    Ik(Obstruction),
    Way(Obstruction),
}

impl<'a> Situate<'a> {
    fn new(cell: &'a Workcell, scene: &'a Scene) -> Result<Self, CollisionError> {
        let place = |X_WO: Isometry3<f64>| -> Result<Place, CollisionError> {
            let open = cell.checker(&cell.approaching(&X_WO)?)?;
            Ok(Place { X_WO, supports: cell.supports(&X_WO), open })
        };
        let places = |stop: &'a Stop| -> Result<(&'a Stop, Vec<Place>), CollisionError> {
            let (wanted, others) = stop.poses_WO.split_first().map_or((None, &[][..]), |(w, o)| (Some(w), o));
            // What is wrong with the wanted pose itself shows as the grasps' reasons.
            let free = others.iter().filter(|X_WO| cell.object_hits(X_WO).is_none());
            Ok((stop, wanted.into_iter().chain(free).map(|X_WO| place(*X_WO)).collect::<Result<_, _>>()?))
        };
        let X_BW = cell.robot.link_poses(&cell.q_start)[cell.arm().base_link].inverse();
        let stops = cell.leg().iter().map(places).collect::<Result<_, _>>()?;
        Ok(Self { cell, scene, start: place(cell.X_WO_start)?, stops, motion: &scene.motion, X_BW })
    }

    /// Fills in the grasp's sets at start and stops, its clearance, and what speaks against it.
    fn grasp(&self, grasp: &mut Grasp) -> Result<(), CollisionError> {
        if let Some(status) = self.room(grasp)? {
            grasp.status = status;
            return Ok(());
        }
        let closed = self.cell.checker(&self.cell.grasping(&self.start.X_WO, &grasp.closed)?)?;
        let mut start = self.set(grasp, &self.start, &closed);
        if start.ik_count == 0 {
            grasp.status = GraspStatus::NoIkAtStart { reason: start.main_reason() };
            grasp.start = Some(start);
            return Ok(());
        }
        let way_in = match self.stops.first() {
            Some((stop, places)) if stop.action == Action::Slide => self.slide(grasp, &places[0], &mut start)?,
            _ => {
                // At its start the object is lifted from its support.
                let lifting = self.carrying(grasp, &self.start.supports)?;
                self.ways(grasp, &self.start, &lifting, &mut start)
            }
        };
        grasp.start = Some(start);
        if let Err(reason) = way_in {
            grasp.status = GraspStatus::NoWayAtStart { reason };
            return Ok(());
        }
        for (step, (stop, places)) in self.stops.iter().enumerate() {
            let is_last = step + 1 == self.stops.len();
            let (set, missing) = self.at_stop(grasp, stop, places)?;
            match missing {
                Some(Missing::Ik(reason)) if is_last => grasp.status = GraspStatus::NoIkAtGoal { reason },
                Some(Missing::Way(reason)) if is_last => grasp.status = GraspStatus::NoWayAtGoal { reason },
                Some(Missing::Ik(reason)) => grasp.status = GraspStatus::NoIkAtStep { step, reason },
                Some(Missing::Way(reason)) => grasp.status = GraspStatus::NoWayAtStep { step, reason },
                None => {}
            }
            if is_last {
                grasp.goal = Some(set)
            } else {
                grasp.via.push(set)
            }
            if !grasp.is_accepted() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// The grasp at a stop; of the poses that a soft goal offers, the most manipulable that can be done.
    fn at_stop(
        &self,
        grasp: &Grasp,
        stop: &Stop,
        places: &[Place],
    ) -> Result<(Situated, Option<Missing>), CollisionError> {
        if let [place] = places {
            return self.at_place(grasp, stop, place);
        }
        let promising = self.most_promising(grasp, places)?;
        let mut first = None;
        for index in promising.into_iter().take(CLOSE_POSES) {
            let (mut set, missing) = self.at_place(grasp, stop, &places[index])?;
            set.poses = stop.poses_WO.len();
            if missing.is_none() {
                return Ok((set, None));
            }
            first = first.or(Some((set, missing)));
        }
        // Nothing promising: what is told is what is wrong with the wanted pose.
        first.map_or_else(|| self.at_place(grasp, stop, &places[0]), Ok)
    }

    fn at_place(
        &self,
        grasp: &Grasp,
        stop: &Stop,
        place: &Place,
    ) -> Result<(Situated, Option<Missing>), CollisionError> {
        // Above or on the table the object is in the hand; while it is poured nothing supports it.
        let held = match stop.action {
            Action::Put => self.carrying(grasp, &place.supports)?,
            Action::Slide => self.carrying(grasp, &self.sliding_supports(place))?,
            Action::Pour { .. } => self.carrying(grasp, &[])?,
        };
        let mut set = self.set(grasp, place, &held);
        if set.ik_count == 0 {
            let reason = set.main_reason();
            return Ok((set, Some(Missing::Ik(reason))));
        }
        let ways = match stop.action {
            Action::Put => self.ways(grasp, place, &held, &mut set),
            // Its ways were followed from the start.
            Action::Slide => Ok(()),
            Action::Pour { .. } => self.tilt_back(grasp, place, &held, &mut set),
        };
        Ok((set, ways.err().map(Missing::Way)))
    }

    /// Places at which the hand is free and the arm reaches, by a coarse mean of the manipulability there, best first.
    fn most_promising(&self, grasp: &Grasp, places: &[Place]) -> Result<Vec<usize>, CollisionError> {
        let cell = self.cell;
        let hand = HandChecker::new(&cell.model, &cell.world, &[], cell.arm_index, &grasp.closed)?;
        let q_now: Vec<f64> = cell.arm().dofs.iter().map(|&dof| cell.q_start[dof]).collect();
        let mut dexterity = Dexterity::new(cell.ik.chain());
        let mut placed = Vec::new();
        let mut promising: Vec<(f64, usize)> = Vec::new();
        for (index, place) in places.iter().enumerate() {
            let X_WH = place.X_WO * grasp.X_OH;
            if hand.first_hit(&X_WH).is_some() {
                continue;
            }
            let found = cell.ik.set(&(self.X_BW * X_WH), &q_now, COARSE_ARM_ANGLES);
            let q: Vec<f64> = found.iter().flatten().copied().collect();
            dexterity.all(&q, &mut placed);
            if !placed.is_empty() {
                let sum: f64 = placed.iter().map(|placed| placed.manipulability).sum();
                promising.push((sum / placed.len() as f64, index));
            }
        }
        promising.sort_by(|l, r| r.0.total_cmp(&l.0).then(l.1.cmp(&r.1)));
        Ok(promising.into_iter().map(|(_, index)| index).collect())
    }

    fn carrying(&self, grasp: &Grasp, supports: &[String]) -> Result<Checker, CollisionError> {
        self.cell.checker(&self.cell.carrying(grasp, supports)?)
    }

    fn sliding_supports(&self, end: &Place) -> Vec<String> {
        self.cell.all_supports(&[self.start.X_WO, end.X_WO])
    }

    /// The distance of the closed hand from everything at start and stops, and whether it is enough.
    fn room(&self, grasp: &mut Grasp) -> Result<Option<GraspStatus>, CollisionError> {
        let cell = self.cell;
        let hand = HandChecker::new(&cell.model, &cell.world, &[], cell.arm_index, &grasp.closed)?;
        let hard = self.stops.iter().filter(|(_, places)| places.len() == 1).flat_map(|(_, places)| places);
        let nearest = std::iter::once(&self.start)
            .chain(hard)
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
        let set = reach.situate(&(place.X_WO * grasp.X_OH), |q| {
            let of_hand = of_hand.get_or_insert_with(|| checker.first_hit_of_hand(&mut scratch, q)).clone();
            of_hand.or_else(|| checker.first_hit_besides_hand(&mut scratch, q)).map(Obstruction::from)
        });
        Situated { X_WO: place.X_WO, poses: 1, ..set }
    }

    /// Looks for configurations from which the open hand can back off straight and the carried object can rise.
    fn ways(&self, grasp: &Grasp, place: &Place, carrying: &Checker, set: &mut Situated) -> Result<(), Obstruction> {
        let X_WH = place.X_WO * grasp.X_OH;
        let back = self.line(&X_WH, &self.backed_off(&X_WH));
        let rise = self.line(&X_WH, &(Translation3::from(Vector3::z() * self.motion.lift_m) * X_WH));
        let mut scratch = Scratch::default();
        self.with_ways(set, |q| {
            self.follow(&mut scratch, q, &back, &place.open)?;
            self.follow(&mut scratch, q, &rise, carrying).map(drop)
        })
    }

    /// Looks for configurations from which the carried object can be turned upright again.
    fn tilt_back(&self, grasp: &Grasp, place: &Place, held: &Checker, set: &mut Situated) -> Result<(), Obstruction> {
        let X_WO_upright = upright_again(&place.X_WO, &self.start.X_WO);
        let turn = self.line(&(place.X_WO * grasp.X_OH), &(X_WO_upright * grasp.X_OH));
        let mut scratch = Scratch::default();
        self.with_ways(set, |q| self.follow(&mut scratch, q, &turn, held).map(drop))
    }

    /// Looks for configurations at the start to which the hand comes straight, from which the object can be pushed to
    /// its goal, and from which the hand then backs off.
    fn slide(&self, grasp: &Grasp, end: &Place, set: &mut Situated) -> Result<Result<(), Obstruction>, CollisionError> {
        let (X_WH, X_WH_end) = (self.start.X_WO * grasp.X_OH, end.X_WO * grasp.X_OH);
        let back = self.line(&X_WH, &self.backed_off(&X_WH));
        let along = self.line(&X_WH, &X_WH_end);
        let leave = self.line(&X_WH_end, &self.backed_off(&X_WH_end));
        let sliding = self.carrying(grasp, &self.sliding_supports(end))?;
        let mut scratch = Scratch::default();
        Ok(self.with_ways(set, |q| {
            self.follow(&mut scratch, q, &back, &self.start.open)?;
            let q_end = self.follow(&mut scratch, q, &along, &sliding)?;
            self.follow(&mut scratch, &q_end, &leave, &end.open).map(drop)
        }))
    }

    fn backed_off(&self, X_WH: &Isometry3<f64>) -> Isometry3<f64> {
        X_WH * Translation3::new(0.0, 0.0, -self.motion.min_approach_m)
    }

    /// Poses of the hand in the base frame on a straight line.
    fn line(&self, X_WH: &Isometry3<f64>, X_WH_end: &Isometry3<f64>) -> Vec<Isometry3<f64>> {
        let poses = straight_line(X_WH, X_WH_end, STRAIGHT_STEP_M, STRAIGHT_STEP_RAD);
        poses.iter().map(|X_WH| self.X_BW * X_WH).collect()
    }

    /// Follows poses with the nearest configurations; the last one.
    fn follow(
        &self,
        scratch: &mut Scratch,
        q: &[f64],
        poses_BH: &[Isometry3<f64>],
        checker: &Checker,
    ) -> Result<Vec<f64>, Blocked> {
        let jump_rad = CartesianSettings::default().max_joint_step_rad;
        let mut q = q.to_vec();
        for X_BH in poses_BH {
            let Some(next) = self.cell.ik.near(X_BH, &q) else { return Err(Blocked::NoIk { X_BH: *X_BH, q }) };
            if next.iter().zip(&q).any(|(to, from)| (to - from).abs() > jump_rad) {
                return Err(Blocked::Jump);
            }
            if let Some(hit) = checker.first_hit(scratch, &next) {
                return Err(Blocked::Hit(hit));
            }
            q = next;
        }
        Ok(q)
    }

    /// Marks the configurations of a set that have ways, the most manipulable first, as many as a planner needs; the
    /// first obstacle met if none has.
    fn with_ways(
        &self,
        set: &mut Situated,
        mut has: impl FnMut(&[f64]) -> Result<(), Blocked>,
    ) -> Result<(), Obstruction> {
        if !self.scene.rank.straight_ways {
            set.with_ways = most_manipulable(set).into_iter().take(UNTRIED_WAYS).collect();
            return Ok(());
        }
        let mut first = None;
        for index in most_manipulable(set).into_iter().take(WAYS_TRIED) {
            match has(&set.solutions[index]) {
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
            Blocked::NoIk { X_BH, q } => {
                self.cell.ik.first(&X_BH, &q).err().map_or_else(jump, |reject| (&reject).into())
            }
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
