//! What a click in the view means: numbers that the renderer carries through, and back.

/// A thing that can be clicked in the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// Nothing, or something that means nothing.
    Nothing,
    /// The robot.
    Robot,
    /// The cluster of this index.
    Cluster(u32),
    /// The grasp of this number.
    Grasp(u32),
    /// The place of the handover of this index.
    Place(u32),
    /// The box in the way of this index.
    Obstacle(u32),
    /// A part of the composite object that is grasped.
    Part {
        /// Its cluster.
        cluster: u32,
        /// Which one, in the order of the fit.
        part: u32,
    },
    /// A voxel of a reachability map.
    Voxel {
        /// Of the left arm (0) or of the right one (1).
        arm: u32,
        /// Its number.
        voxel: u32,
    },
}

impl Pick {
    const KIND_SHIFT: u32 = 28;
    const INDEX: u32 = (1 << Self::KIND_SHIFT) - 1;
    const ARM_SHIFT: u32 = 27;
    const PART_SHIFT: u32 = 20;
    const PART: u32 = (1 << (Self::KIND_SHIFT - Self::PART_SHIFT)) - 1;

    /// The number for [`crate::render::MeshDraw::pick_id`]; indices from 2²⁸ on mean nothing.
    pub fn id(self) -> u32 {
        let pack = |kind: u32, index: u32| if index > Self::INDEX { 0 } else { kind << Self::KIND_SHIFT | index };
        match self {
            Self::Nothing => 0,
            Self::Robot => pack(1, 0),
            Self::Cluster(index) => pack(2, index),
            Self::Grasp(id) => pack(3, id),
            Self::Part { cluster, part } if cluster >> Self::PART_SHIFT == 0 && part <= Self::PART => {
                pack(4, part << Self::PART_SHIFT | cluster)
            }
            Self::Part { .. } => 0,
            Self::Place(index) => pack(6, index),
            Self::Obstacle(index) => pack(7, index),
            Self::Voxel { arm, voxel } if arm < 2 && voxel < 1 << Self::ARM_SHIFT => {
                pack(5, arm << Self::ARM_SHIFT | voxel)
            }
            Self::Voxel { .. } => 0,
        }
    }

    /// What a number of the renderer means.
    pub fn from_id(id: u32) -> Self {
        let index = id & Self::INDEX;
        match id >> Self::KIND_SHIFT {
            1 => Self::Robot,
            2 => Self::Cluster(index),
            3 => Self::Grasp(index),
            4 => Self::Part { cluster: index & ((1 << Self::PART_SHIFT) - 1), part: index >> Self::PART_SHIFT },
            6 => Self::Place(index),
            7 => Self::Obstacle(index),
            5 => Self::Voxel { arm: index >> Self::ARM_SHIFT, voxel: index & ((1 << Self::ARM_SHIFT) - 1) },
            _ => Self::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pick_survives_the_way_through_the_renderer() {
        for pick in [
            Pick::Nothing,
            Pick::Robot,
            Pick::Cluster(0),
            Pick::Cluster(7),
            Pick::Grasp(0),
            Pick::Grasp(411),
            Pick::Place(23),
            Pick::Obstacle(3),
        ] {
            assert_eq!(Pick::from_id(pick.id()), pick);
        }
        let part = Pick::Part { cluster: 3, part: 5 };
        assert_eq!(Pick::from_id(part.id()), part);
        let voxel = Pick::Voxel { arm: 1, voxel: 81_234 };
        assert_eq!(Pick::from_id(voxel.id()), voxel);
        assert_eq!(Pick::Grasp(u32::MAX).id(), 0);
    }
}
