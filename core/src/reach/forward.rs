//! Forward sampling: configurations of any arm, sorted into the poses that they reach.

use nalgebra::{Point3, Vector3};

use super::about::{About, ReachMethod};
use super::clear::SelfClear;
use super::closed::ClosedForm;
use super::grid::Grid;
use super::map::{Data, Reached};
use super::recipe::{Recipe, Samples};
use super::{Orientations, ReachError, ReachMap};
use crate::collision::Scratch;
use crate::robot::{Arm, Chain, ChainError, Dexterity, Placed, Robot, Rough, RoughDexterity};
use crate::simd::{Kernel, widest};
use crate::watch::Watch;

/// Most samples: their numbers take three bytes of a file.
const MOST_SAMPLES: usize = 1 << 24;
/// Samples of one piece of work.
const BLOCK: usize = 16_384;
/// Pieces that are done before their results are sorted in.
const ROUND: usize = 16;
/// Samples that are computed side by side.
const WIDE: usize = 16;
/// Samples that are drawn and placed at once, so that they stay in the fastest memory.
const STRIP: usize = 16 * WIDE;
/// Best samples of each pose that are kept, in case that the robot touches itself in the first ones.
const KEPT_OF_FEW: usize = 8;
const KEPT_OF_MANY: usize = 3;
/// Up to so many poses count as few.
const FEW: usize = 1 << 19;
/// Most numbers that are kept.
const MOST_KEPT: usize = 1 << 27;
/// Poses whose samples are looked at together.
const SETTLED: usize = 1024;

/// What a forward map is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ForwardSettings {
    /// Edge length of the voxels, metres.
    pub voxel_m: f64,
    /// Orientations told apart in each voxel: 1 (positions only), 40 or 272.
    pub orientations: usize,
    /// Configurations that are drawn, up to 2²⁴.
    pub samples: usize,
    /// Where their sequence begins.
    pub seed: u64,
}

impl Default for ForwardSettings {
    fn default() -> Self {
        Self { voxel_m: 0.05, orientations: 40, samples: 5_000_000, seed: 1 }
    }
}

/// The map of any arm by forward sampling; give [`Robot::with_torso`] for a map with the torso.
///
/// Configurations are drawn evenly within the limits and sorted into the pose of the map that their hand is in. Of each
/// pose the best few by manipulability (5.1) are kept (8; 3 in a map of more than 500 000 poses), and the best of these
/// in which the robot does not touch itself stands for it. A pose of which all these touch something is not in the map.
///
/// * `arm`: index into [`Robot::arms`].
///
/// # Errors
/// [`ReachError`] when a setting is none that there is, there is no chain to the hand, or the watch says stop.
pub fn build_forward(
    robot: &Robot,
    arm: usize,
    settings: &ForwardSettings,
    watch: Watch<'_>,
) -> Result<ReachMap, ReachError> {
    let mapped = About::arm(robot, arm)?;
    let count = settings.orientations;
    let orientations = Orientations::new(count).ok_or(ReachError::BadOrientations { found: count })?;
    if !(1..=MOST_SAMPLES).contains(&settings.samples) {
        return Err(ReachError::BadSamples { found: settings.samples, most: MOST_SAMPLES });
    }
    let chain = chain_of(robot, &robot.arms[arm])?;
    let (center, reach_m) = ball_around(robot, &robot.arms[arm], &chain);
    let reach = Vector3::repeat(reach_m);
    let grid = Grid::around(&(center - reach), &(center + reach), settings.voxel_m)?;
    let poses = grid.count() * count;
    let kept = if poses <= FEW { KEPT_OF_FEW } else { KEPT_OF_MANY };
    if poses * kept > MOST_KEPT {
        let (found, most) = ((poses * kept) as f64, MOST_KEPT as f64);
        return Err(ReachError::TooMany { what: "samples of poses", found, most });
    }
    let clear = SelfClear::of(robot, arm)?;
    let samples = Samples::of(&chain, settings.seed);
    let sorter = Sorter { chain: &chain, samples: &samples, grid: &grid, orientations: &orientations };

    let mut best = vec![0_u64; poses * kept];
    let blocks: Vec<usize> = (0..settings.samples).step_by(BLOCK).collect();
    for (round, blocks) in blocks.chunks(ROUND).enumerate() {
        if watch.should_stop() {
            return Err(ReachError::Cancelled);
        }
        let sorted = crate::parallel::map(blocks, |&first| sorter.sort(first..settings.samples.min(first + BLOCK)));
        for (pose, key) in sorted.into_iter().flatten() {
            keep(&mut best[pose as usize * kept..(pose as usize + 1) * kept], key);
        }
        let share = 0.9 * ((round + 1) * ROUND * BLOCK).min(settings.samples) as f64 / settings.samples as f64;
        watch.progress(share, &format!("{:.0} % of the samples", 100.0 * share / 0.9));
    }

    let numbers: Vec<usize> = (0..poses).filter(|pose| best[pose * kept] != 0).collect();
    let groups: Vec<&[usize]> = numbers.chunks(SETTLED).collect();
    let settled = crate::parallel::map(&groups, |group| {
        if watch.should_stop() {
            return None;
        }
        let key = |pose: usize, rank: usize| best[pose * kept..(pose + 1) * kept].get(rank).filter(|key| **key != 0);
        // Rank of the next sample of each pose.
        let mut ranks = vec![0; group.len()];
        let mut next = |index: usize, asked: &mut Vec<f64>| {
            let Some(key) = key(group[index], ranks[index]) else { return false };
            ranks[index] += 1;
            samples.push(number_of(*key), asked);
            true
        };
        let is_free = clear.first_free(&mut Scratch::default(), group.len(), &mut next);
        let best = group
            .iter()
            .zip(is_free.iter().zip(ranks))
            .filter_map(|(&pose, (is_free, rank))| Some((pose, number_of(*key(pose, rank - 1).filter(|_| *is_free)?))));
        Some(sorter.place(&best.collect::<Vec<_>>()))
    });
    let reached = settled.into_iter().collect::<Option<Vec<_>>>().ok_or(ReachError::Cancelled)?.concat();
    watch.progress(1.0, "done");
    let method = ReachMethod::Forward { samples: settings.samples as u32, seed: settings.seed };
    let about = About { arm: mapped, method };
    let spots = vec![0; grid.count()];
    Ok(ReachMap::new(Data::assemble(about, &grid, orientations, &reached, &spots, Recipe::Drawn(samples))))
}

