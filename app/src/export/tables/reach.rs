//! The voxels that an arm reaches.

use endcomfort_core::reach::{ReachMap, Voxel};

use super::Row;

/// Every reached voxel of a map: its centre in the frame of the map's base link, and how freely the hand moves there.
pub(super) fn voxels(map: &ReachMap) -> Vec<Row> {
    let about = map.about();
    let row = |voxel: Voxel| {
        let center = map.center(voxel);
        let best = map.best_orientation(voxel).and_then(|orientation| map.manipulability(voxel, orientation));
        Row(vec![
            ("arm", about.arm.arm.clone().into()),
            ("base_link", about.arm.base_link.clone().into()),
            ("x_m", center.x.into()),
            ("y_m", center.y.into()),
            ("z_m", center.z.into()),
            ("orientations", map.reached(voxel).count().into()),
            ("fraction", map.fraction(voxel).into()),
            ("manipulability_mean", map.mean_manipulability(voxel).into()),
            ("manipulability_best", best.into()),
        ])
    };
    map.voxels().map(row).collect()
}
