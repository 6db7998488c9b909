//! A handover of the pipeline: whose arms, which goal, what stands around, and the plan.

use std::borrow::Cow;

use nalgebra::{Isometry3, Vector3};

use super::goal::stops;
use super::rank::grasp_candidates;
use crate::collision::{MayTouch, Party, World};
use crate::fit::Fit;
use crate::grasp::{Grasp, HandModel, Touched};
use crate::handover::{
    Agent, AgentGoal, Handover, HandoverTask, KEEP_OUT, PERSON, PlaceChoice, Receiver, ReceiverArm, count_serving,
    plan_handover,
};
use crate::job::Refusal;
use crate::library::Library;
use crate::reach::ReachMap;
use crate::robot::ik::ArmIk;
use crate::robot::{Arm, Robot};
use crate::scene::{Action, ArmChoice, Scene, Step};
use crate::superquadric::Superquadric;
use crate::task::{Partners, Plan, TARGET, Workcell};
use crate::watch::Watch;

/// A body this many times as long as wide is a handle.
const SLENDER: f64 = 3.0;
/// Poses of a soft goal of the receiver that may be looked at.
const GOAL_POSES: u32 = 96;
/// What reasons call the floor.
const FLOOR: &str = "floor";
/// The floor: an upper face just below 0, so that what stands on it does not touch it, metres.
const FLOOR_TOP_M: f64 = -0.001;
const FLOOR_SIZE_M: [f64; 3] = [8.0, 8.0, 0.1];

/// The scene as the giver's arm sees it: that arm acts, the receiver's furniture stands around, and the receiver's goal
/// is the task's. A scene without handover is as it is.
///
/// # Errors
/// A [`Refusal`] when the arms' maps cannot be read.
pub(crate) fn acting<'a>(scene: &'a Scene, library: &Library) -> Result<Cow<'a, Scene>, Refusal> {
    let Some(handover) = &scene.handover else { return Ok(Cow::Borrowed(scene)) };
    let mut acting = scene.clone();
    acting.arm = match handover.giver_arm {
        Some(arm) => arm,
        None => better_arm(scene, library)?,
    };
    if let Some(agent) = handover.agent() {
        acting.obstacles.extend(agent.furniture_W());
        acting.task.steps = agent.goal.iter().map(|goal| step(agent, goal)).collect();
    }
    Ok(Cow::Owned(acting))
}

/// The step that brings the object to the receiver's goal.
fn step(agent: &Agent, goal: &AgentGoal) -> Step {
    let action = if goal.lets_go { Action::Put } else { Action::Pour { hold_s: 0.0 } };
    Step { action, freedom: goal.freedom, ..Step::put(agent.X_WA() * goal.X_AO) }
}

/// The arm in whose map the place of the object is the better one; the scene's if they are equal.
fn better_arm(scene: &Scene, library: &Library) -> Result<ArmChoice, Refusal> {
    let robot = library.robot(&scene.robot).map_err(|error| refusal(&error))?;
    let X_WL = scene.q_start(&robot).map(|q| robot.link_poses(&q)).unwrap_or_default();
    let p_W = scene.objects[scene.task.object].X_WO.translation.vector.into();
    let share = |arm: ArmChoice| -> Result<f64, Refusal> {
        let Some(found) = robot.arm(arm.name()) else { return Ok(0.0) };
        let map = map_of(library, &scene.robot, arm.name())?;
        let p_B = X_WL.get(found.base_link).map_or(p_W, |X_WB| X_WB.inverse_transform_point(&p_W));
        Ok(map.voxel_at(&p_B).map_or(0.0, |voxel| map.mean_manipulability(voxel)))
    };
    let other = scene.arm.other();
    Ok(if share(other)? > share(scene.arm)? { other } else { scene.arm })
}

fn map_of(library: &Library, robot: &str, arm: &str) -> Result<ReachMap, Refusal> {
    library.reach_map(robot, arm).map_err(|error| refusal(&error))
}

fn refusal(error: &dyn std::error::Error) -> Refusal {
    Refusal::new(error.to_string())
}

/// Floor and whatever else a handover brings into the world of both.
pub(crate) fn add_surroundings(world: &mut World, scene: &Scene) -> Result<(), Refusal> {
    if scene.handover.as_ref().and_then(Handover::agent).is_none() {
        return Ok(());
    }
    let [x, y, z] = FLOOR_SIZE_M;
    let X_WB = Isometry3::translation(0.0, 0.0, FLOOR_TOP_M - 0.5 * z);
    world.add_box(FLOOR, Vector3::new(x, y, z), &X_WB).map_err(|error| refusal(&error))
}

