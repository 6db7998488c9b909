//! Choosing the place of a handover and the two grasps: everything but the motions.

use std::sync::OnceLock;

use nalgebra::{Isometry3, Translation3, Vector3};

use super::Comfort;
use super::effort::Effort;
use super::places::{Spot, SpotPose, Way, spots};
use super::plan::HandoverTask;
use super::settings::PlaceChoice;
use super::side::{Candidate, Held, Side};
use crate::grasp::Grasp;
use crate::parallel;

/// Spots that are looked at in one go; within one the answers do not depend on each other.
const AT_ONCE: usize = 32;
/// Most spots that are looked at.
const MOST_SPOTS: usize = 4000;
/// Places nearer to each other than this are one, metres.
const APART_M: f64 = 0.075;
/// What the hand along the line of the shoulders, the giver's manipulability and a person's discomfort count for, the
/// receiver's manipulability (its share of the best) counting for 1.
const LINE_WEIGHT: f64 = 0.3;
const GIVER_WEIGHT: f64 = 0.2;
const COMFORT_WEIGHT: f64 = 1.0;
/// What it counts for that the receiver gets the object by its handle.
const HANDLE_WEIGHT: f64 = 0.5;
/// Configurations of an arm that are kept.
const KEPT: usize = 6;
/// Giver's grasps of which the most manipulable is taken.
const COMPARED_GIVERS: usize = 3;

/// A place at which both can hold the object.
pub(super) struct Choice {
    pub(super) spot: Spot,
    pub(super) X_WO: Isometry3<f64>,
    /// Indices of the candidates of giver and receiver.
    pub(super) candidates: [usize; 2],
    /// Configurations of the arms, the most manipulable first.
    pub(super) q: [Vec<Vec<f64>>; 2],
    pub(super) m_g: [f64; 2],
    pub(super) off_line_rad: f64,
    pub(super) by_handle: bool,
    pub(super) comfort: Option<Comfort>,
    pub(super) score: f64,
}

/// What a receiver's arm posture costs it, if it is a person: its joints.
pub(super) type Cost<'a> = dyn Fn(&[f64]) -> Option<Comfort> + Sync + 'a;

/// Places in the order of their score, and how many voxels both reach.
#[derive(Default)]
pub(super) struct Choices {
    pub(super) choices: Vec<Choice>,
    pub(super) voxels: usize,
    /// Spots that were looked at.
    pub(super) looked_at: usize,
}

/// Looks at one spot after the other until enough places are found.
pub(super) fn choose(
    look: &Look<'_>,
    way: &Way,
    settings: &PlaceChoice,
    should_stop: &(dyn Fn() -> bool + Sync),
) -> Choices {
    let (spots, voxels) = spots([look.giver, look.receiver], way, settings, look.effort);
    let mut choices: Vec<Choice> = Vec::new();
    let mut looked_at = 0;
    for some in spots[..spots.len().min(MOST_SPOTS)].chunks(AT_ONCE) {
        if choices.len() >= settings.places || should_stop() {
            break;
        }
        looked_at += some.len();
        for choice in parallel::map(some, |spot| look.at(spot)).into_iter().flatten() {
            let near = |known: &Choice| (known.spot.voxel - choice.spot.voxel).norm() < APART_M;
            match choices.iter_mut().find(|known| near(known)) {
                Some(known) if known.score < choice.score => *known = choice,
                Some(_) => {}
                None => choices.push(choice),
            }
        }
    }
    // A stable sort: equal ones stay in the order in which they were found.
    choices.sort_by(|l, r| r.score.total_cmp(&l.score));
    choices.truncate(settings.places);
    Choices { choices, voxels, looked_at }
}

/// Both sides, and what counts at a spot.
pub(super) struct Look<'a> {
    task: &'a HandoverTask<'a>,
    giver: &'a Side<'a>,
    receiver: &'a Side<'a>,
    effort: Effort,
    /// Whether a pair of candidates leaves room for both hands, the receiver's first: the same wherever the object is.
    both: Vec<OnceLock<bool>>,
}

