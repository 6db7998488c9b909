//! The map: which poses of the hand an arm reaches, how freely it moves there, and by which configuration.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, UnitQuaternion};

use super::about::About;
use super::grid::Grid;
use super::orientations::Orientations;
use super::recipe::Recipe;
use super::scale::Scale;
use super::spots::{POINTS, Spots};
use crate::robot::Robot;

/// A voxel of a map by its number: x runs fastest, then y, then z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Voxel(pub u32);

/// The reachability map of one arm (thesis 6.1), in the frame B of the arm's base link.
///
/// A *pose* of the map is a voxel and one orientation of a set, which stand for all hand frames H in the voxel that are
/// nearest to that orientation. For each pose the map knows whether the arm reaches it without touching its own robot,
/// the manipulability (5.1) of the best configuration there, and that configuration. The 3D values of a voxel, the
/// reachable fraction and the mean manipulability, follow from its poses.
///
/// A copy shares its data with the original.
#[derive(Clone, Debug)]
pub struct ReachMap {
    pub(super) data: Arc<Data>,
}

#[derive(Debug)]
pub(super) struct Data {
    pub(super) about: About,
    pub(super) grid: Grid,
    pub(super) orientations: Orientations,
    /// One bit per pose, [`Data::words`] words per voxel.
    pub(super) bits: Vec<u64>,
    pub(super) words: usize,
    /// For each voxel how many reached poses stand before its first, and at the end how many there are.
    pub(super) first: Vec<u32>,
    /// For each voxel where in it the poses were sought.
    pub(super) spots: Vec<u8>,
    pub(super) places: Spots,
    pub(super) scale: Scale,
    /// Of each reached pose, by voxel and orientation: manipulability on the scale.
    pub(super) levels: Vec<u8>,
    /// Of each reached pose what its configuration is made from.
    pub(super) codes: Vec<u32>,
    /// Of each voxel.
    pub(super) means: Vec<f32>,
    pub(super) recipe: Recipe,
}

/// A pose that was found to be reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    pub(super) voxel: u32,
    pub(super) orientation: u16,
    pub(super) manipulability: f64,
    pub(super) code: u32,
}

impl Data {
    /// From what was found: `reached` by voxel and orientation, `spots` for every voxel of the grid.
    pub(super) fn assemble(
        about: About,
        whole: &Grid,
        orientations: Orientations,
        reached: &[Reached],
        spots: &[u8],
        recipe: Recipe,
    ) -> Self {
        let grid = whole.cut(reached.iter().map(|pose| pose.voxel as usize));
        let scale = Scale::up_to(reached.iter().map(|pose| pose.manipulability).fold(0.0, f64::max));
        let words = orientations.count().div_ceil(64);
        let mut data = Self {
            about,
            bits: vec![0; words * grid.count()],
            words,
            first: Vec::new(),
            spots: vec![0; grid.count()],
            places: Spots::new(orientations.count()),
            scale,
            levels: Vec::with_capacity(reached.len()),
            codes: Vec::with_capacity(reached.len()),
            means: Vec::new(),
            grid,
            orientations,
            recipe,
        };
        for pose in reached {
            let voxel = whole.number_in(&data.grid, pose.voxel as usize);
            let orientation = usize::from(pose.orientation);
            data.bits[voxel * words + orientation / 64] |= 1 << (orientation % 64);
            data.spots[voxel] = spots[pose.voxel as usize];
            data.levels.push(data.scale.level(pose.manipulability));
            data.codes.push(pose.code);
        }
        data.number();
        data.average();
        data
    }

    /// Where the poses of each voxel stand in the lists; follows from the bits.
    pub(super) fn number(&mut self) {
        let mut before = 0;
        self.first = vec![0];
        self.first.extend(self.bits.chunks_exact(self.words).map(|bits| {
            before += bits.iter().map(|word| word.count_ones()).sum::<u32>();
            before
        }));
    }

    /// The means of the voxels; follow from the levels.
    pub(super) fn average(&mut self) {
        let mean = |ends: &[u32]| {
            let levels = &self.levels[ends[0] as usize..ends[1] as usize];
            let sum: f64 = levels.iter().map(|level| self.scale.value(*level)).sum();
            (sum / levels.len().max(1) as f64) as f32
        };
        self.means = self.first.windows(2).map(mean).collect();
    }

    fn bits(&self, voxel: usize) -> &[u64] {
        self.bits.get(voxel * self.words..(voxel + 1) * self.words).unwrap_or_default()
    }

    /// Where a reached pose stands in the lists.
    pub(super) fn index(&self, voxel: usize, orientation: usize) -> Option<usize> {
        let bits = self.bits(voxel);
        let (word, bit) = (orientation / 64, orientation % 64);
        if bits.get(word)? >> bit & 1 == 0 {
            return None;
        }
        let before = bits[..word].iter().map(|word| word.count_ones()).sum::<u32>();
        let below = (bits[word] & ((1 << bit) - 1)).count_ones();
        Some((self.first[voxel] + before + below) as usize)
    }

    /// Orientations that are reached in a voxel, in order.
    pub(super) fn reached(&self, voxel: usize) -> impl Iterator<Item = usize> + '_ {
        self.bits(voxel).iter().enumerate().flat_map(|(word, bits)| {
            let mut bits = *bits;
            std::iter::from_fn(move || {
                let bit = bits.trailing_zeros() as usize;
                bits &= bits.wrapping_sub(1);
                (bit < 64).then_some(64 * word + bit)
            })
        })
    }
}

impl ReachMap {
    pub(super) fn new(data: Data) -> Self {
        Self { data: Arc::new(data) }
    }

