//! Options of `render`: reachability maps in the picture.

use clap::ValueEnum;
use endcomfort_core::reach::ReachMap;
use endcomfort_core::scene::Scene;

use super::Failure;
use crate::assets;
use crate::compose::reach_scale;
use crate::figures::ReachPicture;
use crate::viewer::{Keep, ReachArms, ReachQuantity, ReachView, Slice};

#[derive(clap::Args)]
pub(super) struct Options {
    /// Draws what the arms reach as voxels.
    #[arg(long, value_enum, help_heading = "Reachability")]
    reach: Option<Arms>,
    /// What colours the voxels.
    #[arg(long, value_enum, default_value = "fraction", requires = "reach", help_heading = "Reachability")]
    reach_color: Color,
    /// Equal ratios, not equal differences, are equally far apart in colour.
    #[arg(long, requires = "reach", help_heading = "Reachability")]
    reach_log: bool,
    /// Leaves out voxels with less than this: a share of the orientations, or a manipulability.
    #[arg(long, value_name = "X", default_value_t = 0.0, requires = "reach", help_heading = "Reachability")]
    reach_threshold: f64,
    /// A plane across an axis of the world: `z=1.1` keeps the layer of voxels that it cuts, `x<0.3` and `x>0.3` those on
    /// one side. Once for each axis.
    #[arg(long, value_name = "AXIS=M", value_parser = slice, requires = "reach", help_heading = "Reachability")]
    reach_slice: Vec<(usize, Slice)>,
    /// Voxels with little are see-through.
    #[arg(long, requires = "reach", help_heading = "Reachability")]
    reach_fade: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Arms {
    Left,
    Right,
    Both,
    Overlap,
}

#[derive(Clone, Copy, ValueEnum)]
enum Color {
    Fraction,
    Manipulability,
}

/// An axis by its number, and the plane across it.
pub(super) fn slice(text: &str) -> Result<(usize, Slice), String> {
    let wanted = || format!("found {text:?}, wanted an axis, one of = < >, and metres, as in z=1.1 or x<0.3");
    let at = text.find(['=', '<', '>']).ok_or_else(wanted)?;
    let (axis, rest) = text.split_at(at);
    let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim()).ok_or_else(wanted)?;
    let at_m = rest[1..].trim().parse::<f64>().ok().filter(|at_m| at_m.is_finite()).ok_or_else(wanted)?;
    let keep = match &rest[..1] {
        "<" => Keep::Below,
        ">" => Keep::Above,
        _ => Keep::Slice,
    };
    Ok((axis, Slice { keep, at_m }))
}

impl Options {
    /// The maps that are asked for, of the scene's robot.
    pub(super) fn picture(&self, scene: &Scene) -> Result<Option<ReachPicture>, Failure> {
        let Some(arms) = self.reach else { return Ok(None) };
        let mut view = ReachView {
            arms: match arms {
                Arms::Left => ReachArms::Left,
                Arms::Right => ReachArms::Right,
                Arms::Both => ReachArms::Both,
                Arms::Overlap => ReachArms::Overlap,
            },
            quantity: match self.reach_color {
                Color::Fraction => ReachQuantity::Fraction,
                Color::Manipulability => ReachQuantity::Manipulability,
            },
            is_log: self.reach_log,
            least: self.reach_threshold,
            slices: [Slice { keep: Keep::All, at_m: 0.0 }; 3],
            fades: self.reach_fade,
        };
        for (axis, slice) in &self.reach_slice {
            view.slices[*axis] = *slice;
        }
        let map = |(arm, name): (usize, &str)| -> Result<Option<ReachMap>, Failure> {
            if !view.arms.needs(arm) {
                return Ok(None);
            }
            let library = assets::library();
            let has_arm = library.robot(&scene.robot).is_ok_and(|robot| robot.arm(name).is_some());
            if !has_arm && matches!(arms, Arms::Both) {
                return Ok(None);
            }
            let map = library.reach_map(&scene.robot, name);
            map.map(Some).map_err(|error| Failure::new(error.to_string()))
        };
        let maps = [map((0, "left"))?, map((1, "right"))?];
        let scale = reach_scale(maps.iter().flatten(), &view);
        let (unit, per_si) = view.quantity.unit();
        let (min, max, title) = (per_si * scale.min, per_si * scale.max, view.quantity.title());
        eprintln!("colours: {title}, viridis from {min:.3} {unit} to {max:.3} {unit}");
        Ok(Some(ReachPicture { maps, view }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_an_axis_a_side_and_metres() {
        assert_eq!(slice("z=1.1"), Ok((2, Slice { keep: Keep::Slice, at_m: 1.1 })));
        assert_eq!(slice("x<-0.3"), Ok((0, Slice { keep: Keep::Below, at_m: -0.3 })));
        assert_eq!(slice("y > 0"), Ok((1, Slice { keep: Keep::Above, at_m: 0.0 })));
        for wrong in ["", "z", "w=1", "z=far", "z=nan", "=1"] {
            assert!(slice(wrong).unwrap_err().contains("wanted an axis"), "{wrong:?}");
        }
    }
}
