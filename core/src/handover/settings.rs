//! Who takes the object, where they stand, and how a place for handing it over is chosen (thesis chapter 6).

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::scene::{ArmChoice, Freedom, Obstacle, SceneError, check_range, checked_pose};

/// Most boxes that may move with a receiver.
const MAX_FURNITURE: usize = 32;
/// Nobody stands farther than this from the robot, metres.
const MAX_APART_M: f64 = 5.0;

/// Model of a receiver that is a person.
pub const PERSON: &str = "human";

/// The object goes from the hand that takes it to another hand before it goes to its goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Handover {
    /// Who receives it.
    pub receiver: Receiver,
    /// Arm that gives; `None` leaves it to the program: the one that reaches the object better.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub giver_arm: Option<ArmChoice>,
    /// How the place of the handover is chosen.
    #[serde(default)]
    pub choice: PlaceChoice,
}

/// Who receives the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Receiver {
    /// The robot's own other hand (6.1).
    OtherHand,
    /// Somebody else (6.2).
    Agent(Box<Agent>),
}

/// Another robot, or a person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    /// Its model: `hubo` or `human`.
    pub model: String,
    /// Posture (of its SRDF) in which it waits.
    pub posture: String,
    /// Where it stands in the world's x and y, metres.
    pub position_m: [f64; 2],
    /// Height of what it stands, sits or kneels on, metres above the floor.
    #[serde(default)]
    pub floor_m: f64,
    /// Which way it looks: 0 along the world's x, away from the giver; rad.
    pub yaw_rad: f64,
    /// Arm that receives; `None` leaves it to the program: the one whose shoulder is nearer to the giver's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<ArmChoice>,
    /// Boxes that stand with it: a tray, a stool. Their `X_WB` are poses in its frame A on the floor: x where it looks,
    /// z up.
    #[serde(default)]
    pub furniture: Vec<Obstacle>,
    /// Where it brings the object; without a goal it draws the object to itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<AgentGoal>,
}

/// Where a receiver brings the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentGoal {
    /// Pose of the object's frame O in the frame A in which the agent stands: origin on the floor below it, x where it
    /// looks, z up.
    pub X_AO: Isometry3<f64>,
    /// It is put down there and let go; otherwise held there.
    pub lets_go: bool,
    /// How far the object may end up from that pose.
    #[serde(default, skip_serializing_if = "Freedom::is_none")]
    pub freedom: Freedom,
}

/// How a place for the handover is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PlaceChoice {
    /// Share of its arm's largest mean manipulability that a voxel needs for either hand (6.1).
    pub threshold: f64,
    /// The receiver's manipulability comes first, its hand along the line that joins the shoulders (6.2), and of a person
    /// its comfort; otherwise the place nearest to the way from start to goal (6.1).
    pub receiver_first: bool,
    /// Places that are looked at more closely.
    pub places: usize,
    /// Top speed of the giver's hand on its way to a person, m/s.
    pub hand_speed_m_s: f64,
}

impl Default for PlaceChoice {
    fn default() -> Self {
        Self { threshold: 0.35, receiver_first: true, places: 24, hand_speed_m_s: 0.25 }
    }
}

impl Handover {
    /// The receiver, if it is not the robot itself.
    pub fn agent(&self) -> Option<&Agent> {
        match &self.receiver {
            Receiver::OtherHand => None,
            Receiver::Agent(agent) => Some(agent),
        }
    }

    /// Checks the numbers and brings rotations to unit length.
    ///
    /// # Errors
    /// [`SceneError`] naming the place, what was found and what was wanted.
    pub(crate) fn check(&mut self) -> Result<(), SceneError> {
        let PlaceChoice { threshold, places, hand_speed_m_s, .. } = self.choice;
        check_range("handover.choice.threshold", threshold, 0.0, 1.0)?;
        check_range("handover.choice.places", places as f64, 1.0, 500.0)?;
        check_range("handover.choice.hand_speed_m_s", hand_speed_m_s, 0.01, 5.0)?;
        let Receiver::Agent(agent) = &mut self.receiver else { return Ok(()) };
        let [x, y] = agent.position_m;
        for (name, value, most) in [
            ("position_m[0]", x, MAX_APART_M),
            ("position_m[1]", y, MAX_APART_M),
            ("floor_m", agent.floor_m, 2.0),
            ("yaw_rad", agent.yaw_rad, 7.0),
        ] {
            check_range(&format!("handover.receiver.{name}"), value, -most, most)?;
        }
        let count = agent.furniture.len() as f64;
        check_range("handover.receiver.furniture: number of boxes", count, 0.0, MAX_FURNITURE as f64)?;
        for (index, piece) in agent.furniture.iter_mut().enumerate() {
            let place = format!("handover.receiver.furniture[{index}]");
            checked_pose(&format!("{place}.X_WB"), &mut piece.X_WB)?;
            for size_m in &piece.size_m {
                check_range(&format!("{place}.size_m"), *size_m, 1e-4, 10.0)?;
            }
        }
        if let Some(goal) = &mut agent.goal {
            checked_pose("handover.receiver.goal.X_AO", &mut goal.X_AO)?;
        }
        Ok(())
    }
}

impl Agent {
    /// Pose in the world of the frame A in which it stands: on the floor below it, x where it looks.
    pub fn X_WA(&self) -> Isometry3<f64> {
        let [x, y] = self.position_m;
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.yaw_rad);
        Isometry3::from_parts(Translation3::new(x, y, 0.0), turn)
    }

    /// Its furniture in the world.
    pub fn furniture_W(&self) -> impl Iterator<Item = Obstacle> {
        let X_WA = self.X_WA();
        self.furniture.iter().map(move |piece| Obstacle { X_WB: X_WA * piece.X_WB, ..piece.clone() })
    }
}