    /// What the map is of and how it was made.
    pub fn about(&self) -> &About {
        &self.data.about
    }

    /// Edge length of the voxels, metres.
    pub fn voxel_m(&self) -> f64 {
        self.data.grid.voxel_m
    }

    /// Voxels of the box that the map covers, along x, y and z.
    pub fn size(&self) -> [usize; 3] {
        self.data.grid.size
    }

    /// The orientations of the hand that are told apart.
    pub fn orientations(&self) -> &Orientations {
        &self.data.orientations
    }

    /// The voxels of which at least one pose is reached, in the order of their numbers.
    pub fn voxels(&self) -> impl Iterator<Item = Voxel> + '_ {
        let is_reached = |ends: &[u32]| ends[1] > ends[0];
        (0_u32..)
            .zip(self.data.first.windows(2))
            .filter(move |(_, ends)| is_reached(ends))
            .map(|(voxel, _)| Voxel(voxel))
    }

    /// Number of reached poses of all voxels.
    pub fn reached_poses(&self) -> usize {
        self.data.codes.len()
    }

    /// The greatest manipulability of the map.
    pub fn most_manipulable(&self) -> f64 {
        self.data.levels.iter().max().map_or(0.0, |level| self.data.scale.value(*level))
    }

    /// The voxel that holds a point of B; `None` outside of the box that the map covers, where nothing is reached.
    pub fn voxel_at(&self, p_BQ: &Point3<f64>) -> Option<Voxel> {
        self.data.grid.at(&p_BQ.coords).map(|voxel| Voxel(voxel as u32))
    }

    /// The centre of a voxel, in B, metres.
    pub fn center(&self, voxel: Voxel) -> Point3<f64> {
        self.data.grid.point(voxel.0 as usize, &POINTS[0])
    }

    /// The share of the orientations that is reached, in [0, 1].
    pub fn fraction(&self, voxel: Voxel) -> f64 {
        let reached = self.data.bits(voxel.0 as usize).iter().map(|word| word.count_ones()).sum::<u32>();
        f64::from(reached) / self.data.orientations.count() as f64
    }

    /// Mean of the manipulabilities of the reached orientations; 0 where none is.
    pub fn mean_manipulability(&self, voxel: Voxel) -> f64 {
        self.data.means.get(voxel.0 as usize).copied().map_or(0.0, f64::from)
    }

    /// Whether an orientation is reached.
    pub fn is_reached(&self, voxel: Voxel, orientation: usize) -> bool {
        self.data.index(voxel.0 as usize, orientation).is_some()
    }

    /// Manipulability of the best configuration of a pose, to 1.4 %; `None` where it is not reached.
    pub fn manipulability(&self, voxel: Voxel, orientation: usize) -> Option<f64> {
        let index = self.data.index(voxel.0 as usize, orientation)?;
        Some(self.data.scale.value(self.data.levels[index]))
    }

    /// The orientations that are reached, in order.
    pub fn reached(&self, voxel: Voxel) -> impl Iterator<Item = usize> + '_ {
        self.data.reached(voxel.0 as usize)
    }

    /// The reached orientation with the greatest manipulability, the first of equals.
    pub fn best_orientation(&self, voxel: Voxel) -> Option<usize> {
        let level =
            |orientation: usize| self.data.index(voxel.0 as usize, orientation).map(|index| self.data.levels[index]);
        // The last of equal maxima is taken, hence the second key.
        self.reached(voxel).max_by_key(|&orientation| (level(orientation), std::cmp::Reverse(orientation)))
    }

    /// The pose of the hand that stands for a pose of the map: at the voxel's centre in the orientation itself; in voxels
    /// at the rim of the workspace, of which nothing would be reached so, at a point near a corner and, if need be, turned
    /// by some degrees.
    pub fn pose(&self, voxel: Voxel, orientation: usize) -> Option<Isometry3<f64>> {
        let rotation = self.data.orientations.rotations().get(orientation)?;
        let (offset, turn) = self.data.places.of(*self.data.spots.get(voxel.0 as usize)?);
        let p_BH = self.data.grid.point(voxel.0 as usize, &offset);
        Some(Isometry3::from_parts(p_BH.into(), turn * rotation))
    }

    /// The best configuration of a pose, one value per joint of the arm (the torso's first, if the map is one with it);
    /// `None` where the pose is not reached.
    ///
    /// Inverse sampling puts the hand at [`ReachMap::pose`] exactly, forward sampling somewhere in the voxel and nearest
    /// to that orientation.
    pub fn configuration(&self, voxel: Voxel, orientation: usize) -> Option<Vec<f64>> {
        let index = self.data.index(voxel.0 as usize, orientation)?;
        self.data.recipe.configuration(self.data.codes[index], || self.pose(voxel, orientation))
    }

    /// The voxel and orientation that a pose of the hand belongs to.
    pub fn nearest(&self, X_BH: &Isometry3<f64>) -> Option<(Voxel, usize)> {
        Some((self.voxel_at(&X_BH.translation.vector.into())?, self.nearest_orientation(&X_BH.rotation)))
    }

    /// Number of the orientation that is nearest to a rotation of the hand.
    pub fn nearest_orientation(&self, R_BH: &UnitQuaternion<f64>) -> usize {
        self.data.orientations.nearest(R_BH)
    }

    /// Whether the map is one of this arm: same joints, limits, hand and base.
    pub fn is_of(&self, robot: &Robot, arm: usize) -> bool {
        About::arm(robot, arm).is_ok_and(|arm| arm == self.data.about.arm)
    }
}
