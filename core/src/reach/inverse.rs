//! Inverse sampling: every pose of the map is solved for the joints in closed form.

use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::about::{About, ReachMethod};
use super::clear::SelfClear;
use super::closed::{ARM_ANGLES, ClosedForm, Code};
use super::grid::Grid;
use super::map::{Data, Reached};
use super::recipe::Recipe;
use super::spots::{POINTS, Spots};
use super::{Orientations, ReachError, ReachMap};
use crate::collision::Scratch;
use crate::robot::ik::{Glance, IkSet};
use crate::robot::{Chain, Dexterity, JointLimit, Placed, Robot};
use crate::watch::Watch;

/// Branches of one arm angle that are looked at, those with the most room: they differ in nothing but half turns of
/// the segments about themselves, so where two touch something the others mostly do.
const BRANCHES: usize = 2;
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
/// Each orientation of the set is put at the centre of each voxel. Of 32 arm angles over the full turn, the one with the
/// greatest manipulability (5.1) is solved in closed form, and of its branches within the limits the one that leaves the
/// most room to them is taken; where the robot touches itself, the next follows. A torso stands at 7 positions, each
/// with its best arm angle, which compete by the manipulability of all joints. A voxel of which nothing is reached at its
/// centre is tried near its corners, and if that gives nothing, with all orientations turned by some degrees; the spot
/// with the most orientations stands for it ([`ReachMap::pose`]). So the rim of the workspace, where a centre lies just
/// outside and few orientations are left, is in the map.
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
        spots: Spots::new(count),
        orientations,
    };

    let rows: Vec<usize> = (0..job.grid.count()).step_by(job.grid.size[0]).collect();
    let done = AtomicUsize::new(0);
    let found = crate::parallel::map(&rows, |&first| {
        let mut worker = Worker::new(&job);
        // A row with hundreds of orientations takes half a second at the rim: whoever stops asks each voxel.
        let voxel = |voxel| if watch.should_stop() { None } else { Some(worker.voxel(voxel)) };
        let row: Vec<Solved> = (first..first + job.grid.size[0]).map(voxel).collect::<Option<_>>()?;
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
    spots: Spots,
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
    /// The poses that have a configuration: orientation, and where their tries begin.
    poses: Vec<Pose>,
    tries: Vec<Try>,
    q: Vec<f64>,
    placed: Vec<Placed>,
}

struct Pose {
    orientation: u16,
    /// Its tries.
    begin: usize,
    end: usize,
    /// How many configurations were asked for.
    asked: usize,
}

/// One pose seen from one position of the joint before the arm.
struct Try {
    stand: usize,
    /// Arm angles that are used up have no manipulability.
    glance: Glance,
    /// The arm angle at which it is.
    step: usize,
    /// Its configurations, the last is the next to be asked for.
    ready: Vec<Candidate>,
    /// The one that was asked for last.
    given: Candidate,
}

#[derive(Clone, Copy, Default)]
struct Candidate {
    q: [f64; 7],
    branch: u8,
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
            poses: Vec::new(),
            tries: Vec::new(),
            q: Vec::new(),
            placed: Vec::new(),
        }
    }

    fn voxel(&mut self, voxel: usize) -> Solved {
        let closed = &self.job.closed;
        let center = self.job.grid.point(voxel, &POINTS[0]);
        // No point of the voxel is farther from its centre than this.
        let farthest_m = closed.reach_m() + self.job.grid.voxel_m;
        if closed.stands.iter().all(|stand| (center - stand.p_BS).norm() > farthest_m) {
            return Solved::default();
        }
        let reached = self.solve(voxel, 0);
        if !reached.is_empty() {
            return Solved { spot: 0, reached };
        }
        let mut best = Solved::default();
        let mut is_blocked = !self.poses.is_empty();
        for spots in Spots::by_turn() {
            for spot in spots.filter(|spot| *spot != 0) {
                let reached = self.solve(voxel, spot);
                is_blocked |= !self.poses.is_empty();
                if reached.len() > best.reached.len() {
                    best = Solved { spot, reached };
                }
            }
            // Turning the hand helps where it is too far away, hardly where the robot stands in its own way.
            if is_blocked || !best.reached.is_empty() {
                break;
            }
        }
        best
    }

    /// All orientations at one spot.
    fn solve(&mut self, voxel: usize, spot: u8) -> Vec<Reached> {
        self.poses.clear();
        self.tries.clear();
        let (offset, turn) = self.job.spots.of(spot);
        let p_BH = self.job.grid.point(voxel, &offset);
        let reach_m = self.job.closed.reach_m();
        if self.job.closed.stands.iter().all(|stand| (p_BH - stand.p_BS).norm() > reach_m) {
            return Vec::new();
        }
        for orientation in 0..self.job.orientations.count() {
            let begin = self.tries.len();
            self.look(&p_BH, &turn, orientation);
            let end = self.tries.len();
            if end > begin {
                self.poses.push(Pose { orientation: orientation as u16, begin, end, asked: 0 });
            }
        }
        if self.job.closed.stands.len() > 1 {
            self.sort_stands();
        }
        let Self { job, scratch, found, poses, tries, .. } = self;
        let count = poses.len();
        let mut next = |pose: usize, asked: &mut Vec<f64>| {
            let pose = &mut poses[pose];
            let tries = &mut tries[pose.begin..pose.end];
            // By turns, beginning with the best.
            for _ in 0..tries.len() {
                let this = &mut tries[pose.asked % (pose.end - pose.begin)];
                pose.asked += 1;
                if this.advance(&job.closed, found) {
                    asked.extend(job.closed.stands[this.stand].lead.iter().chain(&this.given.q));
                    return true;
                }
            }
            false
        };
        let is_free = job.clear.first_free(scratch, count, &mut next);
        let free: Vec<(u16, &Try)> = poses
            .iter()
            .zip(is_free)
            .filter(|(_, is_free)| *is_free)
            .map(|(pose, _)| (pose.orientation, &tries[pose.begin + (pose.asked - 1) % (pose.end - pose.begin)]))
            .collect();
        self.q.clear();
        self.q.extend(free.iter().flat_map(|(_, this)| job.closed.stands[this.stand].lead.iter().chain(&this.given.q)));
        measure(&mut self.dexterity, &mut self.q, free.len(), &mut self.placed);
        let reached = free.iter().zip(&self.placed).map(|((orientation, this), placed)| Reached {
            voxel: voxel as u32,
            orientation: *orientation,
            manipulability: placed.manipulability,
            code: Code { stand: this.stand, arm_angle: this.step, branch: this.given.branch }.pack(),
        });
        reached.collect()
    }

    /// Adds the tries of a pose that have a configuration within the limits.
    fn look(&mut self, p_BH: &Point3<f64>, turn: &UnitQuaternion<f64>, orientation: usize) {
        let job = self.job;
        let (upper_m, fore_m) = job.closed.srs.lengths_m();
        let p_BW = p_BH + turn * job.to_wrist[orientation];
        for (stand_idx, stand) in job.closed.stands.iter().enumerate() {
            if (p_BW - stand.p_BS).norm_squared() > (upper_m + fore_m) * (upper_m + fore_m) {
                continue;
            }
            let X_BH = Isometry3::from_parts((*p_BH).into(), turn * job.orientations.rotations()[orientation]);
            let Some(glance) = job.closed.glancer.glance(&(stand.X_AB * X_BH)) else { continue };
            let mut this = Try { stand: stand_idx, glance, step: 0, ready: Vec::new(), given: Candidate::default() };
            if this.fill(&job.closed, &mut self.found) {
                self.tries.push(this);
            }
        }
    }

    /// Puts the tries of each pose in the order of the manipulability of all joints.
    fn sort_stands(&mut self) {
        let Self { job, tries, poses, q, placed, dexterity, .. } = self;
        q.clear();
        for this in tries.iter() {
            // Whatever is added is ready at least once.
            let first = this.ready.last().copied().unwrap_or_default();
            q.extend(job.closed.stands[this.stand].lead.iter().chain(&first.q));
        }
        measure(dexterity, q, tries.len(), placed);
        let mut ranked: Vec<(f64, Try)> =
            placed.iter().map(|placed| placed.manipulability).zip(tries.drain(..)).collect();
        for pose in poses.iter() {
            ranked[pose.begin..pose.end].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        tries.extend(ranked.into_iter().map(|(_, this)| this));
    }
}

