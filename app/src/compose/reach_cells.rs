//! Which voxels of the maps are shown, and with which value.

use endcomfort_core::reach::{ReachMap, Voxel};
use nalgebra::{Isometry3, Point3, Vector3};

use crate::render::{ColorMap, Scale};
use crate::viewer::{ReachArms, ReachQuantity, ReachView};

/// A map where its arm's base stands.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) map: &'a ReachMap,
    pub(super) X_WB: Isometry3<f64>,
}

/// A voxel that is shown.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cell {
    /// Of the left arm (0) or of the right one (1).
    pub(super) arm: usize,
    pub(super) voxel: Voxel,
    /// Its centre.
    pub(super) p_W: Point3<f64>,
    pub(super) value: f64,
}

impl Placed<'_> {
    fn value(&self, voxel: Voxel, quantity: ReachQuantity) -> f64 {
        match quantity {
            ReachQuantity::Manipulability => self.map.mean_manipulability(voxel),
            ReachQuantity::Fraction => self.map.fraction(voxel),
        }
    }

    /// The value at a point of the world; 0 where nothing is reached.
    fn value_at(&self, p_W: &Point3<f64>, quantity: ReachQuantity) -> f64 {
        let voxel = self.map.voxel_at(&self.X_WB.inverse_transform_point(p_W));
        voxel.map_or(0.0, |voxel| self.value(voxel, quantity))
    }

    /// How far a voxel reaches along the axes of the world, metres.
    fn half_m(&self) -> Vector3<f64> {
        let rotation = self.X_WB.rotation.to_rotation_matrix();
        let half_m = 0.5 * self.map.voxel_m();
        Vector3::from_fn(|axis, _| half_m * rotation.matrix().row(axis).abs().sum())
    }
}