/// What a handover is planned from.
pub(crate) struct HandoverInput<'a> {
    /// The giver before the object, its candidates and the object.
    pub(crate) giver: &'a Workcell,
    pub(crate) grasps: &'a [Grasp],
    pub(crate) target: &'a Fit,
    /// What fingers close on.
    pub(crate) touched: &'a dyn Fn() -> Result<Touched, Refusal>,
    /// The scene as the giver's arm sees it ([`acting`]).
    pub(crate) scene: &'a Scene,
    pub(crate) handover: &'a Handover,
    pub(crate) library: &'a Library,
    pub(crate) is_dropped: bool,
}

impl HandoverInput<'_> {
    /// The two arms and the receiver's candidate grasps.
    ///
    /// # Errors
    /// A [`Refusal`] when there is no such arm or nothing to grasp.
    pub(crate) fn partners(&self) -> Result<(Partners, Vec<Grasp>), Refusal> {
        let robot = &self.giver.robot;
        let arm_index = receiving_arm(robot, self.giver, self.handover)?;
        let arm = &robot.arms[arm_index];
        let receiver = Workcell {
            arm_index,
            ik: ArmIk::of(robot, arm).map_err(|error| refusal(&error))?,
            hand: HandModel::new(robot, arm),
            stops: stops(self.scene, self.target, self.is_dropped, GOAL_POSES),
            ..self.giver.clone()
        };
        // At the handover nothing but the giver stands around the object.
        let alone = Workcell { world: World::new(), ..receiver.clone() };
        let grasps = grasp_candidates(&alone, self.target, (self.touched)()?, &self.scene.grasp)?;
        let mut may_touch = self.handover.agent().map(|agent| standing(robot, agent)).unwrap_or_default();
        // The object may come near the person who takes it; in the giver's hand it keeps away as the giver does.
        let own_space = || (0..robot.links.len()).filter(|&link| robot.links[link].name.ends_with(KEEP_OUT));
        let near = |link, b| MayTouch { a: Party::Link(link), b, depth_m: f64::INFINITY };
        may_touch.extend(own_space().map(|link| near(link, Party::Obstacle(TARGET.to_owned()))));
        let giver = Workcell { stops: Vec::new(), may_touch: may_touch.clone(), ..self.giver.clone() };
        may_touch.extend(own_space().map(|link| near(link, Party::Carried)));
        let receiver = Workcell { may_touch, ..receiver };
        Ok((Partners { giver, receiver }, grasps))
    }

    /// Plans it; also the two arms.
    ///
    /// # Errors
    /// The [`Refusal`] of [`plan_handover`].
    pub(crate) fn plan(&self, watch: Watch<'_>) -> Result<(Plan, Partners), Refusal> {
        let (partners, receiver_grasps) = self.partners()?;
        let plan = self.plan_between(&partners, &receiver_grasps, watch)?;
        Ok((plan, partners))
    }

    /// How many grasps of each arm serve the object's start, and its goal.
    ///
    /// # Errors
    /// A [`Refusal`] when bodies make no sense.
    pub(crate) fn serving(&self, partners: &Partners, receiver_grasps: &[Grasp]) -> Result<Serving, Refusal> {
        let Partners { giver, receiver } = partners;
        let goal = receiver.stops.last().map_or(&[][..], |stop| &stop.poses_WO);
        let start = [giver.X_WO_start];
        let count = |cell: &Workcell, grasps: &[Grasp], poses: &[Isometry3<f64>]| {
            count_serving(cell, &self.scene.motion, grasps, poses).map_err(|error| refusal(&error))
        };
        Ok(Serving {
            giver: (count(giver, self.grasps, &start)?, count(giver, self.grasps, goal)?),
            receiver: (count(receiver, receiver_grasps, &start)?, count(receiver, receiver_grasps, goal)?),
        })
    }

    /// Plans it with candidates that are known already.
    ///
    /// # Errors
    /// As [`HandoverInput::plan`].
    pub(crate) fn plan_between(
        &self,
        partners: &Partners,
        receiver_grasps: &[Grasp],
        watch: Watch<'_>,
    ) -> Result<Plan, Refusal> {
        let choice = &self.handover.choice;
        let agent = self.handover.agent();
        let model = agent.map_or(self.scene.robot.as_str(), |agent| agent.model.as_str());
        let prefix = agent.map_or(String::new(), |agent| format!("{}_", agent.model));
        let receiver_arm = &partners.receiver.arm().name;
        let receiver_map = map_of(self.library, model, receiver_arm.strip_prefix(&prefix).unwrap_or(receiver_arm))?;
        let giver_map = map_of(self.library, &self.scene.robot, &partners.giver.arm().name)?;
        // Both hands of one robot: the middle between start and goal decides, not who is more comfortable (6.1).
        let is_own = self.handover.receiver == Receiver::OtherHand;
        let is_person = model == PERSON;
        let choice = PlaceChoice {
            receiver_first: choice.receiver_first && !is_own,
            hand_speed_m_s: if is_person { choice.hand_speed_m_s } else { f64::INFINITY },
            ..*choice
        };
        let receiver = &partners.receiver;
        let person = is_person.then(|| ReceiverArm::of(&receiver.robot, receiver.arm())).flatten();
        let task = HandoverTask {
            partners,
            grasps: [self.grasps, receiver_grasps],
            maps: [&giver_map, &receiver_map],
            lets_go: agent.is_none_or(|agent| agent.goal.is_some_and(|goal| goal.lets_go)),
            choice: &choice,
            motion: &self.scene.motion,
            handle: handle(self.target),
            cost: &|q| person.as_ref().map(|arm| arm.comfort(q)),
            seed: self.scene.seed,
        };
        plan_handover(&task, watch)
    }
}

