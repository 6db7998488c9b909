//! The robot posed by hand: joints by sliders and buttons, hands by their targets in the view, both arms alive at once.
//!
//! The pose is where the scene's plan starts ([`Scene::joints`]), so it is saved, shared and undone like everything else,
//! and the plan follows it. A target that the arm cannot reach stays where it was put: the arm goes as near as it can,
//! and a tether joins the two.

use std::sync::Arc;

use endcomfort_core::job::FitOutput;
use endcomfort_core::pipeline::{Meeting, Seen, Surroundings};
use endcomfort_core::robot::ik::{ArmIk, IkReject};
use endcomfort_core::robot::{JointKind, Robot};
use endcomfort_core::scene::Scene;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::goal_drag::FARTHEST_M;
use super::state::Side;
use super::{Effect, ViewerState};
use crate::assets;

/// A joint this near to its limit counts as at it, radians or metres.
const AT_LIMIT: f64 = 0.009;

/// What a person does with the robot's posture.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseCommand {
    /// Opens the page, the robot as it starts.
    Open,
    /// Closes it; the pose stays.
    Close,
    /// Shows the joints of another arm, and its whole gizmo.
    Arm(usize),
    /// Whether buttons move the hand along its own axes instead of the world's.
    AlongHand(bool),
    /// How far a button moves the hand, an index into [`STEPS`].
    Step(usize),
    /// Leads the hand of an arm to a pose in the world while it is dragged.
    Lead(usize, Isometry3<f64>),
    /// It has been let go.
    EndDrag,
    /// Moves the hand of the chosen arm by one step.
    Jog(Jog),
    /// Moves a degree of freedom while its slider is held, radians or metres.
    DragJoint(usize, f64),
    /// Opens the hand of the chosen arm to this share, [0, 1], while its slider is held.
    DragFingers(f64),
    /// Starts from this posture of the robot, as it is.
    Posture(String),
    /// Brings a target back to where its hand is.
    Recall(usize),
}

/// One step of a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jog {
    /// Whether it turns about the axis instead of moving along it.
    pub turns: bool,
    /// x, y or z.
    pub axis: usize,
    /// Back instead of forth.
    pub back: bool,
}

/// Steps of the buttons: metres and radians.
pub(super) const STEPS: [(f64, f64); 3] = [(0.001, 0.0175), (0.01, 0.0873), (0.05, 0.2618)];
/// The same in words.
pub(super) const STEP_WORDS: [&str; 3] = ["1 mm, 1°", "1 cm, 5°", "5 cm, 15°"];

/// How the robot is posed.
pub struct Posing {
    /// Whether the page is open.
    pub is_open: bool,
    /// The arm whose joints are listed.
    pub arm: usize,
    /// Whether buttons move along the hand's own axes.
    pub along_hand: bool,
    /// Index into [`STEPS`].
    pub step: usize,
    /// By arm: a target that its hand does not reach.
    targets: Vec<Option<HandTarget>>,
    around: Option<Around>,
    meeting: Option<Meeting>,
}

impl Default for Posing {
    fn default() -> Self {
        let (around, meeting) = (None, None);
        Self { is_open: false, arm: 0, along_hand: false, step: 1, targets: Vec::new(), around, meeting }
    }
}

/// What the robot stands among, and of which scene and fits it was made.
struct Around {
    scene: Arc<Scene>,
    fits: Option<Arc<FitOutput>>,
    surroundings: Surroundings,
}

/// Where a hand is wanted but is not.
#[derive(Clone, Debug, PartialEq)]
pub struct HandTarget {
    /// Wanted pose of the hand in the world.
    pub X_WH: Isometry3<f64>,
    /// Why it is not there.
    pub reason: IkReject,
}

