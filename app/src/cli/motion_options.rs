//! Options of `plan`: how the robot moves and what its goal leaves free. Whatever is not given stays as the scene has
//! it.

use clap::ValueEnum;
use endcomfort_core::scene::{Action, Freedom, Scene, Step};
use endcomfort_core::task::Planner;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::{Failure, input};

#[derive(clap::Args)]
pub(super) struct Options {
    /// What looks for the way.
    #[arg(long, value_enum, help_heading = "Motion")]
    planner: Option<PlannerName>,
    /// With the planner `routes`: the hand's route, counted from 1; default: the first that the arm can follow.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Motion")]
    route: Option<u32>,
    /// Distance that searched ways keep from everything where there is room, metres.
    #[arg(long, help_heading = "Motion")]
    clearance: Option<f64>,
    /// Share of the joints' speed limits, up to 1.
    #[arg(long, help_heading = "Motion")]
    velocity_scale: Option<f64>,
    /// Share of the joints' acceleration limits, up to 1.
    #[arg(long, help_heading = "Motion")]
    acceleration_scale: Option<f64>,
    /// Share of the joints' jerk limits, up to 1.
    #[arg(long, help_heading = "Motion")]
    jerk_scale: Option<f64>,
    /// Straight way of the open hand before the grasp, metres.
    #[arg(long, help_heading = "Motion")]
    approach: Option<f64>,
    /// Straight way up with the object, metres.
    #[arg(long, help_heading = "Motion")]
    lift: Option<f64>,
    /// Grasps tried before the task is refused.
    #[arg(long, help_heading = "Motion")]
    max_grasps: Option<usize>,
    /// Never puts the object down in between to grasp it anew.
    #[arg(long, help_heading = "Motion")]
    no_regrasp: bool,
    /// Goal of the object's frame instead of the scene's: x,y,z in metres and its yaw in degrees, relative to the start.
    #[arg(long, value_parser = input::numbers::<4>, allow_hyphen_values = true, help_heading = "Goal")]
    goal: Option<[f64; 4]>,
    /// Turn about the vertical that the last goal leaves free to either side, degrees; 180 leaves it free.
    #[arg(long, help_heading = "Goal")]
    yaw_free: Option<f64>,
    /// Shift along x and y that the last goal leaves free to either side: x,y in metres.
    #[arg(long, value_parser = input::numbers::<2>, help_heading = "Goal")]
    area: Option<[f64; 2]>,
    /// Half angle of the cone of directions in which the object's upright axis may end up, degrees.
    #[arg(long, help_heading = "Goal")]
    cone: Option<f64>,
    /// On the way to every goal the object stays upright within this, degrees.
    #[arg(long, help_heading = "Goal")]
    keep_upright: Option<f64>,
    /// Pushes the object to its goal instead of lifting it.
    #[arg(long, help_heading = "Goal")]
    slide: bool,
}

/// A planner by name.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum PlannerName {
    /// Bidirectional random trees with the whole IK set as goals.
    Search,
    /// A roadmap without random numbers.
    Roadmap,
    /// Several clearly different routes of the hand, followed through the null space, without random numbers.
    Routes,
}

impl From<PlannerName> for Planner {
    fn from(name: PlannerName) -> Self {
        match name {
            PlannerName::Search => Self::Search,
            PlannerName::Roadmap => Self::Roadmap,
            PlannerName::Routes => Self::Routes,
        }
    }
}

impl Options {
    /// Puts what was given into a scene and checks every number.
    ///
    /// # Errors
    /// What is wrong, with its place, what was found and what is wanted.
    pub(super) fn apply(&self, mut scene: Scene) -> Result<Scene, Failure> {
        let motion = &mut scene.motion;
        set(&mut motion.planner, self.planner.map(Planner::from));
        motion.route = self.route.map(|number| number as usize - 1).or(motion.route);
        set(&mut motion.clearance_m, self.clearance);
        set(&mut motion.velocity_scale, self.velocity_scale);
        set(&mut motion.acceleration_scale, self.acceleration_scale);
        set(&mut motion.jerk_scale, self.jerk_scale);
        set(&mut motion.approach_m, self.approach);
        set(&mut motion.lift_m, self.lift);
        set(&mut motion.max_grasps, self.max_grasps);
        motion.regrasp &= !self.no_regrasp;
        if let Some([x, y, z, yaw_deg]) = self.goal {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_deg.to_radians());
            let start = scene.objects[scene.task.object].X_WO.rotation;
            let X_WO_goal = Isometry3::from_parts(Translation3::new(x, y, z), turn * start);
            match scene.task.steps.last_mut() {
                Some(step) => step.X_WO_goal = X_WO_goal,
                None => scene.task.steps.push(Step::put(X_WO_goal)),
            }
        }
        let wants_goal =
            self.yaw_free.is_some() || self.area.is_some() || self.cone.is_some() || self.keep_upright.is_some();
        match scene.task.steps.last_mut() {
            Some(step) => self.soften(step),
            None if wants_goal || self.slide => {
                return Err(Failure::new("the scene has no goal: give one with --goal"));
            }
            None => {}
        }
        if let Some(degrees) = self.keep_upright {
            scene.task.steps.iter_mut().for_each(|step| step.keep_upright_rad = Some(degrees.to_radians()));
        }
        scene.checked().map_err(|error| Failure::new(error.to_string()))
    }

    fn soften(&self, step: &mut Step) {
        let Freedom { yaw_rad, area_m, cone_rad } = &mut step.freedom;
        set(yaw_rad, self.yaw_free.map(f64::to_radians));
        set(area_m, self.area);
        set(cone_rad, self.cone.map(f64::to_radians));
        if self.slide {
            step.action = Action::Slide;
        }
    }
}

fn set<T>(place: &mut T, given: Option<T>) {
    if let Some(value) = given {
        *place = value;
    }
}