/// The body of a composite that is its handle: the most slender one.
fn handle(fit: &Fit) -> Option<usize> {
    let slenderness = |body: &Superquadric| {
        let mut semi_axes: Vec<f64> = body.semi_axes().iter().copied().collect();
        semi_axes.sort_by(f64::total_cmp);
        semi_axes[2] / semi_axes[1]
    };
    let bodies: Vec<f64> = fit.bodies().map(slenderness).collect();
    let slender = bodies.iter().enumerate().filter(|(_, slenderness)| **slenderness >= SLENDER);
    let most = slender.max_by(|l, r| l.1.total_cmp(r.1)).map(|(index, _)| index);
    most.filter(|_| bodies.len() > 1)
}

/// What stands still may touch what it stands on: no motion changes that.
fn standing(robot: &Robot, agent: &Agent) -> Vec<MayTouch> {
    let mut moves = vec![false; robot.links.len()];
    // Joint i moves link i + 1, and parents stand before their children.
    for (joint, child) in robot.joints.iter().zip(1..) {
        let dof = joint.dof.or(joint.mimic.as_ref().map(|mimic| mimic.dof));
        let is_of_arm = |arm: &Arm| {
            dof.is_some_and(|dof| arm.dofs.contains(&dof) || arm.hand.fingers.iter().flatten().any(|&own| own == dof))
        };
        moves[child] = moves[joint.parent] || robot.arms.iter().any(is_of_arm);
    }
    let still = (0..robot.links.len()).filter(|&link| !moves[link]);
    let contact = |link, name: &str| MayTouch {
        a: Party::Link(link),
        b: Party::Obstacle(name.to_owned()),
        depth_m: f64::INFINITY,
    };
    let names = || agent.furniture.iter().map(|piece| piece.name.as_str()).chain([FLOOR]);
    still.flat_map(|link| names().map(move |name| contact(link, name))).collect()
}

/// Grasps of an arm that serve the object's start, and its goal.
pub(crate) struct Serving {
    pub(crate) giver: (usize, usize),
    pub(crate) receiver: (usize, usize),
}

/// The arm that receives: the one that was chosen, the robot's other one, or the agent's whose shoulder is nearer.
fn receiving_arm(robot: &Robot, giver: &Workcell, handover: &Handover) -> Result<usize, Refusal> {
    let named = |name: &str| robot.arms.iter().position(|arm| arm.name == name);
    let missing = |name: &str| Refusal::new(format!("{} has no {name} arm", robot.name));
    let Some(agent) = handover.agent() else {
        let other = (0..robot.arms.len()).find(|&index| index != giver.arm_index);
        return other.ok_or_else(|| missing("other"));
    };
    let name = |arm: ArmChoice| format!("{}_{}", agent.model, arm.name());
    if let Some(arm) = agent.arm {
        return named(&name(arm)).ok_or_else(|| missing(&name(arm)));
    }
    let X_WL = robot.link_poses(&giver.q_start);
    let shoulder = |arm: usize| X_WL[robot.arms[arm].base_link].translation.vector;
    let from = shoulder(giver.arm_index);
    let arms = [ArmChoice::Left, ArmChoice::Right].into_iter().filter_map(|arm| named(&name(arm)));
    let nearest = arms.min_by(|&l, &r| (shoulder(l) - from).norm().total_cmp(&(shoulder(r) - from).norm()));
    nearest.ok_or_else(|| missing(&agent.model))
}
