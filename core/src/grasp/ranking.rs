//! The order of accepted grasps: by m_g (thesis 5.1), by a weighted score with visible terms, or by the controls of
//! Table 5.1.

use serde::{Deserialize, Serialize};

use super::{Grasp, Quantity};
use crate::rng::Rng;

/// Stream of the random order.
const RANDOM_STREAM: u64 = 0x7261_6e6b;

/// How grasps are ordered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RankSettings {
    /// What counts.
    pub by: RankBy,
    /// Weights of the score, by term; a term that is not named has weight 0.
    pub weights: Weights,
    /// Arm angles over a full turn at which IK sets are sampled.
    pub arm_angles: usize,
    /// Whether a grasp needs a straight way in and out at both poses to be accepted; the thesis asks for IK alone.
    pub straight_ways: bool,
}

impl Default for RankSettings {
    fn default() -> Self {
        Self { by: RankBy::Goal, weights: Weights::default(), arm_angles: 24, straight_ways: true }
    }
}

/// What grasps are ordered by; the first is best.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RankBy {
    /// m_g at the goal: the end-comfort effect.
    #[default]
    Goal,
    /// m_g at the start.
    Start,
    /// The mean of both.
    Mean,
    /// The weighted score.
    Score,
    /// ε alone: a control.
    Epsilon,
    /// A random order of the scene's seed: a control.
    Random,
}

impl RankBy {
    /// All orders.
    pub const ALL: [Self; 6] = [Self::Goal, Self::Start, Self::Mean, Self::Score, Self::Epsilon, Self::Random];

    /// The name in JSON and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Goal => "goal",
            Self::Start => "start",
            Self::Mean => "mean",
            Self::Score => "score",
            Self::Epsilon => "epsilon",
            Self::Random => "random",
        }
    }

    /// The quantity that decides; a task without a goal has its start alone. `None` for a random order.
    pub fn quantity(self, has_goal: bool) -> Option<Quantity> {
        Some(match self {
            Self::Goal if has_goal => Quantity::MgGoal,
            Self::Mean if has_goal => Quantity::MgMean,
            Self::Goal | Self::Start | Self::Mean => Quantity::MgStart,
            Self::Score => Quantity::Score,
            Self::Epsilon => Quantity::Epsilon,
            Self::Random => return None,
        })
    }
}

/// Weights of the score's terms, 0 or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Weights {
    /// Of m_g at the goal.
    pub m_g_goal: f64,
    /// Of m_g at the start.
    pub m_g_start: f64,
    /// Of N, the smaller one of start and goal.
    pub ik_count: f64,
    /// Of ε.
    pub epsilon: f64,
    /// Of the success probability.
    pub success: f64,
    /// Of the clearance.
    pub clearance: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { m_g_goal: 1.0, m_g_start: 0.5, ik_count: 0.25, epsilon: 0.25, success: 0.5, clearance: 0.25 }
    }
}

/// The weighted score of a grasp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Sum of weight times share over all terms, divided by the sum of the weights: in [0, 1].
    pub total: f64,
    /// What it is made of.
    pub terms: Vec<Term>,
}

/// One term of a score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Its name, that of the weight.
    pub name: String,
    /// Its weight.
    pub weight: f64,
    /// The grasp's value divided by the largest of all accepted grasps, in [0, 1].
    pub share: f64,
}

/// Orders grasps: accepted ones first, best first, equal ones by number; then the others by number. The scores
/// are filled in when they decide.
pub fn rank(grasps: &mut [Grasp], settings: &RankSettings, seed: u64) {
    match settings.by {
        RankBy::Score => score(grasps, &settings.weights),
        _ => grasps.iter_mut().for_each(|grasp| grasp.score = None),
    }
    let has_goal = grasps.iter().any(|grasp| grasp.is_accepted() && grasp.goal.is_some());
    let quantity = settings.by.quantity(has_goal);
    let key = |grasp: &Grasp| match quantity {
        _ if !grasp.is_accepted() => f64::NEG_INFINITY,
        Some(quantity) => quantity.of(grasp).unwrap_or(f64::NEG_INFINITY),
        None => Rng::new(seed, RANDOM_STREAM ^ (u64::from(grasp.id) << 32)).unit(),
    };
    grasps.sort_by(|l, r| {
        let by_key = || key(r).total_cmp(&key(l));
        r.is_accepted().cmp(&l.is_accepted()).then_with(by_key).then_with(|| l.id.cmp(&r.id))
    });
}

/// A term's value, 0 or more.
type ValueOf = fn(&Grasp) -> f64;

