//! Inverse sampling: every pose of the map is solved for the joints in closed form.

use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{Isometry3, Point3, Vector3};

use super::about::{About, ReachMethod};
use super::clear::SelfClear;
use super::closed::{ARM_ANGLES, ClosedForm, Code};
use super::grid::Grid;
use super::map::{Data, Reached, SPOTS};
use super::recipe::Recipe;
use super::{Orientations, ReachError, ReachMap};
use crate::collision::Scratch;
use crate::robot::ik::IkSet;
use crate::robot::{Chain, Dexterity, JointLimit, Placed, Robot};
use crate::watch::Watch;

/// Arm angles at which a pose is solved first; where none of them is within the limits, all of [`ARM_ANGLES`] are tried.
const FIRST_ANGLES: usize = 8;
/// Configurations that are computed side by side.
const BATCH: usize = 16;

/// What an inverse map is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseSettings {
    /// Edge length of the voxels, metres.
    pub voxel_m: f64,
    /// Orientations told apart in each voxel: 40 or 272.
    pub orientations: usize,
}

impl Default for InverseSettings {
    fn default() -> Self {
        Self { voxel_m: 0.05, orientations: 40 }
    }
}

/// The map of an S-R-S arm by inverse sampling; give [`Robot::with_torso`] for a map with the torso.
///
/// Each orientation of the set is put at the centre of each voxel and solved in closed form at 8 arm angles (32 where
/// these give nothing); a torso stands at 7 positions. Configurations within the limits in which the robot does not
/// touch itself compete by manipulability (5.1), those of equal manipulability by the room that they leave to the
/// limits. A voxel of which nothing is reached at its centre is tried near its corners, and the corner with the most
/// orientations stands for it: so the rim of the workspace, where a centre lies just outside, is in the map.
///
/// * `arm`: index into [`Robot::arms`].
///
/// # Errors
/// [`ReachError`] when the arm is not S-R-S, a setting is none that there is, or the watch says stop.
pub fn build_inverse(
    robot: &Robot,
    arm: usize,
    settings: &InverseSettings,
    watch: Watch<'_>,
) -> Result<ReachMap, ReachError> {
    let mapped = About::arm(robot, arm)?;
    let count = settings.orientations;
    let orientations = Orientations::new(count).ok_or(ReachError::BadOrientations { found: count })?;
    if count == 1 {
        return Err(ReachError::NeedsOrientations);
    }
    let closed = ClosedForm::of(robot, &robot.arms[arm])?;
    let chain = Chain::between(robot, robot.arms[arm].base_link, robot.arms[arm].hand.tcp_link)?;
    let reach = Vector3::repeat(closed.reach_m());
    let shoulders = || closed.stands.iter().map(|stand| stand.p_BS.coords);
    let lower = shoulders().fold(Vector3::repeat(f64::INFINITY), |low, p| low.inf(&p)) - reach;
    let upper = shoulders().fold(Vector3::repeat(f64::NEG_INFINITY), |high, p| high.sup(&p)) + reach;
    let grid = Grid::around(&lower.into(), &upper.into(), settings.voxel_m)?;
    let p_HW = closed.srs.wrist().coords;
    let job = Job {
        clear: SelfClear::of(robot, arm)?,
        to_wrist: orientations.rotations().iter().map(|rotation| rotation * p_HW).collect(),
        closed,
        chain,
        grid,
        orientations,
    };

    let rows: Vec<usize> = (0..job.grid.count()).step_by(job.grid.size[0]).collect();
    let done = AtomicUsize::new(0);
    let found = crate::parallel::map(&rows, |&first| {
        if watch.should_stop() {
            return None;
        }
        let mut worker = Worker::new(&job);
        let row: Vec<Solved> = (first..first + job.grid.size[0]).map(|voxel| worker.voxel(voxel)).collect();
        let share = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / rows.len() as f64;
        watch.progress(share, &format!("{:.0} % of the voxels", 100.0 * share));
        Some(row)
    });
    let found: Vec<Vec<Solved>> = found.into_iter().collect::<Option<_>>().ok_or(ReachError::Cancelled)?;
    let (mut reached, mut spots) = (Vec::new(), Vec::with_capacity(job.grid.count()));
    for solved in found.into_iter().flatten() {
        spots.push(solved.spot);
        reached.extend(solved.reached);
    }
    let method = ReachMethod::Inverse { torso_positions: job.closed.stands.len() as u8 };
    let about = About { arm: mapped, method };
    let recipe = Recipe::Closed(Box::new(job.closed));
    Ok(ReachMap::new(Data::assemble(about, &job.grid, job.orientations, &reached, &spots, recipe)))
}