/// A hand that can be led.
#[derive(Clone, Debug, PartialEq)]
pub struct LedHand {
    /// Index of the arm.
    pub arm: usize,
    /// Name of the arm.
    pub name: String,
    /// Where the hand is.
    pub X_WH: Isometry3<f64>,
    /// Where it is wanted, if it is not there.
    pub target: Option<HandTarget>,
}

impl LedHand {
    /// Where its gizmo is.
    pub fn handle(&self) -> Isometry3<f64> {
        self.target.as_ref().map_or(self.X_WH, |target| target.X_WH)
    }
}

/// What posing adds to the picture; equal values give equal pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosingKey {
    /// Hands with their targets; none while the page is closed.
    pub hands: Vec<LedHand>,
    /// Names of whatever touches something it must not.
    pub met: Vec<String>,
    /// Names of the links whose joints are at a limit.
    pub strained: Vec<String>,
}

impl Posing {
    /// Every target goes back to where its hand is.
    pub(super) fn recall_all(&mut self) {
        self.targets.clear();
    }
}

impl ViewerState {
    /// The robot that is posed, with the number of its own arms: those of somebody who receives are not led.
    pub(super) fn posed_robot(&self) -> Option<(Arc<Robot>, usize)> {
        let scene = &self.document.scene;
        let robot = assets::library().robot_of(scene).ok()?;
        let own = assets::library().robot(&scene.robot).ok()?.arms.len();
        Some((robot, own))
    }

    /// Where the robot starts, one value per degree of freedom.
    pub(super) fn q_posed(&self, robot: &Robot) -> Option<Vec<f64>> {
        self.document.scene.q_start(robot).ok()
    }

    /// The hands that can be led; none while the page is closed.
    pub(super) fn led_hands(&self) -> Vec<LedHand> {
        let Some((robot, own)) = self.posed_robot().filter(|_| self.posing.is_open) else { return Vec::new() };
        let Some(q) = self.q_posed(&robot) else { return Vec::new() };
        let X_WL = robot.link_poses(&q);
        let hand = |(arm, found): (usize, &endcomfort_core::robot::Arm)| LedHand {
            arm,
            name: found.name.clone(),
            X_WH: X_WL[found.hand.tcp_link],
            target: self.posing.targets.get(arm).cloned().flatten(),
        };
        robot.arms.iter().take(own).enumerate().map(hand).collect()
    }

    /// What the shown pose touches, and how near it comes to everything else.
    pub fn meeting(&self) -> Option<&Meeting> {
        self.posing.meeting.as_ref().filter(|_| self.posing.is_open)
    }

    /// What posing adds to the picture.
    pub fn posing_key(&self) -> PosingKey {
        if !self.posing.is_open {
            return PosingKey::default();
        }
        let hits = self.meeting().map_or(&[][..], |meeting| &meeting.hits);
        let mut met: Vec<String> = hits.iter().flat_map(|hit| [hit.a.clone(), hit.b.clone()]).collect();
        met.sort();
        met.dedup();
        PosingKey { hands: self.led_hands(), met, strained: self.strained() }
    }

    /// Links whose joints are at a limit.
    fn strained(&self) -> Vec<String> {
        let Some((robot, own)) = self.posed_robot() else { return Vec::new() };
        let Some(q) = self.q_posed(&robot) else { return Vec::new() };
        let dofs = robot.arms.iter().take(own).flat_map(|arm| &arm.dofs);
        let joints = dofs.map(|&dof| (&robot.joints[robot.dof_joints[dof]], q[dof]));
        let at_limit = joints.filter(|(joint, value)| {
            let turns_round = joint.limit.upper - joint.limit.lower > std::f64::consts::TAU - 1e-3;
            !turns_round && (value - joint.limit.lower < AT_LIMIT || joint.limit.upper - value < AT_LIMIT)
        });
        at_limit.map(|(joint, _)| robot.links[joint.child].name.clone()).collect()
    }