/// The joints from the base to the hand, which must be those of the arm in the same order.
pub(super) fn chain_of(robot: &Robot, arm: &Arm) -> Result<Chain, ReachError> {
    let chain = Chain::between(robot, arm.base_link, arm.hand.tcp_link)?;
    let differs = chain.dofs().iter().zip(&arm.dofs).find(|(a, b)| a != b).map(|(a, _)| *a);
    let shorter = chain.dofs().len().min(arm.dofs.len());
    let extra = || chain.dofs().iter().chain(&arm.dofs).copied().nth(shorter);
    let other = differs.or_else(|| (chain.dofs().len() != arm.dofs.len()).then(extra).flatten());
    match other {
        None => Ok(chain),
        Some(dof) => Err(ChainError::OtherJoints {
            arm: arm.name.clone(),
            joint: robot.joints[robot.dof_joints[dof]].name.clone(),
            tip: robot.links[arm.hand.tcp_link].name.clone(),
        }
        .into()),
    }
}

/// A ball that the hand never leaves: about the shoulder of an S-R-S arm, about the first joint of any other.
fn ball_around(robot: &Robot, arm: &Arm, chain: &Chain) -> (Point3<f64>, f64) {
    match ClosedForm::of(robot, arm) {
        Ok(closed) if closed.stands.len() == 1 => (closed.stands[0].p_BS, closed.reach_m()),
        _ => (chain.origin().into(), chain.reach_m()),
    }
}

/// A sample of a pose as a number that is greater for more manipulability, and of equals for the earlier sample; 0 is
/// none. The bits of
/// a positive `f32` are in the order of its values.
fn key_of(manipulability: f32, number: usize) -> u64 {
    u64::from(manipulability.to_bits()) << 32 | u64::from(u32::MAX - number as u32)
}

fn number_of(key: u64) -> u32 {
    u32::MAX - key as u32
}

/// Sorts a key into a list that begins with the greatest.
#[inline]
fn keep(best: &mut [u64], key: u64) {
    let last = best.len() - 1;
    if key <= best[last] {
        return;
    }
    let mut place = last;
    while place > 0 && best[place - 1] < key {
        best[place] = best[place - 1];
        place -= 1;
    }
    best[place] = key;
}

/// Draws samples and says which pose each is of.
struct Sorter<'a> {
    chain: &'a Chain,
    samples: &'a Samples,
    grid: &'a Grid,
    orientations: &'a Orientations,
}