/// What all voxels share.
struct Job {
    closed: ClosedForm,
    chain: Chain,
    clear: SelfClear,
    grid: Grid,
    orientations: Orientations,
    /// From the hand to the wrist, for each orientation, in B.
    to_wrist: Vec<Vector3<f64>>,
}

/// What is reached of one voxel, and at which of its points.
#[derive(Default)]
struct Solved {
    spot: u8,
    reached: Vec<Reached>,
}

/// Working memory of one thread.
struct Worker<'a> {
    job: &'a Job,
    dexterity: Dexterity<'a>,
    scratch: Scratch,
    found: IkSet,
    /// Configurations of all poses of a voxel, one after the other.
    q: Vec<f64>,
    candidates: Vec<Candidate>,
    /// The poses that have any: orientation, and where their candidates begin.
    poses: Vec<(u16, usize)>,
    /// One configuration of each group, and its manipulability.
    group_q: Vec<f64>,
    placed: Vec<Placed>,
}

#[derive(Clone, Copy)]
struct Candidate {
    code: u32,
    /// Candidates of one arm angle have their joint axes in the same lines, hence the same manipulability.
    group: usize,
    /// Which configuration of the list.
    index: usize,
    /// Least distance of a joint from its limits, as a share of its range.
    room: f64,
}

impl<'a> Worker<'a> {
    fn new(job: &'a Job) -> Self {
        Self {
            job,
            dexterity: Dexterity::new(&job.chain),
            scratch: Scratch::default(),
            found: IkSet::default(),
            q: Vec::new(),
            candidates: Vec::new(),
            poses: Vec::new(),
            group_q: Vec::new(),
            placed: Vec::new(),
        }
    }

    fn voxel(&mut self, voxel: usize) -> Solved {
        let closed = &self.job.closed;
        let center = self.job.grid.point(voxel, &SPOTS[0]);
        // No point of the voxel is farther from its centre than this.
        let farthest_m = closed.reach_m() + self.job.grid.voxel_m;
        if closed.stands.iter().all(|stand| (center - stand.p_BS).norm() > farthest_m) {
            return Solved::default();
        }
        let mut best = Solved { spot: 0, reached: self.solve(voxel, &center) };
        if best.reached.is_empty() {
            for (spot, offset) in (0_u8..).zip(&SPOTS).skip(1) {
                let reached = self.solve(voxel, &self.job.grid.point(voxel, offset));
                if reached.len() > best.reached.len() {
                    best = Solved { spot, reached };
                }
            }
        }
        best
    }