/// The voxels of a view, left arm before right. Voxels of both arms stand at one place when the centre of the one lies
/// in the other; of an overlap the left arm's voxels are shown.
pub(super) fn cells(maps: [Option<Placed<'_>>; 2], view: &ReachView) -> Vec<Cell> {
    let mut cells = Vec::new();
    for (arm, placed) in maps.iter().enumerate() {
        let Some(placed) = placed.as_ref().filter(|_| view.arms.needs(arm)) else { continue };
        let other = maps[1 - arm].as_ref();
        let (half_m, quantity) = (placed.half_m(), view.quantity);
        for voxel in placed.map.voxels() {
            let p_W = placed.X_WB * placed.map.center(voxel);
            if !view.leaves(&p_W.coords, &half_m) {
                continue;
            }
            let value = placed.value(voxel, quantity);
            let others = || other.map_or(0.0, |other| other.value_at(&p_W, quantity));
            let value = match view.arms {
                ReachArms::Left | ReachArms::Right => value,
                // Of two that stand at one place the better one is seen.
                ReachArms::Both if arm == 0 && others() > value || arm == 1 && others() >= value => continue,
                ReachArms::Both => value,
                ReachArms::Overlap if arm == 1 => continue,
                ReachArms::Overlap => match others() {
                    0.0 => continue,
                    others => value.min(others),
                },
            };
            if value >= view.least {
                cells.push(Cell { arm, voxel, p_W, value });
            }
        }
    }
    cells
}

/// The colours of a view over these maps, up to the greatest value there is, in the unit of the data.
pub fn reach_scale<'a>(maps: impl Iterator<Item = &'a ReachMap> + Clone, view: &ReachView) -> Scale {
    let values = |map: &'a ReachMap| {
        let placed = Placed { map, X_WB: Isometry3::identity() };
        map.voxels().map(move |voxel| placed.value(voxel, view.quantity))
    };
    let max = maps.clone().flat_map(values).fold(0.0, f64::max);
    let min = match view.quantity {
        // A single orientation.
        ReachQuantity::Fraction => 1.0 / maps.map(|map| map.orientations().count()).max().unwrap_or(1) as f64,
        // Two decades: what is less free than that is not free at all.
        ReachQuantity::Manipulability => 0.01 * max,
    };
    Scale { map: ColorMap::Viridis, min: if view.is_log { min } else { 0.0 }, max, is_log: view.is_log }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets;
    use crate::viewer::{Keep, Slice};

    /// Maps of both arms of a robot where its zero posture has their bases.
    fn maps(robot: &str) -> [(ReachMap, Isometry3<f64>); 2] {
        let library = assets::library();
        let body = library.robot(robot).unwrap();
        let X_WL = body.link_poses(&vec![0.0; body.dof_count()]);
        ["left", "right"].map(|arm| {
            let map = library.reach_map(robot, arm).unwrap();
            (map, X_WL[body.arm(arm).unwrap().base_link])
        })
    }

    fn open(arms: ReachArms) -> ReachView {
        ReachView { arms, slices: [Slice { keep: Keep::All, at_m: 0.0 }; 3], ..ReachView::default() }
    }

    fn shown(maps: &[(ReachMap, Isometry3<f64>); 2], view: &ReachView) -> Vec<Cell> {
        cells(maps.each_ref().map(|(map, X_WB)| Some(Placed { map, X_WB: *X_WB })), view)
    }

    #[test]
    fn one_arm_shows_every_voxel_of_its_map_and_a_threshold_leaves_those_with_enough() {
        let maps = maps("alita");
        for (arm, arms) in [(0, ReachArms::Left), (1, ReachArms::Right)] {
            let all = shown(&maps, &open(arms));
            assert_eq!(all.len(), maps[arm].0.voxels().count());
            let some = shown(&maps, &ReachView { least: 0.5, ..open(arms) });
            let wanted = maps[arm].0.voxels().filter(|voxel| maps[arm].0.fraction(*voxel) >= 0.5).count();
            assert!((1..all.len()).contains(&some.len()) && some.len() == wanted, "{} of {}", some.len(), all.len());
        }
    }

    #[test]
    fn an_overlap_has_the_smaller_value_and_only_places_that_both_arms_reach() {
        for robot in ["alita", "crichton"] {
            let maps = maps(robot);
            let view = open(ReachArms::Overlap);
            let overlap = shown(&maps, &view);
            assert!(overlap.len() > 1000, "{robot}: {}", overlap.len());
            for cell in overlap.iter().step_by(37) {
                let values = maps.each_ref().map(|(map, X_WB)| {
                    let voxel = map.voxel_at(&(X_WB.inverse() * cell.p_W)).expect("both reach it");
                    map.fraction(voxel)
                });
                assert!(values[1] > 0.0 && cell.value == values[0].min(values[1]), "{values:?} at {cell:?}");
            }
            // The arms are each other's mirror image: so is what both reach, up to the two grids.
            let middle_m = overlap.iter().map(|cell| cell.p_W.y).sum::<f64>() / overlap.len() as f64;
            assert!(middle_m.abs() < 0.03, "{robot}: the overlap stands {middle_m} m off the middle");
        }
    }

    #[test]
    fn both_arms_together_show_no_place_twice() {
        let maps = maps("crichton");
        let both = shown(&maps, &open(ReachArms::Both));
        let overlap = shown(&maps, &open(ReachArms::Overlap));
        let separate: usize = maps.iter().map(|(map, _)| map.voxels().count()).sum();
        let (least, most) = (separate - overlap.len() * 21 / 20, separate - overlap.len() * 19 / 20);
        assert!((least..=most).contains(&both.len()), "{} of {separate}, overlap {}", both.len(), overlap.len());
    }

    #[test]
    fn a_slice_is_one_layer_of_voxels_where_the_grid_stands_along_the_world() {
        let maps = maps("alita");
        let mut view = open(ReachArms::Left);
        let all = shown(&maps, &view);
        let at_m = all[all.len() / 2].p_W.z;
        view.slices[2] = Slice { keep: Keep::Slice, at_m };
        let layer = shown(&maps, &view);
        let wanted = all.iter().filter(|cell| (cell.p_W.z - at_m).abs() < 1e-6).count();
        assert_eq!(layer.len(), wanted, "of {}", all.len());
    }

    #[test]
    fn a_logarithmic_scale_begins_above_nothing() {
        let maps = maps("alita");
        for quantity in ReachQuantity::ALL {
            let view = ReachView { quantity, is_log: true, ..open(ReachArms::Both) };
            let scale = reach_scale(maps.iter().map(|(map, _)| map), &view);
            assert!(scale.min > 0.0 && scale.max > scale.min, "{scale:?}");
            assert_eq!(reach_scale(maps.iter().map(|(map, _)| map), &ReachView { is_log: false, ..view }).min, 0.0);
        }
    }
}