impl Try {
    /// Makes the configurations of the most manipulable arm angle that is left ready, the one with the most room last;
    /// `false` when no arm angle is left.
    fn fill(&mut self, closed: &ClosedForm, found: &mut IkSet) -> bool {
        loop {
            let left = self.glance.manipulability.iter().enumerate();
            let Some((step, most)) = left.max_by(|a, b| a.1.total_cmp(b.1)) else { return false };
            if *most < 0.0 {
                return false;
            }
            self.step = step;
            self.glance.manipulability[step] = -1.0;
            found.clear();
            closed.glancer.solve_into(&self.glance, step, found);
            let mut last = None;
            for solution in &found.solutions {
                // A joint that turns by more than a full turn gives the same posture again.
                if last.replace(solution.branch) != Some(solution.branch) {
                    let room = room(&solution.q, closed.srs.limits());
                    self.ready.push(Candidate { q: solution.q, branch: solution.branch, room });
                }
            }
            self.ready.sort_by(|a, b| a.room.total_cmp(&b.room));
            self.ready.drain(..self.ready.len().saturating_sub(BRANCHES));
            if !self.ready.is_empty() {
                return true;
            }
        }
    }

    /// Takes the next configuration; `false` when there is none.
    fn advance(&mut self, closed: &ClosedForm, found: &mut IkSet) -> bool {
        if self.ready.is_empty() {
            // All of an arm angle touch something: its neighbours are too much like it.
            for neighbour in [self.step + 1, self.step + ARM_ANGLES - 1] {
                self.glance.manipulability[neighbour % ARM_ANGLES] = -1.0;
            }
            self.fill(closed, found);
        }
        let next = self.ready.pop();
        self.given = next.unwrap_or(self.given);
        next.is_some()
    }
}

/// Pose and manipulability of so many configurations, computed in whole batches.
fn measure(dexterity: &mut Dexterity<'_>, q: &mut Vec<f64>, count: usize, placed: &mut Vec<Placed>) {
    let joints = q.len().checked_div(count).unwrap_or(0);
    for _ in count..count.next_multiple_of(BATCH) {
        q.extend_from_within(..joints);
    }
    dexterity.all(q, placed);
    placed.truncate(count);
}

fn room(q: &[f64; 7], limits: &[JointLimit; 7]) -> f64 {
    let of_joint = |(q, limit): (&f64, &JointLimit)| {
        (q - limit.lower).min(limit.upper - q) / (limit.upper - limit.lower).max(f64::MIN_POSITIVE)
    };
    q.iter().zip(limits).map(of_joint).fold(f64::INFINITY, f64::min)
}