    /// All orientations at one point.
    fn solve(&mut self, voxel: usize, p_BH: &Point3<f64>) -> Vec<Reached> {
        self.q.clear();
        self.candidates.clear();
        self.poses.clear();
        self.group_q.clear();
        for orientation in 0..self.job.orientations.count() {
            let begin = self.candidates.len();
            self.sweep(p_BH, orientation, FIRST_ANGLES);
            if self.candidates.len() == begin {
                self.sweep(p_BH, orientation, ARM_ANGLES);
            }
            if self.candidates.len() > begin {
                self.poses.push((orientation as u16, begin));
            }
        }
        if self.poses.is_empty() {
            return Vec::new();
        }
        self.measure();
        let Self { job, scratch, q, candidates, poses, placed, .. } = self;
        let end_of = |pose: usize| poses.get(pose + 1).map_or(candidates.len(), |next| next.1);
        let manipulability = |candidate: &Candidate| placed[candidate.group].manipulability;
        let ends: Vec<(usize, usize)> = (0..poses.len()).map(|pose| (poses[pose].1, end_of(pose))).collect();
        for &(begin, end) in &ends {
            candidates[begin..end].sort_by(|a, b| {
                manipulability(b).total_cmp(&manipulability(a)).then_with(|| b.room.total_cmp(&a.room))
            });
        }
        let joints = job.closed.joints();
        let mut nth = |pose: usize, rank: usize, asked: &mut Vec<f64>| {
            let (begin, end) = ends[pose];
            let Some(candidate) = candidates[begin..end].get(rank) else { return false };
            asked.extend_from_slice(&q[joints * candidate.index..joints * (candidate.index + 1)]);
            true
        };
        let free = job.clear.first_free(scratch, ends.len(), &mut nth);
        let reached = free.iter().zip(poses.iter()).filter_map(|(rank, &(orientation, begin))| {
            let candidate = &candidates[begin + (*rank)?];
            Some(Reached {
                voxel: voxel as u32,
                orientation,
                manipulability: manipulability(candidate),
                code: candidate.code,
            })
        });
        reached.collect()
    }

    /// Adds the candidates of a pose at evenly spread arm angles.
    fn sweep(&mut self, p_BH: &Point3<f64>, orientation: usize, arm_angles: usize) {
        let job = self.job;
        let srs = &job.closed.srs;
        let (upper_m, fore_m) = srs.lengths_m();
        let p_BW = p_BH + job.to_wrist[orientation];
        for (number, stand) in job.closed.stands.iter().enumerate() {
            if (p_BW - stand.p_BS).norm_squared() > (upper_m + fore_m) * (upper_m + fore_m) {
                continue;
            }
            let X_BH = Isometry3::from_parts((*p_BH).into(), job.orientations.rotations()[orientation]);
            self.found.clear();
            srs.sweep_into(&(stand.X_AB * X_BH), arm_angles, &mut self.found);
            let mut last = None;
            for solution in &self.found.solutions {
                let this = (solution.arm_angle, solution.branch);
                // A joint that turns by more than a full turn gives the same posture again.
                if last == Some(this) {
                    continue;
                }
                if last.is_none_or(|(arm_angle, _)| arm_angle != solution.arm_angle) {
                    self.group_q.extend(stand.lead.iter().chain(&solution.q));
                }
                last = Some(this);
                self.candidates.push(Candidate {
                    code: Code::of(number, solution.arm_angle, solution.branch).pack(),
                    group: self.group_q.len() / job.closed.joints() - 1,
                    index: self.candidates.len(),
                    room: room(&solution.q, srs.limits()),
                });
                self.q.extend(stand.lead.iter().chain(&solution.q));
            }
        }
    }

    /// Manipulability of all groups, in whole batches.
    fn measure(&mut self) {
        let joints = self.job.closed.joints();
        let groups = self.group_q.len() / joints;
        for _ in groups..groups.next_multiple_of(BATCH) {
            self.group_q.extend_from_within(..joints);
        }
        self.dexterity.all(&self.group_q, &mut self.placed);
    }
}

fn room(q: &[f64; 7], limits: &[JointLimit; 7]) -> f64 {
    let of_joint = |(q, limit): (&f64, &JointLimit)| {
        (q - limit.lower).min(limit.upper - q) / (limit.upper - limit.lower).max(f64::MIN_POSITIVE)
    };
    q.iter().zip(limits).map(of_joint).fold(f64::INFINITY, f64::min)
}