/// The scores of all accepted grasps.
fn score(grasps: &mut [Grasp], weights: &Weights) {
    let terms: [(&str, f64, ValueOf); 6] = [
        ("m_g_goal", weights.m_g_goal, |g| Quantity::MgGoal.of(g).unwrap_or(0.0)),
        ("m_g_start", weights.m_g_start, |g| Quantity::MgStart.of(g).unwrap_or(0.0)),
        ("ik_count", weights.ik_count, |g| {
            let counts = [Quantity::IkStart.of(g), Quantity::IkGoal.of(g)];
            counts.into_iter().flatten().fold(f64::INFINITY, f64::min)
        }),
        ("epsilon", weights.epsilon, |g| g.epsilon),
        ("success", weights.success, |g| Quantity::Success.of(g).unwrap_or(0.0)),
        ("clearance", weights.clearance, |g| g.clearance_m.unwrap_or(0.0).max(0.0)),
    ];
    let largest = terms.map(|(_, _, value)| {
        let accepted = grasps.iter().filter(|grasp| grasp.is_accepted());
        accepted.map(value).filter(|value| value.is_finite()).fold(0.0, f64::max)
    });
    let sum: f64 = terms.iter().map(|(_, weight, _)| weight).sum();
    for grasp in grasps.iter_mut() {
        grasp.score = grasp.is_accepted().then(|| {
            let share = |value: f64, of: f64| if of > 0.0 { (value / of).min(1.0) } else { 0.0 };
            let terms: Vec<Term> = terms
                .iter()
                .zip(largest)
                .map(|((name, weight, value), of)| Term {
                    name: (*name).to_owned(),
                    weight: *weight,
                    share: share(value(grasp), of),
                })
                .collect();
            let total: f64 = terms.iter().map(|term| term.weight * term.share).sum();
            Score { total: if sum > 0.0 { total / sum } else { 0.0 }, terms }
        });
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::grasp::{GraspStatus, Situated, Success};

    /// A grasp with these m_g at start and goal, and this ε.
    fn grasp(id: u32, start: f64, goal: f64, epsilon: f64) -> Grasp {
        let set = |m_g: f64| Some(Situated { m_g, ik_count: 10 + id as usize, ..Situated::default() });
        Grasp {
            id,
            part: 0,
            X_OH: Isometry3::identity(),
            closed: Vec::new(),
            contacts: vec![crate::grasp::Contact {
                p_O: nalgebra::Point3::origin(),
                n_O: nalgebra::Vector3::z(),
                penetration_m: 0.0,
                link: "palm".into(),
            }],
            width_m: 0.05,
            epsilon,
            volume: None,
            success: Some(Success { held: id, trials: 10 }),
            clearance_m: Some(0.01 * f64::from(id)),
            score: None,
            start: set(start),
            via: Vec::new(),
            goal: set(goal),
            status: GraspStatus::Accepted,
        }
    }

    fn order(by: RankBy, weights: Weights, seed: u64) -> Vec<u32> {
        let mut grasps = vec![grasp(0, 0.09, 0.02, 0.3), grasp(1, 0.05, 0.09, 0.1), grasp(2, 0.08, 0.07, 0.2)];
        grasps.push(Grasp { status: GraspStatus::TooFewContacts { found: 1, wanted: 3 }, ..grasp(3, 1.0, 1.0, 1.0) });
        rank(&mut grasps, &RankSettings { by, weights, ..RankSettings::default() }, seed);
        assert!(!grasps[3].is_accepted() && grasps[3].score.is_none(), "what is rejected comes last");
        for grasp in &grasps[..3] {
            assert_eq!(grasp.score.is_some(), by == RankBy::Score);
            for term in grasp.score.iter().flat_map(|score| &score.terms) {
                assert!((0.0..=1.0).contains(&term.share), "{term:?}");
            }
        }
        grasps[..3].iter().map(|grasp| grasp.id).collect()
    }

    #[test]
    fn every_order_puts_its_own_best_first() {
        let usual = Weights::default();
        assert_eq!(order(RankBy::Start, usual, 1), [0, 2, 1]);
        assert_eq!(order(RankBy::Goal, usual, 1), [1, 2, 0]);
        assert_eq!(order(RankBy::Mean, usual, 1), [2, 1, 0]);
        assert_eq!(order(RankBy::Epsilon, usual, 1), [0, 2, 1]);
    }

    #[test]
    fn a_score_of_one_term_orders_by_that_term_and_one_of_none_by_number() {
        let none = Weights { m_g_goal: 0.0, m_g_start: 0.0, ik_count: 0.0, epsilon: 0.0, success: 0.0, clearance: 0.0 };
        assert_eq!(order(RankBy::Score, Weights { m_g_goal: 2.0, ..none }, 1), [1, 2, 0]);
        assert_eq!(order(RankBy::Score, Weights { success: 0.1, ..none }, 1), [2, 1, 0]);
        assert_eq!(order(RankBy::Score, none, 1), [0, 1, 2]);
    }

    #[test]
    fn a_random_order_depends_on_the_seed_alone() {
        let orders: Vec<_> = (0..30).map(|seed| order(RankBy::Random, Weights::default(), seed)).collect();
        assert_eq!(orders[7], order(RankBy::Random, Weights::default(), 7));
        let different = |first: u32| orders.iter().filter(|order| order[0] == first).count();
        assert!((0..3).all(|first| different(first) > 3), "each comes first sometimes");
    }
}
