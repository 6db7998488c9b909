//! What can be told of a grasp in one number: the columns of the table, of the colours and of the exports.

use serde::{Deserialize, Serialize};

use super::Grasp;

/// One number of a grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Mean manipulability m_g at the start (5.2).
    MgStart,
    /// Mean manipulability m_g at the goal (5.2).
    MgGoal,
    /// Mean of both.
    MgMean,
    /// N at the start.
    IkStart,
    /// N at the goal.
    IkGoal,
    /// Weighted score.
    Score,
    /// Largest-ball quality ε.
    Epsilon,
    /// Volume of the grasp wrench space.
    Volume,
    /// Success probability under pose noise.
    Success,
    /// Distance of the hand from table and neighbours.
    Clearance,
    /// Width between the outermost contacts.
    Width,
    /// Number of contacts.
    Contacts,
}

impl Quantity {
    /// All quantities in the order of the exports.
    pub const ALL: [Self; 12] = [
        Self::MgStart,
        Self::MgGoal,
        Self::MgMean,
        Self::IkStart,
        Self::IkGoal,
        Self::Score,
        Self::Epsilon,
        Self::Volume,
        Self::Success,
        Self::Clearance,
        Self::Width,
        Self::Contacts,
    ];

    /// Name in JSON, CSV and on the command line, with its unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::MgStart => "m_g_start",
            Self::MgGoal => "m_g_goal",
            Self::MgMean => "m_g_mean",
            Self::IkStart => "ik_count_start",
            Self::IkGoal => "ik_count_goal",
            Self::Score => "score",
            Self::Epsilon => "epsilon",
            Self::Volume => "gws_volume",
            Self::Success => "success_probability",
            Self::Clearance => "clearance_m",
            Self::Width => "width_m",
            Self::Contacts => "contacts",
        }
    }

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::MgStart => "Mean manipulability at the start",
            Self::MgGoal => "Mean manipulability at the goal",
            Self::MgMean => "Mean manipulability, start and goal averaged",
            Self::IkStart => "IK solutions at the start",
            Self::IkGoal => "IK solutions at the goal",
            Self::Score => "Weighted score",
            Self::Epsilon => "Largest-ball quality ε",
            Self::Volume => "Volume of the grasp wrench space",
            Self::Success => "Success probability under pose noise",
            Self::Clearance => "Distance from table and neighbours",
            Self::Width => "Width between the contacts",
            Self::Contacts => "Contacts",
        }
    }

    /// The value, SI units; `None` where the grasp never came so far.
    pub fn of(self, grasp: &Grasp) -> Option<f64> {
        let (start, goal) = (grasp.start.as_ref(), grasp.goal.as_ref());
        let has_contacts = !grasp.contacts.is_empty();
        match self {
            Self::MgStart => start.map(|set| set.m_g),
            Self::MgGoal => goal.map(|_| at_stops(grasp)),
            Self::MgMean => start.filter(|_| goal.is_some()).map(|start| 0.5 * (start.m_g + at_stops(grasp))),
            Self::IkStart => start.map(|set| set.ik_count as f64),
            Self::IkGoal => goal.map(|_| grasp.stops().map(|set| set.ik_count as f64).fold(f64::INFINITY, f64::min)),
            Self::Score => grasp.score.as_ref().map(|score| score.total),
            Self::Epsilon => has_contacts.then_some(grasp.epsilon),
            Self::Volume => grasp.volume,
            Self::Success => grasp.success.map(|success| success.probability()),
            Self::Clearance => grasp.clearance_m,
            Self::Width => has_contacts.then_some(grasp.width_m),
            Self::Contacts => Some(grasp.contacts.len() as f64),
        }
    }
}

/// Mean of m_g over all stops after the start: with one goal, m_g there.
fn at_stops(grasp: &Grasp) -> f64 {
    let (sum, count) = grasp.stops().fold((0.0, 0_u32), |(sum, count), set| (sum + set.m_g, count + 1));
    sum / f64::from(count.max(1))
}