/// What is known about a pose of the object and the giver there.
#[derive(Default)]
struct Given {
    promising: Option<Vec<usize>>,
    held: Vec<Option<Option<Held>>>,
}

impl<'a> Look<'a> {
    pub(super) fn new(task: &'a HandoverTask<'a>, [giver, receiver]: [&'a Side<'a>; 2], effort: Effort) -> Self {
        let pairs = giver.candidates.len() * receiver.candidates.len();
        let both = std::iter::repeat_with(OnceLock::new).take(pairs).collect();
        Self { task, giver, receiver, effort, both }
    }

    /// The best pair of grasps at a spot.
    fn at(&self, spot: &Spot) -> Option<Choice> {
        match &spot.pose {
            SpotPose::ReceiverHand(X_WH) => {
                self.receiver.promise(X_WH, self.effort)?;
                let takes = 0..self.receiver.candidates.len();
                let free = takes.filter(|&take| self.receiver.candidates[take].hand.first_hit(X_WH).is_none());
                let free: Vec<usize> = free.take(self.effort.tried_grasps()).collect();
                if free.is_empty() {
                    return None;
                }
                // The arm is the same for all grasps of this hand pose; only the closed fingers differ.
                let held = self.receiver.configurations(X_WH).ok()?;
                free.into_iter().find_map(|take| {
                    let X_WO = X_WH * self.receiver.candidates[take].grasp.X_OH.inverse();
                    let (give, given) = self.best_giver(&X_WO, take, &mut Given::default())?;
                    self.receiver.serving(&self.receiver.candidates[take])?;
                    Some(self.choice(spot, X_WO, [give, take], given, &held))
                })
            }
            SpotPose::Object(X_WO) => {
                let mut given = Given::default();
                let candidates = self.receiver.candidates.iter().enumerate();
                let held = candidates.filter_map(|(take, candidate)| {
                    let X_WH = X_WO * candidate.grasp.X_OH;
                    self.receiver.promise(&X_WH, self.effort)?;
                    self.receiver.held(candidate, &X_WH).ok().map(|held| (take, held))
                });
                held.take(self.effort.tried_grasps()).find_map(|(take, held)| {
                    let (give, given) = self.best_giver(X_WO, take, &mut given)?;
                    self.receiver.serving(&self.receiver.candidates[take])?;
                    Some(self.choice(spot, *X_WO, [give, take], given, &held))
                })
            }
        }
    }

    /// The giver's most manipulable grasp that leaves room for the receiver's; what is found out about a pose of the
    /// object is kept.
    fn best_giver(&self, X_WO: &Isometry3<f64>, take: usize, known: &mut Given) -> Option<(usize, Held)> {
        let Given { promising, held } = known;
        let mut best: Option<(usize, f64)> = None;
        let mut found = 0;
        held.resize_with(self.giver.candidates.len(), || None);
        for &give in promising.get_or_insert_with(|| self.promising_givers(X_WO)).iter() {
            if !self.come_and_go(give, take) {
                continue;
            }
            let candidate = &self.giver.candidates[give];
            let look = || self.giver.held(candidate, &(X_WO * candidate.grasp.X_OH)).ok();
            let Some(held) = held[give].get_or_insert_with(look) else { continue };
            found += 1;
            if best.is_none_or(|(_, m_g)| m_g < held.m_g) {
                best = Some((give, held.m_g));
            }
            if found == COMPARED_GIVERS {
                break;
            }
        }
        let (give, _) = best?;
        Some((give, held[give].clone()??))
    }