    pub(super) fn apply_pose(&mut self, command: PoseCommand) -> Vec<Effect> {
        match command {
            PoseCommand::Open => self.open_posing(),
            PoseCommand::Close => {
                self.posing.is_open = false;
                self.posing.targets.clear();
            }
            PoseCommand::Arm(arm) => self.posing.arm = arm,
            PoseCommand::AlongHand(along_hand) => self.posing.along_hand = along_hand,
            PoseCommand::Step(step) => self.posing.step = step.min(STEPS.len() - 1),
            PoseCommand::Lead(arm, X_WH) => return self.lead(arm, &X_WH, true),
            PoseCommand::EndDrag => return self.end_goal_drag(),
            PoseCommand::Jog(jog) => return self.jog(jog),
            PoseCommand::DragJoint(dof, value) => {
                self.forget_target_of(dof);
                return self.set_joints(&[(dof, value)], true);
            }
            PoseCommand::DragFingers(share) => return self.move_fingers(share),
            PoseCommand::Posture(name) => {
                self.posing.targets.clear();
                return self.edit_task(|scene| {
                    scene.posture = name;
                    scene.joints.clear();
                });
            }
            PoseCommand::Recall(arm) => {
                if let Some(target) = self.posing.targets.get_mut(arm) {
                    *target = None;
                }
            }
        }
        Vec::new()
    }

    fn open_posing(&mut self) {
        self.posing.is_open = true;
        self.reaching.is_open = false;
        self.reaching.let_go();
        self.lab.is_open = false;
        self.playback.playing = false;
        self.selection.ik = None;
        self.drawer = Some(Side::Right);
    }

    /// Leads the hand of an arm to a pose; the arm goes there or as near as it gets.
    ///
    /// * `is_held`: while it is dragged, so that all of the drag is one step of undo.
    fn lead(&mut self, arm: usize, X_WH: &Isometry3<f64>, is_held: bool) -> Vec<Effect> {
        let Some((robot, own)) = self.posed_robot() else { return Vec::new() };
        let (Some(q), true) = (self.q_posed(&robot), arm < own && X_WH.translation.vector.amax() <= FARTHEST_M) else {
            return Vec::new();
        };
        let found = &robot.arms[arm];
        let Ok(ik) = ArmIk::of(&robot, found) else { return Vec::new() };
        let now: Vec<f64> = found.dofs.iter().map(|&dof| q[dof]).collect();
        let X_BH = robot.link_poses(&q)[found.base_link].inv_mul(X_WH);
        let followed = ik.follow(&robot, &X_BH, &now);
        self.posing.arm = arm;
        self.posing.targets.resize(own, None);
        self.posing.targets[arm] = followed.short.map(|reason| HandTarget { X_WH: *X_WH, reason });
        let joints: Vec<(usize, f64)> = found.dofs.iter().copied().zip(followed.q).collect();
        self.set_joints(&joints, is_held)
    }

    /// Puts degrees of freedom somewhere within their limits.
    fn set_joints(&mut self, joints: &[(usize, f64)], is_held: bool) -> Vec<Effect> {
        let Some((robot, _)) = self.posed_robot() else { return Vec::new() };
        let named = joints.iter().filter_map(|&(dof, value)| {
            let joint = &robot.joints[*robot.dof_joints.get(dof)?];
            Some((joint.name.clone(), value.max(joint.limit.lower).min(joint.limit.upper)))
        });
        if is_held {
            self.drag(|scene| scene.joints.extend(named))
        } else {
            self.edit_task(|scene| scene.joints.extend(named))
        }
    }

    fn jog(&mut self, jog: Jog) -> Vec<Effect> {
        let arm = self.posing.arm;
        let Some(hand) = self.led_hands().into_iter().nth(arm) else { return Vec::new() };
        let (step_m, step_rad) = STEPS[self.posing.step.min(STEPS.len() - 1)];
        let mut axis = Vector3::zeros();
        axis[jog.axis.min(2)] = if jog.back { -1.0 } else { 1.0 };
        let X_WH = hand.handle();
        let axis = if self.posing.along_hand { X_WH.rotation * axis } else { axis };
        let to = if jog.turns {
            let turn = UnitQuaternion::new(axis * step_rad);
            Isometry3::from_parts(X_WH.translation, turn * X_WH.rotation)
        } else {
            Translation3::from(axis * step_m) * X_WH
        };
        self.lead(arm, &to, false)
    }