impl Sorter<'_> {
    /// The poses of samples and their keys, in single precision.
    fn sort(&self, numbers: std::ops::Range<usize>) -> Vec<(u32, u64)> {
        let joints = self.chain.dofs().len();
        let mut dexterity = RoughDexterity::new(self.chain);
        let (mut q, mut placed) = (vec![0.0; STRIP * joints], Vec::with_capacity(STRIP));
        let mut sorted = Vec::with_capacity(numbers.len());
        for first in numbers.clone().step_by(STRIP) {
            widest(Draw { samples: self.samples, first, q: &mut q });
            dexterity.all(&q, &mut placed);
            // The last strip may go on beyond the samples that were asked for.
            for (number, Rough { R_BH, p_BH, manipulability }) in (first..numbers.end).zip(&placed) {
                let p_BH = Vector3::from(p_BH.map(f64::from));
                if let Some(pose) = self.pose(&p_BH, &R_BH.map(f64::from)) {
                    sorted.push((pose as u32, key_of(*manipulability, number)));
                }
            }
        }
        sorted
    }

    /// The samples that stand for poses, placed in double precision; one in ten thousand turns out to be across the
    /// border of its pose, and is left out.
    fn place(&self, best: &[(usize, u32)]) -> Vec<Reached> {
        let count = self.orientations.count();
        let mut q = Vec::with_capacity(best.len() * self.chain.dofs().len());
        best.iter().for_each(|(_, number)| self.samples.push(*number, &mut q));
        let mut placed = Vec::with_capacity(best.len());
        Dexterity::new(self.chain).all(&q, &mut placed);
        let is_there = |pose: usize, placed: &Placed| {
            let rows = std::array::from_fn(|entry| placed.R_BH[(entry / 3, entry % 3)]);
            self.pose(&placed.p_BH, &rows) == Some(pose)
        };
        let found = best.iter().zip(&placed).filter(|((pose, _), placed)| is_there(*pose, placed));
        let reached = found.map(|((pose, number), placed)| Reached {
            voxel: (pose / count) as u32,
            orientation: (pose % count) as u16,
            manipulability: placed.manipulability,
            code: *number,
        });
        reached.collect()
    }

    /// The pose of the map that a pose of the hand belongs to; the rotation row by row.
    #[inline]
    fn pose(&self, p_BH: &Vector3<f64>, R_BH: &[f64; 9]) -> Option<usize> {
        let voxel = self.grid.at(p_BH)?;
        let orientation = match self.orientations.count() {
            1 => 0,
            _ => self.orientations.nearest_to(quaternion(R_BH)),
        };
        Some(voxel * self.orientations.count() + orientation)
    }
}

/// `[w, x, y, z]` of a rotation, of any length, by its greatest component (Shepperd 1978).
#[inline]
fn quaternion(rows: &[f64; 9]) -> [f64; 4] {
    let [x, xy_, xz_, yx_, y, yz_, zx_, zy_, z] = *rows;
    let (yz, zx, xy) = (zy_ - yz_, xz_ - zx_, yx_ - xy_);
    let (with_yz, with_zx, with_xy) = (zy_ + yz_, xz_ + zx_, yx_ + xy_);
    if x + y + z > 0.0 {
        [1.0 + x + y + z, yz, zx, xy]
    } else if x > y && x > z {
        [yz, 1.0 + x - y - z, with_xy, with_zx]
    } else if y > z {
        [zx, with_xy, 1.0 - x + y - z, with_yz]
    } else {
        [xy, with_zx, with_yz, 1.0 - x - y + z]
    }
}

/// Configurations from a number on, as many as there is room for.
struct Draw<'a> {
    samples: &'a Samples,
    first: usize,
    q: &'a mut [f64],
}

impl Kernel for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let joints = self.samples.alpha.len();
        for (chunk, q) in self.q.chunks_exact_mut(WIDE * joints).enumerate() {
            let first = self.samples.first + (self.first + chunk * WIDE) as f64;
            for joint in 0..joints {
                let mut positions = [0.0; WIDE];
                for (k, position) in positions.iter_mut().enumerate() {
                    *position = self.samples.position(joint, first + k as f64);
                }
                for (k, position) in positions.iter().enumerate() {
                    q[k * joints + joint] = *position;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn the_quaternion_of_a_matrix_is_that_of_its_rotation() {
        let mut rng = Rng::new(2, 0);
        for _ in 0..5_000 {
            let rotation = rng.rotation();
            let R = rotation.to_rotation_matrix();
            let q = quaternion(&std::array::from_fn(|entry| R[(entry / 3, entry % 3)]));
            let wanted = rotation.quaternion();
            let dot = q[0] * wanted.w + q[1] * wanted.i + q[2] * wanted.j + q[3] * wanted.k;
            let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
            assert!((dot.abs() / length - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_best_few_are_kept_best_first_and_of_equals_the_earlier() {
        let mut best = [0; 3];
        for (m, number) in [(0.1, 7), (0.3, 8), (0.2, 9), (0.3, 3), (0.05, 1), (0.25, 2)] {
            keep(&mut best, key_of(m, number));
        }
        assert_eq!(best.map(number_of), [3, 8, 2]);
    }
}