    /// The giver's grasps of which its map promises something at a pose of the object, the most manipulable first; none
    /// where the object itself cannot be.
    fn promising_givers(&self, X_WO: &Isometry3<f64>) -> Vec<usize> {
        if self.giver.cell.object_hits(X_WO).is_some() {
            return Vec::new();
        }
        let promise = |give: usize| {
            let X_WH = X_WO * self.giver.candidates[give].grasp.X_OH;
            self.giver.promise(&X_WH, self.effort).map(|m| (give, m))
        };
        let mut promising: Vec<(usize, f64)> = (0..self.giver.candidates.len()).filter_map(promise).collect();
        // A stable sort: equal ones stay in the order of the candidates.
        promising.sort_by(|l, r| r.1.total_cmp(&l.1));
        promising.into_iter().map(|(give, _)| give).collect()
    }

    /// Whether both hands can hold the object together, the receiver's open hand can come while the giver holds it, and
    /// the giver's open hand can leave while the receiver does. Everything is in the object's frame.
    fn come_and_go(&self, give: usize, take: usize) -> bool {
        let known = &self.both[take * self.giver.candidates.len() + give];
        *known.get_or_init(|| self.find_room(&self.giver.candidates[give], &self.receiver.candidates[take]))
    }

    fn find_room(&self, give: &Candidate, take: &Candidate) -> bool {
        if give.hand.first_hit_with(&give.grasp.X_OH, &take.hand, &take.grasp.X_OH).is_some() {
            return false;
        }
        let away = |grasp: &Grasp, share: f64| {
            grasp.X_OH * Translation3::new(0.0, 0.0, -share * self.task.motion.min_approach_m)
        };
        [0.0, 0.3, 0.7, 1.0].iter().all(|&share| {
            let (leaves, comes) = (away(&give.grasp, share), away(&take.grasp, share));
            let [open_give, open_take] = [&self.giver.open, &self.receiver.open];
            open_give.first_hit_with(&leaves, &take.hand, &take.grasp.X_OH).is_none()
                && open_take.first_hit_with(&comes, &give.hand, &give.grasp.X_OH).is_none()
        })
    }

    fn choice(&self, spot: &Spot, X_WO: Isometry3<f64>, candidates: [usize; 2], give: Held, take: &Held) -> Choice {
        let taking = &self.receiver.candidates[candidates[1]].grasp;
        let approach = X_WO * taking.X_OH * Vector3::z();
        let line = self.giver.shoulder() - self.receiver.shoulder();
        let off_line_rad = approach.angle(&line);
        let mut q_take: Vec<Vec<f64>> = take.q.iter().take(KEPT).cloned().collect();
        let mut comfort = None;
        if self.task.choice.receiver_first {
            // A person takes the posture that costs least.
            let mut costs: Vec<(f64, Option<Comfort>, Vec<f64>)> = take
                .q
                .iter()
                .map(|q| {
                    let comfort = (self.task.cost)(q);
                    (comfort.map_or(0.0, |comfort| comfort.total), comfort, q.clone())
                })
                .collect();
            costs.sort_by(|l, r| l.0.total_cmp(&r.0));
            comfort = costs.first().and_then(|(_, comfort, _)| *comfort);
            q_take = costs.into_iter().take(KEPT).map(|(_, _, q)| q).collect();
        } else if let Some(q) = q_take.first() {
            comfort = (self.task.cost)(q);
        }
        let m_g = [give.m_g, take.m_g];
        let by_handle = self.task.handle == Some(taking.part);
        let score = if self.task.choice.receiver_first {
            take.m_g / self.receiver.most_of_arm()
                + LINE_WEIGHT * 0.5 * (1.0 + libm::cos(off_line_rad))
                + if by_handle { HANDLE_WEIGHT } else { 0.0 }
                + GIVER_WEIGHT * give.m_g / self.giver.most_of_arm()
                - COMFORT_WEIGHT * comfort.map_or(0.0, |comfort| comfort.total)
        } else {
            -spot.off_way_m
        };
        let q = [give.q.into_iter().take(KEPT).collect(), q_take];
        Choice { spot: spot.clone(), X_WO, candidates, q, m_g, off_line_rad, by_handle, comfort, score }
    }
}