    fn move_fingers(&mut self, share: f64) -> Vec<Effect> {
        let Some((robot, own)) = self.posed_robot() else { return Vec::new() };
        let Some(arm) = robot.arms[..own].get(self.posing.arm) else { return Vec::new() };
        let hand = &arm.hand;
        let share = share.max(0.0).min(1.0);
        let dofs = hand.fingers.iter().flatten().zip(hand.open.iter().zip(&hand.closed));
        let joints: Vec<_> = dofs.map(|(&dof, (open, closed))| (dof, closed + share * (open - closed))).collect();
        self.set_joints(&joints, true)
    }

    /// The share to which a hand is open: 1 as its open posture, 0 as its closed one.
    pub(super) fn opening(&self, robot: &Robot, q: &[f64]) -> Option<f64> {
        let hand = &robot.arms.get(self.posing.arm)?.hand;
        let dofs = hand.fingers.iter().flatten().zip(hand.open.iter().zip(&hand.closed));
        let shares = dofs.filter(|(_, (open, closed))| (*open - *closed).abs() > 1e-9);
        let shares: Vec<f64> = shares.map(|(&dof, (open, closed))| (q[dof] - closed) / (open - closed)).collect();
        (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
    }

    /// A joint that is moved by itself takes the hand along, and its target with it.
    fn forget_target_of(&mut self, dof: usize) {
        let Some((robot, _)) = self.posed_robot() else { return };
        for (arm, target) in robot.arms.iter().zip(&mut self.posing.targets) {
            if arm.dofs.contains(&dof) {
                *target = None;
            }
        }
    }

    /// Finds out what the pose touches, while the page is open.
    pub(super) fn look_around(&mut self) {
        if !self.posing.is_open {
            return;
        }
        let Some((robot, _)) = self.posed_robot() else { return };
        let Some(q) = self.q_posed(&robot) else {
            self.posing.meeting = None;
            return;
        };
        let stands_as_before = |around: &Around| {
            let (a, b) = (&around.scene, &self.document.scene);
            let same_boxes = a.table == b.table && a.obstacles == b.obstacles;
            let same_robot = a.robot == b.robot && a.hand == b.hand && a.handover == b.handover;
            let same_fits = match (&around.fits, &self.outputs.fit) {
                (Some(a), Some(b)) => Arc::ptr_eq(a, &b.value),
                (a, b) => a.is_none() && b.is_none(),
            };
            same_fits && same_boxes && same_robot
        };
        if !self.posing.around.as_ref().is_some_and(stands_as_before) {
            let seen = self.outputs.fit.as_ref().zip(self.outputs.segment.as_ref()).map(|(fits, segment)| Seen {
                fits,
                clusters: &segment.clusters,
                is_dropped: self.document.cloud.is_some(),
            });
            let around = Surroundings::of(&self.document.scene, &robot, seen);
            self.posing.around = around.ok().map(|surroundings| Around {
                scene: self.document.scene.clone(),
                fits: self.outputs.fit.as_ref().map(|fit| fit.value.clone()),
                surroundings,
            });
        }
        self.posing.meeting = self.posing.around.as_mut().map(|around| around.surroundings.meets(&q));
    }
}

/// What a joint's value is shown in: the unit, and how many there are of it in one of SI.
pub(super) fn unit_of_joint(kind: JointKind) -> (&'static str, f64) {
    if kind == JointKind::Prismatic { ("mm", 1e3) } else { ("°", 180.0 / std::f64::consts::PI) }
}
